# SPDX-License-Identifier: Apache-2.0
"""What a medial axis and a skeleton have in common."""
from __future__ import annotations

from functools import cached_property
from typing import Any, ContextManager, Optional, Tuple

import numpy as np

from ._common import Progress, calling


class Complex:
    """Vertices with radii, edges and polygons: views of what the library holds."""

    _core: Any
    _threads: int = 0
    _progress: Progress = False

    def _calling(self, threads: Optional[int], progress: Optional[Progress]) -> ContextManager[Any]:
        """Threads and progress of a call: as given, else as given to the call that made this."""
        return calling(self._threads if threads is None else threads, self._progress if progress is None else progress)

    def __repr__(self) -> str:
        return (f'{type(self).__name__} of {len(self.vertices)} vertices, {len(self.edges)} edges, '
                f'{len(self.polygons[0]) - 1} polygons')

    @cached_property
    def vertices(self) -> np.ndarray:
        return np.asarray(self._core.vertices)

    @cached_property
    def radius(self) -> np.ndarray:
        return np.asarray(self._core.radius)

    @cached_property
    def edges(self) -> np.ndarray:
        return np.asarray(self._core.edges)

    @cached_property
    def edge_degree(self) -> np.ndarray:
        return np.bincount(np.asarray(self._core.polygon_edges), minlength=len(self.edges))

    @cached_property
    def polygons(self) -> Tuple[np.ndarray, np.ndarray]:
        return np.asarray(self._core.polygon_offsets), np.asarray(self._core.polygon_corners)
