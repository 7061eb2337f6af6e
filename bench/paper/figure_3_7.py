#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.7: the family of skeletons of the elk, theta2 in rows and theta1 in columns (bench/family.py has more of it). Sheets
blue, curves red. Figures: area of sheets, length of curves, Betti numbers: all the same."""
import numpy as np
from paper import CURVE, Complex, Scene, main, sheet, table

THETA2, THETA1 = ('0.01', '0.03', '0.1', 'inf'), ('0', '0.02', '0.05', 'inf')


def make(paper):
    mesh = paper.real('meshes/elk.off')
    if mesh is None:
        return
    core, burned = paper.file('elk160.vtp'), paper.file('elk160_burned.vtp')
    paper.quench('core', mesh, '--resolution', 160, '-o', core)
    paper.quench('burn', core, '-o', burned)
    surface = paper.surface(mesh)
    side = float(Complex(core).field['longest_side'].ravel()[0])
    pictures, captions, rows = [], [], []
    for theta2 in THETA2:
        line, texts = [], []
        for theta1 in THETA1:
            file = paper.file('member.vtp')
            paper.quench('skeleton', burned, '--theta2', theta2, '--theta1', theta1, '-o', file)
            member = Complex(file)
            area = member.areas().sum() / side**2 if member.count else 0
            curve = member.only_curves() if len(member.lines) else np.zeros(0, bool)
            length = np.linalg.norm(np.diff(member.points[member.lines[curve]], axis=1)[:, 0], axis=1).sum() / side
            rows.append((theta2, theta1, member.count, f'{area:.3f}', f'{length:.2f}', member.betti()))
            scene = Scene((-0.4, -0.3, -1), (0, 1, 0)).add(surface, (0.8, 0.8, 0.8), 0.07)
            scene.add(member.sheets()).add(member.curves(curve), CURVE, width=1.5 if theta1 == '0' else 4)
            line.append(scene.render((420, 360), surface.GetBounds()))
            texts.append(f'sheets {area:.2f}, curves {length:.1f}')
        pictures.append(line)
        captions.append(texts)
    print('Dissertation, without numbers: two parameters prune sheets and curves; topology stays. Units: longest side.\n')
    table(('theta2', 'theta1', 'polygons', 'area of sheets', 'length of curves', 'b0, b1, b2'), rows)
    paper.save(sheet(pictures, [f'θ₁ = {t}' for t in THETA1], [f'θ₂ = {t}' for t in THETA2], captions, 2.6), '3_7')


if __name__ == '__main__':
    main(make, __doc__)
