# SPDX-License-Identifier: Apache-2.0
"""Results that were pickled, copied or sent to another process are the same, and go on being of use."""
import concurrent.futures
import copy
import dataclasses
import multiprocessing
import pickle

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs


def same(a, b):
    """Array for array, number for number."""
    if isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    elif dataclasses.is_dataclass(a):
        same(vars(a), vars(b))
    elif isinstance(a, dict):
        assert list(a) == list(b)
        for name in a:
            same(a[name], b[name])
    elif isinstance(a, (list, tuple)):
        assert len(a) == len(b)
        for x, y in zip(a, b):
            same(x, y)
    elif isinstance(a, float):
        assert a == b or (a != a and b != b)
    else:
        assert a == b


def same_cells(a, b):
    for name in ('dimension', 'units', 'vertices', 'radius', 'edges', 'edge_degree', 'polygons', 'topology'):
        same(getattr(a, name), getattr(b, name))


def same_axes(a, b):
    same_cells(a, b)
    for name in ('detail', 'lambda_', 'coverage', 'surface', 'longest_side', 'faces', 'face_polygon'):
        same(getattr(a, name), getattr(b, name))
    assert list(a.measures) == list(b.measures)
    for name in a.measures:
        same(a.measures[name], b.measures[name])


def same_skeletons(a, b):
    same_cells(a, b)
    for name in ('theta1', 'theta2', 'theta1_radii', 'sheets', 'curves'):
        same(getattr(a, name), getattr(b, name))
    same_graphs(a.graph(), b.graph())


def same_graphs(a, b):
    for name in ('nodes', 'branches', 'paths', 'radii', 'erosion_thickness', 'mgf'):
        same(getattr(a, name), getattr(b, name))


def same_files(a, b, folder, endings):
    for ending in endings:
        file = folder / ('same' + ending)  # pictures have the name
        a.save(file)
        wanted = file.read_bytes()
        b.save(file)
        assert file.read_bytes() == wanted, ending


def through(value, protocol):
    if protocol == 'deepcopy':
        return copy.deepcopy(value)
    if protocol != 'apart':
        return pickle.loads(pickle.dumps(value, protocol))
    buffers = []
    data = pickle.dumps(value, 5, buffer_callback=buffers.append)
    apart = sum(len(b.raw()) for b in buffers)
    assert apart < 100000 or len(data) < apart / 2
    return pickle.loads(data, buffers=buffers)


PROTOCOLS = [2, 5, 'deepcopy']
TWO = [4, 'apart']


def axes():
    mesh = quench.sample('torus', fineness=0.5)
    scan = blobs(21).astype(np.float32) * 3
    return {'voxels': quench.medial_axis(bent_tube(), spacing=(0.5, 0.5, 1)),
            'lambda': quench.medial_axis(blobs(21), lambda_='auto'),
            'mesh': quench.medial_axis((mesh.vertices, mesh.faces), resolution=40),
            'grey': quench.medial_axis(scan, threshold=1.5, surface='grey', blur=0.5),
            'image': quench.medial_axis(bent_tube().any(axis=2))}


@pytest.mark.parametrize('protocol', PROTOCOLS)
def test_axes_and_what_follows_from_them(protocol, tmp_path):
    for name, axis in axes().items():
        twin = through(axis, protocol)
        same_axes(axis, twin)
        same(twin.erosion_thickness(), axis.erosion_thickness())
        same_skeletons(axis.skeleton(), twin.skeleton())
        same(axis.reconstruct(), twin.reconstruct())
        same(axis.pruned('2vox' if name != 'lambda' else '3vox').radius,
             twin.pruned('2vox' if name != 'lambda' else '3vox').radius)
        assert twin.verify(samples=500), name
        same_files(axis, twin, tmp_path, ['.vtp', '.ply', '.csv'])


def test_what_is_burned_is_not_burned_again(tmp_path):
    for axis in (quench.medial_axis(bent_tube()), quench.medial_axis(bent_tube().any(axis=2))):
        burned = axis.burn_time()
        twin = through(axis, 5)
        same_files(axis, through(twin, 5), tmp_path, ['.vtp', '.png'])  # before anything is asked of it
        same(twin.burn_time(), burned)
        same_files(axis, twin, tmp_path, ['.vtp'])
        skeleton = axis.skeleton()  # a family is there
        twin = through(axis, 4)
        same_skeletons(skeleton, twin.skeleton())
        same_files(axis, twin, tmp_path, ['.vtp'])
        twin = through(axis, 4)
        twin.forget()
        same(twin.burn_time(), burned)


