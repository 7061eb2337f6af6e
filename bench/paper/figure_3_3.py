#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.3: burn time, radius and erosion thickness of an ellipse and of a flat ellipsoid, each with a small bump. Figures: ET
at the centre and at the place where the branch (sheet) of the bump leaves the rest."""
import numpy as np
from matplotlib.collections import LineCollection
from paper import Complex, Scene, colours, main, plt, table, write_nrrd

SHADES = ('burn_time', 'radius', 'erosion_thickness')
TITLES = ('burn time BT', 'radius R', 'erosion thickness ET = BT − R')


def along(axis, length=1.5):
    """Pieces of the edges of an axis of the plane, with R, BT and ET in their middles: R^2 is a quadratic along an edge, and the
    earlier of the fires from both ends counts."""
    segments, values = [], {name: [] for name in SHADES}
    for a, b in axis.lines:
        p, q = axis.points[a, :2], axis.points[b, :2]
        size = np.linalg.norm(q - p)
        t = np.linspace(0, size, max(1, int(np.ceil(size / length))) + 1)
        middle = (t[1:] + t[:-1]) / 2
        (r, s), (u, v) = axis.at['radius'][[a, b]], axis.at['burn_time'][[a, b]]
        radius = np.sqrt(r**2 + (s**2 - r**2 - size**2) * middle / size + middle**2)
        time = np.minimum(u + middle, v + size - middle)
        at = p + (q - p) * (t / size)[:, None]
        segments += list(np.stack([at[:-1], at[1:]], 1))
        for name, found in zip(SHADES, (time, radius, time - radius)):
            values[name] += list(found)
    return segments, {name: np.array(found) for name, found in values.items()}


def make(paper):
    x, y = np.indices((260, 150))
    plane = ((x - 130) / 120) ** 2 + ((y - 70) / 52) ** 2 < 1
    plane |= (x - 175) ** 2 + (y - 117) ** 2 < 9**2  # the bump
    file = paper.file('bump.pgm')
    file.write_bytes(b'P5 260 150 255\n' + (255 * plane.T).astype(np.uint8).tobytes())
    paper.quench('run', file, '--threshold', 128, '-o', paper.file('bump'))
    axis = Complex(paper.file('bump') / 'core.vtp')

    a, b, c = np.indices((140, 96, 48))
    solid = ((a - 70) / 64) ** 2 + ((b - 48) / 42) ** 2 + ((c - 20) / 14) ** 2 < 1
    solid |= (a - 90) ** 2 + (b - 55) ** 2 + (c - 31) ** 2 < 6**2
    volume = write_nrrd(paper.file('bump.nrrd'), solid)
    paper.quench('core', volume, '--threshold', 1, '--surface', 'voxels', '--subdivide', 2, '--lambda', '3.0abs', '-o',
                 paper.file('bump.vtp'))
    paper.quench('burn', paper.file('bump.vtp'), '-o', paper.file('bump_burned.vtp'))
    sheetlike = Complex(paper.file('bump_burned.vtp'))

    figure, panels = plt.subplots(2, 3, figsize=(14, 5.6), layout='constrained')
    top = max(axis.at['burn_time'].max(), 1)
    segments, values = along(axis)
    for k, name in enumerate(SHADES):
        panel = panels[0][k]
        panel.imshow(plane.T, cmap='gray_r', vmin=0, vmax=7, origin='lower')
        panel.add_collection(LineCollection(segments, colors=plt.get_cmap('turbo')(np.clip(values[name] / top, 0, 1)), linewidths=3))
        panel.set_title(TITLES[k], fontsize=13)
        panel.set_axis_off()
    points = axis.points[:, :2]
    hottest = sheetlike.at['burn_time'].max()
    for k, name in enumerate(SHADES):
        scene = Scene((-0.5, -1, -0.9))
        scene.add(sheetlike.sheets(), points=colours(sheetlike.at[name].astype(float), 0, hottest))
        scene.add(sheetlike.curves(sheetlike.only_curves()), (0.1, 0.1, 0.5), width=3)
        panels[1][k].imshow(scene.render((760, 420), zoom=1.15))
        panels[1][k].set_axis_off()

    in_bump = points[:, 1] > 104
    rising = sheetlike.points[:, 2] > 23
    rows = [('ellipse 120 × 52, in pixels', 'largest', *(f'{axis.at[n].max():.1f}' for n in SHADES)),
            ('', 'branch into the bump', *(f'{axis.at[n][in_bump].max():.1f}' for n in SHADES)),
            ('ellipsoid 64 × 42 × 14, in voxels', 'largest', *(f'{sheetlike.at[n].max():.1f}' for n in SHADES)),
            ('', 'sheet into the bump', *(f'{sheetlike.at[n][rising].max():.1f}' if rising.any() else 'pruned' for n in SHADES))]
    print('Dissertation, without numbers: BT and R are large on the branch of the bump, their difference is not.\n')
    table(('shape', 'where', *TITLES), rows)
    paper.save(figure, '3_3')


if __name__ == '__main__':
    main(make, __doc__)
