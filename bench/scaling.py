#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Time and memory of `quench core` against boundary vertices: several shapes, R = 128, 256 ... 1280 (Yan 2018, Fig. 2.7).

Every point is a whole run of the program, from the mesh to the written file. Prints a Markdown table of the linear fits
(seconds = slope * sites, through the origin, and the largest deviation from it where R >= 256), writes all runs as TSV
and a plot. Needs matplotlib and numpy.

    bench/scaling.py MESH... [--quench PROGRAM] [--runs N] [--threads N] [--most R] [--step R] [-o FOLDER]
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt
import numpy as np

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('meshes', nargs='+', metavar='MESH')
parser.add_argument('--quench', default='build/release/quench')
parser.add_argument('--runs', type=int, default=1, help='of which the median is taken')
parser.add_argument('--threads', type=int, default=1)
parser.add_argument('--most', type=int, default=1280)
parser.add_argument('--step', type=int, default=128)
parser.add_argument('-o', '--output', type=pathlib.Path, default=pathlib.Path('build/bench'))
options = parser.parse_args()


def run(mesh, resolution):
    """Sites, seconds and peak bytes of one run."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder, 'report.json')
        subprocess.run([options.quench, 'core', mesh, '--resolution', str(resolution), '--threads', str(options.threads),
                        '-o', str(pathlib.Path(folder, 'core.vtp')), '--json', str(report), '--quiet'], check=True)
        data = json.loads(report.read_text())
    return data['shape']['sites'], data['seconds']['total'], data['peak_bytes']


def main():
    options.output.mkdir(parents=True, exist_ok=True)
    figure, (time_axes, memory_axes) = plt.subplots(1, 2, figsize=(11, 4.5))
    lines = ['mesh\tresolution\tsites\tseconds\tpeak_bytes']
    print('| mesh | sites at R = %d | s there | µs/site (fit) | largest deviation | bytes/site there |' % options.most)
    print('|---|---|---|---|---|---|')
    for mesh in options.meshes:
        name = pathlib.Path(mesh).stem
        points = []
        for resolution in range(options.step, options.most + 1, options.step):
            runs = [run(mesh, resolution) for _ in range(options.runs)]
            points.append((resolution, runs[0][0], statistics.median(r[1] for r in runs), max(r[2] for r in runs)))
            lines.append('%s\t%d\t%d\t%.3f\t%d' % (name, *points[-1]))
            print(lines[-1], file=sys.stderr)
        resolution, sites, seconds, memory = np.array(points).T
        slope = (sites * seconds).sum() / (sites * sites).sum()
        large = resolution >= 256
        deviation = np.abs(seconds / (slope * sites) - 1)[large].max() if large.any() else float('nan')
        print('| %s | %d | %.1f | %.2f | %.0f %% | %.0f |' % (name, sites[-1], seconds[-1], 1e6 * slope, 100 * deviation,
                                                         memory[-1] / sites[-1]), flush=True)
        line, = time_axes.plot(sites / 1e6, seconds, 'o', label='%s, %.1f µs per site' % (name, 1e6 * slope))
        time_axes.plot(sites / 1e6, slope * sites, '-', color=line.get_color(), linewidth=0.8)
        memory_axes.plot(sites / 1e6, memory / 1e9, 'o-', color=line.get_color(), linewidth=0.8, label=name)
        (options.output / 'scaling.tsv').write_text('\n'.join(lines) + '\n')  # what is done is kept
    for axes, what in ((time_axes, 'seconds'), (memory_axes, 'peak memory, GB')):
        axes.set_xlabel('million boundary vertices')
        axes.set_ylabel(what)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.suptitle('quench core, from the mesh to the written file, %d thread%s, R = %d to %d' %
                    (options.threads, 's' if options.threads > 1 else '', options.step, options.most), fontsize=10)
    figure.tight_layout()
    figure.savefig(options.output / 'scaling.png', dpi=110)


if __name__ == '__main__':
    main()
