# SPDX-License-Identifier: Apache-2.0
"""From the axis back to the solid."""
from __future__ import annotations

from functools import cached_property
from typing import Any, Dict, Optional, Tuple

import numpy as np

from . import _core, _export, _show
from ._common import Array, Path, Progress, Topology, calling, ending, error, reals, topology_of, written
from ._pickles import Result


class Solid(Result):
    """The solid of a medial axis or a skeleton: its balls or, as `envelope`, also all between them. Made by
    :meth:`MedialAxis.solid` and :meth:`Skeleton.solid`.

    Attributes
    ----------
    envelope : bool
        Whether cones along edges and slabs over triangles belong to it.
    voxels : bool array
        Voxels (pixels) whose centres are in it, on the grid of the shape; of an axis from a file on that of its file.
    topology : Topology
        Of all of its voxels, also those beyond that grid.
    """

    def __init__(self, core: '_core.Solid', threads: int = 0, progress: Progress = False):
        self._core = core
        self._threads = threads
        self._progress = progress

    def _calling(self, threads: Optional[int], progress: Optional[Progress]) -> Any:
        return calling(self._threads if threads is None else threads, self._progress if progress is None else progress)

    @property
    def envelope(self) -> bool:
        return bool(self._core.envelope)

    def _repr_html_(self) -> str:
        facts = [('of', 'balls, cones and slabs' if self.envelope else 'balls'),
                 ('topology', _show.topology_text(self.topology, self._core.dimension)),
                 ('grid', ' x '.join(map(str, self._core.dims)))]
        errors = self.errors()
        if errors:
            volume = errors['volume']
            facts += [(name, _show.number(volume[name])) for name in ('shape', 'solid', 'missing', 'added')]
            if 'surface_from_solid' in errors:
                facts.append(('surface to solid', 'at most ' +
                              _show.number(errors['surface_from_solid']['either_side']['largest'])))
        return _show.card('Solid', facts)

    @cached_property
    def voxels(self) -> Array:
        voxels = np.zeros(tuple(self._core.dims), bool)
        self._core.fill(voxels.view(np.uint8))
        voxels.flags.writeable = False
        return voxels

    @property
    def topology(self) -> Topology:
        return topology_of(self._core)

    def errors(self) -> Optional[Dict[str, Any]]:
        """How far it is from the shape; None of an axis from a file, which has none.

        Returns
        -------
        dict
            `surface`: what distances refer to, "mesh", "grey", "smooth" or "voxels" (their faces). `surface_from_solid`:
            of places of the surface from the solid, ``['outside']`` with the `mean`, the value of 99 % (`p99`) and the
            `largest` distance, 0 inside: what is missing; ``['either_side']`` of the boundary, on both sides.
            `solid_from_surface`: the other way, what sticks out. `volume`: of `shape` and `solid`, and what is `missing`
            and `added`, in voxels of which each counts its size. Of images only `volume`, which is their area.
        """
        return self._core.errors()

    def distance(self, points: Any, *, threads: Optional[int] = None, progress: Optional[Progress] = None) -> Array:
        """Signed distance of points from the solid: exact outside of it; inside less than 0, and no point lies less deep.

        Parameters
        ----------
        points : (n, 3) floats
            In the coordinates of the axis; of images (n, 2).
        """
        at = reals(points, 'points')
        if at.ndim != 2 or at.shape[1] != self._core.dimension:
            raise error(2, f'points have the shape {at.shape}; give a row of {self._core.dimension} numbers for each', 'points')
        if at.shape[1] == 2:
            at = np.pad(at, ((0, 0), (0, 1)))
        with self._calling(threads, progress) as call:
            return np.asarray(self._core.distance(np.ascontiguousarray(at), *call))

    def mesh(self, *, threads: Optional[int] = None, progress: Optional[Progress] = None) -> Tuple[Array, Array]:
        """Its boundary as points and triangles, a closed manifold with the topology of the voxels, faces outward.

        Returns
        -------
        (n, 3) float64 array, (m, 3) int32 array
        """
        with self._calling(threads, progress) as call:
            points, triangles = self._core.mesh(*call)
        return np.asarray(points), np.asarray(triangles)

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` of :meth:`mesh`."""
        return _export.to_trimesh(*self.mesh())

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` of :meth:`mesh`."""
        return _export.to_pyvista(*self.mesh(), np.zeros((0, 2), np.int32), {})

    def save(self, path: Path, *, threads: Optional[int] = None, progress: Optional[Progress] = None) -> None:
        """Writes voxels (.nrrd, .zarr) or the mesh (.ply, .obj, .vtp; with `distance` from the surface of the shape),
        over an existing file."""
        kind = ending(path)
        if kind not in ('.nrrd', '.zarr', '.ply', '.obj', '.vtp'):
            raise error(2, f'path={path!r}: solids are written as .nrrd, .zarr, .ply, .obj or .vtp', 'path')
        with self._calling(threads, progress) as call:
            self._core.save(written(path), kind in ('.nrrd', '.zarr'), *call)
