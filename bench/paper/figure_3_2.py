#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.2: three measures on the medial axis of a horse with hair: object angle, circumradius, erosion thickness; below, what
is left above the threshold at which half of the length is left. The horse is the silhouette of the data with hairs added, or
the pony of docs/figures where there is no data. MGF, which the program has in the plane, is printed too."""
import sys

import numpy as np
from matplotlib.collections import LineCollection
from paper import REPOSITORY, Complex, main, plt, table
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

sys.path.insert(0, str(REPOSITORY / 'docs/figures'))
from plane_figures import limb, pony  # noqa: E402

MEASURES = {'object_angle': 'object angle', 'radius': 'circumradius', 'erosion_thickness': 'erosion thickness', 'mgf': 'MGF'}


def horse(paper):
    """image[x, y], y up, and where the hairs are."""
    file = paper.real('images/horse.png')
    if file is None:
        return pony(), None
    pixels = plt.imread(file)
    inside = (pixels[..., :3].mean(-1) * pixels[..., 3] + 1 - pixels[..., 3] if pixels.shape[-1] == 4 else pixels[..., 0]) < 0.5
    smooth = np.pad(inside, 24)[::-1].T
    edge = np.argwhere(smooth & ~(np.roll(smooth, 1, 0) & np.roll(smooth, -1, 0) & np.roll(smooth, 1, 1) & np.roll(smooth, -1, 1)))
    x, y = np.indices(smooth.shape)
    image, random = smooth.copy(), np.random.default_rng(5)
    chosen, placed = random.permutation(len(edge)), []
    for k in chosen:  # hairs at the trunk, the neck and the back, 18 pixels apart
        px, py = edge[k]
        if py < 0.47 * smooth.shape[1] or any((px - a) ** 2 + (py - b) ** 2 < 18**2 for a, b in placed):
            continue
        near = smooth[max(0, px - 8):px + 9, max(0, py - 8):py + 9]
        away = np.array([px, py]) - np.mean(np.argwhere(near) + (max(0, px - 8), max(0, py - 8)), axis=0)
        if np.linalg.norm(away) < 1.5 or not near.any():
            continue
        away /= np.linalg.norm(away)
        start, tip = np.array([px, py]) - 3 * away, np.array([px, py]) + random.uniform(9, 15) * away
        far = (np.array([px, py]) + 24 * away).round().astype(int)
        if smooth[max(0, far[0] - 14):far[0] + 15, max(0, far[1] - 14):far[1] + 15].any():
            continue  # it would touch another limb
        image |= limb(x, y, [(*start, 3.2), (*tip, 1.0)])
        placed.append((px, py))
    return image, smooth


def pieces(lines):
    if not len(lines):
        return 0
    _, at = np.unique(lines, return_inverse=True)
    a, b = at.reshape(-1, 2).T
    n = at.max() + 1
    return connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(n, n)))[0]


def make(paper):
    image, smooth = horse(paper)
    file = paper.file('horse.pgm')
    file.write_bytes(f'P5 {image.shape[0]} {image.shape[1]} 255\n'.encode() + (255 * image.T).astype(np.uint8).tobytes())
    folder = paper.file('horse')
    paper.quench('run', file, '--threshold', 128, '--largest-component', '-o', folder)
    axis = Complex(folder / 'core.vtp')
    points, lines = axis.points[:, :2], axis.lines
    length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1)
    hair = np.zeros(len(lines), bool)
    if smooth is not None:
        middle = points[lines].mean(axis=1).round().astype(int)
        hair = ~smooth[tuple(middle.T)]
    figure, panels = plt.subplots(2, len(MEASURES), figsize=(15.5, 7), layout='constrained')
    rows = []
    for k, (name, title) in enumerate(MEASURES.items()):
        values = axis.at[name].astype(float)
        if name == 'erosion_thickness':
            values[axis.at['unburned'] == 1] = np.inf
        of_line = values[lines].min(axis=1)
        finite = of_line[np.isfinite(of_line)]
        order = np.argsort(of_line)[::-1]
        threshold = of_line[order][np.searchsorted(np.cumsum(length[order]), length.sum() / 2)]
        kept = of_line >= threshold
        parts = pieces(lines[kept])
        hairs = length[kept & hair].sum() / max(length[hair].sum(), 1e-9)
        rows.append((title, f'{threshold:.3g}', f'{length[kept].sum() / length.sum():.2f}', parts,
                     f'{100 * hairs:.0f} %' if smooth is not None else '', f'{finite.max():.1f}'))
        colour = plt.get_cmap('turbo')(np.clip(of_line / np.quantile(finite, 0.98), 0, 1))
        for row, chosen in ((0, np.ones(len(lines), bool)), (1, kept)):
            axes = panels[row][k]
            axes.imshow(image.T, cmap='gray_r', vmin=0, vmax=7, interpolation='nearest')
            axes.add_collection(LineCollection(points[lines[chosen]], colors=colour[chosen], linewidths=1.6))
            axes.invert_yaxis()
            axes.set_axis_off()
        panels[0][k].set_title(title, fontsize=12)
        panels[1][k].set_title(f'upper half: {parts} piece{"s" * (parts != 1)}', fontsize=10)
    print('Dissertation, without numbers: object angle keeps hair, circumradius loses legs, ET separates them and never falls apart.\n'
          'Here, above the threshold at which half of the length is left:\n')
    table(('measure', 'threshold', 'kept', 'pieces', 'of the axis in hairs kept', 'largest'), rows)
    paper.save(figure, '3_2')


if __name__ == '__main__':
    main(make, __doc__)
