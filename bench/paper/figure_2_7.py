#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.7: time and memory of `quench core` against boundary vertices, five shapes, resolutions in steps of 128 up to 640
(--large: 1280). Beside it, for two shapes, methods that hold the whole volume, up to 384 (--large: 512): Hamilton-Jacobi skeletons and
mass transport after Jalba et al., the two of the figure, as published and written anew in Python (voxel_axes.py), not the programs of
their authors; and the 3D thinning of scikit-image, compiled. bench/scaling.py does the same to 1280, on one thread."""
import json
import sys
from pathlib import Path

import numpy as np
from paper import main, measured, plt, table

SHAPES = {'ellipsoid': None, 'torus': None, 'elk': 'meshes/elk.off', 'fertility': 'meshes/fertility.off',
          'armadillo': 'meshes/armadillo.off'}  # the dissertation: ellipsoid, mug, elk, hand, fertility
THINNING = """
import sys, numpy as np
head, samples = open(sys.argv[1], 'rb').read().split(b'\\n\\n', 1)
import gzip
if b'gzip' in head: samples = gzip.decompress(samples)
sizes = [int(n) for line in head.split(b'\\n') if line.startswith(b'sizes:') for n in line.split()[1:]]
volume = np.frombuffer(samples, np.uint8).reshape(sizes[::-1]) > 0
from skimage.morphology import skeletonize_3d
skeletonize_3d(volume)
"""


VOXELS = str(Path(__file__).with_name('voxel_axes.py'))
PEERS = {'Hamilton-Jacobi': [VOXELS, 'hamilton_jacobi'], 'mass transport': [VOXELS, 'mass_transport'], 'thinning': ['-c', THINNING]}


def make(paper):
    largest, voxels = (1280, 512) if paper.options.large else (640, 384)
    figure, (memory, seconds) = plt.subplots(2, 1, figsize=(7.2, 6.6), sharex=True, layout='constrained')
    rows, beside = [], []
    for name, real in SHAPES.items():
        mesh = paper.real(real) if real else paper.sample(name)
        if mesh is None:
            continue
        ours, peers = [], {name: [] for name in PEERS}
        for resolution in range(128, largest + 1, 128):
            report = paper.file('scaling.json')
            cost = paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--lambda',
                                0.015 if name == 'elk' else 0.025, '-o', paper.file('scaling.vtp'), '--json', report)
            said = json.loads(report.read_text())
            ours.append((said['shape']['sites'], cost.cpu, cost.megabytes, resolution))
            if name in ('ellipsoid', 'elk') and resolution <= voxels:
                volume = paper.file('scaling.nrrd')
                paper.quench('voxelize', mesh, '--resolution', resolution, '-o', volume)
                for peer, command in PEERS.items():
                    code, time, size = measured([sys.executable, *command, str(volume)])
                    if code == 0:
                        peers[peer].append((said['shape']['sites'], time, size, resolution))
        sites, cpu, megabytes, _ = np.array(ours).T
        line, = seconds.plot(sites / 1e6, cpu, 'o-', ms=4, label=name)
        memory.plot(sites / 1e6, megabytes / 1e3, 'o-', ms=4, color=line.get_color(), label=name)
        slope = lambda v: np.polyfit(np.log(sites[1:]), np.log(v[1:]), 1)[0]
        rows.append((name, int(sites[-1]), f'{cpu[-1]:.1f}', f'{1e6 * cpu[-1] / sites[-1]:.1f}', f'{slope(cpu):.2f}',
                     f'{megabytes[-1]:.0f}', f'{1e6 * megabytes[-1] / sites[-1]:.0f}'))
        for (peer, found), style in zip(peers.items(), ('x--', '+:', '1-.')):
            if found:
                s, t, m, at = np.array(found).T
                seconds.plot(s / 1e6, t, style, color=line.get_color(), lw=1, label=f'{peer}, {name}')
                memory.plot(s / 1e6, m / 1e3, style, color=line.get_color(), lw=1, label=f'{peer}, {name}')
                growth = lambda v: f'{np.log(v[-1] / v[1]) / np.log(s[-1] / s[1]):.2f}'
                there = [(c, u) for _, c, u, r in ours if r == at[-1]][0]
                beside.append((name, peer, '; '.join(f'{r:.0f}: {a:.1f} s, {b / 1000:.2f} GB' for r, a, b in zip(at, t, m)), growth(t),
                               growth(m), f'{t[-1] / there[0]:.1f}, {m[-1] / there[1]:.1f}'))
    memory.set_ylabel('peak memory, GB')
    seconds.set_ylabel('processor time, s')
    seconds.set_xlabel('boundary vertices of the voxel shape, millions')
    memory.legend(fontsize=7, ncols=4, loc='lower center', bbox_to_anchor=(0.5, 1))
    for axes in (memory, seconds):
        axes.grid(alpha=0.3)
        axes.set_xscale('log')
        axes.set_yscale('log')
    print(f'Dissertation: linear in boundary vertices, all inputs up to 1280 below 10 GB, most of the time in the Voronoi diagram; '
          f'voxel methods grow faster and end at 640.\nHere at {largest} (CPU time; a growth of 1.00 is linear, from 256 on):\n')
    table(('shape', 'boundary vertices', 's', 'µs each', 'growth of time', 'MB', 'bytes each'), rows)
    print('\nMethods that hold the volume; the first two in Python, where the growth says more than the seconds. Growth with the boundary '
          'vertices,\nfrom 256 on: linear is 1.00, the volume 1.50.\n')
    table(('shape', 'method', 'at', 'growth of time', 'of memory', 'time and memory at the last, times ours'), beside)
    paper.save(figure, '2_7')


if __name__ == '__main__':
    main(make, __doc__)
