# SPDX-License-Identifier: Apache-2.0
"""Skeletons, graphs, pictures and label images."""
import csv
import json
import os
import re

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs, plate_with_tunnel


def tube_skeleton(**options):
    return quench.medial_axis(bent_tube(), **options).skeleton('inf', '20%')


def test_curves_of_a_bent_tube():
    skeleton = tube_skeleton(spacing=(1, 1, 1))
    table = skeleton.branches()
    longest = table['length'].argmax()
    assert 38 + 20 - 8 < table['length'].sum() < 38 + 24 + 8
    assert 1.8 < table['mean_radius'][longest] < 3.3
    ends = np.concatenate([skeleton.graph().paths[longest][[0, -1]]])
    assert np.ptp(ends[:, 2]) < 2 and skeleton.sheets.faces.shape == (0, 3)
    curves = skeleton.curves
    assert len(curves.vertices) == len(curves.radius) and curves.edges.max() < len(curves.vertices)
    assert len(curves.edges) == len(curves.vertices) - 1 and len(curves.erosion_thickness) == len(curves.edges)


def test_lengths_follow_the_spacing_of_their_axis():
    one, other = tube_skeleton(), tube_skeleton(spacing=2)
    assert other.branches()['length'].sum() == pytest.approx(2 * one.branches()['length'].sum())
    assert np.allclose(np.sort(other.branches()['x'] if 'x' in other.branches() else other.branches()['from_x']),
                       2 * np.sort(one.branches()['from_x']))


def test_sheets_of_a_plate():
    axis = quench.medial_axis(plate_with_tunnel(), detail=0)
    skeleton = axis.skeleton(0.05, 'inf')
    sheets = skeleton.sheets
    assert len(sheets.faces) > 100 and np.allclose(sheets.vertices[:, 2], 5)
    corner = sheets.vertices[sheets.faces]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum() / 2
    assert 200 < area < 30 * 24 and (sheets.erosion_thickness >= skeleton.theta2 - 1e-9).mean() > 0.5
    assert skeleton.topology.betti == (1, 1, 0)
    assert skeleton.verify(), skeleton.verify()


def test_closed_pockets_never_burn():
    image = np.ones((15, 14, 13), bool)
    image[6:9, 6:9, 6:8] = False
    axis = quench.medial_axis(image)
    et = axis.erosion_thickness()
    assert axis.topology.betti == (1, 0, 1) and np.isinf(et).any() and (et >= 0).all()
    assert axis.skeleton('inf', 'inf').topology.betti == (1, 0, 1)


def test_burning_is_kept_and_the_same():
    image = blobs(20)
    axis = quench.medial_axis(image)
    et = axis.erosion_thickness().copy()
    first = axis.skeleton(0.05, 0.02)
    again = axis.skeleton(0.05, 0.02)
    fresh = quench.medial_axis(image, threads=1).skeleton(0.05, 0.02)
    axis.forget()
    forgotten = axis.skeleton(0.05, 0.02)
    for other in (again, fresh, forgotten):
        assert np.array_equal(first.vertices, other.vertices) and np.array_equal(first.edges, other.edges)
    assert np.array_equal(axis.erosion_thickness(), et)
    assert np.allclose(axis.burn_time() - axis.radius, et)
    finer = axis.erosion_thickness(omega='0.1vox')
    assert np.nanmedian(np.abs(finer - et)[np.isfinite(et)]) < 0.05 and not np.array_equal(finer, et)


def test_fire_as_windows_is_exact_and_stays_with_the_file(tmp_path):
    axis = quench.medial_axis(blobs(20))
    exact = axis.erosion_thickness(propagation='windows').copy()
    near, far = (np.abs(axis.erosion_thickness(omega=omega) - exact) for omega in ('0.1vox', '1vox'))
    burned = np.isfinite(exact)
    assert near[burned].mean() < far[burned].mean() / 3
    assert np.allclose(axis.erosion_thickness('1vox', propagation='windows')[burned], exact[burned], atol=1e-3)  # rounded
    wanted = axis.skeleton(0.05, 0.02, propagation='windows')
    axis.save(tmp_path / 'burned.vtp')
    found = quench.read(tmp_path / 'burned.vtp')
    assert np.array_equal(found.erosion_thickness()[burned], exact[burned])
    assert np.array_equal(found.skeleton(0.05, 0.02).edges, wanted.edges)
    with pytest.raises(quench.UsageError, match="propagation='waves' is not one of"):
        axis.burn_time(propagation='waves')
    with pytest.raises(quench.UsageError, match='^propagation='):
        quench.medial_axis(np.ones((20, 30), bool)).burn_time(propagation='windows')


