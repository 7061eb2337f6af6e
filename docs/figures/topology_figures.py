# SPDX-License-Identifier: Apache-2.0
"""The figure of digitization with the topology of the mesh: the same steps as in src/voxelization, in the plane."""
import math

from svg import BLUE, GREY, INK, ORANGE, SAND, SKY, Figure, inside_contour

COLUMNS, ROWS = 20, 9
AROUND = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]


def contour():
    """Two blobs and an arm between them, thinner than a pixel in the middle."""

    def at(s):
        radius = (0.12 + 2.6 * abs(2 * s - 1) ** 2.6) * math.sqrt(max(0, 1 - (2 * s - 1) ** 10))
        return 1.1 + 17.8 * s, 4.45 + 1.35 * math.sin(2 * math.pi * s), radius

    steps = [at(i / 400) for i in range(401)]
    upper = [(x, y + r) for x, y, r in steps]
    return upper + [(x, y - r) for x, y, r in reversed(steps)] + upper[:1]


def groups(cells, adjacent):
    """How many components."""
    left, count = set(cells), 0
    while left:
        stack = [left.pop()]
        count += 1
        while stack:
            x, y = stack.pop()
            near = [n for n in left if adjacent(abs(n[0] - x), abs(n[1] - y))]
            left.difference_update(near)
            stack.extend(near)
    return count


def simple(cell, shape):
    around = [(cell[0] + dx, cell[1] + dy) for dx, dy in AROUND]
    inside = [n for n in around if n in shape]
    outside = [n for n in around if n not in shape]
    beside = {n for n in inside if abs(n[0] - cell[0]) + abs(n[1] - cell[1]) == 1}
    joined = [n for n in inside if n in beside or sum(abs(n[0] - b[0]) + abs(n[1] - b[1]) == 1 for b in beside) > 0]
    if not beside or not outside or groups(joined, lambda x, y: x + y == 1) != 1:
        return False
    return groups(outside, lambda x, y: max(x, y) == 1) == 1


def digitization_topology():
    line = contour()
    centre = {(i, j): (i + 0.5, j + 0.5) for i in range(COLUMNS) for j in range(ROWS)}
    gauss = {c for c, p in centre.items() if abs(inside_contour(p, line)) > 0.5}
    cover, distance = set(), {}
    for a, b in zip(line, line[1:]):
        for k in range(40):
            p = tuple(a[i] + (b[i] - a[i]) * k / 40 for i in range(2))
            cell = (math.floor(p[0]), math.floor(p[1]))
            cover.add(cell)
            distance[cell] = min(distance.get(cell, 9), math.dist(p, (cell[0] + 0.5, cell[1] + 0.5)))
    shape = gauss | cover
    for _ in range(3):  # until nothing is simple
        for cell in sorted(cover - gauss, key=lambda c: (-distance[c], c)):
            if cell in shape and simple(cell, shape):
                shape.remove(cell)
    fills = shape - gauss

    figure = Figure(960, 210)
    panels = [
        ('Gauss digitization', []),
        ('with the cover', [(cover - gauss, SAND)]),
        ('with the fills', [(fills, ORANGE)]),
    ]
    for k, (title, more) in enumerate(panels):
        panel = figure.panel(15 + 318 * k, 180, 15)
        for cells, colour in [(gauss, SKY), *more]:
            for i, j in sorted(cells):
                panel.rectangle((i, j), (i + 1, j + 1), fill=colour, stroke=GREY if colour != SKY else BLUE, width=0.6)
        panel.path(line, stroke=INK, width=1.4)
        figure.text(15 + 318 * k + 150, 24, title, size=14, weight='bold')
    figure.save('digitization_topology.svg')
