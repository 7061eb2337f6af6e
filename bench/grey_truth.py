#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Radii of grey-value balls, tubes and tori against the truth.

usage: grey_truth.py [--quench PROGRAM] [--radii 3,4,6,10] [--widths 1,2,3] [--noise 0,0.05] [--seeds 1,2,3]
                     [--surfaces voxels,grey] [--kinds ball,tube,torus] [--work DIR] [--skeleton]

The volumes are f(d) plus noise, float32 .npy files with voxels of side 1: d is the signed distance to the surface of a
ball, a tube (slanted, through the whole image) or a torus (slanted, ring of four radii), f runs from 0 outside to 1
inside like the error function, as blurring does, with a slope of 1 / width per voxel at the surface; noise is normal,
independent per voxel, its standard deviation a fraction of the step. The threshold is 1/2, so the truth is the surface
d = 0. (Blurring the image of a curved shape itself would move that surface: inward by half of the variance times the
sum of its curvatures.)

Of `quench core SHAPE --threshold 0.5 --largest-component --fill-cavities`, the vertices within half a radius of the
true axis count (where a tube leaves the image, those at least two radii from there). Columns: their number; mean and
mean size of the error of their radius, against their distance to the true surface, in voxels; their mean distance to
the true axis. --skeleton: the points of skeleton.swc of `quench run` instead, and the errors are those against the true
radius.

Needs Debian's python3-numpy."""
import argparse
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

erf = np.vectorize(math.erf, otypes=[float])


def turned(direction):
    """A rotation whose last axis is the direction."""
    w = np.array(direction) / np.linalg.norm(direction)
    u = np.cross(w, [1, 0, 0])
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(w, u), w])


class Shape:
    """A solid of constant radius around an axis; places in units of voxels, voxel centres at integers."""

    def __init__(self, kind, radius, seed):
        random = np.random.default_rng(seed)
        self.kind, self.radius = kind, radius
        margin = 6
        side = math.ceil(2 * radius + 2 * margin)
        ring = math.ceil(10 * radius + 2 * margin)
        self.sides = {'ball': (side,) * 3, 'tube': (side + 8, side + 8, 40), 'torus': (ring,) * 3}[kind]
        self.middle = (np.array(self.sides) - 1) / 2 + random.uniform(-0.5, 0.5, 3)
        self.turn = turned([0.2, 0.1, 1] if kind == 'tube' else [0.3, 0.5, 1])

    def to_axis(self, points):
        local = (points - self.middle) @ self.turn.T
        if self.kind == 'ball':
            return np.linalg.norm(local, axis=-1)
        across = np.hypot(local[..., 0], local[..., 1])
        return across if self.kind == 'tube' else np.hypot(across - 4 * self.radius, local[..., 2])

    def inner(self, points):
        """Which places are far from where the axis leaves the image."""
        return (self.kind != 'tube') | (np.abs(points[:, 2] - (self.sides[2] - 1) / 2) < self.sides[2] / 2 - 2 * self.radius)

    def image(self, width, noise, seed):
        grid = np.stack(np.meshgrid(*map(np.arange, self.sides), indexing='ij'), axis=-1)
        inside = self.radius - self.to_axis(grid.astype(float))
        values = 0.5 + 0.5 * erf(inside * math.sqrt(math.pi) / width)
        values += noise * np.random.default_rng(seed + 1000).standard_normal(self.sides)
        return np.asfortranarray(values.astype(np.float32))


def vertices(options, shape, surface, work):
    """x, y, z, radius of the vertices of the core, or of the points of the skeleton's curves."""
    out = work / ('run' if options.skeleton else 'core.csv')
    subprocess.run([options.quench, 'run' if options.skeleton else 'core', str(shape), '--threshold', '0.5',
                    '--largest-component', '--fill-cavities', '--surface', surface, '-o', str(out), '--overwrite'],
                   check=True, capture_output=True)
    if options.skeleton:
        return np.loadtxt(out / 'skeleton.swc')[:, 2:6]
    with open(out, newline='') as file:
        return np.array([[float(r[k]) for k in ('x', 'y', 'z', 'radius')] for r in csv.DictReader(file)])


def row(options, kind, radius, width, noise, surface, work):
    errors, offsets = [], []
    for seed in options.seeds:
        shape = Shape(kind, radius, seed)
        file = work / f'{kind}_{radius:g}_{width:g}_{noise:g}_{seed}.npy'
        if not file.exists():
            np.save(file, shape.image(width, noise, seed))
        found = vertices(options, file, surface, work)
        away = shape.to_axis(found[:, :3])
        near = (away < radius / 2) & shape.inner(found[:, :3])
        errors.append(found[near, 3] - radius if options.skeleton else found[near, 3] - (radius - away[near]))
        offsets.append(away[near])
    errors, offsets = np.concatenate(errors), np.concatenate(offsets)
    print(f'| {kind} | {radius:g} | {width:g} | {noise:g} | {surface} | {len(errors)} | {errors.mean():+.3f} | '
          f'{np.abs(errors).mean():.3f} | {offsets.mean():.3f} |', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    numbers = lambda text: [float(n) for n in text.split(',')]
    parser.add_argument('--quench', default='build/release/cli/quench')
    parser.add_argument('--kinds', type=lambda text: text.split(','), default=['ball', 'tube', 'torus'])
    parser.add_argument('--radii', type=numbers, default=[3, 4, 6, 10])
    parser.add_argument('--widths', type=numbers, default=[1, 2, 3])
    parser.add_argument('--noise', type=numbers, default=[0, 0.05])
    parser.add_argument('--seeds', type=lambda text: [int(n) for n in text.split(',')], default=[1, 2, 3])
    parser.add_argument('--surfaces', type=lambda text: text.split(','), default=['voxels', 'grey'])
    parser.add_argument('--skeleton', action='store_true')
    parser.add_argument('--work')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(options.work or folder)
        work.mkdir(parents=True, exist_ok=True)
        print('| shape | radius | width | noise | surface | vertices | radius error | its size | off the axis |')
        print('|---|---|---|---|---|---|---|---|---|')
        for kind in options.kinds:
            for radius in options.radii:
                for width in options.widths:
                    for noise in options.noise:
                        for surface in options.surfaces:
                            row(options, kind, radius, width, noise, surface, work)


if __name__ == '__main__':
    sys.exit(main())
