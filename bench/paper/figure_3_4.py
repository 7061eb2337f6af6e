#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.4: burning of the medial axis of a board with a fin, at five times and at the end. What has burned is grey and pale;
the rest is coloured by its burn time. Figures: area that is left, and its connected pieces."""
import numpy as np
from paper import Complex, Scene, colours, main, sheet, table


def make(paper):
    mesh = paper.sample('fin-on-board')
    core, burned = paper.file('fin.vtp'), paper.file('fin_burned.vtp')
    paper.quench('core', mesh, '--resolution', 200, '--surface', 'voxels', '-o', core)
    paper.quench('burn', core, '-o', burned)
    axis = Complex(burned)
    surface = paper.surface(mesh)
    time = axis.at['burn_time'].astype(float)
    last = time.max()
    view = (-0.75, -1.3, -0.75)
    bounds = surface.GetBounds()
    area = axis.areas()
    inner = axis.least(time)
    rows, pictures, captions = [], [], []
    pictures.append(Scene(view).add(surface, (0.75, 0.72, 0.66), smooth=False).render((620, 400), bounds))
    captions.append('the shape')
    for k, share in enumerate((0.20, 0.34, 0.48, 0.62, 0.80), 1):
        t = share * last
        left = inner > t
        pieces = axis.pieces(left)
        rows.append((f'T{k}', f'{t:.3f}', f'{100 * area[left].sum() / area.sum():.1f} %', int((pieces > 1e-4 * area.sum()).sum())))
        scene = Scene(view).add(axis.sheets(~left), (0.8, 0.8, 0.8), 0.16)
        scene.add(axis.sheets(left), points=colours(time, 0, last))
        pictures.append(scene.render((620, 400), bounds))
        captions.append(f'T{k} = {t:.2f}: {100 * area[left].sum() / area.sum():.0f} % left')
    whole = Scene(view).add(axis.sheets(), points=colours(time, 0, last))
    pictures.append(whole.render((620, 400), bounds))
    captions.append(f'burn time, up to {last:.2f}')
    et = axis.thickness()
    pictures.append(Scene(view).add(axis.sheets(), points=colours(et, 0, et.max())).render((620, 400), bounds))
    captions.append(f'erosion thickness, up to {et.max():.2f}')
    fin = (np.abs(axis.points[:, 1]) < 0.02) & (axis.points[:, 2] > 0.3)
    print(f'The fin burns from its rim and dies out at the seam: its latest burn time is {time[fin].max():.3f} '
          f'(radius there {axis.at["radius"][fin].max():.3f}), that of the board {last:.3f}; {int(axis.at["unburned"].sum())} points '
          'never burn.\n')
    table(('time', '', 'area left', 'pieces above a ten-thousandth'), rows)
    paper.save(sheet([pictures[:4], pictures[4:]], captions=[captions[:4], captions[4:]], width=3.6), '3_4')


if __name__ == '__main__':
    main(make, __doc__)
