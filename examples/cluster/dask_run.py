#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The medial axis of a large shape on a Dask cluster: a task per share of a round, then the merge.

    dask_run.py WORK CORE.vtp TASKS [--scheduler tcp://HOST:8786] [--threads 1] -- SHAPE [options of quench bricks plan]

Without a scheduler a cluster of this machine's processors is started. WORK must be on a file system that all workers
share, and quench in their PATH. A task that fails or whose worker dies is run again, up to twice; bricks that are there
are not worked on again.
"""
import argparse
import json
import os
import subprocess

from dask.distributed import Client, LocalCluster


def quench(*words):
    """Runs the program; its last sentence is the error where it fails."""
    done = subprocess.run(["quench", *map(str, words)], capture_output=True, text=True)
    if done.returncode < 0:
        raise RuntimeError(f"quench was killed by signal {-done.returncode}")
    if done.returncode > 0:
        raise RuntimeError((done.stderr.strip() or "quench failed").splitlines()[-1])
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work")
    parser.add_argument("core")
    parser.add_argument("tasks", type=int)
    parser.add_argument("--scheduler", help="address of a running cluster")
    parser.add_argument("--threads", type=int, default=1, help="threads of a task")
    parser.add_argument("plan", nargs="+", metavar="SHAPE and options")
    o = parser.parse_args()

    workers = max(1, os.cpu_count() // o.threads)  # of one task at a time each
    cluster = o.scheduler or LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:

        def submit(*words):
            return client.submit(quench, *words, "--threads", o.threads, "--quiet", pure=False, retries=2)

        submit("bricks", "plan", *o.plan, "-o", o.work).result()
        for r in json.loads(quench("bricks", "status", o.work, "--json"))["rounds"]:
            n = min(o.tasks, r["bricks"])
            client.gather([submit("bricks", "run", o.work, "--round", r["round"], "--task", f"{i}/{n}")
                           for i in range(n)])
            print(f"round {r['round']}: {r['bricks']} bricks done", flush=True)
        submit("bricks", "merge", o.work, "-o", o.core).result()
        print(f"{o.core} written")


if __name__ == "__main__":
    main()
