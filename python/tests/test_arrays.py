# SPDX-License-Identifier: Apache-2.0
"""Images as arrays: where things are, whatever the order in memory, and what is copied."""
import gc
import warnings

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs

SPACING = (0.5, 2.0, 3.0)


def same(a, b):
    return (np.array_equal(a.vertices, b.vertices) and np.array_equal(a.radius, b.radius)
            and np.array_equal(a.edges, b.edges) and np.array_equal(a.faces, b.faces))


def test_places_are_index_times_spacing_in_the_order_of_axes():
    image = bent_tube()
    axis = quench.medial_axis(image, spacing=SPACING, lambda_=0)
    index = axis.vertices / SPACING
    assert (index.min(axis=0) >= [1.5, 1.5, 2.5]).all() and (index.max(axis=0) <= [42.5, 26.5, 7.5]).all()
    nearest = tuple(np.rint(index).astype(int).T)  # voxel centres at integers: whoever is inside rounds to the inside
    assert image[nearest].all()


@pytest.mark.parametrize('axes', [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)])
def test_transposed_images_have_transposed_axes(axes):
    image = bent_tube()
    axis = quench.medial_axis(image, spacing=SPACING, lambda_=0)
    turned = quench.medial_axis(image.transpose(axes), spacing=[SPACING[a] for a in axes], lambda_=0)

    def rows(a):
        return np.round(np.column_stack([a.vertices, a.radius]), 9)
    wanted = rows(axis)[:, [*axes, 3]]
    got = rows(turned)
    assert np.allclose(wanted[np.lexsort(wanted.T)], got[np.lexsort(got.T)])


@pytest.mark.parametrize('layout', ['C', 'F', 'reversed', 'strided', 'transposed view', 'offset'])
def test_the_order_in_memory_does_not_matter(layout):
    image = blobs(1)
    wanted = quench.medial_axis(np.ascontiguousarray(image), spacing=SPACING)
    if layout == 'C':
        given = np.ascontiguousarray(image)
    elif layout == 'F':
        given = np.asfortranarray(image)
    elif layout == 'reversed':
        given = np.ascontiguousarray(image[::-1, ::-1, ::-1])[::-1, ::-1, ::-1]
        assert min(given.strides) < 0
    elif layout == 'strided':
        room = np.ones((2 * image.shape[0], 3 * image.shape[1], 2 * image.shape[2]), bool)
        room[::2, ::3, 1::2] = image
        given = room[::2, ::3, 1::2]
    elif layout == 'transposed view':
        given = np.ascontiguousarray(image.transpose(1, 2, 0)).transpose(2, 0, 1)
    else:
        given = np.pad(image, 3, constant_values=True)[3:-3, 3:-3, 3:-3]
    assert np.array_equal(given, image)
    assert same(quench.medial_axis(given, spacing=SPACING), wanted)


@pytest.mark.parametrize('strides', ['C', 'F'])
def test_more_than_64_slices(strides):
    image = np.zeros((9, 8, 150), bool, order=strides)
    image[2:6, 2:6, 3:140] = True
    axis = quench.medial_axis(image, lambda_=0)
    assert axis.vertices[:, 2].min() < 5 and 137 < axis.vertices[:, 2].max() < 139.5
    assert axis.topology.betti == (1, 0, 0)


def test_a_broadcast_image_is_read_where_it_lies():
    plane = np.zeros((20, 15), bool)
    plane[3:-3, 4:-4] = True
    image = np.broadcast_to(plane[:, :, None], (20, 15, 7))
    assert image.strides[2] == 0
    assert same(quench.medial_axis(image), quench.medial_axis(image.copy()))


@pytest.mark.parametrize('kind', ['b1', 'i1', 'u1', 'i2', 'u2', 'i4', 'u4', 'i8', 'u8', 'f2', 'f4', 'f8', '>i4', '>f8',
                                  '>u2', 'longlong', 'intc'])
