# SPDX-License-Identifier: Apache-2.0
"""Images, meshes and files, and how they become voxel shapes."""
from __future__ import annotations

import numbers
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core, _export, _show
from ._common import (ArgumentTypeError, Array, Error, Path, Progress, Spacing, calling, error, file_name, is_path,
                      must_exist, reals, spacing_of, whole, wrong_type)


@dataclass
class Mesh:
    """A triangle mesh.

    Attributes
    ----------
    vertices : (V, 3) float64 array
    faces : (F, 3) int32 array
    branches : list of dict
        Of ``sample("root")`` only: the true branches, each with ``parent``, ``parent_point``, ``length``, ``points``,
        ``radius``.
    touching : list of dict
        Of ``sample("root")`` only: where two branches run into each other, each with ``branch``, ``other``, ``from``,
        ``to`` (places on their centre lines) and ``on_purpose``.
    """

    vertices: Array
    faces: Array
    branches: List[Dict[str, Any]] = field(default_factory=list, repr=False)
    touching: List[Dict[str, Any]] = field(default_factory=list, repr=False)

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh``."""
        return _export.to_trimesh(self.vertices, self.faces)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData``."""
        return _export.to_pyvista(self.vertices, self.faces, np.zeros((0, 2), np.int32), {})


class Volume:
    """A volume, or an image of two dimensions, with its place in the world; :func:`read` makes one of a file.

    It is accepted wherever an image is, and results have its place and units.

    Parameters
    ----------
    array : (X, Y, Z) array, or (rows, columns)
        Not copied, except float16 and foreign byte order.
    spacing : float or a float per axis, optional
        Size of a voxel (x, y, z) or pixel (y, x), in the order of the axes of the array. Default: 1.
    origin : three floats (x, y, z), or two (x, y), optional
        The place of the centre of the first voxel or pixel. Default: 0.
    direction : (3, 3) or (2, 2) array, optional
        Its columns are where the axes of the array point: perpendicular unit vectors. Default: x, y and z; of an image
        (y, x).
    units : str
        Of places, such as "mm"; tables and files say it.
    space : str
        "LPS" where x, y, z grow to the left, back and head of a body.

    Attributes
    ----------
    array : (X, Y, Z) array, or (rows, columns)
        The samples, not copied; of a volume axis 0 is x, of an image it is y and axis 1 is x. Also what
        ``numpy.asarray(volume)`` gives.
    spacing : (3,) or (2,) array
        Size of a voxel or pixel along the axes of the array.
    origin : (3,) or (2,) array
        The place x, y, z or x, y of the centre of the first one.
    direction : (3, 3) or (2, 2) array
        Where the axes point: place = origin + direction @ (spacing * index).
    units, space : str
        Of places, where the file says so.

    Raises
    ------
    UsageError
        For numbers that are no place of a grid: sizes of 0, axes that are not perpendicular.

    Examples
    --------
    >>> import numpy as np, quench
    >>> scan = np.zeros((30, 20, 20), np.int16)
    >>> scan[3:-3, 3:-3, 3:-3] = 700
    >>> volume = quench.Volume(scan, spacing=(0.5, 0.5, 2), origin=(100, 0, -50), units='mm')
    >>> quench.medial_axis(volume, threshold=300).vertices.min(axis=0) > (101, 1, -46)
    array([ True,  True,  True])
    """

    def __init__(self, array: Any, spacing: Spacing = None, origin: Optional[Sequence[float]] = None,
                 direction: Any = None, *, units: str = '', space: str = ''):
        self.array: Array = image_array(array, array.array.ndim if isinstance(array, Volume) else None)
        self._place = _place(self.array.ndim, spacing, origin, direction, units, space)

    @property
    def _axes(self) -> List[int]:
        """x, y or z of each axis of the array."""
        return [1, 0] if self.array.ndim == 2 else [0, 1, 2]

    @property
    def spacing(self) -> Array:
        return np.array(self._place.spacing)[self._axes]

    @property
    def origin(self) -> Array:
        return np.array(self._place.origin)[:self.array.ndim]

    @property
    def direction(self) -> Array:
        return np.array(self._place.direction)[:self.array.ndim, self._axes]

    @property
    def units(self) -> str:
        return self._place.units

    @property
    def space(self) -> str:
        return self._place.space

    def __getstate__(self) -> Dict[str, Any]:
        place = self._place
        return {'array': self.array, 'place': (place.dimension, place.spacing, place.origin, place.direction, place.units,
                                               place.space, place.y_down)}

    def __setstate__(self, state: Dict[str, Any]) -> None:
        self.array = state['array']
        self._place = _core.Place(*state['place'])

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> Array:
        if dtype is not None and np.dtype(dtype) != self.array.dtype:
            return self.array.astype(dtype)
        return self.array.copy() if copy else self.array

    @property
    def shape(self) -> Tuple[int, ...]:
        return self.array.shape

    @property
    def dtype(self) -> Any:
        return self.array.dtype

    def _repr_html_(self) -> str:
        def numbers(values: Array) -> str:
            return ', '.join(f'{value:g}' for value in values)

        facts = [('shape', ' x '.join(map(str, self.shape))), ('type', str(self.dtype)), ('spacing', numbers(self.spacing)),
                 ('origin', numbers(self.origin)), ('units', self.units), ('space', self.space)]
        return _show.card('Image' if self.array.ndim == 2 else 'Volume', [(name, value) for name, value in facts if value])

    def __repr__(self) -> str:
        kind = 'Image' if self.array.ndim == 2 else 'Volume'
        return f'{kind} of {self.array.shape} {self.array.dtype}, spacing {tuple(self.spacing)}'


