# SPDX-License-Identifier: Apache-2.0
"""Meshes, files, lengths, and what is no input."""
import math
import os
import subprocess
import types
import warnings

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs

DATA = os.environ.get('QUENCH_DATA', '')
PROGRAM = os.environ.get('QUENCH_PROGRAM', '')


def data(name):
    path = os.path.join(DATA, name)
    if not os.path.exists(path):
        pytest.skip(f'{path} is not there')
    return path


def box(sides=(3.0, 2.0, 1.0), at=(10.0, 20.0, 30.0)):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * sides + at
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array(quads)


def same(a, b):
    return np.array_equal(a.vertices, b.vertices) and np.array_equal(a.radius, b.radius)


def test_forms_of_a_mesh():
    vertices, quads = box()
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    padded = np.insert(triangles, 0, 3, axis=1).ravel()
    wanted = quench.medial_axis((vertices, triangles), resolution=30)
    low, high = wanted.vertices.min(axis=0), wanted.vertices.max(axis=0)
    assert (low > [10, 20, 30]).all() and (high < [13, 22, 31]).all() and wanted.longest_side == 3
    assert high[0] - low[0] > 2 * (high[2] - low[2])
    for form in ((vertices, quads), [vertices.tolist(), triangles.tolist()], (vertices, triangles.astype(np.uint8)),
                 (np.asfortranarray(vertices), np.asfortranarray(triangles)), (vertices, triangles[:, ::-1]),
                 types.SimpleNamespace(vertices=vertices, faces=triangles),
                 types.SimpleNamespace(points=vertices, faces=padded), quench.Mesh(vertices, triangles)):
        assert same(quench.medial_axis(form, resolution=30), wanted)


@pytest.mark.parametrize('bad, word', [
    ((np.zeros((3, 2)), [[0, 1, 2]]), r'\(V, 3\)'), ((np.eye(3), [[0, 1]]), r'\(F, 3\)'), ((np.eye(3), [[0, 1, 3]]), 'vertex 3'),
    ((np.eye(3), [[0, 1, -1]]), 'vertex -1'), ((np.eye(3), [[0.0, 1, 2]]), 'float'), ((np.eye(3), [[0, 1, 2]]), ''),
    ((np.eye(3), [0, 1, 2, 0, 1]), ''), ((np.full((3, 3), np.nan), [[0, 1, 2]]), ''), (('a', 'b'), 'numbers')])
def test_meshes_that_are_none(bad, word):
    with pytest.raises(quench.Error, match=word) as caught:
        quench.medial_axis(bad, resolution=20)
    assert caught.value.code == 3


@pytest.mark.parametrize('vertices', [
    np.eye(3) + 1j, np.eye(3).astype(np.complex64), [[0, 0, 1j], [1, 0, 0], [0, 1, 0]], np.eye(3).astype(str),
    np.eye(3).astype('datetime64[s]'), [[0, 0, 0], [1, 0], [0, 1, 0]], [['a', 0, 0], [1, 0, 0], [0, 1, 0]]])
@pytest.mark.filterwarnings('error')
def test_vertices_that_are_no_real_numbers(vertices):
    with pytest.raises(quench.Error, match='the vertices of the mesh are not real numbers') as caught:
        quench.medial_axis((vertices, [[0, 1, 2]]), resolution=20)
    assert caught.value.code == 3


@pytest.mark.parametrize('faces, vertex', [
    (np.array([[0, 1, 2], [0, 1, 2**64 - 1]], np.uint64), 2**64 - 1), (np.array([[0, 1, 2], [0, 2**63, 1]], np.uint64), 2**63),
    (np.array([[0, 1, 2], [-2**31, 1, 2]], np.int32), -2**31), (np.array([[0, 1, 2], [0, 2**32, 1]]), 2**32),
    (np.array([3, 0, 1, 2, 3, 0, 1, 2**63 + 5], np.uint64), 2**63 + 5), ([[0, 1, 2, 3], [0, 1, 2, 7]], 3)])
def test_corners_beyond_the_vertices(faces, vertex):
    with pytest.raises(quench.Error, match=f'names vertex {vertex}, and there are 3 vertices') as caught:
        quench.medial_axis((np.eye(3), faces), resolution=20)
    assert caught.value.code == 3


