# SPDX-License-Identifier: Apache-2.0
"""Trees: repair, axes, traits, files."""
import sys

import numpy as np
import pytest
import quench


def plant(gap=False):
    """A root along z, 7 thick, with a lateral, 3 thick, at z 40 .. 42; `gap`: in the lateral."""
    image = np.zeros((40, 14, 60), bool)
    image[8:15, 3:10, 2:58] = True
    image[12:37, 5:8, 40:43] = True
    if gap:
        image[22:25, 5:8, 40:43] = False
    return image


@pytest.fixture(scope='module')
def tree():
    return quench.tree(plant())


def test_axes_and_branches(tree):
    assert [axis.level for axis in tree.axes] == [0, 1]
    main, lateral = tree.axes
    assert main.parent == -1 and lateral.parent == 0 and list(main.children) == [1]
    assert main.points.shape == (len(main.radius), 3) and 2.5 < main.radius.max() < 4.5
    assert len(tree.branches) == 3 and sorted(b.parent for b in tree.branches)[0] == -1
    for branch in tree.branches:
        assert branch.points.shape == (len(branch.radius), 3) and branch.bridged.shape == (len(branch.radius) - 1,)
        if branch.parent >= 0:
            assert np.array_equal(branch.points[0], tree.branches[branch.parent].points[-1])
    assert len(tree.plants) == 1 and tree.plants[0].main_axis == 0 and tree.plants[0].soma is None
    assert np.array_equal(tree.down, (0, 0, 1)) and '2 axes' in repr(tree)
    assert tree.edited.shape == (40, 14, 60) and tree.edited.dtype == bool and tree.edited.sum() == plant().sum()


def test_traits_are_tables(tree):
    axes = tree.traits()
    assert len(axes['length']) == 2 and axes['length'][0] > axes['length'][1] > 15
    assert set(axes.attrs['units']) == set(axes.keys()) == set(axes.attrs['meanings'])
    assert len(tree.traits('branches')['length']) == 3 and len(tree.traits('sample')['length']) == 1 \
        if 'length' in tree.traits('sample') else True
    assert list(tree.traits('toporoot').keys())[:3] == ['Index', 'Level', 'Length']
    for table in ('sholl', 'depths'):
        assert len(tree.traits(table).keys()) > 1
    with pytest.raises(quench.UsageError, match='axes'):
        tree.traits('leaves')


def test_tables_without_pandas(tree, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pandas', None)
    table = tree.traits()
    assert isinstance(table, dict) and isinstance(table['length'], np.ndarray) and 'length' in table.attrs['units']


def test_a_gap_is_bridged():
    whole = quench.tree(plant(gap=True))
    assert list(whole.edits['kind']) == ['bridge'] and len(whole.axes) == 2 and whole.components_before == 2
    assert sum(branch.bridged.sum() for branch in whole.branches) > 0
    from_voxels = quench.medial_axis(whole.edited).topology.betti
    assert from_voxels == (1, 0, 0)
    parts = quench.tree(plant(gap=True), plants=0)
    assert len(parts.plants) == 2 and 'of 2 plants' in repr(parts)


def test_grey_values_need_no_threshold():
    values = np.where(plant(), 90, 10).astype(np.uint8) + np.random.default_rng(1).integers(0, 9, plant().shape, np.uint8)
    with pytest.warns(UserWarning, match='threshold'):
        found = quench.tree(values)
    assert len(found.axes) == 2


def test_of_a_medial_axis(tree):
    axis = quench.medial_axis(plant())
    again = quench.tree(axis)
    for one, other in zip(tree.branches, again.branches):
        assert np.array_equal(one.points, other.points) and np.array_equal(one.radius, other.radius)
    with pytest.raises(quench.UsageError, match='threshold'):
        quench.tree(axis, threshold=3)


@pytest.mark.parametrize('name', ['t.swc', 't.rsml'])
def test_files_are_read_back(tree, tmp_path, name):
    tree.save(tmp_path / name)
    for again in (quench.read_tree(tmp_path / name), quench.tree(tmp_path / name)):
        assert [axis.level for axis in again.axes] == [0, 1] and again.edited is None and len(again.edits) >= 0
        assert again.traits()['length'][0] == pytest.approx(tree.traits()['length'][0], rel=1e-3)


def test_saves_all_formats(tree, tmp_path):
    for name in ('t.mtg', 't.vtp', 't.graphml', 't.csv', 't.png'):
        tree.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100
    tree.save(tmp_path / 'top.csv', columns='toporoot')
    assert (tmp_path / 'top.csv').read_text().startswith('Index,Level,Length')
    with pytest.raises(quench.UsageError, match='.rsml'):
        tree.save(tmp_path / 't.doc')


def test_results_are_trees(tree, tmp_path):
    axis = quench.medial_axis(plant())
    axis.save(tmp_path / 'core.vtp')
    axis.skeleton('inf', '1r').save(tmp_path / 'skeleton.vtp')
    for name in ('core.vtp', 'skeleton.vtp'):
        found = quench.tree(tmp_path / name)
        assert len(found.axes) == 2 and found.edited is None
        assert found.traits()['length'][0] == pytest.approx(tree.traits()['length'][0], rel=1e-2)


def test_networkx(tree):
    networkx = pytest.importorskip('networkx')
    graph = tree.to_networkx()
    assert networkx.is_arborescence(graph) and graph.number_of_edges() == 3
    assert all('length' in data and len(data['points']) for _, _, data in graph.edges(data=True))


def test_refuses():
    image = plant()
    for options, argument in (({'kind': 'oak'}, 'kind'), ({'repair': 'some'}, 'repair'), ({'axes': 'long'}, 'axes'),
                              ({'soma': 'big'}, 'soma'), ({'down': (0, 0, 0)}, 'down'), ({'down': 'up'}, 'down'),
                              ({'root': (1, 2)}, 'root'), ({'plants': -1}, 'plants'), ({'reach': 'far'}, 'reach'),
                              ({'plants': 2, 'root': (1, 2, 3)}, 'plants')):
        with pytest.raises(quench.UsageError) as refused:
            quench.tree(image, **options)
        assert refused.value.argument == argument, options
    with pytest.raises(quench.UsageError, match='trees are made in space'):
        quench.tree(np.ones((9, 30), bool))
    with pytest.raises(TypeError, match='colour'):
        quench.tree(image, colour=3)
    with pytest.raises(quench.UsageError, match='.swc'):
        quench.read_tree('x.doc')
    with pytest.raises(quench.Error, match='does not exist'):
        quench.read_tree('absent.swc')
