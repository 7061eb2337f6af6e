# SPDX-License-Identifier: Apache-2.0
"""Results in the hands of other packages: plots, meshes. None of them is needed to import quench."""
from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from ._common import Array, error, need, whole


def mask(voxel_shape: Any, wanted: Optional[Sequence[int]], dimension: int) -> Array:
    """An empty image for a result: of the shape that is wanted, else of the image it is of."""
    if wanted is None:
        if voxel_shape is None:
            raise error(2, 'the medial axis comes from a file, which does not hold the image; compute it with medial_axis()')
        wanted = voxel_shape.dims
    sides = tuple(whole(side, 'shape', 1) for side in wanted)
    if len(sides) != dimension:
        raise error(2, f'shape={tuple(wanted)!r} has {len(sides)} sides; the image has {dimension}', 'shape')
    return np.zeros(sides, dtype=bool)


def to_trimesh(vertices: Array, faces: Array) -> Any:
    return need('trimesh', 'to_trimesh()').Trimesh(vertices.copy(), faces.astype(np.int64), process=False)


def to_pyvista(vertices: Array, faces: Array, edges: Array, arrays: Dict[str, Array]) -> Any:
    def padded(rows: Array) -> Array:
        return np.insert(rows.astype(np.int64), 0, rows.shape[1], axis=1).ravel()

    pyvista = need('pyvista', 'to_pyvista()')
    vertices = np.pad(vertices, ((0, 0), (0, 3 - vertices.shape[1])))
    data = pyvista.PolyData(vertices.copy(), **({'faces': padded(faces)} if len(faces) else {}),
                            **({'lines': padded(edges)} if len(edges) else {}))
    for name, values in arrays.items():
        data.point_data[name] = values
    return data


def swc_table(text: str) -> Dict[str, Array]:
    """The samples of an SWC file as columns, with the names that navis has for them."""
    rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith('#')]
    columns = list(zip(*rows)) or [()] * 7
    whole_ones = {'node_id': 0, 'parent_id': 6, 'type': 1}
    numbers = {'x': 2, 'y': 3, 'z': 4, 'radius': 5}
    table = {name: np.array(columns[c], np.int64) for name, c in whole_ones.items()}
    table.update({name: np.array(columns[c], np.float64) for name, c in numbers.items()})
    return {name: table[name] for name in ('node_id', 'parent_id', 'x', 'y', 'z', 'radius', 'type')}


def to_navis(table: Dict[str, Array], units: str) -> Any:
    """A ``navis.TreeNeuron``, or a ``navis.NeuronList`` of one per root."""
    navis, pandas = need('navis', 'to_navis()'), need('pandas', 'to_navis()')
    root: Dict[int, int] = {}
    tree = np.zeros(len(table['node_id']), np.int64)
    for row, (node, parent) in enumerate(zip(table['node_id'].tolist(), table['parent_id'].tolist())):
        root[node] = tree[row] = root[parent] if parent >= 0 else node  # parents come before children
    frame = pandas.DataFrame({('label' if name == 'type' else name): values for name, values in table.items()})
    neurons = [navis.TreeNeuron(frame[tree == first].reset_index(drop=True), units=units or None)
               for first in np.unique(tree)]
    return neurons[0] if len(neurons) == 1 else navis.NeuronList(neurons)


def _parts(result: Any) -> Tuple[Array, Array, str, Array, Array, Array]:
    """Triangles with a value each, segments with a value each, single points."""
    if hasattr(result, 'sheets'):
        sheets, curves = result.sheets, result.curves
        triangles, value, name = sheets.vertices[sheets.faces], sheets.erosion_thickness, 'erosion thickness'
        segments, thick = curves.vertices[curves.edges], curves.radius[curves.edges].mean(axis=1)
        alone = curves.vertices[np.bincount(curves.edges.ravel(), minlength=len(curves.vertices)) == 0]
        return triangles, value, name, segments, thick, alone
    et = result.erosion_thickness()
    lone = result.edges[result.edge_degree == 0]
    isolated = result.vertices[np.bincount(result.edges.ravel(), minlength=len(result.vertices)) == 0]
    return (result.vertices[result.faces], et[result.faces].mean(axis=1), 'erosion thickness', result.vertices[lone],
            result.radius[lone].mean(axis=1), isolated)


def plot(result: Any, ax: Any = None, *, cmap: str = 'viridis', linewidth: float = 1.5, view: Sequence[float] = (25, -55),
         colorbar: bool = True) -> Any:
    """See MedialAxis.plot and Skeleton.plot. `view`: elevation and azimuth in degrees."""
    matplotlib, cm, colors, pyplot = (need('matplotlib' + name, 'plot()') for name in ('', '.cm', '.colors', '.pyplot'))
    art = need('mpl_toolkits.mplot3d.art3d', 'plot()')
    triangles, value, name, segments, thick, alone = _parts(result)
    if ax is None:
        ax = pyplot.figure(figsize=(7, 6)).add_subplot(projection='3d', computed_zorder=True)
    finite = value[np.isfinite(value)]
    if len(triangles):
        # Light comes from the viewer's upper left, so that sheets show their bends.
        normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        shade = 0.55 + 0.45 * np.abs(normal @ (np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)))[:, None]
        norm = colors.Normalize(0, finite.max() if len(finite) and finite.max() > 0 else 1, clip=True)
        paint = matplotlib.colormaps[cmap](norm(np.where(np.isfinite(value), value, 0)))
        paint[~np.isfinite(value)] = (0.6, 0.6, 0.6, 1)  # closed pockets never burn
        paint[:, :3] *= shade
        ax.add_collection3d(art.Poly3DCollection(triangles, facecolors=paint, edgecolors=paint, linewidths=0.2))
        if colorbar and len(finite):
            ax.figure.colorbar(cm.ScalarMappable(norm, cmap), ax=ax, label=name, shrink=0.6)
    if len(segments):
        lines = art.Line3DCollection(segments, linewidths=linewidth, capstyle='round')
        if len(finite):
            lines.set_color('crimson')
        else:
            lines.set_array(thick)
            lines.set_cmap(cmap)
            if colorbar:
                ax.figure.colorbar(lines, ax=ax, label='radius', shrink=0.6)
        ax.add_collection3d(lines)
    if len(alone):
        ax.scatter(*alone.T, color='crimson', s=4)
    places = np.concatenate([triangles.reshape(-1, 3), segments.reshape(-1, 3), alone])
    if len(places):
        low, high = places.min(axis=0), places.max(axis=0)
        side = np.maximum(high - low, 0.05 * (high - low).max() or 1.0)
        middle = (low + high) / 2
        for a, limit in enumerate((ax.set_xlim, ax.set_ylim, ax.set_zlim)):
            limit(middle[a] - side[a] / 2, middle[a] + side[a] / 2)
        ax.set_box_aspect(side / side.max())
    ax.view_init(*view)
    return ax
