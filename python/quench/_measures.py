# SPDX-License-Identifier: Apache-2.0
"""Significance measures of the cells of a medial axis."""
from __future__ import annotations

from typing import Iterator, Mapping, NamedTuple, Optional

import numpy as np

from . import _core
from ._common import Array


class Cells(NamedTuple):
    """One value per cell, by dimension."""
    vertices: Array
    edges: Array
    polygons: Array


class Measure(NamedTuple):
    """A significance measure of the cells of a medial axis."""
    values: Optional[Cells]
    levels: Optional[Cells]
    """The largest threshold up to which a pruning by the measure keeps each cell; None where there is no such pruning."""


class Measures(Mapping[str, Measure]):
    """The measures of a medial axis by name; arrays are views, or computed when asked for."""

    def __init__(self, core: '_core.Axis'):
        self._core = core

    def __getitem__(self, name: str) -> Measure:
        if name not in self._core.measure_names():
            raise KeyError(name)
        return Measure(*(given and Cells(*map(np.asarray, given)) for given in self._core.measure(name)))

    def __iter__(self) -> Iterator[str]:
        return iter(self._core.measure_names())

    def __len__(self) -> int:
        return len(self._core.measure_names())