@pytest.mark.parametrize('faces', [[[0, 1, 2.5]], [[0, 1, 1j]], [['0', '1', '2']], [[True, False, True]]])
def test_corners_that_are_no_whole_numbers(faces):
    with pytest.raises(quench.Error, match='faces are of type') as caught:
        quench.medial_axis((np.eye(3), faces), resolution=20)
    assert caught.value.code == 3


def test_fields_of_a_file_that_cannot_be(tmp_path):
    def field(name, *values):
        return f'<DataArray type="Float64" Name="{name}" NumberOfTuples="{len(values)}" format="ascii">' \
               f'{" ".join(map(str, values))}</DataArray>'
    text = ('<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData><FieldData>'
            + field('longest_side', -5) + field('spacing', 1, 0, 1) + '</FieldData>'
            '<Piece NumberOfPoints="3" NumberOfPolys="1"><Points><DataArray type="Float64" NumberOfComponents="3" '
            'format="ascii">0 0 0 3 0 0 0 1 0</DataArray></Points><PointData><DataArray type="Float64" Name="radius" '
            'format="ascii">1 1 {}</DataArray></PointData><Polys><DataArray type="Int32" Name="connectivity" '
            'format="ascii">0 1 2</DataArray><DataArray type="Int32" Name="offsets" format="ascii">3</DataArray></Polys>'
            '</Piece></PolyData></VTKFile>')
    (tmp_path / 'a.vtp').write_text(text.format('1'))
    with pytest.warns(UserWarning) as told:
        axis = quench.read(tmp_path / 'a.vtp')
    sentences = ' '.join(str(warning.message) for warning in told)
    assert "'longest_side' of" in sentences and "'spacing' of" in sentences and 'a.vtp' in sentences
    assert axis.longest_side == 3
    (tmp_path / 'b.vtp').write_text(text.format('1e308'))
    with pytest.raises(quench.Error, match='vertex 2') as caught:
        quench.read(tmp_path / 'b.vtp')
    assert caught.value.code == 3


def test_arguments_of_the_other_kind():
    with pytest.raises(quench.Error, match='for images') as caught:
        quench.medial_axis(box(), spacing=2)
    assert caught.value.code == 2


@pytest.mark.parametrize('spacing', [0, -1, math.nan, math.inf, (1, 2), (1, 2, 3, 4), 'x', (1, 0, 1), [[1, 2, 3]],
                                     1 + 1j, np.array([1, 1, 1 + 1j]), ('1', '1', '1')])
def test_spacings_that_are_none(spacing):
    with pytest.raises(quench.Error, match='voxel size') as caught:
        quench.medial_axis(bent_tube(), spacing=spacing)
    assert caught.value.code == 2


def test_lengths():
    image = bent_tube()
    side = 41.0  # of the box of the foreground
    for given, wanted in ((0.1, 0.1 * side), ('10%', 0.1 * side), ('2vox', 2.0), ('1.5abs', 1.5), (0, 0),
                          (np.float32(0.125), 0.125 * side), (math.inf, math.inf), ('inf', math.inf)):
        axis = quench.medial_axis(image, lambda_=given)
        assert axis.lambda_ == pytest.approx(wanted) and axis.longest_side == side
    skeleton = axis.skeleton('4vox', '2abs')
    assert (skeleton.theta2, skeleton.theta1) == (4, 2)
    skeleton = quench.medial_axis(image).skeleton()  # of a small shape not 0.03 and 0.02 of its side
    assert (skeleton.theta2, skeleton.theta1) == pytest.approx((1.5 * math.sqrt(3), 2.25 * math.sqrt(3)))
    skeleton = quench.medial_axis(np.ones((200, 4, 3), bool)).skeleton('auto', theta1='auto')
    assert (skeleton.theta2, skeleton.theta1) == pytest.approx((6, 2.25 * math.sqrt(3)))
    assert quench.medial_axis(image, spacing=(1, 2, 4), lambda_='1vox').lambda_ == 1
    assert quench.medial_axis(image, spacing=(1, 2, 4)).longest_side == 50
    assert quench.medial_axis(image, spacing=(1, 2, 4), detail='1vox').detail == 1
    for bad in (-1, 'x', '3 m', True, math.nan, [1]):
        for argument in ('detail', 'lambda_'):
            with pytest.raises(quench.Error, match=argument) as caught:
                quench.medial_axis(image, **{argument: bad})
            assert caught.value.code == 2
    with pytest.raises(quench.Error):
        axis.skeleton(theta2=-0.1)
    with pytest.raises(quench.Error, match='omega'):
        axis.erosion_thickness(omega=0)
    with pytest.raises(quench.Error, match='threads'):
        quench.medial_axis(image, threads=-1)