def test_types(kind):
    image = blobs(2)
    wanted = quench.medial_axis(image)
    assert same(quench.medial_axis(image.astype(kind)), wanted)
    if np.dtype(kind).kind != 'b':
        scaled = (image * 90 + 5).astype(kind)
        assert same(quench.medial_axis(scaled, threshold=50), wanted)
        assert same(quench.medial_axis(scaled, threshold=95), wanted)
        assert same(quench.medial_axis(scaled, label=95), wanted)


def test_labels_of_64_bits_are_exact():
    image = np.full((6, 6, 6), 2**60, np.int64)
    image[2:4, 2:4, 2:4] += 1
    assert quench.medial_axis(image, label=2**60 + 1).reconstruct().sum() == 8
    assert quench.medial_axis(image, label=2**60, lambda_=0).topology.betti == (1, 0, 1)


def test_not_a_number_is_background():
    image = np.full((9, 8, 7), np.nan)
    image[2:6, 2:5, 2:4] = 3
    assert quench.medial_axis(image, threshold=1, lambda_=0).reconstruct().sum() == 4 * 3 * 2


@pytest.mark.parametrize('bad, word', [
    (np.ones(4), '1 dimensions'), (np.ones((4, 4, 4, 3)), '4 dimensions'), (np.ones((0, 4, 4)), 'no voxels'),
    (np.ones((4, 4, 4), complex), 'complex'), (np.full((4, 4, 4), 'a'), 'type'),
    (np.arange(64).reshape(4, 4, 4), 'more than two values'), (np.zeros((4, 4, 4)), 'no voxel'),
    (np.ma.masked_array(np.ones((4, 4, 4)), mask=False), 'masked'), (None, 'dimensions'), (7, 'dimensions')])
def test_images_that_are_none(bad, word):
    with pytest.raises(quench.Error, match=word) as caught:
        quench.medial_axis(bad)
    assert caught.value.code in (2, 3)


def test_results_outlive_their_inputs():
    image = blobs(3)
    axis = quench.medial_axis(image)
    vertices, radius, kept = axis.vertices, axis.radius, axis.vertices.copy()
    skeleton = axis.skeleton()
    curve = skeleton.curves.vertices.copy()
    image[:] = False
    sheets, keeper = skeleton.sheets.vertices, axis.skeleton('inf').graph().paths
    lengths = [len(path) for path in keeper]
    proved = skeleton.axis.verify()
    del image, axis, skeleton
    gc.collect()
    filler = [np.random.default_rng(i).random(100000) for i in range(20)]  # whoever was freed is overwritten
    assert np.array_equal(vertices, kept) and (radius > 0).all() and len(filler) == 20
    assert proved and len(curve) and len(sheets) and [len(path) for path in keeper] == lengths
    assert all(np.isfinite(path).all() for path in keeper)


def test_arrays_are_views_that_cannot_be_written():
    axis = quench.medial_axis(bent_tube())
    assert axis.vertices.base is not None and not axis.vertices.flags.owndata
    assert axis.vertices.ctypes.data == np.asarray(axis._core.vertices).ctypes.data
    for array in (axis.vertices, axis.radius, axis.edges, axis.faces):
        with pytest.raises(ValueError):
            array[0] = 0


def test_the_image_is_neither_copied_nor_changed():
    import resource
    image = np.zeros((400, 500, 500), np.uint8)  # 100 MB
    image[200:210, 200:206, 200:204] = 1
    image.setflags(write=False)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    quench.medial_axis(image)
    quench.skeletonize(image)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 60e3


def test_numpy_2():
    if int(np.__version__.split('.')[0]) < 2:
        pytest.skip(f'numpy 2 is not installed; these tests ran with numpy {np.__version__}')
    assert np.asarray(quench.medial_axis(bent_tube()).vertices, copy=False).shape[1] == 3


def test_no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        quench.medial_axis(bent_tube()).skeleton().branches()
