#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.10: cores of smooth shapes beside three methods that start from samples of the surface. The methods as published, written anew
(sampled_axes.py, tested by check_peers.py), not the programs of their authors: topology and place can be compared, time and memory of
Python not. Samples: the vertices of the mesh, and (elk, fertility) of the mesh with edges halved down to 1/96 of the side."""
import json
import sys
from pathlib import Path

import numpy as np
import vtk
from paper import Complex, Scene, main, measured, polydata, sheet, table
from sampled_axes import Sheets

METHODS = {'SAT, s = 1': 'scale_axis=1', 'SAT, s = 1.05': 'scale_axis=1.05', 'all inner balls': 'inner_voronoi',
           'power crust': 'power_shape', 'Dey and Zhao': 'dey_zhao'}
DRAWN = ('SAT, s = 1', 'power crust', 'Dey and Zhao')
SHAPES = {'ellipsoid': (None, ((-0.3, 0.45, -1), (0, 1, 0))), 'elk': ('meshes/elk.off', ((-0.4, -0.3, -1), (0, 1, 0))),
          'fertility': ('meshes/fertility.off', ((-0.2, -0.2, -1), (0, 1, 0))),
          'armadillo': ('meshes/armadillo.off', ((-0.6, -0.25, 1.5), (0, 1, 0)))}  # the dissertation: mug or hand, too
DENSER = ('elk', 'fertility')


def subdivided(surface, file):
    """The mesh with edges halved until none is longer than 1/96 of the longest side."""
    bounds = np.array(surface.GetBounds())
    halves = vtk.vtkAdaptiveSubdivisionFilter()
    halves.SetInputData(surface)
    halves.SetMaximumEdgeLength((bounds[1::2] - bounds[::2]).max() / 96)
    halves.SetMaximumTriangleArea(1e30)
    writer = vtk.vtkPLYWriter()
    writer.SetInputConnection(halves.GetOutputPort())
    writer.SetFileName(str(file))
    writer.Write()
    return file


def faces_of(core):
    """Of a file of Quench: faces, those with the corners of another, closed spaces between them."""
    corners = [tuple(sorted(core.corners[a:b])) for a, b in zip(core.offsets[:-1], core.offsets[1:])]
    return len(corners), len(corners) - len(set(corners)), core.betti()[2]


def between(one, other, side):
    away = one.take(20000)
    far = other.distances(away) / side * 1000
    return f'{far.mean():.2f}, {np.quantile(far, 0.99):.1f}, {far.max():.1f}'


def make(paper):
    largest = 1024 if paper.options.large else 512
    resolutions = (128, 256, largest)
    pictures, captions, rows, place = [], [], [], []
    for shape, (real, (view, up)) in SHAPES.items():
        mesh = paper.real(real) if real else paper.sample(shape, '--fineness', 0.35)
        if mesh is None:
            continue
        surface = paper.surface(mesh)
        bounds = np.array(surface.GetBounds())
        side = (bounds[1::2] - bounds[::2]).max()
        plain = paper.file(f'{shape}_plain.ply')
        writer = vtk.vtkPLYWriter()
        writer.SetInputData(surface)
        writer.SetFileName(str(plain))
        writer.Write()
        row, line = [], []

        def draw(data, lines, text):
            scene = Scene(view, up).add(surface, (0.8, 0.8, 0.8), 0.12)
            scene.add(data, (0.42, 0.60, 0.82))
            if len(lines):
                scene.add(polydata(lines[0], lines=lines[1]), (0.75, 0.08, 0.10), width=2)
            row.append(scene.render((520, 440), bounds))
            line.append(text)

        cores, wanted = {}, None
        for resolution in resolutions:
            file, report = paper.file(f'beside_{shape}_{resolution}.vtp'), paper.file('beside.json')
            cost = paper.quench('core', mesh, '--resolution', resolution, '--lambda', 0.015 if shape == 'elk' else 0.025,
                                '-o', file, '--json', report)
            said = json.loads(report.read_text())
            wanted = tuple(said['shape']['topology']['solid_betti']) if 'topology' in said['shape'] else tuple(said['shape']['betti'])
            core = Complex(file)
            cores[resolution] = core, Sheets(core.points, core.offsets, core.corners, core.lines[core.only_curves()]), cost
        ours = cores[256][1]
        for sampling in ('vertices', 'denser') if shape in DENSER else ('vertices',):
            samples = plain if sampling == 'vertices' else subdivided(surface, paper.file(f'{shape}_denser.ply'))
            for method, name in METHODS.items():
                file = paper.file(f'beside_{shape}_{sampling}_{name}.npz')
                code, cpu, megabytes = measured([sys.executable, str(Path(__file__).with_name('sampled_axes.py')), name, str(samples),
                                                 str(file)])
                if code:
                    raise SystemExit(f'{name} of {shape} ended with code {code}')
                found = np.load(file)
                number = json.loads(str(found['numbers']))
                sheets = Sheets(*(found[k] for k in ('points', 'offsets', 'corners', 'lines')))
                betti = number['components'], number['tunnels'], number['pockets']
                right = 'yes' if betti == wanted else 'no'
                rows.append((shape, method, sampling, number['vertices'], number['faces'], number['solids'],
                             f'{number["euler"]}, {number["components"]}', betti, wanted, right, f'{cpu:.1f}', f'{megabytes:.0f}'))
                place.append((shape, method, sampling, between(sheets, ours, side), between(ours, sheets, side)))
                if sampling == 'vertices' and method in DRAWN:
                    draw(polydata(found['points'], found['offsets'], found['corners']),
                         (found['points'], found['lines']) if len(found['lines']) else (),
                         f'χ, parts: {number["euler"]}, {number["components"]}' +
                         (' (right)' if betti == wanted else f' (χ of the shape: {wanted[0] - wanted[1] + wanted[2]})'))
        for resolution, (core, sheets, cost) in cores.items():
            faces, twice, pockets = faces_of(core)
            betti = core.betti()
            rows.append((shape, f'Quench {resolution}', 'voxels', len(core.points), faces, 0,
                         f'{betti[0] - betti[1] + betti[2]}, {betti[0]}', betti, wanted, 'yes' if betti == wanted and not twice else 'no',
                         f'{cost.cpu:.1f}', f'{cost.megabytes:.0f}'))
            if resolution != 256:
                place.append((shape, f'Quench {resolution}', 'voxels', between(sheets, ours, side), between(ours, sheets, side)))
            draw(core.sheets(), (core.points, core.lines[core.only_curves()]) if core.only_curves().any() else (),
                 f'χ, parts: {betti[0] - betti[1] + betti[2]}, {betti[0]}' + (' (right)' if betti == wanted else '') +
                 f'; {cost.cpu:.1f} s, {cost.megabytes:.0f} MB')
        pictures.append(row)
        captions.append(line)
    print('Dissertation: SAT has duplicate faces and some pockets, the power crust many pockets, Dey and Zhao many islands; the core the '
          'right topology.\nHere the methods written anew, not the programs; solids: tetrahedra, each a closed pocket where faces only are '
          'written.\nb0, b1, b2 are those of the faces.\n')
    table(('shape', 'method', 'samples', 'vertices', 'faces', 'solids', 'χ, parts', 'b0, b1, b2', 'of the shape', 'right', 'CPU s',
           'MB'), rows)
    print('\nDistances to the core at 256 and from it, mean, 99 %, largest, in thousandths of the longest side:\n')
    table(('shape', 'method', 'samples', 'to our core', 'from our core'), place)
    paper.save(sheet(pictures, [*DRAWN, *(f'Quench {r}³' for r in resolutions)], list(SHAPES), captions, width=2.6), '2_10')


if __name__ == '__main__':
    main(make, __doc__)
