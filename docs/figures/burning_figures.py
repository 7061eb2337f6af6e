# SPDX-License-Identifier: Apache-2.0
"""Figures of burning, curves, skeletons and the curve graph."""
import math

import numpy as np

from svg import BLUE, GREEN, GREY, INK, LIGHT, MINT, ORANGE, PALE, RED, SAND, SKY, Figure, between, inside_contour, ramp


def burning():
    figure = Figure(920, 360)
    panel = figure.panel(40, 85, 44)
    half = 0.55
    x = np.linspace(0, 9, 181)
    bump = half + 0.5 * np.exp(-(((x - 3.2) / 0.33) ** 2))
    shape = [(0, half)] + [(float(a), float(b)) for a, b in zip(x, bump)] + [(9, half), (9, -half), (0, -half)]
    panel.polygon(shape, fill=PALE, stroke=GREY, width=1.5)
    panel.line((half, 0), (9 - half, 0), stroke=BLUE, width=2.6)
    for sx, ex in ((0, half), (9, 9 - half)):
        for sy in (-half, half):
            panel.line((sx, sy), (ex, 0), stroke=BLUE, width=1.2)
    panel.line((3.2, 0), (3.2, 0.62), stroke=ORANGE, width=2.4)
    panel.circle((5.6, 0), half, stroke=GREY, width=1, dash='4 3')
    panel.line((5.6, 0), (5.6, half), stroke=GREY, width=1)
    panel.text((5.6, half / 2), 'R', dx=9, dy=4, size=13, fill=GREY, style='italic')
    panel.text((3.2, 0.7), 'sheet under the bump', dx=28, dy=-4, anchor='start', size=12, fill=ORANGE)
    graph = figure.panel(40, 312, 44)
    graph.line((0, 0), (9.2, 0), stroke=GREY, width=1)
    graph.line((0, 0), (0, 3.4), stroke=GREY, width=1)
    burn = [(float(a), 0.72 * (half + min(a - half, 9 - half - a))) for a in np.linspace(half, 9 - half, 50)]
    radius = [(half, 0.72 * half), (9 - half, 0.72 * half)]
    graph.polygon(burn + radius[::-1], fill=SKY, opacity=0.7)
    graph.path(burn, stroke=BLUE, width=2.4)
    graph.path(radius, stroke=INK, width=2)
    graph.line((4.5, 0.72 * half), (4.5, 0.72 * 4.42), stroke=BLUE, width=1, dash='4 3')
    graph.text((4.5, 1.5), 'ET', dx=8, anchor='start', fill=BLUE, size=15, style='italic')
    graph.text((7.1, 1.9), 'BT', anchor='start', fill=BLUE, size=14, style='italic')
    graph.text((8.6, 0.72 * half), 'R', anchor='start', dy=5, size=14, style='italic')
    graph.path([(3.2, 0.72 * 0.47), (3.2, 0.72 * 0.95)], stroke=ORANGE, width=5)
    graph.text((3.2, 0.72 * 1.0), 'ET of the bump', dy=-8, size=12, fill=ORANGE)
    graph.text((0, 3.4), 'time', anchor='start', dx=6, dy=4, size=12, fill=GREY)
    figure.text(240, 345, 'along the axis of the plate', size=13)
    panel = figure.panel(520, 300, 58)
    w, h = 6.2, 4.2
    for k in range(7):
        d = 0.3 * k
        panel.rectangle((d, d), (w - d, h - d), fill=ramp(k / 6.5), stroke='#ffffff', width=1, opacity=0.55)
    panel.rectangle((0, 0), (w, h), stroke=INK, width=2)
    left, right = (h / 2, h / 2), (w - h / 2, h / 2)
    panel.line(left, right, stroke=RED, width=3)
    for a, b in ((left, (0, 0)), (left, (0, h)), (right, (w, 0)), (right, (w, h))):
        panel.line(a, b, stroke=RED, width=1.6)
    panel.arrow((w * 0.42, 0.12), (w * 0.42, 0.9), stroke='#ffffff', width=2)
    panel.arrow((0.12, h * 0.55), (0.9, h * 0.55), stroke='#ffffff', width=2)
    figure.text(700, 345, 'isochrones in a sheet, and where its fires meet', size=13)
    figure.save('burning.svg')


