#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Three methods that take the medial axis from samples of the surface, as published, written anew for comparison; not the programs of
their authors, of which nothing is used here. figure_2_10.py draws them, check_peers.py tests them on shapes with known answers.

dey_zhao      T. K. Dey, W. Zhao, Approximating the medial axis from the Voronoi diagram with a convergence guarantee, Algorithmica 38
              (2004): Voronoi faces whose dual edge pq stands steeply on the umbrella of p (angle condition, theta = pi/8) or is long
              beside its triangles (ratio condition, rho = 8).
power_shape   N. Amenta, S. Choi, R. K. Kolluri, The power crust, 2001: all simplices of the regular triangulation of the poles whose
              corners are inner poles.
scale_axis    B. Miklos, J. Giesen, M. Pauly, Discrete scale axis representations for 3D geometry, 2010: the inner polar balls, grown by
              s, and the dual shape of their union (alpha complex at 0), which has its topology. In place of their last step, the medial
              axis of the union by cutting a Voronoi diagram with the solid cells of the dual shape (Amenta and Kolluri), these cells
              are collapsed, from outside to inside, until none is left: as thin, the same topology, and nowhere farther away than the
              cells are thick.
inner_voronoi What the same gives for s = 1 from all inner Voronoi balls: the part of the Voronoi diagram with inner vertices.

Whether a Voronoi vertex is inside is asked of the mesh: that is generous to all, which find out by themselves. Samples are
moved by 1e-6 of the longest side at random, so that no five are on a sphere. Polygons are kept once each and share their corners, so
there are no duplicates by construction; what programs write may have them.

