# SPDX-License-Identifier: Apache-2.0
"""What the scripts of bench/paper share: the program, its files, pictures of complexes, tables. Each script makes one
figure of Yan 2018 as a PNG and prints what the dissertation states of it beside what came out here.

Needs Debian's python3-numpy, -scipy, -matplotlib, -vtk9, and a display for VTK (xvfb)."""
import argparse
import gzip
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import matplotlib
import numpy as np
import vtk
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

matplotlib.use('Agg')
from matplotlib import pyplot as plt  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[2]
SIDE = (0.36, 0.56, 0.80)  # colour of sheets
CURVE = (0.75, 0.08, 0.10)


class Cost:
    """Processor seconds, wall seconds and peak memory of one run of the program."""

    def __init__(self, cpu, wall, megabytes):
        self.cpu, self.wall, self.megabytes = cpu, wall, megabytes


def measured(command):
    """Exit code, processor seconds and peak megabytes of a command. A small process starts it: the peak of a process that was
    split off from a large one begins with that of the large one."""
    starter = ('import os, subprocess, sys; p = subprocess.Popen(sys.argv[1:]); u = os.wait4(p.pid, 0); '
               'print(os.waitstatus_to_exitcode(u[1]), u[2].ru_utime + u[2].ru_stime, u[2].ru_maxrss / 1024)')
    said = subprocess.run([sys.executable, '-c', starter, *command], stdout=subprocess.PIPE, text=True, check=True).stdout
    code, cpu, megabytes = said.split()[-3:]
    return int(code), float(cpu), float(megabytes)


class Paper:
    def __init__(self, options):
        self.out, self.data, self.work, self.options = options.out, options.data, options.work, options
        self.program = str(options.quench)
        for folder in (self.out, self.work):
            folder.mkdir(parents=True, exist_ok=True)

    def quench(self, *arguments):
        """Runs the program; its cost. Its outputs are replaced."""
        command = [self.program, *map(str, arguments), '--quiet', '--overwrite', '--threads', str(self.options.threads)]
        start = time.monotonic()
        code, cpu, megabytes = measured(command)
        if code:
            raise SystemExit(f'{" ".join(command)} ended with code {code}')
        return Cost(cpu, time.monotonic() - start, megabytes)

    def file(self, name):
        return self.work / name

    def sample(self, name, *options, suffix='.ply'):
        file = self.file('_'.join([name, *(str(o).strip('-') for o in options)]) + suffix)
        if not file.exists():
            self.quench('sample', name, '-o', file, *options)
        return file

    def real(self, name):
        """A file of the real data beside the checkout, or None with a line that says what is missing."""
        if (self.data / name).exists():
            return self.data / name
        print(f'{name}: not in {self.data} (--data FOLDER)')
        return None

    def surface(self, mesh):
        """A mesh as VTK data."""
        if Path(mesh).suffix != '.ply':
            file = self.file(Path(mesh).stem + '_surface.ply')
            if not file.exists():
                self.quench('convert', mesh, file)
            mesh = file
        reader = vtk.vtkPLYReader()
        reader.SetFileName(str(mesh))
        reader.Update()
        return reader.GetOutput()

    def save(self, figure, name):
        file = self.out / f'figure_{name}.png'
        figure.savefig(file, dpi=150)
        plt.close(figure)
        print(f'\n-> {file.name}')


