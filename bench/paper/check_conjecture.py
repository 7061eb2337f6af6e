#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The conjecture of Yan 2018, sec. 2.4, that every point of the medial axis is near the core: docs/algorithms/voxel_core.md proves
that it is less than a voxel diagonal away. Here the steps of the proof are checked on random shapes, by exact integers and without
the program, and the largest distances are looked for, with voxels split into 1, 2 and 4 to the side, in voxels h of each.

For distances the axis stands as the core at 16 to the side (within 1/64 of it by Thm. 2.4.4): its vertices and centres of polygons.
The core is taken at points 0.05 of a voxel of the shape apart, so that distances are at most 0.03 k h too large for voxels split
into k."""
import itertools

import numpy as np
from figure_2_4 import points_on
from paper import Complex, main, table, write_nrrd
from scipy.spatial import cKDTree

PARTS, TRUTH = (1, 2, 4), 16
UNITS = np.eye(3, dtype=int)


# ---------------------------------------------------------------------------------------------------------------- the theorem


def cells_of_boundary(inside):
    """Faces of the boundary, and all its cells, as (lowest corner, axes along which it extends)."""
    padded = np.pad(inside, 1).astype(int)
    faces = []
    for axis in range(3):
        for place in np.argwhere(np.diff(padded, axis=axis) != 0):
            base = place - 1
            base[axis] += 1
            faces.append((tuple(base), tuple(a for a in range(3) if a != axis)))
    cells = set(faces)
    for base, (u, v) in faces:
        for i, j in itertools.product((0, 1), repeat=2):
            cells.add((tuple(base + i * UNITS[u] + j * UNITS[v]), ()))
        for i in (0, 1):
            cells.add((tuple(base + i * UNITS[u]), (v,)))
            cells.add((tuple(base + i * UNITS[v]), (u,)))
    return faces, cells


def lattice_box(sites, cells, low, size):
    """Of an open box of voxels inside O: nothing where the core meets it. Else the lattice box Q whose lattice points, rounded to
    from the box, are the nearest sites there. Decided at the halves of voxels, in which every point has one nearest site."""
    points = 2 * low + np.stack(np.meshgrid(*[np.arange(2 * n + 1) for n in size], indexing='ij'), -1)
    square = ((points[..., None, :] - 2 * sites) ** 2).sum(-1)
    nearest = square == square.min(-1, keepdims=True)
    for axis in range(3):
        nearest = np.take(nearest, range(2 * size[axis]), axis) & np.take(nearest, range(1, 2 * size[axis] + 1), axis)
    if not nearest.any(-1).all():
        return None  # a wall of the Voronoi diagram crosses one of the eighths: its edge is no edge of the lattice
    p = sites[nearest.argmax(-1)]
    for axis in range(3):
        step = np.diff(p, axis=axis)
        if np.delete(step, axis, -1).any() or step.min(initial=0) < 0 or step.max(initial=0) > 1:
            return None
        for place in np.argwhere(step[..., axis]):
            if (tuple(p[tuple(place)]), (axis,)) not in cells:
                return None
    corners = list(np.ndindex(2, 2, 2))
    for place in np.ndindex(*(n - 1 for n in p.shape[:3])):
        around = [tuple(p[tuple(np.add(place, c))]) for c in corners]
        if len(set(around)) == 8:
            return None  # all corners of a voxel
        if len(set(around)) == 4 and (around[0], tuple(np.flatnonzero(np.subtract(around[7], around[0])))) not in cells:
            return None  # those of a square across O
    lo, hi = p.min((0, 1, 2)), p.max((0, 1, 2))
    middle = np.stack(np.meshgrid(*[low[k] + (np.arange(2 * size[k]) + 0.5) / 2 for k in range(3)], indexing='ij'), -1)
    assert (p == np.clip(np.rint(middle), lo, hi)).all(), 'nearest sites by axis'
    return lo, hi


def check_theorem(inside, random, found):
    """Of every voxel of O, and of those two, four and eight around a face, edge or corner inside O, that the core does not meet: at
    random points the one nearest point of the boundary is that of Q. So the axis does not meet them."""
    faces, cells = cells_of_boundary(inside)
    sites = np.array(sorted({base for base, free in cells if not free}))
    low = np.array([base for base, _ in faces])
    high = low + [[a in free for a in range(3)] for _, free in faces]
    scale = 2**12
    for size in map(np.array, itertools.product((1, 2), repeat=3)):
        for v in np.ndindex(*np.maximum(inside.shape - size + 1, 0)):
            if not inside[tuple(slice(v[k], v[k] + size[k]) for k in range(3))].all():
                continue
            found['boxes'] += 1
            box = lattice_box(sites, cells, np.array(v), size)
            if box is None:
                continue
            found['missed'] += 1
            y = scale * np.array(v) + random.integers(1, scale * size, (16, 3))
            wanted = np.clip(y, scale * box[0], scale * box[1])
            foot = np.clip(y[:, None], scale * low, scale * high)
            square = ((y[:, None] - foot) ** 2).sum(-1)
            least = square.min(1)
            assert (least == ((y - wanted) ** 2).sum(-1)).all(), 'the distance to the boundary is that to Q'
            for k in range(len(y)):
                assert (foot[k][square[k] == least[k]] == wanted[k]).all(), 'one nearest point'
            found['points'] += len(y)


# ------------------------------------------------------------------------------------------------------------------ distances


def random_shape(random, most, dimension=3):
    """Random voxels, or a few random boxes, which have larger flat parts and reflex edges. Not empty."""
    while True:
        size = random.integers(2, most + 1, dimension)
        if random.random() < 0.5:
            inside = random.random(size) < random.uniform(0.4, 0.85)
        else:
            inside = np.zeros(size, bool)
            for _ in range(random.integers(1, 4)):
                a, b = np.sort(np.stack([random.integers(0, size), random.integers(0, size)]), axis=0)
                inside[tuple(slice(i, j + 1) for i, j in zip(a, b))] = True
        if inside.any():
            return inside


def core_of(paper, inside, parts):
    volume, out = write_nrrd(paper.file('conjecture.nrrd'), inside), paper.file('conjecture.vtp')
    paper.quench('core', volume, '--threshold', 1, '--surface', 'voxels', '--subdivide', parts, '--detail', 0, '-o', out)
    return Complex(out)


def convex_corners(inside, dimension):
    """Corners of voxels [x, y, z], or of pixels [x, y, 0], whose neighbours around the corner are all outside. A voxel's centre is
    at its index."""
    padded = np.pad(inside, 1)
    found = []
    for signs in itertools.product(*[(-1, 1)] * dimension + [(0,)] * (3 - dimension)):
        alone = padded.copy()
        for axis in range(dimension):
            alone &= ~np.roll(padded, -signs[axis], axis)
        found.append(np.argwhere(alone) - 1 + np.array(signs) / 2)
    return np.concatenate(found)


def farthest(paper, inside, found):
    axis = core_of(paper, inside, TRUTH)
    points = [axis.points, axis.points[axis.lines].mean(axis=1)]
    if axis.count:
        points.append(np.add.reduceat(axis.points[axis.corners], axis.offsets[:-1]) / np.diff(axis.offsets)[:, None])
    points = np.concatenate(points)
    convex = convex_corners(inside[:, :, None] if inside.ndim == 2 else inside, inside.ndim)
    away = cKDTree(convex).query(points)[0]
    for parts in PARTS:
        distance = cKDTree(points_on(core_of(paper, inside, parts), 0.05)).query(points)[0] * parts
        free = away * parts > 2  # of convex corners, in voxels of this core
        k = distance.argmax()
        found.setdefault(parts, []).append((distance[k], away[k] * parts < 1, distance[free].max(initial=0), distance.mean(), inside))


# ------------------------------------------------------------------------------------------------------------------------ all


def make(paper):
    many = 10 if paper.options.large else 1
    random = np.random.default_rng(4)
    found = dict(boxes=0, missed=0, points=0)
    for _ in range(200 * many):
        check_theorem(random_shape(random, 7), random, found)
    print(f'Steps of the proof, on {200 * many} random shapes: {found["boxes"]} open boxes of 1, 2, 4 or 8 voxels, {found["missed"]} of them '
          f'not met by the core; at {found["points"]} points in these the only nearest point of the boundary is that of the box Q.\n')
    for name, dimension, shapes, most in (('voxels', 3, 80 * many, 5), ('pixels', 2, 120 * many, 7)):
        found = {}
        for _ in range(shapes):
            farthest(paper, random_shape(random, most, dimension), found)
        rows = []
        for parts, values in found.items():
            all_, corner, free, mean = (np.array([v[i] for v in values]) for i in range(4))
            rows.append((f'1/{parts}', f'{all_.max():.3f} h', f'{np.median(all_):.3f} h', f'{100 * corner.mean():.0f} %', f'{free.max():.3f} h',
                         f'{np.median(mean):.3f} h', f'{all_.max() / parts:.3f}'))
        diagonal = np.sqrt(dimension)
        print(f'From the axis to the core, {shapes} random shapes of {name}; the diagonal is {diagonal:.3f} h, half of it {diagonal / 2:.3f} h.\n')
        table(('h', 'largest', 'median of shapes', 'farthest at a convex corner', 'largest, 2 h and more from convex corners',
               'mean, median of shapes', 'largest, in voxels of the shape'), rows)
        print()
        assert all(v[0] < diagonal + 0.03 * parts for parts, values in found.items() for v in values)


if __name__ == '__main__':
    main(make, __doc__)
