#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Medial axes fitted to the surface of a mesh and those of its voxels, of solids whose axis is known.

usage: surface_convergence.py [--quench PROGRAM] [--solids ellipsoid,torus,box,cone,capsule,rounded-cone,balls]
                              [--resolutions 64,128,256,512] [--surfaces mesh,voxels] [--fineness 2] [--seed 1]
                              [--work DIR] [--seconds]

Solids, all turned at random (--seed; 0: as they are), as closed meshes:

  ellipsoid     semi-axes 1, 0.7, 0.4 (`quench sample`); axis: an elliptic disc
  torus         radii 1 and 0.35 (`quench sample`); axis: a circle
  box           2 x 1.4 x 1 (`quench sample`); axis: thirteen flat sheets
  cone          height 2, radius of the flat base 0.8; axis: the segment from the tip to the centre of the inscribed
                ball, and the cone from there to the rim of the base
  capsule       radius 0.35 around a segment of length 1.3
  rounded-cone  hull of balls of radii 0.45 and 0.2, centres 1.4 apart; axis: the segment between the centres
  balls         two balls of radius 1, overlapping, centres 1.2 apart; axis: the segment between the centres (the balls
                around its points touch the whole circle where the spheres meet)

Every solid is run once (`quench run`, default options); pure curves are then made of its burned core (`quench skeleton
--theta2 inf`). One row of a Markdown table per solid, resolution and surface; lengths in voxels:

  vertices      of the pruned core
  core to axis  distance of the vertices to the true axis: mean, that of 99 %, largest
  axis to core  distance of points of the true axis, where its cap height is above a voxel, to the cells of the core:
                mean and largest
  radius        error of the radii of the vertices against their distances to the true surface: mean size (mean)
  skeleton      distance of the points of skeleton.vtp to the true axis: mean; error of their radii: mean size
  length        where the axis is a curve: total length of the pure curves less the true length (number of branches)
  ET            largest error of the erosion thickness: of sheets at vertices of the core within a voxel of the axis
                (ellipsoid, box, cone farther than 0.1 from where its parts meet; at most 3000 of them), else of pure
                curves at their points; not of the torus, whose curve never burns

--seconds: wall time of `run` in a last column. Needs Debian's python3-numpy, python3-scipy and python3-vtk9."""
import argparse
import csv
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import vtk
from scipy.spatial.transform import Rotation
from vtk.util.numpy_support import vtk_to_numpy


# ---- distances ------------------------------------------------------------------------------------------------------