def burning_links():
    figure = Figure(940, 380)
    panel = figure.panel(215, 310, 46)
    v, top = (0, 0), (0.25, 5)
    sheets = [((-3.6, 0.7), BLUE, SKY), ((1.9, -0.5), GREEN, MINT), ((3.3, 1.1), ORANGE, SAND)]
    for (dx, dy), colour, pale in sheets[::-1]:
        far = [(v[0] + dx, v[1] + dy), (top[0] + dx * 0.92, top[1] + dy * 0.92)]
        panel.polygon([v, far[0], far[1], top], fill=pale, stroke=colour, width=1.6, opacity=0.75)
        for a, b in ((v, far[0]), far, (far[1], top)):
            for k in range(1, 4):
                panel.dot(between(a, b, k / 4), 3.2, fill=colour)
        for corner in far:
            panel.dot(corner, 4.2, fill=colour, stroke='#ffffff')
    panel.line(v, top, stroke=INK, width=4)
    for k in range(1, 5):
        p = between(v, top, k / 5)
        for (dx, dy), (_, colour, _) in zip(((-0.2, 0.04), (0.2, -0.12), (0.42, 0.1)), sheets):
            panel.dot((p[0] + dx, p[1] + dy), 4.4, fill=colour, stroke='#ffffff')
    panel.dot(v, 6.5, fill=RED, stroke='#ffffff')
    panel.text(v, 'v', dx=-2, dy=24, fill=RED, size=16, style='italic')
    panel.text(top, 'seam', dy=-10, size=13)
    panel.text((-0.5, 3.0), 'three states', anchor='end', dx=-2, dy=-12, size=12, fill=GREY)
    panel.text((-0.5, 3.0), 'per node here', anchor='end', dx=-2, dy=4, size=12, fill=GREY)
    figure.text(240, 368, 'nodes of three polygons', size=13)
    link = figure.panel(690, 175, 92)
    south, north = (0, -1.25), (0, 1.25)
    for bend, colour, name in ((-1.25, BLUE, 's1'), (0.05, GREEN, 's2'), (1.3, ORANGE, 's3')):
        arc = [(bend * math.sin(math.pi * t), -1.25 + 2.5 * t) for t in np.linspace(0, 1, 40)]
        link.path(arc, stroke=colour, width=3)
        link.dot(arc[20], 4, fill='#ffffff', stroke=colour, width=2)
        link.text(arc[20], name, dx=22, dy=5, size=14, fill=colour, style='italic')
    for p, text, dy in ((south, 'seam, downward', 26), (north, 'seam, upward', -14)):
        link.dot(p, 7, fill=INK)
        link.text(p, text, dy=dy, size=13)
    link.text((0.2, -1.25), 'degree 3', dx=0, dy=4, anchor='start', size=12, fill=GREY)
    link.text((0.2, 1.25), 'degree 3', dx=0, dy=4, anchor='start', size=12, fill=GREY)
    figure.text(700, 368, 'link of a node on the seam: three sectors, two cycles', size=13)
    figure.save('burning_links.svg')


