# SPDX-License-Identifier: Apache-2.0
"""Medial axes of images and meshes, and what files hold."""
from __future__ import annotations

from typing import Any, Optional, Sequence, Tuple, Union

from . import _core
from ._axis import MedialAxis
from ._common import Length, Path, Progress, Spacing, calling, error, measures_of, pruning_of
from ._inputs import Cut, Mesh, Threshold, Volume, read_file, shape_of


def medial_axis(image_or_mesh: Any, *, spacing: Spacing = None, threshold: Threshold = None,
                label: Optional[int] = None, dimension: Optional[int] = None, channel: Optional[str] = None,
                resolution: Union[int, str] = 256, detail: Length = 'auto', lambda_: Optional[Length] = None,
                invert: bool = False, largest_component: bool = False, min_component: int = 0, fill_cavities: bool = False,
                interpolate: bool = False, median: int = 0, blur: float = 0, close: int = 0, connectivity: int = 6,
                subdivide: int = 1, fill: str = 'nonzero', topology: str = 'mesh', surface: str = 'auto',
                lambda_rule: str = 'coface', prune_by: Optional[Tuple[str, Length]] = None,
                measures: Union[str, Sequence[str]] = (), threads: int = 0, progress: Progress = False) -> MedialAxis:
    """The medial axis of a shape: its voxel core, pruned without changing its topology.

    Parameters
    ----------
    image_or_mesh : array, (vertices, faces), object with .vertices and .faces, Volume, or path
        An image is an array of two or three dimensions, of any order in memory: ``image[row, column]`` with rows from the
        top, or ``volume[x, y, z]``. A bool image, and one of at most two values, is the shape where it is not 0; others
        need `threshold` or `label`. A mesh has to be closed.
    spacing : float or a float per axis, optional
        Size of a voxel or pixel along the axes of the array: of an image, of rows and columns (y, x). Default: what the
        file says, else 1.
    threshold : float, (float, float), "auto", "thin" or "otsu", optional
        The shape is where the image is at least this; of a pair, at least the first and connected to where it is at least
        the second. "auto": cuts most of the edges; "thin": two, for thin things (docs/user/volumes.md); "otsu": Otsu's.
    label : int, optional
        The shape is where the image is exactly this.
    dimension : 2 or 3, optional
        Of an image with one axis of length 1: whether it is an image of two dimensions or a slice of voxels.
    channel : "luminance", "red", "green", "blue" or "alpha", optional
        Of an image with colours, (rows, columns, 3 or 4).
    resolution : int or "auto"
        Of meshes: voxels along the longest side of the box; "auto": the fewest of 128, 256 ... 2048 with the topology of
        the mesh.
    detail : length or "auto"
        What sticks out less than this is noise, and is dropped where topology allows; every corner of the
        voxel surface stays within max(2 detail, a voxel diagonal) of the balls that are kept. "auto": half the voxel diagonal,
        above which nothing comes from the steps of voxels; 0: nothing is dropped. Of images, of pixels.
    lambda_ : length or "auto", optional
        Prunes by another measure instead: parts that touch the surface within a ball of this radius are dropped where
        topology allows. "auto": the largest from 2 % of the longest side down whose balls still fill 98 % of the shape.
    invert, largest_component, min_component, fill_cavities
        What to do with the shape first: take what is not the shape, keep its largest part only, drop parts of fewer
        voxels, fill closed cavities (of images, holes).
    interpolate, median, blur, close, connectivity
        Resample thick slices to cubes; take medians of (2 median + 1) ** 3 values; blur with a Gaussian of so many voxels;
        then, of the voxels, close gaps with a ball of radius `close`; connectivity 26 joins what touches in edges or
        corners only (docs/user/volumes.md).
    subdivide : int
        Splits every voxel into subdivide ** 3, a pixel into subdivide ** 2.
    fill : "nonzero", "evenodd", "winding" or "auto"
        Of meshes: overlapping and nested parts are united, or alternate between inside and outside
        (docs/user/defective_meshes.md).
    topology : "mesh" or "voxels"
        Of meshes: "mesh" puts in and takes out a few voxels where the voxel shape would break or join what the mesh does
        not; "voxels": those whose centres are inside, and no others.
    surface : "auto", "voxels", "mesh", "grey" or "smooth"
        What points and radii are fitted to: nothing but the voxels; the mesh; the values of the image at `threshold`; a
        smoothed surface of the voxels (for masks and labels). "auto": the mesh where its solid can be told, the values
        where `threshold` cuts more than two, else the voxels. Of images: the pixels.
    lambda_rule : "coface" or "ball"
        See docs/user/parameters.md.
    prune_by : (name, threshold), optional
        Prunes by a measure instead: what is below the threshold is dropped where topology allows. Names and what they are:
        "cap_height", "object_angle" (degrees), "circumradius", "mgf", "chord_residual", "core_erosion_thickness",
        "relative_erosion_thickness" (0 to 1), "scale_axis" (1 or more), and "detail" and "lambda"
        (docs/algorithms/pruning.md). Thresholds are lengths where nothing else is said: ``('mgf', '10vox')``.
    measures : name or names
        Also these measures, of what is kept; "all": all of them.
    threads : int
        0: all processors. The result is the same for any number.
    progress : bool or callable
        True: a bar of tqdm where that is installed; a function is called as ``progress(stage, fraction)``.

    Returns
    -------
    MedialAxis

    Notes
    -----
    Places: of a volume as array, index times spacing in the order of its axes, voxel centres at integers, as in scipy and
    scikit-image. Of files and meshes, world coordinates x, y, z.

    Of an image of two dimensions, places are (x, y), as in files and for `matplotlib`: x is column times spacing, y is row
    times spacing and grows downwards. What is in the order of the array, as scikit-image has it, says so: `row_col`, and
    :meth:`MedialAxis.to_image`. Foreground pixels are neighbours by sides, background pixels by corners too.

    A *length* is a number or a text: ``0.02`` and ``"2%"`` are fractions of the longest side of the box of the shape,
    ``"2.5vox"`` multiples of the smallest spacing, ``"3.5abs"`` the units of the coordinates, ``"inf"`` and
    ``math.inf`` infinite.

    Ctrl-C stops the computation. Nothing of the input is kept.

    Examples
    --------
    >>> import numpy as np, quench
    >>> plate = np.zeros((40, 30, 9), bool)
    >>> plate[2:-2, 2:-2, 2:-2] = True
    >>> axis = quench.medial_axis(plate)
    >>> axis.topology.betti
    (1, 0, 0)
    >>> float(axis.radius.max())  # of 2.5 to the faces, measured to the corners of voxels
    2.598...
    >>> axis.vertices[axis.radius.argmax()][2]  # in the middle of 2 .. 6
    4.0
    >>> axis.detail, axis.coverage  # half a voxel diagonal, and a whole one: the corners of the plate
    (0.866..., 1.732...)

    An image:

    >>> image = np.zeros((9, 40), bool)
    >>> image[2:-2, 2:-2] = True
    >>> axis = quench.medial_axis(image)
    >>> axis.vertices[axis.radius.argmax()][1]  # (x, y): in the middle of the rows 2 .. 6
    4.0
    >>> mask, distance = axis.to_image(return_distance=True)
    >>> mask.shape, mask[4, 20], float(distance[4, 20])
    ((9, 40), True, 2.549...)
    """
    pruning = pruning_of(detail, lambda_, prune_by)
    more = measures_of(measures)
    if lambda_rule not in ('coface', 'ball'):
        raise error(2, f"lambda_rule={lambda_rule!r} is not one of 'coface', 'ball'", 'lambda_rule')
    cut = Cut(threshold, label, invert, largest_component, min_component, fill_cavities, subdivide, spacing, resolution, fill,
              topology, surface, dimension, channel, interpolate, median, blur, close, connectivity)
    shape = shape_of(image_or_mesh, cut, threads, progress)
    with calling(threads, progress) as call:
        return MedialAxis(_core.compute_axis(shape, *pruning, lambda_rule, more, *call), threads, progress)


