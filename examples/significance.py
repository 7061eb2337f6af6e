#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares measures of significance on one medial axis (Yan 2018, sec. 3.5): what is left of it above a threshold.

usage: significance.py AXIS.vtp [--keep SHARE] [--clean CLEAN.vtp] [--surface MESH.ply|.off]
                       [--box NAME X0 X1 Y0 Y1 Z0 Z1]... [--out PREFIX] [--json FILE]

AXIS is a core that 'quench core --measures all' wrote: its measures are compared. Of one without `circumradius` it is the
radius, of a burned one without `core_erosion_thickness` its erosion thickness, of a polygon the smallest of its corners.
Each is thresholded where the polygons at or above it have a share SHARE (default 0.2) of the area. Prints one row of a
Markdown table per measure:

  kept        share of the area that is kept; more than SHARE where many polygons have exactly the value
  components  pieces of what is kept (polygons that share a corner hang together); islands: those below 1 % of its area
  outside     share of the kept area outside of the largest piece
  noise       --clean: share of the kept area farther than 2 voxels from the axis of the shape without noise
  features    --clean: share of the area of that axis within 2 voxels of what is kept
  surface     --surface: share of the area of the mesh within 1 % of its longest side of a kept ball
  tips        --surface: how many tips of the mesh a kept ball comes within 3 % of its longest side of. Tips are the
              vertices farthest from the vertex nearest to the centroid, along edges, of all vertices within 8 % of it
  NAME        --box: share of the area inside that box (world coordinates) that is kept