def burning_fronts():
    figure = Figure(1000, 560)
    base_y = 0.0
    corners = [(-2.6, base_y), (3.2, base_y), (1.5, 3.5), (-1.4, 2.9)]
    far = []
    for a, b in zip(corners[1:], corners[2:] + corners[:1]):
        far += [between(a, b, k / 9) for k in range(1, 9)]
    n1, n2 = (-0.55, base_y), (0.95, base_y)

    def lit(source, low, high, node):
        t = (base_y - source[1]) / (node[1] - source[1])
        return low - 1e-9 <= source[0] + t * (node[0] - source[0]) <= high + 1e-9

    def fan(panel, source, low, high, colour, pale):
        region = [(low, base_y), (high, base_y)]
        reach = []
        for x in np.linspace(high, low, 60):
            best = None
            direction = (x - source[0], base_y - source[1])
            for a, b in zip(corners[1:], corners[2:] + corners[:1]):
                e = np.subtract(b, a)
                det = direction[0] * -e[1] + direction[1] * e[0]
                if abs(det) < 1e-12:
                    continue
                r = np.subtract(a, source)
                s = (r[0] * -e[1] + r[1] * e[0]) / det
                u = (direction[0] * r[1] - direction[1] * r[0]) / det
                if -1e-9 <= u <= 1 + 1e-9 and s > 1:
                    best = (source[0] + s * direction[0], source[1] + s * direction[1])
            if best:
                reach.append(best)
        corner_points = [c for c in corners[2:] if lit(source, low, high, c)]
        points = region + sorted(reach + corner_points, key=lambda q: -math.atan2(q[0] - source[0], q[1] - source[1]))
        panel.polygon(points, fill=pale, opacity=0.8)
        for end in (low, high):
            panel.line(source, (end, base_y), stroke=colour, width=1, dash='4 3')
        for radius in np.linspace(math.dist(source, (0.5 * (low + high), base_y)) * 1.0, 6, 9)[1:]:
            arc = []
            for q in np.linspace(low, high, 40):
                direction = np.array([q - source[0], base_y - source[1]])
                point = np.asarray(source) + direction / np.linalg.norm(direction) * radius
                if point[1] > base_y and inside_contour(tuple(point), corners + corners[:1]) > 0.5:
                    arc.append(tuple(point))
            if len(arc) > 1:
                panel.path(arc, stroke=colour, width=0.8)
        panel.dot(source, 5, fill=colour)

    def scene(column, row, title):
        panel = figure.panel(150 + 335 * column, 190 + 275 * row, 38)
        panel.polygon(corners, fill='#fbfcfd', stroke=GREY, width=1.4)
        figure.text(35 + 335 * column, 32 + 275 * row, title[0], size=16, anchor='start', weight='bold')
        figure.text(35 + 24 + 335 * column, 32 + 275 * row, title[1], size=13, anchor='start')
        return panel

    def finish(panel, fronts, labels=('n1', 'n2')):
        for node in far:
            owners = [colour for source, low, high, colour in fronts if lit(source, low, high, node)]
            panel.dot(node, 3.6 if owners else 2.4, fill=owners[0] if owners else LIGHT)
        panel.line(n1, n2, stroke=INK, width=4)
        for node, label in zip((n1, n2), labels):
            panel.dot(node, 5, fill=INK, stroke='#ffffff')
            panel.text(node, label, dx=-11 if node == n1 else 11, dy=-9, size=13, style='italic')
        panel.text((2.55, 0.28), 'f', size=15, fill=GREY, style='italic')

    panel = scene(0, 0, ('a', 'both came through f: nothing'))
    source = (0.35, 2.2)
    for node in (n1, n2):
        panel.arrow(source, between(source, node, 0.93), stroke=BLUE)
    panel.dot(source, 5, fill=BLUE)
    panel.text(source, 'S', dx=12, dy=-4, fill=BLUE, size=14, style='italic')
    finish(panel, [])

    panel = scene(1, 0, ('b', 'one source'))
    source = (-0.2, -1.35)
    fan(panel, source, n1[0], n2[0], BLUE, SKY)
    panel.text(source, 'S1 = S2', dx=12, dy=6, anchor='start', fill=BLUE, size=14, style='italic')
    finish(panel, [(source, n1[0], n2[0], BLUE)])

    panel = scene(2, 0, ('b', 'two sources: fronts meet at c'))
    left, right = (-0.95, -1.1), (1.2, -1.25)
    cut = next(
        x for x in np.linspace(n1[0], n2[0], 2000) if math.dist(left, (x, base_y)) >= math.dist(right, (x, base_y))
    )
    fan(panel, left, n1[0], cut, BLUE, SKY)
    fan(panel, right, cut, n2[0], ORANGE, SAND)
    panel.text(left, 'S1', dx=-10, dy=4, anchor='end', fill=BLUE, size=14, style='italic')
    panel.text(right, 'S2', dx=10, dy=4, anchor='start', fill=ORANGE, size=14, style='italic')
    finish(panel, [(left, n1[0], cut, BLUE), (right, cut, n2[0], ORANGE)])
    panel.dot((cut, base_y), 4, fill=RED)
    panel.text((cut, base_y), 'c', dy=20, fill=RED, size=13, style='italic')

    panel = scene(0, 1, ('c', 'n1 is a vertex V'))
    right = (1.35, -1.2)
    cut = next(x for x in np.linspace(n1[0], n2[0], 2000) if math.dist(right, (x, base_y)) <= 1.35 + (x - n1[0]))
    fan(panel, right, cut, n2[0], ORANGE, SAND)
    for angle in np.linspace(0.2, 1.0, 4):
        end = (n1[0] + 1.9 * math.cos(angle * math.pi * 0.85), n1[1] + 1.9 * math.sin(angle * math.pi * 0.85))
        panel.arrow(n1, end, stroke=BLUE, width=1.1)
    panel.text(right, 'S2', dx=10, dy=4, anchor='start', fill=ORANGE, size=14, style='italic')
    finish(panel, [(right, cut, n2[0], ORANGE)], labels=('V', 'n2'))

    panel = scene(1, 1, ('d', 'the source both times agree with'))
    t1, t2, width = 1.15, 1.45, n2[0] - n1[0]
    u = (t1 * t1 - t2 * t2 + width * width) / (2 * width)
    source = (n1[0] + u, -math.sqrt(t1 * t1 - u * u))
    for node, t in ((n1, t1), (n2, t2)):
        arc = [(node[0] + t * math.cos(a), base_y - t * math.sin(a)) for a in np.linspace(0.15, math.pi - 0.15, 50)]
        panel.path(arc, stroke=GREY, width=1, dash='3 3')
    fan(panel, source, n1[0], n2[0], GREEN, MINT)
    panel.text((n1[0] - 0.62 * t1, -0.62 * t1), 't1', dx=-18, dy=10, size=13, style='italic')
    panel.text((n2[0] + 0.62 * t2, -0.62 * t2), 't2', dx=14, dy=12, size=13, style='italic')
    finish(panel, [(source, n1[0], n2[0], GREEN)])

    panel = scene(2, 1, ('d', 'circles miss: a plane wave'))
    slope = 0.35
    h = math.sqrt(1 - slope * slope)
    far_source = (n1[0] - slope * 40, -h * 40)
    low, high = n1[0], n2[0]
    ends = []
    for x in (high, low):
        length = next(
            s for s in np.linspace(0.05, 8, 4000) if inside_contour((x + slope * s, h * s), corners + corners[:1]) < 0.5
        )
        ends.append((x + slope * length, h * length))
    panel.polygon(
        [(low, 0), (high, 0), ends[0], corners[2], ends[1]]
        if ends[0][0] > corners[2][0] > ends[1][0]
        else [(low, 0), (high, 0), *ends],
        fill=MINT,
        opacity=0.8,
    )
    for x in np.linspace(low, high, 4):
        panel.arrow((x - slope * 1.2, -h * 1.2), (x - slope * 0.08, -h * 0.08), stroke=GREEN, width=1.1)
    for s in np.linspace(0.5, 3.5, 7):
        a, b = (low + slope * s, h * s), (low + slope * s, h * s)
        a = (low + slope * s, h * s)
        normal = (h, -slope)
        line = [
            q
            for q in ((a[0] + normal[0] * k, a[1] + normal[1] * k) for k in np.linspace(-1, 3, 300))
            if q[1] > 0 and low <= q[0] - slope * q[1] / h <= high and inside_contour(q, corners + corners[:1]) > 0.5
        ]
        if len(line) > 1:
            panel.path([line[0], line[-1]], stroke=GREEN, width=0.8)
    finish(panel, [(far_source, low, high, GREEN)])
    figure.save('burning_fronts.svg')


