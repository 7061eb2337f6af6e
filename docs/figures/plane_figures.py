# SPDX-License-Identifier: Apache-2.0
"""Figures of the plane, after Figs. 2.1, 2.3, 3.2 and 3.3 of Yan 2018: own shapes, medial axes of the module quench."""
import itertools

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Voronoi, cKDTree

from svg import BLUE, GREEN, GREY, INK, LIGHT, PALE, RED, Figure, ramp

STEP = 0.002  # of the samples on the true medial axis, in pixels


def medial_axis(image, **options):
    """Of image[x, y]: of the module, whose arrays are image[row, column]."""
    import quench  # here, so that the other figures can be drawn without it

    return quench.medial_axis(np.ascontiguousarray(image.T), **options)


def small_shape():
    """A room with a pillar, and passages a pixel wide that meet in a T."""
    inside = np.zeros((14, 10), bool)
    inside[1:8, 1:8] = inside[8:13, 2] = inside[11, 3:8] = True
    inside[1:3, 6:8] = inside[4:6, 4] = False
    return inside


def unit_edges(image):
    """Edges between pixels inside and outside, from corner to corner, the inside on a fixed side."""
    padded = np.pad(image, 1).astype(int)
    edges = []
    for axis in (0, 1):
        for x, y in np.argwhere(np.diff(padded, axis=axis)):
            low, high = ((x, y - 1), (x, y)) if axis == 0 else ((x - 1, y), (x, y))
            leaves = padded[x, y] == 1
            edges.append((low, high) if leaves == (axis == 0) else (high, low))
    return [tuple((a[0] - 0.5, a[1] - 0.5) for a in edge) for edge in edges]


def outlines(image):
    """Closed lines around the shape, a point per corner; outlines that touch in a point may be joined there."""
    following = {}
    for a, b in unit_edges(image):
        following.setdefault(a, []).append(b)
    loops = []
    while following:
        at = start = next(iter(following))
        loop = []
        while not loop or at != start:
            loop.append(at)
            ways = following[at]
            after = ways.pop()
            if not ways:
                del following[at]
            at = after
        turns = [p for a, p, b in zip(loop[-1:] + loop, loop, loop[1:] + loop[:1]) if len({a[0], p[0], b[0]}) > 1]
        loops.append(
            [p for a, p, b in zip(turns[-1:] + turns, turns, turns[1:] + turns[:1]) if len({a[1], p[1], b[1]}) > 1]
        )
    return loops


def silhouette(panel, image, fill=PALE, stroke=LIGHT):
    """The shape without the steps of its pixels, unless it has few of them."""
    for loop in outlines(image):
        middles = [np.add(a, b) / 2 for a, b in zip(loop, loop[1:] + loop[:1])]
        panel.polygon(middles[::2] if len(loop) > 40 else loop, fill=fill, stroke=stroke)


def pixels(panel, image):
    for x, y in np.argwhere(image):
        panel.rectangle((x - 0.5, y - 0.5), (x + 0.5, y + 0.5), fill=PALE, stroke=LIGHT, width=0.6)
    panel.paths(unit_edges(image), stroke=GREY, width=1.4)


def sites_of(image):
    padded = np.pad(image, 1).astype(int)
    around = padded[:-1, :-1] + padded[1:, :-1] + padded[:-1, 1:] + padded[1:, 1:]
    return np.argwhere((around > 0) & (around < 4)) - 0.5


def cut_to_box(a, b, low, high):
    """The part of a segment in a box, or None."""
    begin, end = 0.0, 1.0
    for k in (0, 1):
        for bound, sign in ((low[k], 1), (high[k], -1)):
            here, there = sign * (a[k] - bound), sign * (b[k] - bound)
            if here < 0 and there < 0:
                return None
            if here < 0:
                begin = max(begin, here / (here - there))
            elif there < 0:
                end = min(end, here / (here - there))
    return None if begin >= end else (a + begin * (b - a), a + end * (b - a))


