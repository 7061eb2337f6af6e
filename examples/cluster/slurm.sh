#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The medial axis of a large shape on a SLURM cluster: the plan, an array of tasks per round, each after the one before,
# and the merge after the last. Run it where jobs are submitted; it waits for the plan only.
#   slurm.sh WORK CORE.vtp TASKS SHAPE [options of quench bricks plan]
#   slurm.sh WORK CORE.vtp TASKS     what is left of a plan that is there, e.g. after tasks have failed
# Options of sbatch for all jobs are given as its own variables: SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT.
# Processors of a task: TASK_CPUS (2). Memory of a task: TASK_MEMORY (4G; '2G 4G 8G': of rounds 1, 2, and all further
# ones), of the plan and the merge: MERGE_MEMORY (16G).
set -euo pipefail
[ $# -ge 3 ] || { sed -n '3,9p' "$0" | sed 's/^# \{0,1\}//'; exit 2; }
work=$1 core=$2 tasks=$3
shift 3
cpus=${TASK_CPUS:-2} merge_memory=${MERGE_MEMORY:-16G}
read -ra memory <<<"${TASK_MEMORY:-4G}"
mkdir -p "$work/log"

# submit LOG MEMORY 'COMMAND LINE' [options of sbatch]: prints the number of the job. A job whose program is killed goes
# back into the queue, up to three times; what it has done by then stays.
submit() {
  local log=$1 memory=$2 line=$3
  shift 3
  sbatch --parsable --requeue --kill-on-invalid-dep=yes --ntasks=1 --cpus-per-task="$cpus" --mem="$memory" \
    --output="$work/log/$log" --open-mode=append "$@" <<END
#!/usr/bin/env bash
echo "job \$SLURM_JOB_ID on \$SLURMD_NODENAME"
$line --threads $cpus --memory-limit "\${SLURM_MEM_PER_NODE}M"
code=\$?
[ \$code -le 130 ] || [ "\${SLURM_RESTART_COUNT:-0}" -ge 3 ] || scontrol requeue "\$SLURM_JOB_ID"
exit \$code
END
}

if [ $# -gt 0 ]; then
  echo "planning ..."
  submit plan.txt "$merge_memory" "quench bricks plan $(printf '%q ' "$@") -o $(printf %q "$work")" \
    --job-name=quench-plan --wait >/dev/null || { tail -n 1 "$work/log/plan.txt" >&2 2>/dev/null; exit 1; }
fi
rounds=$(quench bricks status "$work" --json | python3 -c 'import json, sys
for r in json.load(sys.stdin)["rounds"]: print(r["round"], r["bricks"])')
after=()
while read -r round bricks; do
  n=$((bricks < tasks ? bricks : tasks))
  job=$(submit "round$round-%a.txt" "${memory[round - 1]:-${memory[-1]}}" \
    "quench bricks run $(printf %q "$work") --round $round --task \$SLURM_ARRAY_TASK_ID/$n" \
    --job-name="quench-$round" --array="0-$((n - 1))" "${after[@]}")
  after=(--dependency="afterok:${job%%;*}")
  echo "round $round: job $job, $n tasks for $bricks bricks"
done <<<"$rounds"
job=$(submit merge.txt "$merge_memory" "quench bricks merge $(printf %q "$work") -o $(printf %q "$core")" \
  --job-name=quench-merge "${after[@]}")
echo "merge: job $job"
