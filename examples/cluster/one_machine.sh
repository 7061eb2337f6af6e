#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The medial axis of a large shape on one machine, some tasks at a time. What is interrupted goes on when it is run
# again.
#   one_machine.sh WORK CORE.vtp JOBS SHAPE [options of quench bricks plan]
set -euo pipefail
work=$1 core=$2 jobs=$3
shift 3
quench bricks plan "$@" -o "$work"
rounds=$(quench bricks status "$work" --json | python3 -c 'import json, sys; print(len(json.load(sys.stdin)["rounds"]))')
for round in $(seq "$rounds"); do
  seq 0 $((jobs - 1)) | xargs -P "$jobs" -I{} quench --threads 1 bricks run "$work" --round "$round" --task "{}/$jobs"
done
quench bricks merge "$work" -o "$core"
