#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the figures of the pages about algorithms: docs/figures/draw.py [NAME...]. Needs python3-numpy and python3-scipy, and
for those of the plane the module quench (PYTHONPATH=build/release/python)."""
import sys

from axis_figures import bricks, delaunay, peeling, voxel_core, voxelization
from burning_figures import burning, burning_fronts, burning_links, curve_graph, skeletons
from plane_figures import plane_core, plane_fire, plane_measures, plane_subdivision
from svg import BLUE, GREEN, GREY, LIGHT, ORANGE, PALE, RED, SKY, Figure, between
from topology_figures import digitization_topology


def stages():
    figure = Figure(920, 230)

    def projected(x, y, z):
        return (0.87 * x + 0.5 * y, z + 0.28 * y - 0.12 * x)

    a, b, c = 4.0, 2.4, 1.0
    r = c / 2
    middle = [(r, r, r), (a - r, r, r), (a - r, b - r, r), (r, b - r, r)]
    titles = ['the shape O', 'sheets: the medial axis', 'curves', 'a point']
    for i, title in enumerate(titles):
        panel = figure.panel(22 + 228 * i, 150, 38)
        corners = [[projected(x, y, z) for x, y in ((0, 0), (a, 0), (a, b), (0, b))] for z in (0, c)]
        front = [corners[0][0], corners[0][1], corners[1][1], corners[1][0]]
        right = [corners[0][1], corners[0][2], corners[1][2], corners[1][1]]
        if i == 0:
            panel.polygon(front, fill='#dbe3ea', stroke=GREY)
            panel.polygon(right, fill='#c3ced8', stroke=GREY)
            panel.polygon(corners[1], fill='#eef2f5', stroke=GREY)
        else:
            for z in (0, 1):
                panel.polygon(corners[z], stroke=LIGHT, dash='3 3')
            for k in range(4):
                panel.line(corners[0][k], corners[1][k], stroke=LIGHT, dash='3 3')
        if i == 1:
            ends = [(0, 0), (a, 0), (a, b), (0, b)]
            for z in (0, c):
                for k in range(4):
                    m = (k + 1) % 4
                    quad = [
                        projected(*ends[k], z),
                        projected(*ends[m], z),
                        projected(*middle[m]),
                        projected(*middle[k]),
                    ]
                    panel.polygon(quad, fill=SKY, stroke=BLUE, width=0.7, opacity=0.35)
            panel.polygon([projected(*p) for p in middle], fill=BLUE, stroke=BLUE, opacity=0.75)
        if i in (2, 3):
            flat = [projected(*p) for p in middle]
            panel.polygon(flat, fill=SKY, opacity=0.5, stroke=SKY)
            half = b / 2 - r
            left, right_end = projected(r + half, b / 2, r), projected(a - r - half, b / 2, r)
        if i == 2:
            panel.line(left, right_end, stroke=RED, width=2.6)
            for end, corner in ((left, 0), (left, 3), (right_end, 1), (right_end, 2)):
                panel.line(end, flat[corner], stroke=RED, width=1.3)
        if i == 3:
            panel.dot(between(left, right_end, 0.5), 5, fill=RED)
        figure.text(22 + 228 * i + 92, 196, title, size=14, weight='bold')
        if i:
            label = ['', 'burn the shape', 'burn the sheets', 'burn the curves'][i]
            x = 228 * i - 8
            figure.text(x + 6, 26, label, size=12, fill=GREY)
            arrow = figure.panel(x - 40, 36, 1)
            arrow.arrow((0, 0), (92, 0), stroke=GREY)
    figure.text(92 + 22, 216, 'dimension 3', size=12, fill=GREY)
    for i, text in ((1, 'dimension 2: R, λ, ET'), (2, 'dimension 1: ET_MC'), (3, 'dimension 0')):
        figure.text(22 + 228 * i + 92, 216, text, size=12, fill=GREY)
    figure.save('stages.svg')


def verification():
    figure = Figure(900, 350)

    def box(x, y, w, h, title, lines, fill, stroke):
        panel = figure.panel(x, y + h, 1)
        panel.rectangle((0, 0), (w, h), fill=fill, stroke=stroke, width=1.6)
        figure.text(x + w / 2, y + 24, title, size=15, weight='bold')
        for k, line in enumerate(lines):
            figure.text(x + w / 2, y + 48 + 19 * k, line, size=12)

    box(
        20,
        20,
        270,
        135,
        'the program',
        ['triangulation, peeling, bricks', 'centres, radii, λ, thinning', 'burning, curves, skeletons', 'graph'],
        '#eef4fa',
        BLUE,
    )
    box(
        315,
        20,
        270,
        135,
        'quench verify',
        [
            'nearest sites, hulls, circumspheres',
            'λ, thinning by keys',
            'enclosure, proximity, closed pockets',
            'bounds of burn times and levels',
        ],
        '#edf7f0',
        GREEN,
    )
    box(
        610,
        20,
        270,
        135,
        'brute force of the tests',
        ['all empty balls of small shapes', 'burning by definition', 'signed tetrahedra for voxels', 'closed forms'],
        '#fdf3e1',
        ORANGE,
    )
    box(
        20,
        180,
        565,
        66,
        'shared by program and verify',
        ['readers, table of arrays, make_complex(), topology(), cleaning of voxels, voxelization'],
        PALE,
        GREY,
    )
    box(
        20, 266, 860, 66, 'shared by all three', ['the voxel shape, boundary_vertices(), integer_spacing()'], PALE, GREY
    )
    figure.save('verification.svg')


FIGURES = [
    stages,
    voxelization,
    delaunay,
    digitization_topology,
    voxel_core,
    plane_core,
    plane_subdivision,
    plane_measures,
    plane_fire,
    peeling,
    bricks,
    burning,
    burning_links,
    burning_fronts,
    skeletons,
    curve_graph,
    verification,
]

if __name__ == '__main__':
    for draw in FIGURES:
        if len(sys.argv) < 2 or draw.__name__ in sys.argv[1:]:
            draw()
