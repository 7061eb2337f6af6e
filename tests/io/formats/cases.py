# SPDX-License-Identifier: Apache-2.0
"""What a case of volume_formats.py is, how a valid file is damaged, and how an outcome is judged."""
import itertools
from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Tuple

import numpy as np

DIMS = (5, 4, 3)
INTEGERS = ['uint8', 'int8', 'uint16', 'int16', 'uint32', 'int32', 'uint64', 'int64']
FLOATS = ['float32', 'float64']
TYPES = INTEGERS + FLOATS
SPACING = (0.5, 0.75, 2.0)
ORIGIN = (10.0, 20.0, 30.0)


@dataclass
class Grid:
    """A volume that would be right: samples[x, y, z], and where they are."""

    samples: np.ndarray
    spacing: Tuple = (1.0, 1.0, 1.0)
    origin: Tuple = (0.0, 0.0, 0.0)
    direction: np.ndarray = field(default_factory=lambda: np.eye(3))
    units: Optional[Tuple[str, ...]] = None  # those that may be said, '-' for none; None: any
    space: Tuple[str, ...] = ('-', 'LPS')  # what may be said of the world axes
    placed: bool = True  # False: spacing and the rest are not looked at
    any_axes: bool = False  # axes may come in another order, as long as every sample is where it belongs
    any_type: bool = False  # numbers must be the same, their type need not
    anything: bool = False  # nothing is looked at: a damaged file without checksums, whatever it is taken for
    plane: bool = False  # an image: one slice, y down, and the third step is the smaller of the two

    def __str__(self) -> str:
        where = f', spacing {numbers(self.spacing)}, origin {numbers(self.origin)}' if self.placed else ''
        turned = self.placed and not np.allclose(self.direction, np.eye(3))
        return (' x '.join(map(str, self.samples.shape)) + f' {self.samples.dtype}' + (' image' if self.plane else '') + where
                + (f', direction {numbers(np.ravel(self.direction))}' if turned else '')
                + (f', units {" or ".join(self.units)}' if self.units else ''))


@dataclass
class Case:
    """Files, the one that is opened ('.' is their folder), and what may come of it: one of `right` or, where it is
    `refusable`, exit 3 with a sentence."""

    name: str
    files: Dict[str, bytes]
    opened: str
    right: List[Grid]
    refusable: bool = False
    by_program: bool = False  # the program itself reads it, too
    cuts: Optional[range] = None  # bytes of the main file where a cut can be noticed; None: everywhere
    damage: bool = True
    usage: bool = False  # refused for the options, with exit 2
    memory: bool = False  # refused for want of memory, with exit 1
    how: Tuple[Tuple[str, str], ...] = ()  # options of the reader: ('channel', 'red'), ('dimension', '3')

    def code(self) -> int:
        """Of the refusal."""
        return 2 if self.usage else 1 if self.memory else 3

    def expected(self) -> str:
        text = ' or '.join(map(str, self.right))
        return text + (' or ' if text and self.refusable else '') + (f'exit {self.code()}' if self.refusable else '')


def case(name: str, data, opened: str, *right: Grid, **more) -> Case:
    """A case of one file (bytes) or several (a dictionary)."""
    files = data if isinstance(data, dict) else {opened: data}
    more.setdefault('refusable', not right)
    more.setdefault('damage', False)
    return Case(name, files, opened, list(right), **more)


def image(samples: np.ndarray, spacing=(1.0, 1.0), **more) -> Grid:
    """samples[x, y] of a plane."""
    return Grid(samples.reshape(samples.shape[0], -1, 1), tuple(spacing) + (min(spacing),), plane=True, **more)


def slab(samples: np.ndarray) -> Grid:
    """The same image, taken as one slice of a volume."""
    return Grid(samples.reshape(samples.shape[0], -1, 1))


def one_slice(name: str, data, opened: str, right: Grid) -> List[Case]:
    """A volume of one slice: refused until somebody says what it is. `right`: of the volume."""
    direction = np.eye(3)
    direction[:2, :2] = right.direction[:2, :2]
    plane = replace(right, spacing=right.spacing[:2] + (min(right.spacing[:2]),), origin=tuple(right.origin[:2]) + (0.0,),
                    direction=direction, space=('-',), plane=True)
    return [case(f'{name}, one slice', data, opened, usage=True),
            case(f'{name}, one slice, an image', data, opened, plane, how=(('dimension', '2'),), by_program=True),
            case(f'{name}, one slice, a slab', data, opened, right, how=(('dimension', '3'),))]


