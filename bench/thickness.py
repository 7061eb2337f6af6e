#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Local thickness beside a distance transform of scipy with the dilation of its balls, in one run.

usage: thickness.py [VOLUME[:THRESHOLD] ...] [--sizes N]     (PYTHONPATH: the folder python of the build)

Per volume: CPU seconds of quench.local_thickness (core and all), of its balls of vertices alone, and of what programs on
distance transforms do: for each of N radii (25, as PoreSpy has it) the voxels nearer than the radius to a voxel whose distance
is at least that (two distance transforms of scipy.ndimage per radius); and the same with every radius there is, by
painting balls. Then the ratios, and the mean thickness of each. Without a volume: a gyroid and a Menger sponge."""
import argparse
import time

import numpy as np
from scipy import ndimage

import quench


def timed(work):
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def by_sizes(inside, sizes):
    """A diameter per voxel: twice the largest of the radii."""
    distance = ndimage.distance_transform_edt(inside)
    thickness = np.zeros(inside.shape, np.float32)
    for radius in np.unique(np.geomspace(1, distance.max(), sizes)):
        seeds = distance >= radius
        thickness[(ndimage.distance_transform_edt(~seeds) < radius) & inside] = 2 * radius
    return thickness


def by_painting(inside):
    """A diameter per voxel: twice the largest distance of a voxel whose ball holds it; largest balls first."""
    distance = ndimage.distance_transform_edt(inside)
    thickness = np.zeros(inside.shape, np.float32)
    places = np.argwhere(inside)
    radius = distance[inside]
    for i in np.argsort(-radius, kind='stable'):
        r = radius[i]
        low = np.maximum(places[i] - int(r), 0)
        box = tuple(slice(a, c + int(r) + 1) for a, c in zip(low, places[i]))
        part = thickness[box]
        offsets = np.ogrid[tuple(slice(a - c, a - c + n) for a, c, n in zip(low, places[i], part.shape))]
        ball = sum(o * o for o in offsets) < r * r
        part[ball & (part == 0)] = 2 * r
    thickness[~inside] = 0
    return thickness


def gyroid(n=96):
    x, y, z = np.meshgrid(*[np.arange(n) * (6 * np.pi / n)] * 3, indexing='ij')
    return np.abs(np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)) < 0.45


def sponge(level=4):
    side = 3**level
    place = np.arange(side)
    holes = np.zeros((side,) * 3, bool)
    for k in range(level):
        middle = place // 3**k % 3 == 1
        x, y, z = middle[:, None, None], middle[None, :, None], middle[None, None, :]
        holes |= (x.astype(int) + y + z) >= 2
    return ~holes


def shapes(names):
    if not names:
        yield 'gyroid', gyroid()
        yield 'sponge', sponge()
    for name in names:
        file, _, threshold = name.partition(':')
        image = np.asarray(quench.read(file))
        yield name.rsplit('/', 1)[-1], image >= float(threshold) if threshold else image != 0


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('volumes', nargs='*')
parser.add_argument('--sizes', type=int, default=25)
options = parser.parse_args()
print('| shape | voxels inside | Quench, all balls | of vertices | scipy, '
      f'{options.sizes} sizes | scipy and painted balls | ratio sizes | ratio painted | mean thickness of each |')
print('|---|---|---|---|---|---|---|---|---|')
for name, inside in shapes(options.volumes):
    ways = [timed(lambda: quench.local_thickness(inside, correction=0)),
            timed(lambda: quench.local_thickness(inside, correction=0, balls='vertices')),
            timed(lambda: by_sizes(inside, options.sizes)), timed(lambda: by_painting(inside))]
    seconds = [s for s, _ in ways]
    means = ', '.join(f'{t[inside].mean():.3f}' for _, t in ways)
    print(f'| {name} | {inside.sum()} | ' + ' | '.join(f'{s:.2f} s' for s in seconds) +
          f' | {seconds[2] / seconds[0]:.1f} | {seconds[3] / seconds[0]:.1f} | {means} |', flush=True)