def test_pruning_later_is_pruning_at_once():
    image = blobs(9)
    full = quench.medial_axis(image, lambda_=0)
    for given in ('0.9vox', '1.2vox', 0.1, 'inf'):
        assert same(full.pruned(given), quench.medial_axis(image, lambda_=given))
        kept = full.vertex_lambda_level >= quench.medial_axis(image, lambda_=given).lambda_
        assert kept.sum() == len(full.pruned(given).vertices)
    assert len(full.face_lambda_level) == len(full.faces)
    with pytest.raises(quench.Error, match='below'):
        full.pruned('2vox').pruned('1vox')


def test_axes_are_pruned_by_detail_unless_lambda_is_given():
    image, spacing = blobs(9), np.array([1, 0.5, 2])
    axis = quench.medial_axis(image, spacing=spacing)
    diagonal = np.linalg.norm(spacing)
    assert axis.detail == pytest.approx(diagonal / 2) and axis.lambda_ is None
    assert 0 <= axis.coverage <= diagonal * (1 + 1e-9)
    assert same(axis, quench.medial_axis(image, spacing=spacing, detail=f'{axis.detail!r}abs'))
    other = quench.medial_axis(image, spacing=spacing, lambda_='auto')
    assert other.lambda_ > 0 and other.detail is None and other.coverage is None
    assert not same(axis, other) and axis.topology == other.topology
    whole, by_lambda = (quench.medial_axis(image, **{argument: 0}) for argument in ('detail', 'lambda_'))
    assert same(whole, by_lambda) and whole.coverage == 0
    for given in (0, 0.02, '2vox', 'inf'):
        with pytest.raises(quench.UsageError, match='two measures') as caught:
            quench.medial_axis(image, detail=given, lambda_='auto')
        assert caught.value.argument == 'lambda_' and 'detail=' in str(caught.value)
        with pytest.raises(quench.UsageError, match='two measures'):
            quench.skeletonize(image, detail=given, lambda_=0)


def test_pruning_by_detail_later_is_pruning_at_once():
    image = blobs(9)
    full = quench.medial_axis(image, detail=0)
    for given in ('0.7vox', '1.2vox', 0.1, 'inf'):
        at_once, later = quench.medial_axis(image, detail=given), full.pruned(detail=given)
        assert same(later, at_once) and same(full.pruned(given), at_once)
        assert (later.detail, later.coverage) == (at_once.detail, at_once.coverage)
        assert at_once.coverage <= max(2 * at_once.detail, math.sqrt(3)) + 1e-9
        assert (full.vertex_detail_level >= at_once.detail * (1 - 1e-12)).sum() == len(at_once.vertices)
    assert len(full.face_detail_level) == len(full.faces) and len(full.edge_detail_level) == len(full.edges)
    with pytest.raises(quench.UsageError, match='^detail=.* is below') as caught:
        full.pruned('2vox').pruned('1vox')
    assert caught.value.argument == 'detail'


def test_a_threshold_of_the_other_measure_is_refused():
    by_detail, by_lambda = quench.medial_axis(blobs(9)), quench.medial_axis(blobs(9), lambda_=0)
    assert same(by_lambda.pruned(lambda_='1vox'), by_lambda.pruned('1vox'))
    for axis, argument in ((by_detail, 'lambda_'), (by_lambda, 'detail')):
        with pytest.raises(quench.UsageError, match=f'^{argument}=.*not pruned') as caught:
            axis.pruned(**{argument: '3vox'})
        assert caught.value.argument == argument
    for given in ((), (0.1, 0.1)):
        with pytest.raises(quench.UsageError, match='one threshold, of detail'):
            by_detail.pruned(*given[:1], **({'detail': given[1]} if given else {}))


