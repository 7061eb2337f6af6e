#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Statements of chapters 2 and A of Yan 2018 on small shapes, each with numbers, without the program where that is possible:
Thm. 2.3.1 as it is written, Lemmas 2.4.1 and A.1.1, Thms. 2.4.1, 2.4.2, 2.4.3, 2.4.4 and 2.4.5 with the in-core test, Lemma 2.4.2
on random shapes (all by exact integers or brute force), Thm. A.3.1 on voxels of known solids."""
import itertools

import numpy as np
from figure_2_4 import boundary_boxes, distance_to_axis
from paper import Complex, boundary_faces, main, table, write_nrrd
from scipy.spatial import Voronoi, cKDTree


def sites_of(inside):
    """Lattice corners whose eight voxels are neither all inside nor all outside; voxel (x, y, z) has corners x to x + 1."""
    padded = np.pad(inside, 1).astype(int)
    count = sum(padded[i:padded.shape[0] - 1 + i, j:padded.shape[1] - 1 + j, k:padded.shape[2] - 1 + k]
                for i, j, k in np.ndindex(2, 2, 2))
    return np.argwhere((count > 0) & (count < 8))


def boundary_elements(inside):
    """Faces of the boundary as four corners."""
    unit = np.eye(3, dtype=int)
    return np.array([[base, base + unit[u], base + unit[u] + unit[v], base + unit[v]] for base, u, v in boundary_faces(inside)])


def random_shape(random):
    size = random.integers(2, 7, 3)
    return random.random(size) < random.uniform(0.35, 0.8)


def lemma_2_4_1(random):
    """Points of random elements of the lattice: their nearest lattice points are corners of the element."""
    checked = 0
    around = np.array(list(itertools.product(range(-2, 4), repeat=3)))
    for _ in range(4000):
        free = random.random(3) < random.uniform(0.2, 1)
        p = np.where(free, random.integers(1, 64, 3) / 64, 0)  # inside the element that is free along these axes
        square = ((around - p) ** 2).sum(axis=1)
        nearest = around[square == square.min()]
        assert ((nearest >= 0) & (nearest <= free)).all()
        checked += 1
    return checked


def empty_balls(inside):
    """Thm. 2.4.1: around the centre of every face and edge of the boundary no site is nearer than its corners."""
    faces, sites = boundary_elements(inside), sites_of(inside)
    tree = cKDTree(sites)
    centres = faces.mean(axis=1)
    assert np.allclose(tree.query(centres)[0], np.sqrt(0.5))
    edges = np.concatenate([faces[:, [i, (i + 1) % 4]] for i in range(4)])
    assert np.allclose(tree.query(edges.mean(axis=1))[0], 0.5)
    return len(faces) + len(edges)


def euler(inside):
    """Of the open voxel shape: voxels less shared faces, plus edges and corners whose voxels are all inside."""
    v = np.pad(inside, 1).astype(int)
    f = sum((np.minimum(v, np.roll(v, 1, a)) == 1).sum() for a in range(3))
    e = sum((np.minimum.reduce([v, np.roll(v, 1, a), np.roll(v, 1, b), np.roll(np.roll(v, 1, a), 1, b)]) == 1).sum()
            for a, b in itertools.combinations(range(3), 2))
    c = (np.minimum.reduce([np.roll(v, s, (0, 1, 2)) for s in np.ndindex(2, 2, 2)]) == 1).sum()
    return int(v.sum() - f + e - c)


def core_checks(paper, random, count):
    """On the program's cores of random shapes."""
    found = {'shapes': 0, 'points': 0, 'farthest': 0.0, 'Euler': 0, 'in-core': 0, 'inside': 0}
    for number in range(count):
        inside = random_shape(random)
        if not inside.any():
            continue
        volume, out = write_nrrd(paper.file('random.nrrd'), inside), paper.file('random.vtp')
        paper.quench('core', volume, '--threshold', 1, '--surface', 'voxels', '--detail', 0, '-o', out)
        core = Complex(out)
        found['shapes'] += 1
        assert int(core.field['euler'].ravel()[0]) == euler(inside), 'Thm. 2.4.3'
        found['Euler'] += 1
        # Thm. 2.4.5: strictly inside. Voxel (x, y, z) is centred at (x, y, z).
        low, high = boundary_boxes(inside)
        x = [core.points, core.points[core.lines].mean(axis=1)]
        if core.count:
            x.append(np.add.reduceat(core.points[core.corners], core.offsets[:-1]) / np.diff(core.offsets)[:, None])
        x = np.concatenate(x)
        distance = np.full(len(x), np.inf)
        for a, b in zip(low, high):
            distance = np.minimum(distance, np.linalg.norm(x - np.clip(x, a, b), axis=1))
        assert distance.min() > 1e-9, 'Thm. 2.4.5'
        found['inside'] += len(x)
        far = distance_to_axis(x, low, high, 0.5)
        assert far.max() <= 0.25 + 1e-7, 'Thm. 2.4.4'
        found['points'] += len(x)
        found['farthest'] = max(found['farthest'], far.max())
        # The in-core test: circumcentres of the sites inside O are the vertices of the core, and no others.
        sites = sites_of(inside) - 0.5
        box = 60 * np.array(list(itertools.product((-1, 1), repeat=3)))
        vertices = Voronoi(np.concatenate([sites, box])).vertices
        padded = np.pad(inside, 1)
        cell = np.rint(vertices).astype(int) + 1
        in_box = ((cell >= 0) & (cell < padded.shape)).all(axis=1)
        half = np.abs(vertices - np.rint(vertices))
        clear = in_box & (half.max(axis=1) < 0.5 - 1e-6)  # a vertex on a voxel's boundary is inside if all its voxels are
        chosen = clear.copy()
        chosen[clear] = padded[tuple(cell[clear].T)]
        if chosen.any():
            assert cKDTree(core.points).query(vertices[chosen])[0].max() < 1e-6, 'in-core test'
        found['in-core'] += int(chosen.sum())
    return found


