# SPDX-License-Identifier: Apache-2.0
"""The curves of a skeleton as nodes and branches."""
from __future__ import annotations

import os
from functools import cached_property
from typing import Any, Dict, List, Optional, Sequence, Union

import numpy as np

from . import _core, _export, _plane, _show
from ._common import Array, Path, ending, error, need, written
from ._pickles import Result

Table = Dict[str, Array]


class Graph(Result):
    """The curves of a skeleton as nodes and branches, to measure on; made by :meth:`Skeleton.graph`.

    Attributes
    ----------
    nodes : dict of arrays
        ``x y z radius kind component degree sheet``, a row per node. `kind` is one of end, junction, sheet, loop, isolated;
        `sheet` the patch of sheets the node lies on, or -1. Of an image without z.
    branches : dict of arrays
        ``from to component length mean_radius min_radius max_radius thickness tortuosity from_x ... to_z from_kind
        to_kind``, a row per branch. ``pandas.DataFrame(graph.branches)`` is a table.
    paths : list of (n, 3) arrays, of an image (n, 2)
        The course of each branch: x, y, z or x, y.
    radii : list of (n,) arrays
        The radius along it.
    erosion_thickness, mgf : list of (n,) arrays
        Of an image, what else is measured along it; infinite on loops, and where the boundary points are on different
        outlines. Of volumes empty.
    """

    def __init__(self, core: '_core.Graph'):
        self._core = core

    def __repr__(self) -> str:
        return f'Graph of {len(self.nodes["x"])} nodes, {len(self.branches["length"])} branches'

    def _repr_html_(self) -> str:
        kinds, counts = np.unique(self.nodes['kind'], return_counts=True)
        names = ', '.join(f'{count:,} {kind}' for kind, count in zip(kinds, counts))
        return _show.card('Graph', [('branches', f'{len(self.branches["length"]):,}'), ('nodes', names or 'none'),
                                    ('length', _show.ranged(self.branches['length'])),
                                    ('mean radius', _show.ranged(self.branches['mean_radius']))])

    @cached_property
    def nodes(self) -> Table:
        columns = {name: np.asarray(column) for name, column in self._core.nodes().items()}
        return {**self._xyz(columns.pop('point')), **{**columns, 'kind': _kinds(columns['kind'])}}

    @cached_property
    def branches(self) -> Table:
        columns = {name: np.asarray(column) for name, column in self._core.branches().items()}
        ends = {**self._xyz(columns.pop('from_point'), 'from_'), **self._xyz(columns.pop('to_point'), 'to_'),
                'from_kind': _kinds(columns.pop('from_kind')), 'to_kind': _kinds(columns.pop('to_kind'))}
        return {**columns, **ends}

    def _xyz(self, points: Array, prefix: str = '') -> Table:
        return {prefix + name: points[:, a] for a, name in enumerate('xyz'[:self._core.dimension])}

    @cached_property
    def _paths(self) -> List[Any]:
        return self._core.paths()

    @cached_property
    def paths(self) -> List[Array]:
        return [np.asarray(path[0])[:, :self._core.dimension] for path in self._paths]

    @cached_property
    def radii(self) -> List[Array]:
        return [np.asarray(path[1]) for path in self._paths]

    @cached_property
    def erosion_thickness(self) -> List[Array]:
        return [np.asarray(path[2]) for path in self._paths]

    @cached_property
    def mgf(self) -> List[Array]:
        return [np.asarray(path[3]) for path in self._paths]

    def to_networkx(self) -> Any:
        """A ``networkx.MultiGraph``: rows of `nodes` and `branches` are the attributes, `path` and `radii` those of edges."""
        networkx = need('networkx', 'to_networkx()')
        graph = networkx.MultiGraph()
        for n in range(len(self.nodes['x'])):
            graph.add_node(n, **{name: column[n].item() for name, column in self.nodes.items()})
        for b, (path, radii) in enumerate(zip(self.paths, self.radii)):
            row = {name: column[b].item() for name, column in self.branches.items()}
            graph.add_edge(row.pop('from'), row.pop('to'), key=b, path=path, radii=radii, **row)
        return graph

    def to_skan(self, separator: str = '-') -> Table:
        """The table of ``skan.summarize``, without skan: a row per branch, for what was written for such tables.

        Parameters
        ----------
        separator : str
            In the names of columns: "-", or "_" as newer versions of skan have it.

        Returns
        -------
        dict of arrays
            ``pandas.DataFrame(graph.to_skan())``. ``image-coord`` is the index in the image, a fraction, as branches are
            smooth (NaN where there is no image), and ``coord`` the place, in the order of the axes of the array: of images
            (y, x). ``mean-pixel-value`` and ``stdev-pixel-value`` are those of the radius, as of a distance image.
            ``branch-type``: 0 between two ends, 1 between an end and a junction, 2 between two junctions, 3 a loop. Places
            where curves meet a sheet are junctions.
        """
        nodes, rows = self.nodes, self.branches
        dimension = self._core.dimension
        order = [1, 0] if dimension == 2 else [0, 1, 2]
        places = np.stack([nodes[name] for name in 'xyz'[:dimension]], axis=1)
        indices = self._core.indices(np.ascontiguousarray(np.pad(places, ((0, 0), (0, 3 - dimension)))))
        index = np.full(places.shape, np.nan) if indices is None else np.asarray(indices)
        ends = {'src': rows['from'], 'dst': rows['to']}
        tip = {name: nodes['kind'][end] == 'end' for name, end in ends.items()}
        kind = np.where(ends['src'] == ends['dst'], 3, 2 - tip['src'].astype(np.int64) - tip['dst'])
        # Means along the branch, by length, and the deviation from them.
        deviations = np.zeros(len(kind))
        for b, (path, radius) in enumerate(zip(self.paths, self.radii)):
            steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
            if steps.sum() > 0:
                deviations[b] = np.sqrt(np.average(((radius[1:] + radius[:-1]) / 2 - rows['mean_radius'][b])**2, weights=steps))
        table: Table = {'skeleton-id': rows['component'].astype(np.int64)}
        table.update({f'node-id-{name}': end.astype(np.int64) for name, end in ends.items()})
        table.update({'branch-distance': rows['length'], 'branch-type': kind, 'mean-pixel-value': rows['mean_radius'],
                      'stdev-pixel-value': deviations})
        for what, values in (('image-coord', index), ('coord', places)):
            for name, end in ends.items():
                table.update({f'{what}-{name}-{i}': values[end, axis] for i, axis in enumerate(order)})
        table['euclidean-distance'] = np.linalg.norm(places[ends['dst']] - places[ends['src']], axis=1)
        return {name.replace('-', separator): values for name, values in table.items()}

    def swc(self, *, root: Optional[Sequence[float]] = None, swc_type: Union[int, str] = 'dendrite') -> Table:
        """The samples of the .swc file that :meth:`save` writes, as a table: parents before children.

        Returns
        -------
        dict of arrays
            ``node_id parent_id x y z radius type``; the parent of a root is -1.
        """
        text = _show.file_of(lambda file: self.save(os.fsdecode(file), root=root, swc_type=swc_type), '.swc', 'graph')
        return _export.swc_table(text.decode())

    def to_navis(self, *, root: Optional[Sequence[float]] = None, swc_type: Union[int, str] = 'dendrite') -> Any:
        """A ``navis.TreeNeuron``, of several trees a ``navis.NeuronList``; loops are cut as in .swc files."""
        return _export.to_navis(self.swc(root=root, swc_type=swc_type), self._core.units)

    def save(self, path: Path, *, root: Optional[Sequence[float]] = None,
             swc_type: Union[int, str] = 'dendrite') -> Optional[Dict[str, int]]:
        """Writes .csv (a row per branch), .graphml or .swc (trees; loops are cut and listed in the header); of images also
        .geojson.

        Of SWC, `root` is a place: the node next to it is the root of its tree; `swc_type` the type of every sample, a number
        or a name ("soma", "axon", "dendrite", "apical-dendrite", "custom" ...). Returns what the file holds:
        ``trees samples sheet_links cuts``.
        """
        name = written(path)
        if ending(path) == '.csv':
            self._core.write_csv(name)
        elif ending(path) == '.graphml':
            self._core.write_graphml(name)
        elif ending(path) == '.swc':
            return self._core.write_swc(name, None if root is None else [float(x) for x in root], str(swc_type))
        elif ending(path) == '.geojson':
            self.to_geojson(path)
        else:
            raise error(2, f"'{ending(path)}' is not a format of graphs; name the file .csv, .graphml or .swc")
        return None

    def to_geojson(self, path: Optional[Path] = None) -> Dict[str, Any]:
        """Of an image: the branches as a GeoJSON FeatureCollection, see :meth:`Skeleton.to_geojson`."""
        if self._core.dimension != 2:
            raise error(2, 'to_geojson() is of images of two dimensions; of volumes there are .swc, .graphml and .csv')
        found = _plane.geojson(self, self._core.y_down)
        if path is not None:
            _plane.write_json(found, path)
        return found


def _kinds(codes: Array) -> Array:
    return np.array(_core.NODE_KINDS)[codes]