def test_measures_have_values_and_levels_by_name():
    axis = quench.medial_axis(blobs(9), detail=0)
    assert list(axis.measures) == ['lambda', 'detail', 'object_angle', 'cap_height']
    values, levels = axis.measures['detail']
    assert np.array_equal(levels.vertices, axis.vertex_detail_level) and np.array_equal(levels.edges, axis.edge_detail_level)
    assert np.array_equal(levels.polygons[axis.face_polygon], axis.face_detail_level)
    assert len(values.polygons) == len(axis.polygons[0]) - 1 and (values.vertices[~np.isinf(levels.vertices)] >= 0).all()
    height = axis.measures['cap_height']
    least = np.minimum.reduceat(axis.radius[axis.polygons[1]], axis.polygons[0][:-1])
    half = np.minimum(axis.measures['lambda'].values.polygons, least)
    assert height.levels is None and np.allclose(height.values.polygons, least - np.sqrt(least**2 - half**2))
    assert axis.measures['lambda'].levels is None and len(axis.face_lambda) == len(axis.faces)
    with pytest.raises(quench.UsageError, match='no levels of it') as caught:
        axis.face_lambda_level
    assert caught.value.argument == 'lambda_'

    axis = quench.medial_axis(blobs(9), lambda_=0)
    assert list(axis.measures) == ['lambda', 'object_angle', 'cap_height']
    with pytest.raises(quench.UsageError, match='not pruned by detail'):
        axis.vertex_detail_level
    values, levels = axis.measures['lambda']
    assert np.array_equal(levels.vertices, axis.vertex_lambda_level) and np.array_equal(levels.edges, axis.edge_lambda_level)
    assert np.array_equal(levels.polygons[axis.face_polygon], axis.lambda_level)
    assert np.array_equal(values.polygons[axis.face_polygon], axis.face_lambda)
    angle = axis.measures['object_angle']
    assert angle.levels is None and len(angle.values.edges) == len(axis.edges)
    wanted = 2 * np.degrees(np.arcsin(np.clip(values.vertices / axis.radius, 0, 1)))
    assert np.allclose(angle.values.vertices, wanted)
    assert 'no such' not in axis.measures
    with pytest.raises(KeyError):
        axis.measures['no such']


def test_cleaning():
    image = np.zeros((30, 20, 10), bool)
    image[2:20, 2:18, 2:8] = True
    image[6:9, 6:9, 4:6] = False
    image[24:28, 4:8, 4:8] = True
    assert quench.medial_axis(image).topology.betti == (2, 0, 1)
    assert quench.medial_axis(image, largest_component=True).topology.betti == (1, 0, 1)
    assert quench.medial_axis(image, min_component=65, fill_cavities=True).topology.betti == (1, 0, 0)
    assert quench.medial_axis(image, invert=True).topology.betti[0] == 2
    fine = quench.medial_axis(image, subdivide=2, lambda_=0)
    assert fine.topology.betti == (2, 0, 1) and fine.vertices.max() < 28
    assert fine.reconstruct().shape == image.shape
    with pytest.raises(quench.Error, match='cannot be combined'):
        quench.medial_axis(image, threshold=1, label=1)
    with pytest.warns(UserWarning, match='took 20% of the shape'):
        quench.medial_axis(blobs_of(80, 20), largest_component=True)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        quench.medial_axis(blobs_of(98, 2), largest_component=True)


def blobs_of(*sizes):
    """Bars of so many voxels, apart."""
    image = np.zeros((2 * len(sizes) + 1, 3, max(sizes) + 2), bool)
    for i, size in enumerate(sizes):
        image[2 * i + 1, 1, 1:size + 1] = True
    return image


def test_whole_thresholds_are_exact():
    odd = 2**53 + 1  # no float
    for dtype, values in ((np.int64, (odd - 1, odd)), (np.uint64, (2**64 - 2, 2**64 - 1))):
        image = np.array(values, dtype).reshape(2, 1, 1)
        for least, voxels in zip(values, (2, 1)):
            for threshold in (least, dtype(least)):
                assert len(quench.medial_axis(image, threshold=threshold, lambda_=0).vertices) == voxels
        axis = quench.medial_axis(image, threshold=values[1], lambda_=0)
        assert axis.verify()
    for wrong in (2**64, -2**64, 10**400, 'high', [1]):
        with pytest.raises(quench.Error, match='threshold='):
            quench.medial_axis(image, threshold=wrong)


def test_files_and_arrays_say_the_same(tmp_path):
    image = blobs(11)
    path = tmp_path / 'räume 1.npy'
    np.save(path, np.asfortranarray(image.astype(np.uint8)))  # axis 0 is x where it is the closest in memory
    volume = quench.read(path)
    assert np.array_equal(np.asarray(volume), image) and volume.array.flags.f_contiguous
    wanted = quench.medial_axis(image, spacing=(1, 2, 3))
    assert same(quench.medial_axis(path, spacing=(1, 2, 3)), wanted)
    assert same(quench.medial_axis(str(path), spacing=(1, 2, 3)), wanted)
    assert same(quench.medial_axis(volume, spacing=(1, 2, 3)), wanted)


