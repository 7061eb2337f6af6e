#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The medial axis of a large shape on a Dask cluster: a task per share of a round, then the merge.

    dask_run.py WORK CORE.vtp TASKS [--scheduler tcp://HOST:8786] -- SHAPE [options of quench bricks plan]

Without a scheduler a cluster of this machine's processors is started. WORK must be on a file system that all workers
share. A task whose worker dies is run again by Dask; bricks that are there are not worked on again.
"""
import argparse
import json
import subprocess

from dask.distributed import Client, LocalCluster


def quench(*words):
    """Runs the program; its last sentence is the error where it fails."""
    done = subprocess.run(["quench", *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError((done.stderr.strip() or "quench failed").splitlines()[-1])
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work")
    parser.add_argument("core")
    parser.add_argument("tasks", type=int)
    parser.add_argument("--scheduler")
    parser.add_argument("plan", nargs="+", metavar="SHAPE and options")
    arguments = parser.parse_args()

    quench("bricks", "plan", *arguments.plan, "-o", arguments.work)
    rounds = json.loads(quench("bricks", "status", arguments.work, "--json"))["rounds"]
    cluster = arguments.scheduler or LocalCluster(threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        for number, bricks in ((r["round"], r["bricks"]) for r in rounds):
            n = min(arguments.tasks, bricks)
            shares = [client.submit(quench, "--threads", 1, "bricks", "run", arguments.work, "--round", number,
                                    "--task", f"{i}/{n}", pure=False, retries=2) for i in range(n)]
            client.gather(shares)
            print(f"round {number}: {bricks} bricks done")
        print(client.submit(quench, "bricks", "merge", arguments.work, "-o", arguments.core, pure=False).result(), end="")


if __name__ == "__main__":
    main()
