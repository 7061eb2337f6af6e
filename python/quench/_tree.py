# SPDX-License-Identifier: Apache-2.0
"""Roots, neurons, vessels and airways as trees, and what is measured of them."""
from __future__ import annotations

import importlib
import os
from dataclasses import replace
from functools import cached_property
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core, _export, _show
from ._axis import MedialAxis
from ._common import (Array, Length, Path, Progress, calling, ending, error, file_name, is_path, length_or_auto, must_exist,
                      need, reals, warn, whole, written)
from ._inputs import Cut, as_mesh, read_file, shape_of
from ._pickles import Result
from ._show import View

Points = Union[Sequence[float], Sequence[Sequence[float]], None]
Direction = Union[str, Sequence[float], None]


class Branch(NamedTuple):
    """A piece between two forks or ends of a tree."""
    points: Array
    """(n, 3): from its base to its far end; the first is the last of its parent."""
    radius: Array
    parent: int
    """The branch at whose far end it begins; -1: it begins at a root node."""
    axis: int
    plant: int
    strahler: int
    """Horton-Strahler number."""
    order: int
    """Centrifugal: forks between the root node and its base."""
    type: int
    """Structure identifier of SWC, where one is known; else 0."""
    bridged: Array
    """(n - 1,): 1 where the shape has a gap."""


class Axis(NamedTuple):
    """A root, neurite or vessel from where it leaves its parent to its tip."""
    points: Array
    """(n, 3): the whole course, from the course of its parent on."""
    radius: Array
    parent: int
    """The axis it grows from; -1: of level 0."""
    level: int
    plant: int
    branches: Array
    """From base to tip."""
    children: Array
    """Axes, by position along it."""
    position: float
    """Length along the parent from its base to where this leaves it."""
    stem: bool
    """Whether it is the thick part from which level 1 grows."""
    label: str
    """Of the file it was read from."""


class Plant(NamedTuple):
    """One tree of its own."""
    root: Array
    """x, y, z of the root node."""
    main_axis: int
    soma: Optional[float]
    """Radius of the thick ball at the root node, where there is one."""
    label: str


class Columns(Dict[str, Any]):
    """A table where pandas is not installed: arrays by the names of columns, and `attrs` as a DataFrame has them."""

    def __init__(self, columns: Dict[str, Any]):
        super().__init__(columns)
        self.attrs: Dict[str, Any] = {}


def _frame(rows: Any) -> Any:
    """A pandas.DataFrame, or Columns without it, of (name, unit, meaning, values); `attrs` has units and meanings."""
    columns = {name: np.asarray(values) for name, _, _, values in rows}
    try:
        table: Any = importlib.import_module('pandas').DataFrame(columns)
    except ImportError:
        table = Columns(columns)
    table.attrs['units'] = {name: unit for name, unit, _, _ in rows}
    table.attrs['meanings'] = {name: meaning for name, _, meaning, _ in rows}
    return table


TABLES = ('axes', 'branches', 'sample', 'sholl', 'depths', 'toporoot')