def main(make, description):
    """The command line of every script."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', type=Path, default=Path('figures'), help='folder for the PNG')
    parser.add_argument('--quench', type=Path, default=REPOSITORY / 'build/release/quench')
    parser.add_argument('--data', type=Path, default=REPOSITORY.parent / 'shared/data', help='the real data')
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / f'quench_paper_{os.getuid()}')
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--large', action='store_true', help='the resolutions of the dissertation where smaller are taken')
    make(Paper(parser.parse_args()))


def table(head, rows):
    print('| ' + ' | '.join(head) + ' |\n|' + '---|' * len(head))
    for row in rows:
        print('| ' + ' | '.join(f'{c:.4g}' if isinstance(c, float) else str(c) for c in row) + ' |', flush=True)


class Complex:
    """A file of Quench: `points`, polygons (`corners` from offsets[f] to offsets[f + 1]), `lines` as pairs of points,
    `at` and `faces`: arrays of points and polygons; `field`."""

    def __init__(self, file):
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(file))
        reader.Update()
        data = reader.GetOutput()
        self.points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
        self.offsets = vtk_to_numpy(data.GetPolys().GetOffsetsArray()).astype(np.int64)
        self.corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).astype(np.int64)
        if not len(self.offsets):
            self.offsets = np.zeros(1, np.int64)
        self.count = len(self.offsets) - 1
        offsets = vtk_to_numpy(data.GetLines().GetOffsetsArray()).astype(np.int64)
        chain = vtk_to_numpy(data.GetLines().GetConnectivityArray()).astype(np.int64)
        inner = np.ones(max(0, len(chain) - 1), bool)
        inner[offsets[1:-1] - 1] = False
        self.lines = np.stack([chain[:-1][inner], chain[1:][inner]], 1) if len(chain) else np.zeros((0, 2), np.int64)
        skipped = data.GetNumberOfVerts() + data.GetNumberOfLines()
        arrays = lambda part: {part.GetArrayName(i): vtk_to_numpy(part.GetArray(i))
                               for i in range(part.GetNumberOfArrays()) if part.GetArray(i)}
        self.at = arrays(data.GetPointData())
        cells = arrays(data.GetCellData())
        self.faces = {name: values[skipped:] for name, values in cells.items()}
        self.polylines = {name: values[data.GetNumberOfVerts():skipped] for name, values in cells.items()}
        self.line_cell = np.repeat(np.arange(len(offsets) - 1), np.maximum(0, np.diff(offsets) - 1)) if len(chain) else []
        self.field = arrays(data.GetFieldData())
        self.polygon = np.repeat(np.arange(self.count), np.diff(self.offsets))

    def betti(self):
        return tuple(int(b) for b in self.field['betti'].ravel())

    def only_curves(self):
        """Which lines are curves: edges without polygons."""
        return self.polylines['kind'][self.line_cell] == 1

    def areas(self):
        following = np.arange(1, len(self.corners) + 1)
        following[self.offsets[1:] - 1] = self.offsets[:-1]
        first = self.points[self.corners[np.repeat(self.offsets[:-1], np.diff(self.offsets))]]
        cross = np.cross(self.points[self.corners] - first, self.points[self.corners[following]] - first)
        return np.linalg.norm(np.add.reduceat(cross, self.offsets[:-1]), axis=1) / 2

    def least(self, values):
        """Of values at points, the least of each polygon's corners."""
        return np.minimum.reduceat(values[self.corners], self.offsets[:-1])

    def thickness(self):
        """Erosion thickness at the points, infinite on closed pockets."""
        values = self.at['erosion_thickness'].astype(float)
        values[self.at['unburned'] == 1] = np.inf
        return values

    def edges(self):
        """Edges of the polygons as pairs, and of each side of a polygon its edge."""
        following = np.arange(1, len(self.corners) + 1)
        following[self.offsets[1:] - 1] = self.offsets[:-1]
        pairs = np.sort(np.stack([self.corners, self.corners[following]], 1), axis=1)
        return np.unique(pairs, axis=0, return_inverse=True)

    def pieces(self, kept):
        """Areas of the connected pieces (by corners) of the polygons kept."""
        if not kept.any():
            return np.zeros(0)
        number = np.cumsum(kept) - 1
        chosen = kept[self.polygon]
        names, at = np.unique(self.corners[chosen], return_inverse=True)
        n = kept.sum()
        graph = coo_matrix((np.ones(len(at)), (number[self.polygon[chosen]], n + at)), shape=(n + len(names),) * 2)
        return np.bincount(connected_components(graph, directed=False)[1][:n], self.areas()[kept])

    def sheets(self, kept=None):
        """VTK data of the polygons that are kept."""
        kept = np.ones(self.count, bool) if kept is None else kept
        sizes = np.diff(self.offsets)[kept]
        return polydata(self.points, np.concatenate([[0], np.cumsum(sizes)]), self.corners[kept[self.polygon]])

    def curves(self, kept=None):
        lines = self.lines if kept is None else self.lines[kept]
        return polydata(self.points, None, None, lines)


def polydata(points, offsets=None, corners=None, lines=None):
    data = vtk.vtkPolyData()
    places = vtk.vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points, float), deep=True))
    data.SetPoints(places)

    def cells(offsets, corners):
        array = vtk.vtkCellArray()
        array.SetData(numpy_to_vtkIdTypeArray(np.ascontiguousarray(offsets, np.int64), deep=True),
                      numpy_to_vtkIdTypeArray(np.ascontiguousarray(corners, np.int64).ravel(), deep=True))
        return array

    if corners is not None:
        data.SetPolys(cells(offsets, corners))
    if lines is not None:
        data.SetLines(cells(np.arange(len(lines) + 1) * 2, lines))
    return data