SPACES = ('', 'LPS', 'scanner-xyz', '3D-right-handed', '3D-left-handed')


def volume_of(image: '_core.Image') -> Volume:
    """What the core has read or made."""
    volume = Volume.__new__(Volume)
    volume.array = np.asarray(image)
    volume._place = image.place
    return volume


def _numbers(value: Any, shape: Tuple[int, ...], argument: str, what: str) -> Array:
    try:
        values = reals(value, 'numbers')
    except Error:
        values = np.zeros(0)
    if values.shape != shape or not np.isfinite(values).all():
        raise error(2, f'{argument}={value!r} is not {what}', argument)
    return values


def _place(dimension: int, spacing: Spacing, origin: Any, direction: Any, units: str, space: str) -> '_core.Place':
    """Where an array lies in the world, as the core takes it."""
    if space not in SPACES:
        raise error(2, f'space={space!r} is not one of {", ".join(map(repr, SPACES[1:]))}', 'space')
    size = spacing_of(spacing, dimension) or (1.0, 1.0, 1.0)
    at, axes = np.zeros(3), np.eye(3)
    if origin is not None:
        at[:dimension] = _numbers(origin, (dimension,), 'origin', f'a place of {dimension} numbers')
    if direction is not None:
        given = _numbers(direction, (dimension, dimension), 'direction', f'a {dimension} x {dimension} matrix')
        if np.abs(given.T @ given - np.eye(dimension)).max() > 1e-4:
            raise error(2, f'direction={direction!r} has columns that are not perpendicular unit vectors; resample a sheared '
                           'image, and give sizes of voxels as spacing', 'direction')
        left, _, right = np.linalg.svd(given)
        nearest = given if np.abs(given.T @ given - np.eye(dimension)).max() <= 1e-15 else left @ right
        axes[:dimension, :dimension] = nearest[:, ::-1] if dimension == 2 else nearest
    return _core.Place(dimension, size, tuple(at), [tuple(row) for row in axes], str(units), space, dimension == 2)


CHANNELS = ('luminance', 'alpha', 'red', 'green', 'blue')


def check_reading(dimension: Optional[int], channel: Optional[str]) -> None:
    if dimension not in (None, 2, 3):
        raise error(2, f'dimension={dimension!r} is neither 2 nor 3', 'dimension')
    if channel is not None and channel not in CHANNELS:
        raise error(2, f'channel={channel!r} is not one of {", ".join(map(repr, CHANNELS))}', 'channel')


