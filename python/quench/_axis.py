# SPDX-License-Identifier: Apache-2.0
"""The medial axis and what follows from it."""
from __future__ import annotations

from functools import cached_property
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from . import _core, _export, _plane, _show
from ._common import (Array, Certificate, Length, Path, Progress, calling, deprecated, ending, error, length, length_or_auto,
                      threshold_of, whole, written)
from ._complex import Complex
from ._measures import Cells, Measures
from ._simplification import Simplification
from ._skeleton import Skeleton, theta2_of
from ._show import View
from ._solid import Solid


_Held = _core.Axis  # a name that the attribute of the class does not hide
_ARGUMENTS = {'detail': 'detail', 'lambda': 'lambda_'}  # of measures; others: prune_by


class MedialAxis(Complex):
    """A medial axis: vertices with radii, edges and polygons; made by :func:`medial_axis` or :func:`read`.

    Arrays are views of the result: not copied, read-only, and alive as long as anybody holds one. What the result holds is
    an attribute; what has to be computed, or takes arguments, is a method. Methods work on the threads, and show the
    progress, that were asked for when the medial axis was made, unless they are told otherwise.

    Attributes
    ----------
    dimension : int
        3, or 2 of an image; then there are edges only, and no polygons and faces.
    vertices : (V, 3) float64
        x, y, z; of an image (V, 2): x to the right, y down.
    row_col : (V, 2) float64
        Of an image: row and column of each vertex, ``image[tuple(np.rint(axis.row_col).astype(int).T)]`` its pixel.
    radius : (V,) float64
        Distance to the nearest corner of a boundary voxel or pixel.
    edges : (E, 2) int32
        Every edge, of polygons and of curves; ``edges[edge_degree == 0]`` are the curves.
    edge_degree : (E,) int64
        Number of polygons at each edge: 2 inside a sheet, 1 at its rim, more where sheets meet.
    polygons : (offsets, corners)
        Polygon p has the corners ``corners[offsets[p]:offsets[p + 1]]``. V - E + polygons is the Euler characteristic.
    faces : (F, 3) int32
        The polygons as triangles.
    face_polygon : (F,) int32
        The polygon of each triangle.
    face_detail_level : (F,) float64
        The largest detail up to which the polygon of each triangle stays; infinite where topology needs it. Also
        ``edge_detail_level``, ``vertex_detail_level``. Of a medial axis that is pruned by detail.
    face_lambda_level : (F,) float64
        The same for λ, with ``edge_lambda_level``, ``vertex_lambda_level``. Of a medial axis that is pruned by λ.
    face_lambda : (F,) float64
        λ of the polygon of each triangle: half the distance of its two nearest boundary points. Also ``edge_lambda``,
        ``vertex_lambda``.
    measures : mapping of names to (values, levels)
        "lambda", "detail" where it is pruned by it, and those that follow from λ: "object_angle" and "cap_height" (what
        the shape loses where the axis ends here). ``measures['lambda'].values.polygons`` has a value per polygon,
        ``.vertices`` and ``.edges`` per vertex and edge; there are levels of the measure it is pruned by. Of an image also
        "mgf": of an edge, the shorter arc of the outline between its two nearest boundary points; infinite where these
        are on different outlines. Others of docs/algorithms/pruning.md where they were asked for. Empty for an axis from a
        file.
    detail : float or None
        What it is pruned with, in the units of the coordinates; None where it is not pruned by detail.
    lambda_ : float or None
        The same for λ.
    pruned_by : (name, threshold) or None
        The measure it is pruned by, and its threshold in world units, degrees or a ratio.
    coverage : float or None
        The largest distance of a boundary vertex of the shape to the balls; known where it is pruned by detail.
    surface : str
        What vertices and radii refer to: "mesh", "grey" or "smooth" where the axis was fitted to a surface, else
        "voxels".
    reconstructed : float
        Share of the shape that its balls fill (of a sample of voxels).
    longest_side : float
        What plain numbers as lengths refer to.
    topology : Topology
    """

    _core: _Held

    def __init__(self, core: _Held, threads: int = 0, progress: Progress = False):
        self._core = core
        self._threads = threads
        self._progress = progress

    @cached_property
    def _fans(self) -> Tuple[Array, Array]:
        triangles, polygon = self._core.fans()
        return np.asarray(triangles), np.asarray(polygon)

    @property
    def faces(self) -> Array:
        return self._fans[0]

    @property
    def face_polygon(self) -> Array:
        return self._fans[1]

    @property
    def measures(self) -> Measures:
        return Measures(self._core)

    def _cells(self, name: str, what: str) -> Cells:
        """The "values" or "levels" of a measure, or an Error that says where there are some."""
        if not self.measures:
            raise error(2, f'a medial axis from a file has no {what} of {name} here; they are arrays of the file')
        cells: Optional[Cells] = getattr(self.measures[name], what) if name in self.measures else None
        if cells is None:
            argument = _ARGUMENTS.get(name, 'prune_by')
            raise error(2, f'the medial axis is not pruned by {name}, so that there are no {what} of it; '
                           f'medial_axis(..., {argument}=...) makes one with them', argument)
        return cells

    @cached_property
    def face_detail_level(self) -> Array:
        return self._cells('detail', 'levels').polygons[self.face_polygon]

    @property
    def edge_detail_level(self) -> Array:
        return self._cells('detail', 'levels').edges

    @property
    def vertex_detail_level(self) -> Array:
        return self._cells('detail', 'levels').vertices

    @cached_property
    def face_lambda_level(self) -> Array:
        return self._cells('lambda', 'levels').polygons[self.face_polygon]

    @property
    def edge_lambda_level(self) -> Array:
        return self._cells('lambda', 'levels').edges

    @property
    def vertex_lambda_level(self) -> Array:
        return self._cells('lambda', 'levels').vertices

    @cached_property
    def face_lambda(self) -> Array:
        return self._cells('lambda', 'values').polygons[self.face_polygon]

    @property
    def edge_lambda(self) -> Array:
        return self._cells('lambda', 'values').edges

    @property
    def vertex_lambda(self) -> Array:
        return self._cells('lambda', 'values').vertices

    @property
    def lambda_level(self) -> Array:
        """Deprecated: `face_lambda_level`."""
        deprecated('lambda_level', 'face_lambda_level')
        return self.face_lambda_level

    @property
    def detail(self) -> Optional[float]:
        return self._core.threshold if self._core.pruned_by == 'detail' else None

    @property
    def lambda_(self) -> Optional[float]:
        return self._core.threshold if self._core.pruned_by == 'lambda' else None

    @property
    def pruned_by(self) -> Optional[Tuple[str, float]]:
        measure, threshold = self._core.pruned_by, self._core.threshold
        return None if measure is None or threshold is None else (measure, threshold)

    @property
    def coverage(self) -> Optional[float]:
        return self._core.coverage

    @property
    def surface(self) -> str:
        return self._core.surface

    @property
    def reconstructed(self) -> float:
        return self._core.reconstructed

    @property
    def longest_side(self) -> float:
        return self._core.longest_side

    def pruned(self, threshold: Optional[Length] = None, *, detail: Optional[Length] = None,
               lambda_: Optional[Length] = None, threads: Optional[int] = None,
               progress: Optional[Progress] = None) -> 'MedialAxis':
        """The same medial axis for a larger threshold of the measure it is pruned by, without computing it anew.

        Parameters
        ----------
        threshold : length
            Of that measure; of those without lengths a number. With the keyword `detail` or `lambda_` one of the other measure is refused.

        Examples
        --------
        >>> import numpy as np, quench
        >>> full = quench.medial_axis(np.ones((30, 20, 8), bool), detail=0)
        >>> len(full.pruned(detail='2vox').vertices) < len(full.vertices)
        True
        """
        measure = self._core.pruned_by or 'detail'
        own = _ARGUMENTS.get(measure, measure)
        for argument, value in (('detail', detail), ('lambda_', lambda_)):
            if value is not None and argument != own:
                raise error(2, f'{argument}={value!r} is of a measure by which this medial axis is not pruned; give {own}, '
                               f'or compute it with medial_axis(..., {argument}=...)', argument)
        given = [value for value in (threshold, detail, lambda_) if value is not None]
        if len(given) != 1:
            raise error(2, f'pruned() takes one threshold, of {own}; {len(given)} are given', own)
        text = length(given[0], own) if measure in _ARGUMENTS else threshold_of(measure, given[0])
        with self._calling(threads, progress) as call:
            return MedialAxis(self._core.pruned(text, *call), self._threads, self._progress)

    def erosion_thickness(self, omega: Optional[Length] = None, *, propagation: str = 'auto', threads: Optional[int] = None,
                          progress: Optional[Progress] = None) -> Array:
        """How much longer each vertex burns than its ball says: large in the middle of plates, 0 at rims.

        Parameters
        ----------
        omega : length, optional
            Distance of the points on edges between which fire is followed. Default: that of the file where the axis was
            read from one that is burned (which is then not burned again), else 0.65 of the mean edge, for an error of
            about 0.1 %. Of images there are no such points, and the result is exact.
        propagation : "segments", "windows" or "auto"
            How fire crosses sheets: "segments", from these points; "windows", exactly, in two to five times the time.
            "auto": that of the file, else segments.

        Returns
        -------
        (V,) float64 array
            Infinite on closed pockets (sheets around a cavity; of an image: loops, and what is between them), where no
            fire comes.

        Examples
        --------
        >>> import numpy as np, quench
        >>> plate = np.ones((60, 40, 5), bool)
        >>> et = quench.medial_axis(plate).erosion_thickness()
        >>> bool(16.5 < et.max() < 18)  # the fire has 17.5 to go: half the width less the 2.5 to the rim
        True
        """
        return np.asarray(self._burn(omega, propagation, threads, progress)[1])

    def burn_time(self, omega: Optional[Length] = None, *, propagation: str = 'auto', threads: Optional[int] = None,
                  progress: Optional[Progress] = None) -> Array:
        """When the fire that starts at the rims comes to each vertex: erosion thickness + radius, (V,) float64."""
        return np.asarray(self._burn(omega, propagation, threads, progress)[0])

    def _burn(self, omega: Optional[Length], propagation: str, threads: Optional[int],
              progress: Optional[Progress]) -> Tuple[Any, Any, float]:
        with self._calling(threads, progress) as call:
            return self._core.burn(self._omega(omega), self._propagation(propagation), *call)

    def _propagation(self, propagation: str) -> str:
        if propagation not in ('auto', 'segments', 'windows'):
            raise error(2, f"propagation={propagation!r} is not one of 'auto', 'segments', 'windows'", 'propagation')
        if propagation != 'auto' and self.dimension == 2:
            raise error(2, f'propagation={propagation!r} is of sheets; the medial axis of an image is burned exactly without it',
                        'propagation')
        return propagation

    def _omega(self, omega: Optional[Length]) -> float:
        if omega is None or (isinstance(omega, str) and omega == 'auto'):
            return 0.0
        if self.dimension == 2:
            raise error(2, f'omega={omega!r} is of sheets; the medial axis of an image is burned exactly without it', 'omega')
        distance = self._core.resolve(length(omega, 'omega'), 'omega')
        if not 0 < distance < np.inf:
            raise error(2, f'omega={omega!r} is not a distance between nodes; give a length above 0, or None', 'omega')
        return distance

    def skeleton(self, theta2: Length = 'auto', theta1: Length = 'auto', *, tips: str = 'full',
                 omega: Optional[Length] = None, propagation: str = 'auto', threads: Optional[int] = None,
                 progress: Optional[Progress] = None) -> Skeleton:
        """What of the medial axis matters: sheets of an erosion thickness of at least θ2, and curves of at least θ1.

        The first call burns the axis, unless it was read from a file that is burned; others with the same omega take
        what it found (:meth:`forget` drops it).

        Parameters
        ----------
        theta2 : length or "auto"
            Sheets below turn into curves, or go. ``"inf"``: curves only, for roots, vessels, neurons. "auto": 3 % of the
            longest side, but no less than three times the automatic detail (2.6 voxels). An image has no sheets, and one
            threshold, θ1: ``skeleton(theta1=...)``.
        theta1 : length, radii or "auto"
            Branches shorter than about this go; ``"0.5r"``: those that stick out of what they leave by less than half its
            radius. ``"inf"``: what topology needs is left. "auto": 0.5r, and what is thinner than four voxels.
        tips : "full" or "pruned"
            Pruning takes about θ1 off every branch, also of those that stay, and θ2 off every rim of a sheet; "full":
            these grow back to their tips and rims.
        omega : length, optional
        propagation : "segments", "windows" or "auto"
            As in :meth:`erosion_thickness`.

        Returns
        -------
        Skeleton
            With the topology of the shape.

        Examples
        --------
        >>> import numpy as np, quench
        >>> ring = np.ones((24, 24, 6), bool)
        >>> ring[7:-7, 7:-7] = False
        >>> curves = quench.medial_axis(ring).skeleton(theta2='inf', theta1='inf').curves
        >>> len(curves.vertices) == len(curves.edges)  # one closed curve
        True
        """
        thetas = theta2_of(theta2, self.dimension), length_or_auto(theta1, 'theta1')
        if tips not in ('full', 'pruned'):
            raise error(2, f"tips={tips!r} is not one of 'full', 'pruned'", 'tips')
        for text, name in zip(thetas, ('theta2', 'theta1')):
            if text != 'auto' and not text.endswith('r'):
                self._core.resolve(text, name)  # refuses what the axis does not know before anything is burned
        distance, how = self._omega(omega), self._propagation(propagation)
        with self._calling(threads, progress) as call:
            return Skeleton(self._core.skeleton(*thetas, tips == 'full', distance, how, *call), self)

    def forget(self) -> None:
        """Drops what burning left behind: about 1 KB per vertex."""
        self._core.forget()

    def reconstruct(self, shape: Optional[Sequence[int]] = None, *, threads: Optional[int] = None,
                    progress: Optional[Progress] = None) -> Array:
        """The union of the balls as a bool image: voxels (of images pixels) whose centres are in one.

        Parameters
        ----------
        shape : ints, optional
            Of the result; default: that of the image, or of the voxels a mesh was turned into.

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((20, 14, 9), bool)
        >>> image[2:-2, 2:-2, 2:-2] = True
        >>> bool((quench.medial_axis(image, lambda_=0).reconstruct() == image).all())
        True
        """
        mask = _export.mask(self._core.shape, shape, self.dimension)
        with self._calling(threads, progress) as call:
            self._core.mark_balls(mask.view(np.uint8), *call)
        return mask

    def solid(self, envelope: bool = False, *, resolution: Optional[int] = None, threads: Optional[int] = None,
              progress: Optional[Progress] = None) -> Solid:
        """The solid of the balls, with its voxels, mesh and errors (docs/user/reconstruction.md).

        Parameters
        ----------
        envelope : bool
            Also what lies linearly between the balls: cones along edges, slabs over triangles.
        resolution : int, optional
            Of an axis from a file: voxels along the longest side. Default: those its file says, else 256. Others have the
            voxels of the shape.

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((20, 14, 9), bool)
        >>> image[2:-2, 2:-2, 2:-2] = True
        >>> solid = quench.medial_axis(image).solid(envelope=True)
        >>> solid.topology.betti
        (1, 0, 0)
        >>> sorted(solid.errors())
        ['solid_from_surface', 'surface', 'surface_from_solid', 'volume']
        """
        number = 0 if resolution is None else whole(resolution, 'resolution', 1)
        with self._calling(threads, progress) as call:
            core = _core.solid_of_axis(self._core, bool(envelope), number, *call)
        return Solid(core, self._threads, self._progress)

    def simplified(self, vertices: int = 200, *, error: Optional[Length] = None, fits: int = 12,
                   threads: Optional[int] = None, progress: Optional[Progress] = None) -> Simplification:
        """The same axis with few vertices, of the same topology (docs/user/simplification.md).

        Parameters
        ----------
        vertices : int
            So many are left, or as few as the topology allows.
        error : length, optional
            Instead: as few as will do, so that no point of the boundary is farther outside of the result, or deeper in a
            ball, cone or slab of it.
        fits : int
            Rounds of fitting the vertices that are left.

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((40, 30, 20), bool)
        >>> image[2:-2, 2:-2, 2:-2] = True
        >>> few = quench.medial_axis(image).simplified(30)
        >>> len(few.axis.vertices), few.axis.topology.betti
        (30, (1, 0, 0))
        """
        text = '' if error is None else length(error, 'error')
        number = whole(vertices, 'vertices', 1)
        rounds = whole(fits, 'fits', 0)
        with self._calling(threads, progress) as call:
            core = self._core.simplified(number, text, rounds, *call)
        return Simplification(core, MedialAxis, self._threads, self._progress)

    def smoothed(self, most: Length = '0.5vox', *, iterations: int = 10, threads: Optional[int] = None,
                 progress: Optional[Progress] = None) -> 'MedialAxis':
        """The same cells with sheets and curves that run smoothly, radii too; no vertex moves by more than `most`.

        Measures are those of the axis as it was, and left out. Axes without voxels need a length of another unit.
        """
        rounds = whole(iterations, 'iterations', 0)
        with self._calling(threads, progress) as call:
            core = self._core.smoothed(self._core.resolve(length(most, 'most'), 'most'), rounds, *call)
        return MedialAxis(core, self._threads, self._progress)

    def to_image(self, shape: Optional[Sequence[int]] = None, *, return_distance: bool = False) -> Any:
        """Of an image: the pixels the axis runs through, as a bool image.

        Parameters
        ----------
        shape : (rows, columns), optional
            Of the result; default: that of the image.
        return_distance : bool
            Also a float64 image: the largest radius of the axis inside each of these pixels, 0 elsewhere. In units of
            `spacing`, to the corners of the pixels of the outline; half a pixel less than the distance to the centres of
            background pixels that ``skimage.morphology.medial_axis(return_distance=True)`` gives.

        Returns
        -------
        (rows, columns) bool array, or it and the distances
            Connected (8) where the axis is.

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((9, 40), bool)
        >>> image[2:-2, 2:-2] = True
        >>> quench.medial_axis(image, detail=0).to_image()[2:-2, 2:9].astype(int)
        array([[1, 0, 0, 0, 0, 0, 0],
               [0, 1, 0, 0, 0, 0, 0],
               [0, 0, 1, 1, 1, 1, 1],
               [0, 1, 0, 0, 0, 0, 0],
               [1, 0, 0, 0, 0, 0, 0]])
        """
        return self._image(self._core.shape, shape, return_distance)

    def to_geojson(self, path: Optional[Path] = None) -> Dict[str, Any]:
        """Of an image: all branches of the axis, as :meth:`Skeleton.to_geojson` gives those of a skeleton."""
        self._of_image('to_geojson()', 'save()')
        return self.skeleton(theta1=0).to_geojson(path)

    def verify(self, samples: int = 20000, *, threads: Optional[int] = None,
               progress: Optional[Progress] = None) -> Certificate:
        """Checks the result against its shape by code of its own; what it cannot tell is in the last line of the certificate.

        Examples
        --------
        >>> import numpy as np, quench
        >>> bool(quench.medial_axis(np.ones((9, 8, 7), bool)).verify())
        True
        """
        with self._calling(threads, progress) as call:
            return Certificate(self._core.verify(whole(samples, 'samples', 1), *call))

    def save(self, path: Path, *, quality: str = 'radius', threads: Optional[int] = None,
             progress: Optional[Progress] = None) -> None:
        """Writes a file, over an existing one; an interrupted call leaves none half written.

        Parameters
        ----------
        path : str or path
            .vtp (everything; ParaView), .ply (MeshLab), .obj, .ma, .r, .csv (a row per vertex), .png (a picture),
            .html (interactive page). With burn times where the axis was burned; .vtp also with all that skeletons need,
            so that it is not burned again when it is read. Of images also .geojson.
        quality : str
            Of PLY: the array that MeshLab shows as quality.
        """
        with self._calling(threads, progress) as call:
            if ending(path) == '.geojson':
                self.to_geojson(path)
            elif ending(path) in ('.html', '.png'):
                _core.page_of_axis(self._core, None, written(path), None, *call)
            else:
                self._core.save(written(path), quality, *call)

    def view(self, *, height: int = 600, threads: Optional[int] = None, progress: Optional[Progress] = None) -> View:
        """The interactive page, as :meth:`save` writes it to .html: a notebook shows it in a frame.

        Parameters
        ----------
        height : int
            Of the frame, in pixels.

        Returns
        -------
        View
            ``.save('axis.html')`` writes it for a browser.
        """
        with self._calling(threads, progress) as call:
            return _show.view_of(lambda file: _core.page_of_axis(self._core, None, file, None, *call), 'Medial axis', height)

    def _repr_html_(self) -> str:
        units, facts = self.units, self._facts()
        for name, value in (('detail', self.detail), ('λ', self.lambda_), ('coverage', self.coverage)):
            if value is not None:
                facts.append((name, _show.number(value, units)))
        facts.append(('fitted to', {'voxels': 'nothing: that of the voxels' if self.dimension == 3 else
                                    'nothing: that of the pixels'}.get(self.surface, self.surface)))
        return _show.card('Medial axis', facts, self._picture())

    def _draw(self, file: bytes) -> None:
        with calling(self._threads, False) as call:
            _core.picture_of_axis(self._core, file, _show.SIZE, *call)

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draws the faces with matplotlib, coloured by erosion thickness; returns the axes.

        Of an image: the edges, coloured by radius; with unit spacing they lie on what ``ax.imshow(image)`` has drawn.
        """
        return (_plane if self.dimension == 2 else _export).plot(self, ax, **options)

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` of the faces."""
        self._no_image('to_trimesh()', 'edges')
        return _export.to_trimesh(self.vertices, self.faces)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` of the faces and curves with ``radius``."""
        return _export.to_pyvista(self.vertices, self.faces, self.edges[self.edge_degree == 0], {'radius': self.radius})