def test_the_burning_comes_from_the_pickle():
    axis = quench.medial_axis(blobs(21))
    burned = axis.burn_time()
    restore, (kind, small, large, shape) = axis._core.__reduce_ex__(4)
    large[-1] = large[-1][:-1] + bytes([large[-1][-1] ^ 1])
    twin = quench.MedialAxis(restore(kind, small, large, shape))
    with pytest.warns(UserWarning, match='damaged; the medial axis is burned again'):
        same(twin.burn_time(), burned)


@pytest.mark.parametrize('protocol', TWO)
def test_skeletons_graphs_parts_solids(protocol, tmp_path):
    plate = np.zeros((30, 26, 14), bool)
    plate[4:-4, 4:-4, 4:-4] = True
    plate[14:17, :, 6:8] = True
    for axis in (quench.medial_axis(plate), quench.medial_axis(plate.any(axis=2))):
        skeleton = axis.skeleton(theta1='1vox')
        twin = through(skeleton, protocol)
        same_skeletons(skeleton, twin)
        same_axes(axis, twin.axis)
        same(skeleton.reconstruct(), twin.reconstruct())
        same(skeleton.reconstructed_share(), twin.reconstructed_share())
        assert twin.verify(samples=500)
        same_files(skeleton, twin, tmp_path, ['.vtp', '.swc', '.graphml', '.png'])
        same_graphs(skeleton.graph(resample='1vox'), through(skeleton.graph(resample='1vox'), protocol))
        same_graphs(twin.graph(), skeleton.graph())
        same(through(skeleton.topology, protocol), skeleton.topology)
        same(through(skeleton.curves, protocol), skeleton.curves)
        same(through(skeleton.sheets, protocol), skeleton.sheets)
        for of in (axis, skeleton):
            solid = of.solid(envelope=True)
            other = through(solid, protocol)
            same(solid.voxels, other.voxels)
            same((solid.topology, solid.envelope, solid.errors()), (other.topology, other.envelope, other.errors()))
            if axis.dimension == 3:
                same(solid.mesh(), other.mesh())
                same_files(solid, other, tmp_path, ['.nrrd', '.ply'])
            points = np.random.default_rng(1).uniform(0, 30, (50, axis.dimension))
            same(solid.distance(points), other.distance(points))
    axis = quench.medial_axis(plate)
    skeleton = axis.skeleton()
    same(skeleton.to_volume(), through(skeleton, protocol).to_volume())
    parts = skeleton.parts(remesh='3vox')
    other = through(parts, protocol)
    for name in ('sheets', 'seams', 'junctions', 'meshes', 'vertices', 'thickness', 'faces', 'face_sheet', 'units'):
        same(getattr(parts, name), getattr(other, name))
    same(through(parts.meshes[0], protocol), parts.meshes[0])
    same_files(parts, other, tmp_path, ['.vtp', '.csv'])
    few = axis.simplified(30)
    other = through(few, protocol)
    same_axes(few.axis, other.axis)
    same((few.most, few.least, few.boundary, few.errors), (other.most, other.least, other.boundary, other.errors))
    same_axes(few.level(12), other.level(12))
    certificate = axis.verify(samples=200)
    same(through(certificate, protocol).checks, certificate.checks)


@pytest.mark.parametrize('protocol', TWO)
def test_trees(protocol, tmp_path):
    plant = np.zeros((40, 12, 50), bool)
    plant[18:23, 4:9, 2:-2] = True
    plant[5:20, 5:8, 20:23] = True
    of_array = quench.tree(plant)
    of_array.save(tmp_path / 't.swc')
    for tree in (of_array, quench.read_tree(tmp_path / 't.swc')):
        other = through(tree, protocol)
        same(list(map(tuple, tree.axes)), list(map(tuple, other.axes)))
        same(list(map(tuple, tree.branches)), list(map(tuple, other.branches)))
        same(list(map(tuple, tree.plants)), list(map(tuple, other.plants)))
        same(tree.edited, other.edited)
        for table in ('axes', 'branches', 'sample', 'sholl', 'depths', 'toporoot'):
            a, b = tree.traits(table), other.traits(table)
            assert a.attrs == b.attrs
            for name in a:
                same(np.asarray(a[name]), np.asarray(b[name]))
        same_files(tree, other, tmp_path, ['.rsml', '.swc', '.graphml', '.csv', '.png'])


@pytest.mark.parametrize('protocol', TWO)
def test_inputs_and_tables(protocol):
    volume = quench.Volume(blobs(12).astype(np.uint8), spacing=(1, 2, 3), origin=(4, 5, 6),
                           direction=[[0, 1, 0], [1, 0, 0], [0, 0, 1]], units='mm', space='LPS')
    other = through(volume, protocol)
    for name in ('array', 'spacing', 'origin', 'direction', 'units', 'space'):
        same(getattr(volume, name), getattr(other, name))
    same_axes(quench.medial_axis(volume), quench.medial_axis(other))
    mesh = quench.sample('root', branches=3, fineness=0.3)
    same(through(mesh, protocol), mesh)
    walls = quench.surface_thickness(quench.sample('ellipsoid', fineness=0.3), resolution=24)
    same(through(walls, protocol), walls)
    same(dict(through(quench.medial_axis(volume).measures, protocol)), dict(quench.medial_axis(volume).measures))


