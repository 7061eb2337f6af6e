#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.5: a burn time that no exposing tree attains. A tube stands on a plane sheet; the shortest way from x to the rim runs
along its foot. A path on the foot itself would have to send another one up the tube; one beside it need not. The
infimum is the length of a taut string around the foot, here known in closed form."""
import numpy as np
from matplotlib.tri import Triangulation
from paper import Complex, Scene, colours, main, plt, polydata, table

RADIUS, HEIGHT, SIDES = 1.5, 8.0, 48
LEFT, RIGHT, HALF = -4.0, 16.0, 12.0


def plate():
    """Points and triangles of the plate with the foot's circle among its edges, and of the tube on it."""
    from scipy.spatial import Delaunay
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    foot = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    rings = [foot * s for s in (1, 1.25, 1.6, 2.0, 0.66, 0.33)]
    random = np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(LEFT, RIGHT + 0.1, 0.5), np.arange(-HALF, HALF + 0.1, 0.5))
    grid = np.column_stack([x.ravel(), y.ravel()])
    inner = (np.abs(grid[:, 0] - (LEFT + RIGHT) / 2) < (RIGHT - LEFT) / 2 - 0.1) & (np.abs(grid[:, 1]) < HALF - 0.1)
    grid[inner] += random.uniform(-0.06, 0.06, (inner.sum(), 2))
    grid = grid[np.linalg.norm(grid, axis=1) > 2.2 * RADIUS]
    behind = np.array([(4, 0), (6, 0), (8, 0)])
    grid = grid[np.linalg.norm(grid[:, None] - behind, axis=2).min(axis=1) > 0.3]
    flat = np.concatenate([*rings, [[0, 0]], behind, grid])
    triangles = Delaunay(flat).simplices
    levels = 13
    tube = [np.column_stack([foot, np.full(SIDES, HEIGHT * k / levels)]) for k in range(1, levels + 1)]
    points = np.concatenate([np.column_stack([flat, np.zeros(len(flat))]), *tube])
    rows = [np.arange(SIDES)] + [len(flat) + SIDES * k + np.arange(SIDES) for k in range(levels)]
    for a, b in zip(rows, rows[1:]):
        for i in range(SIDES):
            j = (i + 1) % SIDES
            triangles = np.concatenate([triangles, [[a[i], a[j], b[j]], [a[i], b[j], b[i]]]])
    return points, triangles


def taut(x):
    """Length of the shortest way in the plane from (x, 0) around the foot (a polygon) to the left side."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    foot = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])[:SIDES // 2 + 1]  # the upper half
    best = np.inf
    for i in range(SIDES // 4 + 1):  # leaves the tangent at i, runs along the polygon to the top, then straight to the left
        chain = foot[i:SIDES // 4 + 1]
        way = np.linalg.norm(foot[i] - (x, 0)) + np.linalg.norm(np.diff(chain, axis=0), axis=1).sum() - LEFT + foot[SIDES // 4][0]
        side = np.cross(foot[i] - (x, 0), foot - (x, 0))
        if side.max() < 1e-9 or side.min() > -1e-9:
            best = min(best, way)
    return best


def make(paper):
    points, triangles = plate()
    # The fire starts on the left side at 0, everywhere else on the rim so late that it does not matter.
    top = (np.abs(points[:, 0] - RIGHT) < 1e-9) | (np.abs(np.abs(points[:, 1]) - HALF) < 1e-9) | (np.abs(points[:, 2] - HEIGHT) < 1e-9)
    radius = np.where(top & (np.abs(points[:, 0] - LEFT) > 1e-9), 40.0, 0.0)
    mesh, radii = paper.file('tube.obj'), paper.file('tube.r')
    mesh.write_text(''.join(f'v {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}\n' for p in points) +
                    ''.join(f'f {t[0] + 1} {t[1] + 1} {t[2] + 1}\n' for t in triangles))
    radii.write_text(f'{len(points)}\n' + ''.join(f'{p[0]:.9g} {p[1]:.9g} {p[2]:.9g} {r:.9g}\n' for p, r in zip(points, radius)))
    rows = []
    for omega in (0.4, 0.1):
        out = paper.file('tube.vtp')
        paper.quench('burn', mesh, '--radii', radii, '--omega', f'{omega}abs', '-o', out)
        axis = Complex(out)
        for x in (2.4, 3.0, 4.0, 6.0, 8.0):
            at = np.linalg.norm(axis.points - (x, 0, 0), axis=1).argmin()
            if np.linalg.norm(axis.points[at] - (x, 0, 0)) > 0.2:
                continue
            p = axis.points[at]
            if abs(p[1]) < 1e-6:
                rows.append((omega, f'{p[0]:.2f}', f'{axis.at["burn_time"][at]:.4f}', f'{taut(p[0]):.4f}',
                             f'{axis.at["burn_time"][at] / taut(p[0]) - 1:+.2%}', f'{p[0] - LEFT:.2f}'))
    print('Burn time at points (x, 0) behind the tube: the fire comes around the foot beside the seam. A tree that touches the '
          f'foot would\nhave to reach the top of the tube too, {HEIGHT + 40:g} later than 0.\n')
    table(('omega', 'x', 'BT of the program', 'infimum (taut string)', 'difference', 'straight through the foot'), rows)
    time = axis.at['burn_time'].astype(float)
    order = np.array([np.linalg.norm(axis.points - p, axis=1).argmin() for p in points])
    shown = time[order]
    at_foot = np.arange(SIDES)
    for i in at_foot:  # beside the seam the sheet burns earlier than the seam itself, whose time the file has
        around = np.unique(triangles[(triangles == i).any(axis=1)])
        outside = around[(points[around, 2] < 1e-9) & (np.linalg.norm(points[around], axis=1) > RADIUS + 1e-6)]
        shown[i] = (shown[outside] + np.linalg.norm(points[outside] - points[i], axis=1)).min()

    keep = [t for t in triangles if (points[t][:, 2] < 1e-9).all() and np.linalg.norm(points[t].mean(axis=0)) > RADIUS]
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 5.4), layout='constrained')
    scene = Scene((0.45, 1.0, -0.75))
    scene.add(polydata(points, 3 * np.arange(len(triangles) + 1), triangles), points=colours(np.where(points[:, 2] < 1e-9, shown, 60), 0, 16))
    left.imshow(scene.render((900, 760), (-4, 8, -5, 5, 0, 7)))
    left.set_axis_off()
    left.set_title('burn time (the tube burns last)')
    right.tricontourf(Triangulation(points[:, 0], points[:, 1], np.array(keep)), shown, np.arange(0, 22.1, 0.5),
                      cmap='turbo', extend='max')
    right.add_patch(plt.Circle((0, 0), RADIUS, fc='w', ec='r', lw=2))
    x, phi = 4.0, np.arccos(RADIUS / 4.0)
    arc = np.linspace(phi, np.pi / 2, 30)
    right.plot(np.r_[x, RADIUS * np.cos(arc), LEFT], np.r_[0, RADIUS * np.sin(arc), RADIUS], 'k-', lw=1.6)
    right.plot(x, 0, 'ko')
    right.text(x + 0.25, 0, 'x')
    right.set_aspect('equal')
    right.set_xlim(LEFT, 10)
    right.set_ylim(-6, 6)
    right.set_title('isochrones on the plate; the way beside the foot')
    paper.save(figure, '3_5')


if __name__ == '__main__':
    main(make, __doc__)