def plane_core():
    image = small_shape()
    axis = medial_axis(image, detail=0)
    points, edges = axis.vertices[:, :2], axis.edges
    sites = sites_of(image)
    far = 1000 * np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])
    voronoi = Voronoi(np.concatenate([sites, far]))
    low, high = (-0.9, -0.9), (13.9, 9.9)
    figure = Figure(960, 270)
    titles = ('the shape O and its sites P', 'Del(P) and Vor(P)', 'the core, and what it is dual to')
    panels = [figure.panel(33 + 317 * k, 222, 20, origin=(-0.5, -0.5)) for k in range(3)]
    for k, (panel, title) in enumerate(zip(panels, titles)):
        figure.text(33 + 317 * k + 140, 258, title, size=13)
        pixels(panel, image)
    dual, primal, core = [], [], []
    vertices = cKDTree(points)
    for (i, j), (v, w) in zip(voronoi.ridge_points, voronoi.ridge_vertices):
        if max(i, j) >= len(sites) or min(v, w) < 0:
            continue
        a, b = voronoi.vertices[v], voronoi.vertices[w]
        if np.linalg.norm(a - b) < 1e-9:
            continue
        primal.append((sites[i], sites[j]))
        if part := cut_to_box(a, b, low, high):
            dual.append(part)
        if max(vertices.query([a, b])[0]) < 1e-9:
            core.append((sites[i], sites[j]))
    assert len(core) == len(edges)  # qhull and the module agree on what is inside
    panels[1].paths(primal, stroke=RED, width=1)
    panels[1].paths(dual, stroke=BLUE, width=1.4)
    panels[2].paths(core, stroke='#eaa9a9', width=1)
    panels[2].paths([points[edge] for edge in edges], stroke=BLUE, width=2.4)
    for panel in panels:
        for site in sites:
            panel.dot(site, 2)
    for point in points:
        panels[2].dot(point, 2.6, fill=BLUE)
    figure.save('plane_core.svg')


def boundary_elements(image):
    """Sides of the boundary as (low end, high end), and its corners."""
    corners = [p for loop in outlines(image) for p in loop]
    sides = [(np.array(a), np.array(b)) for loop in outlines(image) for a, b in zip(loop, loop[1:] + loop[:1])]
    return [(np.minimum(a, b), np.maximum(a, b)) for a, b in sides] + [(np.array(p), np.array(p)) for p in corners]


def bisector(e, f, size):
    """Points of equal distance from the lines or points that two elements of the boundary lie on, a list per line."""
    t = np.arange(-1, size, STEP)
    flat = [k for k in (e, f) if np.any(k[0] != k[1])]
    across = [0 if k[0][0] == k[1][0] else 1 for k in flat]  # the coordinate that is the same along the side
    if len(flat) == 2 and across[0] == across[1]:
        middle = np.full_like(t, (e[0][across[0]] + f[0][across[0]]) / 2)
        return [np.stack([middle, t] if across[0] == 0 else [t, middle], 1)]
    if len(flat) == 2:
        x, y = (e, f)[across.index(0)][0][0], (e, f)[across.index(1)][0][1]
        t = np.arange(-size, size, STEP)
        return [np.stack([x + t, y + t], 1), np.stack([x + t, y - t], 1)]
    if len(flat) == 1:
        point = (e if np.all(e[0] == e[1]) else f)[0]
        k, line = across[0], flat[0][0][across[0]]
        if point[k] == line:
            return []
        offset = ((t - point[1 - k]) ** 2 + point[k] ** 2 - line**2) / (2 * (point[k] - line))
        return [np.stack([offset, t] if k == 0 else [t, offset], 1)]
    middle, along = (e[0] + f[0]) / 2, f[0] - e[0]
    t = np.arange(-size, size, STEP)[:, None]
    return [middle + t * np.array([-along[1], along[0]]) / np.linalg.norm(along)]


