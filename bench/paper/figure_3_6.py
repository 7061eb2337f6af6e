#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.6: nodes on the edges of polygons, prime arcs, regions, and the curve network dual to them: of the real burning of the
middle sheet of a plate with holes. (a) nodes, (b) arcs per sheet at a seam, drawn apart, (c) prime arcs and the medial curves."""
import numpy as np
from matplotlib.collections import LineCollection
from paper import Complex, main, plt, table

OMEGA = 0.05  # of world units


def states(axis):
    """Nodes inside edges, and the prime arcs (from, to, polygon) of the burn sequence (docs/user/files.md)."""
    edges, side = axis.edges()
    length = np.linalg.norm(axis.points[edges[:, 0]] - axis.points[edges[:, 1]], axis=1)
    return edges, side, np.maximum(1, np.ceil(length / float(axis.field['omega'].ravel()[0]) - 1e-9)).astype(int)


def make(paper):
    volume = paper.file('few.ply')
    paper.quench('sample', 'plate-with-holes', '-o', volume)
    core, burned = paper.file('few.vtp'), paper.file('few_burned.vtp')
    paper.quench('core', volume, '--resolution', 56, '--surface', 'voxels', '--lambda', 0, '-o', core)
    paper.quench('burn', core, '--omega', f'{OMEGA / 2}abs', '-o', burned)
    curves, hairs = paper.file('few_curves.vtp'), paper.file('few_hairs.vtp')
    paper.quench('skeleton', burned, '--theta2', 0, '--theta1', 'inf', '--smooth', 0, '--full', '-o', curves)
    paper.quench('skeleton', burned, '--theta2', 'inf', '--theta1', 0, '--smooth', 0, '--tips', 'pruned', '-o', hairs)
    axis, network = Complex(burned), Complex(hairs)
    middle = np.median(axis.points[:, 2])
    flat = axis.least(-np.abs(axis.points[:, 2] - middle)) > -1e-9
    edges, side, parts = states(axis)
    figure, (nodes, seam, duals) = plt.subplots(1, 3, figsize=(16, 4.9), layout='constrained', width_ratios=(1.1, 0.75, 1.6))
    shown = np.flatnonzero(flat)
    low, high = axis.points.min(0)[:2], axis.points.max(0)[:2]
    centre = low + (high - low) * (0.30, 0.42)
    shown = [f for f in shown if (np.abs(axis.points[axis.corners[axis.offsets[f]:axis.offsets[f + 1]], :2] - centre) < 0.42).all()]
    quarter = [f for f in shown if (np.abs(axis.points[axis.corners[axis.offsets[f]:axis.offsets[f + 1]], :2] - centre) < 0.17).all()]

    def outline(axes, f, **style):
        corner = axis.points[axis.corners[axis.offsets[f]:axis.offsets[f + 1]], :2]
        axes.fill(*corner.T, **style)

    for f in quarter:
        outline(nodes, f, fc='#eef2f6', ec='#8795a3', lw=0.8)
        for c in range(axis.offsets[f], axis.offsets[f + 1]):
            a, b = axis.points[edges[side[c]], :2]
            inner = np.linspace(0, 1, parts[side[c]] + 1)[1:-1, None]
            nodes.plot(*((1 - inner) * a + inner * b).T, 'o', ms=4, mfc='w', mec='k', mew=0.8)
    used = np.unique(np.concatenate([axis.corners[axis.offsets[f]:axis.offsets[f + 1]] for f in quarter]))
    nodes.plot(*axis.points[used, :2].T, 'ko', ms=5)
    nodes.set_title('(a) nodes at most ω apart', fontsize=11)

    # (b) a seam of three polygons, with one arc per polygon between neighbouring nodes.
    number = np.bincount(side, minlength=len(edges))
    seams = np.flatnonzero(number >= 3)
    count = int(number[seams[0]]) if len(seams) else 3
    t = np.linspace(0, 1, 6)
    for k in range(count):
        angle = 2 * np.pi * k / count + 0.4
        away = np.array([np.cos(angle), np.sin(angle)])
        seam.fill([0, away[0], away[0], 0], [0, away[1] * 0.8, away[1] * 0.8 + 3, 3], fc=f'C{k}', alpha=0.13, ec='none')
        for a, b in zip(t, t[1:]):
            s = np.linspace(0, 1, 20)
            bend = 0.10 * np.sin(np.pi * s)
            seam.plot(bend * away[0], 3 * (a + (b - a) * s) + bend * away[1], color=f'C{k}', lw=1.8)
    seam.plot(0 * t, 3 * t, 'o', color='darkorange', mec='k', ms=6)
    seam.set_title('(b) at a seam: an arc per sheet', fontsize=11)

    for f in shown:
        outline(duals, f, fc='#eef2f6', ec='#b9c4cf', lw=0.6)
    lies = (np.abs(network.points[network.lines][:, :, 2] - middle) < 1e-9).all(axis=1)
    segments = network.points[network.lines[lies]][:, :, :2]
    thick = network.at['curve_erosion_thickness'][network.lines[lies]].min(axis=1)
    duals.add_collection(LineCollection(segments, colors=['#1a9641' if t < 0.05 else '#0b5d2a' for t in thick],
                                        linewidths=[1.2 if t < 0.05 else 2.4 for t in thick]))
    # Where fire ran: from the corner of a polygon whose time is later by the way between them.
    time = axis.at['burn_time'].astype(float)
    for f in shown:
        corner = axis.corners[axis.offsets[f]:axis.offsets[f + 1]]
        for a in corner:
            gap = np.linalg.norm(axis.points[corner] - axis.points[a], axis=1)
            fit = np.where(gap > 0, np.abs(time[a] - time[corner] - gap) / np.maximum(gap, 1e-12), np.inf)
            if fit.min() < 0.03:
                duals.plot(*axis.points[[a, corner[fit.argmin()]], :2].T, '-', color='#d7301f', lw=1.2, alpha=0.8)
    duals.set_title('(c) where fire ran between vertices (red), medial curves (green)', fontsize=11)
    for axes in (nodes, seam, duals):
        axes.set_aspect('equal')
        axes.set_axis_off()
    duals.set_xlim(centre[0] - 0.42, centre[0] + 0.42)
    duals.set_ylim(centre[1] - 0.34, centre[1] + 0.34)
    rows = [(axis.count, len(edges), int(parts.sum() - len(edges) + len(axis.points)), int(axis.field['burn_nodes'].ravel()[0]),
             len(network.lines), axis.betti(), network.betti())]
    print('Dissertation: the network dual to the arcs that burned has the topology of M.\n')
    table(('polygons', 'edges', 'nodes counted here', 'nodes of the program', 'segments of the curves', 'b of M', 'b of the curves'), rows)
    paper.save(figure, '3_6')


if __name__ == '__main__':
    main(make, __doc__)
