#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.4: a shape of few voxels, its core with voxels split into 1, 2 and 4 to the side, and the true medial axis.

The true axis is drawn as the core at 16 to the side, within h / 64 of it. Distances from the core to the true axis are
exact upper bounds: of a point x of the core, whose nearest boundary point p is not a corner, the ball that touches in p is
grown away from p until it touches a second time; its centre is on the true axis."""
import numpy as np
from paper import CURVE, Complex, Scene, main, sheet, table, voxel_faces, write_nrrd
from scipy.spatial import cKDTree

PARTS = (1, 2, 4)
TRUTH = 16


def small_shape():
    inside = np.zeros((9, 7, 5), bool)
    inside[0:6, 0:5, 0:2] = True
    inside[1:4, 1:4, 2:4] = True
    inside[6:9, 2, 0] = True
    inside[8, 2:7, 0] = True
    return inside


def boundary_boxes(inside):
    """Voxels outside that touch the shape, as (low, high)."""
    padded = np.pad(inside, 1)
    near = np.zeros_like(padded)
    for shift in np.ndindex(3, 3, 3):
        near |= np.roll(padded, np.array(shift) - 1, (0, 1, 2))
    low = np.argwhere(near & ~padded) - 1.5
    return low, low + 1


def nearest_of_boxes(x, low, high):
    """Distances of points to the union of boxes, and the nearest points."""
    distance, foot = np.full(len(x), np.inf), np.zeros_like(x)
    for l, h in zip(low, high):
        p = np.clip(x, l, h)
        d = np.linalg.norm(x - p, axis=1)
        closer = d < distance
        distance[closer], foot[closer] = d[closer], p[closer]
    return distance, foot


def distance_to_axis(x, low, high, bound):
    """Upper bounds of the distances of points inside to the medial axis, by bisection up to `bound`."""
    distance, foot = nearest_of_boxes(x, low, high)
    normal = (x - foot) / distance[:, None]
    begin, end = np.zeros(len(x)), np.full(len(x), bound)
    free = np.abs(nearest_of_boxes(x + end[:, None] * normal, low, high)[0] - (distance + end)) < 1e-9
    for _ in range(24):
        middle = (begin + end) / 2
        d = nearest_of_boxes(x + middle[:, None] * normal, low, high)[0]
        still = np.abs(d - (distance + middle)) < 1e-9  # the ball touches nothing else yet
        begin, end = np.where(still, middle, begin), np.where(still, end, middle)
    return np.where(free, np.inf, end)


def points_on(axis, step):
    """Points on the polygons and lines of a complex, at most `step` apart."""
    found = [axis.points]
    corner = np.arange(len(axis.corners))
    inner = (corner > axis.offsets[axis.polygon]) & (corner + 1 < axis.offsets[axis.polygon + 1])
    first = axis.points[axis.corners[axis.offsets[axis.polygon[inner]]]]  # of the fan of triangles of each polygon
    a, b = axis.points[axis.corners[corner[inner]]] - first, axis.points[axis.corners[corner[inner] + 1]] - first
    parts = np.ceil(np.maximum(np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)) / step).astype(int).clip(1)
    for n in np.unique(parts):
        i, j = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)]).T[:, :, None, None] / n
        of = parts == n
        found.append((first[of] + i * a[of] + j * b[of]).reshape(-1, 3))
    for a, b in axis.points[axis.lines]:
        t = np.linspace(0, 1, int(np.ceil(np.linalg.norm(b - a) / step)) + 2)[:, None]
        found.append((1 - t) * a + t * b)
    return np.concatenate(found)


def make(paper):
    inside = small_shape()
    volume = write_nrrd(paper.file('small.nrrd'), inside)
    low, high = boundary_boxes(inside)
    cores = {}
    for parts in (*PARTS, TRUTH):
        file = paper.file(f'small_{parts}.vtp')
        paper.quench('core', volume, '--threshold', 1, '--surface', 'voxels', '--subdivide', parts, '--detail', 0, '-o', file)
        cores[parts] = Complex(file)
    truth = points_on(cores[TRUTH], 0.1)
    surface = voxel_faces(inside)
    rows, pictures, captions = [], [], []
    view = (-1.1, 1.6, -1.5)
    for parts in PARTS:
        core, h = cores[parts], 1 / parts
        x = np.unique(points_on(core, 0.3).round(9), axis=0)
        far = distance_to_axis(x, low, high, h)
        back = cKDTree(points_on(core, 0.05)).query(truth)[0]
        rows.append((f'1/{parts}', core.count, int(core.only_curves().sum()), len(x), f'{far.max():.4f}', f'{h / 4:.4f}',
                     f'{back.max():.3f}',
                     f'{back.max() / h:.2f}'))
        scene = Scene(view)
        scene.add(surface, (0.7, 0.75, 0.8), 0.10)
        scene.add(cores[TRUTH].sheets(), (0.15, 0.65, 0.3), 0.35, behind=True)
        scene.add(core.sheets(), (0.66, 0.68, 0.72), edges=True)
        scene.add(core.curves(core.only_curves()), CURVE, width=6)
        pictures.append(scene.render((820, 620)))
        captions.append(f'{core.count} polygons; from core to axis at most {far.max():.3f} (bound {h / 4:g})')
    print('Thm. 2.4.4: points of the core are within h/4 of the true medial axis. Unit: the voxel of the shape.\n')
    table(('voxel h', 'polygons', 'lone edges', 'points tested', 'core to axis, at most', 'bound h/4', 'axis to core (sampled)', 'in h'),
          rows)
    print('\nThe last two columns are the conjecture (that the core comes near every point of the axis, proved by now for 0.866 h): it is '
          'farthest\nat the convex corners, which the axis reaches and the core does not.')
    paper.save(sheet([pictures], [f'voxels of 1/{p}' if p > 1 else 'voxels' for p in PARTS], captions=[captions], width=4.2), '2_4')


if __name__ == '__main__':
    main(make, __doc__)
