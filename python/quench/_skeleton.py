# SPDX-License-Identifier: Apache-2.0
"""Skeletons, their curves as a graph, and label images."""
from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Dict, Iterable, Optional, Sequence, Union

import numpy as np

from . import _core, _export, _plane, _show
from ._common import (Array, Certificate, Length, Path, Progress, Spacing, calling, deprecated, ending, error, is_path,
                      length, length_or_auto, pruning_of, spacing_of, whole, written)
from ._complex import Complex
from ._graph import Graph, Table
from ._inputs import Volume, image_array, label_of, read_file
from ._parts import Parts
from ._show import View
from ._solid import Solid

if TYPE_CHECKING:
    from ._axis import MedialAxis

_Held = _core.Skeleton  # a name that the attribute of the class does not hide


def theta2_of(theta2: Length, dimension: int) -> str:
    """The text of theta2. Of an image all is curves: "auto" and "inf" say so, and there is no other."""
    text = length_or_auto(theta2, 'theta2')
    if dimension != 2:
        return text
    if text not in ('auto', 'inf'):
        raise error(2, f'theta2={theta2!r} is of sheets, and an image has none; its one threshold is theta1', 'theta2')
    return 'inf'


@dataclass
class Sheets:
    """The sheets of a skeleton.

    Attributes
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int32
        Triangles.
    radius : (V,) float64
    erosion_thickness : (F,) float64
        What θ2 is compared with.
    """

    vertices: Array
    faces: Array
    radius: Array
    erosion_thickness: Array


@dataclass
class Curves:
    """The curves of a skeleton.

    Attributes
    ----------
    vertices : (V, 3) float64, of an image (V, 2)
        Those without an edge are components that are one point.
    edges : (E, 2) int32
    radius : (V,) float64
    erosion_thickness : (E,) float64
        ET_MC: what θ1 is compared with; infinite on loops.
    branch : (E,) int32
        The branch of each edge: the row of it in :meth:`Skeleton.branches`.
    """

    vertices: Array
    edges: Array
    radius: Array
    erosion_thickness: Array
    branch: Array


