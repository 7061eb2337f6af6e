#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.8: a CT scan of maize roots: surface, medial axis, and the curve skeleton coloured by radius; and the same of a
made-up root at the size of the dissertation's scan (--large)."""
import json

import numpy as np
from paper import Complex, Scene, colours, isosurface, main, plt, read_nrrd, table


def make(paper):
    volume = paper.real('volumes/maize_root_ct.nrrd')
    if volume is None:
        return
    shape = ('--threshold', 'thin', '--close', 3, '--fill-cavities', '--largest-component')
    folder = paper.file('maize')
    cost = paper.quench('core', volume, *shape, '-o', paper.file('maize.vtp'), '--json', paper.file('maize.json'))
    said = json.loads(paper.file('maize.json').read_text())
    whole = paper.quench('run', volume, *shape, '--theta2', 'inf', '-o', folder)
    axis, curves = Complex(folder / 'core.vtp'), Complex(folder / 'skeleton.vtp')
    samples, spacing, origin = read_nrrd(volume)
    surface = isosurface(samples, 12, spacing, origin)
    view, down = (-1, -0.25, 0.1), (0, 0, -1)
    low, high = curves.points.min(0), curves.points.max(0)
    bounds = np.array([low, high]).T.ravel()
    middle = low + (high - low) * (0.5, 0.35, 0.30)
    near = np.array([middle - 0.11 * (high - low).max(), middle + 0.11 * (high - low).max()]).T.ravel()
    top = np.quantile(axis.at['radius'], 0.995)
    scenes = [Scene(view, down).add(surface, (0.72, 0.62, 0.48)),
              Scene(view, down).add(axis.sheets(), points=colours(axis.at['radius'], 0, top)).add(axis.curves(axis.only_curves()), width=2),
              Scene(view, down).add(surface, (0.7, 0.7, 0.7), 0.08).add(curves.curves(), points=colours(curves.at['radius'], 0, top),
                                                                  width=5, light=False)]
    rows = [[s.render((600, 820), bounds) for s in scenes], [s.render((600, 560), near) for s in scenes]]
    figure = plt.figure(figsize=(10, 8.0))
    for i, row in enumerate(rows):
        for k, pixels in enumerate(row):
            axes = figure.add_axes([(k + 0.005) / 3, 0.005 if i else 0.40, 0.33, 0.39 if i else 0.565])
            axes.imshow(pixels)
            axes.set_axis_off()
            if not i:
                axes.set_title(('surface of the scan', 'medial axis, by radius', 'curve skeleton, by radius')[k], fontsize=12)
    paper.save(figure, '2_8')
    rows = [('dissertation: corn, 4 weeks', '1560 × 789 × 1041', '', '< 60 (wall)', '1500', '')]
    rows.append(('maize_root_ct', ' × '.join(map(str, said['shape']['dims'])), said['shape']['sites'], f'{cost.cpu:.1f}',
                 f'{cost.megabytes:.0f}', f'{whole.cpu:.1f} s, {whole.megabytes:.0f} MB'))
    if paper.options.large:
        root = paper.file('root1560.nrrd')
        if not root.exists():
            paper.quench('sample', 'root', '--resolution', 1560, '-o', root)
        cost = paper.quench('core', root, '--threshold', 1, '-o', paper.file('root1560.vtp'), '--json', paper.file('root.json'))
        said = json.loads(paper.file('root.json').read_text())
        rows.append(('sample root', ' × '.join(map(str, said['shape']['dims'])), said['shape']['sites'], f'{cost.cpu:.1f}',
                     f'{cost.megabytes:.0f}', ''))
    table(('volume', 'dims', 'boundary vertices', 'medial axis, CPU s', 'MB', 'with burning and skeleton'), rows)
    print(f'\nTopology of the shape {tuple(axis.betti())}, of the curve skeleton {tuple(curves.betti())}.')


if __name__ == '__main__':
    main(make, __doc__)