def _channel(array: Array, channel: str) -> Array:
    """One value per pixel of an image with colours, as files of images are read: luminance is that of ITU-R BT.601, on a
    white ground where pixels are transparent."""
    if array.ndim != 3 or array.shape[2] not in (3, 4):
        raise error(2, f'channel={channel!r} is of images of shape (rows, columns, 3 or 4); the shape of this one is '
                       f'{array.shape}', 'channel')
    if channel == 'alpha' and array.shape[2] == 3:
        raise error(2, "channel='alpha' is not in an image of three channels; take its luminance or a colour", 'channel')
    if channel != 'luminance':
        chosen: Array = array[:, :, ('red', 'green', 'blue', 'alpha').index(channel)]
        return chosen
    if array.dtype.kind == 'f':
        shade: Array = array[:, :, :3] @ np.array([0.299, 0.587, 0.114])
        if array.shape[2] == 3:
            return shade
        mixed: Array = shade * array[:, :, 3] + (1 - array[:, :, 3])
        return mixed
    if array.dtype not in (np.uint8, np.uint16):
        raise error(2, f"channel='luminance' is of images of uint8, uint16 or floats; this one is {array.dtype}", 'channel')
    colours = array.astype(np.int64)
    light, white = (colours[:, :, :3] @ np.array([19595, 38470, 7471]) + 2**15) >> 16, np.iinfo(array.dtype).max
    alpha: Any = colours[:, :, 3] if array.shape[2] == 4 else white
    mixed = (2 * (light * alpha + white * (white - alpha)) + white) // (2 * white)
    return mixed.astype(array.dtype)


def _of_dimension(array: Array, dimension: Optional[int], channel: Optional[str]) -> Array:
    """Of two or three axes: an image or a volume, where there is no doubt which."""
    if channel is not None:
        if dimension == 3:
            raise error(2, f'channel={channel!r} is of images, and dimension=3 of volumes; give one of them', 'channel')
        return _channel(array, channel)
    if array.ndim == 2 and dimension == 3:
        raise error(2, f'dimension=3 is not that of an image of shape {array.shape}; image[..., None] is a slice of voxels',
                    'dimension')
    if array.ndim != 3 or dimension == 3:
        return array
    if array.shape.count(1) == 1:
        axis = array.shape.index(1)
        if dimension == 2:
            return array.squeeze(axis)
        raise error(2, f'an image of shape {array.shape} may be meant as one of two dimensions or as a slice of voxels; pass '
                       f'image[{("0", ":, 0", "..., 0")[axis]}], or dimension=3', 'dimension')
    if dimension == 2:
        raise error(2, f'dimension=2 is not that of an image of shape {array.shape}; pass one slice of it', 'dimension')
    if array.shape[2] in (3, 4) and min(array.shape[:2]) > array.shape[2] and array.dtype.kind != 'b':
        raise error(2, f'an image of shape {array.shape} may be one with colours; choose a channel, e.g. channel="luminance" '
                       'or image[..., 0], or pass dimension=3 where the last axis is one of space', 'channel')
    return array


def image_array(value: Any, dimension: Optional[int] = None, channel: Optional[str] = None) -> Array:
    """An array of two or three axes the core can look at where it lies; copied only where its type makes that necessary."""
    if isinstance(value, np.ma.MaskedArray):
        raise error(3, 'the image is a masked array; say what masked voxels or pixels are, e.g. with image.filled(0)')
    try:
        array = np.asarray(value)
    except Exception as reason:
        raise error(3, f'{type(value).__name__} is not an image: {reason}') from reason
    if array.ndim == 0 and array.dtype.kind == 'O':
        raise wrong_type(f'{type(value).__name__} has no dimensions of an image; give an array, a mesh or the path of a file',
                         'image')
    array = _of_dimension(array, dimension, channel)
    if array.ndim not in (2, 3):
        raise error(3, f'the image has {array.ndim} dimensions; an image of a shape has 2 or 3')
    if array.size == 0:
        raise error(3, f'the image of shape {array.shape} holds no {"pixels" if array.ndim == 2 else "voxels"}')
    if array.dtype.kind not in 'biuf' or array.dtype.itemsize > 8:
        raise error(3, f'samples of type {array.dtype} are not values of an image; give bool, integer or float samples')
    if array.dtype == np.float16:
        array = array.astype(np.float32)
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder('='))
    return array


