#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.9: the lambda-subsets of the ellipsoid's core (columns) at resolutions 128, 256, 512, 768 (rows; --large: the
dissertation's 128, 256, 768, 1280). The true medial axis is a plane ellipse, its outline red. Distances are taken at vertices
and centres of polygons (bench_convergence axis bounds them). The first column is the rear half of the whole core, from 512 on the
part of it of lambda 0.006 and more."""
import numpy as np
from paper import Complex, Scene, colours, main, polydata, sheet, table
from scipy.spatial import cKDTree

A, B, C = 1, 0.7, 0.4
LAMBDAS = (0.015, 0.025, 0.065)  # of the longest side, 2


def ellipse(scale=1.0, step=0.004):
    """The medial axis of the ellipsoid, its radius function's level set scaled; points, and its outline."""
    a, b = scale * (A * A - C * C) / A, scale * (B * B - C * C) / B
    x, y = np.meshgrid(np.arange(-a, a, step), np.arange(-b, b, step))
    inside = (x / a) ** 2 + (y / b) ** 2 <= 1
    t = np.linspace(0, 2 * np.pi, 400)
    return np.column_stack([x[inside], y[inside], 0 * x[inside]]), np.column_stack([a * np.cos(t), b * np.sin(t), 0 * t])


def to_ellipse(points, scale):
    """Distances from points to the plane ellipse of that scale, by the nearest point of a fine sample of its outline."""
    a, b = scale * (A * A - C * C) / A, scale * (B * B - C * C) / B
    t = np.linspace(0, 2 * np.pi, 20000)
    over = np.linalg.norm(points[:, :2] / (a, b), axis=1) <= 1
    rim = cKDTree(np.column_stack([a * np.cos(t), b * np.sin(t)])).query(points[:, :2])[0]
    return np.hypot(np.where(over, 0, rim), points[:, 2])


def make(paper):
    resolutions = (128, 256, 768, 1280) if paper.options.large else (128, 256, 512, 768)
    mesh = paper.sample('ellipsoid', '--fineness', 2)
    view = (-0.5, -1.1, -0.9)
    bounds = (-1, 1, -0.7, 0.7, -0.4, 0.4)
    outline = polydata(ellipse()[1], None, None, np.stack([np.arange(399), np.arange(1, 400)], 1))
    rows, pictures, captions = [], [], []
    for resolution in resolutions:
        file = paper.file(f'ellipsoid_{resolution}.vtp')
        least = 0 if resolution <= 256 else 0.006
        paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--topology', 'voxels', '--lambda', least,
                     '-o', file)
        core = Complex(file)
        h = 2 / resolution
        rear = core.least(core.points @ np.array(view)) > 0 if least == 0 else np.ones(core.count, bool)
        whole = Scene(view).add(core.sheets(rear), cells=colours(core.faces['lambda'][rear], 0, 0.4))
        line, texts = [whole.render((520, 330), bounds)], ['whole core, rear half' if least == 0 else 'λ ≥ 0.006']
        for threshold in LAMBDAS:
            kept = core.faces['lambda_level'] >= 2 * threshold
            scale = np.sqrt(1 - (2 * threshold / C) ** 2)
            used = np.unique(core.corners[kept[core.polygon]])
            there = to_ellipse(core.points[used], scale).max()
            # Centres of polygons too, so that the sheet is sampled about as finely as its voxels.
            middle = np.add.reduceat(core.points[core.corners], core.offsets[:-1]) / np.diff(core.offsets)[:, None]
            back = cKDTree(np.concatenate([core.points[used], middle[kept]])).query(ellipse(scale)[0])[0].max()
            rows.append((resolution, threshold, int(kept.sum()), f'{there / 2:.4f} ({there / h:.1f} h)',
                         f'{back / 2:.4f} ({back / h:.1f} h)'))
            scene = Scene(view).add(core.sheets(kept), cells=colours(core.faces['lambda'][kept], 0, 0.4))
            line.append(scene.add(outline, (0.85, 0.1, 0.1), width=3, light=False).render((520, 330), bounds))
            texts.append(f'{kept.sum()} polygons, core to axis {there / h:.1f} h')
        pictures.append(line)
        captions.append(texts)
    print('Dissertation, without numbers: lambda 0.065 is clean from 128 on and misses the rim; 0.015 keeps noise at 768 and '
          'none at 1280.\nDistances between the pruned core and the lambda-axis, largest at vertices and centres, as shares of the longest '
          'side (in voxels):\n')
    table(('resolution', 'lambda', 'polygons', 'core to axis', 'axis to core'), rows)
    paper.save(sheet(pictures, ['core, by λ', *(f'λ = {t}' for t in LAMBDAS)], [f'{r}³' for r in resolutions], captions, 2.9), '2_9')


if __name__ == '__main__':
    main(make, __doc__)