def true_axis(image):
    """The medial axis of the union of pixels as lines of points: what two parts of the boundary are nearest to."""
    elements = boundary_elements(image)
    lines = []
    for e, f in itertools.combinations(elements, 2):
        for points in bisector(e, f, max(image.shape)):
            cell = np.rint(points).astype(int)
            inside = ((cell >= 0) & (cell < image.shape)).all(axis=1)
            inside[inside] = image[tuple(cell[inside].T)]
            nearest = np.full(len(points), np.inf)
            for low, high in elements:
                nearest = np.minimum(nearest, np.linalg.norm(points - np.clip(points, low, high), axis=1))
            foot, other = np.clip(points, *e), np.clip(points, *f)
            good = inside & (np.linalg.norm(foot - other, axis=1) > 1e-3)
            for p in (foot, other):
                good &= np.linalg.norm(points - p, axis=1) < nearest + 1e-9
            runs = np.split(np.arange(len(points)), 1 + np.flatnonzero(np.diff(good)))
            lines += [points[run] for run in runs if good[run[0]]]
    return lines


def shorter(lines):
    """Every fiftieth point and the ends."""
    return [line[np.unique(np.r_[0 : len(line) : 50, len(line) - 1])] for line in lines]


def in_box(lines, low, high):
    """Segments of lines, cut to a box."""
    return [part for line in lines for a, b in zip(line, line[1:]) if (part := cut_to_box(a, b, low, high))]


def subdivided(panel, image, parts, lines, core, width, box=((-1, -1), (14, 10))):
    """Pixels in `parts` x `parts`, the true medial axis and the core, in a box."""
    for x, y in np.argwhere(np.kron(image, np.ones((parts, parts), bool))):
        low = np.maximum((x / parts - 0.5, y / parts - 0.5), box[0])
        high = np.minimum(((x + 1) / parts - 0.5, (y + 1) / parts - 0.5), box[1])
        if (low < high).all():
            panel.rectangle(tuple(low), tuple(high), fill=PALE, stroke=LIGHT, width=0.6)
    panel.paths(lines if width > 1 else shorter(lines), stroke=GREEN, width=2.2 * width)
    panel.paths(core, stroke=BLUE, width=1.1 * width)
    if width > 1:
        for point in {tuple(p.round(4)) for edge in core for p in edge}:
            if np.all(np.minimum(np.subtract(point, box[0]), np.subtract(box[1], point)) > 1e-6):
                panel.dot(point, 3.4, fill=BLUE)


def plane_subdivision():
    image = small_shape()
    lines = true_axis(image)
    tree, box = cKDTree(np.concatenate(lines)), ((9.8, 1.4), (12.2, 3.8))
    figure = Figure(960, 290)
    print('pixel   beta   core to axis   axis to core')
    for k, parts in enumerate((1, 2, 4, 8)):
        axis = medial_axis(image, detail=0, subdivide=parts)
        points = axis.vertices[:, :2]
        far = tree.query(points)[0].max()
        along = np.concatenate([np.linspace(*points[edge], 1 + int(400 / parts)) for edge in axis.edges])
        back = cKDTree(along).query(np.concatenate(lines))[0].max()
        print(f'1/{parts:<5} {1 / (8 * parts):.4f} {far:14.3f} {back:14.3f}')
        if parts == 1:
            panel = figure.panel(14, 222, 18, origin=(-0.5, -0.5))
            subdivided(panel, image, 1, lines, points[axis.edges], 1)
            panel.rectangle(*box, stroke=INK, dash='4 3')
            figure.text(140, 258, 'true medial axis (green) and core', size=13)
        if parts < 8:
            panel = figure.panel(290 + 226 * k, 222, 86, origin=box[0])
            subdivided(panel, image, parts, in_box(shorter(lines), *box), in_box(points[axis.edges], *box), 2.2, box)
            figure.text(290 + 226 * k + 103, 252, ('pixels', 'halves', 'quarters')[k], size=13)
            figure.text(290 + 226 * k + 103, 274, f'at most {far:.3f}, β = {1 / (8 * parts):.3f}', size=12, fill=GREY)
    figure.save('plane_subdivision.svg')


def limb(x, y, joints):
    """Where a limb is, of disks of (x, y, radius) that change evenly from joint to joint."""
    found = np.zeros(x.shape, bool)
    for a, b in zip(joints, joints[1:]):
        for t in np.linspace(0, 1, 60):
            cx, cy, radius = (1 - t) * np.array(a) + t * np.array(b)
            found |= (x - cx) ** 2 + (y - cy) ** 2 < radius**2
    return found