def numbers(values) -> str:
    return '(' + ', '.join(f'{float(v):.9g}' for v in values) + ')'


def volume(kind: str, dims=DIMS, finite: bool = False) -> np.ndarray:
    """Distinct samples (as far as there are so many) with the extremes of their type; no byte of the last one is zero, so
    that a missing end shows."""
    dtype = np.dtype(kind)
    count = int(np.prod(dims))
    random = np.random.default_rng(dtype.num * 1000 + count)
    if dtype.kind in 'iu':
        info = np.iinfo(dtype)
        special = {0, 1, info.min, info.max, info.max - 1} | ({-1} if dtype.kind == 'i' else {2})
        chosen = set(special)
        while len(chosen) < min(count, 2**(8 * dtype.itemsize)):
            bits = int(random.integers(3, dtype.itemsize * 8 + 1))
            chosen.add(max(info.min, min(info.max, int.from_bytes(random.bytes(8), 'little') % 2**bits
                                         + (info.min if random.random() < 0.3 else 0))))
        flat = np.resize(np.array(sorted(chosen), dtype=dtype), count)
    else:
        info = np.finfo(dtype)
        special = [0.0, 1.0, -1.0, info.max, -info.max, info.tiny, float(info.tiny) / 4, 0.1]
        special += [] if finite else [np.inf, -np.inf, np.nan]
        flat = np.concatenate([special, random.normal(size=max(0, count - len(special))) * 1000])[:count].astype(dtype)
    random.shuffle(flat)
    flat[-1] = np.frombuffer(b'\x5a' * dtype.itemsize, dtype)[0] if dtype.itemsize > 2 or dtype.kind != 'f' else 90
    return flat.reshape(dims, order='F')


def raw(samples: np.ndarray, order: str = '<') -> bytes:
    """x fastest."""
    return samples.astype(samples.dtype.newbyteorder(order)).tobytes(order='F')


def slices(samples: np.ndarray, order: str = '<') -> List[bytes]:
    return [raw(samples[:, :, z], order) for z in range(samples.shape[2])]


def rotation(axis=(1.0, 2.0, 3.0), degrees: float = 40.0) -> np.ndarray:
    k = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    a = np.radians(degrees)
    return np.eye(3) + np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross


def resized(grid: Grid, dims) -> Optional[Grid]:
    """What a raw file of this grid holds for a header that claims `dims`: a prefix, or nothing where it is too short."""
    if any(d < 1 for d in dims) or np.prod([float(d) for d in dims]) > grid.samples.size:
        return None
    flat = grid.samples.ravel(order='F')[:int(np.prod(dims))]
    return replace(grid, samples=flat.reshape(dims, order='F'))


def wrong_sizes(dims=DIMS, most: int = 2**63) -> List[Tuple]:
    """Sizes with one that is wrong."""
    found = []
    for axis in range(len(dims)):
        for size in (dims[axis] + 1, dims[axis] - 1, 0, -1, 2**15 - 1, 2**31 - 1, 2**31, 2**32 + dims[axis], 2**40, 2**63 - 1):
            if size <= most:
                found.append(dims[:axis] + (size,) + dims[axis + 1:])
    found.append((min(most, 2**21),) * len(dims))  # the product wraps around in 64 bits
    return found


def claims(name: str, grid: Grid, write, opened: str, most: int = 2**63) -> List[Case]:
    """Files whose header claims other sizes: write(dims) is a file of them with the samples of `grid`."""
    found = []
    for dims in wrong_sizes(grid.samples.shape, most):
        right = resized(grid, dims)
        found.append(case(f'{name}, header claims {dims}', write(dims), opened, *([right] if right else []), refusable=True))
    return found