def test_a_burned_file_is_not_burned_again(tmp_path):
    axis = quench.medial_axis(blobs(20))
    axis.erosion_thickness(omega='0.4vox')
    axis.save(tmp_path / 'burned.vtp')
    wanted = axis.skeleton(0.05, 0.02, omega='0.4vox')
    axis.save(tmp_path / 'with_skeletons.vtp')
    assert (tmp_path / 'burned.vtp').read_bytes() == (tmp_path / 'with_skeletons.vtp').read_bytes()
    found = quench.read(tmp_path / 'burned.vtp')
    skeleton = found.skeleton(0.05, 0.02)  # with the omega of the file
    # Without the shape, which says what is inside, branches are smoothed less.
    for of in (lambda s: s.sheets.vertices, lambda s: s.edges, lambda s: s.curves.erosion_thickness, lambda s: s.curves.branch):
        assert np.array_equal(of(skeleton), of(wanted))
    assert np.array_equal(found.erosion_thickness(), axis.erosion_thickness(omega='0.4vox'))
    found.save(tmp_path / 'again.vtp')
    assert (tmp_path / 'again.vtp').read_bytes() == (tmp_path / 'burned.vtp').read_bytes()
    # What is kept is of these radii only.
    rows = np.column_stack([axis.vertices, axis.radius * 1.01])
    (tmp_path / 'other.r').write_text(f'{len(rows)}\n' + '\n'.join(' '.join(map(repr, map(float, row))) for row in rows))
    other = quench.read(tmp_path / 'burned.vtp', radii=tmp_path / 'other.r')
    with pytest.warns(UserWarning, match='does not fit its medial axis'):
        other.skeleton(0.05, 0.02)