def pony():
    """A pony with a shaggy mane and coat, image[x, y] with y up."""
    x, y = np.meshgrid(np.arange(330), np.arange(250), indexing='ij')
    image = limb(x, y, [(105, 130, 35), (150, 126, 31), (225, 134, 37)])
    image |= limb(x, y, [(92, 140, 26), (70, 185, 17), (62, 206, 15), (30, 184, 9), (24, 180, 8)])
    image |= limb(x, y, [(66, 208, 9), (70, 236, 2)]) | limb(x, y, [(56, 208, 8), (56, 232, 2)])
    image |= limb(x, y, [(86, 118, 20), (80, 70, 9), (84, 40, 7), (82, 12, 7), (76, 8, 6)])
    image |= limb(x, y, [(108, 112, 20), (118, 66, 9), (112, 38, 7), (118, 10, 7), (112, 8, 6)])
    image |= limb(x, y, [(228, 122, 25), (222, 76, 11), (236, 46, 7), (228, 12, 7), (222, 8, 6)])
    image |= limb(x, y, [(244, 124, 22), (258, 78, 10), (274, 46, 7), (268, 12, 7), (262, 8, 6)])
    image |= limb(x, y, [(254, 150, 9), (284, 150, 8), (302, 110, 9), (306, 62, 3)])
    hairs = [(76 + 4.6 * i, 200 - 7.4 * i, 0.6 + 0.05 * i) for i in range(0, 8, 2)]  # place and direction
    hairs += [(124 + 16 * i, 152 + 4 * np.sin(i), 1.4 + 0.1 * (i % 3)) for i in range(7)]
    hairs += [(134 + 17 * i, 100 - 2 * np.cos(i), -1.7 + 0.15 * (i % 3)) for i in range(5)]
    for number, (hx, hy, turn) in enumerate(hairs):
        reach = 19 + 3 * (number % 3)
        image |= limb(x, y, [(hx, hy, 6), (hx + reach * np.cos(turn), hy + reach * np.sin(turn), 1.5)])
    return image


def chains(edges):
    """Edges as lines of vertices."""
    at, used, lines = {}, set(), []
    for number, ends in enumerate(edges):
        for v in ends:
            at.setdefault(v, []).append(number)
    for start in sorted(at, key=lambda v: len(at[v]) == 2):
        for number in at[start]:
            line = [start]
            while number not in used:
                used.add(number)
                line.append(edges[number].sum() - line[-1])
                here = at[line[-1]]
                number = next((n for n in here if n not in used), number) if len(here) == 2 else number
            if len(line) > 1:
                lines.append(line)
    return lines


class Fire:
    """Radius and burn time all along the edges of an axis, cut into pieces of at most `length`: at both ends of each.

    Fire comes to an edge from its ends at their burn times, and the earlier counts; at a junction that waits for
    another branch, an edge therefore burns before its vertex does. R^2 is a quadratic along an edge."""

    def __init__(self, axis, length=4.0):
        ends = axis.vertices[:, :2][axis.edges]
        radius, time = axis.radius[axis.edges], axis.burn_time()[axis.edges]
        points, self.edges, self.edge, self.radius, self.time = list(axis.vertices[:, :2]), [], [], [], []
        for number, (a, b) in enumerate(ends):
            size = np.linalg.norm(b - a)
            count = max(1, int(np.ceil(size / length)))
            at = np.linspace(0, size, count + 1)
            names = [axis.edges[number, 0], *range(len(points), len(points) + count - 1), axis.edges[number, 1]]
            points += [a + d / size * (b - a) for d in at[1:-1]]
            (r, s), (t, u) = radius[number], time[number]
            square = r**2 + (s**2 - r**2 - size**2) * at / size + at**2
            burned = np.minimum(t + at, u + size - at)
            for values, name in ((np.sqrt(square), 'radius'), (burned, 'time'), (np.array(names), 'edges')):
                getattr(self, name).extend(zip(values, values[1:]))
            self.edge += count * [number]
        self.points = np.array(points)
        self.edges, self.edge, self.radius, self.time = map(np.array, (self.edges, self.edge, self.radius, self.time))
        self.thickness = self.time - self.radius


