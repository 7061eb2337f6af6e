#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The hierarchy of fires of Yan 2018, sec. 4.1.2, level by level, on random shapes of voxels and pixels and on one by
hand, a board with a short fin. Of every level with vertices and edges (curves of the plane, medial curves in 3D): is the
time of the fire never before that of the level above; does it jump along an edge, by more than the edge is long; is its
erosion thickness somewhere inside (not at a free end) less than at all neighbours, and by how much. Lengths in voxels. The
picture is docs/pictures/hierarchy_fin.png: docs/algorithms/hierarchy.md."""
import numpy as np
from paper import Complex, main, plt, table, write_nrrd
from scipy.ndimage import gaussian_filter
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

SHAPES = 40


def board_with_fin():
    inside = np.zeros((22, 22, 12), bool)
    inside[:, :, :4] = True
    inside[8:14, 10:12, 4:] = True
    return inside


def burned(paper, inside, *options):
    """Curves of a shape, nothing dropped and nothing smoothed: `core` of a plane, `skeleton` of a volume."""
    plane = inside.shape[2] == 1
    padded = np.pad(inside, ((1, 1), (1, 1), (0, 0) if plane else (1, 1)))
    volume, folder = write_nrrd(paper.file('hierarchy.nrrd'), padded), paper.file('hierarchy')
    paper.quench('run', volume, '--threshold', 1, *(['--dimension', 2] if plane else ['--theta2', 'inf']), '--surface', 'voxels',
                 '--detail', 0, '--theta1', 0, '--smooth', 0, '--tips', 'pruned', '--no-view', '--no-picture', *options, '-o', folder)
    found = Complex(folder / ('core.vtp' if plane else 'skeleton.vtp'))
    never = lambda name: found.at[name].astype(bool)  # noqa: E731
    time = {name: found.at[name].astype(float) for name in ('radius', 'burn_time')}
    time['burn_time'][never('unburned')] = np.inf
    if not plane:
        time['curve_burn_time'] = found.at['curve_burn_time'].astype(float)
        time['curve_burn_time'][never('curve_unburned')] = np.inf
    return found.points, found.lines, list(time.values())[-2:], plane


def look(points, lines, times):
    """Of the fire `times[1]` over the level above, `times[0]`: least thickness, largest jumps of both, deepest inner minimum."""
    above, time = times
    with np.errstate(invalid='ignore'):
        thickness = np.where(np.isfinite(time), time - above, np.inf)
        length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1)
        jumps = [np.nanmax(np.where(np.isfinite(t[lines]).all(axis=1), np.abs(np.diff(t[lines], axis=1))[:, 0] - length, 0), initial=0)
                 for t in times]
        lowest = np.full(len(points), np.inf)
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(lowest, lines[:, a], thickness[lines[:, b]])
        inner = (np.bincount(lines.ravel(), minlength=len(points)) > 1) & np.isfinite(thickness) & np.isfinite(lowest)
        depth = np.max((lowest - thickness)[inner], initial=0)
    return min(thickness.min(initial=np.inf), np.inf), *jumps, max(0, depth)


def shapes(random, plane):
    for _ in range(SHAPES):
        size = [*random.integers(20, 60, 2), 1] if plane else random.integers(6, 20, 3)
        noise = gaussian_filter(random.random(size), random.uniform(0.7, 2) * (np.array([1, 1, 0]) if plane else 1))
        inside = noise > np.quantile(noise, random.uniform(0.4, 0.8))
        yield inside


def picture(paper, points, lines, times):
    """Along the way from a free end in the fin to the place that burns last."""
    above, time = times
    length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1) + 1e-9
    ways = coo_matrix((length, lines.T), shape=(len(points),) * 2).tocsr()
    last = np.argmax(np.where(np.isfinite(time), time, -1))
    far, before = dijkstra(ways, directed=False, indices=last, return_predecessors=True)
    top = np.flatnonzero(points[:, 2] > points[:, 2].min() + 6)
    at = top[np.argmax(far[top])]
    way = [at]
    while way[-1] != last:
        way.append(before[way[-1]])
    s = far[at] - far[way]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), width_ratios=(1, 1.25))
    used = points[lines]
    left.plot(used[:, :, 0].T, used[:, :, 2].T, color='#9db4c9', linewidth=0.5)
    left.plot(points[way, 0], points[way, 2], color='#d1495b', linewidth=2)
    left.set_aspect('equal')
    left.set_title('medial curves from the side; the way', fontsize=9)
    left.axis('off')
    for values, name, colour in ((above, 'BT, of the sheets', '#20486e'), (time, 'BT of the curves', '#d1495b'),
                                 (time - above, 'ET of the curves', '#e0a030')):
        right.plot(s, values[way], '.-', label=name, color=colour, markersize=3)
    right.set_xlabel('along the way, voxels')
    right.legend(fontsize=8)
    right.grid(alpha=0.3)
    paper.save(figure, 'check_hierarchy')


def make(paper):
    rows = []
    for plane in (True, False):
        random, all_found, deepest = np.random.default_rng(5), [], None
        for inside in shapes(random, plane):
            points, lines, times, _ = burned(paper, inside, *([] if plane else ['--propagation', 'windows']))
            if not len(lines):
                continue
            all_found.append(look(points, lines, times))
            if all_found[-1][3] >= max(one[3] for one in all_found):
                deepest = inside
        found = np.array(all_found)
        rows.append((f'{len(found)} shapes of ' + ('pixels: axis' if plane else 'voxels: medial curves'), found[:, 0].min(),
                     found[:, 1].max(), found[:, 2].max(), found[:, 3].max(), f'{100 * np.mean(found[:, 3] > 0.01):.0f} %'))
    for name, inside in ((f'the deepest of these ({" x ".join(map(str, deepest.shape))})', deepest), ('board with a fin', board_with_fin())):
        for omega in ('0.4vox', '0.2vox', '0.1vox', '0.05vox')[:4 if inside is deepest else 3]:
            points, lines, times, _ = burned(paper, inside, '--omega', omega, '--propagation', 'windows')
            found = look(points, lines, times)
            rows.append((f'{name}, nodes {omega[:-3]} voxels apart', *found, '-'))
    picture(paper, points, lines, times)
    table(('shapes', 'least ET', 'largest jump of the time above', 'of the time', 'deepest inner minimum of ET', 'shapes that have one'),
          rows)


if __name__ == '__main__':
    main(make, __doc__)