def to_segment(p, a, b):
    """Distance of points to a segment, in any dimension."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[:, None] * (b - a), axis=1)


def to_triangle(p, a, b, c):
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    inside = np.ones(len(p), bool)
    for s, e in ((a, b), (b, c), (c, a)):
        inside &= (p - s) @ np.cross(normal, e - s) >= 0
    edges = np.minimum(np.minimum(to_segment(p, a, b), to_segment(p, b, c)), to_segment(p, c, a))
    return np.where(inside, np.abs((p - a) @ normal), edges)


def to_ellipse_or_ellipsoid(p, axes):
    """Distance of points to an ellipse or ellipsoid: the root of Eberly's equation, by bisection. Not for points on the
    plane of the two longest axes."""
    axes = np.asarray(axes, float)
    q, square = np.abs(p), axes ** 2
    low = -square[-1] + axes[-1] * q[:, -1]
    high = -square[-1] + np.linalg.norm(axes * q, axis=1)
    for _ in range(100):
        middle = (low + high) / 2
        with np.errstate(all='ignore'):
            up = ((axes * q / (middle[:, None] + square)) ** 2).sum(1) > 1
        low, high = np.where(up, middle, low), np.where(up, high, middle)
    with np.errstate(all='ignore'):
        return np.linalg.norm(square * q / (high[:, None] + square) - q, axis=1)


def profile(p):
    """Distance to the z axis, and z."""
    return np.column_stack([np.hypot(p[:, 0], p[:, 1]), p[:, 2]])


# ---- solids ---------------------------------------------------------------------------------------------------------
# Each has: to_axis(points), depth(points) = distance to the surface, samples(step) = points of the axis and their cap
# heights (a ball reaches so far beyond the chord of its contacts); length where the axis is a curve;
# thickness(points) = erosion thickness of sheets, or of the curve, at the nearest point of the axis.

class Ellipsoid:
    name, a, length = 'ellipsoid', np.array([1, 0.7, 0.4]), None

    def __init__(self):
        square = self.a ** 2
        self.rim = (square[:2] - square[2]) / self.a[:2]
        t = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
        self.rim_points = self.rim * np.column_stack([np.cos(t), np.sin(t)])

    def ball(self, q):
        """Radius at points of the disc, and how far their contacts are from them in the plane."""
        contact = q * self.a[:2] ** 2 / (self.a[:2] ** 2 - self.a[2] ** 2)
        height = self.a[2] * np.sqrt(np.maximum(0, 1 - ((contact / self.a[:2]) ** 2).sum(1)))
        aside = np.linalg.norm(contact - q, axis=1)
        return np.hypot(aside, height), aside

    def to_axis(self, p):
        outside = ((p[:, :2] / self.rim) ** 2).sum(1) > 1
        distance = np.zeros(len(p))
        distance[outside] = to_ellipse_or_ellipsoid(p[outside, :2], self.rim)
        return np.hypot(distance, p[:, 2])

    def depth(self, p):
        p = p.copy()
        p[:, 2] = np.where(np.abs(p[:, 2]) < 1e-9, 1e-9, p[:, 2])
        return to_ellipse_or_ellipsoid(p, self.a)

    def samples(self, step):
        u = [np.arange(-r, r, step) for r in self.rim]
        q = np.stack(np.meshgrid(*u), axis=-1).reshape(-1, 2)
        q = q[((q / self.rim) ** 2).sum(1) <= 1]
        radius, aside = self.ball(q)
        return np.column_stack([q, 0 * q[:, 0]]), radius - aside

    def thickness(self, p):
        q = p[:, :2] / np.maximum(1, np.sqrt(((p[:, :2] / self.rim) ** 2).sum(1)))[:, None]
        start = self.ball(self.rim_points)[0]
        burnt = [(start + np.linalg.norm(self.rim_points - x, axis=1)).min() for x in q]
        return np.array(burnt) - self.ball(q)[0]


class Torus:
    name, length = 'torus', 2 * np.pi
    thickness = None

    def to_axis(self, p):
        return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 1, p[:, 2])

    def depth(self, p):
        return 0.35 - self.to_axis(p)

    def samples(self, step):
        t = np.arange(0, 2 * np.pi, step)
        return np.column_stack([np.cos(t), np.sin(t), 0 * t]), np.full(len(t), 0.35)


class Box:
    name, half, length = 'box', np.array([1, 0.7, 0.5]), None

    def __init__(self):
        x, y, z = self.half
        corner, edge, end, middle = (x, y, z), (x, y, 0), (x - z, y - z, 0), (0, 0, 0)
        # Of the octant x, y, z > 0: the middle sheet, and those that bisect two faces.
        self.triangles = [np.array(t, float) for t in (
            (middle, (x - z, 0, 0), end), (middle, end, (0, y - z, 0)), (edge, corner, end),
            ((x, 0, z), corner, end), ((x, 0, z), end, (x - z, 0, 0)),
            ((0, y, z), corner, end), ((0, y, z), end, (0, y - z, 0)))]

    def to_axis(self, p):
        return np.min([to_triangle(np.abs(p), *t) for t in self.triangles], axis=0)

    def depth(self, p):
        return (self.half - np.abs(p)).min(1)

    def samples(self, step):
        points, caps = [], []
        for number, (a, b, c) in enumerate(self.triangles):
            n = int(np.ceil(max(np.linalg.norm(b - a), np.linalg.norm(c - a)) / step))
            i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
            i, j = i[i + j <= n] / n, j[i + j <= n] / n
            q = a + i[:, None] * (b - a) + j[:, None] * (c - a)
            points.append(q)
            caps.append(self.depth(q) * (1 if number < 2 else 1 - np.sqrt(0.5)))
        return np.concatenate(points), np.concatenate(caps)  # the other octants are alike

    def thickness(self, p):
        q = np.abs(p)
        in_middle = np.min([to_triangle(q, *t) for t in self.triangles[:2]], axis=0) <= np.min(
            [to_triangle(q, *t) for t in self.triangles[2:]], axis=0)
        x, y, z = self.half
        inner = z * (np.sqrt(2) - 1) + np.maximum(0, np.minimum(x - z - q[:, 0], y - z - q[:, 1]))
        return np.where(in_middle, inner, (np.sqrt(2) - 1) * self.depth(p))


class Cone:
    name, height, base, length = 'cone', 2.0, 0.8, None

    def __init__(self):
        slant = np.hypot(self.height, self.base)
        self.inner = self.base * self.height / (self.base + slant)  # of the inscribed ball
        self.sine = self.base / slant  # of half the angle at the tip
        self.share = np.sin(np.arctan2(self.height, self.base) / 2)  # of half the angle at the base

    def parts(self, p):
        q = profile(p)
        return (to_segment(q, (0, self.inner), (0, self.height)),
                to_segment(q, (0, self.inner), (self.base, 0)))

    def to_axis(self, p):
        return np.minimum(*self.parts(p))

    def depth(self, p):
        q = profile(p)
        side = ((self.height - q[:, 1]) * self.base - q[:, 0] * self.height) / np.hypot(self.height, self.base)
        return np.minimum(side, q[:, 1])

    def samples(self, step):
        z = np.arange(self.inner, self.height, step)
        points, caps = [np.column_stack([0 * z, 0 * z, z])], [(self.height - z) * self.sine * (1 - self.sine)]
        for s in np.arange(0, 1, step / np.hypot(self.inner, self.base)):
            t = np.arange(0, 2 * np.pi, step / max(s * self.base, step))
            points.append(np.column_stack([s * self.base * np.cos(t), s * self.base * np.sin(t),
                                           np.full(len(t), (1 - s) * self.inner)]))
            caps.append(np.full(len(t), (1 - s) * self.inner * (1 - self.share)))
        return np.concatenate(points), np.concatenate(caps)

    def thickness(self, p):
        segment, sheet = self.parts(p)
        at = np.where(sheet < segment, self.depth(p) * (1 / self.share - 1), 0)
        near_jump = np.linalg.norm(p - [0, 0, self.inner], axis=1) < 0.1
        return np.where(near_jump, np.nan, at)

    def outline(self):
        return [(0, 0), *line((0, 0), (self.base, 0), 100), *line((self.base, 0), (0, self.height), 200)]


class RoundedCone:
    """Around the segment from 0 to (0, 0, length), radius at its ends; a capsule where they are the same."""

    def __init__(self, name, lower, upper, length):
        self.name, self.lower, self.upper, self.length = name, lower, upper, length
        self.sine = (lower - upper) / length

    def to_axis(self, p):
        return to_segment(p, (0, 0, 0), (0, 0, self.length))

    def depth(self, p):
        q = profile(p)
        cosine = np.sqrt(1 - self.sine ** 2)
        at = np.clip(q[:, 1] - q[:, 0] * self.sine / cosine, 0, self.length)  # centre of the ball with p's contact
        return self.lower - self.sine * at - np.hypot(q[:, 0], q[:, 1] - at)

    def samples(self, step):
        z = np.linspace(0, self.length, int(self.length / step))
        return np.column_stack([0 * z, 0 * z, z]), (self.lower - self.sine * z) * (1 - self.sine)

    def thickness(self, p):
        z = np.clip(p[:, 2], 0, self.length)
        return np.minimum(self.lower + z, self.upper + self.length - z) - (self.lower - self.sine * z)

    def outline(self):
        turn = np.arcsin(self.sine)  # of the contacts out of the horizontal, upward
        t, u = np.linspace(-np.pi / 2, turn, 400), np.linspace(turn, np.pi / 2, 400)
        low = self.lower * np.column_stack([np.cos(t), np.sin(t)])
        high = self.upper * np.column_stack([np.cos(u), np.sin(u)]) + [0, self.length]
        return [*low, *line(low[-1], high[0], 100), *high[1:]]


class Balls:
    name, radius, apart, length = 'balls', 1.0, 1.2, 1.2

    def __init__(self):
        self.neck = np.sqrt(self.radius ** 2 - self.apart ** 2 / 4)

    def to_axis(self, p):
        return to_segment(p, (0, 0, -self.apart / 2), (0, 0, self.apart / 2))

    def depth(self, p):
        q = profile(p)
        q[:, 1] = np.abs(q[:, 1]) - self.apart / 2
        from_centre = np.maximum(np.linalg.norm(q, axis=1), 1e-12)
        on_sphere = self.apart / 2 + self.radius * q[:, 1] / from_centre >= 0
        return np.where(on_sphere, self.radius - from_centre,
                        np.hypot(q[:, 0] - self.neck, q[:, 1] + self.apart / 2))

    def samples(self, step):
        z = np.linspace(-self.apart / 2, self.apart / 2, int(self.apart / step))
        return np.column_stack([0 * z, 0 * z, z]), np.hypot(self.neck, z) - np.abs(z)

    def thickness(self, p):
        z = np.minimum(np.abs(p[:, 2]), self.apart / 2)
        return self.radius + self.apart / 2 - z - np.hypot(self.neck, z)

    def outline(self):
        t = np.linspace(-np.pi / 2, np.arcsin(self.apart / 2 / self.radius), 500)
        low = self.radius * np.column_stack([np.cos(t), np.sin(t)]) - [0, self.apart / 2]
        return [*low, *(low[-2::-1] * [1, -1])]


SOLIDS = {s.name: s for s in (Ellipsoid(), Torus(), Box(), Cone(), RoundedCone('capsule', 0.35, 0.35, 1.3),
                              RoundedCone('rounded-cone', 0.45, 0.2, 1.4), Balls())}


# ---- meshes ---------------------------------------------------------------------------------------------------------

def line(a, b, n):
    a, b = np.asarray(a, float), np.asarray(b, float)
    return [a + (b - a) * i / n for i in range(1, n + 1)]


def revolved(outline, around=600):
    """The closed mesh of a profile that starts and ends on the z axis, turned around it, facing outward."""
    outline = np.array(outline)
    poles = np.column_stack([np.zeros((2, 2)), outline[[0, -1], 1]])
    outline = outline[1:-1]
    t = 2 * np.pi * np.arange(around) / around
    rings = np.stack([outline[:, :1] * np.cos(t), outline[:, :1] * np.sin(t), np.repeat(outline[:, 1:], around, 1)],
                     axis=-1)
    n = len(outline)
    first, last = n * around, n * around + 1
    i, j = np.meshgrid(np.arange(n - 1), np.arange(around), indexing='ij')
    a, b = (i * around + j).ravel(), (i * around + (j + 1) % around).ravel()
    c, d = a + around, b + around
    j, k = np.arange(around), (np.arange(around) + 1) % around
    top = (n - 1) * around
    triangles = np.concatenate([np.column_stack([a, b, d]), np.column_stack([a, d, c]),
                                np.column_stack([np.full(around, first), k, j]),
                                np.column_stack([np.full(around, last), top + j, top + k])])
    return np.concatenate([rings.reshape(-1, 3), poles]), triangles


def read_ply(file):
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(file))
    reader.Update()
    data = reader.GetOutput()
    return (vtk_to_numpy(data.GetPoints().GetData()).astype(float),
            vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3))


def write_ply(file, points, triangles):
    rows = np.zeros(len(triangles), [('n', 'u1'), ('v', '<i4', 3)])
    rows['n'], rows['v'] = 3, triangles
    with open(file, 'wb') as out:
        out.write((f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty double x\n'
                   f'property double y\nproperty double z\nelement face {len(triangles)}\n'
                   'property list uchar int vertex_indices\nend_header\n').encode())
        out.write(np.ascontiguousarray(points, '<f8').tobytes())
        out.write(rows.tobytes())


# ---- results --------------------------------------------------------------------------------------------------------

def read_axis(file):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    data = reader.GetOutput()
    arrays = data.GetPointData()
    return data, vtk_to_numpy(data.GetPoints().GetData()).astype(float), {
        arrays.GetArrayName(i): vtk_to_numpy(arrays.GetArray(i)) for i in range(arrays.GetNumberOfArrays())}


def to_cells(points, data):
    """Distance of points to the polygons and lines of a file."""
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(data)
    triangles.PassVertsOn()
    triangles.Update()
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(triangles.GetOutput())
    locator.BuildLocator()
    place, cell, sub, square = [0.0] * 3, vtk.reference(0), vtk.reference(0), vtk.reference(0.0)
    result = np.empty(len(points))
    for i, p in enumerate(points):
        locator.FindClosestPoint(p, place, cell, sub, square)
        result[i] = np.sqrt(float(square))
    return result


def row(options, solid, resolution, surface, turn):
    work = options.work
    mesh = work / f'{solid.name}-{options.seed}-{options.fineness:g}.ply'
    if not mesh.exists():
        if hasattr(solid, 'outline'):
            points, triangles = revolved(solid.outline())
        else:
            upright = work / f'{solid.name}.ply'
            options.quench_with('sample', solid.name, '--fineness', options.fineness, '-o', upright)
            points, triangles = read_ply(upright)
            upright.unlink()
        write_ply(mesh, points @ turn.T, triangles)
    folder = work / f'{mesh.stem}-{resolution}-{surface}'
    start = time.time()
    options.quench_with('run', mesh, '--resolution', resolution, '--surface', surface, '--no-view', '-o', folder)
    seconds = time.time() - start

    data, points, arrays = read_axis(folder / 'core.vtp')
    voxel = data.GetFieldData().GetArray('spacing').GetValue(0)
    local = points @ turn
    away = solid.to_axis(local) / voxel
    error = (arrays['radius'] - solid.depth(local)) / voxel
    axis, caps = solid.samples(voxel / 2 if solid.length else max(voxel, 0.006))
    reached = to_cells(axis[caps > voxel] @ turn.T, data) / voxel

    _, bones, of_bones = read_axis(folder / 'skeleton.vtp')
    bones = bones @ turn
    bone_error = (of_bones['radius'] - solid.depth(bones)) / voxel

    length, thickness = '', ''
    if solid.length:
        options.quench_with('skeleton', folder / 'core.vtp', '--theta2', 'inf', '--csv', folder / 'pure.csv', '-o',
                            folder / 'pure.vtp')
        with open(folder / 'pure.csv', newline='') as file:
            lengths = [float(branch['length']) for branch in csv.DictReader(file)]
        length = f'{(sum(lengths) - solid.length) / voxel:+.2f} ({len(lengths)})'
    if solid.thickness:
        if solid.length:
            _, places, found = read_axis(folder / 'pure.vtp')
            places, values = places @ turn, found['curve_erosion_thickness']
        else:
            near = np.flatnonzero(away < 1)
            near = np.random.default_rng(0).permutation(near)[:3000]
            places, values = local[near], arrays['erosion_thickness'][near]
        thickness = f'{np.nanmax(np.abs(values - solid.thickness(places))) / voxel:.2f}'
    cells = [solid.name, resolution, surface, len(points),
             f'{away.mean():.3f}', f'{np.quantile(away, 0.99):.2f}', f'{away.max():.2f}',
             f'{reached.mean():.3f}', f'{reached.max():.2f}', f'{np.abs(error).mean():.3f} ({error.mean():+.3f})',
             f'{solid.to_axis(bones).mean() / voxel:.3f}', f'{np.abs(bone_error).mean():.3f}', length, thickness]
    if options.seconds:
        cells.append(f'{seconds:.1f}')
    print('| ' + ' | '.join(map(str, cells)) + ' |', flush=True)


def main():
    words = lambda text: text.split(',')
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--quench', default='build/release/cli/quench')
    parser.add_argument('--solids', type=words, default=list(SOLIDS))
    parser.add_argument('--resolutions', type=words, default=words('64,128,256,512'))
    parser.add_argument('--surfaces', type=words, default=words('mesh,voxels'))
    parser.add_argument('--fineness', type=float, default=2, help='of the samples')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_surface_convergence')
    parser.add_argument('--seconds', action='store_true')
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    options.quench_with = lambda *arguments: subprocess.run(
        [options.quench, *map(str, arguments), '--quiet', '--overwrite', '--threads', '1'], check=True)
    head = ['solid', 'R', 'surface', 'vertices', 'core to axis: mean', '99 %', 'largest', 'axis to core: mean',
            'largest', 'radius', 'skeleton to axis', 'its radius', 'length', 'ET'] + ['seconds'] * options.seconds
    print('| ' + ' | '.join(head) + ' |\n|' + '---|' * len(head))
    for name in options.solids:
        turn = Rotation.random(random_state=options.seed + 100 * list(SOLIDS).index(name)).as_matrix() \
            if options.seed else np.eye(3)
        for resolution in options.resolutions:
            for surface in options.surfaces:
                row(options, SOLIDS[name], resolution, surface, turn)


if __name__ == '__main__':
    main()