def mesh_arrays(vertices: Any, faces: Any) -> Tuple[Array, Array]:
    """Vertices as (V, 3) doubles, faces as (F, 3) int64; polygons become triangle fans."""
    points = reals(vertices, 'the vertices of the mesh')
    try:
        corners = np.asarray(faces)
    except (TypeError, ValueError) as reason:
        raise error(3, f'the faces of the mesh are not an array of numbers: {reason}') from reason
    if points.ndim != 2 or points.shape[1] != 3:
        raise error(3, f'the vertices have the shape {points.shape}; a mesh has (V, 3)')
    if corners.dtype.kind not in 'iu':
        raise error(3, f'the faces are of type {corners.dtype}; a mesh has integers, (F, 3)')
    if corners.ndim == 1:  # count, corners, count, corners ...: as VTK and PyVista write them
        corners = _padded(corners)
    if corners.ndim != 2 or corners.shape[1] < 3:
        raise error(3, f'the faces have the shape {corners.shape}; a mesh has (F, 3)')
    outside = (corners < 0) | (corners >= len(points))
    if outside.any():
        face = int(np.argmax(outside.any(axis=1)))
        corner = int(corners[face][outside[face]][0])
        raise error(3, f'face {face} names vertex {corner}, and there are {len(points)} vertices, from 0 on')
    corners = corners.astype(np.int64, copy=False)
    if corners.shape[1] > 3:
        corners = np.concatenate([corners[:, [0, i - 1, i]] for i in range(2, corners.shape[1])])
    return points, corners


def _padded(flat: Array) -> Array:
    triangles: List[Tuple[int, int, int]] = []
    at = 0
    while at < len(flat):
        n = int(flat[at])
        if n < 0 or at + n >= len(flat):
            raise error(3, 'the faces are a list of numbers that is not one of counts and corners; a mesh has (F, 3)')
        triangles.extend((flat[at + 1], flat[at + i - 1], flat[at + i]) for i in range(3, n + 1))
        at += n + 1
    return np.array(triangles, dtype=flat.dtype).reshape(-1, 3)


def as_mesh(value: Any) -> Optional[Tuple[Any, Any]]:
    """The vertices and faces of what is a mesh, None for what is none."""
    if isinstance(value, np.ndarray):
        return None
    if hasattr(value, 'faces') and (hasattr(value, 'vertices') or hasattr(value, 'points')):
        return (value.vertices if hasattr(value, 'vertices') else value.points), value.faces
    if isinstance(value, (tuple, list)) and len(value) == 2:
        return value[0], value[1]
    return None


def _threshold(value: Any) -> Union[int, float]:
    """A float, or the whole number itself where a float would round it."""
    try:
        if isinstance(value, numbers.Integral) and abs(int(value)) > 2**53:
            if not -2**63 <= int(value) < 2**64:
                raise error(2, f'threshold={value} does not fit into 64 bits', 'threshold')
            return int(value)
        return float(value)
    except (TypeError, ValueError, OverflowError) as reason:
        kind = ArgumentTypeError if isinstance(reason, TypeError) else None
        raise error(2, f'threshold={value!r} is not a number', 'threshold', kind) from None


def _thresholds(value: Any) -> Tuple[Optional[Union[int, float]], Optional[Union[int, float]]]:
    """The lower threshold and that of seeds, of None, a number or a pair."""
    if value is None:
        return None, None
    if not isinstance(value, (tuple, list)):
        return _threshold(value), None
    if len(value) != 2:
        raise error(2, f'threshold={value!r} is not a number or a pair (low, high)', 'threshold')
    return _threshold(value[0]), _threshold(value[1])


def _width(value: Any) -> float:
    try:
        width = float(value)
        if width >= 0:
            return width
    except TypeError:
        raise wrong_type(f'blur={value!r} is not a number from 0 on', 'blur') from None
    except (ValueError, OverflowError):
        pass
    raise error(2, f'blur={value!r} is not a number from 0 on', 'blur')


Threshold = Union[None, float, str, Tuple[float, float]]


