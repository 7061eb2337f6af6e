# SPDX-License-Identifier: Apache-2.0
"""Figures from the mesh to the pruned voxel core."""
import numpy as np
from scipy.spatial import Delaunay

from plane_core import PlaneCore, whale
from svg import BLUE, GREEN, GREY, INK, LIGHT, MINT, ORANGE, PALE, RED, SAND, SKY, Figure, between, inside_contour, ramp


def grid(panel, width, height, stroke=LIGHT):
    for x in range(width + 1):
        panel.line((x, 0), (x, height), stroke=stroke, width=0.6)
    for y in range(height + 1):
        panel.line((0, y), (width, y), stroke=stroke, width=0.6)


def pixels(panel, core, fill=PALE, stroke=LIGHT):
    for x, y in np.argwhere(core.inside):
        panel.rectangle((x - 1, y - 1), (x, y), fill=fill, stroke=stroke, width=0.6)


def outline(panel, core, stroke=GREY, width=1.4):
    for x in range(core.inside.shape[0] - 1):
        for y in range(core.inside.shape[1] - 1):
            if core.inside[x, y] != core.inside[x + 1, y]:
                panel.line((x, y - 1), (x, y), stroke=stroke, width=width)
            if core.inside[x, y] != core.inside[x, y + 1]:
                panel.line((x - 1, y), (x, y), stroke=stroke, width=width)


def voxelization():
    figure = Figure(900, 360)
    angle = np.linspace(0, 2 * np.pi, 90)
    contour = np.array(
        [(7 + 6.1 * np.cos(t), 4.9 + 4.4 * np.sin(t) - 3.4 * np.exp(-(((t - 1.75) / 0.36) ** 2))) for t in angle]
    )
    panel = figure.panel(30, 310, 27)
    for x in range(14):
        for y in range(10):
            if inside_contour((x + 0.5, y + 0.5), contour) > 0.5:
                panel.rectangle((x, y), (x + 1, y + 1), fill=SKY)
    grid(panel, 14, 10)
    for x in range(14):
        for y in range(10):
            panel.dot((x + 0.5, y + 0.5), 1.3, fill=GREY)
    panel.path([tuple(p) for p in contour], stroke=INK, width=2)
    row = 7.5
    panel.line((0, row), (14, row), stroke=ORANGE, width=1.6)
    crossings = []
    for a, b in zip(contour, contour[1:]):
        if (a[1] - row) * (b[1] - row) < 0:
            crossings.append((a[0] + (row - a[1]) / (b[1] - a[1]) * (b[0] - a[0]), 1 if b[1] < a[1] else -1))
    total = 0
    last = 0.0
    for x, sign in [*sorted(crossings), (14, 0)]:
        panel.text(((last + x) / 2, row), total, dy=-5, size=13, fill=ORANGE, weight='bold')
        total += sign
        if sign:
            panel.dot((x, row), 4.5, fill=ORANGE, stroke='#ffffff')
            panel.text((x, row), '+1' if sign > 0 else '−1', dy=18, size=12, fill=ORANGE)
        last = x
    figure.text(220, 342, 'crossings of a scanline; their sum is the winding number', size=13)
    # Right: a gap, the generalized winding number, the cap.
    first = next(i for i, t in enumerate(angle) if t >= 0.85)
    ordered = [tuple(p) for p in contour[first:]] + [tuple(p) for p, t in zip(contour[1:], angle[1:]) if t <= 0.15]
    panel = figure.panel(490, 310, 27)
    for x in range(14):
        for y in range(10):
            w = inside_contour((x + 0.5, y + 0.5), ordered)
            panel.rectangle((x, y), (x + 1, y + 1), fill=ramp(w), opacity=0.75)
            if w > 0.5:
                panel.dot((x + 0.5, y + 0.5), 2.2, fill=INK)
    grid(panel, 14, 10, stroke='#ffffff')
    panel.path(ordered, stroke=INK, width=2.4)
    panel.line(ordered[-1], ordered[0], stroke=INK, width=1.6, dash='5 4')
    panel.text(between(ordered[-1], ordered[0], 0.5), 'cap', dx=8, dy=-8, anchor='start', size=13)
    for k, value in enumerate((0, 0.25, 0.5, 0.75, 1)):
        panel.rectangle((4.2 + 1.3 * k, -1.3), (5.5 + 1.3 * k, -0.75), fill=ramp(value), opacity=0.75)
        panel.text((4.85 + 1.3 * k, -1.3), f'{value:g}', dy=13, size=11)
    panel.text((4.1, -1.15), 'w', anchor='end', size=13, style='italic')
    panel.text((11.0, -1.15), 'dots: w > ½', anchor='start', size=12)
    figure.save('voxelization.svg')


