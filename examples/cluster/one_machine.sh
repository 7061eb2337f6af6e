#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The medial axis of a large shape on one machine, JOBS tasks of one thread at a time. After an interruption the same
# command goes on where it was.
#   one_machine.sh WORK CORE.vtp JOBS SHAPE [options of quench bricks plan]
set -euo pipefail
[ $# -ge 4 ] || { sed -n '3,5p' "$0" | sed 's/^# \{0,1\}//'; exit 2; }
work=$1 core=$2 jobs=$3
shift 3
quench bricks plan "$@" -o "$work"
rounds=$(quench bricks status "$work" --json | python3 -c 'import json, sys; print(len(json.load(sys.stdin)["rounds"]))')
tasks=$((8 * jobs)) # more than jobs, so that none waits long for another at the end of a round
for round in $(seq "$rounds"); do
  seq 0 $((tasks - 1)) |
    xargs -P "$jobs" -I{} quench bricks run "$work" --round "$round" --task "{}/$tasks" --threads 1 --quiet
  echo "round $round of $rounds done"
done
quench bricks merge "$work" -o "$core" --threads "$jobs"