def coloured(panel, points, edges, values, top, width):
    """Edges in colours of their values, in few elements."""
    shade = np.minimum(23, (24 * np.asarray(values) / top).astype(int))
    for k in np.unique(shade):
        panel.paths([points[line] for line in chains(edges[shade == k])], stroke=ramp((k + 0.5) / 24), width=width)


def pieces(edges):
    """How many connected parts edges have."""
    names, index = np.unique(edges, return_inverse=True)
    a, b = index.reshape(-1, 2).T
    return connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(len(names),) * 2))[0]


def plane_measures():
    image = pony()
    axis = medial_axis(image)
    fire = Fire(axis)
    lengths = np.linalg.norm(np.subtract(*fire.points[fire.edges].transpose(1, 0, 2)), axis=1)
    measures = {
        'object angle': axis.measures['object_angle'].values.edges[fire.edge],
        'circumradius R': fire.radius.min(axis=1),
        'erosion thickness ET': fire.thickness.min(axis=1),
    }
    figure = Figure(960, 560)
    for k, (name, values) in enumerate(measures.items()):
        order = np.argsort(-values, kind='stable')
        kept = order[: 1 + np.searchsorted(np.cumsum(lengths[order]), 0.5 * lengths.sum())]
        count = pieces(fire.edges[kept])
        share = lengths[kept].sum() / lengths.sum()
        print(f'{name}: {share:.3f} of the length from {values[kept].min():.3g} on, {count} pieces')
        for row, part in enumerate((np.arange(len(values)), kept)):
            panel = figure.panel(14 + 318 * k, 240 + 265 * row, 0.93)
            silhouette(panel, image)
            coloured(panel, fire.points, fire.edges[part], values[part], np.quantile(values, 0.98), 2.4 if row else 1.8)
        figure.text(14 + 318 * k + 153, 262, name, size=14, weight='bold')
        figure.text(
            14 + 318 * k + 153, 532, f'{name.split()[-1]} ≥ {values[kept].min():.3g}{"°" if k == 0 else ""}', size=13
        )
        figure.text(14 + 318 * k + 153, 551, f'{count} piece{"s" if count > 1 else ""}', size=13, fill=GREY)
    figure.save('plane_measures.svg')


def plane_fire():
    x, y = np.meshgrid(np.arange(330), np.arange(170), indexing='ij')
    image = ((x - 165) / 155) ** 2 + ((y - 72) / 66) ** 2 < 1
    image |= (x - 215) ** 2 + (y - 128) ** 2 < 17**2
    fire = Fire(medial_axis(image))
    fields = {'burn time BT': fire.time, 'radius R': fire.radius, 'erosion thickness ET': fire.thickness}
    top = fire.time.max()
    figure = Figure(960, 400)
    graph = figure.panel(150, 368, 1)
    for k, (name, values) in enumerate(fields.items()):
        panel = figure.panel(14 + 316 * k, 172, 0.92)
        silhouette(panel, image)
        coloured(panel, fire.points, fire.edges, values.mean(axis=1), top, 4)
        figure.text(14 + 316 * k + 152, 196, name, size=14, weight='bold')
        stroke = (RED, GREY, BLUE)[k]
        scale = np.array([2, 140 / top])
        places = fire.points[fire.edges][:, :, 0]
        graph.paths(np.stack([places, values], 2) * scale, stroke=stroke, width=2)
        graph.line((690, 120 - 24 * k), (718, 120 - 24 * k), stroke=stroke, width=2)
        graph.text((726, 120 - 24 * k), name.split()[-1], dy=4, anchor='start')
    graph.line((0, 0), (660, 0), stroke=INK)
    graph.line((0, 0), (0, 150), stroke=INK)
    for value in (0, 50, 100):
        graph.text((-8, value * 140 / top), value, dy=4, size=11, anchor='end')
    graph.text((330, 0), 'place along the long axis', dy=20, size=12)
    bump = (fire.points[fire.edges][:, :, 1] > 80).all(axis=1)
    print(f'ET at most {fire.thickness.max():.1f}, on the branch to the bump {fire.thickness[bump].max():.1f}')
    figure.save('plane_fire.svg')