@dataclass
class Cut:
    """Which voxels are the shape, and of which size: the keyword arguments of medial_axis()."""

    threshold: Threshold = None
    label: Optional[int] = None
    invert: bool = False
    largest_component: bool = False
    min_component: int = 0
    fill_cavities: bool = False
    subdivide: int = 1
    spacing: Spacing = None
    resolution: Union[int, str] = 256
    fill: str = 'nonzero'
    topology: str = 'mesh'
    surface: str = 'auto'
    dimension: Optional[int] = None
    channel: Optional[str] = None
    interpolate: bool = False
    median: int = 0
    blur: float = 0
    close: int = 0
    connectivity: int = 6
    keep_values: bool = False  # for bridges of trees
    keep_mesh: bool = False  # for thickness at its vertices

    def options(self, dimension: Optional[int] = None) -> '_core.ShapeOptions':
        """As the core takes them; `dimension`: of the image, where it is known."""
        check_reading(self.dimension, self.channel)
        if self.threshold is not None and self.label is not None:
            raise error(2, 'threshold and label cannot be combined; give one of them', 'threshold')
        if self.fill not in ('nonzero', 'evenodd', 'winding', 'auto'):
            raise error(2, f"fill={self.fill!r} is not one of 'nonzero', 'evenodd', 'winding', 'auto'", 'fill')
        if self.topology not in ('mesh', 'voxels'):
            raise error(2, f"topology={self.topology!r} is not one of 'mesh', 'voxels'", 'topology')
        if self.surface not in ('auto', 'voxels', 'mesh', 'grey', 'smooth'):
            raise error(2, f"surface={self.surface!r} is not one of 'auto', 'voxels', 'mesh', 'grey', 'smooth'", 'surface')
        if self.connectivity not in (6, 26):
            raise error(2, f'connectivity={self.connectivity!r} is neither 6 nor 26', 'connectivity')
        rule = self.threshold if isinstance(self.threshold, str) else ''
        if rule not in ('', 'auto', 'otsu', 'thin'):
            raise error(2, f"threshold={rule!r} is neither a number nor 'auto', 'thin' or 'otsu'", 'threshold')
        bounds = _thresholds(None if rule else self.threshold)
        options = _core.ShapeOptions(
            threshold=bounds[0], seed_threshold=bounds[1], rule=rule, interpolate=bool(self.interpolate),
            median=min(whole(self.median, 'median'), 2**30), blur=_width(self.blur),
            close=min(whole(self.close, 'close'), 2**30), connectivity=int(self.connectivity),
            label=None if self.label is None else label_of(self.label), invert=bool(self.invert),
            largest_component=bool(self.largest_component),
            min_component=min(whole(self.min_component, 'min_component'), 2**62), fill_cavities=bool(self.fill_cavities),
            subdivide=min(whole(self.subdivide, 'subdivide'), 2**30), spacing=spacing_of(self.spacing, dimension),
            resolution=0 if self.resolution == 'auto' else min(whole(self.resolution, 'resolution', 1), 2**30),
            fill=self.fill, topology=self.topology, surface=self.surface)
        options.keep_values = self.keep_values
        options.keep_mesh = self.keep_mesh
        return options

    def for_images(self) -> bool:
        """Whether something is given that means nothing for a mesh."""
        asked = self.invert, self.interpolate, self.median, self.blur, self.close, self.connectivity != 6
        return any(asked) or any(given is not None for given in (self.threshold, self.label, self.spacing, self.dimension,
                                                                 self.channel))


def label_of(value: Any) -> int:
    """A label that fits into 64 bits with a sign."""
    label = whole(value, 'label', -2**63)
    if label >= 2**63:
        raise error(2, f'label={label} does not fit into 64 bits with a sign', 'label')
    return label


def shape_of(source: Any, cut: Cut, threads: int, progress: Progress) -> '_core.Shape':
    """The voxel shape of an image, a mesh or a file."""
    cut.options()  # refuses what is wrong before a file is read
    with calling(threads, progress) as call:
        if not is_path(source):
            return _shape(source, cut, call)
        named = os.fsdecode(source)
        found = read_file(source, cut.spacing, None, call, cut.dimension, cut.channel)
        if isinstance(found, _core.Axis):
            raise error(3, f"'{named}' is a medial axis already; quench.read() gives it")
        try:
            return _shape(found, cut, call)
        except Error as reason:
            if reason.code not in (2, 3):
                raise
            raise error(reason.code, f"'{named}': {reason}", reason.argument) from None


def _shape(source: Any, cut: Cut, call: Tuple[Any, int]) -> '_core.Shape':
    if isinstance(source, Volume):
        return _core.shape_of_array(source.array, source._place, cut.options(source.array.ndim), *call)
    mesh = as_mesh(source)
    if mesh is None:
        array = image_array(source, cut.dimension, cut.channel)
        return _core.shape_of_array(array, None, cut.options(array.ndim), *call)
    if cut.for_images():
        raise error(2, 'threshold, label, invert, interpolate, median, blur, close, connectivity, spacing, dimension and '
                       'channel are for images; this is a mesh')
    return _core.shape_of_mesh(*mesh_arrays(*mesh), cut.options(), *call)


