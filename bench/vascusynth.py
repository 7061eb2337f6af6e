#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares `quench tree --kind vessel` with a synthetic vessel tree of VascuSynth (Hamarneh and Jassi 2010).

usage: vascusynth.py TREE.xml [--voxel 0.04] [--quench PROGRAM] [--resolutions 256,512,1024] [--work DIR]

TREE.xml is the tree in GXL that VascuSynth writes: positions in voxels of its image, radii in its own unit, of which
--voxel make a voxel of its image. Every edge becomes a tube with round ends; `quench tree` gets them as one mesh, at each
resolution. One row of a Markdown table per resolution:

  tips     share of the terminal nodes with an end of an axis within max(3 voxels, 1.5 radii), one for one
  ends     share of the ends of axes that are so matched
  length   length of all axes over that of all edges
  edges    share of the edges of which both nodes are within max(2 voxels, 1 radius) of an axis; of these
  chord    relative error of the distance of the places next to both nodes, median size
  radius   error half way, in voxels, median size and median
  angle    between the edge and what joins these places, degrees, median

Only what the resolution can show counts: tips and edges of at least one voxel radius, edges longer than twice the
radius of the edge before them. Needs Debian's python3-numpy and python3-scipy."""
import argparse
import subprocess
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from root_truth import best_pairs
from tree_truth import Tree


def read_gxl(file, voxel):
    """Positions of the nodes; per edge its nodes and its radius; whether a node is an end."""
    graph = xml.parse(file).getroot().find('graph')
    position = {node.get('id'): [float(f.text) for f in node.iter('float')] for node in graph.findall('node')}
    number = {name: i for i, name in enumerate(position)}
    edges, radius = [], []
    for edge in graph.findall('edge'):
        edges.append((number[edge.get('from')], number[edge.get('to')]))
        radius.append(next(float(a.find('float').text) for a in edge.findall('attr') if a.get('name').strip() == 'radius'))
    return np.array(list(position.values())), np.array(edges), np.array(radius) / voxel


def tube(a, b, radius, around=24, cap=6):
    """Vertices and triangles of a capsule."""
    along = (b - a) / np.linalg.norm(b - a)
    normal = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    normal /= np.linalg.norm(normal)
    binormal = np.cross(along, normal)
    turn = 2 * np.pi * np.arange(around) / around
    circle = np.cos(turn)[:, None] * normal + np.sin(turn)[:, None] * binormal
    slope = 0.5 * np.pi * np.arange(1, cap + 1) / cap
    rings = [a - radius * np.cos(s) * along + radius * np.sin(s) * circle for s in slope]
    rings += [b + radius * np.cos(s) * along + radius * np.sin(s) * circle for s in slope[::-1]]
    points = np.concatenate([[a - radius * along], *rings, [b + radius * along]])
    ring = 1 + np.arange(around)
    after = 1 + (np.arange(around) + 1) % around
    faces = [np.column_stack([np.zeros(around, int), after, ring])]
    for k in range(2 * cap - 1):
        low, high = k * around, (k + 1) * around
        faces += [np.column_stack([ring + low, after + low, after + high]), np.column_stack([ring + low, after + high, ring + high])]
    last = (2 * cap - 1) * around
    faces.append(np.column_stack([ring + last, after + last, np.full(around, len(points) - 1)]))
    return points, np.concatenate(faces)


def write_ply(file, parts):
    points, faces, count = [], [], 0
    for p, f in parts:
        points.append(p)
        faces.append(f + count)
        count += len(p)
    points, faces = np.concatenate(points), np.concatenate(faces)
    rows = np.zeros(len(faces), [('n', 'u1'), ('v', '<i4', 3)])
    rows['n'], rows['v'] = 3, faces
    with open(file, 'wb') as out:
        out.write(f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n'
                  f'property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n'.encode())
        out.write(points.astype('<f8').tobytes() + rows.tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('tree', type=Path)
    parser.add_argument('--voxel', type=float, default=0.04)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--resolutions', type=lambda text: [int(n) for n in text.split(',')], default=[256, 512, 1024])
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_vascusynth')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    nodes, edges, radius = read_gxl(options.tree, options.voxel)
    mesh = options.work / 'vessels.ply'
    write_ply(mesh, (tube(nodes[i], nodes[j], r) for (i, j), r in zip(edges, radius)))
    side = (nodes.max(axis=0) - nodes.min(axis=0)).max()
    before = {int(j): r for (_, j), r in zip(edges, radius)}  # the radius before a node
    length = np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1)
    ends = ~np.isin(edges[:, 1], edges[:, 0])
    print('| resolution | tips | ends | length | edges | chord | radius | bias | angle |\n|' + '---|' * 9, flush=True)
    for resolution in options.resolutions:
        voxel, folder = side / resolution, options.work / str(resolution)
        if not (folder / 'report.json').exists():
            subprocess.run([options.quench, 'tree', mesh, '--kind', 'vessel', '--resolution', str(resolution), '-o', folder,
                            '--no-view', '--no-picture', '--overwrite', '--quiet'], check=True)
        tree = Tree(folder, voxel)
        points = np.concatenate([c.points for c in tree.courses])
        radii = np.concatenate([c.radius for c in tree.courses])
        shown = radius >= voxel
        tips, reach = nodes[edges[ends, 1]], np.maximum(3 * voxel, 1.5 * radius[ends])
        axis_ends = np.array([c.points[-1] for c in tree.courses])
        far = np.linalg.norm(tips[:, None] - axis_ends[None], axis=2) / reach[:, None]
        found = best_pairs(far, 1.0)
        wanted = np.flatnonzero(shown[ends])
        search = cKDTree(points)
        far, near = search.query(nodes)
        counts = shown & (length > 2 * np.array([max(r, before.get(int(i), r)) for (i, _), r in zip(edges, radius)]))
        close = np.all(far[edges] <= np.maximum(2 * voxel, radius)[:, None], axis=1) & counts
        joined = points[near[edges[:, 1]]] - points[near[edges[:, 0]]]
        true = nodes[edges[:, 1]] - nodes[edges[:, 0]]
        chord = np.linalg.norm(joined, axis=1) / length - 1
        angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(joined, true), axis=1), np.sum(joined * true, axis=1)))
        middle = (nodes[edges[:, 0]] + nodes[edges[:, 1]]) / 2
        error = (radii[search.query(middle)[1]] - radius) / voxel
        of = [f'{sum(t in found for t in wanted) / len(wanted):.3f} ({sum(t in found for t in wanted)}/{len(wanted)})',
              f'{len(found) / len(axis_ends):.3f} ({len(found)}/{len(axis_ends)})',
              f'{sum(c.length for c in tree.courses) / length.sum():.3f}',
              f'{close.sum() / counts.sum():.3f} ({close.sum()}/{counts.sum()})', f'{np.median(np.abs(chord[close])):.2%}',
              f'{np.median(np.abs(error[close])):.2f}', f'{np.median(error[close]):+.2f}', f'{np.median(angle[close]):.1f}']
        print(f"| {resolution} | {' | '.join(of)} |", flush=True)


if __name__ == '__main__':
    main()
