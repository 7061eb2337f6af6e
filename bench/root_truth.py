#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the curve graphs of Quench with the true branches of random roots (`quench sample root`).

usage: root_truth.py [--quench PROGRAM] [--seeds 1,2,3,4,5] [--resolutions 256,512] [--branches 20,60]
                     [--theta1 LIST] [--smooth LIST] [--resample LIST] [--pruning 'OPTION VALUE'] [--work DIR] [--thinning]
                     [--each]

Every root is run once (`quench run`), every combination of the lists is then made of its burned core (`quench
skeleton --theta2 inf`); without lists, the files of `run` are looked at: its default parameters. Prints one row of a
Markdown table per resolution, number of branches and combination, over all seeds (--each: one row per root).
--thinning: a row for the thinning of scikit-image (Lee 1994), where Debian's python3-skimage is installed; its radii
are those of the distance transform, its ends and junctions voxels with one and with more than two neighbours.

What is compared. A true tip is the centre of the ball at the end of a branch, a true junction the point of the parent's
centre line where a branch begins; the base of the main root is a tip.

  tips found    true tips with an end of a curve within max(3 voxels, 1.5 radii), one end for one tip
  ends right    ends of curves that are so matched
  junctions found, right: the same with junctions, but several true junctions may share one and the reverse
  length        path along the curves from the end of the branch to the place nearest to its true junction, against the
                true length: median of the relative errors (size); `bias`: median of the signed ones
  radius        at every point of a true branch, radius of the nearest point of the curves: median of the errors (size)
                in voxels; `bias`: median of the signed ones

Radii are compared where a branch is farther from every other than the sum of the two radii and two voxels: not where it
leaves its parent. Roots whose branches touch for want of room (more than some hundred branches) are refused: their loops
and hidden tips are not in the list of branches.

Needs Debian's python3-numpy and python3-scipy."""
import argparse
import tempfile
import csv
import itertools
import json
import re
import subprocess
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree


def sampled(points, step):
    """A polyline (rows: coordinates and what else varies along it) with points about every `step`."""
    parts = max(1, int(np.ceil(np.linalg.norm(points[1, :3] - points[0, :3]) / step)))
    t = np.arange(parts)[:, None] / parts
    return np.concatenate([((1 - t) * a + t * b) for a, b in zip(points, points[1:])] + [points[-1:]])


def best_pairs(cost, limit):
    """The most pairs that cost less than the limit, the cheapest of these; columns by rows."""
    if cost.size == 0:
        return {}
    rows, columns = linear_sum_assignment(np.where(cost < limit, cost, 1e3 * limit))
    return {int(i): int(j) for i, j in zip(rows, columns) if cost[i, j] < limit}


class Truth:
    """The true branches, sampled every quarter of a voxel, and where each is clear of the others."""

    def __init__(self, file, voxel):
        content = json.loads(Path(file).read_text())
        if content['damage']:
            raise SystemExit(f'{file}: branches touch; use fewer branches')
        branches = content['branches']
        self.voxel = voxel
        fine = [sampled(np.array(branch['points']), voxel / 4) for branch in branches]
        self.first = np.concatenate([[0], np.cumsum([len(p) for p in fine])])
        self.points, self.radius = np.split(np.concatenate(fine), [3], axis=1)
        self.radius = self.radius[:, 0]
        self.parent = np.array([b['parent'] for b in branches])
        self.length = np.array([np.linalg.norm(np.diff(p[:, :3], axis=0), axis=1).sum() for p in fine])
        self.count = len(branches)
        owner = np.repeat(np.arange(self.count), np.diff(self.first))
        self.clear = np.ones(len(self.points), bool)
        for b in range(self.count):
            own, others = np.flatnonzero(owner == b), np.flatnonzero(owner != b)
            tree = cKDTree(self.points[others])
            reach = self.radius[own] + self.radius.max() + 2 * voxel
            for i, near in zip(own, tree.query_ball_point(self.points[own], reach)):
                far = np.linalg.norm(self.points[others[near]] - self.points[i], axis=1)
                self.clear[i] = not np.any(far < self.radius[others[near]] + self.radius[i] + 2 * voxel)
        last = self.first[1:] - 1
        self.tips = np.concatenate([last, [0]])
        self.junctions = self.first[1:-1]  # first points of the branches but the main root
        self.junction_parent_radius = np.array([self.radius[self.on_parent(b)] for b in range(1, self.count)])

    def on_parent(self, b):
        p = self.parent[b]
        own = slice(self.first[p], self.first[p + 1])
        return self.first[p] + np.argmin(np.linalg.norm(self.points[own] - self.points[self.first[b]], axis=1))

    def reach(self, radius):
        return np.maximum(3 * self.voxel, 1.5 * radius)

    def junction_reach(self):
        return self.reach(self.junction_parent_radius)


