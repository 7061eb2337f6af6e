#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""All measures of the menu on noisy shapes: what a plain threshold keeps of features and of noise, and what topology adds.

usage: significance.py QUENCH MESHES FOLDER [--picture FILE.png] [--gallery SHAPE FACES FILE.png]

QUENCH is the program, MESHES a folder with armadillo.off and elk.off, FOLDER takes what is made. For every shape a whole
core with all measures is made at resolution 256, of the voxels; examples/significance.py thresholds each measure where the
same share of the area is left. Of QUENCH's pruning by each measure at that threshold, *bridges* is the share of the area
of the pruning that lies below the threshold, which only topology keeps, *wires* the length of its lines, in longest
sides, both from one core with levels. Prints the tables of notes/significance.md; --picture draws the summary, --gallery the
prunings of a shape by each measure to about so many faces (under xvfb-run where there is no screen). Needs Debian's python3-numpy,
python3-scipy, python3-vtk9 and python3-matplotlib."""
import argparse
import json
import pathlib
import subprocess
import sys

EXAMPLES = pathlib.Path(__file__).resolve().parent.parent / 'examples'
sys.path.insert(0, str(EXAMPLES))
from significance import Axis, share  # noqa: E402

import numpy as np  # noqa: E402
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

FIN = ['--box', 'fin', '-0.7', '0.1', '-0.005', '0.005', '0.25', '0.65', '--box', 'bump', '0.28', '0.92', '-0.22', '0.42',
       '0.05', '0.26']
# Name, shares of the area that are kept, options of examples/significance.py, the column of features.
SHAPES = (('fin-on-board', (0.2, 0.1), FIN, 'fin'), ('rippled-box', (0.2, 0.05), ['--clean', 'clean-box'], 'features'),
          ('bumpy-sphere', (0.05,), [], None), ('armadillo', (0.05, 0.2), ['--surface'], 'tips'),
          ('elk', (0.05, 0.2), ['--surface'], 'tips'))
ORDER = ('circumradius', 'lambda', 'object_angle', 'cap_height', 'detail', 'mgf', 'chord_residual', 'scale_axis',
         'core_erosion_thickness', 'relative_erosion_thickness')
COLOURS = dict(zip(ORDER, ('#7f7f7f', '#1f77b4', '#d62728', '#17becf', '#2ca02c', '#9467bd', '#e377c2', '#8c564b', '#ff7f0e',
                           '#bcbd22')))
MARKS = {'fin-on-board': 's', 'rippled-box': 'D', 'armadillo': 'o', 'elk': '^'}


def core(quench, mesh, out, *options):
    if not out.exists():
        subprocess.run([quench, 'core', mesh, '--resolution', '256', '--surface', 'voxels', *options, '-o', out, '--quiet'], check=True)
    return out


def leveled(quench, mesh, folder, name):
    """The whole core with the levels of a measure: its pruning at every threshold."""
    by = [f'--{name}', '0'] if name in ('detail', 'lambda') else ['--prune-by', f'{name}={1 if name == "scale_axis" else 0}']
    return Axis(str(core(quench, mesh, folder / f'{mesh.stem}_{name}.vtp', *by, '--full')))


def bridges(axis, row):
    """Of the pruning at the threshold of a row."""
    name = row['measure']
    least = row['threshold'] * (1 - 1e-6)  # some files have single precision
    level = vtk_to_numpy(axis.data.GetCellData().GetArray(f'{name}_level')).astype(float)
    kept = level[axis.first_cell:] >= least
    area = axis.area[kept].sum()
    row['faces'] = int(kept.sum())
    row['bridges'] = axis.area[kept & (axis.measure(name) < least)].sum() / area if area > 0 else 0
    ends, of_lines = axis.lines()
    ahead = np.arange(1, len(axis.index) + 1)
    ahead[axis.offsets[1:] - 1] = axis.offsets[:-1]
    sides = np.sort(np.stack([axis.index, axis.index[ahead]], 1)[kept[axis.polygon]], axis=1)
    count = len(axis.points)
    alone = (level[of_lines] >= least) & ~np.isin(np.sort(ends, axis=1) @ [count, 1], sides @ [count, 1])
    length = np.linalg.norm(axis.points[ends[alone, 0]] - axis.points[ends[alone, 1]], axis=1).sum()
    row['wires'] = length / float(axis.data.GetFieldData().GetArray('longest_side').GetValue(0))


def kept_features(row, column):
    return row[column][0] / row[column][1] if column == 'tips' else row[column]


def texts(row):
    for key, value in row.items():
        yield (value if key == 'measure' else f'{value:.4g}' if key == 'threshold' else f'{value[0]} of {value[1]}'
               if key == 'tips' else f'{value:.2f}' if key == 'wires' else str(value) if isinstance(value, int) else share(value))


def table(rows):
    hidden = ('faces',)
    rows = [{k: v for k, v in row.items() if k not in hidden} for row in rows]
    print('| ' + ' | '.join(rows[0]) + ' |\n' + '|---' * len(rows[0]) + '|')
    for row in rows:
        print('| ' + ' | '.join(texts(row)) + ' |')
    print(flush=True)


def summary(found):
    """A row per measure: features kept and area outside of the largest piece, over the shapes."""
    print('| measure | ' + ' | '.join(f'{shape}, {100 * keep:.0f} %' for shape, keep in found) + ' |')
    print('|---' * (len(found) + 1) + '|')
    for name in ORDER:
        cells = []
        for (shape, _), rows in found.items():
            row = next(r for r in rows if r['measure'] == name)
            column = next(s[3] for s in SHAPES if s[0] == shape)
            cells.append((f'{100 * kept_features(row, column):.0f}' if column else '–') +
                         f' / {100 * row["outside"]:.1f} / {100 * row["bridges"]:.1f}')
        print(f'| {name} | ' + ' | '.join(cells) + ' |')


def draw(found, file):
    import matplotlib
    matplotlib.use('Agg')
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(9, 5.4))
    for (shape, keep), rows in found.items():
        column = next(s[3] for s in SHAPES if s[0] == shape)
        if not column or keep != next(s[1][0] for s in SHAPES if s[0] == shape):
            continue
        for row in rows:
            axes.plot(100 * row['outside'], 100 * kept_features(row, column), MARKS[shape], color=COLOURS[row['measure']],
                      markersize=9, alpha=0.8, markeredgecolor='white')
    axes.set_xscale('symlog', linthresh=0.1)
    axes.set_xlim(-0.02, 110)
    axes.set_ylim(-4, 104)
    axes.set_xlabel('share of the kept area outside of its largest piece, %')
    axes.set_ylabel('features kept, %')
    axes.set_title('A plain threshold of each measure at the same area: upper left is best', fontsize=11)
    axes.grid(alpha=0.3)
    keep_of = {s[0]: s[1][0] for s in SHAPES}
    handles = [plt.Line2D([], [], color=COLOURS[n], marker='o', linestyle='', label=n.replace('_', ' ')) for n in ORDER]
    handles += [plt.Line2D([], [], color='black', marker=m, linestyle='', label=f'{s}, {100 * keep_of[s]:.0f} %')
                for s, m in MARKS.items()]
    axes.legend(handles=handles, fontsize=8, loc='center left', bbox_to_anchor=(1.01, 0.5))
    figure.savefig(file, dpi=110, bbox_inches='tight')


def gallery(quench, mesh, folder, faces, file):
    import vtk
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(1500, 640)
    for number, name in enumerate(ORDER):
        axis = leveled(quench, mesh, folder, name)
        level = vtk_to_numpy(axis.data.GetCellData().GetArray(f'{name}_level')).astype(float)
        least = np.sort(level[axis.first_cell:])[-faces]
        axis.data.GetPointData().SetActiveScalars('radius')
        part = vtk.vtkThreshold()
        part.SetInputData(axis.data)
        part.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_CELLS, f'{name}_level')
        part.SetThresholdFunction(vtk.vtkThreshold.THRESHOLD_UPPER)
        part.SetUpperThreshold(least)
        surface = vtk.vtkGeometryFilter()
        surface.SetInputConnection(part.GetOutputPort())
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputConnection(surface.GetOutputPort())
        mapper.ScalarVisibilityOff()
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*[int(COLOURS[name][i:i + 2], 16) / 255 for i in (1, 3, 5)])
        actor.GetProperty().SetAmbient(0.25)
        actor.GetProperty().SetLineWidth(2)
        text = vtk.vtkTextActor()
        text.SetInput(f'{name.replace("_", " ")}  {least:.3g}')
        text.GetTextProperty().SetColor(0, 0, 0)
        text.GetTextProperty().SetFontSize(17)
        text.SetPosition(8, 8)
        view = vtk.vtkRenderer()
        view.SetBackground(1, 1, 1)
        view.SetViewport(number % 5 / 5, 0.5 - number // 5 / 2, number % 5 / 5 + 0.2, 1 - number // 5 / 2)
        view.AddActor(actor)
        view.AddActor2D(text)
        window.AddRenderer(view)
        if number == 0:
            view.ResetCamera(axis.data.GetBounds())
            camera = view.GetActiveCamera()
            camera.Azimuth(30)
            camera.Elevation(15)
            camera.Zoom(1.3)
        view.SetActiveCamera(camera)
        view.ResetCameraClippingRange()
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(file)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('quench')
    parser.add_argument('meshes', type=pathlib.Path)
    parser.add_argument('folder', type=pathlib.Path)
    parser.add_argument('--picture')
    parser.add_argument('--gallery', nargs=3)
    options = parser.parse_args()
    quench, folder = options.quench, options.folder
    folder.mkdir(exist_ok=True)
    for sample, file, more in (('fin-on-board', 'fin-on-board', ()), ('rippled-box', 'rippled-box', ()),
                               ('rippled-box', 'clean-box', ('--noise', '1e-6')), ('bumpy-sphere', 'bumpy-sphere', ())):
        if not (folder / f'{file}.ply').exists():
            subprocess.run([quench, 'sample', sample, *more, '-o', folder / f'{file}.ply', '--quiet'], check=True)
    found = {}
    for shape, keeps, flags, _ in SHAPES:
        mesh = next(m for m in (folder / f'{shape}.ply', options.meshes / f'{shape}.off') if m.exists())
        whole = core(quench, mesh, folder / f'{shape}.vtp', '--detail', '0', '--measures', 'all')
        flags = list(flags)
        if flags[:1] == ['--clean']:
            flags = ['--clean', core(quench, folder / 'clean-box.ply', folder / 'clean-box.vtp', '--detail', '0')]
        if flags == ['--surface']:
            flags = ['--surface', mesh]
        found_here = {}
        for keep in keeps:
            rows_file = folder / f'{shape}_{keep}.json'
            if not rows_file.exists():
                subprocess.run([EXAMPLES / 'significance.py', whole, '--keep', str(keep), *flags, '--json', rows_file],
                               check=True, stdout=subprocess.DEVNULL)
            found_here[keep] = sorted(json.loads(rows_file.read_text()), key=lambda row: ORDER.index(row['measure']))
        for number, name in enumerate(ORDER):
            axis = leveled(quench, mesh, folder, name)
            for rows in found_here.values():
                bridges(axis, rows[number])
        for keep, rows in found_here.items():
            found[shape, keep] = rows
            print(f'### {shape}, {100 * keep:.0f} %\n')
            table(rows)
    summary(found)
    if options.picture:
        draw(found, options.picture)
    if options.gallery:
        shape, faces, file = options.gallery
        gallery(quench, next(m for m in (folder / f'{shape}.ply', options.meshes / f'{shape}.off') if m.exists()), folder,
                int(faces), file)


if __name__ == '__main__':
    main()
