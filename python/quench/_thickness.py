# SPDX-License-Identifier: Apache-2.0
"""Local thickness of images and of surfaces."""
from __future__ import annotations

from typing import Any, NamedTuple, Optional, Union

import numpy as np

from . import _core, _export
from ._common import Array, Length, Progress, Spacing, calling, error, length_or_auto
from ._inputs import Cut, Threshold, shape_of


def local_thickness(image_or_mesh: Any, *, spacing: Spacing = None, threshold: Threshold = None,
                    label: Optional[int] = None, dimension: Optional[int] = None, channel: Optional[str] = None,
                    resolution: Union[int, str] = 256, invert: bool = False, fill: str = 'nonzero', topology: str = 'mesh',
                    mask: Any = None, balls: str = 'all', correction: Length = 'auto', threads: int = 0,
                    progress: Progress = False) -> Array:
    """Local thickness: at every voxel of a shape the diameter of the largest ball in the shape that contains its centre.

    The balls are those of the whole voxel core, which is exact (docs/user/thickness.md has the definition, beside those of
    BoneJ and PoreSpy).

    Parameters
    ----------
    image_or_mesh, spacing, threshold, label, dimension, channel, resolution, fill, topology
        As of :func:`quench.medial_axis`: what the shape is.
    invert : bool
        Measure what is not the shape, in the box of the image: pores.
    mask : array of the same shape, optional
        Voxels where it is 0 are 0; balls are those of the whole shape.
    balls : "all" or "vertices"
        All balls centred on the core, or only those of its vertices, which is faster.
    correction : length or "auto"
        Added to every radius. "auto": half a voxel, because the corners of voxels, which balls touch, lie that far inside
        the surface they stand for; of images of two dimensions 0. For boxes along the axes take 0.
    threads, progress
        As of :func:`quench.medial_axis`.

    Returns
    -------
    (X, Y, Z) or (rows, columns) float32 array
        In the unit of `spacing`; 0 outside the shape.

    Examples
    --------
    >>> import numpy as np, quench
    >>> plate = np.zeros((40, 40, 12), bool)
    >>> plate[2:-2, 2:-2, 2:-2] = True
    >>> thickness = quench.local_thickness(plate, correction=0)
    >>> thickness.shape, float(thickness[20, 20, 6])  # balls touch the corners of squares of the two sides
    ((40, 40, 12), 8.124...)
    >>> float(quench.local_thickness(plate, spacing=0.5)[20, 20, 6])
    4.562...
    """
    if balls not in ('all', 'vertices'):
        raise error(2, f"balls={balls!r} is not one of 'all', 'vertices'", 'balls')
    added = length_or_auto(correction, 'correction')
    cut = Cut(threshold=threshold, label=label, invert=invert, spacing=spacing, resolution=resolution, fill=fill,
              topology=topology, dimension=dimension, channel=channel, surface='voxels')
    shape = shape_of(image_or_mesh, cut, threads, progress)
    kept = None
    if mask is not None:
        kept = shape_of(mask, Cut(label=0, invert=True, surface='voxels', dimension=dimension), threads, False)
    with calling(threads, progress) as call:
        values, sides = _core.local_thickness(shape, kept, balls == 'all', added, *call)
    values = np.asarray(values)
    return values.reshape(sides) if len(sides) == 2 else values.reshape(sides, order='F')


class SurfaceThickness(NamedTuple):
    """A surface with the thickness of what it encloses.

    Attributes
    ----------
    vertices : (V, 3) array
    faces : (F, 3) array
    thickness : (V,) array
        Diameter of the largest ball inside that touches the vertex.
    across : (V, 3) array
        The point of the surface at the other end of that diameter.
    """

    vertices: Array
    faces: Array
    thickness: Array
    across: Array

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` with the vertex attribute ``thickness``."""
        mesh = _export.to_trimesh(self.vertices, self.faces)
        mesh.vertex_attributes['thickness'] = self.thickness
        return mesh

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` with ``thickness``."""
        return _export.to_pyvista(self.vertices, self.faces, np.zeros((0, 2), np.int32), {'thickness': self.thickness})


def surface_thickness(mesh_or_image: Any, *, resolution: Union[int, str] = 256, fill: str = 'nonzero',
                      topology: str = 'mesh', spacing: Spacing = None, threshold: Threshold = None,
                      label: Optional[int] = None, surface: str = 'auto', tolerance: Length = 'auto', threads: int = 0,
                      progress: Progress = False) -> SurfaceThickness:
    """The thickness at the vertices of a mesh, or at those of the surface of an image: wall thickness.

    Parameters
    ----------
    mesh_or_image, resolution, fill, topology, spacing, threshold, label, surface
        As of :func:`quench.medial_axis`.
    tolerance : length or "auto"
        How far a ball may be from a vertex that it touches. "auto": half a voxel diagonal. Where none is so near, as at
        sharp edges, the nearest ball counts.
    threads, progress
        As of :func:`quench.medial_axis`.

    Returns
    -------
    SurfaceThickness
        Of a mesh, with its vertices and faces.

    Examples
    --------
    >>> import numpy as np, quench
    >>> ball = quench.sample('ellipsoid', fineness=0.5)
    >>> walls = quench.surface_thickness(ball, resolution=64)
    >>> walls.thickness.shape == (len(ball.vertices),), walls.across.shape == ball.vertices.shape
    (True, True)
    """
    reach = length_or_auto(tolerance, 'tolerance')
    cut = Cut(threshold=threshold, label=label, spacing=spacing, resolution=resolution, fill=fill, topology=topology,
              surface=surface, keep_mesh=True)
    shape = shape_of(mesh_or_image, cut, threads, progress)
    with calling(threads, progress) as call:
        found = _core.surface_thickness(shape, reach, *call)
    return SurfaceThickness(*(np.asarray(found[name]) for name in SurfaceThickness._fields))
