#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.10: skeletons of shapes without and with noise, with the default parameters (theta1 in radii). Figures: distances
between both, and the same with theta1 as a length, as in the dissertation (bench/stability.py has more shapes)."""
import numpy as np
from figure_3_8 import NOISE, SHAPES, noisy
from paper import CURVE, Complex, Scene, main, sheet, table
from scipy.spatial import cKDTree

RESOLUTION = 192


def samples(axis, step):
    """Points on the polygons (their corners and centres) and along the curves."""
    found = [axis.points]
    if axis.count:
        found.append(np.add.reduceat(axis.points[axis.corners], axis.offsets[:-1]) / np.diff(axis.offsets)[:, None])
    for a, b in axis.points[axis.lines]:
        n = int(np.ceil(np.linalg.norm(b - a) / step))
        found.append(a + (b - a) * np.linspace(0, 1, n + 1)[:, None])
    return np.concatenate(found)


def members(paper, name, kind, mesh):
    """Skeletons of a shape by theta1: in radii, as a length."""
    folder = paper.file(f'{name}_{kind}')
    paper.quench('run', mesh, '--resolution', RESOLUTION, '-o', folder)
    fixed = paper.file(f'{name}_{kind}_fixed.vtp')
    paper.quench('skeleton', folder / 'core.vtp', '--theta2', 0.03, '--theta1', 0.03, '-o', fixed)
    return {'0.5r': Complex(folder / 'skeleton.vtp'), '0.03': Complex(fixed)}


def length_of(axis):
    ends = axis.points[axis.lines[axis.only_curves()]]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()


def make(paper):
    rows, pictures, captions, names = [], [], [], []
    for name, (real, view) in SHAPES.items():
        mesh = paper.real(real)
        if mesh is None:
            continue
        line, texts, found = [], [], {}
        for kind, file in (('without', mesh), ('with', noisy(paper, mesh, name))):
            found[kind] = members(paper, name, kind, file)
            axis, surface = found[kind]['0.5r'], paper.surface(file)
            line.append(Scene(view, (0, 1, 0)).add(surface, (0.8, 0.8, 0.8)).render((480, 440), surface.GetBounds()))
            scene = Scene(view, (0, 1, 0)).add(surface, (0.8, 0.8, 0.8), 0.08)
            scene.add(axis.sheets()).add(axis.curves(axis.only_curves()), CURVE, width=5)
            line.append(scene.render((480, 440), surface.GetBounds()))
            texts += [f'{kind} noise', f'{axis.count} polygons, b = {axis.betti()}']
        for theta1 in ('0.5r', '0.03'):
            pair = [found[kind][theta1] for kind in ('without', 'with')]
            side = float(pair[0].field['longest_side'].ravel()[0])
            a, b = (samples(axis, side / RESOLUTION / 2) for axis in pair)
            there, back = cKDTree(b).query(a)[0] / side, cKDTree(a).query(b)[0] / side
            rows.append((name, theta1, *(f'{axis.areas().sum() / side**2:.3f}' for axis in pair),
                         *(f'{length_of(axis) / side:.2f}' for axis in pair), f'{100 * (there.mean() + back.mean()) / 2:.2f} %',
                         f'{100 * np.quantile(np.concatenate([there, back]), 0.95):.2f} %',
                         f'{100 * max(there.max(), back.max()):.1f} %', pair[0].betti(), pair[1].betti()))
        pictures.append(line)
        captions.append(texts)
        names.append(name)
    print('Dissertation, without numbers: skeletons barely change under noise. Here normal noise of '
          f'{NOISE:.1%} of the side on all vertices; resolution {RESOLUTION},\ntheta2 0.03; distances between the two skeletons in shares '
          f'of the longest side (a voxel: {100 / RESOLUTION:.2f} %):\n')
    table(('shape', 'theta1', 'sheets without', 'with', 'curves without', 'with', 'mean distance', '95 %', 'largest', 'b without', 'with'),
          rows)
    paper.save(sheet(pictures, None, names, captions, 3.2), '3_10')


if __name__ == '__main__':
    main(make, __doc__)