def damaged(whole: Case) -> List[Case]:
    """The case with one of its files cut at every 37th byte and at the last 16, or with rubbish behind."""
    found = []
    for name, data in whole.files.items():
        def variant(what, changed):
            files = {**whole.files, name: changed}
            found.append(Case(f'{whole.name}, {name} {what}', files, whole.opened, whole.right, refusable=True, how=whole.how))
        allowed = whole.cuts if whole.cuts is not None and name == whole.opened else range(len(data))
        for n in sorted(set(range(0, len(data), 37)) | set(range(max(0, len(data) - 16), len(data)))):
            if n in allowed:
                variant(f'cut to {n} of {len(data)} bytes', data[:n])
        for rubbish in (b'\n', b'\0', b'\xff' * 7, b'rubbish ' * 40):
            variant(f'with {len(rubbish)} bytes of {rubbish[:1]!r} behind', data + rubbish)
    return found


# ---------------------------------------------------------------------------------------------------------- outcomes

def parse(line: str) -> Optional[Grid]:
    """A line "read ..." of the program read_volumes."""
    words = line.split(' ')
    if words[0] != 'read':
        return None
    dims = tuple(map(int, words[2:5]))
    placed = list(map(float, words[5:20]))
    if words[23] == '-':
        samples = np.broadcast_to(np.zeros((), words[1]), dims)  # too large to print, and so larger than all of ours
    else:
        samples = np.frombuffer(bytes.fromhex(words[23]), words[1]).reshape(dims, order='F')
    return Grid(samples, tuple(placed[:3]), tuple(placed[3:6]), np.array(placed[6:]).reshape(3, 3), units=(words[20],),
                space=(words[21],), plane=words[24:] == ['2', 'down'])


def difference(got: Grid, wanted: Grid) -> str:
    """What is wrong with it; empty: nothing."""
    if wanted.anything:
        return ''
    if wanted.any_axes:
        found = [difference(reordered(got, axes), replace(wanted, any_axes=False))
                 for axes in itertools.permutations(range(3))]
        return min(found, key=len)
    if got.samples.shape != wanted.samples.shape:
        return f'{" x ".join(map(str, got.samples.shape))} voxels'
    if got.plane != wanted.plane:
        return 'an image' if got.plane else 'a volume'
    if got.samples.dtype != wanted.samples.dtype and not wanted.any_type:
        return f'samples of type {got.samples.dtype}'
    same = equal(got.samples, wanted.samples)
    if not same.all():
        at = tuple(int(i) for i in np.argwhere(~same)[0])
        return (f'{(~same).sum()} of {same.size} samples differ, the first at {at}: {got.samples[at]} instead of '
                f'{wanted.samples[at]}')
    if wanted.placed:
        for what in ('spacing', 'origin', 'direction'):
            a, b = np.ravel(getattr(got, what)), np.ravel(getattr(wanted, what))
            if not np.allclose(a, b, rtol=2e-6, atol=2e-6):
                return f'{what} {numbers(a)} instead of {numbers(b)}'
    if wanted.units is not None and got.units[0] not in wanted.units:
        return f'units {got.units[0]} instead of {" or ".join(wanted.units)}'
    if got.space[0] not in wanted.space:
        return f'space {got.space[0]} instead of {" or ".join(wanted.space)}'
    return ''


def equal(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    if a.dtype.kind in 'iu' and b.dtype.kind in 'iu':
        return a == b if a.dtype == b.dtype else a.astype(object) == b.astype(object)
    with np.errstate(all='ignore'):
        x, y = a.astype(float), b.astype(float)
        exact = a.dtype == b.dtype
        close = x == y if exact else np.isclose(x, y, rtol=1e-6, atol=0)
        return close | (np.isnan(x) & np.isnan(y))


def reordered(grid: Grid, axes) -> Grid:
    return replace(grid, samples=grid.samples.transpose(axes), spacing=tuple(grid.spacing[i] for i in axes),
                   direction=grid.direction[:, list(axes)])


def judge(tried: Case, line: str) -> str:
    """What is wrong with an outcome, a line of the program read_volumes; empty: nothing."""
    if line == 'whole only':
        return ''
    words = line.split(' ', 2)
    if words[0] == 'refused':
        if words[1] != str(tried.code()):
            return f'exit {words[1]}: {words[2]}'
        if not tried.refusable:
            return f'exit 3: {words[2]}'
        if len(words[2]) > 1000 or any(ord(c) < 32 for c in words[2]):
            return f'exit 3, but not with one sentence: {words[2]!r}'
        return ''
    got = parse(line)
    if got is None:
        return line  # a crash, or an exception that is not an Error
    found = [difference(got, wanted) for wanted in tried.right]
    if not found:
        return f'taken: {got}'
    return min(found, key=len)
