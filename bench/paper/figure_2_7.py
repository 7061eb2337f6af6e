#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.7: time and memory of `quench core` against boundary vertices, five shapes, resolutions in steps of 128 up to 640
(--large: 1280). Beside it scikit-image's 3D thinning of the same voxels, a method that holds the whole volume, as a stand-in
for the two voxel-based methods of the figure, which no package has. bench/scaling.py does the same to 1280, on one thread."""
import json
import sys

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


def thinning(volume):
    code, cpu, megabytes = measured([sys.executable, '-c', THINNING, str(volume)])
    return None if code else (cpu, megabytes)


def make(paper):
    largest = 1280 if paper.options.large else 640
    figure, (memory, seconds) = plt.subplots(2, 1, figsize=(7.2, 6.6), sharex=True, layout='constrained')
    rows = []
    for name, real in SHAPES.items():
        mesh = paper.real(real) if real else paper.sample(name)
        if mesh is None:
            continue
        measured, peer = [], []
        for resolution in range(128, largest + 1, 128):
            report = paper.file('scaling.json')
            cost = paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--lambda',
                                0.015 if name == 'elk' else 0.025, '-o', paper.file('scaling.vtp'), '--json', report)
            said = json.loads(report.read_text())
            measured.append((said['shape']['sites'], cost.cpu, cost.megabytes, resolution))
            if name in ('ellipsoid', 'elk') and resolution <= 384:
                volume = paper.file('scaling.nrrd')
                paper.quench('voxelize', mesh, '--resolution', resolution, '-o', volume)
                if found := thinning(volume):
                    peer.append((said['shape']['sites'], *found))
        sites, cpu, megabytes, _ = np.array(measured).T
        line, = seconds.plot(sites / 1e6, cpu, 'o-', ms=4, label=name)
        memory.plot(sites / 1e6, megabytes / 1e3, 'o-', ms=4, color=line.get_color(), label=name)
        if peer:
            s, t, m = np.array(peer).T
            seconds.plot(s / 1e6, t, 'x--', color=line.get_color(), label=f'thinning, {name}')
            memory.plot(s / 1e6, m / 1e3, 'x--', color=line.get_color(), label=f'thinning, {name}')
        slope = lambda v: np.polyfit(np.log(sites[1:]), np.log(v[1:]), 1)[0]
        rows.append((name, int(sites[-1]), f'{cpu[-1]:.1f}', f'{1e6 * cpu[-1] / sites[-1]:.1f}', f'{slope(cpu):.2f}',
                     f'{megabytes[-1]:.0f}', f'{1e6 * megabytes[-1] / sites[-1]:.0f}',
                     ', '.join(f'{n}: {t:.1f} s, {m:.0f} MB' for n, (_, t, m) in zip((128, 256, 384), peer))))
    memory.set_ylabel('peak memory, GB')
    seconds.set_ylabel('processor time, s')
    seconds.set_xlabel('boundary vertices of the voxel shape, millions')
    memory.legend(fontsize=8)
    for axes in (memory, seconds):
        axes.grid(alpha=0.3)
        axes.set_ylim(0)
    print(f'Dissertation: linear in boundary vertices, all inputs up to 1280 below 10 GB, most of the time in the Voronoi diagram; '
          f'voxel methods grow faster and end at 640.\nHere at {largest} (CPU time; a growth of 1.00 is linear, from 256 on):\n')
    table(('shape', 'boundary vertices', 's', 'µs each', 'growth of time', 'MB', 'bytes each', 'thinning of the volume at'), rows)
    paper.save(figure, '2_7')


if __name__ == '__main__':
    main(make, __doc__)