def test_graph_as_table_networkx_and_file(tmp_path):
    networkx = pytest.importorskip('networkx')
    skeleton = quench.medial_axis(blobs(21)).skeleton('inf', '1vox')
    graph = skeleton.graph()
    nodes, branches = graph.nodes, graph.branches
    net = skeleton.to_networkx()
    assert net.number_of_nodes() == len(nodes['x']) and net.number_of_edges() == len(branches['length'])
    assert networkx.number_connected_components(net) == skeleton.topology.betti[0]
    loops = net.number_of_edges() - net.number_of_nodes() + networkx.number_connected_components(net)
    assert loops == skeleton.topology.betti[1]
    for b, path in enumerate(graph.paths):
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert steps == pytest.approx(branches['length'][b])
        assert np.allclose(path[0], [nodes[a][branches['from'][b]] for a in 'xyz'])
        assert len(path) == len(graph.radii[b])
    graph.save(tmp_path / 'b.csv')
    with open(tmp_path / 'b.csv', newline='') as file:
        rows = list(csv.DictReader(file))
    assert [float(row['length']) for row in rows] == pytest.approx(list(branches['length']))
    assert [row['to_kind'] for row in rows] == list(branches['to_kind'])
    skeleton.save(tmp_path / 'b.graphml')
    assert networkx.read_graphml(tmp_path / 'b.graphml', force_multigraph=True).number_of_edges() == len(rows)
    report = graph.save(tmp_path / 'b.swc', root=(0, 0, 0))
    samples = [line for line in (tmp_path / 'b.swc').read_text().splitlines() if line and line[0] != '#']
    assert report['samples'] == len(samples) and report['cuts'] == loops
    assert {line.split()[1] for line in samples} == {'3'}  # programs for neurons refuse 0
    for given, number in (('axon', '2'), (7, '7'), (np.int64(5), '5')):
        skeleton.save(tmp_path / 'b.swc', swc_type=given)
        assert {line.split()[1] for line in (tmp_path / 'b.swc').read_text().splitlines() if line[0] != '#'} == {number}
    for wrong in ('twig', -1, 2.5, 256, True):
        with pytest.raises(quench.Error, match='swc_type'):
            skeleton.save(tmp_path / 'b.swc', swc_type=wrong)
    assert len(skeleton.graph(smooth=0, resample='1vox').branches['length']) > 0
    curves = skeleton.curves
    pieces = np.linalg.norm(np.diff(curves.vertices[curves.edges], axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(np.bincount(curves.branch, pieces), graph.branches['length'])  # the same branches
    axis = skeleton.axis
    pruned = axis.skeleton('inf', theta1='0.2r', tips='pruned')
    assert pruned.theta1_radii == 0.2
    assert sum(pruned.branches()['length']) <= sum(axis.skeleton('inf', theta1='0.2r').branches()['length'])
    with pytest.raises(quench.Error, match='tips'):
        axis.skeleton(tips='x')
    with pytest.raises(quench.Error, match='theta1'):
        axis.skeleton(theta1='xr')


def test_pandas():
    pandas = pytest.importorskip('pandas')
    frame = pandas.DataFrame(tube_skeleton().branches())
    assert {'length', 'mean_radius', 'from_kind'} <= set(frame.columns) and len(frame) > 0


def test_formats(tmp_path):
    axis = quench.medial_axis(plate_with_tunnel())
    skeleton = axis.skeleton()
    for name in ('a.vtp', 'a.ply', 'a.obj', 'a.ma', 'a.r', 'a.csv'):
        axis.save(tmp_path / name)
    for name in ('s.vtp', 's.ply', 's.obj', 's.csv', 's.swc', 's.graphml'):
        skeleton.save(str(tmp_path / name))
    assert all(os.path.getsize(tmp_path / name) > 10 for name in os.listdir(tmp_path))
    for value in (axis, skeleton):
        with pytest.raises(quench.Error) as caught:
            value.save(tmp_path / 'x.foo')
        assert caught.value.code == 2
        with pytest.raises(FileNotFoundError, match='no folder') as caught:
            value.save(tmp_path / 'no folder' / 'x.vtp')
        assert isinstance(caught.value, quench.Error) and caught.value.code == 1


def test_pictures(tmp_path):
    pyplot = pytest.importorskip('matplotlib.pyplot')
    axis = quench.medial_axis(plate_with_tunnel())
    for number, value in enumerate((axis, axis.skeleton(), axis.skeleton('inf'), tube_skeleton())):
        value.save(tmp_path / f'{number}.png')
        image = pyplot.imread(tmp_path / f'{number}.png')
        channels = np.round(255 * image).astype(np.uint32).reshape(-1, image.shape[2])
        assert len(np.unique(channels @ 256**np.arange(image.shape[2], dtype=np.uint32))) > 100
    assert pyplot.get_fignums() == []


def test_pages(tmp_path):
    from quench import _core
    axis = quench.medial_axis(plate_with_tunnel())
    values = [axis, axis.skeleton(), quench.skeletonize(plate_with_tunnel())[1]]
    if not _core.has_pages:
        with pytest.raises(quench.Error, match='interactive page'):
            axis.save(tmp_path / 'x.html')
        pytest.skip('this build has no interactive page')
    for number, value in enumerate(values):
        value.save(tmp_path / f'page {number}.html')
        text = (tmp_path / f'page {number}.html').read_text(encoding='utf-8')
        meta = json.loads(re.search(r'id="quench-meta">(.*?)</script>', text, re.S).group(1))
        names = {array['name'] for array in meta['arrays']}
        assert meta['title'] == f'page {number}' and 'shape/points' in names
        assert meta.get('pruning', {}).get('measure') == ('detail' if number < 2 else None)
        assert [layer + '/points' in names for layer in ('core', 'skeleton', 'family', 'still')] == \
            [number < 2, number >= 1, number == 1, False]
    axis.save(tmp_path / 'a.vtp')
    quench.read(tmp_path / 'a.vtp').save(tmp_path / 'b.html')
    written = (tmp_path / 'b.html').read_text(encoding='utf-8')
    assert '"pruning"' in written and '"measures": [{"name": "detail"' in written
    axis.save(tmp_path / 'foreign.ma')
    quench.read(tmp_path / 'foreign.ma').save(tmp_path / 'c.html')
    assert '"pruning"' not in (tmp_path / 'c.html').read_text(encoding='utf-8')


@pytest.mark.parametrize('module', ['trimesh', 'pyvista'])
def test_packages_that_are_asked_for(module):
    import importlib.util
    skeleton = quench.medial_axis(plate_with_tunnel()).skeleton()
    convert = getattr(skeleton, f'to_{module}')
    if importlib.util.find_spec(module) is None:
        with pytest.raises(quench.Error, match=module) as caught:
            convert()
        assert caught.value.code == 1
        pytest.skip(f'{module} is not installed')
    convert()


def label_image():
    image = np.zeros((60, 50, 40), np.uint16)
    image[5:55, 4:9, 4:9] = 300
    image[10:40, 20:40, 10:14] = 7
    image[45:55, 30:45, 20:38] = 12
    image[48:52, 35:40, 25:30] = 7  # inside 12: another part of 7, and a cavity of 12
    image[1, 1, 1] = 2
    return image


@pytest.mark.parametrize('order', ['C', 'F'])
@pytest.mark.parametrize('threads', [1, 3])
def test_labels(order, threads):
    image = label_image().astype(np.uint16, order=order)
    found = quench.skeletonize(image, spacing=(1, 2, 0.5), threads=threads)
    assert list(found) == [2, 7, 12, 300]
    for label, skeleton in found.items():
        alone = quench.medial_axis(image == label, spacing=(1, 2, 0.5)).skeleton('inf')
        assert skeleton.topology == alone.topology
        assert np.array_equal(skeleton.edges, alone.edges) and np.allclose(skeleton.vertices, alone.vertices)
        assert np.allclose(skeleton.radius, alone.radius)
        volume = skeleton.to_volume()
        assert volume.shape == image.shape and volume.any() and (image[volume] == label).all()
        assert skeleton.branches()['length'].sum() == pytest.approx(alone.branches()['length'].sum())
    by_lambda = quench.skeletonize(image, labels=[7], spacing=(1, 2, 0.5), lambda_=0, threads=threads)[7]
    alone = quench.medial_axis(image == 7, spacing=(1, 2, 0.5), lambda_=0).skeleton('inf')
    assert np.array_equal(by_lambda.edges, alone.edges) and np.allclose(by_lambda.vertices, alone.vertices)
    assert found[7].topology.betti == (2, 0, 0) and found[12].topology.betti == (1, 0, 1)


def test_labels_are_the_same_for_any_number_of_threads():
    image = label_image()
    one, four = (quench.skeletonize(image, threads=n) for n in (1, 4))
    for label in one:
        assert np.array_equal(one[label].vertices, four[label].vertices)
        assert np.array_equal(one[label].edges, four[label].edges)


def test_chosen_labels():
    image = label_image()
    assert list(quench.skeletonize(image, labels=[300, 7, 7])) == [7, 300]
    assert list(quench.skeletonize(image, labels=[0], theta1='inf')) == [0]
    assert quench.skeletonize(image, labels=[]) == {}
    assert quench.skeletonize(np.zeros((4, 4, 4), int)) == {}
    assert list(quench.skeletonize(image > 0)) == [1]
    assert list(quench.skeletonize(-image.astype(np.int32), labels=[-12])) == [-12]
    for call in (lambda: quench.skeletonize(image, labels=[5]), lambda: quench.skeletonize(image, labels='some'),
                 lambda: quench.skeletonize(image.astype(float)), lambda: quench.skeletonize(image, labels=[1.5]),
                 lambda: quench.skeletonize(image, theta2='x')):
        with pytest.raises(quench.Error):
            call()


def test_labels_of_a_file(tmp_path):
    image = label_image()
    np.save(tmp_path / 'l.npy', np.asfortranarray(image))
    found = quench.skeletonize(tmp_path / 'l.npy', spacing=2.0)
    wanted = quench.skeletonize(image, spacing=2.0)
    assert list(found) == list(wanted) and np.allclose(found[7].vertices, wanted[7].vertices)
    found[7].save(tmp_path / '7.vtp')
    found[7].save(tmp_path / '7.swc')
    assert found[7].axis is None


@pytest.mark.parametrize('seed', range(6))
def test_skeletons_with_cut_polygons_verify(seed):
    """What is left of a polygon need not be convex; its boundary goes around it once."""
    certificate = quench.medial_axis(blobs(seed)).skeleton().verify()
    assert certificate, certificate
