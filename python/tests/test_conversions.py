# SPDX-License-Identifier: Apache-2.0
"""Results for other packages. What is not installed is played by a module of the same name."""
import sys
import types

import numpy as np
import pytest
import quench
from shapes import bent_tube, plate_with_tunnel


@pytest.fixture
def stand_in(monkeypatch):
    """Puts a module with classes that keep what they are given in the place of a package."""
    def put(name, *classes):
        module = types.ModuleType(name)
        for kind in classes:
            def init(self, *args, **kwargs):
                self.args, self.kwargs, self.point_data, self.vertex_attributes = args, kwargs, {}, {}
            setattr(module, kind, type(kind, (), {'__init__': init}))
        monkeypatch.setitem(sys.modules, name, module)
    return put


def three_arms(spacing=1.0):
    """A T in a box of three different sides."""
    image = np.zeros((60, 34, 11), bool)
    image[2:-2, 3:8, 3:8] = True
    image[26:31, 3:-3, 3:8] = True
    return quench.medial_axis(quench.Volume(image, spacing, origin=(10, 20, 30), units='um')).skeleton('inf', '0.5r')


def test_trimesh_and_pyvista(stand_in):
    stand_in('trimesh', 'Trimesh')
    stand_in('pyvista', 'PolyData')
    axis = quench.medial_axis(plate_with_tunnel())
    skeleton = axis.skeleton()
    parts, solid = skeleton.parts(), axis.solid()
    mesh = quench.sample('torus', fineness=0.3)
    walls = quench.surface_thickness(mesh, resolution=24)
    meshes = [(axis, axis.vertices, axis.faces), (skeleton, skeleton.sheets.vertices, skeleton.sheets.faces),
              (parts, parts.vertices, parts.faces), (parts.meshes[0], parts.meshes[0].vertices, parts.meshes[0].faces),
              (solid, *solid.mesh()), (mesh, mesh.vertices, mesh.faces), (walls, walls.vertices, walls.faces)]
    for result, vertices, faces in meshes:
        made = result.to_trimesh()
        np.testing.assert_array_equal(made.args[0], vertices)
        np.testing.assert_array_equal(made.args[1], faces)
        data = result.to_pyvista()
        padded = data.kwargs['faces'].reshape(-1, 4)
        assert (padded[:, 0] == 3).all()
        np.testing.assert_array_equal(data.args[0][padded[:, 1:]], vertices[faces])
        for values in data.point_data.values():
            assert len(values) == len(data.args[0])
    np.testing.assert_array_equal(walls.to_trimesh().vertex_attributes['thickness'], walls.thickness)
    np.testing.assert_array_equal(walls.to_pyvista().point_data['thickness'], walls.thickness)
    tree = quench.tree(bent_tube())
    data = tree.to_pyvista()
    lines = data.kwargs['lines'].reshape(-1, 3)
    assert (lines[:, 0] == 2).all() and len(lines) == sum(len(branch.points) - 1 for branch in tree.branches)
    steps = np.linalg.norm(np.diff(data.args[0][lines[:, 1:]], axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(steps.sum(), sum(np.linalg.norm(np.diff(b.points, axis=0), axis=1).sum() for b in tree.branches))
    assert set(data.point_data) == {'radius', 'branch', 'axis'}


def test_tables_of_samples_are_the_swc_file(tmp_path):
    skeleton = three_arms(0.5)
    tree = quench.tree(skeleton.axis, 'neuron')
    for result, options in ((skeleton.graph(), {'root': (0, 0, 0)}), (tree, {}), (tree, {'swc_type': 'axon'})):
        table = result.swc(**options)
        assert list(table) == ['node_id', 'parent_id', 'x', 'y', 'z', 'radius', 'type']
        result.save(tmp_path / 't.swc', **options)
        rows = np.loadtxt(tmp_path / 't.swc')
        for name, column in zip(('node_id', 'type', 'x', 'y', 'z', 'radius', 'parent_id'), rows.T):
            np.testing.assert_array_equal(table[name], column)
        row = {node: n for n, node in enumerate(table['node_id'].tolist())}
        assert all(parent == -1 or row[parent] < n for n, parent in enumerate(table['parent_id'].tolist()))


def test_navis(stand_in):
    pytest.importorskip('pandas')
    stand_in('navis', 'TreeNeuron', 'NeuronList')
    skeleton = three_arms()
    neuron = skeleton.to_navis(root=(10, 20, 30))
    table, wanted = neuron.args[0], skeleton.graph().swc(root=(10, 20, 30))
    assert type(neuron).__name__ == 'TreeNeuron' and neuron.kwargs == {'units': 'um'}
    assert {'node_id', 'parent_id', 'x', 'y', 'z', 'radius', 'label'} == set(table.columns)
    np.testing.assert_array_equal(table['node_id'], wanted['node_id'])
    two = np.zeros((40, 30, 9), bool)
    two[2:-2, 2:8, 2:-2] = two[2:-2, 16:22, 2:-2] = True
    several = quench.tree(two, plants=0).to_navis()
    assert type(several).__name__ == 'NeuronList' and len(several.args[0]) == 2
    for neuron in several.args[0]:
        table = neuron.args[0]
        assert (table['parent_id'] < 0).sum() == 1 and table['parent_id'].isin([-1, *table['node_id']]).all()
        assert neuron.kwargs == {'units': None}


def test_what_is_not_installed_is_named(monkeypatch):
    for name in ('navis', 'trimesh', 'pyvista'):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(quench.Error, match='navis, which is not installed'):
        three_arms().to_navis()
    with pytest.raises(quench.Error, match='trimesh, which is not installed'):
        quench.sample('torus').to_trimesh()


COLUMNS = ['skeleton-id', 'node-id-src', 'node-id-dst', 'branch-distance', 'branch-type', 'mean-pixel-value',
           'stdev-pixel-value']


def columns(dimension):
    ends = [f'{what}-{end}-{i}' for what in ('image-coord', 'coord') for end in ('src', 'dst') for i in range(dimension)]
    return [*COLUMNS, *ends, 'euclidean-distance']


def test_the_table_of_skan_of_a_volume():
    skeleton = three_arms(0.5)
    table, graph = skeleton.to_skan(), skeleton.graph()
    assert list(table) == columns(3) and [name.replace('-', '_') for name in table] == list(skeleton.to_skan('_'))
    assert len(table['branch-type']) == 3 and (table['branch-type'] == 1).all() and (table['skeleton-id'] == 0).all()
    for b, path in enumerate(graph.paths):
        for end, n in (('src', 0), ('dst', -1)):
            place = np.array([table[f'coord-{end}-{i}'][b] for i in range(3)])
            np.testing.assert_allclose(place, path[n])
            index = np.array([table[f'image-coord-{end}-{i}'][b] for i in range(3)])
            np.testing.assert_allclose(index * 0.5 + [10, 20, 30], place)
        np.testing.assert_allclose(table['euclidean-distance'][b], np.linalg.norm(path[-1] - path[0]))
    np.testing.assert_array_equal(table['branch-distance'], graph.branches['length'])
    np.testing.assert_array_equal(table['mean-pixel-value'], graph.branches['mean_radius'])
    assert (table['stdev-pixel-value'] < table['mean-pixel-value']).all() and table['stdev-pixel-value'].max() > 0


def test_the_table_of_skan_of_an_image(tmp_path):
    image = np.zeros((60, 100), bool)
    image[10:21, 10:90] = image[10:50, 40:51] = True
    image[3:8, 3:8] = image[40:56, 70:90] = True
    image[45:51, 76:84] = False
    skeleton = quench.medial_axis(image, spacing=(2, 0.5)).skeleton()
    table = skeleton.to_skan()
    assert list(table) == columns(2) and 3 in table['branch-type'] and 1 in table['branch-type']
    for end in ('src', 'dst'):
        for i, size in enumerate((2, 0.5)):
            np.testing.assert_allclose(table[f'image-coord-{end}-{i}'] * size, table[f'coord-{end}-{i}'])
    rows = skeleton.branches()
    np.testing.assert_array_equal(table['coord-src-0'], rows['from_y'])  # the order of the axes of the array
    np.testing.assert_array_equal(table['coord-dst-1'], rows['to_x'])
    skeleton.axis.save(tmp_path / 'a.vtp')
    read = quench.read(tmp_path / 'a.vtp').skeleton().to_skan()
    assert np.isnan(read['image-coord-src-0']).all() and np.isfinite(read['coord-src-0']).all()