def read_file(path: Path, spacing: Spacing, radii: Optional[Path], call: Tuple[Any, int], dimension: Optional[int] = None,
              channel: Optional[str] = None) -> Union[Mesh, Volume, '_core.Axis']:
    """What a file holds; a medial axis as the core has it."""
    check_reading(dimension, channel)
    named = os.fsdecode(path)
    kind = _core.kind_of(file_name(path))
    must_exist(path)
    if radii is not None:
        must_exist(radii)
    if kind == 'volume':
        volume = volume_of(_core.read_image(file_name(path), spacing_of(spacing), dimension, channel or '', *call))
        spacing_of(spacing, volume.array.ndim)
        return volume
    if kind != 'surface':
        _core.refuse_unknown_kind(file_name(path))
    for name, given in (('spacing', spacing), ('dimension', dimension), ('channel', channel)):
        if given is not None:
            raise error(2, f"{name} is for images; '{named}' is not one", name)
    found = _core.read_surface(file_name(path), b'' if radii is None else file_name(radii), *call)
    return Mesh(np.asarray(found[0]), np.asarray(found[1])) if isinstance(found, tuple) else found


def sample(name: str, *, noise: float = 0, seed: int = 1, branches: int = 60, fineness: float = 1,
           touching: int = 0) -> Mesh:
    """A built-in shape as a closed mesh; ``quench.samples()`` lists them.

    Parameters
    ----------
    name : str
    noise : float
        Height of ripples and bumps as a fraction of the longest side, for shapes that have them; 0: the shape's own.
    seed, branches : int
        ``"root"``: another seed, another root; its number of branches.
    fineness : float
        Multiplies the number of triangles along each direction.
    touching : int
        ``"root"``: so many pairs of branches are turned until they touch.

    Examples
    --------
    >>> import quench
    >>> quench.sample('torus').vertices.shape[1]
    3
    >>> len(quench.sample('root', branches=5).branches)
    5
    >>> len(quench.sample('root', touching=2).touching)
    2
    """
    if not 1 <= branches <= 100000 or not 0.01 <= fineness <= 16 or not 0 <= noise <= 0.1:
        raise error(2, 'branches go from 1 to 100000, fineness from 0.01 to 16, noise from 0 to 0.1')
    found = _core.sample(name, float(noise), whole(seed, 'seed'), whole(branches, 'branches'), float(fineness),
                         whole(touching, 'touching', 0))
    truth = [{key: np.asarray(value) if key in ('points', 'radius') else value for key, value in branch.items()}
             for branch in found['branches']]
    return Mesh(np.asarray(found['vertices']), np.asarray(found['faces']), truth, found['touching'])


def samples() -> Dict[str, str]:
    """Names and descriptions of the built-in shapes.

    Examples
    --------
    >>> import quench
    >>> 'root' in quench.samples()
    True
    """
    return _core.samples()


def voxelize(mesh: Any, *, resolution: Union[int, str] = 256, fill: str = 'nonzero', topology: str = 'mesh',
             threads: int = 0, progress: Progress = False) -> Volume:
    """The voxels whose centres lie in a mesh.

    Parameters
    ----------
    mesh : (vertices, faces), object with .vertices and .faces, or path
    resolution : int or "auto"
        Voxels along the longest side; "auto": the fewest of 128, 256 ... 2048 with the topology of the mesh.
    fill : "nonzero", "evenodd", "winding" or "auto"
        Overlapping and nested parts are united, or alternate between inside and outside. What holes leave open, the
        generalized winding number decides; "winding": faces are turned and duplicates dropped first, even if the mesh
        is closed; "auto": one of these.
    topology : "mesh" or "voxels"
        "mesh": a few voxels are put in and taken out where the others would break or join what the mesh does not.

    Returns
    -------
    Volume
        Of 0 and 1 (uint8), placed where the mesh is.

    Examples
    --------
    >>> import quench
    >>> quench.voxelize(quench.sample('torus'), resolution=20).array.max()
    1
    """
    return volume_of(shape_of(mesh, Cut(resolution=resolution, fill=fill, topology=topology, surface='voxels'), threads,
                           progress).image())