class Tree(Result):
    """One tree per plant: axes and branches with courses and radii; made by :func:`tree` or :func:`read_tree`.

    Attributes
    ----------
    axes : list of Axis
        Roots, neurites or vessels, each from where it leaves its parent to its tip; parents before children.
    branches : list of Branch
        Pieces between forks and ends, parents before children.
    plants : list of Plant
        Trees of their own, with their root nodes.
    edits : table
        What was repaired: a row per cut, bridge and part that was left out.
    edited : bool array or None
        The shape after repair, where the tree is of a shape that is known: one component without tunnels per plant.
    units : str
        Of lengths, where they are known.
    down : (3,) array
        Where gravity points.
    components_before, loops_before : int
        Of the curves, before they were repaired.
    """

    def __init__(self, core: '_core.Tree', threads: int = 0, progress: Progress = False):
        self._core = core
        self._threads = threads
        self._progress = progress

    def __repr__(self) -> str:
        plants = '' if len(self.plants) == 1 else f' of {len(self.plants)} plants'
        deepest = max((axis.level for axis in self.axes), default=0)
        return f'Tree{plants} with {len(self.axes)} axes of levels 0 to {deepest}, {len(self.branches)} branches'

    @cached_property
    def branches(self) -> List[Branch]:
        return [Branch(np.asarray(points), np.asarray(radius), _index(parent), axis, plant, strahler, order, kind,
                       np.asarray(bridged) if len(np.asarray(bridged)) else np.zeros(len(np.asarray(points)) - 1, np.uint8))
                for points, radius, parent, axis, plant, strahler, order, kind, bridged in self._core.branches()]

    @cached_property
    def axes(self) -> List[Axis]:
        return [Axis(np.asarray(points), np.asarray(radius), _index(parent), level, plant, np.asarray(branches),
                     np.asarray(children), position, stem, label)
                for points, radius, parent, level, plant, branches, children, position, stem, label in self._core.axes()]

    @cached_property
    def plants(self) -> List[Plant]:
        return [Plant(np.array(root), main_axis, soma, label) for root, main_axis, soma, label in self._core.plants()]

    @property
    def units(self) -> str:
        return self._core.units

    @property
    def down(self) -> Array:
        return np.array(self._core.down)

    @property
    def components_before(self) -> int:
        return self._core.components_before

    @property
    def loops_before(self) -> int:
        return self._core.loops_before

    @cached_property
    def edits(self) -> Any:
        return _frame(self._core.table('edits'))

    @cached_property
    def edited(self) -> Optional[Array]:
        image = self._core.edited()
        return None if image is None else np.asarray(image).astype(bool)

    def traits(self, table: str = 'axes') -> Any:
        """What is measured: a ``pandas.DataFrame``, or a dict of arrays where pandas is not installed.

        Parameters
        ----------
        table : str
            "axes" or "branches": a row for each; "sample": one row; "sholl", "depths": profiles, a row per sphere or layer;
            "toporoot": a row per axis with the columns of TopoRoot.

        Returns
        -------
        table
            ``.attrs['units']`` has the unit of every column, ``.attrs['meanings']`` what it is; docs/user/traits.md has the
            formulas.
        """
        if table not in TABLES:
            raise error(2, f'table={table!r} is not one of {", ".join(map(repr, TABLES))}', 'table')
        return _frame(self._core.table(table))

    def save(self, path: Path, *, swc_type: Union[int, str] = 'dendrite', columns: str = 'quench',
             threads: Optional[int] = None, progress: Optional[Progress] = None) -> None:
        """Writes a file, over an existing one; an interrupted call leaves none half written.

        Parameters
        ----------
        path : str or path
            .rsml, .swc, .mtg, .graphml, .vtp (a polyline per branch); .csv (a row per axis); .png (a picture), .html (the
            interactive page).
        swc_type : int or str
            Of SWC: the type of every sample of which none is known, a number or "axon", "dendrite", "custom" ...
        columns : "quench" or "toporoot"
            Of .csv.
        """
        if columns not in ('quench', 'toporoot'):
            raise error(2, f"columns={columns!r} is not one of 'quench', 'toporoot'", 'columns')
        with calling(self._threads if threads is None else threads,
                     self._progress if progress is None else progress) as call:
            if not self._core.save(written(path), str(swc_type), columns == 'toporoot', None, *call):
                raise error(2, f"'{ending(path)}' is not a format of trees; name the file .rsml, .swc, .mtg, .graphml, .vtp, "
                               '.csv, .png or .html')

    def swc(self, *, swc_type: Union[int, str] = 'dendrite') -> Dict[str, Array]:
        """The samples of the .swc file that :meth:`save` writes, as a table: parents before children.

        Returns
        -------
        dict of arrays
            ``node_id parent_id x y z radius type``; the parent of a root is -1.
        """
        with calling(self._threads, False) as call:
            text = _show.file_of(lambda file: self._core.save(file, str(swc_type), False, None, *call), '.swc', 'tree')
        return _export.swc_table(text.decode())

    def to_navis(self, *, swc_type: Union[int, str] = 'dendrite') -> Any:
        """A ``navis.TreeNeuron``, of several plants a ``navis.NeuronList``."""
        return _export.to_navis(self.swc(swc_type=swc_type), self.units)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData`` of the branches as lines, with ``radius``, ``branch`` and ``axis``."""
        sizes = np.array([len(branch.points) for branch in self.branches], np.int64)
        last = np.cumsum(sizes) - 1
        starts = np.delete(np.arange(sizes.sum()), last)
        number = np.repeat(np.arange(len(sizes)), sizes)
        arrays = {'radius': np.concatenate([np.zeros(0), *(branch.radius for branch in self.branches)]), 'branch': number,
                  'axis': np.array([branch.axis for branch in self.branches], np.int64)[number]}
        points = np.concatenate([np.zeros((0, 3)), *(branch.points for branch in self.branches)])
        return _export.to_pyvista(points, np.zeros((0, 3), np.int32), np.stack([starts, starts + 1], axis=1), arrays)

    def view(self, *, height: int = 600, threads: Optional[int] = None, progress: Optional[Progress] = None) -> View:
        """The interactive page with tables of axes and repairs, as :meth:`save` writes it to .html: a notebook shows it in a
        frame, see :meth:`MedialAxis.view`."""
        with calling(self._threads if threads is None else threads,
                     self._progress if progress is None else progress) as call:
            return _show.view_of(lambda file: self._core.save(file, 'dendrite', False, None, *call), 'Tree', height)

    def _repr_html_(self) -> str:
        levels = np.bincount([axis.level for axis in self.axes])
        sample = {name: np.asarray(values) for name, _, _, values in self._core.table('sample')}
        facts = [('plants', f'{len(self.plants):,}'), ('axes', f'{len(self.axes):,}'),
                 ('by level', ', '.join(f'{level}: {count:,}' for level, count in enumerate(levels))),
                 ('branches', f'{len(self.branches):,}'),
                 ('radius', _show.ranged(np.concatenate([np.zeros(0), *(b.radius for b in self.branches)]), self.units)),
                 ('repairs', f'{len(self.edits["kind"]):,}')]
        if 'total_length' in sample:
            facts.insert(4, ('length', _show.number(float(sample['total_length'][0]), self.units)))
        return _show.card('Tree', facts, _show.picture(self._draw))

    def _draw(self, file: bytes) -> None:
        with calling(self._threads, False) as call:
            self._core.save(file, 'dendrite', False, _show.SIZE, *call)

    def to_networkx(self) -> Any:
        """A ``networkx.DiGraph`` from root nodes to tips: an edge per branch, with its rows of ``traits('branches')``, `points`
        and `radius`; nodes have `x`, `y`, `z`, `radius`.
        """
        networkx = need('networkx', 'to_networkx()')
        graph = networkx.DiGraph()
        rows = self._core.table('branches')
        first = {plant: n for n, plant in enumerate(range(len(self.plants)))}
        for plant, n in first.items():
            graph.add_node(n, **_place(self.plants[plant].root), plant=plant)
        for b, branch in enumerate(self.branches):
            start = first[branch.plant] if branch.parent < 0 else len(first) + branch.parent
            graph.add_node(len(first) + b, **_place(branch.points[-1]), radius=float(branch.radius[-1]), plant=branch.plant)
            if branch.parent < 0:
                graph.nodes[start]['radius'] = float(branch.radius[0])
            row = {name: _item(np.asarray(values)[b]) for name, _, _, values in rows}
            graph.add_edge(start, len(first) + b, **{**row, 'points': branch.points, 'radius': branch.radius})
        return graph


def _index(parent: int) -> int:
    """-1 for none."""
    return -1 if parent == 2**32 - 1 else parent


def _place(point: Array) -> Dict[str, float]:
    return {name: float(value) for name, value in zip('xyz', point)}


def _item(value: Any) -> Any:
    return value.item() if hasattr(value, 'item') else value


def _points(root: Points) -> List[Tuple[float, float, float]]:
    """The root nodes that are given: one place or several."""
    if root is None:
        return []
    places = np.atleast_2d(reals(root, 'the places of root nodes'))
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        raise error(2, f'root={root!r} is neither a place (x, y, z) nor several', 'root')
    return [(float(x), float(y), float(z)) for x, y, z in places]


def _direction(down: Direction) -> Optional[Tuple[float, float, float]]:
    """A vector; of a text such as "-z" that of the axis."""
    if down is None:
        return None
    if isinstance(down, str):
        name = down[1:] if down[:1] in ('-', '+') else down
        values = np.array([(name == letter) * (-1.0 if down[0] == '-' else 1.0) for letter in 'xyz'])
    else:
        values = reals(down, 'the direction of gravity')
    if values.shape != (3,) or not np.isfinite(values).all() or not values.any():
        raise error(2, f'down={down!r} is not a direction; give "-z", "+y" ... or three numbers that are not all 0', 'down')
    return (float(values[0]), float(values[1]), float(values[2]))


def _how(kind: str, root: Points, plants: Optional[int], down: Direction, repair: str, reach: Length, axes: Optional[str],
         soma: Optional[str], sholl_step: Length) -> '_core.TreeHow':
    roots = _points(root)
    if roots and plants is not None:
        raise error(2, 'plants and root cannot be combined: there are as many plants as there are root nodes', 'plants')
    return _core.TreeHow(kind=str(kind), repair=str(repair), roots=roots,
                         plants=None if plants is None else min(whole(plants, 'plants'), 10**6),
                         reach=length_or_auto(reach, 'reach'), axes=None if axes is None else str(axes),
                         soma=None if soma is None else str(soma), down=_direction(down),
                         sholl_step=length_or_auto(sholl_step, 'sholl_step'))


def tree(source: Any, kind: str = 'root', *, root: Points = None, plants: Optional[int] = None, down: Direction = None,
         repair: str = 'all', reach: Length = 'auto', axes: Optional[str] = None, soma: Optional[str] = None,
         theta1: Length = 'auto', sholl_step: Length = 'auto', threads: int = 0, progress: Progress = False,
         **shape: Any) -> Tree:
    """The tree of a root system, a neuron, a vessel or an airway.

    Its curves are repaired to one tree per plant, which is then given a hierarchy of axes and measured.

    Parameters
    ----------
    source : array, mesh, Volume, MedialAxis, or path
        As :func:`medial_axis` takes it; or a medial axis, or the path of a result (core.vtp, skeleton.vtp) or of a tree
        (.swc, .rsml).
    kind : "root", "neuron", "vessel" or "airway"
        What it is the tree of, for defaults.
    root : (x, y, z) or several, optional
        The root node is the one nearest to this place; of several, there is a plant for each. Default: of roots the thick end
        at the top, of vessels and airways the thickest end, of neurons the thickest node.
    plants : int, optional
        So many trees, those that are worth most; 0: every part stays a tree of its own. Default: 1.
    down : "-z", "+y" ... or a vector, optional
        Where gravity points. Default: of roots "-z" or "+z", so that most of the volume lies at the top; else "-z".
    repair : "all", "loops", "gaps" or "off"
        Whether loops are cut and gaps are bridged.
    reach : length or "auto"
        The longest gap that is bridged.
    axes : "depth", "length", "radius", "strahler" or "continuation", optional
        Which child continues its parent at a fork.
    soma : "auto", "none" or "thickest", optional
        Whether the root node is a soma. Default: "auto" for neurons, else "none".
    theta1 : length, radii or "auto"
        Branches that stick out of what they leave by less go. "auto": one radius of that ("1r"), and what is thinner than four
        voxels.
    sholl_step : length or "auto"
        Distance of the spheres of the Sholl profile.
    threads, progress
        As in :func:`medial_axis`.
    **shape
        Keyword arguments of :func:`medial_axis` that say what the shape is. Of a grey volume without `threshold` and
        `label` the two thresholds of "thin" are taken, with a warning that says which, and noisy values are
        blurred by 0.8 voxels before, unless `blur`, `median` or `interpolate` says otherwise. Cavities are filled, and voxels that touch in edges
        or corners are joined (`connectivity=26`).

    Returns
    -------
    Tree

    Examples
    --------
    >>> import numpy as np, quench
    >>> plant = np.zeros((40, 12, 50), bool)
    >>> plant[18:23, 4:9, 2:-2] = True  # a root along z
    >>> plant[5:20, 5:8, 20:23] = True  # and a lateral
    >>> tree = quench.tree(plant)
    >>> [axis.level for axis in tree.axes]
    [0, 1]
    >>> tree.axes[1].parent
    0
    """
    how = _how(kind, root, plants, down, repair, reach, axes, soma, sholl_step)
    theta = length_or_auto(theta1, 'theta1')
    if isinstance(source, MedialAxis):
        _no_shape(shape, 'a medial axis')
        axis = source
    elif is_path(source) and _core.is_tree_file(file_name(source)):
        _no_shape(shape, 'a tree')
        with calling(threads, progress) as call:
            must_exist(source)
            return Tree(_core.read_tree(file_name(source), how, *call), threads, progress)
    else:
        given: Dict[str, Any] = {'fill_cavities': True, **_known(shape), 'keep_values': repair in ('all', 'gaps')}
        cut = Cut(**given)
        if is_path(source):
            with calling(threads, progress) as call:
                found = read_file(source, cut.spacing, None, call, cut.dimension, cut.channel)
                if isinstance(found, _core.Axis):
                    _no_shape(shape, 'a result')
                    return Tree(_core.tree_of_result(file_name(source), how, theta, *call), threads, progress)
            source = found
        image = as_mesh(source) is None
        if image and 'connectivity' not in shape:
            cut = replace(cut, connectivity=26)
        choose = image and cut.threshold is None and cut.label is None
        voxels = shape_of(source, replace(cut, threshold='thin') if choose else cut, threads, progress)
        chosen = voxels.chosen if choose else None
        if chosen:
            if chosen[2] != 'thin' and not (cut.interpolate or cut.median or 'blur' in shape):  # as the program does
                voxels = shape_of(source, replace(cut, threshold='thin', blur=0.8), threads, progress)
            value, seed, rule, reason = voxels.chosen or chosen
            values = f'{value:g}' if seed is None else f'{value:g}, {seed:g}'
            warn(f'threshold {values} ({rule}): {reason}; threshold=T takes another')
        with calling(threads, progress) as call:
            axis = MedialAxis(_core.compute_axis(voxels, 'detail', 'auto', 'coface', [], *call), threads, progress)
    if axis.dimension == 2:
        raise error(2, 'trees are made in space; of an image, skeleton() has a graph of branches')
    with calling(threads, progress) as call:
        return Tree(_core.tree_of_axis(axis._core, how, theta, *call), threads, progress)


def read_tree(path: Path, kind: str = 'root', *, root: Points = None, down: Direction = None, axes: Optional[str] = None,
              soma: Optional[str] = None, sholl_step: Length = 'auto') -> Tree:
    """A tree of an .swc or .rsml file, measured as it is.

    Parameters
    ----------
    path : str or path
    kind, root, down, axes, soma, sholl_step
        As in :func:`tree`. The axes that a file has stay, unless `axes`, `root` or `soma` is given.

    Returns
    -------
    Tree

    Examples
    --------
    >>> import os, tempfile, quench
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = os.path.join(folder, 'y.swc')
    ...     with open(file, 'w') as out:
    ...         _ = out.write('1 3 0 0 0 1 -1\\n2 3 0 0 -5 1 1\\n3 3 2 0 -9 1 2\\n4 3 -2 0 -7 1 2\\n')
    ...     len(quench.read_tree(file).branches)
    3
    """
    if not _core.is_tree_file(file_name(path)):
        raise error(2, f"'{os.fsdecode(path)}' is not a tree; trees are read from .swc and .rsml")
    how = _how(kind, root, None, down, 'off', 'auto', axes, soma, sholl_step)
    with calling(0, False) as call:
        must_exist(path)
        return Tree(_core.read_tree(file_name(path), how, *call))


def _no_shape(shape: Dict[str, Any], what: str) -> None:
    if shape:
        raise error(2, f'{", ".join(shape)} say what a shape is; this is {what} already', next(iter(shape)))


def _known(shape: Dict[str, Any]) -> Dict[str, Any]:
    """The keyword arguments of a shape; refuses others as Python does."""
    for name in shape:
        if name not in Cut.__dataclass_fields__ or name in ('keep_values', 'keep_mesh'):
            raise TypeError(f'tree() got an unexpected keyword argument {name!r}')
    return shape
