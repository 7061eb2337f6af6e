#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How clean and how complete default results are, before and after: `quench run` with different prunings.

usage: quality.py [--quench PROGRAM] [--resolutions 64,128,256,512] [--shapes NAME_OR_FILE,...]
                  [--prunings '--lambda auto;--detail auto'] [--work DIR]

One row of a Markdown table per shape, resolution and pruning. Shapes are built-in samples or mesh files.

  faces       faces of the pruned core, of those of the whole core
  nodes       nodes of the burning
  branches    of pure curves (theta2 inf) with the default theta1, and their ends
  coverage    largest distance of a boundary vertex to the balls of the core, in voxels, found here with a k-d tree
  core, axis  ellipsoid, torus, box, whose medial axes are known: largest distance of a point of the core to the axis,
              and of a point of the axis to the core, in voxels; in brackets that of 99 % of the points

Needs numpy, scipy and Debian's python3-vtk9."""
import argparse
import json
import subprocess
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

SHAPES = 'ellipsoid,torus,box,bumpy-sphere,fin-on-board,four-blobs,plate-with-holes,rippled-box'


def known_axis(name):
    """Points of the medial axis of a sample, about 0.002 apart."""
    if name == 'ellipsoid':
        a, b, c = 1, 0.7, 0.4
        A, B = (a * a - c * c) / a, (b * b - c * c) / b
        x, y = np.meshgrid(np.arange(-A, A, 0.002), np.arange(-B, B, 0.002))
        inside = (x / A) ** 2 + (y / B) ** 2 <= 1
        return np.column_stack([x[inside], y[inside], np.zeros(inside.sum())])
    if name == 'torus':
        t = np.linspace(0, 2 * np.pi, 6000)
        return np.column_stack([np.cos(t), np.sin(t), 0 * t])
    return None


def box_axis(sides):
    """Of a box about 0: for every point of the three middle planes and of the bisectors, whether two of the distances
    to faces are least there."""
    half = np.asarray(sides) / 2
    step = 0.004
    u = [np.arange(-h, h + step / 2, step) for h in half]
    parts = []
    short = int(np.argmin(half))
    i, j = [k for k in range(3) if k != short]
    p, q = np.meshgrid(u[i], u[j])  # the middle plane
    keep = np.minimum(half[i] - np.abs(p), half[j] - np.abs(q)) >= half[short]
    plane = np.zeros((keep.sum(), 3))
    plane[:, i], plane[:, j] = p[keep], q[keep]
    parts.append(plane)
    for a, b in ((0, 1), (0, 2), (1, 2)):  # where the distances to a face along a and to one along b are the same
        other = 3 - a - b
        d, o = np.meshgrid(np.arange(0, min(half[a], half[b]), step / np.sqrt(2)), u[other])
        keep = half[other] - np.abs(o) >= d
        for sa in (-1, 1):
            for sb in (-1, 1):
                sheet = np.zeros((keep.sum(), 3))
                sheet[:, a], sheet[:, b] = sa * (half[a] - d[keep]), sb * (half[b] - d[keep])
                sheet[:, other] = o[keep]
                parts.append(sheet)
    return np.concatenate(parts)


def read(file):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    data = reader.GetOutput()
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    polygons = (vtk_to_numpy(data.GetPolys().GetOffsetsArray()), vtk_to_numpy(data.GetPolys().GetConnectivityArray()))
    lines = vtk_to_numpy(data.GetLines().GetConnectivityArray()).reshape(-1, 2)
    return points, vtk_to_numpy(data.GetPointData().GetArray('radius')), lines, polygons, data


def points_of(file):
    """Points of the cells of a core: vertices, lines in eight parts, triangles of the polygons in a grid of four."""
    points, _, lines, (offsets, corners), _ = read(file)
    t = np.arange(1, 8)[:, None, None] / 8
    parts = [points, ((1 - t) * points[lines[:, 0]] + t * points[lines[:, 1]]).reshape(-1, 3)]
    sizes = np.diff(offsets)
    triangles = sizes - 2
    face = np.repeat(np.arange(len(sizes)), triangles)
    k = np.arange(len(face)) - np.repeat(np.cumsum(triangles) - triangles, triangles) + 1
    a, b, c = (points[corners[offsets[face] + i]] for i in (0, k, k + 1))
    for i in range(5):
        for j in range(5 - i):
            parts.append(a + i / 4 * (b - a) + j / 4 * (c - a))
    return np.concatenate(parts)