def skeletons():
    figure = Figure(940, 350)
    panel = figure.panel(45, 300, 68)
    size = 4
    panel.rectangle((0, 0), (size, size), fill='#fbfcfd', stroke=GREY, width=1.4)
    arcs = [((0, 3), (1, 4)), ((0, 2), (2, 4)), ((2, 0), (4, 1)), ((1, 0), (4, 2))]
    along = [((0, 1), (0, 2)), ((0, 2), (0, 3)), ((0, 0), (1, 0)), ((1, 0), (2, 0))]
    regions = [
        [((0, 3), (0, 4)), ((0, 4), (1, 4))],
        [((0, 2), (0, 3)), ((1, 4), (2, 4))],
        [
            ((0, 0), (0, 1)),
            ((0, 1), (0, 2)),
            ((2, 4), (3, 4)),
            ((3, 4), (4, 4)),
            ((4, 4), (4, 3)),
            ((4, 3), (4, 2)),
            ((0, 0), (1, 0)),
        ],
        [((1, 0), (2, 0)), ((4, 2), (4, 1))],
        [((2, 0), (3, 0)), ((3, 0), (4, 0)), ((4, 0), (4, 1))],
    ]
    duals = [(0.3, 3.7), (0.78, 3.22), (2.0, 2.2), (2.75, 0.98), (3.4, 0.32)]
    for a, b in along:
        panel.line(a, b, stroke=RED, width=4)
    for a, b in arcs:
        panel.arrow(a, b, stroke=RED, width=2)
    for dual, segments in zip(duals, regions):
        for a, b in segments:
            door = between(a, b, 0.5)
            burned = (a, b) in along or (b, a) in along
            if not burned:
                panel.line(dual, door, stroke=GREEN, width=2)
            panel.square(door, 4, fill='#ffffff' if burned else GREEN, stroke=GREEN)
    for dual in duals:
        panel.dot(dual, 5.5, fill=GREEN, stroke='#ffffff')
    for k in range(size + 1):
        for p in {(k, 0), (k, size), (0, k), (size, k)}:
            panel.dot(p, 4.5, fill=INK, stroke='#ffffff')
    figure.text(180, 338, 'prime arcs, region duals and doors in a polygon', size=13)

    def sheet(x, title, curves):
        panel = figure.panel(x, 240, 46)
        w, h = 5.4, 3.2
        panel.rectangle(
            (0, 0), (w, h), fill=SKY if curves else PALE, stroke=BLUE if curves else LIGHT, width=1.2, opacity=0.6
        )
        left, right = (h / 2, h / 2), (w - h / 2, h / 2)
        return panel, w, h, left, right, title

    panel, w, h, left, right, _ = sheet(372, '', True)
    panel.line(left, right, stroke=RED, width=2.6)
    for a, b in ((left, (0, 0)), (left, (0, h)), (right, (w, 0)), (right, (w, h))):
        panel.line(a, b, stroke=RED, width=1.8)
    for k in range(1, 18):
        x = w * k / 18
        reach = min(h / 2, x, w - x)
        for y, inner in ((0, reach), (h, h - reach)):
            panel.line((x, y), (x, inner), stroke=RED, width=0.6)
    for k in range(1, 11):
        y = h * k / 11
        reach = min(y, h - y)
        for x, inner in ((0, reach), (w, w - reach)):
            panel.line((x, y), (inner, y), stroke=RED, width=0.6)
    figure.text(372 + w * 23, 338, 'medial curves, θ1 = 0', size=13)
    panel, w, h, left, right, _ = sheet(668, '', False)
    panel.line(left, right, stroke=RED, width=3)
    for a, b in ((left, (0, 0)), (left, (0, h)), (right, (w, 0)), (right, (w, h))):
        panel.line(a, between(a, b, 0.55), stroke=RED, width=2)
        panel.line(between(a, b, 0.55), b, stroke=LIGHT, width=1.4, dash='4 3')
    panel.dot(between(left, right, 0.5), 6, fill=RED, stroke='#ffffff')
    panel.text(between(left, right, 0.5), 'medial point', dy=26, size=12, fill=RED)
    figure.text(668 + w * 23, 338, 'θ2 = ∞, a larger θ1; dashed: pruned', size=13)
    figure.save('skeletons.svg')


