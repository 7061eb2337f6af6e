# SPDX-License-Identifier: Apache-2.0
"""A drawing of panels as SVG text: just what the figures of the documentation need."""
import math
from pathlib import Path

import numpy as np

INK, GREY, LIGHT, PALE = '#1f2933', '#7b8794', '#cbd2d9', '#f0f3f6'
BLUE, SKY, RED, ORANGE, GREEN = '#2563a8', '#bcd7f2', '#c62828', '#d97706', '#2e7d4f'
SAND, MINT = '#fbe3bf', '#cfe9d8'


def _style(fill=None, stroke=None, width=1.0, dash=None, opacity=None):
    """Attributes that differ from those of the whole drawing."""
    values = {
        'fill': fill,
        'stroke': stroke,
        'stroke-width': None if width == 1 else f'{width:g}',
        'stroke-dasharray': dash,
        'fill-opacity': None if opacity is None else f'{opacity:g}',
    }
    return ' '.join(f'{name}="{value}"' for name, value in values.items() if value)


class Figure:
    """`width` x `height` pixels; y down. Panels put drawings in their own coordinates, y up, into it."""

    def __init__(self, width, height):
        self.width, self.height, self.items = width, height, []

    def panel(self, x, y, scale, origin=(0, 0)):
        """Coordinates whose `origin` lies at pixel (x, y), `scale` pixels for a unit."""
        return Panel(self, x, y, scale, origin)

    def text(self, x, y, text, size=13, anchor='middle', fill=INK, weight='normal', style='normal'):
        text = str(text).replace('&', '&amp;').replace('<', '&lt;')
        looks = ''.join(
            f' {name}="{value}"'
            for name, value in (('font-weight', weight), ('font-style', style))
            if value != 'normal'
        )
        self.items.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" text-anchor="{anchor}" fill="{fill}"{looks}>{text}</text>'
        )

    def save(self, name):
        body = '\n'.join(self.items)
        (Path(__file__).parent / name).write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" '
            f'height="{self.height}" font-family="DejaVu Sans, Helvetica, Arial, sans-serif" fill="none" '
            'stroke-linejoin="round" stroke-linecap="round">\n'
            f'<rect width="{self.width}" height="{self.height}" fill="#ffffff"/>\n{body}\n</svg>\n',
            encoding='utf-8',
        )


class Panel:
    def __init__(self, figure, x, y, scale, origin):
        self.figure, self.x, self.y, self.scale, self.origin = figure, x, y, scale, origin

    def at(self, p):
        return self.x + (p[0] - self.origin[0]) * self.scale, self.y - (p[1] - self.origin[1]) * self.scale

    def _points(self, points):
        return ' '.join('{:.1f},{:.1f}'.format(*self.at(p)) for p in points)

    def polygon(self, points, **style):
        self.figure.items.append(f'<polygon points="{self._points(points)}" {_style(**style)}/>')

    def path(self, points, **style):
        self.figure.items.append(f'<polyline points="{self._points(points)}" {_style(**style)}/>')

    def line(self, a, b, **style):
        self.path([a, b], **style)

    def paths(self, lines, **style):
        """Several lines in one element."""
        text = ''.join('M' + 'L'.join('{:.1f} {:.1f}'.format(*self.at(p)) for p in line) for line in lines)
        self.figure.items.append(f'<path d="{text}" {_style(**style)}/>')

    def rectangle(self, low, high, **style):
        self.polygon([low, (high[0], low[1]), high, (low[0], high[1])], **style)

    def circle(self, centre, radius, **style):
        """Of a radius in units of the panel."""
        x, y = self.at(centre)
        self.figure.items.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius * self.scale:.1f}" {_style(**style)}/>')

    def dot(self, centre, pixels=3.0, fill=INK, stroke=None, width=1.0):
        x, y = self.at(centre)
        self.figure.items.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{pixels:g}" {_style(fill=fill, stroke=stroke, width=width)}/>'
        )

    def square(self, centre, pixels=3.0, fill=INK, stroke=None):
        x, y = self.at(centre)
        self.figure.items.append(
            f'<rect x="{x - pixels:.1f}" y="{y - pixels:.1f}" width="{2 * pixels:g}" height="{2 * pixels:g}" '
            f'{_style(fill=fill, stroke=stroke)}/>'
        )

    def arrow(self, a, b, stroke=INK, width=1.5, head=7, dash=None):
        (x0, y0), (x1, y1) = self.at(a), self.at(b)
        length = max(1e-9, ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5)
        dx, dy = (x1 - x0) / length, (y1 - y0) / length
        bx, by = x1 - head * dx, y1 - head * dy
        self.figure.items.append(
            f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{bx:.1f}" y2="{by:.1f}" {_style(stroke=stroke, width=width, dash=dash)}/>'
        )
        side = head * 0.45
        self.figure.items.append(
            f'<polygon points="{x1:.1f},{y1:.1f} {bx - side * dy:.1f},{by + side * dx:.1f} '
            f'{bx + side * dy:.1f},{by - side * dx:.1f}" {_style(fill=stroke)}/>'
        )

    def text(self, p, text, dx=0, dy=0, **style):
        x, y = self.at(p)
        self.figure.text(x + dx, y + dy, text, **style)


def between(a, b, t):
    return tuple((1 - t) * np.asarray(a, float) + t * np.asarray(b, float))


def ramp(t):
    """From blue over yellow to red."""
    stops = [(0.0, (37, 99, 168)), (0.35, (66, 160, 150)), (0.65, (240, 180, 60)), (1.0, (198, 40, 40))]
    t = min(1.0, max(0.0, t))
    for (a, low), (b, high) in zip(stops, stops[1:]):
        if t <= b:
            return '#' + ''.join(f'{round(x + (y - x) * (t - a) / (b - a)):02x}' for x, y in zip(low, high))
    return '#c62828'


def inside_contour(p, contour):
    total = 0.0
    for a, b in zip(contour, contour[1:]):
        u, v = np.subtract(a, p), np.subtract(b, p)
        total += math.atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    return total / (2 * math.pi)