class Curves:
    """A graph with radii, in pieces of at most half a voxel."""

    def __init__(self, points, radius, links, ends, junctions, voxel):
        self.ends, self.junctions = points[ends], points[junctions]
        self.end_ids = np.asarray(ends)
        far = np.linalg.norm(points[links[:, 0]] - points[links[:, 1]], axis=1)
        parts = np.maximum(1, np.ceil(far / (voxel / 2)).astype(int))
        all_points, all_radii, rows, cols, weights = [points], [radius], [], [], []
        count = len(points)
        for (a, b), n, length in zip(links, parts, far):
            t = np.arange(1, n)[:, None] / n
            all_points.append((1 - t) * points[a] + t * points[b])
            all_radii.append((1 - t[:, 0]) * radius[a] + t[:, 0] * radius[b])
            chain = np.concatenate([[a], np.arange(count, count + n - 1), [b]])
            count += n - 1
            rows.append(chain[:-1])
            cols.append(chain[1:])
            weights.append(np.full(n, length / n))
        self.points, self.radius = np.concatenate(all_points), np.concatenate(all_radii)
        self.graph = coo_matrix((np.maximum(np.concatenate(weights), 1e-12), (np.concatenate(rows), np.concatenate(cols))),
                                shape=(count, count)).tocsr()
        self.tree = cKDTree(self.points)


def read_curves(swc, table, voxel):
    """The graph of an SWC file with its cut loops closed again; ends and junctions of the table of branches."""
    text = Path(swc).read_text()
    rows = np.array([[float(x) for x in line.split()] for line in text.splitlines() if not line.startswith('#')])
    points, radius, parent = rows[:, 2:5], rows[:, 5], rows[:, 6].astype(int) - 1
    links = [(i, p) for i, p in enumerate(parent) if p >= 0]
    links += [(int(a) - 1, int(b) - 1) for a, b in re.findall(r'no segment between samples (\d+) and (\d+)', text)]
    kinds = {'end': set(), 'junction': set()}
    with open(table, newline='') as file:
        for row in csv.DictReader(file):
            for side in ('from', 'to'):
                if row[f'{side}_kind'] in kinds:
                    kinds[row[f'{side}_kind']].add(tuple(float(row[f'{side}_{axis}']) for axis in 'xyz'))
    tree = cKDTree(points)
    places = {kind: tree.query(np.array(sorted(at)).reshape(-1, 3))[1] for kind, at in kinds.items()}
    return Curves(points, radius, np.array(links), places['end'], places['junction'], voxel)


def thinned(volume, voxel):
    """Thinning of a voxel shape by scikit-image, as a graph of voxels."""
    from scipy import ndimage
    from skimage.morphology import skeletonize
    header, data = Path(volume).read_bytes().split(b'\n\n', 1)
    fields = dict(line.split(': ', 1) for line in header.decode().splitlines() if ': ' in line)
    if fields['encoding'] == 'gzip':
        import gzip
        data = gzip.decompress(data)
    sizes = [int(n) for n in fields['sizes'].split()]
    solid = np.frombuffer(data, np.uint8).reshape(sizes[::-1]) != 0
    origin = np.array([float(x) for x in fields['space origin'].strip('()').split(',')])
    bones = skeletonize(solid) != 0
    distance = ndimage.distance_transform_edt(solid) * voxel
    at = np.argwhere(bones)
    number = -np.ones(np.array(solid.shape) + 2, int)
    number[tuple((at + 1).T)] = np.arange(len(at))
    links, degree = [], np.zeros(len(at), int)
    for step in itertools.product((-1, 0, 1), repeat=3):
        if step == (0, 0, 0):
            continue
        other = number[tuple((at + 1 + step).T)]
        degree += other >= 0
        if step > (0, 0, 0):
            links += [(a, b) for a, b in enumerate(other) if b >= 0]
    points = origin + at[:, ::-1] * voxel
    return Curves(points, distance[tuple(at.T)], np.array(links), np.flatnonzero(degree == 1),
                  np.flatnonzero(degree > 2), voxel)


