#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The open conjecture of Yan 2018, sec. 2.4, on random shapes of few voxels: is every point of the medial axis near the core, and
nearer as voxels are split? Largest distances from the axis to the core with voxels split into 1, 2 and 4 to the side, in voxels h
of each. The axis stands as the core at 16 to the side (within 1/64 of it by Thm. 2.4.4): its vertices and centres of polygons. The
core is taken at points 0.05 apart, so that distances are at most 0.03 too large."""
import numpy as np
from figure_2_4 import points_on
from paper import Complex, main, table, write_nrrd
from scipy.spatial import cKDTree

PARTS, TRUTH, SHAPES = (1, 2, 4), 16, 40


def random_shape(random):
    """Random voxels, or a few random boxes, which have larger flat parts and reflex edges."""
    size = random.integers(2, 6, 3)
    if random.random() < 0.5:
        return random.random(size) < random.uniform(0.4, 0.85)
    inside = np.zeros(size, bool)
    for _ in range(random.integers(1, 4)):
        a, b = np.sort(np.stack([random.integers(0, size), random.integers(0, size)]), axis=0)
        inside[a[0]:b[0] + 1, a[1]:b[1] + 1, a[2]:b[2] + 1] = True
    return inside


def core_of(paper, inside, parts):
    volume, out = write_nrrd(paper.file('conjecture.nrrd'), inside), paper.file('conjecture.vtp')
    paper.quench('core', volume, '--threshold', 1, '--surface', 'voxels', '--subdivide', parts, '--detail', 0, '-o', out)
    return Complex(out)


def make(paper):
    random = np.random.default_rng(4)
    found = {parts: [] for parts in PARTS}
    worst = (0, None)
    for _ in range(SHAPES):
        inside = random_shape(random)
        if not inside.any():
            continue
        axis = core_of(paper, inside, TRUTH)
        points = [axis.points]
        if axis.count:
            points.append(np.add.reduceat(axis.points[axis.corners], axis.offsets[:-1]) / np.diff(axis.offsets)[:, None])
        points = np.concatenate(points)
        padded = np.pad(inside, 1)
        for parts in PARTS:
            distance = cKDTree(points_on(core_of(paper, inside, parts), 0.05)).query(points)[0] * parts
            k = distance.argmax()
            # Is the farthest point near a convex corner: a corner of the lattice with one voxel inside?
            corner = np.round((points[k] + 0.5) * parts) / parts
            base = np.round(corner).astype(int)
            voxels = padded[base[0]:base[0] + 2, base[1]:base[1] + 2, base[2]:base[2] + 2].sum()
            found[parts].append((distance[k], voxels == 1 and np.abs(corner - base).max() < 1e-9))
            if distance[k] > worst[0]:
                worst = distance[k], f'{"x".join(map(str, inside.shape))} voxels, split into {parts}, at {np.round(points[k], 3)}'
    rows = []
    for parts, values in found.items():
        distance = np.array([d for d, _ in values])
        rows.append((f'1/{parts}', len(values), f'{distance.max():.3f} h', f'{np.median(distance):.3f} h', f'{distance.max() / parts:.3f}',
                     f'{100 * np.mean([c for _, c in values]):.0f} %'))
    print(f'From the axis to the core; half the diagonal of a voxel is {np.sqrt(3) / 2:.3f} h.\n')
    table(('voxel h', 'shapes', 'largest', 'median of shapes', 'largest, in voxels of the shape', 'farthest at a convex corner'), rows)
    print(f'\nLargest: {worst[0]:.3f} h, {worst[1]}.')


if __name__ == '__main__':
    main(make, __doc__)