--out writes what each measure keeps to PREFIX_MEASURE.vtp, --json the rows. Needs Debian's python3-numpy, python3-scipy,
python3-vtk9."""
import argparse
import json

import numpy as np
import vtk
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree
from vtk.util.numpy_support import vtk_to_numpy

BIG = 3.4e38  # files have it for infinity


class Axis:
    """The polygons of a medial axis: corners in `index`, from offsets[p] to offsets[p + 1]."""

    def __init__(self, file):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(file)
        reader.Update()
        self.data = reader.GetOutput()
        polys = self.data.GetPolys()
        if polys.GetNumberOfCells() == 0:
            raise SystemExit(f'{file} has no polygons, or is no .vtp file')
        self.points = vtk_to_numpy(self.data.GetPoints().GetData()).astype(float)
        self.offsets = vtk_to_numpy(polys.GetOffsetsArray()).astype(np.int64)
        self.index = vtk_to_numpy(polys.GetConnectivityArray()).astype(np.int64)
        self.count = len(self.offsets) - 1
        self.first_cell = self.data.GetNumberOfVerts() + self.data.GetNumberOfLines()
        self.polygon = np.repeat(np.arange(self.count), np.diff(self.offsets))
        self.triangles, self.owner = self.fans()
        corner = self.points[self.triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.triangle_area = np.linalg.norm(normal, axis=1) / 2
        self.area = np.bincount(self.owner, self.triangle_area, self.count)

    def fans(self):
        triangles, owner = [], []
        sizes = np.diff(self.offsets)
        for size in range(3, sizes.max() + 1):
            of_size = np.flatnonzero(sizes >= size)  # the fan triangle that ends at corner `size` of each
            start = self.offsets[of_size]
            triangles.append(np.stack([self.index[start], self.index[start + size - 2], self.index[start + size - 1]], 1))
            owner.append(of_size)
        return np.concatenate(triangles), np.concatenate(owner)

    def voxel(self):
        return vtk_to_numpy(self.data.GetFieldData().GetArray('spacing')).min()

    def point_array(self, name):
        array = self.data.GetPointData().GetArray(name)
        if array is None:
            raise SystemExit(f'there is no point array {name}; burn the medial axis first (quench burn)')
        return vtk_to_numpy(array).astype(float)

    def measures(self):
        """The names of what there is to compare."""
        texts = self.data.GetFieldData().GetAbstractArray('measures')
        names = [texts.GetValue(i) for i in range(texts.GetNumberOfValues())] if texts else []
        if 'circumradius' not in names:
            names.append('radius')
        if 'core_erosion_thickness' not in names and self.data.GetPointData().GetArray('burn_time'):
            names.append('erosion_thickness')
        return names

    def measure(self, name):
        """One value per polygon."""
        if name not in ('radius', 'erosion_thickness'):
            array = self.data.GetCellData().GetArray(name)
            if array is None:
                raise SystemExit(f'there is no cell array {name}')
            values = vtk_to_numpy(array)[self.first_cell:self.first_cell + self.count].astype(float)
            return np.where(values >= BIG, np.inf, values)
        values = self.point_array(name)
        if name == 'erosion_thickness':
            values[self.point_array('unburned') == 1] = np.inf
        return np.minimum.reduceat(values[self.index], self.offsets[:-1])

    def inside(self, box):
        """The polygons whose corners are all in a box."""
        corners = self.points[self.index]
        return np.logical_and.reduceat(((corners >= box[:, 0]) & (corners <= box[:, 1])).all(axis=1), self.offsets[:-1])

    def samples(self, kept, step):
        """Points on the kept polygons, no farther than about `step` apart, and the area each stands for."""
        chosen = kept[self.owner]
        corner, area = self.points[self.triangles[chosen]], self.triangle_area[chosen]
        longest = np.max([np.linalg.norm(corner[:, i] - corner[:, i - 1], axis=1) for i in range(3)], axis=0)
        parts = np.maximum(1, np.ceil(longest / step)).astype(int)
        places, areas = [], []
        for n in np.unique(parts):
            of_n = parts == n
            weights = [((i + s) / n, (j + s) / n) for s, last in ((1 / 3, n), (2 / 3, n - 1))
                       for i in range(last) for j in range(last - i)]
            for a, b in weights:
                c = corner[of_n]
                places.append(c[:, 0] + a * (c[:, 1] - c[:, 0]) + b * (c[:, 2] - c[:, 0]))
                areas.append(area[of_n] / len(weights))
        return np.concatenate(places), np.concatenate(areas)

    def pieces(self, kept):
        """Area of each connected piece of the kept polygons."""
        rows, numbers = np.unique(self.index[kept[self.polygon]], return_inverse=True)
        names = np.cumsum(kept) - 1
        polygons = names[self.polygon[kept[self.polygon]]]
        n = kept.sum()
        joined = coo_matrix((np.ones(len(numbers)), (polygons, n + numbers)), shape=(n + len(rows), n + len(rows)))
        piece = connected_components(joined, directed=False)[1][:n]
        return np.bincount(piece, self.area[kept])

    def lines(self):
        """The ends of the lines, and their rows in cell arrays."""
        lines, first = self.data.GetLines(), self.data.GetNumberOfVerts()
        ends = np.zeros((0, 2), np.int64)
        if lines.GetNumberOfCells() > 0:
            ends = vtk_to_numpy(lines.GetConnectivityArray()).reshape(-1, 2).astype(np.int64)
        return ends, np.arange(first, first + len(ends))

    def balls(self, kept):
        rows = np.unique(self.index[kept[self.polygon]])
        return self.points[rows], self.point_array('radius')[rows]

    def write(self, kept, file):
        ids = vtk.vtkIdTypeArray()
        for cell in np.flatnonzero(kept) + self.first_cell:
            ids.InsertNextValue(int(cell))
        node = vtk.vtkSelectionNode()
        node.SetFieldType(vtk.vtkSelectionNode.CELL)
        node.SetContentType(vtk.vtkSelectionNode.INDICES)
        node.SetSelectionList(ids)
        selection = vtk.vtkSelection()
        selection.AddNode(node)
        extract = vtk.vtkExtractSelection()
        extract.SetInputData(0, self.data)
        extract.SetInputData(1, selection)
        surface = vtk.vtkGeometryFilter()
        surface.SetInputConnection(extract.GetOutputPort())
        writer = vtk.vtkXMLPolyDataWriter()
        writer.SetInputConnection(surface.GetOutputPort())
        writer.SetFileName(file)
        writer.Write()


class Surface:
    """A closed mesh and its tips."""

    def __init__(self, file):
        if file.lower().endswith('.ply'):
            reader = vtk.vtkPLYReader()
            reader.SetFileName(file)
            reader.Update()
            self.points = vtk_to_numpy(reader.GetOutput().GetPoints().GetData()).astype(float)
            faces = vtk_to_numpy(reader.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)
        else:
            words = [w for line in open(file) for w in line.split('#')[0].split()]
            n, m = int(words[1]), int(words[2])
            self.points = np.array(words[4:4 + 3 * n], float).reshape(n, 3)
            faces = np.array(words[4 + 3 * n:4 + 3 * n + 4 * m], np.int64).reshape(m, 4)[:, 1:]
        self.side = np.ptp(self.points, axis=0).max()
        corner = self.points[faces]
        area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1) / 2
        self.area = sum(np.bincount(faces[:, i], area / 3, len(self.points)) for i in range(3))
        a, b = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).T
        length = np.linalg.norm(self.points[a] - self.points[b], axis=1)
        edges = coo_matrix((length, (a, b)), shape=(len(self.points),) * 2).tocsr()
        edges = edges.maximum(edges.T)
        centre = np.average(self.points, axis=0, weights=self.area)
        far = dijkstra(edges, indices=cKDTree(self.points).query(centre)[1])
        far[~np.isfinite(far)] = -1
        tree, self.tips, left = cKDTree(self.points), [], far.copy()
        for v in np.argsort(-far):  # from the farthest: whoever is near a farther vertex is no tip
            around = tree.query_ball_point(self.points[v], 0.08 * self.side) if left[v] >= 0 else []
            if len(around) and far[v] == far[around].max():
                self.tips.append(v)
            left[around] = -1

    def gaps(self, centres, radii):
        """Distance of each vertex from the nearest ball, 0 inside."""
        # The nearest ball by power distance is the nearest point in four dimensions; the nearest itself is among the first.
        lifted = np.column_stack([centres, np.sqrt(np.maximum(0, radii.max() ** 2 - radii ** 2))])
        k = min(16, len(radii))
        found = cKDTree(lifted).query(np.column_stack([self.points, np.zeros(len(self.points))]), k=k)[1].reshape(-1, k)
        distance = np.linalg.norm(self.points[:, None] - centres[found], axis=2) - radii[found]
        return np.maximum(0, distance.min(axis=1))


def within(points, others, reach):
    """Which points have one of the others no farther than `reach`."""
    tree = cKDTree(others, balanced_tree=False)  # medians are slow where most coordinates are equal, as on a lattice
    return np.isfinite(tree.query(points, distance_upper_bound=reach)[0])


def threshold_for(values, area, share):
    """The largest threshold whose polygons have at least this share of the area."""
    order = np.argsort(-values, kind='stable')
    reached = np.searchsorted(np.cumsum(area[order]), share * area.sum() * (1 - 1e-12))
    return values[order[min(reached, len(order) - 1)]]


def share(value):
    return f'{100 * value:.1f} %'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('axis')
    parser.add_argument('--keep', type=float, default=0.2)
    parser.add_argument('--clean')
    parser.add_argument('--surface')
    parser.add_argument('--box', nargs=7, action='append', default=[])
    parser.add_argument('--out')
    parser.add_argument('--json')
    options = parser.parse_args()
    axis = Axis(options.axis)
    clean = Axis(options.clean) if options.clean else None
    if clean:
        theirs, theirs_area = clean.samples(np.ones(clean.count, bool), axis.voxel())
    boxes = {box[0]: axis.inside(np.array(box[1:], float).reshape(3, 2)) for box in options.box}
    surface = Surface(options.surface) if options.surface else None

    rows = []
    for name in axis.measures():
        values = axis.measure(name)
        threshold = threshold_for(values, axis.area, options.keep)
        kept = values >= threshold
        pieces = axis.pieces(kept)
        small = pieces < 0.01 * pieces.sum()
        row = {'measure': name, 'threshold': threshold, 'kept': pieces.sum() / axis.area.sum(), 'components': len(pieces),
               'islands': int(small.sum()), 'area in islands': pieces[small].sum() / pieces.sum(),
               'outside': 1 - pieces.max() / pieces.sum()}
        if clean:
            ours, ours_area = axis.samples(kept, axis.voxel())
            row['noise'] = ours_area[~within(ours, theirs, 2 * axis.voxel())].sum() / ours_area.sum()
            row['features'] = theirs_area[within(theirs, ours, 2 * axis.voxel())].sum() / theirs_area.sum()
        if surface:
            gaps = surface.gaps(*axis.balls(kept))
            row['surface'] = surface.area[gaps <= 0.01 * surface.side].sum() / surface.area.sum()
            row['tips'] = [int((gaps[surface.tips] <= 0.03 * surface.side).sum()), len(surface.tips)]
        for box, inside in boxes.items():
            row[box] = axis.area[inside & kept].sum() / axis.area[inside].sum()
        if not rows:
            print('| ' + ' | '.join(row) + ' |\n' + '|---' * len(row) + '|')
        rows.append(row)
        print('| ' + ' | '.join(name if key == 'measure' else f'{value:.4g}' if key == 'threshold' else f'{value}'
                                if isinstance(value, int) else f'{value[0]} of {value[1]}' if key == 'tips' else share(value)
                                for key, value in row.items()) + ' |', flush=True)
        if options.out:
            axis.write(kept, f'{options.out}_{name}.vtp')
    if options.json:
        with open(options.json, 'w') as file:
            json.dump(rows, file, indent=1)


if __name__ == '__main__':
    main()
