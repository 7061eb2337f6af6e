#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 3.6: nodes on the edges of polygons, prime arcs, regions, and the curve network dual to them: of the real burning of the
middle sheet of a plate with holes. (a) nodes, (b) arcs per sheet at a seam, drawn apart, (c) the prime arcs of vertices, read from
the burn sequence of the file, and the medial curves."""
import numpy as np
from matplotlib.collections import LineCollection
from paper import Complex, main, plt, table
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

OMEGA = 0.05  # of world units


def parts_of(axis, edges):
    """Into how many parts nodes split each edge."""
    length = np.linalg.norm(axis.points[edges[:, 0]] - axis.points[edges[:, 1]], axis=1)
    return np.maximum(1, np.ceil(length / float(axis.field['omega'].ravel()[0]) - 1e-9)).astype(int)


def sectors_at_vertices(axis, edges, side):
    """Per corner the sector of its vertex, counted over all vertices, and the first of each vertex. Corners are of one sector
    where they share an edge of exactly two polygons."""
    uses = np.bincount(side, minlength=len(edges))
    before = np.arange(len(axis.corners)) - 1
    before[axis.offsets[:-1]] = axis.offsets[1:] - 1
    # Two corners meet over an edge: that which the edge leaves from, and that of the other polygon with the same vertex.
    ends = {}
    links = []
    for corner, vertex in enumerate(axis.corners):
        for edge in (side[corner], side[before[corner]]):
            if uses[edge] == 2:
                links += [(corner, other) for other in ends.setdefault((edge, vertex), [])]
                ends[edge, vertex].append(corner)
    a, b = np.array(links).T
    n = len(axis.corners)
    part = connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(n, n)), directed=False)[1]
    of_vertex = {}
    for corner, vertex in enumerate(axis.corners):
        of_vertex.setdefault(vertex, {}).setdefault(part[corner], []).append(corner)
    return [list(of_vertex.get(v, {}).values()) for v in range(len(axis.points))]


def prime_arcs(axis, edges, side, parts):
    """Arcs along which fire came to vertices, as pairs of points with their polygon, of the burn sequence in the file
    (docs/user/files.md); and the number of states counted here."""
    sectors = sectors_at_vertices(axis, edges, side)
    uses = np.bincount(side, minlength=len(edges))
    states = sum(map(len, sectors)) + int(((parts - 1) * np.where(uses > 2, uses, np.minimum(uses, 1))).sum())
    stored = axis.field['sequence_parents'].ravel().astype(np.int64)
    large = dict(axis.field['sequence_large'].ravel().reshape(-1, 2)) if 'sequence_large' in axis.field else {}

    def boundary(face):
        found = []
        for c in range(axis.offsets[face], axis.offsets[face + 1]):
            p, q = axis.points[axis.corners[c]], axis.points[axis.corners[c + 1 if c + 1 < axis.offsets[face + 1] else axis.offsets[face]]]
            found += [p + (q - p) * k / parts[side[c]] for k in range(parts[side[c]])]
        return found

    arcs, state = [], 0
    for corners in (c for vertex in sectors for c in vertex):
        number = int(stored[state])
        number = large.get(state, number) if number == 255 else number
        state += 1
        if not number:
            continue
        way, chosen = divmod(number, len(corners))
        face = axis.polygon[corners[chosen]]
        nodes = boundary(face)
        at = int(parts[side[axis.offsets[face]:corners[chosen]]].sum())
        steps = (way + 1) // 2
        arcs.append((nodes[at], nodes[(at + steps if way % 2 else at - steps) % len(nodes)], face))
    return arcs, states, len(stored)


def crossings(a, b):
    """How many segments of a cross one of b properly, in the plane."""
    def turn(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    p, q, r, s = a[:, None, 0], a[:, None, 1], b[None, :, 0], b[None, :, 1]
    tiny = 1e-12
    return int(((turn(p, q, r) * turn(p, q, s) < -tiny) & (turn(r, s, p) * turn(r, s, q) < -tiny)).sum())


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
    edges, side = axis.edges()
    parts = parts_of(axis, edges)
    arcs, counted, stored = prime_arcs(axis, edges, side, parts)
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
    shown_faces = set(shown)
    for p, q, face in arcs:
        if face in shown_faces:
            duals.plot([p[0], q[0]], [p[1], q[1]], '-', color='#d7301f', lw=1.2, alpha=0.9)
            duals.plot(*p[:2], '.', color='#d7301f', ms=4)
    drawn = np.array([(p[:2], q[:2]) for p, q, face in arcs if face in shown_faces])
    duals.set_title('(c) prime arcs of vertices (red), medial curves (green)', fontsize=11)
    for axes in (nodes, seam, duals):
        axes.set_aspect('equal')
        axes.set_axis_off()
    duals.set_xlim(centre[0] - 0.42, centre[0] + 0.42)
    duals.set_ylim(centre[1] - 0.34, centre[1] + 0.34)
    rows = [(axis.count, len(edges), int(parts.sum() - len(edges) + len(axis.points)), int(axis.field['burn_nodes'].ravel()[0]), f'{counted}, {stored}', len(drawn),
             crossings(drawn, segments), len(network.lines), axis.betti(), network.betti())]
    print('Dissertation: the network dual to the arcs that burned has the topology of M.\n')
    table(('polygons', 'edges', 'nodes counted here', 'nodes of the program', 'states here, in the file', 'arcs drawn',
           'that cross a curve', 'segments of the curves', 'b of M', 'b of the curves'), rows)
    paper.save(figure, '3_6')


if __name__ == '__main__':
    main(make, __doc__)
