# SPDX-License-Identifier: Apache-2.0
"""Pickles of what the library holds: a few bytes, and large arrays as buffers, which protocol 5 can leave apart."""
from __future__ import annotations

import pickle
from typing import Any, Dict, List, Tuple

from . import _core

KINDS = ('Shape', 'Axis', 'Skeleton', 'Graph', 'Parts', 'Tree', 'Solid', 'Simplification')


def restore(kind: str, small: bytes, large: List[Any], *others: Any) -> Any:
    """What `pieces_of` took to pieces; `others` are what it is made of."""
    return getattr(_core, 'restore_' + kind)(small, large, *others)


def _reduce(self: Any, protocol: int) -> Tuple[Any, ...]:
    small, large, *others = _core.pieces_of(self)
    apart: Any = pickle.PickleBuffer if protocol >= 5 else bytes
    return restore, (type(self).__name__, small, [apart(array) for array in large], *others)


for _kind in KINDS:
    getattr(_core, _kind).__reduce_ex__ = _reduce


class Result:
    """What holds a result of the library as `_core`; attributes that follow from it are computed again when they are
    asked for, and a function that progress was told to is left behind."""

    def __getstate__(self) -> Dict[str, Any]:
        state = {name: value for name, value in self.__dict__.items() if name in self._kept}
        if '_progress' in state:
            state['_progress'] = bool(state['_progress']) and not callable(state['_progress'])
        return state

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self.__dict__.update(state)

    _kept: Tuple[str, ...] = ('_core', '_threads', '_progress')