def test_what_is_written_is_read(tmp_path):
    axis = quench.medial_axis(blobs(12))
    axis.erosion_thickness()
    for name in ('a.vtp', 'a.ply', 'a.ma'):
        axis.save(tmp_path / name)
        back = quench.read(tmp_path / name)
        assert back.topology == axis.topology and np.allclose(back.vertices, axis.vertices, atol=1e-5)
        assert np.allclose(back.radius, axis.radius, atol=1e-5)
    back = quench.read(tmp_path / 'a.vtp')
    assert np.allclose(back.erosion_thickness(), axis.erosion_thickness(), atol=1e-4)
    assert len(back.skeleton('inf', '3vox').vertices) > 0
    assert (back.detail, back.coverage, back.lambda_) == (axis.detail, axis.coverage, None)
    foreign = quench.read(tmp_path / 'a.ma')
    assert (foreign.detail, foreign.coverage, foreign.lambda_) == (None, None, None)
    for call in (back.verify, back.reconstruct, lambda: back.pruned(1), lambda: back.face_lambda_level,
                 lambda: back.face_detail_level, lambda: foreign.pruned(1)):
        with pytest.raises(quench.Error, match='from a file'):
            call()
    quench.medial_axis(blobs(12), lambda_='1vox').save(tmp_path / 'lambda.vtp')
    back = quench.read(tmp_path / 'lambda.vtp')
    assert (back.detail, back.coverage, back.lambda_) == (None, None, 1)
    with pytest.raises(quench.Error, match='medial axis already'):
        quench.medial_axis(tmp_path / 'a.vtp')


def test_files_that_are_none(tmp_path):
    (tmp_path / 'empty.ply').write_text('')
    (tmp_path / 'odd.xyz').write_text('1 2 3')
    for name, code in (('none.nrrd', 1), ('empty.ply', 3), ('odd.xyz', 3)):
        with pytest.raises(quench.Error, match=name) as caught:
            quench.medial_axis(tmp_path / name)
        assert caught.value.code == code
    np.save(tmp_path / 'many.npy', np.arange(27, dtype=np.uint8).reshape(3, 3, 3))
    with pytest.raises(quench.Error, match='many.npy.*more than two values'):
        quench.medial_axis(tmp_path / 'many.npy')


def test_the_program_verifies_what_is_saved(tmp_path):
    if not os.path.exists(PROGRAM):
        pytest.skip('the program is not built')
    image = bent_tube()
    np.save(tmp_path / 'v.npy', np.asfortranarray((image * 7).astype(np.uint8)))
    axis = quench.medial_axis(tmp_path / 'v.npy', threshold=5, spacing=(1, 1, 2))
    axis.save(tmp_path / 'axis.vtp')
    axis.skeleton('inf').save(tmp_path / 'skeleton.vtp')
    done = subprocess.run([PROGRAM, 'verify', tmp_path / 'v.npy', tmp_path / 'axis.vtp', tmp_path / 'skeleton.vtp'],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_world_coordinates_of_a_file():
    axis = quench.medial_axis(data('volumes/torsoLabel.nii.gz'), label=8)
    volume = quench.read(data('volumes/torsoLabel.nii.gz'))
    index = np.linalg.solve(volume.direction, (axis.vertices - volume.origin).T).T / volume.spacing
    assert (volume.array[tuple(np.rint(index).astype(int).T)] == 8).mean() > 0.999
    assert volume.units == 'mm' and volume.spacing[2] == 5


@pytest.mark.parametrize('topology, sentence', [('voxels', 'voxelization changed the topology'),
                                                ('mesh', 'for the topology of the mesh')])
def test_warnings_of_the_library(topology, sentence):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter('always')
        quench.medial_axis(quench.sample('four-blobs'), resolution=32, topology=topology)
    assert len(caught) == 1 and caught[0].category is UserWarning and caught[0].filename == __file__
    assert sentence in str(caught[0].message)


def test_samples():
    for name in quench.samples():
        mesh = quench.sample(name, fineness=0.3)
        assert mesh.faces.max() < len(mesh.vertices)
    root = quench.sample('root', branches=7)
    assert len(root.branches) == 7 and root.branches[0]['points'].shape[1] == 3
    with pytest.raises(quench.Error, match='torus'):
        quench.sample('no such shape')
