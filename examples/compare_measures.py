#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Four measures of what matters in a medial axis, on a board with a thin fin and a low bump: measures.csv and measures.png.

usage: compare_measures.py [MESH] [--resolution N] [--keep SHARE] [-o FOLDER]

Radius, lambda, object angle and erosion thickness are thresholded so that each keeps the same share of the area; what is kept
is drawn and its connected pieces are counted. Needs numpy and matplotlib. (notes/significance.md compares further.)"""
import argparse
import pathlib

import matplotlib
import numpy as np
import quench

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('mesh', nargs='?')
parser.add_argument('--resolution', type=int, default=80)
parser.add_argument('--keep', type=float, default=0.2)
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)

mesh = options.mesh or quench.sample('fin-on-board')
axis = quench.medial_axis(mesh, resolution=options.resolution, lambda_='0.5vox')
faces, radius = axis.faces, axis.radius[axis.faces].min(axis=1)
measures = {'radius': radius, 'lambda': axis.face_lambda,
            'object angle': 2 * np.degrees(np.arcsin(np.clip(axis.face_lambda / radius, 0, 1))),
            'erosion thickness': axis.erosion_thickness()[faces].min(axis=1)}
corners = axis.vertices[faces]
normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
area = np.linalg.norm(normal, axis=1) / 2
shade = 0.5 + 0.5 * np.abs(normal @ [0.3, -0.5, 0.81]) / np.maximum(2 * area, 1e-300)


def pieces(kept):
    """Number of connected pieces: the smallest vertex spreads over each until nothing changes."""
    mine = np.arange(len(axis.vertices))
    while True:
        least = mine[faces[kept]].min(axis=1)
        new = mine.copy()
        np.minimum.at(new, faces[kept], least[:, None])
        new = new[new]
        if np.array_equal(new, mine):
            return len(np.unique(mine[faces[kept]]))
        mine = new


figure = pyplot.figure(figsize=(10, 7), layout='constrained')
rows = []
for number, (name, value) in enumerate(measures.items()):
    order = np.argsort(-value, kind='stable')
    last = np.searchsorted(np.cumsum(area[order]), options.keep * area.sum())
    kept = value >= value[order[min(last, len(order) - 1)]]
    rows.append((name, value[kept].min(), area[kept].sum() / area.sum(), pieces(kept)))
    print(f'{name:18} >= {rows[-1][1]:8.4g} keeps {100 * rows[-1][2]:5.1f} % of the area in {rows[-1][3]} pieces')
    axes = figure.add_subplot(2, 2, number + 1, projection='3d')
    paint = np.outer(shade[kept], [0.25, 0.5, 0.85])
    axes.add_collection3d(Poly3DCollection(corners[kept], facecolors=paint, edgecolors=paint, linewidths=0.1))
    low, high = axis.vertices.min(0), axis.vertices.max(0)
    for limit, a, b in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), low, high):
        limit(a, b)
    axes.set_box_aspect(np.maximum(high - low, 0.2 * (high - low).max()), zoom=1.5)
    axes.set_title(f'{name}: {rows[-1][3]} piece{"s" * (rows[-1][3] > 1)}')
    axes.set_axis_off()
    axes.view_init(28, -60)
figure.savefig(options.output / 'measures.png', dpi=70, bbox_inches='tight')
with open(options.output / 'measures.csv', 'w') as file:
    file.write('measure,threshold,share,pieces\n')
    file.writelines(f'{name},{threshold:.6g},{share:.6g},{count}\n' for name, threshold, share, count in rows)
