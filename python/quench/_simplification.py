# SPDX-License-Identifier: Apache-2.0
"""Medial axes of few vertices."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Optional, Type

from . import _core, _show
from ._common import Progress, calling, whole
from ._pickles import Result

if TYPE_CHECKING:
    from ._axis import MedialAxis


class Simplification(Result):
    """What MedialAxis.simplified() gives: an axis of few vertices, and those of every other number.

    Attributes
    ----------
    axis : MedialAxis
        Of triangles and edges; balls, cones along edges and slabs over triangles stay near the shape.
    errors : dict
        How far the boundary lies from them: "outside", 0 where they cover it, and "either_side", each with "mean", "p99"
        and "largest", in world units.
    boundary : str
        What that is: "mesh", "grey" or "smooth", the surface the shape has; "voxels", its corners; "envelope", of an axis
        from a file, its own.
    most, least : int
        Vertices of the axis in the beginning, and the fewest that its topology allows.
    """

    _kept = (*Result._kept, '_kind', 'most', 'least', 'boundary', 'errors', 'axis')

    def __init__(self, core: '_core.Simplification', kind: Type['MedialAxis'], threads: int, progress: Progress):
        self._core, self._kind, self._threads, self._progress = core, kind, threads, progress
        self.most: int = core.most
        self.least: int = core.least
        self.boundary: str = core.boundary
        self.errors: Dict[str, Any] = core.errors
        with calling(threads, progress) as call:
            self.axis = kind(core.axis(*call), threads, progress)

    def level(self, vertices: int, *, threads: Optional[int] = None, progress: Optional[Progress] = None) -> 'MedialAxis':
        """The axis of another number of vertices, between `least` and `most`, of the same topology."""
        number = whole(vertices, 'vertices', 1)
        used = self._threads if threads is None else threads
        shown = self._progress if progress is None else progress
        with calling(used, shown) as call:
            return self._kind(self._core.level(number, *call), used, shown)

    def _repr_html_(self) -> str:
        facts = [('vertices', f'{len(self.axis.vertices):,} of {self.most:,}; {self.least:,} at least'),
                 ('measured from', self.boundary)]
        facts += [(name.replace('_', ' '), f'mean {_show.number(of["mean"])}, largest {_show.number(of["largest"])}')
                  for name, of in self.errors.items() if isinstance(of, dict)]
        return _show.card('Simplified medial axis', facts, self.axis._picture())

    def __repr__(self) -> str:
        return f'<quench.Simplification: {len(self.axis.vertices)} of {self.most} vertices>'