class Skeleton(Complex):
    """A skeleton of sheets and curves with the topology of its shape; made by :meth:`MedialAxis.skeleton`.

    Attributes
    ----------
    vertices, radius : arrays
        Of the whole skeleton, as `dimension`, `row_col`, `edges`, `edge_degree` and `polygons`, see :class:`MedialAxis`.
    sheets : Sheets
    curves : Curves
    theta2, theta1 : float
        In the units of the coordinates; of an image θ2 is infinite: all is curves.
    theta1_radii : float
        In radii of what branches leave; 0 where θ1 was given as a length.
    topology : Topology
    axis : MedialAxis or None
        What it is a skeleton of; :func:`skeletonize` does not keep it.
    """

    _kept = (*Complex._kept, 'axis')

    _core: _Held

    def __init__(self, core: _Held, axis: Optional['MedialAxis'] = None):
        self._core = core
        self.axis = axis
        if axis is not None:
            self._threads, self._progress = axis._threads, axis._progress

    @property
    def theta2(self) -> float:
        return self._core.theta2

    @property
    def theta1(self) -> float:
        return self._core.theta1

    @property
    def theta1_radii(self) -> float:
        return self._core.theta1_radii

    def reconstructed_share(self, *, threads: Optional[int] = None, progress: Optional[Progress] = None) -> float:
        """Share of the shape that the balls fill (of a sample of voxels)."""
        with self._calling(threads, progress) as call:
            return self._core.reconstructed(*call)

    @property
    def reconstructed(self) -> float:
        """Deprecated: :meth:`reconstructed_share`."""
        deprecated('Skeleton.reconstructed', 'reconstructed_share()')
        return self.reconstructed_share()

    @cached_property
    def sheets(self) -> Sheets:
        offsets, corners = self.polygons
        sizes = np.diff(offsets)
        # The triangles of the fan of each polygon: its first corner, and every side that does not touch it.
        polygon = np.repeat(np.arange(len(sizes)), sizes - 2)
        step = np.arange(len(polygon)) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
        start = offsets[:-1][polygon] if len(polygon) else np.zeros(0, np.int64)
        triangles = np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)
        used, faces = np.unique(triangles, return_inverse=True)
        return Sheets(self.vertices[used], faces.reshape(-1, 3).astype(np.int32), self.radius[used],
                      np.asarray(self._core.face_thickness)[polygon])

    @cached_property
    def curves(self) -> Curves:
        chosen = self.edge_degree == 0
        lonely = np.bincount(self.edges.ravel(), minlength=len(self.vertices)) == 0
        used = np.unique(np.concatenate([self.edges[chosen].ravel(), np.flatnonzero(lonely)])).astype(np.int64)
        edges = np.searchsorted(used, self.edges[chosen]).astype(np.int32)
        return Curves(self.vertices[used], edges, self.radius[used], np.asarray(self._core.edge_thickness)[chosen],
                      np.asarray(self._core.edge_branch)[chosen])

    def graph(self, *, smooth: int = 10, resample: Length = 0, threads: Optional[int] = None,
              progress: Optional[Progress] = None) -> Graph:
        """The curves as nodes and branches with lengths and radii.

        Radii are half a voxel larger than those of `curves`, which are distances to the corners of voxels, where the axis
        is that of the voxels (docs/user/files.md); of images they are the same.

        Parameters
        ----------
        smooth : int
            Passes of smoothing over the zigzag of voxels; branches stay inside the shape. `curves` have 10.
        resample : length
            Distance of points along branches; 0: as they come.
        """
        with self._calling(threads, progress) as call:
            return Graph(self._core.graph(min(whole(smooth, 'smooth'), 2**30), length(resample, 'resample'), *call))

    @cached_property
    def _graph(self) -> Graph:
        return self.graph()

    def branches(self) -> Table:
        """A table of branches, a row each: ``graph().branches``.

        Examples
        --------
        >>> import numpy as np, quench
        >>> tube = np.zeros((60, 9, 9), bool)
        >>> tube[3:-3, 3:-3, 3:-3] = True
        >>> table = quench.medial_axis(tube, spacing=0.5).skeleton('inf').branches()
        >>> len(table['length'])
        1
        >>> bool(24 < table['length'][0] < 27)  # 54 voxels of 0.5, less what is rounded off
        True
        """
        return self._graph.branches

    def parts(self, *, remesh: Optional[Length] = None, threads: Optional[int] = None,
              progress: Optional[Progress] = None) -> Parts:
        """Sheets, seams and junctions with what is measured of them, and each sheet as a mesh.

        Parameters
        ----------
        remesh : length, optional
            Triangles with sides about this long; None: the polygons of the skeleton, in triangles.

        Examples
        --------
        >>> import numpy as np, quench
        >>> plate = np.zeros((50, 40, 14), bool)
        >>> plate[4:-4, 4:-4, 4:-4] = True
        >>> parts = quench.medial_axis(plate).skeleton().parts(remesh='3vox')
        >>> parts
        Parts: 1 sheet, 0 seams, 0 junctions
        >>> mesh = parts.meshes[0]
        >>> bool(6 <= np.median(mesh.thickness) <= 7.5)
        True
        """
        self._no_image('parts()', 'branches()')
        wanted = None if remesh is None else length(remesh, 'remesh')
        with self._calling(threads, progress) as call:
            return Parts(_core.parts_of(self._core, wanted, *call))

    def to_networkx(self) -> Any:
        """A ``networkx.MultiGraph`` of ends, junctions and branches: ``graph().to_networkx()``."""
        return self._graph.to_networkx()

    def to_skan(self, separator: str = '-') -> Table:
        """The table of ``skan.summarize``: ``graph().to_skan()``."""
        return self._graph.to_skan(separator)

    def to_navis(self, *, root: Optional[Sequence[float]] = None, swc_type: Union[int, str] = 'dendrite') -> Any:
        """A ``navis.TreeNeuron``, of several trees a ``navis.NeuronList``: ``graph().to_navis()``."""
        return self._graph.to_navis(root=root, swc_type=swc_type)

    def to_geojson(self, path: Optional[Path] = None) -> Dict[str, Any]:
        """Of an image: the branches as a GeoJSON FeatureCollection, a LineString per branch: ``graph().to_geojson()``.

        Parameters
        ----------
        path : str or path, optional
            Also writes it to a file.

        Returns
        -------
        dict
            Coordinates are (x, y) as in `vertices`; ``y_axis`` says "down" or "up". Properties are `branch` (the row of
            :meth:`branches`) and, of the columns there, `from`, `to`, `from_kind`, `to_kind`, `length`, `mean_radius`,
            `min_radius`, `max_radius`, `thickness`, `tortuosity`; and arrays with a number per point, `radius`,
            `erosion_thickness`, `mgf`. What is infinite is null. A component that is one point is a Point with `from`,
            its row of ``graph().nodes``, `kind` "isolated" and `radius`.

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((9, 40), bool)
        >>> image[2:-2, 2:-2] = True
        >>> line, = quench.medial_axis(image).skeleton().to_geojson()['features']
        >>> line['geometry']['type'], line['properties']['max_radius']
        ('LineString', 2.5...)
        """
        return self._graph.to_geojson(path)

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh`` of the sheets."""
        self._no_image('to_trimesh()', 'curves')
        return _export.to_trimesh(self.sheets.vertices, self.sheets.faces)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` of sheets and curves with ``radius``."""
        sheets, curves = self.sheets, self.curves
        return _export.to_pyvista(np.concatenate([sheets.vertices, curves.vertices]), sheets.faces,
                                  curves.edges + len(sheets.vertices),
                                  {'radius': np.concatenate([sheets.radius, curves.radius])})

    def to_volume(self, shape: Optional[Sequence[int]] = None, *, threads: Optional[int] = None,
                  progress: Optional[Progress] = None) -> Array:
        """The voxels the skeleton runs through, as a bool image: connected (26) where the skeleton is.

        Parameters
        ----------
        shape : three ints, optional
            Of the result; default: that of the image, or of the voxels a mesh was turned into.

        Examples
        --------
        >>> import numpy as np, quench
        >>> tube = np.zeros((40, 9, 9), bool)
        >>> tube[2:-2, 2:-2, 2:-2] = True
        >>> line = quench.medial_axis(tube).skeleton('inf').to_volume()
        >>> bool((line & ~tube).any()), 20 < line.sum() < 45
        (False, True)
        """
        self._no_image('to_volume()', 'to_image()')
        mask = _export.mask(self._core.axis_shape, shape, self.dimension)
        with self._calling(threads, progress) as call:
            self._core.mark_cells(mask.view(np.uint8), *call)
        return mask

    def to_image(self, shape: Optional[Sequence[int]] = None, *, return_distance: bool = False,
                 labels: bool = False) -> Any:
        """Of an image: the pixels the skeleton runs through, as a bool image, see :meth:`MedialAxis.to_image`.

        Parameters
        ----------
        shape, return_distance
            As there.
        labels : bool
            An int32 image in place of the bool one: 0 where there is no branch, else 1 + the branch (the row of
            :meth:`branches`; of several, the first).

        Examples
        --------
        >>> import numpy as np, quench
        >>> image = np.zeros((30, 40), bool)
        >>> image[2:7, 2:-2] = image[2:-2, 17:22] = True  # a T
        >>> skeleton = quench.medial_axis(image).skeleton()
        >>> np.unique(skeleton.to_image(labels=True))
        array([0, 1, 2, 3], dtype=int32)
        """
        branch = np.asarray(self._core.edge_branch) if labels else None
        return self._image(self._core.axis_shape, shape, return_distance, branch)

    def reconstruct(self, shape: Optional[Sequence[int]] = None, *, threads: Optional[int] = None,
                    progress: Optional[Progress] = None) -> Array:
        """The union of the balls as a bool image, see :meth:`MedialAxis.reconstruct`."""
        mask = _export.mask(self._core.axis_shape, shape, self.dimension)
        with self._calling(threads, progress) as call:
            self._core.mark_balls(mask.view(np.uint8), *call)
        return mask

    def solid(self, envelope: bool = True, *, resolution: Optional[int] = None, threads: Optional[int] = None,
              progress: Optional[Progress] = None) -> Solid:
        """The solid of the balls and, as `envelope`, of all that lies between them, see :meth:`MedialAxis.solid`."""
        number = 0 if resolution is None else whole(resolution, 'resolution', 1)
        with self._calling(threads, progress) as call:
            core = _core.solid_of_skeleton(self._core, bool(envelope), number, *call)
        return Solid(core, self._threads, self._progress)

    def verify(self, samples: int = 20000, *, threads: Optional[int] = None,
               progress: Optional[Progress] = None) -> Certificate:
        """Checks the skeleton against its shape, see :meth:`MedialAxis.verify`."""
        with self._calling(threads, progress) as call:
            return Certificate(self._core.verify(whole(samples, 'samples', 1), *call))

    def save(self, path: Path, *, quality: str = 'radius', root: Optional[Sequence[float]] = None,
             swc_type: Union[int, str] = 'dendrite', threads: Optional[int] = None,
             progress: Optional[Progress] = None) -> None:
        """Writes a file, over an existing one; an interrupted call leaves none half written.

        Parameters
        ----------
        path : str or path
            As ``quench skeleton -o`` of the program: .vtp, .ply, .obj: sheets and curves; .csv: a row per vertex. .swc,
            .graphml, of images .geojson: the branches as in :meth:`graph`; .png: a picture; .html: an interactive page. The
            table of branches is ``graph().save('branches.csv')``.
        quality : str
            Of PLY: the array that MeshLab shows as quality.
        root : three floats, optional
            Of SWC: the node next to this place is the root of its tree. Default: the thickest.
        swc_type : int or str
            Of SWC: the type of every sample, a number or "soma", "axon", "dendrite", "apical-dendrite", "custom" ...;
            programs for neurons refuse 0.
        """
        kind = ending(path)
        if kind in ('.swc', '.graphml', '.geojson'):
            self._graph.save(path, root=root, swc_type=swc_type)
        else:
            with self._calling(threads, progress) as call:
                if kind not in ('.html', '.png'):
                    self._core.save(written(path), quality, *call)
                elif kind == '.png':
                    _core.page_of_skeleton(self._core, written(path), None, *call)
                else:
                    self._write_page(written(path), call)

    def view(self, *, height: int = 600, threads: Optional[int] = None, progress: Optional[Progress] = None) -> View:
        """The interactive page, as :meth:`save` writes it to .html, see :meth:`MedialAxis.view`."""
        with self._calling(threads, progress) as call:
            return _show.view_of(lambda file: self._write_page(file, call), 'Skeleton', height)

    def _write_page(self, file: bytes, call: Any) -> None:
        if self.axis is None:  # of skeletonize(): what it is a part of is not kept
            _core.page_of_skeleton(self._core, file, None, *call)
        else:
            _core.page_of_axis(self.axis._core, self._core, file, None, *call)

    def _repr_html_(self) -> str:
        units, facts = self.units, self._facts()
        branches = np.asarray(self._core.edge_branch)
        facts.insert(1, ('branches', f'{int(branches.max()) + 1 if len(branches) else 0:,}'))
        if self.dimension == 3:
            facts.append(('θ2', _show.number(self.theta2, units)))
        radii = f' or {self.theta1_radii:g} radii' if self.theta1_radii else ''
        facts.append(('θ1', _show.number(self.theta1, units) + radii))
        return _show.card('Skeleton', facts, self._picture())

    def _draw(self, file: bytes) -> None:
        with calling(self._threads, False) as call:
            _core.page_of_skeleton(self._core, file, _show.SIZE, *call)

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draws curves, coloured by radius, and sheets with matplotlib; returns the axes. Of images: as
        :meth:`MedialAxis.plot`."""
        return (_plane if self.dimension == 2 else _export).plot(self, ax, **options)


def skeletonize(image: Any, /, *, spacing: Spacing = None, labels: Union[str, Iterable[int]] = 'all',
                detail: Length = 'auto', lambda_: Optional[Length] = None, theta2: Length = 'inf',
                theta1: Length = 'auto', dimension: Optional[int] = None, threads: int = 0,
                progress: Progress = False) -> Dict[int, Skeleton]:
    """The skeleton of every label of a label image, several at a time.

    Parameters
    ----------
    image : array of integers or bool, Volume, or path
        Of two or three dimensions. 0 is the background unless `labels` names it; the label of a mask is 1.
    spacing : float or a float per axis, optional
        As in :func:`medial_axis`.
    labels : "all" or ints
    detail, lambda_, theta2, theta1 : length or "auto"
        As in :func:`medial_axis` and :meth:`MedialAxis.skeleton`. Fractions are those of the longest side of each label.
    dimension : 2 or 3, optional
        As in :func:`medial_axis`.
    threads : int
        Labels worked on at a time; 0: as many as there are processors. No more than memory allows are begun. The result
        is the same for any number.
    progress : bool or callable

    Returns
    -------
    dict of int to Skeleton
        In the order of the labels, with places in the whole image.

    Examples
    --------
    >>> import numpy as np, quench
    >>> image = np.zeros((40, 30, 9), np.uint16)
    >>> image[2:-2, 2:8, 2:-2] = 3
    >>> image[2:-2, 12:28, 2:-2] = 7
    >>> {label: s.topology.betti for label, s in quench.skeletonize(image).items()}
    {3: (1, 0, 0), 7: (1, 0, 0)}
    >>> quench.skeletonize(image[:, :, 4])[7].to_image().shape
    (40, 30)
    """
    pruning, thetas = pruning_of(detail, lambda_), (length_or_auto(theta2, 'theta2'), length_or_auto(theta1, 'theta1'))
    if isinstance(labels, str):
        if labels != 'all':
            raise error(2, f"labels={labels!r} is neither 'all' nor a list of labels", 'labels')
        chosen = None
    else:
        chosen = sorted({label_of(label) for label in labels})
    spacing_of(spacing)  # refuses what is wrong before a file is read
    with calling(threads, progress) as call:
        if is_path(image):
            image = read_file(image, spacing, None, call, dimension)
            if not isinstance(image, Volume):
                raise error(3, 'a label image is a volume, and this file is not one')
        array = image.array if isinstance(image, Volume) else image_array(image, dimension)
        size = spacing_of(spacing, array.ndim)
        wish = (*pruning, theta2_of(theta2, array.ndim), thetas[1])
        place = image._place if isinstance(image, Volume) else None
        found = _core.skeletonize_array(array, place, size, chosen, *wish, *call)
    return {label: Skeleton(core) for label, core in found}
