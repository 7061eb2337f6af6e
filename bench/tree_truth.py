#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the trees of Quench (`quench tree`) with the true branches of random roots (`quench sample root`).

usage: tree_truth.py [--quench PROGRAM] [--seeds 1,2,3,4,5] [--cases clean256,clean512,light,medium,strong]
                     [--branches 60] [--options 'OPTIONS OF quench tree'] [--work DIR] [--each] [--wrong] [--itself]

Cases: clean roots at resolution 256 and 512 as meshes; at 256 as images of grey values

  light    blur 0.5 voxels, noise 0.05 of the contrast,  3 gaps, 2 places where branches touch
  medium   blur 0.8,        noise 0.1,                   6 gaps, 4
  strong   blur 1,          noise 0.2,                  12 gaps, 6

Prints a Markdown table with a row per case over all seeds (--each: one per root), and whether the bars hold. --wrong
lists every branch, parent, level and edit that is wrong, with its place. --itself: the truth goes to `quench tree` as an
RSML file, so that only hierarchy and traits are compared.

An axis and a true branch are a pair when they run side by side, one axis for one branch: the share of the one that is
within max(2 voxels, 1 radius) of the other is at least 0.7 for both, and the tips are within max(3 voxels, 1.5 radii)
plus, of a tip in a gap, nothing. What is compared:

  number      axes of the tree less true branches; exact: share of the roots without a difference
  axes        share of the true branches that have an axis
  right       share of the axes that have a true branch
  tips        share of the true tips with an end of an axis within max(3 voxels, 1.5 radii), one for one
  parents     share of the pairs whose parents are a pair; levels: whose levels are equal
  length      relative error of the length of an axis, median of the sizes and median of the signed ones
  radius      at every point of a true branch out of its parent, radius of its axis next to it: median size, in voxels
  parent, gravity: error of parent_angle and gravity_angle (docs/user/traits.md) in degrees, mean of the sizes
  repaired    share of the gaps that a bridge closes, and of the touching places that are cut
  false       share of the edits that are false: a bridge that leaves the tube of a branch (and of its parent), a cut
              that takes a piece of a branch away; and parts left out that are a piece of a branch (missed) are counted apart

Needs Debian's python3-numpy and python3-scipy."""
import argparse
import csv
import json
import subprocess
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from root_truth import best_pairs, sampled

CASES = {
    'clean256': ['--resolution', 256],
    'clean512': ['--resolution', 512],
    'light': ['--touching', 2, '--gaps', 3, '--blur', 0.5, '--noise', 0.05],
    'medium': ['--touching', 4, '--gaps', 6, '--blur', 0.8, '--noise', 0.1],
    'strong': ['--touching', 6, '--gaps', 12, '--blur', 1, '--noise', 0.2],
}


class Course:
    """A polyline with radii, finely sampled."""

    def __init__(self, points, radius, step):
        fine = sampled(np.column_stack([points, radius]), step)
        self.points, self.radius = fine[:, :3], fine[:, 3]
        self.at = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])
        self.length = self.at[-1]
        self.tree = cKDTree(self.points)

    def place(self, at):
        return np.array([np.interp(at, self.at, self.points[:, k]) for k in range(3)])

    def share_near(self, other, voxel, first=0):
        far, near = other.tree.query(self.points[first:])
        return np.mean(far <= np.maximum(2 * voxel, other.radius[near]))


