#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What bricks cost and how they would scale: every task of a shape in bricks is run here, one after the other, and
measured; beside it the core of the shape in one piece, in the same run. From the tasks the time on more workers is
simulated: a round begins when the one before it has ended, its tasks go in order to the worker that is free first, and
the merge is one task.

    bench/brick_scaling.py SHAPE RESOLUTION... [--size 512] [--tasks 1000] [--quench build/release/quench]
                           [--work DIR] [--no-whole 8192] [--json OUT.json] [--plot OUT.png]
                           [--core "--lambda 0.02"]

Nothing is said of networks and file systems: the bytes that tasks read and write stand in the table.
"""
import argparse
import filecmp
import heapq
import json
import os
import shutil
import subprocess
import sys
import tempfile

WORKERS = (1, 10, 100, 1000)


def run(command):
    """Processor seconds and peak memory of a command; ends the bench where it fails."""
    pid = os.posix_spawnp(command[0], command, os.environ,
                          file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)])
    _, status, used = os.wait4(pid, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(command)}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss * 1024


def makespan(seconds, workers):
    """Tasks in order, each to the worker that is free first."""
    free = [0.0] * min(workers, max(1, len(seconds)))
    for s in seconds:
        heapq.heapreplace(free, free[0] + s)
    return max(free)


def simulated(rounds, merge, workers):
    return sum(makespan(tasks, workers) for tasks in rounds) + merge


def measure(quench, shape, resolution, size, most_tasks, work, whole, core_options):
    def task(*words):
        return run([quench, *map(str, words), "--quiet", "--threads", "1"])

    core = os.path.join(work, "core.vtp")
    bricks = os.path.join(work, "bricks")
    shutil.rmtree(bricks, ignore_errors=True)
    row = {"resolution": resolution, "size": size}
    row["plan_seconds"], row["plan_bytes"] = task("bricks", "plan", shape, "--resolution", resolution, "--size", size,
                                                  *core_options, "-o", bricks)

    def status():
        return json.loads(subprocess.run([quench, "bricks", "status", bricks, "--json"], stdout=subprocess.PIPE,
                                         check=True).stdout)

    row["rounds"] = []
    for number, bricks_of_round in ((r["round"], r["bricks"]) for r in status()["rounds"]):
        n = min(bricks_of_round, most_tasks)
        tasks = [task("bricks", "run", bricks, "--round", number, "--task", f"{i}/{n}") for i in range(n)]
        row["rounds"].append({"bricks": bricks_of_round, "seconds": [t[0] for t in tasks],
                              "peak_bytes": max(t[1] for t in tasks)})
    for measured, told in zip(row["rounds"], status()["rounds"]):
        measured |= {k: told[k] for k in ("bytes_read", "bytes_written") if k in told}
    row["merge_seconds"], row["merge_bytes"] = task("bricks", "merge", bricks, "-o", core, "--overwrite")
    if whole:
        one = os.path.join(work, "one.vtp")
        row["whole_seconds"], row["whole_bytes"] = task("core", shape, "--resolution", resolution, *core_options,
                                                        "-o", one, "--overwrite")
        row["same_bytes"] = filecmp.cmp(core, one, shallow=False)
    shutil.rmtree(bricks)
    return row


def tell(row):
    tasks = [s for r in row["rounds"] for s in r["seconds"]]
    total = row["plan_seconds"] + sum(tasks) + row["merge_seconds"]
    print(f"\nresolution {row['resolution']}, bricks of {row['size']}: {total:.1f} s of processor time in all"
          + (f", in one piece {row['whole_seconds']:.1f} s: ratio {total / row['whole_seconds']:.2f}; "
             f"{'the same bytes' if row['same_bytes'] else 'OTHER BYTES'}" if "whole_seconds" in row else ""))
    gib = 2.0**30
    print(f"  plan      {row['plan_seconds']:8.1f} s  {row['plan_bytes'] / gib:6.2f} GiB")
    for number, r in enumerate(row["rounds"], 1):
        s = r["seconds"]
        print(f"  round {number}   {sum(s):8.1f} s  {r['peak_bytes'] / gib:6.2f} GiB  {r['bricks']:5} bricks, {len(s):5} tasks, longest "
              f"{max(s):.1f} s = {max(s) * len(s) / max(sum(s), 1e-9):.1f} of the mean; read "
              f"{r.get('bytes_read', 0) / gib:.2f} GiB, written {r.get('bytes_written', 0) / gib:.2f} GiB")
    print(f"  merge     {row['merge_seconds']:8.1f} s  {row['merge_bytes'] / gib:6.2f} GiB")
    if "whole_bytes" in row:
        print(f"  one piece {row['whole_seconds']:8.1f} s  {row['whole_bytes'] / gib:6.2f} GiB")
    rounds = [r["seconds"] for r in row["rounds"]]
    for n in WORKERS:
        span, with_merge = simulated(rounds, 0, n), simulated(rounds, row["merge_seconds"], n)
        print(f"  simulated on {n:4} workers: rounds {span:8.1f} s (efficiency {sum(tasks) / n / span:.2f}), with the "
              f"merge {with_merge:8.1f} s ({(sum(tasks) + row['merge_seconds']) / n / with_merge:.2f})")


def plot(rows, file):
    import matplotlib
    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(8, 4.5))
    workers = [round(10 ** (i / 8)) for i in range(25)]
    for row in rows:
        rounds = [r["seconds"] for r in row["rounds"]]
        whole = simulated(rounds, row["merge_seconds"], 1)
        name = f"resolution {row['resolution']}, bricks of {row['size']}"
        colour = axes.loglog(workers, [simulated(rounds, row["merge_seconds"], n) for n in workers], label=name)[0].get_color()
        axes.loglog(workers, [simulated(rounds, 0, n) for n in workers], "--", color=colour)
        axes.loglog(workers, [whole / n for n in workers], ":", color=colour, linewidth=0.8)
    for style, name in (("-", "rounds and merge"), ("--", "rounds alone"), (":", "perfect division")):
        axes.loglog([], [], style, color="grey", label=name)
    axes.set_xlabel("workers (simulated from measured tasks)")
    axes.set_ylabel("seconds")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.tight_layout()
    figure.savefig(file, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shape")
    parser.add_argument("resolution", type=int, nargs="+")
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--tasks", type=int, default=1000,
                        help="tasks of a round at most; each begins with the plan and the surface")
    parser.add_argument("--quench", default="build/release/quench")
    parser.add_argument("--work", help="folder for what is written meanwhile; default: a temporary one")
    parser.add_argument("--no-whole", type=int, default=1 << 30, metavar="R",
                        help="from this resolution on nothing is computed in one piece")
    parser.add_argument("--core", default="", metavar="OPTIONS", help="of quench core, as \"--lambda 0.02\"")
    parser.add_argument("--json")
    parser.add_argument("--plot")
    o = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory(dir=o.work) as work:
        for resolution in o.resolution:
            rows.append(measure(o.quench, o.shape, resolution, o.size, o.tasks, work, resolution < o.no_whole,
                                o.core.split()))
            tell(rows[-1])
            sys.stdout.flush()
            if o.json:
                with open(o.json, "w") as file:
                    json.dump(rows, file, indent=1)
    if o.plot:
        plot(rows, o.plot)


if __name__ == "__main__":
    main()