def colours(values, low=None, high=None, name='turbo'):
    """RGB bytes of values; infinite ones dark."""
    finite = np.isfinite(values)
    low = values[finite].min() if low is None else low
    high = values[finite].max() if high is None else high
    scaled = np.clip((np.where(finite, values, high) - low) / max(high - low, 1e-30), 0, 1)
    rgb = (255 * matplotlib.colormaps[name](0.03 + 0.94 * scaled)[:, :3]).astype(np.uint8)
    rgb[~finite] = (90, 0, 40)
    return rgb


class Scene:
    """Things to draw, and a parallel camera that looks along a direction."""

    def __init__(self, direction=(-1, -2, -0.8), up=(0, 0, 1)):
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.renderer.SetUseDepthPeeling(1)
        self.renderer.SetMaximumNumberOfPeels(12)
        self.direction, self.up = np.array(direction, float), up

    def add(self, data, colour=SIDE, opacity=1.0, points=None, cells=None, width=1.5, edges=False, light=True, smooth=False,
            behind=False):
        """`points`, `cells`: RGB bytes. `smooth`: normals of a closed surface. `behind`: drawn behind what is in the same plane."""
        if smooth:
            normals = vtk.vtkPolyDataNormals()
            normals.SetInputData(data)
            normals.SplittingOff()
            normals.Update()
            data = normals.GetOutput()
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputData(data)
        mapper.ScalarVisibilityOff()
        if behind:
            mapper.SetResolveCoincidentTopologyToPolygonOffset()
            mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(3, 12)
        for rgb, part, mode in ((points, data.GetPointData(), 'point'), (cells, data.GetCellData(), 'cell')):
            if rgb is not None:
                array = numpy_to_vtk(np.ascontiguousarray(rgb, np.uint8), deep=True)
                array.SetName('rgb')
                part.SetScalars(array)
                mapper.ScalarVisibilityOn()
                mapper.SetColorModeToDirectScalars()
                mapper.SetScalarModeToUsePointData() if mode == 'point' else mapper.SetScalarModeToUseCellData()
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetColor(*colour)
        look.SetOpacity(opacity)
        look.SetLineWidth(width)
        look.SetAmbient(0.35 if light else 1)
        look.SetDiffuse(0.65 if light else 0)
        look.SetInterpolationToPhong() if smooth else look.SetInterpolationToFlat()
        if edges:
            look.EdgeVisibilityOn()
            look.SetEdgeColor(0.25, 0.25, 0.25)
            look.SetLineWidth(0.6)
        self.renderer.AddActor(actor)
        return self

    def render(self, size=(700, 520), bounds=None, zoom=1.0):
        """Pixels; the box `bounds` (of all there is) fills the picture."""
        bounds = np.array(self.renderer.ComputeVisiblePropBounds() if bounds is None else bounds, float)
        low, high = bounds[::2], bounds[1::2]
        middle = (low + high) / 2
        view = self.direction / np.linalg.norm(self.direction)
        right = np.cross(view, self.up)
        right /= np.linalg.norm(right)
        above = np.cross(right, view)
        corners = np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]]
                            for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - middle
        half = max(np.abs(corners @ above).max(), np.abs(corners @ right).max() * size[1] / size[0]) * 1.04 / zoom
        camera = self.renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*middle)
        camera.SetPosition(*(middle - view * 10 * np.linalg.norm(high - low)))
        camera.SetViewUp(*above)
        camera.SetParallelScale(half)
        self.renderer.ResetCameraClippingRange()
        window = vtk.vtkRenderWindow()
        window.SetOffScreenRendering(1)
        window.SetAlphaBitPlanes(1)
        window.SetMultiSamples(0)
        factor = 2  # drawn twice as large, then halved: smooth lines with transparency
        window.SetSize(size[0] * factor, size[1] * factor)
        window.AddRenderer(self.renderer)
        window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.ReadFrontBufferOff()
        grab.Update()
        pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(size[1] * factor, size[0] * factor, 3)
        pixels = pixels[::-1].reshape(size[1], factor, size[0], factor, 3).mean(axis=(1, 3))
        window.Finalize()
        return pixels.astype(np.uint8)


