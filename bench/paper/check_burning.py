#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Statements of chapters 3 and B of Yan 2018 on burned cores: Lemma B.1.1, Thms. B.1.1, B.1.2, B.1.3 and 3.4.1 (B.2.1), and that
thresholds of ET alone disconnect a medial axis (sec. 3.4.4), which is why skeletons are thinned."""
import numpy as np
from paper import Complex, main, table

SHAPES = {'fin-on-board': ('--resolution', 96, '--detail', 'auto'), 'rippled-box': ('--resolution', 96, '--lambda', '1.5vox'),
          'bumpy-sphere': ('--resolution', 48, '--lambda', '1.5vox')}


class Burned(Complex):
    def __init__(self, paper, core, omega):
        out = paper.file('check_burned.vtp')
        paper.quench('burn', core, '--omega', omega, '-o', out)
        super().__init__(out)
        self.edge, self.side = self.edges()
        self.length = np.linalg.norm(self.points[self.edge[:, 0]] - self.points[self.edge[:, 1]], axis=1)
        self.uses = np.bincount(self.side, minlength=len(self.edge))
        n = len(self.points)
        self.rim, self.singular = np.zeros(n, bool), np.zeros(n, bool)
        self.rim[self.edge[self.uses == 1]] = True
        self.singular[self.edge[self.uses > 2]] = True
        self.singular[self.lines] = True
        self.et = self.thickness()


def pockets(axis):
    """Points of the largest part without rim: polygons with a side of their own are removed until there is none."""
    alive, uses = np.ones(axis.count, bool), axis.uses.copy()
    while True:
        free = alive & (np.minimum.reduceat(uses[axis.side], axis.offsets[:-1]) == 1)
        if not free.any():
            break
        uses -= np.bincount(axis.side[free[axis.polygon]], minlength=len(uses))
        alive &= ~free
    found = np.zeros(len(axis.points), bool)
    found[axis.corners[alive[axis.polygon]]] = True
    return found


def minima(axis):
    """Points inside M whose ET is below that of all other corners of the polygons around."""
    least = np.full(len(axis.points), np.inf)
    value = axis.et[axis.corners]
    first = np.minimum.reduceat(value, axis.offsets[:-1])
    # The least of the other corners of a polygon: its least, or its second least for the corner that has it.
    masked = np.where(value == first[axis.polygon], np.inf, value)
    second = np.minimum.reduceat(masked, axis.offsets[:-1])
    several = np.add.reduceat((value == first[axis.polygon]).astype(int), axis.offsets[:-1]) > 1
    other = np.where((value == first[axis.polygon]) & ~several[axis.polygon], second[axis.polygon], first[axis.polygon])
    np.minimum.at(least, axis.corners, other)
    inner = np.isfinite(least) & ~axis.rim & np.isfinite(axis.et)
    inner[axis.lines] = False
    return inner, inner & (axis.et < least - 1e-9), least


def make(paper):
    rows = []
    for name, options in SHAPES.items():
        mesh, core = paper.sample(name), paper.file(f'check_{name}.vtp')
        paper.quench('core', mesh, '--surface', 'voxels', *options, '-o', core)
        voxel = float(Complex(core).field['spacing'].ravel()[0])
        fine = Burned(paper, core, '0.12vox')
        a, b = fine.edge.T
        radius = fine.at['radius'].astype(float)
        slope = np.abs(radius[a] - radius[b]) / fine.length
        rows.append(('Lemma B.1.1', name, f'largest |R(x) − R(y)| / |xy| on {len(a)} edges: {slope.max():.9f}', 'holds'))
        sheet = ~(fine.singular | fine.rim) & np.isfinite(fine.et)
        both = sheet[a] & sheet[b]
        ratio = np.abs(fine.et[a] - fine.et[b])[both] / fine.length[both]
        rows.append(('Thm. B.1.2 (1)', name, f'largest |ET(x) − ET(y)| / |xy| on {both.sum()} edges inside sheets: '
                     f'{ratio.max():.4f}, bound 2',
                     'holds' if ratio.max() <= 2.001 else 'see text'))
        at_seam = fine.singular[a] & sheet[b]
        jump = ((fine.et[b] - fine.et[a]) / fine.length)[at_seam]
        other = fine.singular[b] & sheet[a]
        jump = np.concatenate([jump, ((fine.et[a] - fine.et[b]) / fine.length)[other]])
        if len(jump):
            rows.append(('Thm. B.1.2 (2a)', name, f'largest (ET(y) − ET(x)) / |xy|, x on a seam, y beside: {jump.max():.4f}, '
                         f'bound 2; least {jump.min():.1f} (jumps downwards)', 'holds' if jump.max() <= 2.001 else 'see text'))
        texts = []
        for omega in ('2vox', '0.5vox', '0.12vox'):
            axis = fine if omega == '0.12vox' else Burned(paper, core, omega)
            inner, low, least = minima(axis)
            depth = (least - axis.et)[low].max() / voxel if low.any() else 0
            texts.append(f'{omega}: {low.sum()} of {inner.sum()}' + (f' (by {depth:.3f} voxel at most)' if low.any() else ''))
        rows.append(('Thm. B.1.3', name, 'vertices below all around, by ω: ' + '; '.join(texts),
                     'holds' if not low.any() else 'nearly'))
        for omega in (2, 1, 0.5):
            axis = Burned(paper, core, f'{omega}vox')
            finite = np.isfinite(axis.et) & np.isfinite(fine.et)
            error = (axis.et - fine.et)[finite] / voxel
            rows.append(('Thm. 3.4.1', f'{name}, ω = {omega} vox', f'ET_G − ET from {error.min():.3f} to {error.max():.3f} '
                         f'voxels; bound 0 to {(2 * axis.count + 1) * omega:.0f}', 'right side holds, left up to the error of fronts'))
        parts = fine.pieces(fine.least(fine.et) > 0.25 * fine.et[np.isfinite(fine.et)].max())
        rows.append(('sec. 3.4.4', name, f'pieces above a quarter of the largest ET: {len(parts)}',
                     'thinning is needed' if len(parts) > 1 else 'connected'))
    mesh, core = paper.sample('hollow-sphere'), paper.file('check_hollow.vtp')
    paper.quench('core', mesh, '--resolution', 32, '--surface', 'voxels', '--lambda', '1.5vox', '-o', core)
    axis = Burned(paper, core, '1vox')
    closed, never = pockets(axis), axis.at['unburned'] == 1
    rows.append(('Thm. B.1.1', 'hollow-sphere', f'{never.sum()} points never burn, {closed.sum()} lie on the largest closed '
                 f'part; {(never != closed).sum()} differ', 'holds' if (never == closed).all() else 'does not hold'))
    table(('statement', 'shape', 'measured', ''), rows)


if __name__ == '__main__':
    main(make, __doc__)
