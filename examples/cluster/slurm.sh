#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The medial axis of a large shape on a SLURM cluster: one array of tasks per round, each after the one before, and the
# merge after the last. WORK and SHAPE must be on a file system that all nodes share. To be run on the node that submits
# jobs; it returns when all is submitted.
#   slurm.sh WORK CORE.vtp TASKS SHAPE [options of quench bricks plan]
# Options of sbatch for every job (partition, account, time): SBATCH_* variables of sbatch itself, e.g.
#   SBATCH_PARTITION=long SBATCH_ACCOUNT=plants slurm.sh ...
# Memory of a task and of the merge: TASK_MEMORY (default 4G), MERGE_MEMORY (default 16G); processors of a task: TASK_CPUS
# (default 2).
set -euo pipefail
[ $# -ge 4 ] || { sed -n '3,11p' "$0" | sed 's/^# \{0,1\}//'; exit 2; }
work=$1 core=$2 tasks=$3
shift 3
quench bricks plan "$@" -o "$work"
mkdir -p "$work/log"
# A round with fewer bricks than tasks needs as many tasks as bricks.
quench bricks status "$work" --json |
  python3 -c 'import json, sys
for r in json.load(sys.stdin)["rounds"]: print(r["round"], r["bricks"])' >"$work/log/rounds"
after=()
while read -r round bricks; do
  n=$((bricks < tasks ? bricks : tasks))
  job=$(sbatch --parsable --job-name="quench-$round" --array="0-$((n - 1))" --requeue "${after[@]}" \
    --cpus-per-task="${TASK_CPUS:-2}" --mem="${TASK_MEMORY:-4G}" --output="$work/log/round$round-%a.txt" \
    --open-mode=append --wrap "quench bricks run '$work' --round $round --task \$SLURM_ARRAY_TASK_ID/$n")
  after=(--dependency="afterok:$job")
  echo "round $round: $n tasks for $bricks bricks, job $job"
done <"$work/log/rounds"
job=$(sbatch --parsable --job-name=quench-merge "${after[@]}" --cpus-per-task="${TASK_CPUS:-2}" --requeue \
  --mem="${MERGE_MEMORY:-16G}" --output="$work/log/merge.txt" --open-mode=append \
  --wrap "quench bricks merge '$work' -o '$core'")
echo "merge: job $job"