def sheet(rows, columns=None, names=None, captions=None, width=3.0, title=None):
    """A matplotlib figure of pictures in rows and columns (None: empty)."""
    height, across = len(rows), max(map(len, rows))
    shape = next(p.shape for row in rows for p in row if p is not None)
    tall = width * shape[0] / shape[1] + (0.30 if captions else 0.06)
    left = 0.35 if names else 0.05
    top = (0.32 if columns else 0.05) + (0.3 if title else 0)
    figure = plt.figure(figsize=(width * across + left, tall * height + top))
    full = figure.get_size_inches()
    for i, row in enumerate(rows):
        for k, pixels in enumerate(row):
            axes = figure.add_axes([(left + k * width) / full[0], 1 - (top + (i + 1) * tall) / full[1] +
                                    (0.30 if captions else 0.03) / full[1], width * 0.985 / full[0],
                                    (tall - (0.30 if captions else 0.06)) / full[1]])
            axes.set_axis_off()
            if pixels is not None:
                axes.imshow(pixels)
            if captions and captions[i][k]:
                axes.text(0.5, -0.02, captions[i][k], transform=axes.transAxes, ha='center', va='top', fontsize=8.5)
            if columns and i == 0:
                axes.set_title(columns[k], fontsize=11, pad=4)
        if names:
            figure.text(left / 2 / full[0], 1 - (top + (i + 0.5) * tall) / full[1], names[i], rotation=90, ha='center',
                        va='center', fontsize=11)
    if title:
        figure.text(0.5, 1 - 0.06 / full[1], title, ha='center', va='top', fontsize=12)
    return figure


def boundary_faces(inside):
    """Faces of the boundary of voxels: the lowest corner, and the two axes along which it extends, in the order of a right-handed
    normal. Voxel (x, y, z) has corners x to x + 1."""
    padded = np.pad(inside, 1).astype(int)
    for axis in range(3):
        for place in np.argwhere(np.diff(padded, axis=axis) != 0):
            base = place - 1
            base[axis] += 1
            yield base, (axis + 1) % 3, (axis + 2) % 3


def write_nrrd(file, inside, spacing=1.0):
    """A mask [x, y, z] as a volume, or [x, y] as an image."""
    head = (f'NRRD0004\ntype: uint8\ndimension: {inside.ndim}\nsizes: {" ".join(map(str, inside.shape))}\n'
            f'spacings: {" ".join([str(spacing)] * inside.ndim)}\nencoding: raw\n\n')
    Path(file).write_bytes(head.encode() + inside.astype(np.uint8).tobytes(order='F'))
    return file


def read_nrrd(file):
    """Samples [x, y, z] of an attached NRRD of one-byte samples, or those of `type`, with its spacings and origin."""
    head, samples = Path(file).read_bytes().split(b'\n\n', 1)
    fields = dict(line.split(': ', 1) for line in head.decode('latin-1').splitlines() if ': ' in line)
    if fields['encoding'].startswith('gz'):
        samples = gzip.decompress(samples)
    kind = {'uint8': 'u1', 'uchar': 'u1', 'unsigned char': 'u1', 'uint16': 'u2', 'ushort': 'u2', 'int16': 'i2', 'short': 'i2',
            'float': 'f4'}[fields['type']]
    sizes = [int(n) for n in fields['sizes'].split()]
    spacing = [float(n) for n in fields['spacings'].split()] if 'spacings' in fields else [
        np.linalg.norm([float(c) for c in v.strip('()').split(',')]) for v in fields['space directions'].split()]
    origin = [float(c) for c in fields.get('space origin', '(0,0,0)').strip('()').split(',')]
    return np.frombuffer(samples, '<' + kind).reshape(sizes, order='F'), np.array(spacing), np.array(origin)


def isosurface(samples, threshold, spacing, origin):
    image = vtk.vtkImageData()
    image.SetDimensions(*samples.shape)
    image.SetSpacing(*spacing)
    image.SetOrigin(*origin)
    image.GetPointData().SetScalars(numpy_to_vtk(samples.ravel(order='F'), deep=True))
    contour = vtk.vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, threshold)
    contour.Update()
    return contour.GetOutput()


def voxel_faces(inside, spacing=1.0, origin=(-0.5, -0.5, -0.5)):
    """The boundary squares of a mask as VTK data, voxel (x, y, z) centred at spacing * (x, y, z) for this origin."""
    padded = np.pad(inside, 1).astype(np.int8)
    squares = []
    for axis in range(3):
        step = np.diff(padded, axis=axis)
        place = np.argwhere(step != 0)  # between place and place + 1 along the axis, padded
        base = place.astype(float) - 1
        base[:, axis] += 1
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        square = np.stack([base, base + u, base + u + v, base + v], 1)
        flip = step[tuple(place.T)] > 0
        square[flip] = square[flip][:, ::-1]
        squares.append(square)
    points = (np.concatenate(squares).reshape(-1, 3) + origin) * spacing
    points, corners = np.unique(points.round(9), axis=0, return_inverse=True)
    return polydata(points, np.arange(len(corners) // 4 + 1) * 4, corners)