def coverage(core, shape_file):
    """The largest distance of a boundary vertex to the balls. A ball of radius r at c is nearest where |p - c| - r is:
    balls are grouped by radius, and each group is asked for its nearest centre."""
    points, radius, _, _, _ = read(core)
    header, data = Path(shape_file).read_bytes().split(b'\n\n', 1)
    fields = dict(line.split(': ', 1) for line in header.decode().splitlines() if ': ' in line)
    if fields['encoding'] == 'gzip':
        import gzip
        data = gzip.decompress(data)
    sizes = [int(n) for n in fields['sizes'].split()]
    solid = np.pad(np.frombuffer(data, np.uint8).reshape(sizes[::-1]) != 0, 1)
    count = sum(solid[z:z - 1 or None, y:y - 1 or None, x:x - 1 or None][:solid.shape[0] - 1, :solid.shape[1] - 1,
                                                                          :solid.shape[2] - 1].astype(np.uint8)
                for z in (0, 1) for y in (0, 1) for x in (0, 1))
    at = np.argwhere((count > 0) & (count < 8))[:, ::-1]  # the corner above voxel (i, j, k) of the padded grid
    origin = np.array([float(x) for x in fields['space origin'].strip('()').split(',')])
    steps = np.array([[float(x) for x in v.strip('()').split(',')] for v in fields['space directions'].split()])
    sites = origin + (at - 0.5) @ steps
    order = np.argsort(radius)
    nearest = np.full(len(sites), np.inf)
    for group in np.array_split(order, max(1, min(64, len(order) // 50))):
        # Within a group radii differ: the bound |p - c| - r of the nearest centre is refined over its k nearest.
        k = min(len(group), 8)
        distance, index = cKDTree(points[group]).query(sites, k=k)
        distance, index = distance.reshape(len(sites), k), index.reshape(len(sites), k)
        nearest = np.minimum(nearest, (distance - radius[group][index]).min(axis=1))
    return max(0.0, nearest.max()) / np.linalg.norm(steps[0])


def both(core, axis, voxel):
    core_points = points_of(core)
    to_axis, to_core = cKDTree(axis).query(core_points)[0] / voxel, cKDTree(core_points).query(axis)[0] / voxel
    return ' | '.join(f'{d.max():.2f} ({np.percentile(d, 99):.2f})' for d in (to_axis, to_core))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--resolutions', default='64,128,256,512')
    parser.add_argument('--shapes', default=SHAPES)
    parser.add_argument('--prunings', default='--lambda auto;--detail auto')
    parser.add_argument('--work', type=Path, default=Path('quality'))
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)

    def quench(*arguments):
        subprocess.run([options.quench, *map(str, arguments), '--quiet', '--overwrite'], check=True)

    print('| shape | R | pruning | faces kept | of | nodes | branches (ends) | coverage | core to axis | axis to core |')
    print('|---|---|---|---|---|---|---|---|---|---|')
    for shape in options.shapes.split(','):
        mesh = Path(shape)
        if not mesh.suffix:
            mesh = options.work / f'{shape}.ply'
            quench('sample', shape, '-o', mesh)
        for resolution in options.resolutions.split(','):
            voxels = options.work / f'{mesh.stem}-{resolution}.nrrd'
            quench('voxelize', mesh, '--resolution', resolution, '-o', voxels)
            for pruning in options.prunings.split(';'):
                folder = options.work / '-'.join([mesh.stem, resolution, *pruning.strip('-').split()])
                quench('run', mesh, '--resolution', resolution, *pruning.split(), '--theta2', 'inf', '--no-view', '-o', folder)
                report = json.loads((folder / 'report.json').read_text())
                voxel = report['shape']['spacing'][0]
                axis = known_axis(mesh.stem)
                if mesh.stem == 'box':
                    points = read_mesh_box(mesh)
                    axis = box_axis(points)
                distances = both(folder / 'core.vtp', axis, voxel) if axis is not None else ' | '
                print(f"| {mesh.stem} | {resolution} | {pruning} | {report['pruned']['faces']} | {report['core']['faces']} | "
                      f"{report['burn']['nodes']} | {report['skeleton']['branches']} ({report['skeleton']['ends']}) | "
                      f"{coverage(folder / 'core.vtp', voxels):.2f} | {distances} |", flush=True)


def read_mesh_box(mesh):
    """The sides of the box around a PLY of the samples."""
    import vtk
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(mesh))
    reader.Update()
    b = reader.GetOutput().GetBounds()
    return [b[1] - b[0], b[3] - b[2], b[5] - b[4]]


if __name__ == '__main__':
    main()
