# SPDX-License-Identifier: Apache-2.0
"""What all parts of the package share: errors, lengths, files, progress."""
from __future__ import annotations

import importlib
import math
import numbers
import os
import sys
import warnings
from contextlib import contextmanager
from html import escape
from types import FrameType
from typing import TYPE_CHECKING, Any, Callable, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Tuple, Type, Union

import numpy as np

from . import _core
from ._core import Error as Error, UsageError as UsageError

Error.code = 1  # of errors raised without one
Error.argument = None
if TYPE_CHECKING:
    Array = np.ndarray[Any, np.dtype[Any]]
else:
    Array = np.ndarray
Length = Union[float, str]  # 0.02 and "2%" of the longest side, "2.5vox", "3.5abs", "inf"
Path = Union[str, 'os.PathLike[str]']
Spacing = Union[float, Sequence[float], None]  # in the order of the axes of an array: x, y, z, or of an image y, x
Progress = Union[bool, Callable[[str, float], Any], None]


class ArgumentTypeError(UsageError, TypeError):
    """An argument of a wrong type: a :class:`UsageError`, so that it is a ``ValueError`` too, and a ``TypeError``."""


class MissingFileError(Error, FileNotFoundError):
    """A file or folder that is not there: an :class:`Error` of code 1, and a ``FileNotFoundError``."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ''


ArgumentTypeError.__module__ = MissingFileError.__module__ = 'quench'  # where people find them


def error(code: int, sentence: str, argument: Optional[str] = None, kind: Optional[Type[Error]] = None) -> Error:
    """An Error to raise: code 2 is an invalid argument (a UsageError), 3 an input that cannot be used."""
    result = (kind or (UsageError if code == 2 else Error))(sentence)
    result.code = code
    result.argument = argument
    return result


def wrong_type(sentence: str, argument: str) -> Error:
    """An Error to raise for an argument that is not of a type that makes sense."""
    return error(2, sentence, argument, ArgumentTypeError)


def must_exist(path: Path) -> None:
    if not os.path.exists(path):
        raise error(1, f"'{os.fsdecode(path)}' does not exist", None, MissingFileError)


def deprecated(old: str, new: str) -> None:
    """Warns of a spelling that works for one more release."""
    warn(f'{old} is deprecated; use {new}', DeprecationWarning)


def warn(sentence: str, category: Type[Warning] = UserWarning) -> None:
    """A warning of the line outside this package that led to it."""
    level = 1
    frame: Optional[FrameType] = sys._getframe(1)
    while frame is not None and frame.f_globals.get('__name__', '').startswith('quench.'):
        level, frame = level + 1, frame.f_back
    warnings.warn(sentence, category, stacklevel=level + 1)


class Topology(NamedTuple):
    """Euler characteristic and Betti numbers.

    Attributes
    ----------
    euler : int
    betti : tuple of int
        Connected components, independent loops (tunnels; of an image: holes), cavities (of an image: 0).
    """

    euler: int
    betti: Tuple[int, int, int]


def topology_of(core: Any) -> Topology:
    euler, (components, loops, cavities) = core.topology
    return Topology(euler, (components, loops, cavities))


class Certificate:
    """What ``verify()`` found. True when every check passed.

    Attributes
    ----------
    checks : list of (name, passed, detail)
        `detail` has figures, or the first counterexample.
    """

    def __init__(self, checks: Iterable[Tuple[str, bool, str]]):
        self.checks = [(str(name), bool(passed), str(detail)) for name, passed, detail in checks]

    def _repr_html_(self) -> str:
        rows = ''.join(f'<tr><td>{"ok" if passed else "<b>FAIL</b>"}</td><td style="text-align:left">{escape(name)}</td>'
                       f'<td style="text-align:left">{escape(detail)}</td></tr>' for name, passed, detail in self.checks)
        return f'<table>{rows}</table>'

    def __bool__(self) -> bool:
        return all(passed for _, passed, _ in self.checks)

    def __repr__(self) -> str:
        return '\n'.join(f'{"ok  " if passed else "FAIL"} {name}: {detail}' for name, passed, detail in self.checks)


def text_of(value: Length) -> Optional[str]:
    """The text of a text or a number; nothing when it is neither."""
    if isinstance(value, str):
        return value
    if isinstance(value, numbers.Real) and not isinstance(value, (bool, np.bool_)):
        return 'inf' if math.isinf(value) and value > 0 else repr(float(value))
    return None


def length(value: Length, argument: str) -> str:
    """The text of a length; an Error when it is not one."""
    text = text_of(value)
    if text is None:
        raise wrong_type(f'{argument}={value!r} is not a length; give a fraction of the longest side (0.02 or "2%"), '
                         '"2.5vox", "3.5abs" or "inf"', argument)
    _core.check_length(text, argument.rstrip('_'))
    return text


def length_or_auto(value: Length, argument: str) -> str:
    return 'auto' if isinstance(value, str) and value == 'auto' else length(value, argument)


def pruning_of(detail: Length, lambda_: Optional[Length],
               prune_by: Optional[Tuple[str, Length]] = None) -> Tuple[str, str]:
    """The measure to prune by, and "auto" or the text of a threshold."""
    by_detail = length_or_auto(detail, 'detail')
    if prune_by is not None:
        if by_detail != 'auto' or lambda_ is not None:
            raise error(2, f'prune_by={prune_by!r} and detail or lambda_ are two measures to prune by; give one of them',
                        'prune_by')
        if not isinstance(prune_by, tuple) or len(prune_by) != 2 or not isinstance(prune_by[0], str):
            raise wrong_type(f"prune_by={prune_by!r} is not a measure and its threshold, such as ('mgf', '10vox')", 'prune_by')
        measure, threshold = prune_by
        return measure, threshold_of(measure, threshold)
    if lambda_ is None:
        return 'detail', by_detail
    if by_detail != 'auto':
        raise error(2, f'lambda_={lambda_!r} and detail={detail!r} are two measures to prune by; give one of them', 'lambda_')
    return 'lambda', length_or_auto(lambda_, 'lambda_')


def threshold_of(measure: str, value: Length) -> str:
    """The text of a threshold of a measure; an Error when it is none."""
    text = text_of(value)
    if text is None:
        raise wrong_type(f'{value!r} is not a threshold of {measure}; give a number or a text', 'prune_by')
    _core.check_threshold(measure, text)
    return text


def measures_of(names: Union[str, Sequence[str]]) -> List[str]:
    """The names of measures; an Error for others."""
    listed = [names] if isinstance(names, str) else list(names)
    if not all(isinstance(name, str) for name in listed):
        raise wrong_type(f'measures={names!r} are not names of measures', 'measures')
    return [known for name in listed for known in _core.check_measures(name)]


def reals(value: Any, what: str) -> Array:
    """An array of real numbers as doubles, or an Error: numpy would drop imaginary parts and read numbers in texts."""
    try:
        array = np.asarray(value)
        texts = array.dtype.kind == 'O' and any(isinstance(x, (str, bytes)) for x in array.flat)
        if array.dtype.kind in 'biufO' and not texts:  # objects: fractions, decimals
            return array.astype(np.float64, copy=False)
        reason = 'there are texts among them' if texts else f'they are of type {array.dtype}'
    except (TypeError, ValueError, OverflowError) as failure:
        reason = str(failure)
    raise error(3, f'{what} are not real numbers: {reason}') from None


def spacing_of(spacing: Spacing, dimension: Optional[int] = None) -> Optional[Tuple[float, float, float]]:
    """Along x, y and z (0: there are two), as the core takes it, of one positive number or one per axis of the array; or None.

    Arrays of two axes are image[y, x]. Without `dimension` there may be two or three numbers.
    """
    if spacing is None:
        return None
    try:
        given = reals(spacing, 'sizes')
        values = np.broadcast_to(given, dimension or 3) if given.ndim == 0 else given
    except Error:
        values = np.zeros(0)
    if values.ndim != 1 or len(values) not in ((dimension,) if dimension else (2, 3)) or \
            not np.all(np.isfinite(values)) or not np.all(values > 0):
        raise error(2, f'spacing={spacing!r} is neither a voxel size nor a pixel size; give one positive number, or one per '
                       'axis of the array: three, or two of an image, (y, x)', 'spacing')
    if len(values) == 2:
        return (float(values[1]), float(values[0]), 0.0)  # as the library has two numbers
    return (float(values[0]), float(values[1]), float(values[2]))


def whole(value: Any, argument: str, least: int = 0) -> int:
    """A whole number, or an Error that names the argument."""
    try:
        number = int(value)
        if number != value:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        kind = None if isinstance(value, numbers.Real) else ArgumentTypeError
        raise error(2, f'{argument}={value!r} is not a whole number', argument, kind) from None
    if number < least:
        raise error(2, f'{argument}={value!r} is less than {least}', argument)
    return number


def is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def file_name(path: Path) -> bytes:
    return os.fsencode(path)


def written(path: Path) -> bytes:
    """The name of a file to write; an Error where its folder is missing."""
    folder = os.path.dirname(os.fsdecode(path))
    if folder and not os.path.isdir(folder):
        raise error(1, f"cannot write '{os.fsdecode(path)}': the folder '{folder}' does not exist; create it first", None,
                    MissingFileError)
    return os.fsencode(path)


def ending(path: Path) -> str:
    return os.path.splitext(os.fsdecode(path))[1].lower()


class _Lines:
    """Progress without tqdm: a line per stage that takes a second or more."""

    def __init__(self) -> None:
        self.stage: Optional[str] = None

    def __call__(self, stage: str, fraction: float) -> None:
        if stage != self.stage:
            self.stage = stage
            print(f'quench: {stage}', file=sys.stderr, flush=True)

    def close(self) -> None:
        pass


class _Bar:
    """A bar of tqdm that starts anew with every stage."""

    def __init__(self, tqdm: Any):
        self.bar = tqdm(total=1.0, leave=False, bar_format='{desc:<12} {percentage:3.0f}%|{bar}| {elapsed}')

    def __call__(self, stage: str, fraction: float) -> None:
        self.bar.set_description_str(stage, refresh=False)
        self.bar.n = fraction
        self.bar.refresh()

    def close(self) -> None:
        self.bar.close()


@contextmanager
def listening(progress: Progress) -> Iterator[Optional[Callable[[str, float], Any]]]:
    """What the core calls as (stage, fraction): None, a bar, or the function that was given."""
    if not progress:
        yield None
    elif callable(progress):
        yield progress
    else:
        try:
            shown: Any = _Bar(importlib.import_module('tqdm').tqdm)
        except ImportError:
            shown = _Lines()
        try:
            yield shown
        finally:
            shown.close()


@contextmanager
def calling(threads: int, progress: Progress) -> Iterator[Tuple[Optional[Callable[[str, float], Any]], int]]:
    """The last two arguments of every long call of the core."""
    with listening(progress) as listener:
        yield listener, whole(threads, 'threads')


def need(module: str, use: str) -> Any:
    """A package that is not required, or an Error that names it."""
    try:
        return importlib.import_module(module)
    except ImportError as missing:
        raise error(1, f'{use} needs the package {module.split(".")[0]}, which is not installed') from missing