def curve_graph():
    figure = Figure(900, 330)
    panel = figure.panel(30, 280, 40)
    sheet = [(5.2, 1.0), (8.0, 0.6), (9.0, 3.0), (6.3, 3.6)]
    panel.polygon(sheet, fill=SKY, stroke=BLUE, opacity=0.7)
    a, b, c, d = (0.4, 5.6), (2.3, 3.7), (0.6, 1.4), (5.55, 2.2)
    wave = [
        (b[0] + (d[0] - b[0]) * t, b[1] + (d[1] - b[1]) * t + 0.35 * math.sin(math.pi * 2 * t))
        for t in np.linspace(0, 1, 30)
    ]
    for path in ([a, (1.0, 4.7), b], [c, (1.3, 2.9), b], wave, [(7.6, 3.31), (8.3, 4.6), (8.0, 5.9)]):
        panel.path(path, stroke=RED, width=2.4)
    ring = [(4.6 + 0.8 * math.cos(t), 5.4 + 0.65 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 40)]
    panel.path(ring, stroke=RED, width=2.4)
    for p, name, dx, dy in (
        (a, 'end', 14, -2),
        (b, 'junction', 12, -8),
        (c, 'end', 14, 6),
        (d, 'sheet', 20, 18),
        ((7.6, 3.31), 'sheet', 16, -6),
        ((8.0, 5.9), 'end', 14, 0),
        (ring[0], 'loop', 12, -4),
        ((3.2, 0.9), 'isolated', 12, 5),
    ):
        panel.dot(p, 5, fill=INK, stroke='#ffffff')
        panel.text(p, name, dx=dx, dy=dy, anchor='start', size=13)
    figure.text(220, 318, 'kinds of nodes', size=13)
    panel = figure.panel(500, 280, 40)
    ring = [(3.0 + 1.5 * math.cos(t), 3.9 + 1.5 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 25)]
    for k, (p, q) in enumerate(zip(ring, ring[1:])):
        thick = 2 + 5 * abs(math.sin(math.pi * (k - 5) / 24))
        if k == 5:
            panel.line(p, q, stroke=GREY, width=1.4, dash='3 4')
            panel.text(
                between(p, q, 0.5), 'cut: the thinnest segment', dx=8, dy=-10, anchor='start', size=12, fill=GREY
            )
        else:
            panel.line(p, q, stroke=RED, width=thick)
        panel.dot(p, 2.6)
    panel.path([ring[18], (3.0, 1.6), (2.9, 0.7)], stroke=RED, width=4)
    sheet = [(5.8, 0.5), (8.6, 0.4), (9.0, 2.6), (6.4, 2.9)]
    panel.polygon(sheet, fill=SKY, stroke=BLUE, opacity=0.7)
    nodes = [(6.2, 1.9), (7.4, 0.85), (8.3, 2.2)]
    panel.path([ring[21], (5.2, 2.3), nodes[0]], stroke=RED, width=4)
    panel.path([nodes[2], (9.2, 3.7), (9.0, 4.9)], stroke=RED, width=2.5)
    panel.path([nodes[1], (7.8, -0.2), (8.8, -0.3)], stroke=RED, width=2.5)
    for node in nodes[1:]:
        panel.line(node, nodes[0], stroke=INK, width=1.6, dash='5 4')
    for node in nodes:
        panel.dot(node, 4.5, fill=INK, stroke='#ffffff')
    panel.text((7.4, 2.62), 'links across a sheet', dy=-14, size=12, fill=GREY)
    figure.text(700, 318, 'a tree for SWC', size=13)
    figure.save('curve_graph.svg')
