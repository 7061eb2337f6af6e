# SPDX-License-Identifier: Apache-2.0
"""What a medial axis and a skeleton have in common."""
from __future__ import annotations

from functools import cached_property
from typing import Any, ContextManager, Optional, Tuple

import numpy as np

from . import _export, _plane, _show
from ._common import Array, Progress, Topology, calling, error, topology_of
from ._pickles import Result


class Complex(Result):
    """Vertices with radii, edges and polygons: views of what the library holds. Of an image there are no polygons."""

    _core: Any  # Axis or Skeleton
    _threads: int = 0
    _progress: Progress = False

    def _calling(self, threads: Optional[int], progress: Optional[Progress]) -> ContextManager[Any]:
        """Threads and progress of a call: as given, else as given to the call that made this."""
        return calling(self._threads if threads is None else threads, self._progress if progress is None else progress)

    def __repr__(self) -> str:
        polygons = '' if self.dimension == 2 else f', {len(self.polygons[0]) - 1} polygons'
        return f'{type(self).__name__} of {len(self.vertices)} vertices, {len(self.edges)} edges{polygons}'

    @property
    def dimension(self) -> int:
        """2 of an image, else 3: the number of coordinates of a vertex."""
        return int(self._core.dimension)

    @property
    def units(self) -> str:
        """Of lengths, where they are known."""
        return str(self._core.units)

    def _facts(self) -> _show.Facts:
        """What a notebook shows of it."""
        cells = [_show.counted(len(self.vertices), 'vertex', 'vertices'), _show.counted(len(self.edges), 'edge')]
        if self.dimension == 3:
            cells.append(_show.counted(len(self.polygons[0]) - 1, 'polygon'))
        return [('cells', ', '.join(cells)), ('topology', _show.topology_text(self.topology, self.dimension)),
                ('radius', _show.ranged(self.radius, self.units)), ('box', _show.box_text(self.vertices, self.units))]

    def _picture(self) -> Optional[bytes]:
        """A small PNG, where that is quick."""
        return _show.picture(self._draw) if len(self.vertices) <= 10**6 else None

    def _draw(self, file: bytes) -> None:
        raise NotImplementedError

    @property
    def topology(self) -> Topology:
        return topology_of(self._core)

    @cached_property
    def vertices(self) -> Array:
        return np.asarray(self._core.vertices)[:, :self.dimension]

    @cached_property
    def row_col(self) -> Array:
        """(V, 2) float64: of an image, row and column of each vertex, whole numbers at centres of pixels."""
        self._of_image('row_col', 'vertices / spacing')
        return np.asarray(self._core.rows_and_columns())

    def _of_image(self, what: str, of_volumes: str) -> None:
        if self.dimension != 2:
            raise error(2, f'{what} is of images of two dimensions; of volumes there is {of_volumes}')

    def _no_image(self, what: str, of_images: str) -> None:
        if self.dimension == 2:
            raise error(2, f'{what} is of volumes and meshes; of images there is {of_images}')

    def _image(self, voxel_shape: Any, shape: Any, return_distance: bool, branch: Any = None) -> Any:
        self._of_image('to_image()', 'to_volume() of a skeleton')
        return _plane.image(self, _export.mask(voxel_shape, shape, 2), return_distance, branch)

    @cached_property
    def radius(self) -> Array:
        return np.asarray(self._core.radius)

    @cached_property
    def edges(self) -> Array:
        return np.asarray(self._core.edges)

    @cached_property
    def edge_degree(self) -> Array:
        return np.bincount(np.asarray(self._core.polygon_edges), minlength=len(self.edges))

    @cached_property
    def polygons(self) -> Tuple[Array, Array]:
        return np.asarray(self._core.polygon_offsets), np.asarray(self._core.polygon_corners)
