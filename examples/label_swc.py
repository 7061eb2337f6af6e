#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""From a label volume to an SWC file per label, and one picture of all: LABEL.swc, labels.png.

usage: label_swc.py [LABELS] [--labels K ...] [-o FOLDER]

Without LABELS, four built-in shapes are put into one image. Needs numpy and matplotlib."""
import argparse
import pathlib

import matplotlib
import numpy as np
import quench

matplotlib.use('Agg')
from matplotlib import pyplot  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('image', nargs='?')
parser.add_argument('--labels', type=int, nargs='+')
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)


def four_shapes():
    image = np.zeros((150, 150, 80), np.uint16)
    for label, name, x, y in ((1, 'torus', 5, 5), (2, 'ellipsoid', 78, 5), (5, 'box', 5, 78),
                              (9, 'plate-with-holes', 78, 78)):
        part = quench.voxelize(quench.sample(name), resolution=66).array
        window = image[x:x + part.shape[0], y:y + part.shape[1], 4:4 + part.shape[2]]
        window[part > 0] = label
    return image


image = quench.read(options.image) if options.image else four_shapes()
found = quench.skeletonize(image, labels=options.labels or 'all', theta1='3vox')
axes = pyplot.figure(figsize=(7, 6)).add_subplot(projection='3d')
for number, (label, skeleton) in enumerate(found.items()):
    report = skeleton.graph().save(options.output / f'{label}.swc')
    print(f'{label}.swc: {report["trees"]} trees, {report["samples"]} samples, {report["cuts"]} loops cut; '
          f'components, tunnels, cavities of the label: {skeleton.topology.betti}')
    for path in skeleton.graph().paths:
        axes.plot(*path.T, color=f'C{number % 10}', linewidth=1.2)
places = np.concatenate([skeleton.vertices for skeleton in found.values()])
for limit, low, high in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), places.min(0), places.max(0)):
    limit(low, high)
axes.set_box_aspect(np.maximum(np.ptp(places, axis=0), 0.1 * np.ptp(places, axis=0).max()))
axes.legend([pyplot.Line2D([], [], color=f'C{n % 10}') for n in range(len(found))], [f'label {k}' for k in found],
            loc='center left', bbox_to_anchor=(-0.25, 0.5))
axes.figure.savefig(options.output / 'labels.png', dpi=100, bbox_inches='tight')
