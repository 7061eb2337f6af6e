#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How far noise moves a skeleton and, beside it, the lambda-pruned core (Yan 2018, Fig. 3.10).

usage: stability.py [--quench PROGRAM] [--resolution 192] [--data FOLDER] [--work DIR]

`quench run` with default parameters on a shape without and with noise: rippled-box and bumpy-sphere, where the bumps are
the noise, and two scanned meshes with normal noise of 0.3 and 0.5 % of the longest side on the vertices. Prints rows
of a Markdown table: Hausdorff distance (the larger of the two directions) and mean distance (the mean of the two
directions) between the result without and with noise, in percent of the longest side, and how many faces each has.
Distances are between points on faces and lines a third of a voxel apart. Needs python3-numpy, -scipy, -vtk9."""
import argparse
import tempfile
import json
import subprocess
from pathlib import Path

import numpy as np
import vtk
from scipy.spatial import cKDTree
from vtk.util.numpy_support import vtk_to_numpy

from polylines import segments_of


def points_on(file, spacing, random):
    """Points on all cells of a complex, and its number of faces."""
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    data = reader.GetOutput()
    faces = data.GetNumberOfPolys()
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    found = [points]
    if data.GetNumberOfLines():
        ends = segments_of(data)
        a, b = points[ends[:, 0]], points[ends[:, 1]]
        count = np.ceil(np.linalg.norm(b - a, axis=1) / spacing).astype(int)
        line = np.repeat(np.arange(len(a)), count)
        t = random.random(len(line))[:, None]
        found.append((1 - t) * a[line] + t * b[line])
    if faces:
        offsets = vtk_to_numpy(data.GetPolys().GetOffsetsArray())
        corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray())
        fans = np.concatenate([np.stack([np.full(n - 2, corners[o]), corners[o + 1:o + n - 1], corners[o + 2:o + n]], 1)
                               for o, n in zip(offsets, np.diff(offsets))])
        a, b, c = (points[fans[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        triangle = np.repeat(np.arange(len(a)), np.ceil(area / spacing**2).astype(int))
        s, t = random.random((2, len(triangle), 1))
        flip = s + t > 1
        s, t = np.where(flip, 1 - s, s), np.where(flip, 1 - t, t)
        found.append(a[triangle] + s * (b - a)[triangle] + t * (c - a)[triangle])
    return np.concatenate(found), faces


def distances(a, b):
    there, back = cKDTree(b).query(a)[0], cKDTree(a).query(b)[0]
    return max(there.max(), back.max()), (there.mean() + back.mean()) / 2


def add_noise(source, target, share):
    """Normal noise on every coordinate of every vertex, with this share of the longest side as deviation."""
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(source))
    reader.Update()
    mesh = reader.GetOutput()
    points = vtk_to_numpy(mesh.GetPoints().GetData())
    side = np.ptp(points, axis=0).max()
    points += np.random.default_rng(1).normal(0, share * side, points.shape).astype(points.dtype)
    writer = vtk.vtkPLYWriter()
    writer.SetInputData(mesh)
    writer.SetFileName(str(target))
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--resolution', default='192')
    parser.add_argument('--data', type=Path, default=Path('../shared/data/meshes'))
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_stability')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def quench(*arguments):
        subprocess.run([options.quench, *map(str, arguments), '--overwrite', '--quiet', '--threads', '1'], check=True)

    def run(mesh):
        folder = mesh.with_suffix('')
        quench('run', mesh, '--resolution', options.resolution, '-o', folder)
        return folder

    pairs = []
    for name, noise in (('rippled-box', '0.005'), ('bumpy-sphere', '0.01')):
        meshes = []
        for height in ('0.0001', noise):
            meshes.append(options.work / f'{name}-{height}.ply')
            quench('sample', name, '--noise', height, '-o', meshes[-1])
        pairs.append((f'{name}, noise {noise}', *meshes))
    for file in ('fertility.off', 'kitten.obj'):
        clean = options.work / f'{Path(file).stem}.ply'
        quench('convert', options.data / file, clean)
        for share in (0.003, 0.005):
            noisy = options.work / f'{clean.stem}-{share}.ply'
            add_noise(clean, noisy, share)
            pairs.append((f'{clean.stem}, {share:.1%}', clean, noisy))
    print('| shape, noise | skeleton: Hausdorff | mean | core: Hausdorff | mean | faces of the skeletons | of the cores |\n'
          '|---|---|---|---|---|---|---|', flush=True)
    done = {}
    for name, *meshes in pairs:
        for mesh in meshes:
            if mesh not in done:
                done[mesh] = run(mesh)
        random = np.random.default_rng(0)
        side = json.loads((done[meshes[0]] / 'report.json').read_text())['input']['longest_side']
        cells, counts = [], []
        for kind in ('skeleton', 'core'):
            found = [points_on(done[mesh] / f'{kind}.vtp', side / int(options.resolution) / 3, random) for mesh in meshes]
            largest, mean = distances(found[0][0], found[1][0])
            cells += [f'{largest / side:.2%}', f'{mean / side:.2%}']
            counts.append(' / '.join(str(f[1]) for f in found))
        print(f"| {name} | {' | '.join(cells + counts)} |", flush=True)


if __name__ == '__main__':
    main()
