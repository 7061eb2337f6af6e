#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.8: measures on the medial axes of noisy shapes, and what is left above a threshold that keeps a fifth of the area. The
armadillo and the elk with normal noise of 0.2 % of the side on their vertices, in the place of dolphin and elephant."""
import numpy as np
from measures import NAMES, of_polygons, threshold_of
from paper import Complex, Scene, colours, main, sheet, table
from vtk.util.numpy_support import vtk_to_numpy

SHAPES = {'armadillo': ('meshes/armadillo.off', (-0.6, -0.25, 1.5)), 'elk': ('meshes/elk.off', (-0.4, -0.3, -1))}
NOISE, KEEP, RESOLUTION = 0.002, 0.2, 192


def noisy(paper, mesh, name):
    """The mesh with normal noise on its vertices, as OBJ."""
    data = paper.surface(mesh)
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    side = (points.max(0) - points.min(0)).max()
    points = points + np.random.default_rng(3).normal(0, NOISE * side, points.shape)
    faces = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    file = paper.file(f'{name}_noisy.obj')
    file.write_text(''.join(f'v {x:.7g} {y:.7g} {z:.7g}\n' for x, y, z in points) +
                    ''.join(f'f {a + 1} {b + 1} {c + 1}\n' for a, b, c in faces))
    return file


def make(paper):
    rows, pictures, captions, names = [], [], [], []
    for name, (real, view) in SHAPES.items():
        mesh = paper.real(real)
        if mesh is None:
            continue
        core, burned = paper.file(f'{name}_noisy.vtp'), paper.file(f'{name}_noisy_burned.vtp')
        paper.quench('core', noisy(paper, mesh, name), '--resolution', RESOLUTION, '--surface', 'voxels', '--lambda', 0.008, '--measures', 'mgf', '-o', core)
        paper.quench('burn', core, '-o', burned)
        axis = Complex(burned)
        area, surface = axis.areas(), paper.surface(mesh)
        whole, kept_pictures, texts, kept_texts = [], [], [], []
        for measure, title in NAMES.items():
            if measure == 'lambda':
                continue
            values = of_polygons(axis, measure)
            t = threshold_of(values, area, KEEP)
            kept = values >= t
            pieces = axis.pieces(kept)
            islands = pieces < 0.01 * pieces.sum()
            rows.append((name, title, f'{t:.3g}', f'{area[kept].sum() / area.sum():.2f}', len(pieces),
                         f'{100 * pieces[islands].sum() / pieces.sum():.1f} %'))
            finite = values[np.isfinite(values)]
            top = np.quantile(finite, 0.995)
            scene = Scene(view, (0, 1, 0)).add(axis.sheets(), cells=colours(values, 0, top))
            whole.append(scene.render((480, 420), surface.GetBounds()))
            texts.append(f'up to {finite.max():.3g}')
            scene = Scene(view, (0, 1, 0)).add(surface, (0.8, 0.8, 0.8), 0.10)
            scene.add(axis.sheets(kept), cells=colours(values[kept], 0, top))
            kept_pictures.append(scene.render((480, 420), surface.GetBounds()))
            kept_texts.append(f'≥ {t:.3g}: {len(pieces)} pieces')
        pictures += [whole, kept_pictures]
        captions += [texts, kept_texts]
        names += [name, f'{name}, above']
    print(f'Dissertation, without numbers: object angle has many islands of noise, circumradius loses thin parts, MGF is disturbed by '
          f'noise,\nET keeps thin plates and little noise. Here a threshold that keeps {KEEP:.0%} of the area (islands: pieces below '
          '1 % of what is kept):\n')
    table(('shape', 'measure', 'threshold', 'kept', 'pieces', 'area in islands'), rows)
    paper.save(sheet(pictures, [t for n, t in NAMES.items() if n != 'lambda'], names, captions, 2.9), '3_8')


if __name__ == '__main__':
    main(make, __doc__)
