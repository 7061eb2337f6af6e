#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.9: erosion thickness and MGF of a box without and with ripples on its large faces. Figures: how much the distribution
of each measure changes, and what it costs. CPU seconds of cores are those with MGF."""
import numpy as np
from measures import of_polygons
from paper import Complex, Scene, colours, main, sheet, table
from scipy.spatial import cKDTree

RESOLUTION = 128


def quantiles(values, area):
    """Of values weighted by area, at a tenth, the half, nine tenths."""
    order = np.argsort(values)
    at = np.cumsum(area[order]) / area.sum()
    return [values[order][np.searchsorted(at, q)] for q in (0.1, 0.5, 0.9)]


def make(paper):
    resolution = 256 if paper.options.large else RESOLUTION
    boxes = {'smooth': paper.sample('rippled-box', '--noise', '1e-6'), 'rippled': paper.sample('rippled-box')}
    rows, pictures, captions, found = [], [], [], {}
    view = (-0.7, -1.2, -1.0)
    for kind, mesh in boxes.items():
        core, burned = paper.file(f'box_{kind}.vtp'), paper.file(f'box_{kind}_burned.vtp')
        first = paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--lambda', '1.5vox', '--measures', 'mgf', '-o', core)
        cost = paper.quench('burn', core, '-o', burned)
        axis = Complex(burned)
        found[kind] = axis
        area = axis.areas()
        bounds = paper.surface(mesh).GetBounds()
        line, texts = [Scene(view).add(paper.surface(mesh), (0.75, 0.72, 0.66)).render((560, 380), bounds)], [f'{kind} box']
        for measure in ('erosion_thickness', 'mgf'):
            values = of_polygons(axis, measure)
            finite = np.isfinite(values)
            low, middle, high = quantiles(values[finite], area[finite])
            rows.append((kind, measure.replace('_', ' ').replace('mgf', 'MGF'), f'{low:.3f}', f'{middle:.3f}', f'{high:.3f}', f'{values[finite].max():.3f}',
                         f'{cost.cpu:.2f} (core {first.cpu:.2f})' if measure != 'mgf' else ''))
            top = 0.56 if measure == 'erosion_thickness' else values[finite].max()
            strong = values > 0.02
            scene = Scene(view).add(axis.sheets(~strong), (0.75, 0.78, 0.85), 0.10)
            scene.add(axis.sheets(strong), cells=colours(values[strong], 0, top))
            line.append(scene.render((560, 380), bounds))
            texts.append(f'{measure.replace("_", " ").replace("mgf", "MGF")}: up to {values[finite].max():.3f}')
        pictures.append(line)
        captions.append(texts)
    # ET at the same places: the middle sheet of the smooth box against the nearest point of the rippled one.
    smooth, rippled = found['smooth'], found['rippled']

    et = smooth.thickness()
    deep = np.isfinite(et) & (et > 0.05)
    distance, nearest = cKDTree(rippled.points).query(smooth.points[deep], k=8)
    there = rippled.thickness()[nearest].max(axis=1)
    change = np.abs(there - et[deep])
    print('Dissertation: MGF takes 4 days for this example and changes with the ripples; ET takes 18 s and stays about the same.\n'
          f'Here at {resolution}, values per polygon weighted by area (side of the box 2):\n')
    table(('box', 'measure', '10 %', '50 %', '90 %', 'largest', 'CPU s'), rows)
    voxel = 2 / resolution
    print(f'\nET where it is above 0.05 on the smooth box ({deep.sum()} points; nearest points of the rippled one at '
          f'{distance[:, 0].mean() / voxel:.1f} voxels): changes by {change.mean():.4f} on average, {np.quantile(change, 0.99):.4f} '
          f'at 99 %, of up to {et[deep].max():.3f}.')
    mgf = [axis.at['mgf'].astype(float) for axis in (smooth, rippled)]
    deep = (mgf[0] > 0.5) & (mgf[0] < 3e38)
    nearest = cKDTree(rippled.points).query(smooth.points[deep], k=8)[1]
    change = np.abs(mgf[1][nearest].max(axis=1) - mgf[0][deep])
    print(f'MGF where it is above 0.5: changes by {change.mean():.4f} on average, {np.quantile(change, 0.99):.4f} at 99 %, of up to '
          f'{mgf[0][deep].max():.3f}.')
    paper.save(sheet(pictures, ['shape', 'erosion thickness', 'MGF'], captions=captions, width=3.6), '3_9')


if __name__ == '__main__':
    main(make, __doc__)
