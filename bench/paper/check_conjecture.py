#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The conjecture of Yan 2018, sec. 2.4, that every point of the medial axis is near the core: docs/algorithms/voxel_core.md proves
that it is at most half a voxel diagonal away. Here the steps of the proof are checked on random shapes, by exact integers and without
the program, and the largest distances are looked for, with voxels split into 1, 2 and 4 to the side, in voxels h of each.

For distances the axis stands as the core at 16 to the side (within 1/64 of it by Thm. 2.4.4): its vertices and centres of polygons.
The core is taken at points 0.05 of a voxel of the shape apart, so that distances are at most 0.03 k h too large for voxels split
into k."""
import itertools
from fractions import Fraction

import numpy as np
from figure_2_4 import points_on
from paper import Complex, boundary_faces, main, table, write_nrrd
from scipy.spatial import cKDTree

PARTS, TRUTH = (1, 2, 4), 16
UNITS = np.eye(3, dtype=int)


# ---------------------------------------------------------------------------------------------------------------- the theorem


def cells_of_boundary(inside):
    """Faces of the boundary, and all its cells, as (lowest corner, axes along which it extends)."""
    faces = [(tuple(base), tuple(sorted((u, v)))) for base, u, v in boundary_faces(inside)]
    cells = set(faces)
    for base, (u, v) in faces:
        for i, j in itertools.product((0, 1), repeat=2):
            cells.add((tuple(base + i * UNITS[u] + j * UNITS[v]), ()))
        for i in (0, 1):
            cells.add((tuple(base + i * UNITS[u]), (v,)))
            cells.add((tuple(base + i * UNITS[v]), (u,)))
    return faces, cells


def nearest_sites(y, unit, sites, weight):
    """All of them, of the point y / unit; lengths along the axes count sqrt(weight) times."""
    square = ((y - unit * sites) ** 2 @ weight)
    return sites[square == square.min()]


def cell_of(corners):
    """The cell of the lattice with these corners, or nothing."""
    low, high = corners.min(0), corners.max(0)
    free = tuple(np.flatnonzero(high > low))
    return (tuple(low), free) if (high - low).max() <= 1 and len(corners) == 2 ** len(free) else None


def core_point(x, b, p, F, sites, weight, unit):
    """The point of the core that the proof finds for x in an eighth [0, 1/2]^3 that the core does not meet, where p is the nearest
    site and b, not q, a nearest point of the boundary to x. x and b are given times `unit`."""
    G = [i for i in range(3) if b[i] % unit]
    i = max((i for i in G if i not in F and p[i] <= 0), key=lambda i: weight[i] * x[i] ** 2)
    y = [Fraction(int(v), unit) for v in x]
    for k in G:
        y[k] = Fraction(1, 2) if p[k] <= 0 else Fraction(0)
    # Along axis i, up to where another site is as near as p.
    reached = []
    for s in sites[sites[:, i] > p[i]]:
        rest = sum(int(weight[k]) * ((y[k] - int(s[k])) ** 2 - (y[k] - int(p[k])) ** 2) for k in range(3) if k != i)
        reached.append((rest / int(weight[i]) + int(s[i]) ** 2 - int(p[i]) ** 2) / (2 * int(s[i] - p[i])))
    y[i] = min(reached)
    assert Fraction(1, 2) < y[i] <= Fraction(3, 4)
    return y


def check_theorem(inside, weight, random, found):
    """Of eighths of voxels that the core does not meet: at random points x, q is the only nearest point of the boundary; or else, but
    not for cubes, the point that the proof constructs is one of the core within half the diagonal of a face. All exact."""
    faces, cells = cells_of_boundary(inside)
    all_sites = np.array(sorted({base for base, free in cells if not free}))
    low = np.array([base for base, _ in faces])
    high = low + [[a in free for a in range(3)] for _, free in faces]
    unit, many = 2**10, 32
    for voxel in np.argwhere(inside):
        for flip in itertools.product((0, 1), repeat=3):
            found['eighths'] += 1
            turn = lambda points, unit=1: np.where(flip, unit * (voxel + 1) - points, points - unit * voxel)  # noqa: E731
            is_of_boundary = lambda c: cell_of(np.where(flip, voxel + 1 - c, c + voxel)) in cells  # noqa: E731
            sites = turn(all_sites)
            near = [nearest_sites(np.array(c), 2, sites, weight) for c in itertools.product((0, 1), repeat=3)]
            common = set.intersection(*[set(map(tuple, n)) for n in near])
            if not common or not all(map(is_of_boundary, near)):
                continue  # the core meets it
            found['missed'] += 1
            (p,) = common
            F = [i for i in range(3) if len(np.unique(near[-1][:, i])) == 2]  # the axes of the cell at the centre of the voxel
            assert all(p[i] == 0 for i in F) and len(F) <= 2
            a, c = turn(unit * low, unit), turn(unit * high, unit)
            a, c = np.minimum(a, c), np.maximum(a, c)
            special = random.random((many, 3)) < 0.3  # some on planes between voxels, or half way
            points = np.where(special, random.integers(0, 2, (many, 3)) * unit // 2, random.integers(1, unit // 2 + 1, (many, 3)))
            for x in points:
                foot = np.clip(x, a, c)
                square = (foot - x) ** 2 @ weight
                if square.min() == 0:
                    continue
                found['points'] += 1
                q = np.array([x[i] if i in F else unit * p[i] for i in range(3)])
                for b in np.unique(foot[square == square.min()], axis=0):
                    if (b == q).all():
                        continue
                    assert len(set(weight)) > 1, 'an eighth of a cube'
                    y = core_point(x, b, p, F, sites, weight, unit)
                    common_unit = int(np.lcm.reduce([v.denominator for v in y]))
                    nearest = nearest_sites(np.array([int(v * common_unit) for v in y]), common_unit, sites, weight)
                    assert not is_of_boundary(nearest), 'a point of the core'
                    far = sum(int(w) * (v - Fraction(int(u), unit)) ** 2 for w, v, u in zip(weight, y, x))
                    assert far <= Fraction(int(weight.sum() - weight.min()), 4), 'near'
                    found['constructed'] += 1


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
    for name in 'cubes', 'voxels of other sides':
        found = dict(eighths=0, missed=0, points=0, constructed=0)
        for _ in range(60 * many):
            sides = np.ones(3, int) if name == 'cubes' else random.integers(1, 7, 3)
            check_theorem(random_shape(random, 8), sides**2, random, found)
        print(f'The proof for {name}, on {60 * many} random shapes: {found["eighths"]} eighths of voxels, {found["missed"]} of them not met by '
              f'the core. At {found["points"]} points in these q is the only nearest point of the boundary; at {found["constructed"]} of them '
              'not, and the point that the proof constructs is one of the core, near enough.\n')
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
        assert all(v[0] <= diagonal / 2 + 0.03 * parts for parts, values in found.items() for v in values)


if __name__ == '__main__':
    main(make, __doc__)
