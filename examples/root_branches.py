#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""From the CT of a root to a table of its branches: branches.csv and root.png.

usage: root_branches.py [VOLUME] [--threshold T] [-o FOLDER]

Without VOLUME a built-in root is taken, whose true branches are known. Needs numpy and matplotlib."""
import argparse
import pathlib

import numpy as np
import quench

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('volume', nargs='?')
parser.add_argument('--threshold', type=float)
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)

sample = quench.sample('root', branches=10)
volume = quench.read(options.volume) if options.volume else quench.voxelize(sample, resolution=256)
axis = quench.medial_axis(volume, threshold=options.threshold, largest_component=True, fill_cavities=True)
root = axis.skeleton(theta2='inf', theta1='4vox')  # curves only; a branch has to stand out by four voxels
table = root.branches()
root.graph().save(options.output / 'branches.csv')
root.save(options.output / 'root.png')

tips = (table['from_kind'] == 'end').sum() + (table['to_kind'] == 'end').sum()
print(f'{len(table["length"])} branches between {tips} tips, {table["length"].sum():.4g} long in all')
edges = np.quantile(table['mean_radius'], [0, 0.25, 0.5, 0.75, 1])
for low, high in zip(edges, edges[1:]):
    share = table['length'][(table['mean_radius'] >= low) & (table['mean_radius'] <= high)].sum() / table['length'].sum()
    print(f'  diameter {2 * low:.3g} to {2 * high:.3g}: {100 * share:.0f} % of the length')
if not options.volume:
    print(f'true length of its {len(sample.branches)} branches: {sum(b["length"] for b in sample.branches):.4g}')