def compare(truth, curves):
    voxel, result = truth.voxel, {}
    # Tips: the matching with the most pairs, nearest first among those.
    tips, reach = truth.points[truth.tips], truth.reach(truth.radius[truth.tips])
    far = np.linalg.norm(tips[:, None] - curves.ends[None], axis=2)
    end_of = best_pairs(far / reach[:, None], 1)
    result['tips'], result['ends'] = (len(end_of), len(tips)), (len(end_of), len(curves.ends))
    # Junctions.
    far = np.linalg.norm(truth.points[truth.junctions][:, None] - curves.junctions[None], axis=2)
    near = far <= truth.junction_reach()[:, None]
    result['junctions'] = (int(near.any(axis=1).sum()), near.shape[0])
    result['crossings'] = (int(near.any(axis=0).sum()), near.shape[1])
    # Lengths.
    errors = []
    for b in range(1, truth.count):
        if b not in end_of:
            continue
        end = curves.end_ids[end_of[b]]
        goal = curves.tree.query(truth.points[truth.first[b]])[1]
        path = dijkstra(curves.graph, directed=False, indices=end)[goal]
        errors.append(path / truth.length[b] - 1)
    result['length'] = np.array(errors)
    # Radii, at clear places before the tip.
    places = np.flatnonzero(truth.clear)
    far, near = curves.tree.query(truth.points[places])
    close = far <= truth.reach(truth.radius[places])
    result['radius'] = (curves.radius[near[close]] - truth.radius[places[close]]) / voxel
    return result


def row(name, results):
    def share(key):
        a, b = np.sum([r[key] for r in results], axis=0)
        return f'{a / max(b, 1):.3f} ({a}/{b})'
    def median(values, form):
        return format(np.median(values), form) if len(values) else '-'
    length = np.concatenate([r['length'] for r in results])
    radius = np.concatenate([r['radius'] for r in results])
    return (f"| {name} | {share('tips')} | {share('ends')} | {share('junctions')} | {share('crossings')} | "
            f"{median(abs(length), '.2%')} | {median(length, '+.2%')} | {len(length)} | "
            f"{median(abs(radius), '.2f')} | {median(radius, '+.2f')} |")


HEAD = ('| {} | tips found | ends right | junctions found | junctions right | length error | bias | branches '
        '| radius error (voxels) | bias |\n|' + '---|' * 10)


def numbers(text):
    return text.split(',') if text else []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--seeds', type=numbers, default=numbers('1,2,3,4,5'))
    parser.add_argument('--resolutions', type=numbers, default=numbers('256,512'))
    parser.add_argument('--branches', type=numbers, default=numbers('20,60'))
    parser.add_argument('--theta1', type=numbers, default=[])
    parser.add_argument('--smooth', type=numbers, default=[])
    parser.add_argument('--resample', type=numbers, default=[])
    parser.add_argument('--pruning', default='--detail auto', help="of the runs, e.g. '--lambda auto'")
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_root_truth')
    parser.add_argument('--thinning', action='store_true')
    parser.add_argument('--each', action='store_true')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def quench(*arguments):
        subprocess.run([options.quench, *map(str, arguments), '--quiet', '--threads', '1'], check=True)

    lists = [('--theta1', options.theta1), ('--smooth', options.smooth), ('--resample', options.resample)]
    lists = [(name, values) for name, values in lists if values]
    print(HEAD.format('root'), flush=True)
    for resolution, branches in itertools.product(options.resolutions, options.branches):
        results = {}
        for seed in options.seeds:
            mesh = options.work / f'root-{branches}-{seed}.ply'
            if not mesh.exists():
                quench('sample', 'root', '--seed', seed, '--branches', branches, '-o', mesh)
            folder = options.work / '-'.join([mesh.stem, str(resolution), *options.pruning.strip('-').split()])
            if not (folder / 'report.json').exists():
                quench('run', mesh, '--resolution', resolution, *options.pruning.split(), '-o', folder,
                       '--overwrite')
            report = json.loads((folder / 'report.json').read_text())
            voxel = report['shape']['spacing'][0]
            truth = Truth(mesh.with_suffix('.json'), voxel)

            def add(name, curves):
                result = compare(truth, curves)
                results.setdefault(name, []).append(result)
                if options.each:
                    print(row(f'{name}, seed {seed}', [result]), flush=True)

            title = f'{branches} branches at {resolution}'
            if not lists:
                add(title, read_curves(folder / 'skeleton.swc', folder / 'branches.csv', voxel))
            for values in itertools.product(*(v for _, v in lists)) if lists else []:
                chosen = [word for (name, _), value in zip(lists, values) for word in (name, value)]
                swc, table = folder / 'try.swc', folder / 'try.csv'
                quench('skeleton', folder / 'core.vtp', '--theta2', 'inf', *chosen, '--swc', swc, '--csv', table, '-o',
                       folder / 'try.vtp', '--overwrite')
                add(' '.join([title, *chosen]), read_curves(swc, table, voxel))
            if options.thinning:
                volume = folder / 'shape.nrrd'
                quench('voxelize', mesh, '--resolution', resolution, '-o', volume, '--overwrite')
                add(f'{title}, scikit-image', thinned(volume, voxel))
        if not options.each:
            for name, several in results.items():
                print(row(name, several), flush=True)


if __name__ == '__main__':
    main()