def test_labels_and_axes_from_files(tmp_path):
    image = np.zeros((40, 30, 9), np.uint16)
    image[2:-2, 2:8, 2:-2] = 3
    image[2:-2, 12:28, 2:-2] = 7
    for label, skeleton in quench.skeletonize(image).items():
        other = through(skeleton, 5)
        same_skeletons(skeleton, other)
        same(skeleton.to_volume(image.shape), other.to_volume(image.shape))
    axis = quench.medial_axis(bent_tube())
    axis.burn_time()
    axis.save(tmp_path / 'a.vtp')
    read = quench.read(tmp_path / 'a.vtp')
    other = through(read, 5)
    same_cells(read, other)
    same_skeletons(read.skeleton(), other.skeleton())
    same_files(read, other, tmp_path, ['.vtp'])
    same(read.solid().voxels, through(read.solid(), 4).voxels)


def test_what_results_share_is_pickled_once():
    axis = quench.medial_axis(blobs(21))
    skeleton = axis.skeleton()
    both = pickle.dumps((axis, skeleton, skeleton.graph(), axis.solid()), 5)
    assert len(both) < len(pickle.dumps(axis, 5)) + len(pickle.dumps(skeleton, 5))
    twin, other, graph, solid = pickle.loads(both)
    assert other.axis is twin
    alone = pickle.loads(pickle.dumps(skeleton))
    same_axes(alone.axis, axis)


def test_a_copy_shares_what_it_is_of():
    axis = quench.medial_axis(bent_tube(), progress=lambda stage, fraction: None)
    for result in (axis, axis.skeleton(), axis.solid(), axis.skeleton().graph()):
        twin = copy.copy(result)
        assert twin is not result and twin._core is result._core and type(twin) is type(result)
    assert pickle.loads(pickle.dumps(axis))._progress is False  # a function stays behind
    assert pickle.loads(pickle.dumps(quench.medial_axis(bent_tube(), threads=2)))._threads == 2


def length_of(axis):
    return float(axis.skeleton('inf').branches()['length'].sum())


def made_elsewhere(seed):
    axis = quench.medial_axis(blobs(seed))
    return axis, axis.skeleton()


def fails_elsewhere(_):
    quench.medial_axis(np.zeros((3, 3, 3), bool), lambda_='2mm')


@pytest.mark.parametrize('method', ['spawn', 'forkserver'])
def test_other_processes(method):
    context = multiprocessing.get_context(method)
    axis = quench.medial_axis(blobs(21))
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        assert list(pool.map(length_of, [axis, axis])) == [length_of(axis)] * 2
        for seed, (there, skeleton) in zip((21, 22), pool.map(made_elsewhere, (21, 22))):
            here, its = made_elsewhere(seed)
            same_axes(here, there)
            same_skeletons(its, skeleton)
        with pytest.raises(quench.UsageError) as caught:
            list(pool.map(fails_elsewhere, [0]))
        assert caught.value.code == 2 and caught.value.argument == 'lambda_'


def test_joblib(tmp_path):
    joblib = pytest.importorskip('joblib')
    skeleton = quench.medial_axis(blobs(21)).skeleton()
    joblib.dump(skeleton, tmp_path / 's.joblib', compress=1)
    same_skeletons(joblib.load(tmp_path / 's.joblib'), skeleton)
    assert joblib.hash(skeleton) == joblib.hash(pickle.loads(pickle.dumps(skeleton)))


def test_damaged_pickles_are_refused():
    axis = quench.medial_axis(bent_tube())
    restore, (kind, small, large, shape) = axis._core.__reduce_ex__(4)
    assert restore(kind, small, large, shape).vertices is not None
    for wrong in ((kind, small[:-3], large, shape), (kind, small, large[:-1], shape), (kind, small + b'x', large, shape),
                  (kind, small, [*large[:-1], large[-1][:-8]], shape), ('Skeleton', small, large, axis._core),
                  (kind, b'', large, shape)):
        with pytest.raises(quench.Error) as caught:
            restore(*wrong)
        assert caught.value.code == 3
    with pytest.raises(quench.Error, match='version'):
        restore(kind, small.replace(quench.__version__.encode(), b'9.9.9'[:len(quench.__version__)], 1), large, shape)