usage: sampled_axes.py METHOD[=s] MESH.ply OUT.npz"""
import collections
import json
import sys
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, Delaunay, cKDTree

PAIRS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
NEAR = 1e-4  # of the longest side: balls nearer than this are one
TRIPLES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])  # opposite to corners 0 to 3


def length(vectors):
    return np.sqrt(np.einsum('...i,...i', vectors, vectors))


def dot(a, b):
    return np.einsum('...i,...i', a, b)


def parts(count, a, b):
    """Number of connected parts and the part of each of `count` things, joined in pairs."""
    return connected_components(coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(count, count)), directed=False)


class Simplices:
    """Tetrahedra of a triangulation with their triangles and edges: `triangle_of`, `edge_of` per tetrahedron; `sides`: the two
    tetrahedra of a triangle, -1 outside."""

    def __init__(self, tetrahedra, count):
        self.tetrahedra, self.count = np.sort(tetrahedra, axis=1).astype(np.int64), count
        triples = self.tetrahedra[:, TRIPLES].reshape(-1, 3)
        key = (triples[:, 0] * count + triples[:, 1]) * count + triples[:, 2]
        _, first, at = np.unique(key, return_index=True, return_inverse=True)
        self.triangles, self.triangle_of = triples[first], at.reshape(-1, 4)
        pairs = self.tetrahedra[:, PAIRS].reshape(-1, 2)
        _, first, at = np.unique(pairs[:, 0] * count + pairs[:, 1], return_index=True, return_inverse=True)
        self.edges, self.edge_of = pairs[first], at.reshape(-1, 6)
        order = np.argsort(self.triangle_of.ravel(), kind='stable')
        self.sides = np.full((len(self.triangles), 2), -1)
        owner = self.triangle_of.ravel()[order]
        start = np.ones(len(owner), bool)
        start[1:] = owner[1:] != owner[:-1]
        self.sides[owner[start], 0] = order[start] // 4
        self.sides[owner[~start], 1] = order[~start] // 4
        assert np.bincount(owner).max() <= 2

    def edges_of_triangles(self):
        t, n = self.triangles, self.count
        key = self.edges[:, 0] * n + self.edges[:, 1]
        return np.stack([np.searchsorted(key, t[:, i] * n + t[:, k]) for i, k in ((0, 1), (0, 2), (1, 2))], 1)


class Sample:
    """The Delaunay triangulation of samples, with eight points of a box five times as large around them (as in the power crust):
    `centres` and `radii` of the Voronoi balls, which are `inner` by `inside(points)`. The samples are the first `n` points."""

    def __init__(self, points, inside, seed=1):
        low, high = points.min(0), points.max(0)
        self.size, self.n = (high - low).max(), len(points)
        self.middle = (low + high) / 2
        scaled = (points - self.middle) / self.size + np.random.default_rng(seed).normal(size=points.shape) * 1e-6
        corners = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * 2.5
        self.points = np.concatenate([scaled, corners + np.random.default_rng(2).normal(size=corners.shape) * 1e-3])
        found = Delaunay(self.points)
        assert not len(found.coplanar)
        self.cells = Simplices(found.simplices, len(self.points))
        a, b, c, d = (self.points[self.cells.tetrahedra[:, i]] for i in range(4))
        b, c, d = b - a, c - a, d - a
        top = dot(b, b)[:, None] * np.cross(c, d) + dot(c, c)[:, None] * np.cross(d, b) + dot(d, d)[:, None] * np.cross(b, c)
        with np.errstate(divide='ignore', invalid='ignore'):
            away = top / (2 * dot(b, np.cross(c, d)))[:, None]
        away[~np.isfinite(away).all(1)] = 1e9
        self.centres, self.radii = a + away, length(away)
        self.inner = (np.abs(self.centres) < 0.6).all(1)
        self.inner[self.inner] = inside(self.centres[self.inner] * self.size + self.middle)

    def poles(self):
        """Per sample the farthest vertex of its Voronoi cell, and the farthest on the other side."""
        flat = self.cells.tetrahedra.ravel()
        cell = np.repeat(np.arange(len(self.centres)), 4)
        order = np.lexsort((self.radii[cell], flat))
        flat, cell = flat[order], cell[order]
        last = np.flatnonzero(np.append(flat[1:] != flat[:-1], True))
        first = cell[last][:self.n]
        way = self.centres[first] - self.points[:self.n]
        kept = flat < self.n
        flat, cell = flat[kept], cell[kept]
        other = dot(self.centres[cell] - self.points[flat], way[flat]) < 0
        flat, cell = flat[other], cell[other]
        last = np.flatnonzero(np.append(flat[1:] != flat[:-1], True))
        second = np.full(self.n, -1)
        second[flat[last]] = cell[last]
        return first, second, way / length(way)[:, None]


class Axis:
    """A complex: `points`, polygons as `offsets` and `corners`, `lines` that no polygon has; numbers of vertices, edges, faces and
    solid cells; components, cavities of the complex with its solids, and pockets: closed spaces between its faces, solids among
    them, since a file of faces shows a solid by its hull."""

    def __init__(self, points, offsets, corners, lines, vertices, edges, faces, solids, components, cavities):
        self.points, self.offsets, self.corners, self.lines = points, offsets, corners, lines
        self.vertices, self.edges, self.faces, self.solids = map(int, (vertices, edges, faces, solids))
        self.components, self.pockets = int(components), int(cavities + solids)
        self.euler = self.vertices - self.edges + self.faces  # of the faces
        self.tunnels = self.components + self.pockets - self.euler
        self.solid_betti = (self.components, self.components + int(cavities) - (self.euler - self.solids), int(cavities))

    def sheets(self):
        return Sheets(self.points, self.offsets, self.corners, self.lines)

    def numbers(self):
        return {name: getattr(self, name) for name in
                ('vertices', 'edges', 'faces', 'solids', 'components', 'tunnels', 'pockets', 'euler', 'solid_betti')}

    def save(self, file):
        np.savez(file, points=self.points, offsets=self.offsets, corners=self.corners, lines=self.lines,
                 numbers=json.dumps(self.numbers()))


def voronoi_part(sample, faces, edges, vertices):
    """The closure of Voronoi faces, edges, vertices (masks of Delaunay edges, triangles, tetrahedra) as an Axis. Pockets by duality:
    the parts into which the complex cuts space are Voronoi cells joined through faces that are missing."""
    cells = sample.cells
    from_faces = np.zeros(len(cells.triangles), bool)
    from_faces[faces[cells.edges_of_triangles()].any(1)] = True
    edges = edges | from_faces
    assert (cells.sides[edges] >= 0).all()
    vertices = vertices.copy()
    vertices[cells.sides[edges].ravel()] = True
    name = np.cumsum(vertices) - 1
    joined = name[cells.sides[edges]]
    components = parts(vertices.sum(), joined[:, 0], joined[:, 1])[0]
    open_ = cells.edges[~faces]
    pockets = parts(cells.count, open_[:, 0], open_[:, 1])[0] - 1
    # The corners of a face in the order of their angle around its Delaunay edge.
    used = faces[cells.edge_of]
    cell, corner = np.nonzero(used)
    face = cells.edge_of[cell, corner]
    axis = sample.points[cells.edges[face, 1]] - sample.points[cells.edges[face, 0]]
    axis /= length(axis)[:, None]
    across = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    u = np.cross(axis, across)
    u /= length(u)[:, None]
    v = np.cross(axis, u)
    size = np.bincount(face, minlength=len(cells.edges))
    centre = np.stack([np.bincount(face, sample.centres[cell, i], len(cells.edges)) for i in range(3)], 1)[face] / size[face][:, None]
    away = sample.centres[cell] - centre
    order = np.lexsort((np.arctan2(dot(away, v), dot(away, u)), face))
    return Axis(sample.centres[vertices] * sample.size + sample.middle, np.concatenate([[0], np.cumsum(size[faces])]),
                name[cell[order]], name[cells.sides[edges & ~from_faces]], vertices.sum(), edges.sum(), faces.sum(), 0, components, pockets)


def dey_zhao(sample, theta=np.pi / 8, rho=8):
    cells, n, points = sample.cells, sample.n, sample.points
    _, _, normal = sample.poles()
    # Umbrellas: triangles at p whose Voronoi edge crosses the plane through p across the direction of its pole.
    between = (cells.sides >= 0).all(1)
    triangle, corner = np.nonzero(between[:, None] & (cells.triangles < n))
    p = cells.triangles[triangle, corner]
    ends = cells.sides[triangle]
    crosses = dot(sample.centres[ends[:, 0]] - points[p], normal[p]) * dot(sample.centres[ends[:, 1]] - points[p], normal[p]) < 0
    triangle, p = triangle[crosses], p[crosses]
    order = np.argsort(p, kind='stable')
    triangle, p = triangle[order], p[order]
    start = np.searchsorted(p, np.arange(n + 1))
    a, b, c = (points[cells.triangles[triangle, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    twice = length(cross)
    upright = cross / twice[:, None]
    circle = length(b - a) * length(c - b) * length(a - c) / (2 * twice)
    kept = np.zeros(len(cells.edges), bool)
    sampled = (cells.edges < n).all(1)
    of_triangle = cells.edges_of_triangles()[triangle]
    for side in (0, 1):
        edge = np.flatnonzero(sampled)
        at = cells.edges[edge, side]
        count = start[at + 1] - start[at]
        edge, at, count = edge[count > 0], at[count > 0], count[count > 0]
        which = np.repeat(start[at] - np.cumsum(count) + count, count) + np.arange(count.sum())
        pq = points[cells.edges[edge, 1]] - points[cells.edges[edge, 0]]
        far = length(pq)
        cosine = np.abs(dot(np.repeat(pq / far[:, None], count, axis=0), upright[which]))
        first = np.cumsum(count) - count
        inside_umbrella = np.add.reduceat((of_triangle[which] == np.repeat(edge, count)[:, None]).any(1), first) > 0
        steep = np.minimum.reduceat(cosine, first) > np.sin(theta)
        long_ = far > rho * np.maximum.reduceat(circle[which], first)
        kept[edge[~inside_umbrella & (steep | long_)]] = True
    return voronoi_part(sample, kept & inner_faces(sample), *nothing(sample))


def inner_faces(sample):
    """Voronoi faces with inner vertices only."""
    cells = sample.cells
    inner = np.ones(len(cells.edges), bool)
    inner[cells.edge_of[~sample.inner].ravel()] = False
    return inner


def nothing(sample):
    return np.zeros(len(sample.cells.triangles), bool), np.zeros(len(sample.centres), bool)


def regular_triangulation(points, radii):
    """Tetrahedra of the regular triangulation of balls, by the lower hull in one dimension more (Qhull, joggled where it must be)."""
    lifted = np.column_stack([points, dot(points, points) - radii ** 2])
    hull = ConvexHull(lifted, qhull_options='QJ')
    return Simplices(hull.simplices[hull.equations[:, 3] < 0], len(points))


def simplicial_part(points, cells, corners, edges, triangles, tetrahedra):
    """The Axis of a subcomplex, given by masks, of a triangulation."""
    pair = cells.edges[edges]
    joined = parts(cells.count, pair[:, 0], pair[:, 1])[1]
    components = len(np.unique(joined[corners]))
    outside = len(cells.tetrahedra)
    open_ = np.where(cells.sides < 0, outside, cells.sides)[~triangles]
    space = parts(outside + 1, open_[:, 0], open_[:, 1])[1]
    cavities = len(np.unique(space[np.append(~tetrahedra, True)])) - 1
    name = np.cumsum(corners) - 1
    lone = edges.copy()
    lone[cells.edges_of_triangles()[triangles].ravel()] = False
    return Axis(points[corners], np.arange(triangles.sum() + 1) * 3, name[cells.triangles[triangles]].ravel(),
                name[cells.edges[lone]], corners.sum(), edges.sum(), triangles.sum(), tetrahedra.sum(), components, cavities)


def power_shape(sample):
    first, second, _ = sample.poles()
    poles = np.unique(np.concatenate([first, second[second >= 0]]))
    poles = poles[sample.radii[poles] < 1e3]
    cells = regular_triangulation(sample.centres[poles], sample.radii[poles])
    inner = sample.inner[poles]
    corners = np.zeros(len(poles), bool)
    corners[cells.tetrahedra.ravel()] = True  # others are hidden
    return simplicial_part(sample.centres[poles] * sample.size + sample.middle, cells, corners & inner, inner[cells.edges].all(1),
                           inner[cells.triangles].all(1), inner[cells.tetrahedra].all(1))


def orthocentre(points, weights, simplices):
    """Centre of the smallest sphere orthogonal to the balls of each simplex, and its power."""
    base = points[simplices[:, 0]]
    ways = points[simplices[:, 1:]] - base[:, None]
    right = (dot(ways, ways) - weights[simplices[:, 1:]] + weights[simplices[:, :1]]) / 2
    gram = np.einsum('nik,njk->nij', ways, ways)
    gram += np.eye(gram.shape[1]) * 1e-15 * np.trace(gram, axis1=1, axis2=2)[:, None, None]
    away = np.einsum('nik,ni->nk', ways, np.linalg.solve(gram, right[..., None])[..., 0])
    return base + away, dot(away, away) - weights[simplices[:, 0]]


def dual_shape(points, radii):
    """The alpha complex at 0 of balls: simplices whose dual face of the power diagram meets the union."""
    weights = radii ** 2
    cells = regular_triangulation(points, radii)
    power = lambda centre, ball: dot(centre - points[ball], centre - points[ball]) - weights[ball]
    _, value = orthocentre(points, weights, cells.tetrahedra)
    tetrahedra = value < 0
    # A face of a simplex is in if its own sphere is free of the balls beside it and of negative power, or the simplex is in.
    centre, value = orthocentre(points, weights, cells.triangles)
    free = np.ones(len(cells.triangles), bool)
    within = np.zeros(len(cells.triangles), bool)
    for k in range(4):
        face = cells.triangle_of[:, k]
        free[face[power(centre[face], cells.tetrahedra[:, k]) < value[face]]] = False
        within[face[tetrahedra]] = True
    triangles = within | (free & (value < 0))
    of_triangle = cells.edges_of_triangles()
    centre, value = orthocentre(points, weights, cells.edges)
    free = np.ones(len(cells.edges), bool)
    within = np.zeros(len(cells.edges), bool)
    for k, third in enumerate((2, 1, 0)):
        edge = of_triangle[:, k]
        free[edge[power(centre[edge], cells.triangles[:, third]) < value[edge]]] = False
        within[edge[triangles]] = True
    edges = within | (free & (value < 0))
    shown = np.zeros(len(points), bool)
    shown[cells.tetrahedra.ravel()] = True
    free, within = shown.copy(), np.zeros(len(points), bool)
    for k in (0, 1):
        end, other = cells.edges[:, k], cells.edges[:, 1 - k]
        free[end[power(points[end], other) < -weights[end]]] = False
        within[end[edges]] = True
    return cells, within | free, edges, triangles, tetrahedra


def collapsed(cells, triangles, tetrahedra):
    """The triangles that are left when every tetrahedron has gone through one of its triangles that no other has."""
    solid, left = tetrahedra.copy(), triangles.copy()
    sides, of = cells.sides.tolist(), cells.triangle_of.tolist()
    around = (np.append(solid, False)[cells.sides]).sum(1)
    queue = collections.deque(np.flatnonzero(left & (around == 1)).tolist())
    while queue:
        t = queue.popleft()
        through = [c for c in sides[t] if c >= 0 and solid[c]]
        if len(through) != 1:
            continue
        left[t] = solid[through[0]] = False
        queue.extend(other for other in of[through[0]] if left[other] and sum(c >= 0 and solid[c] for c in sides[other]) == 1)
    assert not solid.any()
    return left


def scale_axis(sample, s=1.0):
    first, second, _ = sample.poles()
    poles = np.unique(np.concatenate([first, second[second >= 0]]))
    poles = poles[sample.inner[poles]]
    _, one = np.unique(np.floor(sample.centres[poles] / NEAR), axis=0, return_index=True)  # of balls at one place, one
    points, radii = sample.centres[poles[one]], sample.radii[poles[one]]
    cells, corners, edges, triangles, tetrahedra = dual_shape(points, radii * s)
    return simplicial_part(points * sample.size + sample.middle, cells, corners, edges, collapsed(cells, triangles, tetrahedra),
                           np.zeros_like(tetrahedra))


def inner_voronoi(sample):
    edges = (sample.cells.sides >= 0).all(1) & sample.inner[sample.cells.sides].all(1)
    return voronoi_part(sample, inner_faces(sample), edges, sample.inner)


METHODS = {'dey_zhao': dey_zhao, 'power_shape': power_shape, 'inner_voronoi': inner_voronoi}


def axis(method, sample):
    name, _, s = method.partition('=')
    return scale_axis(sample, float(s or 1)) if name == 'scale_axis' else METHODS[name](sample)


class Sheets:
    """Polygons and lines as something to measure distances to, and to take points from."""

    def __init__(self, points, offsets, corners, lines):
        size = np.diff(offsets)
        which = np.repeat(np.arange(len(size)), np.maximum(size - 2, 0))
        number = np.arange(len(which)) - np.repeat(np.cumsum(np.maximum(size - 2, 0)) - np.maximum(size - 2, 0), np.maximum(size - 2, 0))
        first = offsets[:-1][which]
        self.triangles = points[np.stack([corners[first], corners[first + number + 1], corners[first + number + 2]], 1)]
        a, b = points[lines[:, 0]], points[lines[:, 1]]
        self.on_lines = (a[:, None] + (b - a)[:, None] * np.linspace(0, 1, 9)[:, None]).reshape(-1, 3)

    def take(self, count, seed=1):
        """Points, even by area; points of the lines where there are no polygons."""
        random = np.random.default_rng(seed)
        area = length(np.cross(self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 0]))
        if not area.sum():
            return self.on_lines
        t = self.triangles[random.choice(len(area), count, p=area / area.sum())]
        u, v = random.random((2, count))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        return t[:, 0] + u[:, None] * (t[:, 1] - t[:, 0]) + v[:, None] * (t[:, 2] - t[:, 0])

    def distances(self, points):
        import vtk
        from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
        found = np.full(len(points), np.inf)
        if len(self.on_lines):
            found = cKDTree(self.on_lines).query(points)[0]
        if len(self.triangles):
            data, places, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
            places.SetData(numpy_to_vtk(np.ascontiguousarray(self.triangles.reshape(-1, 3)), deep=True))
            cells.SetData(numpy_to_vtkIdTypeArray(np.arange(len(self.triangles) + 1) * 3, deep=True),
                          numpy_to_vtkIdTypeArray(np.arange(len(self.triangles) * 3), deep=True))
            data.SetPoints(places)
            data.SetPolys(cells)
            distance, values = vtk.vtkImplicitPolyDataDistance(), vtk.vtkDoubleArray()
            distance.SetInput(data)
            distance.FunctionValue(numpy_to_vtk(np.ascontiguousarray(points), deep=True), values)
            found = np.minimum(found, np.abs(vtk_to_numpy(values)))
        return found


def read_mesh(file):
    """Vertices of a PLY, and a function that says which points are inside its surface."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    reader = vtk.vtkPLYReader()
    reader.SetFileName(str(file))
    reader.Update()

    def inside(points):
        data, places, within = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkSelectEnclosedPoints()
        places.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
        data.SetPoints(places)
        within.SetInputData(data)
        within.SetSurfaceConnection(reader.GetOutputPort())
        within.SetTolerance(1e-9)
        within.Update()
        return vtk_to_numpy(within.GetOutput().GetPointData().GetArray('SelectedPoints')).astype(bool)

    return np.unique(vtk_to_numpy(reader.GetOutput().GetPoints().GetData()).astype(float), axis=0), inside


if __name__ == '__main__':
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    result = axis(sys.argv[1], Sample(*read_mesh(sys.argv[2])))
    result.save(Path(sys.argv[3]))
    print(json.dumps(result.numbers()))
