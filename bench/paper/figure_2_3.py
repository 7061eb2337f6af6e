#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.3: a shape of pixels, its core with pixels split into 1, 2, 4 and 8 to the side, and the true medial axis.

The true axis is that of docs/figures/plane_figures.py: points on bisectors of two parts of the boundary that are nearest."""
import sys

import numpy as np
from paper import REPOSITORY, Complex, main, plt, table
from scipy.spatial import cKDTree

sys.path.insert(0, str(REPOSITORY / 'docs/figures'))
from plane_figures import shorter, small_shape, true_axis  # noqa: E402

PARTS = (1, 2, 4, 8)


def make(paper):
    image = small_shape()  # image[x, y]
    file = paper.file('small.pgm')
    file.write_bytes(f'P5 {image.shape[0]} {image.shape[1]} 255\n'.encode() + (255 * image.T).astype(np.uint8).tobytes())
    lines = true_axis(image)
    truth = np.concatenate(lines)
    tree = cKDTree(truth)
    figure, panels = plt.subplots(2, len(PARTS), figsize=(3.4 * len(PARTS), 5.9), layout='constrained')
    zoom = ((9.6, 12.4), (0.9, 3.7))
    rows = []
    for (panel, close), parts in zip(panels.T, PARTS):
        result = paper.file(f'small2d_{parts}.vtp')
        paper.quench('core', file, '--threshold', 128, '--subdivide', parts, '--detail', 0, '-o', result)
        core = Complex(result)
        points = core.points[:, :2]
        along = np.concatenate([np.linspace(*points[edge], 1 + int(400 / parts)) for edge in core.lines])
        far, back = tree.query(along)[0].max(), cKDTree(along).query(truth)[0].max()
        rows.append((f'1/{parts}', len(core.lines), f'{far:.3f}', 1 / (8 * parts), 1 / (4 * parts), f'{back:.3f}'))
        for axes in (panel, close):
            for x, y in np.argwhere(np.kron(image, np.ones((parts, parts), bool))) / parts - 0.5:
                axes.add_patch(plt.Rectangle((x, y), 1 / parts, 1 / parts, fc='#e9eef3', ec='#c4ced8', lw=0.5))
            for line in shorter(lines):
                axes.plot(*line.T, color='#2e9e4f', lw=3.2 if axes is panel else 6, solid_capstyle='round')
            for edge in core.lines:
                axes.plot(*points[edge].T, '.-' if axes is close else '-', color='#1f4fa3', lw=1.3)
            axes.set_aspect('equal')
            axes.set_axis_off()
        panel.add_patch(plt.Rectangle((zoom[0][0], zoom[1][0]), 2.8, 2.8, fc='none', ec='k', ls=':', lw=0.8))
        panel.autoscale_view()
        close.set_xlim(*zoom[0])
        close.set_ylim(*zoom[1])
        panel.set_title(f'pixels of 1/{parts}' if parts > 1 else 'pixels', fontsize=11)
        panel.text(0.5, -0.02, f'core to axis {far:.3f}, axis to core {back:.3f}', transform=panel.transAxes, ha='center',
                   va='top', fontsize=9)
    print('Distances in pixels of the shape; the dissertation shows the figure without numbers and has h/4 in 3D.\n')
    table(('pixel h', 'edges', 'core to axis, at most', 'bound in the plane, h/8', 'h/4', 'axis to core, at most'), rows)
    paper.save(figure, '2_3')


if __name__ == '__main__':
    main(make, __doc__)
