#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How branched each cell of a label image is: a table, cells.csv (a row per branch) and cells.png.

usage: cells.py [LABELS] [-o FOLDER]

LABELS is an image of two dimensions whose pixels have the number of their cell, 0 outside. Without it, six cells with a
body and arms are drawn. Needs numpy and matplotlib."""
import argparse
import pathlib

import matplotlib
import numpy as np
import quench

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('image', nargs='?')
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)


def drawn_cells():
    """Labels 1 to 6: a round body, and arms that bend and become thinner, of more and more number."""
    random = np.random.default_rng(4)
    row, column = np.indices((400, 600))
    image = np.zeros(row.shape, np.uint8)
    for label in range(1, 7):
        middle = np.array([100 + 200 * ((label - 1) // 3), 100 + 200 * ((label - 1) % 3)])
        disks = [(middle, 18)]
        for arm in range(label + 1):
            place, angle = middle + 0.0, 2 * np.pi * (arm + random.uniform(-0.2, 0.2)) / (label + 1)
            for radius in np.linspace(8, 3.5, 75):
                angle += random.normal(0, 0.06)
                place = place + (np.sin(angle), np.cos(angle))
                disks.append((place, radius))
        for (i, j), radius in disks:
            image[(row - i)**2 + (column - j)**2 <= radius**2] = label
    return image


labels = np.asarray(quench.read(options.image)) if options.image else drawn_cells()
cells = quench.skeletonize(labels)

print('cell  pixels  holes  tips  branches  length  thinnest  thickest')
lines = []
for cell, skeleton in cells.items():
    graph = skeleton.graph()
    branch, tips = graph.branches, (graph.nodes['kind'] == 'end').sum()
    print(f'{cell:4} {(labels == cell).sum():7} {skeleton.topology.betti[1]:6} {tips:5} {len(branch["length"]):9} '
          f'{branch["length"].sum():7.1f} {2 * min(branch["min_radius"]):9.1f} {2 * max(branch["max_radius"]):9.1f}')
    lines += [(cell, *row) for row in zip(branch['length'], branch['mean_radius'], branch['from_kind'], branch['to_kind'])]
with open(options.output / 'cells.csv', 'w', encoding='utf-8') as file:
    print('cell,length,mean_radius,from,to', file=file)
    for cell, length, radius, start, end in lines:
        print(f'{cell},{length:.6g},{radius:.6g},{start},{end}', file=file)

axes = pyplot.figure(figsize=(9, 6)).add_subplot()
axes.imshow(np.where(labels == 0, np.nan, labels % 10), cmap='Pastel1', interpolation='nearest')
widest = max(skeleton.radius.max() for skeleton in cells.values())
for skeleton in cells.values():
    skeleton.plot(axes, colorbar=False)
    axes.collections[-1].set_clim(0, widest)
axes.figure.colorbar(axes.collections[-1], ax=axes, label='radius', shrink=0.6)
axes.set_axis_off()
axes.figure.savefig(options.output / 'cells.png', dpi=100, bbox_inches='tight')