def circumcircle(a, b, c):
    a, b, c = (np.asarray(p, float) for p in (a, b, c))
    d = 2 * ((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
    u, v = ((b - a) ** 2).sum(), ((c - a) ** 2).sum()
    centre = a + np.array([(c - a)[1] * u - (b - a)[1] * v, (b - a)[0] * v - (c - a)[0] * u]) / d
    return centre, float(np.linalg.norm(centre - a))


def small_shape():
    inside = np.zeros((12, 9), bool)
    inside[1:11, 2:6] = True
    inside[2:6, 1:8] = True
    inside[8:10, 5:8] = True
    return inside


def delaunay():
    figure = Figure(920, 330)
    random = np.random.default_rng(5)
    points = np.array(
        [(x + 0.62 * (random.random() - 0.5), y + 0.62 * (random.random() - 0.5)) for x in range(5) for y in range(5)]
    )
    p = np.array([2.15, 1.9])
    triangulation = Delaunay(points)
    conflicts = [
        t
        for t in triangulation.simplices
        if np.linalg.norm(circumcircle(*points[t])[0] - p) < circumcircle(*points[t])[1]
    ]
    edges = {}
    for t in conflicts:
        for k in range(3):
            e = tuple(sorted((int(t[k]), int(t[(k + 1) % 3]))))
            edges[e] = edges.get(e, 0) + 1
    rim = [e for e, count in edges.items() if count == 1]
    for number in (0, 1):
        panel = figure.panel(40 + 300 * number, 270, 56)
        for t in triangulation.simplices:
            conflict = any((t == c).all() for c in conflicts)
            if conflict and number == 1:
                continue
            panel.polygon(
                [points[i] for i in t],
                fill=SAND if conflict else 'none',
                stroke=ORANGE if conflict else LIGHT,
                width=1.2,
            )
        if number == 0:
            for t in conflicts:
                panel.circle(*circumcircle(*points[t]), stroke=ORANGE, width=0.8, dash='4 3')
        else:
            for a, b in rim:
                panel.polygon([points[a], points[b], p], fill=MINT, stroke=GREEN, width=1.2)
        for q in points:
            panel.dot(q, 3.2)
        panel.dot(p, 5, fill=RED)
        panel.text(p, 'p', dx=9, dy=-7, fill=RED, size=15, style='italic')
    figure.text(152, 320, 'triangles in conflict with p', size=13)
    figure.text(452, 320, 'the cavity filled from p', size=13)
    core = PlaneCore(small_shape())
    panel = figure.panel(618, 255, 26)
    for corners in core.cells:
        panel.polygon([core.sites[i] for i in corners], fill=SKY if len(corners) > 3 else PALE, stroke='none')
    for t in core.triangles:
        for k in range(3):
            a, b = sorted((int(t[k]), int(t[(k + 1) % 3])))
            real = (a, b) in core.cells_at
            panel.line(
                core.sites[a],
                core.sites[b],
                stroke=BLUE if real else ORANGE,
                width=1.2 if real else 1.0,
                dash=None if real else '3 3',
            )
    for s in core.sites:
        panel.dot(s, 2.3)
    figure.text(774, 320, 'merged: one polygon per circumcircle', size=13)
    figure.save('delaunay.svg')


def voxel_core():
    figure = Figure(960, 300)
    core = PlaneCore(whale())
    level = core.levels()
    largest = core.edge_lambda.max()
    left = figure.panel(15, 235, 10.4)
    pixels(left, core)
    outline(left, core)
    for (a, b), value in zip(core.edges, core.edge_lambda):
        left.line(core.centre[a], core.centre[b], stroke=BLUE, width=1.5)
    for s in core.sites:
        left.dot(s, 1.7)
    figure.text(165, 275, 'pixels, sites and the whole core', size=13)
    # One edge with its two sites.
    length = [np.linalg.norm(core.centre[a] - core.centre[b]) for a, b in core.edges]
    e = max(
        (k for k in range(len(core.edges)) if 3 < core.edge_lambda[k] < 5 and core.centre[core.edges[k][0]][0] < 16),
        key=lambda k: length[k],
    )
    middle = (core.centre[core.edges[e][0]] + core.centre[core.edges[e][1]]) / 2
    sites = [core.sites[i] for i in core.sites_of[e]]
    panel = figure.panel(470, 130, 15.5, origin=tuple(middle))
    panel.circle(middle, float(np.linalg.norm(sites[0] - middle)), fill=SAND, opacity=0.5, stroke=ORANGE, width=1)
    box = (middle[0] - 7.4, middle[0] + 7.4, middle[1] - 7.9, middle[1] + 7.3)
    shown = [
        k
        for k, (a, b) in enumerate(core.edges)
        if all(box[0] < core.centre[v][0] < box[1] and box[2] < core.centre[v][1] < box[3] for v in (a, b))
    ]
    for k in shown:
        panel.line(core.centre[core.edges[k][0]], core.centre[core.edges[k][1]], stroke=SKY, width=1.4)
    panel.line(core.centre[core.edges[e][0]], core.centre[core.edges[e][1]], stroke=BLUE, width=4)
    for s in core.sites:
        if box[0] < s[0] < box[1] and box[2] < s[1] < box[3]:
            panel.dot(s, 2, fill=GREY)
    panel.line(sites[0], sites[1], stroke=RED, width=1.6, dash='5 4')
    for s in sites:
        panel.dot(s, 4.2, fill=RED)
    panel.text(between(sites[0], sites[1], 0.78), '2λ', dx=20, fill=RED, size=15, style='italic')
    figure.text(470, 275, 'λ of an edge', size=13)
    right = figure.panel(635, 235, 10.4)
    pixels(right, core)
    outline(right, core)
    t = 1.6
    for (a, b), value, reach in zip(core.edges, core.edge_lambda, level):
        if reach >= t:
            right.line(core.centre[a], core.centre[b], stroke=ramp(value / largest), width=3)
    figure.text(785, 275, f'level ≥ {t:g} pixels', size=13)
    figure.save('voxel_core.svg')


def peeling():
    figure = Figure(660, 440)
    core = PlaneCore(whale())
    panel = figure.panel(20, 392, 22)
    outline(panel, core, stroke=LIGHT)
    known = {}
    for number, corners in enumerate(core.cells):
        kind = 0 if core.radius[number] < 0.72 else 1 if core.radius[number] <= 3 else 2
        known[number] = kind
        panel.polygon(
            [core.sites[i] for i in corners],
            fill=('#4d83bd', SKY, '#fdf3e1')[kind],
            stroke='#ffffff' if kind < 2 else '#e8c88f',
            width=0.9,
        )
    unmatched = set()
    for edge, numbers in core.cells_at.items():
        kinds = [known[n] for n in numbers]
        if (len(numbers) == 2 and (kinds[0] == 2) != (kinds[1] == 2)) or (len(numbers) == 1 and kinds[0] == 2):
            panel.line(core.sites[edge[0]], core.sites[edge[1]], stroke=ORANGE, width=2.4)
            unmatched.update(edge)
    for number, s in enumerate(core.sites):
        panel.dot(s, 3.2 if number in unmatched else 1.8, fill=RED if number in unmatched else GREY)
    for k, (fill, text) in enumerate(
        (('#4d83bd', 'corners of one pixel'), (SKY, 'wrapped: circle ≤ 3 pixels'), ('#fdf3e1', 'remainder'))
    ):
        panel.rectangle((1 + 7.3 * k + (k == 2), -1.6), (1.8 + 7.3 * k + (k == 2), -0.9), fill=fill, stroke=LIGHT)
        panel.text((2.1 + 7.3 * k + (k == 2), -1.5), text, anchor='start', size=12)
    panel.dot((21.4, -1.25), 3.4, fill=RED)
    panel.text((21.9, -1.5), 'unfinished site', anchor='start', size=12)
    figure.save('peeling.svg')


def bricks():
    figure = Figure(900, 370)
    core = PlaneCore(whale())
    panel = figure.panel(20, 318, 16)
    low, high, halo = (8, 1), (18, 11), 3
    panel.rectangle(
        (low[0] - halo, low[1] - halo + 1),
        (high[0] + halo, high[1] + halo),
        fill='#f7f9fb',
        stroke=BLUE,
        dash='6 4',
        width=1.4,
    )
    for x in (-2, 8, 18, 28):
        panel.line((x, -1), (x, 19), stroke=LIGHT, width=1)
    for y in (1, 11):
        panel.line((-1, y), (30, y), stroke=LIGHT, width=1)
    panel.rectangle(low, high, stroke=BLUE, width=2)
    outline(panel, core, stroke=GREY, width=1)
    region = (low[0] - halo, low[1] - halo + 1, high[0] + halo, high[1] + halo)

    def fits(n):
        c, r = core.centre[n], core.radius[n]
        return region[0] <= c[0] - r and region[1] <= c[1] - r and c[0] + r <= region[2] and c[1] + r <= region[3]

    good = max(
        (n for n in range(len(core.cells)) if fits(n) and 12 < core.centre[n][0] < 17),
        key=lambda n: core.radius[n] if core.radius[n] < 4 else 0,
    )
    bad = max(
        (n for n in range(len(core.cells)) if not fits(n) and 8 < core.centre[n][0] < 13), key=lambda n: core.radius[n]
    )
    for n, fill, stroke in ((bad, SAND, ORANGE), (good, MINT, GREEN)):
        panel.circle(core.centre[n], core.radius[n], stroke=stroke, width=1.4, dash='5 4')
        panel.polygon([core.sites[i] for i in core.cells[n]], fill=fill, stroke=stroke, width=1.4)
    for s in core.sites:
        inside = region[0] <= s[0] <= region[2] and region[1] <= s[1] <= region[3]
        panel.dot(s, 2.2, fill=INK if inside else LIGHT)
    panel.text((18.2, 1.3), 'brick', anchor='end', dx=-8, dy=-2, fill=BLUE, size=13)
    panel.text((21, 14), 'region', anchor='end', dx=-4, dy=15, fill=BLUE, size=13)
    figure.text(255, 355, 'certified (green), not certified (orange)', size=13)
    # A finished site: cells around it from boundary to boundary.
    focus = min(range(len(core.sites)), key=lambda i: abs(core.sites[i][0] - 21) + abs(core.sites[i][1] - 12) * 3)
    centre = core.sites[focus]
    panel = figure.panel(730, 175, 42, origin=(centre[0], centre[1] - 1.4))
    around = [n for n, corners in enumerate(core.cells) if focus in corners]
    for n, corners in enumerate(core.cells):
        if n in around:
            panel.polygon([core.sites[i] for i in corners], fill=MINT, stroke=GREEN, width=1.6)
    for edge, numbers in core.cells_at.items():
        if focus in edge and len(numbers) == 1:
            panel.line(core.sites[edge[0]], core.sites[edge[1]], stroke=INK, width=4)
    for n in around:
        for i in core.cells[n]:
            panel.dot(core.sites[i], 3, fill=GREY)
    panel.dot(centre, 6, fill=RED)
    panel.text(centre, 'u', dy=-12, fill=RED, size=16, style='italic')
    figure.text(730, 355, 'a finished site; thick: boundary of O', size=13)
    figure.save('bricks.svg')
