# SPDX-License-Identifier: Apache-2.0
"""The voxel core of a shape in pixels: the algorithm of the library in 2D, by scipy's Delaunay triangulation."""
import numpy as np
from scipy.spatial import Delaunay


class PlaneCore:
    """`inside[x, y]`: pixels. Cells are merged triangles inside; core edges join cells across a Delaunay edge."""

    def __init__(self, inside):
        self.inside = np.pad(inside, 1)  # pixel (x, y) of the shape is self.inside[x + 1, y + 1]
        corners = sum(
            self.inside[dx : dx + inside.shape[0] + 1, dy : dy + inside.shape[1] + 1].astype(int)
            for dx in (0, 1)
            for dy in (0, 1)
        )
        self.sites = np.argwhere((corners > 0) & (corners < 4))
        delaunay = Delaunay(self.sites)
        self.triangles = [t for t in delaunay.simplices if self.contains(self.sites[t].mean(axis=0))]
        self._merge()

    def contains(self, p):
        x, y = int(np.floor(p[0])), int(np.floor(p[1]))
        return (
            0 <= x + 1 < self.inside.shape[0] and 0 <= y + 1 < self.inside.shape[1] and bool(self.inside[x + 1, y + 1])
        )

    def _merge(self):
        cells = {}
        for t in self.triangles:
            a, b, c = (self.sites[i].astype(float) for i in t)
            d = 2 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
            if abs(d) < 1e-9:
                continue
            u, v = ((b - a) ** 2).sum(), ((c - a) ** 2).sum()
            centre = a + np.array([(c[1] - a[1]) * u - (b[1] - a[1]) * v, (b[0] - a[0]) * v - (c[0] - a[0]) * u]) / d
            key = tuple(np.round(centre, 6)) + (round(float(np.linalg.norm(a - centre)), 6),)
            cells.setdefault(key, set()).update(int(i) for i in t)
        self.centre = np.array([key[:2] for key in cells])
        self.radius = np.array([key[2] for key in cells])
        self.cells = []
        for (x, y, _), members in cells.items():  # corners in cyclic order
            self.cells.append(sorted(members, key=lambda i: np.arctan2(self.sites[i][1] - y, self.sites[i][0] - x)))
        self.cells_at = {}  # per Delaunay edge between two sites
        for number, corners in enumerate(self.cells):
            for a, b in zip(corners, [*corners[1:], corners[0]]):
                self.cells_at.setdefault((min(a, b), max(a, b)), []).append(number)
        shared = [(edge, pair) for edge, pair in self.cells_at.items() if len(pair) == 2]
        self.sites_of = [edge for edge, _ in shared]
        self.edges = [tuple(pair) for _, pair in shared]
        self.edge_lambda = np.array([np.linalg.norm(self.sites[a] - self.sites[b]) / 2 for a, b in self.sites_of])

    def levels(self):
        """Per core edge: the largest threshold it survives, thinning by pairs of an edge and a free vertex."""
        value = np.zeros(len(self.cells))
        at = [set() for _ in self.cells]
        for e, (a, b) in enumerate(self.edges):
            value[a], value[b] = max(value[a], self.edge_lambda[e]), max(value[b], self.edge_lambda[e])
            at[a].add(e), at[b].add(e)
        level, running = np.full(len(self.edges), np.inf), 0.0
        while True:
            pairs = [
                (max(self.edge_lambda[e], value[v]), e, v) for v in range(len(at)) if len(at[v]) == 1 for e in at[v]
            ]
            if not pairs:
                return level
            key, e, _ = min(pairs)
            running = max(running, key)
            level[e] = running
            for v in self.edges[e]:
                at[v].discard(e)


def whale(width=30, height=18):
    """A plane shape with a thick body, a thin tail and a bump."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5, indexing='ij')
    body = ((x - 10) / 9.2) ** 2 + ((y - 8) / 6.2) ** 2 < 1
    tail = (np.abs(y - (8 + 0.16 * (x - 10))) < 2.1) & (x > 10) & (x < 27)
    fin = (np.abs(x - 26.2) < 1.7) & (np.abs(y - 10.6) < 5.4)
    bump = (x - 8) ** 2 + (y - 14) ** 2 < 3.2
    return body | tail | fin | bump
