#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.13: Neptune with a small lambda (0.005) at resolutions 512 and 1024 (--large: 1024 and 2048, as in the dissertation)."""
import json

import numpy as np
from paper import Complex, Scene, colours, main, sheet, table


def make(paper):
    mesh = paper.real('meshes/neptune.off')
    if mesh is None:
        return
    surface = paper.surface(mesh)
    points = np.array([surface.GetPoint(i) for i in range(surface.GetNumberOfPoints())])
    low, high = points.min(0), points.max(0)
    up = int(np.argmax(high - low))
    above = np.eye(3)[up]
    view = np.roll(above, 1) + 0.6 * np.roll(above, 2) - 0.08 * above
    bounds = np.array([low, high]).T.ravel()
    # The trident: what is around the highest vertex.
    highest, size = points[np.argmax(points[:, up])], 0.11 * (high[up] - low[up])
    detail = np.array([highest - size - 0.8 * size * above, highest + size - 0.8 * size * above])
    rows, pictures, captions = [], [], []
    for resolution in (1024, 2048) if paper.options.large else (512, 1024):
        file, report = paper.file(f'neptune_{resolution}.vtp'), paper.file('neptune.json')
        cost = paper.quench('core', mesh, '--resolution', resolution, '--lambda', 0.005, '-o', file, '--json', report)
        said, core = json.loads(report.read_text()), Complex(file)
        rows.append((resolution, said['shape']['sites'], core.count, tuple(said['shape']['topology']['solid_betti']), core.betti(),
                     said['shape']['topology']['added'], f'{cost.cpu:.1f}', f'{cost.wall:.1f}', f'{cost.megabytes / 1000:.2f}'))
        top = np.quantile(core.at['radius'], 0.99)
        scene = Scene(view, above).add(core.sheets(), points=colours(core.at['radius'], 0, top))
        scene.add(core.curves(core.only_curves()), (0.1, 0.1, 0.5), width=2)
        pictures += [scene.render((480, 620), bounds, 1.12), scene.render((480, 620), detail.T.ravel(), 1.7)]
        captions += [f'{resolution}³: {core.count} polygons, {cost.cpu:.0f} s', 'trident']
    print('Dissertation: a small lambda for the trident; still affordable at 2048, smoother than at 1024. Here:\n')
    table(('resolution', 'boundary vertices', 'polygons', 'solid b0, b1, b2', 'core', 'voxels put in for topology', 'CPU s', 'wall s',
           'GB'), rows)
    paper.save(sheet([pictures], captions=[captions], width=3), '2_13')


if __name__ == '__main__':
    main(make, __doc__)
