# SPDX-License-Identifier: Apache-2.0
"""Sheets, seams and junctions of a skeleton."""
from __future__ import annotations

from functools import cached_property
from typing import Any, Dict, List, NamedTuple, Optional

import numpy as np

from . import _core, _export, _show
from ._common import Array, Path, ending, written
from ._pickles import Result

Table = Dict[str, Any]


class SheetMesh(NamedTuple):
    """A sheet by itself, cut off along its seams: a manifold with boundary."""
    vertices: Array
    """(V, 3) float64"""
    faces: Array
    """(F, 3) int32: triangles, of an orientable sheet all one way round."""
    thickness: Array
    """(V,): 2 r, as in the table of sheets."""
    radius: Array
    erosion_thickness: Optional[Array]
    point: Array
    """(V,): the row of :attr:`Parts.vertices` that each vertex is; sheets that meet have rows in common."""

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh``."""
        return _export.to_trimesh(self.vertices, self.faces)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` with ``thickness``."""
        return _export.to_pyvista(self.vertices, self.faces, np.zeros((0, 2), np.int32), {'thickness': self.thickness})


class Parts(Result):
    """The sheets of a skeleton, the seams along which they meet, and the junctions of these; made by
    :meth:`Skeleton.parts`.

    Attributes
    ----------
    sheets, seams, junctions : dict of arrays
        A row each, with the columns of ``parts.csv``, ``seams.csv`` and ``junctions.csv`` (docs/user/parts.md). Sheets are
        in the order of their areas, the largest first; their numbers are the column `sheet`. `seams`, `sheets` and
        `neighbours` are lists of arrays of numbers.
    meshes : list of SheetMesh
        Every sheet by itself, by its number.
    vertices, radius, erosion_thickness : arrays
        Of the mesh of all sheets, with common points at seams.
    faces, face_sheet : (F, 3) and (F,) int32
        Its triangles and their sheets.
    seam_edges, edge_seam : (E, 2) and (E,) int32
        The edges of seams, and their seams.
    units : str
        Of lengths, where they are known.
    """

    def __init__(self, core: '_core.Parts'):
        self._core = core

    def __repr__(self) -> str:
        counts = {name: len(getattr(self, name + 's')[name]) for name in ('sheet', 'seam', 'junction')}
        return 'Parts: ' + ', '.join(f'{count} {name}{"" if count == 1 else "s"}' for name, count in counts.items())

    def _repr_html_(self) -> str:
        columns = [name for name in ('sheet', 'area', 'mean_thickness', 'neighbours') if name in self.sheets]
        most = 10
        rows = [[' '.join(map(str, value)) if isinstance(value, np.ndarray) else f'{value:.4g}'
                 for value in (self.sheets[name][n] for name in columns)] for n in range(min(most, len(self.meshes)))]
        more = len(self.meshes) - len(rows)
        below = _show.table(columns, rows) + (f'<p>and {more:,} more</p>' if more else '')
        return _show.card(repr(self), [('units', self.units)] if self.units else [], None, below if rows else '')

    @cached_property
    def sheets(self) -> Table:
        return self._table('sheets')

    @cached_property
    def seams(self) -> Table:
        return self._table('seams')

    @cached_property
    def junctions(self) -> Table:
        return self._table('junctions')

    def _table(self, name: str) -> Table:
        return {column: _numbers(values) if isinstance(values, list) else np.asarray(values)
                for column, _, _, values in self._core.table(name)}

    @cached_property
    def meshes(self) -> List[SheetMesh]:
        found = []
        for vertices, faces, arrays in self._core.meshes():
            named = {name: np.asarray(values) for name, values in arrays.items()}
            found.append(SheetMesh(np.asarray(vertices), np.asarray(faces), named['thickness'], named['radius'],
                                   named.get('erosion_thickness'), named['point']))
        return found

    @property
    def units(self) -> str:
        return self._core.units

    @cached_property
    def vertices(self) -> Array:
        return np.asarray(self._core.vertices)

    @cached_property
    def radius(self) -> Array:
        return np.asarray(self._core.radius)

    @cached_property
    def erosion_thickness(self) -> Array:
        return np.asarray(self._core.erosion_thickness)

    @cached_property
    def thickness(self) -> Array:
        """(V,): 2 r; where the axis is that of the voxels, r is half a voxel more than `radius`."""
        return 2 * (self.radius + self._core.more_radius)

    @cached_property
    def faces(self) -> Array:
        return np.asarray(self._core.faces)

    @cached_property
    def face_sheet(self) -> Array:
        return np.asarray(self._core.face_sheet)

    @cached_property
    def seam_edges(self) -> Array:
        return np.asarray(self._core.seam_edges)

    @cached_property
    def edge_seam(self) -> Array:
        return np.asarray(self._core.edge_seam)

    def save(self, path: Path) -> None:
        """Writes all sheets as .vtp, .vtu, .ply, .obj (a group for each) or .stl, or the table of sheets as .csv."""
        if ending(path) == '.csv':
            self._core.save_table(written(path))
        else:
            self._core.save(written(path))

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` of all sheets."""
        return _export.to_trimesh(self.vertices, self.faces)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` of all sheets and seams with ``thickness``."""
        return _export.to_pyvista(self.vertices, self.faces, self.seam_edges, {'thickness': self.thickness})


def _numbers(texts: List[str]) -> List[Array]:
    return [np.array(text.split(), dtype=np.int64) for text in texts]