def read(path: Path, *, spacing: Spacing = None, radii: Optional[Path] = None, dimension: Optional[int] = None,
         channel: Optional[str] = None, threads: int = 0, progress: Progress = False) -> Union[Volume, Mesh, MedialAxis]:
    """Reads a file: a volume, a mesh or a medial axis.

    Parameters
    ----------
    path : str or path
        Volumes: .nrrd .nii.gz .mha .mrc .tif .npy .vol, a folder of slices; images: .png and others; meshes: .ply .obj
        .off .stl; medial axes of Quench or another program: .vtp .ply .ma (a surface with a radius per vertex is taken for
        one).
    spacing : float or a float per axis, optional
        Size of voxels (x, y, z) or pixels (y, x), instead of what the file says.
    radii : str or path, optional
        A .r file with the radii of the vertices of a medial axis, matched by position.
    dimension, channel
        Of files with one slice, or with colours, as in :func:`medial_axis`.
    threads, progress
        As in :func:`medial_axis`.

    Returns
    -------
    Volume, Mesh or MedialAxis

    Examples
    --------
    >>> import os, tempfile, quench
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = os.path.join(folder, 'bar.ply')
    ...     quench.medial_axis(quench.sample('torus'), resolution=32).save(file)
    ...     quench.read(file).topology.betti
    (1, 1, 0)
    """
    with calling(threads, progress) as call:
        found = read_file(path, spacing, radii, call, dimension, channel)
    return MedialAxis(found, threads, progress) if isinstance(found, _core.Axis) else found
