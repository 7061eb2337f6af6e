# SPDX-License-Identifier: Apache-2.0
"""Results of images: pixels, GeoJSON, plots."""
from __future__ import annotations

import json
from typing import Any, Dict, Optional, Tuple

import numpy as np

from . import _core
from ._common import Array, Path, need, written


def marks(complex: Any, sides: Tuple[int, ...]) -> Tuple[Array, Array, Array]:
    """The pixels a graph runs through: of points along its edges, no more than a third of a pixel apart, the pixel (an
    index into the flat image), the edge (-1: of a vertex) and the radius. What leaves the image is left out.

    Between vertices the square of the radius is that of the distance to one point, which is exact for a medial axis, and
    never too much elsewhere; nor is what the balls of both ends leave of theirs.
    """
    # A pixel is the whole part of a place. What lies on the border of two is in the later one, however it was rounded.
    places, radius, edges = complex.row_col + (0.5 + 1e-9), complex.radius, complex.edges
    start, way = places[edges[:, 0]], places[edges[:, 1]] - places[edges[:, 0]]
    steps = np.maximum(1, np.ceil(3 * np.abs(way).max(axis=1))).astype(np.int64) if len(edges) else np.zeros(0, np.int64)
    edge = np.repeat(np.arange(len(edges)), steps + 1)
    t = (np.arange(len(edge)) - np.repeat(np.cumsum(steps + 1) - steps - 1, steps + 1)) / np.maximum(steps, 1)[edge]
    length = ((complex.vertices[edges[:, 1]] - complex.vertices[edges[:, 0]])**2).sum(axis=1)
    squares = radius[edges]**2
    along = (1 - t) * squares[edge, 0] + t * squares[edge, 1] - t * (1 - t) * length[edge]
    pixel = np.floor(np.concatenate([places, start[edge] + t[:, None] * way[edge]])).astype(np.int64)
    inside = ((pixel >= 0) & (pixel < sides)).all(axis=1)
    whole = np.sqrt(length)[edge]
    ends = np.maximum(radius[edges[edge, 0]] - t * whole, radius[edges[edge, 1]] - (1 - t) * whole)
    edge = np.concatenate([np.full(len(places), -1), edge])
    radius = np.concatenate([radius, np.maximum(np.sqrt(np.maximum(along, 0)), ends)])
    return np.ravel_multi_index(tuple(pixel[inside].T), sides), edge[inside], radius[inside]


def image(complex: Any, mask: Array, return_distance: bool, branch: Optional[Array]) -> Any:
    """See MedialAxis.to_image and Skeleton.to_image. `branch`: of each edge, where numbers are wanted in place of True."""
    pixel, edge, radius = marks(complex, mask.shape)
    if branch is None:
        mask.flat[pixel] = True
    else:
        mask = np.zeros(mask.shape, np.int32)
        pixel_of, number = pixel[edge >= 0], branch[edge[edge >= 0]] + 1
        order = np.argsort(-number, kind='stable')  # the last one stays
        mask.flat[pixel_of[order]] = number[order]
    if not return_distance:
        return mask
    distance = np.zeros(mask.shape)
    order = np.argsort(radius, kind='stable')
    distance.flat[pixel[order]] = radius[order]
    return mask, distance


def _number(value: float) -> Optional[float]:
    return value if np.isfinite(value) else None  # JSON has no infinity


def geojson(graph: Any, y_down: bool) -> Dict[str, Any]:
    """See Graph.to_geojson. Features are those of the files of the program."""
    names = ('from', 'to', 'from_kind', 'to_kind', 'length', 'mean_radius', 'min_radius', 'max_radius', 'thickness',
             'tortuosity')
    arrays = {'radius': graph.radii, 'erosion_thickness': graph.erosion_thickness, 'mgf': graph.mgf}
    features = []
    for b, path in enumerate(graph.paths):
        row: Dict[str, Any] = {'branch': b, **{name: graph.branches[name][b].item() for name in names}}
        row.update({name: _number(row[name]) for name in names[4:]})
        row.update({name: [_number(value) for value in lists[b].tolist()] for name, lists in arrays.items()})
        features.append(_feature('LineString', path.tolist(), row))
    nodes = graph.nodes
    for n in np.flatnonzero(nodes['kind'] == 'isolated').tolist():
        row = {'from': n, 'kind': 'isolated', 'radius': float(nodes['radius'][n])}
        features.append(_feature('Point', [float(nodes['x'][n]), float(nodes['y'][n])], row))
    return {'type': 'FeatureCollection', 'y_axis': 'down' if y_down else 'up', 'features': features}


def _feature(kind: str, coordinates: Any, properties: Dict[str, Any]) -> Dict[str, Any]:
    return {'type': 'Feature', 'geometry': {'type': kind, 'coordinates': coordinates}, 'properties': properties}


def write_json(value: Dict[str, Any], path: Path) -> None:
    """Over an existing file, and never half written."""
    _core.write_text(written(path), json.dumps(value, allow_nan=False))


def plot(result: Any, ax: Any, *, cmap: str = 'viridis', linewidth: float = 1.5, colorbar: bool = True) -> Any:
    """See MedialAxis.plot and Skeleton.plot: edges by radius, over an image that `imshow` has drawn into `ax`."""
    collections, pyplot = (need('matplotlib.' + name, 'plot()') for name in ('collections', 'pyplot'))
    fresh = ax is None
    if fresh:
        ax = pyplot.figure(figsize=(7, 6)).add_subplot()
    lines = collections.LineCollection(result.vertices[result.edges], linewidths=linewidth, capstyle='round', cmap=cmap)
    lines.set_array(result.radius[result.edges].mean(axis=1))
    ax.add_collection(lines)
    alone = result.vertices[np.bincount(result.edges.ravel(), minlength=len(result.vertices)) == 0]
    if len(alone):
        ax.scatter(*alone.T, color='crimson', s=4)
    if fresh:
        ax.autoscale_view()
        ax.set_aspect('equal')
        if result._core.y_down:
            ax.invert_yaxis()
    if colorbar and len(result.edges):
        ax.figure.colorbar(lines, ax=ax, label='radius', shrink=0.6)
    return ax