def dual_cubes(h, solid, random):
    """Thm. A.3.1: the configurations of 2 x 2 x 2 voxel centres in and out of a solid in a turned grid, up to symmetry and
    complement; of cubes with an ambiguous face (two centres inside across a face's diagonal, or all but two), how many there are
    and how many have no complement beyond it."""
    n = int(np.ceil(1.5 / h)) + 2
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    axis = [(np.arange(-n, n) + s) * h for s in random.uniform(-0.5, 0.5, 3)]
    grid = np.stack(np.meshgrid(*axis, indexing='ij'), -1) @ turn
    inside = solid(*np.moveaxis(grid, -1, 0))
    a, b, c = np.array(inside.shape) - 1
    code = sum(inside[i:a + i, j:b + j, k:c + k].astype(int) << (4 * i + 2 * j + k) for i, j, k in np.ndindex(2, 2, 2))
    pairs = alone = 0
    for face, (odd, step) in FACES.items():
        for place in np.argwhere(np.isin(code, odd)):
            pairs += 1
            beyond = code[tuple(place + step)]
            alone += CANONICAL[beyond] != PAIR or bin(beyond).count('1') == bin(code[tuple(place)]).count('1')
    return {CANONICAL[c] for c in np.unique(code)}, pairs, alone


def canonical():
    corners = np.array(list(np.ndindex(2, 2, 2)))
    turned = []
    for order in itertools.permutations(range(3)):
        for flip in np.ndindex(2, 2, 2):
            moved = corners[:, order] ^ np.array(flip)
            turned.append(moved @ (4, 2, 1))
    found = []
    for code in range(256):
        bits = (code >> np.arange(8)) & 1
        both = [sum(int(b) << int(t) for b, t in zip(bits, turn)) for turn in turned]
        found.append(min(both + [255 - c for c in both]))
    return found


CANONICAL = canonical()
PAIR = CANONICAL[0b00000110]  # two centres across the diagonal of a face