def degrees(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


class True_branches:
    def __init__(self, file, voxel):
        content = json.loads(Path(file).read_text())
        branches, self.damage = content['branches'], content['damage']
        self.voxel = voxel
        self.courses = [Course(*np.split(np.array(b['points']), [3], axis=1), voxel / 4) for b in branches]
        self.parent = [b['parent'] for b in branches]
        self.level = [b['level'] for b in branches]
        self.out = [self.out_of_parent(b) for b in range(len(branches))]  # first point of each out of its parent
        down = np.array([0, 0, -1])
        self.gravity_angle = [degrees(c.points[-1] - c.points[0], down) for c in self.courses]
        self.parent_angle = [self.angle_to_parent(b) for b in range(len(branches))]
        self.all = cKDTree(np.concatenate([c.points for c in self.courses]))
        self.owner = np.concatenate([np.full(len(c.points), b) for b, c in enumerate(self.courses)])
        self.radius = np.concatenate([c.radius for c in self.courses])

    def out_of_parent(self, b):
        if self.parent[b] < 0:
            return 0
        course, parent = self.courses[b], self.courses[self.parent[b]]
        far, near = parent.tree.query(course.points)
        return int(np.argmax(far > parent.radius[near]))

    def angle_to_parent(self, b):
        """As docs/user/traits.md says: over the radius of the parent and two of its own; the parent's over two of its."""
        if self.parent[b] < 0:
            return np.nan
        course, parent = self.courses[b], self.courses[self.parent[b]]
        at = parent.at[parent.tree.query(course.points[0])[1]]
        tube = np.interp(at, parent.at, parent.radius)
        along = parent.place(min(parent.length, at + tube)) - parent.place(max(0, at - tube))
        return degrees(course.place(tube + 2 * course.radius[0]) - course.points[0], along)

    def tip_reach(self, b):
        return max(3 * self.voxel, 1.5 * self.courses[b].radius[-1])

    def near(self, place, extra):
        """The branches whose tube is within `extra` of a place."""
        found = self.all.query_ball_point(place, self.radius.max() + extra)
        far = np.linalg.norm(self.all.data[found] - place, axis=1)
        return set(self.owner[found][far <= self.radius[found] + extra])


class Tree:
    """What `quench tree` wrote."""

    def __init__(self, folder, voxel):
        self.courses, self.parent, self.level = [], [], []
        scene = xml.parse(folder / 'tree.rsml').getroot().find('scene')
        self.plants = 0
        for plant in scene.findall('plant'):
            self.plants += 1
            for root in plant.findall('root'):
                self.add(root, -1, 0, voxel)
        rows = {int(float(row['axis'])): row for row in table(folder / 'axes.csv')}
        self.rows = [rows[number] for number in self.number]
        self.edits = table(folder / 'edits.csv') if (folder / 'edits.csv').exists() else []
        assert [int(row['level']) for row in self.rows] == self.level

    number = ()

    def add(self, root, parent, level, voxel):
        points = np.array([[float(p.get(a, 0)) for a in 'xyz'] for p in root.find('geometry/polyline').findall('point')])
        radius = np.array([float(s.get('value')) / 2
                           for s in root.find("functions/function[@name='diameter']").findall('sample')])
        own = len(self.courses)
        self.number = (*self.number, int(root.get('id')))
        self.courses.append(Course(points, radius, voxel / 4))
        self.parent.append(parent)
        self.level.append(level)
        for child in root.findall('root'):
            self.add(child, own, level + 1, voxel)


def table(file):
    """Rows of a CSV file, by the names of its columns without units."""
    with open(file, newline='') as text:
        return [{name.split(' [')[0]: value for name, value in row.items()} for row in csv.DictReader(text)]


def place(row, side):
    return np.array([float(row[f'{side}_{axis}']) for axis in 'xyz'])


def distance_of_segments(a, b, c, d):
    """Smallest distance of samples of two segments."""
    t = np.linspace(0, 1, 41)[:, None]
    return cKDTree(a + t * (b - a)).query(c + t * (d - c))[0].min()


def pairs_of(truth, tree):
    cost = np.ones((len(truth.courses), len(tree.courses)))
    for b, course in enumerate(truth.courses):
        for a, axis in enumerate(tree.courses):
            if np.linalg.norm(course.points[-1] - axis.points[-1]) > truth.tip_reach(b):
                continue
            overlap = min(course.share_near(axis, truth.voxel, truth.out[b]), axis.share_near(course, truth.voxel))
            cost[b, a] = 1 - overlap
    return best_pairs(cost, 0.3)


def judge_edits(truth, tree):
    """Which damage is repaired, and which edits are false; edits that are neither mend what noise has done."""
    voxel, repaired, wrong, missed = truth.voxel, [False] * len(truth.damage), [], []
    covered = cKDTree(np.concatenate([c.points for c in tree.courses]))
    for number, edit in enumerate(tree.edits):
        a, b = place(edit, 'from'), place(edit, 'to')
        line = a + np.linspace(0, 1, 21)[:, None] * (b - a)
        mended = False
        for k, d in enumerate(truth.damage):
            if (edit['kind'] == 'bridge') != (d['kind'] == 'gap') or edit['kind'] == 'left_out':
                continue
            radius = truth.courses[d['branch']].radius[0]
            reach = max(3 * voxel, 1.5 * radius) + (d['kind'] == 'touching') * truth.courses[d['other']].radius[0]
            if distance_of_segments(a, b, np.array(d['from']), np.array(d['to'])) <= reach:
                repaired[k] = mended = True
        if edit['kind'] == 'left_out':
            lost = [truth.near(p, 0) for p in (a, b)]
            if float(edit['length']) > 4 * voxel and lost[0] & lost[1]:
                missed.append((number, edit))
        elif edit['kind'] == 'bridge':
            tubes = [truth.near(p, 1.5 * voxel) for p in line]
            first = [t for t in tubes if t]
            inside = [any(t & {b, truth.parent[b]} for b in {*first[0], *first[-1]}) if t else False for t in tubes] if first else [False]
            one = any(all(t & {b, truth.parent[b]} for t in tubes) for b in set().union(*tubes)) if all(inside) else False
            if not one:
                wrong.append((number, edit))
        elif not mended:
            far, near = truth.all.query(line)
            uncovered = (covered.query(truth.all.data[near])[0] > np.maximum(2 * voxel, truth.radius[near])) & (
                far <= truth.radius[near] + voxel)
            if np.any(uncovered):
                wrong.append((number, edit))
    return repaired, wrong, missed


def compare(truth, tree):
    voxel, count = truth.voxel, len(truth.courses)
    result = {'number': len(tree.courses) - count, 'plants': tree.plants}
    pairs = pairs_of(truth, tree)
    back = {a: b for b, a in pairs.items()}
    result['axes'], result['right'] = (len(pairs), count), (len(pairs), len(tree.courses))
    tips = np.array([c.points[-1] for c in truth.courses])
    ends = np.array([c.points[-1] for c in tree.courses])
    far = np.linalg.norm(tips[:, None] - ends[None], axis=2) / np.array([truth.tip_reach(b) for b in range(count)])[:, None]
    result['tips'] = (len(best_pairs(far, 1.0)), count)
    wrong = [('missing', b, None) for b in range(count) if b not in pairs]
    wrong += [('extra', None, a) for a in range(len(tree.courses)) if a not in back]
    parents = {b: back.get(tree.parent[a], -1 if tree.parent[a] < 0 else None) == truth.parent[b] for b, a in pairs.items()}
    levels = {b: tree.level[a] == truth.level[b] for b, a in pairs.items()}
    wrong += [('parent', b, pairs[b]) for b, right in parents.items() if not right]
    wrong += [('level', b, pairs[b]) for b, right in levels.items() if not right]
    result['parents'], result['levels'] = (sum(parents.values()), len(pairs)), (sum(levels.values()), len(pairs))
    result['length'] = np.array([tree.courses[a].length / truth.courses[b].length - 1 for b, a in pairs.items()])
    radius = []
    for b, a in pairs.items():
        course, axis = truth.courses[b], tree.courses[a]
        radius.append(axis.radius[axis.tree.query(course.points[truth.out[b]:])[1]] - course.radius[truth.out[b]:])
    result['radius'] = np.concatenate(radius) / voxel if radius else np.zeros(0)
    for name in ('parent_angle', 'gravity_angle'):
        errors = [float(tree.rows[a][name]) - getattr(truth, name)[b] for b, a in pairs.items()
                  if truth.parent[b] >= 0 and tree.rows[a][name]]
        result[name] = np.array([e for e in errors if np.isfinite(e)])
    repaired, false, missed = judge_edits(truth, tree)
    made = [e for e in tree.edits if e['kind'] != 'left_out']
    result['repaired'], result['false'] = (sum(repaired), len(repaired)), (len(false), len(made))
    result['missed'] = len(missed)
    result['wrong'] = wrong, [d for d, r in zip(truth.damage, repaired) if not r], false, missed
    return result


HEAD = ('| {} | exact | axes | right | tips | parents | levels | length | bias | radius | parent | gravity | repaired | '
        'false | missed |\n|' + '---|' * 15)


def share(results, key):
    a, b = np.sum([r[key] for r in results], axis=0)
    return a / b if b else 1.0, f'{a / b:.3f} ({a}/{b})' if b else '-'


def row(name, results):
    def median(key, form, sizes=True):
        values = np.concatenate([r[key] for r in results])
        return format(np.median(np.abs(values) if sizes else values), form) if len(values) else '-'

    def mean(key):
        values = np.concatenate([r[key] for r in results])
        return f'{np.abs(values).mean():.1f}' if len(values) else '-'
    exact = sum(r['number'] == 0 for r in results)
    cells = [f'{exact}/{len(results)}' + (f" ({results[0]['number']:+d})" if len(results) == 1 else '')]
    cells += [share(results, key)[1] for key in ('axes', 'right', 'tips', 'parents', 'levels')]
    cells += [median('length', '.2%'), median('length', '+.2%', False), median('radius', '.2f'), mean('parent_angle'),
              mean('gravity_angle'), share(results, 'repaired')[1], share(results, 'false')[1],
              str(sum(r['missed'] for r in results))]
    return f"| {name} | {' | '.join(cells)} |"


def bars(case, results):
    """(what, found, bar, whether it holds)"""
    def least(what, value, bar):
        return what, f'{value:.3f}', f'at least {bar}', value >= bar

    def most(what, value, bar):
        return what, f'{value:.3f}', f'at most {bar}', value <= bar
    if case.startswith('clean'):
        angles = np.abs(np.concatenate([r[k] for r in results for k in ('parent_angle', 'gravity_angle')]))
        return [least('number of axes exact', np.mean([r['number'] == 0 for r in results]), 0.95),
                least('parents', share(results, 'parents')[0], 0.98), least('levels', share(results, 'levels')[0], 0.98),
                most('length error', np.median(np.abs(np.concatenate([r['length'] for r in results]))), 0.01),
                most('angles, degrees', angles.mean(), 3)]
    return [least('repaired', share(results, 'repaired')[0], 0.9), most('false edits', share(results, 'false')[0], 0.05),
            least('axes', share(results, 'axes')[0], 0.9)]


def text(p):
    return '({:.4f},{:.4f},{:.4f})'.format(*p)


def print_wrong(title, truth, tree, result):
    wrong, unrepaired, false, missed = result['wrong']
    for kind, b, a in wrong:
        line = f'{title}: {kind}'
        if b is not None:
            course = truth.courses[b]
            line += (f'; true branch {b}, level {truth.level[b]}, parent {truth.parent[b]}, length {course.length:.3f}, '
                     f'from {text(course.points[0])} to tip {text(course.points[-1])}')
        if a is not None:
            course = tree.courses[a]
            line += (f'; axis {tree.number[a]}, level {tree.level[a]}, parent '
                     f'{tree.number[tree.parent[a]] if tree.parent[a] >= 0 else -1}, length {course.length:.3f}, from '
                     f'{text(course.points[0])} to tip {text(course.points[-1])}')
        print(line)
    for d in unrepaired:
        print(f"{title}: not repaired; {d['kind']} of branch {d['branch']}" +
              (f" and {d['other']}" if d['kind'] == 'touching' else f", contrast {d['contrast']:.2f}") +
              f", from {text(d['from'])} to {text(d['to'])}")
    for what, list_of in (('false', false), ('missed', missed)):
        for number, edit in list_of:
            print(f"{title}: {what}; edit {number}, {edit['kind']}, length {float(edit['length']):.4f}, from "
                  f"{text(place(edit, 'from'))} to {text(place(edit, 'to'))}, branches there "
                  f"{sorted(map(int, truth.near(place(edit, 'from'), truth.voxel)))} and "
                  f"{sorted(map(int, truth.near(place(edit, 'to'), truth.voxel)))}")


def write_rsml(truth_file, file):
    """The true branches as an RSML file."""
    branches = json.loads(Path(truth_file).read_text())['branches']
    rsml = xml.Element('rsml')
    metadata = xml.SubElement(rsml, 'metadata')
    for name, value in (('version', '1'), ('unit', 'mm'), ('resolution', '1')):
        xml.SubElement(metadata, name).text = value
    nodes = {-1: xml.SubElement(xml.SubElement(rsml, 'scene'), 'plant')}
    for branch in branches:
        node = nodes[branch['id']] = xml.SubElement(nodes[branch['parent']], 'root', id=str(branch['id']))
        line = xml.SubElement(xml.SubElement(node, 'geometry'), 'polyline')
        for x, y, z, _ in branch['points']:
            xml.SubElement(line, 'point', x=repr(x), y=repr(y), z=repr(z))
        if branch['parent'] >= 0:
            xml.SubElement(xml.SubElement(node, 'properties'), 'parent-node', value=str(branch['parent_point'] + 1))
        function = xml.SubElement(xml.SubElement(node, 'functions'), 'function', domain='polyline', name='diameter')
        for *_, radius in branch['points']:
            xml.SubElement(function, 'sample', value=repr(2 * radius))
    xml.ElementTree(rsml).write(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--seeds', type=lambda text: [int(s) for s in text.split(',')], default=[1, 2, 3, 4, 5])
    parser.add_argument('--cases', type=lambda text: text.split(','), default=list(CASES))
    parser.add_argument('--branches', type=int, default=60)
    parser.add_argument('--options', default='', help="of `quench tree`, e.g. '--repair loops'")
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_tree_truth')
    parser.add_argument('--each', action='store_true')
    parser.add_argument('--wrong', action='store_true')
    parser.add_argument('--itself', action='store_true')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def quench(*arguments):
        return subprocess.run([options.quench, *map(str, arguments), '--quiet', '--threads', '1'])

    print(HEAD.format('root'), flush=True)
    verdicts = []
    for case in options.cases:
        results = []
        for seed in options.seeds:
            words, shape = CASES[case], options.work / f'{case}-{options.branches}-{seed}'
            clean = case.startswith('clean')
            shape = shape.with_suffix('.ply' if clean else '.nrrd')
            if not shape.exists():
                quench('sample', 'root', '--seed', seed, '--branches', options.branches, '-o', shape,
                       *([] if clean else ['--grey', *words])).check_returncode()
            folder = options.work / '-'.join([shape.stem, *options.options.replace('/', ' ').split()])
            source, settings = shape, [*(words if clean else ['--threshold', 125]), *options.options.split()]
            if options.itself:
                source, settings = shape.with_suffix('.rsml'), ['--down', '0,0,-1']
                write_rsml(shape.with_suffix('.json'), source)
                folder = options.work / f'{shape.stem}-itself'
            if not (folder / 'report.json').exists():
                if quench('tree', source, '-o', folder, '--no-view', '--no-picture', '--overwrite', *settings).returncode:
                    print(f'{case}, seed {seed}: quench tree failed', flush=True)
                    continue
            voxel = (1.03 / 512 if case == 'clean512' else 1.03 / 256)
            truth, tree = True_branches(shape.with_suffix('.json'), voxel), Tree(folder, voxel)
            results.append(compare(truth, tree))
            title = f'{case}, seed {seed}'
            if options.each:
                print(row(title, results[-1:]), flush=True)
            if options.wrong:
                print_wrong(title, truth, tree, results[-1])
        if results:
            if not options.each:
                print(row(case, results), flush=True)
            verdicts += [(case, *verdict) for verdict in bars(case, results)]
    print('\n| root | bar | found | asked for | holds |\n|---|---|---|---|---|')
    for case, what, found, asked, holds in verdicts:
        print(f"| {case} | {what} | {found} | {asked} | {'yes' if holds else '**no**'} |")


if __name__ == '__main__':
    main()
