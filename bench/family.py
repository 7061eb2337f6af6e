#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The family of skeletons of one shape (Yan 2018, Fig. 3.7): a table, and a sheet of pictures.

usage: family.py MESH [--quench PROGRAM] [--resolution 160] [--work DIR] [--sheet OUT.png] [--azimuth D] [--elevation D]

Rows theta2, columns theta1; each cell of the table: faces, area of sheets (squared longest sides), length of curves
(longest sides), free ends of curves. Needs python3-numpy, python3-vtk9; pictures need a display (xvfb-run -a)."""
import argparse
import tempfile
import json
import subprocess
from pathlib import Path

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from polylines import segments_of

THETA2, THETA1 = ('0.01', '0.03', '0.1', 'inf'), ('0', '0.02', '0.05', 'inf')


def read(file):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def measures(data, side):
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    area = length = ends = 0
    on_sheet = np.zeros(len(points), bool)
    if data.GetNumberOfPolys():
        offsets = vtk_to_numpy(data.GetPolys().GetOffsetsArray())
        corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray())
        on_sheet[corners] = True
        # Newell's rule, polygon by polygon.
        following = np.arange(1, len(corners) + 1)
        following[offsets[1:] - 1] = offsets[:-1]
        p, q = points[corners], points[corners[following]]
        middle = points[corners[np.repeat(offsets[:-1], np.diff(offsets))]]
        area = np.linalg.norm(np.add.reduceat(np.cross(p - middle, q - middle), offsets[:-1]), axis=1).sum() / 2
    if data.GetNumberOfLines():
        lines = segments_of(data)
        length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1).sum()
        degree = np.bincount(lines.ravel(), minlength=len(points))
        ends = int(((degree == 1) & ~on_sheet).sum())
    return data.GetNumberOfPolys(), area / side**2, length / side, ends


def picture(data, azimuth, elevation, size):
    sheets, curves = vtk.vtkPolyData(), vtk.vtkPolyData()
    sheets.SetPoints(data.GetPoints())
    sheets.SetPolys(data.GetPolys())
    curves.SetPoints(data.GetPoints())
    curves.SetLines(data.GetLines())
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for part, colour in ((sheets, (0.45, 0.65, 0.85)), (curves, (0.75, 0.1, 0.1))):
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputData(part)
        mapper.ScalarVisibilityOff()
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*colour)
        actor.GetProperty().SetLineWidth(2)
        renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return renderer, window


def sheet(cells, box, out, azimuth, elevation):
    size = (230, 200)
    rows = []
    for line in cells:
        row = []
        for data in line:
            renderer, window = picture(data, azimuth, elevation, size)
            renderer.ResetCamera(*box)
            camera = renderer.GetActiveCamera()
            camera.Azimuth(azimuth)
            camera.Elevation(elevation)
            camera.Zoom(1.5)
            renderer.ResetCameraClippingRange()
            window.Render()
            grab = vtk.vtkWindowToImageFilter()
            grab.SetInput(window)
            grab.Update()
            image = grab.GetOutput()
            row.append(vtk_to_numpy(image.GetPointData().GetScalars()).reshape(size[1], size[0], 3)[::-1])
        rows.append(np.concatenate(row, axis=1))
    pixels = np.concatenate(rows)
    pixels = (pixels // 16 * 17).astype(np.uint8)  # few colours make a small file
    image = vtk.vtkImageData()
    image.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    from vtk.util.numpy_support import numpy_to_vtk
    image.GetPointData().SetScalars(numpy_to_vtk(pixels[::-1].reshape(-1, 3), deep=True))
    writer = vtk.vtkPNGWriter()
    writer.SetCompressionLevel(9)
    writer.SetFileName(out)
    writer.SetInputData(image)
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('mesh', type=Path)
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--resolution', default='160')
    parser.add_argument('--work', type=Path, default=Path(tempfile.gettempdir()) / 'quench_family')
    parser.add_argument('--sheet')
    parser.add_argument('--azimuth', type=float, default=30)
    parser.add_argument('--elevation', type=float, default=15)
    options = parser.parse_args()
    folder = options.work / options.mesh.stem
    folder.mkdir(parents=True, exist_ok=True)

    def quench(*arguments):
        subprocess.run([options.quench, *map(str, arguments), '--quiet', '--threads', '1'], check=True)

    quench('run', options.mesh, '--resolution', options.resolution, '-o', folder, '--overwrite')
    side = json.loads((folder / 'report.json').read_text())['input']['longest_side']
    print(f"| theta2 \\ theta1 | {' | '.join(THETA1)} |\n|---|" + '---|' * len(THETA1))
    cells = []
    for theta2 in THETA2:
        row, texts = [], []
        for theta1 in THETA1:
            file = folder / f'{theta2}-{theta1}.vtp'
            quench('skeleton', folder / 'core.vtp', '--theta2', theta2, '--theta1', theta1, '-o', file, '--overwrite')
            row.append(read(file))
            faces, area, length, ends = measures(row[-1], side)
            texts.append(f'{faces} · {area:.3f} · {length:.2f} · {ends}')
        cells.append(row)
        print(f"| **{theta2}** | {' | '.join(texts)} |", flush=True)
    if options.sheet:
        sheet(cells, cells[0][0].GetBounds(), options.sheet, options.azimuth, options.elevation)


if __name__ == '__main__':
    main()