def faces():
    """Per face of a dual cube: the codes that are ambiguous there and of the class PAIR, and the step to the cube beyond it."""
    found = {}
    for axis in range(3):
        for end in (0, 1):
            corners = [4 * c[0] + 2 * c[1] + c[2] for c in np.ndindex(2, 2, 2) if c[axis] == end]
            odd = []
            for diagonal in ((corners[0], corners[3]), (corners[1], corners[2])):
                two = (1 << diagonal[0]) | (1 << diagonal[1])
                four = sum(1 << c for c in corners)
                odd += [two, 255 - (four - two)]
            found[axis, end] = odd, np.eye(3, dtype=int)[axis] * (1 if end else -1)
    return found


FACES = faces()


def make(paper):
    random = np.random.default_rng(11)
    rows = [('Lemma 2.4.1', 'nearest lattice points of a point of an element are its corners', f'{lemma_2_4_1(random)} points', 'holds')]
    elements = sum(empty_balls(random_shape(random)) for _ in range(300))
    rows.append(('Thm. 2.4.1', 'faces and edges of the boundary have empty balls', f'{elements} elements of 300 shapes', 'holds'))
    # Thm. 2.3.1: two opposite corners of a square are on an empty ball, but no element: the square is.
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    distance = np.linalg.norm(square - square[[0, 2]].mean(axis=0), axis=1)
    assert not (distance < distance[0] - 1e-12).any()
    rows.append(('Thm. 2.3.1', 'an element, if and only if its vertices lie on an empty ball',
                 'diagonal of a unit square: empty ball, no element',
                 '"if" needs all sites on the sphere'))
    # Lemma A.1.1
    worst = 0.0
    for _ in range(20000):
        x, p, q, n = random.normal(size=(4, 3))
        n /= np.linalg.norm(n)
        if np.linalg.norm(x - p) >= np.linalg.norm(x - q) or (q - p) @ n < 0.05:
            continue
        s = (((x - q) ** 2).sum() - ((x - p) ** 2).sum()) / (2 * (q - p) @ n)
        assert s > 0
        worst = max(worst, abs(np.linalg.norm(x + s * n - p) - np.linalg.norm(x + s * n - q)))
    rows.append(('Lemma A.1.1', 'the shift s makes p and q equally far', f'largest difference {worst:.1e}', 'holds'))
    core = core_checks(paper, random, 120)
    rows += [('Thm. 2.4.3', 'Euler characteristic of core and shape, counted separately', f'{core["Euler"]} random shapes', 'holds'),
             ('Thm. 2.4.4', 'within h/4 of the true medial axis', f'{core["points"]} points, farthest {core["farthest"]:.4f} h', 'holds'),
             ('Thm. 2.4.5', 'strictly inside', f'{core["inside"]} points', 'holds'),
             ('in-core test', 'Voronoi vertices (by qhull) inside O are vertices of the core', f'{core["in-core"]} vertices', 'holds')]
    solids = {'ball': (1.0, lambda x, y, z: x * x + y * y + z * z < 1),
              'ellipsoid': (0.16, lambda x, y, z: x * x + (y / 0.7) ** 2 + (z / 0.4) ** 2 < 1),
              'torus': (0.35, lambda x, y, z: (np.hypot(x, y) - 1) ** 2 + z * z < 0.35**2)}
    for name, (reach, solid) in solids.items():
        seen, coarse, pairs, alone = set(), set(), 0, 0
        for k in range(12):
            found, some, without = dual_cubes(reach * 3**-0.5 * (1 - 0.05 * k), solid, random)
            seen, pairs, alone = seen | found, pairs + some, alone + without
        for factor in (0.8, 1.2, 1.6, 2.2, 3.0):
            coarse |= dual_cubes(reach * factor, solid, random)[0]
        rows.append(('Thm. A.3.1', f'{name}: at most 8 configurations of dual cubes for h <= r/sqrt 3, the ambiguous in pairs',
                     f'{len(seen)} of {len(set(CANONICAL))} seen ({len(coarse)} with larger voxels); {pairs} ambiguous cubes, {alone} '
                     'without a partner', 'holds' if len(seen) <= 8 and not alone else 'does not hold'))
    table(('statement', 'what', 'checked', ''), rows)


if __name__ == '__main__':
    main(make, __doc__)
