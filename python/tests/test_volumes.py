# SPDX-License-Identifier: Apache-2.0
"""quench.Volume of an array: what is computed of it lies where it lies."""
import copy

import numpy as np
import pytest
import quench
from shapes import bent_tube


def rotated(angle, about=2):
    c, s = np.cos(angle), np.sin(angle)
    return np.roll(np.roll(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), about - 2, axis=0), about - 2, axis=1)


SPACING, ORIGIN = np.array([0.5, 0.5, 2.0]), np.array([100.0, -20.0, 7.0])


def place(index, direction):
    return ORIGIN + (direction @ (SPACING * index).T).T


@pytest.mark.parametrize('direction', [np.eye(3), rotated(0.3), rotated(0.3) @ rotated(1.1, 0), np.diag([1.0, -1, 1]),
                                       np.eye(3)[[2, 0, 1]]])
def test_results_lie_where_the_volume_lies(direction):
    image = bent_tube()
    volume = quench.Volume(image, SPACING, ORIGIN, direction, units='mm')
    assert volume.array is image and volume.shape == image.shape and volume.units == 'mm'
    for given, kept in ((SPACING, volume.spacing), (ORIGIN, volume.origin), (direction, volume.direction)):
        np.testing.assert_allclose(kept, given, atol=1e-15)
    plain, axis = quench.medial_axis(image, spacing=SPACING), quench.medial_axis(volume)
    np.testing.assert_array_equal(axis.edges, plain.edges)
    np.testing.assert_allclose(axis.radius, plain.radius, rtol=1e-12)
    np.testing.assert_allclose(axis.vertices, place(plain.vertices / SPACING, direction), atol=1e-9)
    assert axis.units == 'mm' and axis.skeleton().units == 'mm' and plain.units == ''
    np.testing.assert_array_equal(axis.reconstruct(), plain.reconstruct())
    np.testing.assert_array_equal(axis.skeleton().to_volume(), plain.skeleton().to_volume())
    found = quench.skeletonize(quench.Volume(image.astype(np.uint8), SPACING, ORIGIN, direction))[1]
    np.testing.assert_allclose(found.vertices, quench.skeletonize(volume)[1].vertices, atol=1e-9)
    index = np.rint(((found.vertices - ORIGIN) @ direction) / SPACING).astype(int)
    assert image[tuple(index.T)].all() and found.topology == plain.topology
    assert found.theta1 == pytest.approx(plain.skeleton('inf').theta1)


def test_a_file_and_an_array_are_the_same(tmp_path):
    mesh = quench.sample('torus', fineness=0.5)
    read = quench.voxelize((mesh.vertices + 40, mesh.faces), resolution=30)
    made = quench.Volume(read.array, read.spacing, read.origin, read.direction)
    a, b = quench.medial_axis(read), quench.medial_axis(made)
    np.testing.assert_array_equal(a.vertices, b.vertices)
    np.testing.assert_array_equal(a.radius, b.radius)
    assert abs(b.vertices.mean(axis=0) - 40).max() < 0.5
    a.solid().save(tmp_path / 'a.nrrd')
    b.solid().save(tmp_path / 'b.nrrd')
    assert (tmp_path / 'a.nrrd').read_bytes() == (tmp_path / 'b.nrrd').read_bytes()


def test_images_of_two_dimensions():
    image = np.zeros((9, 40), bool)
    image[2:-2, 2:-2] = True
    plain = quench.medial_axis(image, spacing=(2, 0.5))
    volume = quench.Volume(image, spacing=(2, 0.5), origin=(10, 20), units='um')
    assert repr(volume).startswith('Image')
    np.testing.assert_array_equal(volume.spacing, [2, 0.5])
    np.testing.assert_array_equal(volume.direction, [[0, 1], [1, 0]])  # rows go along y, columns along x
    axis = quench.medial_axis(volume)
    np.testing.assert_allclose(axis.vertices, plain.vertices + [10, 20])
    np.testing.assert_allclose(axis.row_col, plain.row_col, atol=1e-9)
    np.testing.assert_array_equal(axis.to_image(), plain.to_image())
    flipped = quench.medial_axis(quench.Volume(image, (2, 0.5), (10, 20), [[0, -1], [1, 0]]))
    np.testing.assert_allclose(np.sort(10 - (flipped.vertices[:, 0] - 10)), np.sort(axis.vertices[:, 0]))
    assert quench.skeletonize(volume)[1].units == 'um'


def test_it_is_accepted_wherever_an_image_is(tmp_path):
    grey = bent_tube() * np.float16(7)
    volume = quench.Volume(grey, 0.5, units='mm', space='LPS')
    assert volume.dtype == np.float32  # as the library has no halves
    np.testing.assert_array_equal(quench.local_thickness(volume, threshold=3),
                                  quench.local_thickness(grey, threshold=3, spacing=0.5))
    np.testing.assert_array_equal(quench.surface_thickness(volume, threshold=3).thickness,
                                  quench.surface_thickness(grey, threshold=3, spacing=0.5).thickness)
    tree = quench.tree(volume, threshold=3)
    assert tree.units == 'mm' and tree.traits('axes').attrs['units']['length'] == 'mm'
    tree.save(tmp_path / 't.swc')
    assert 'SPACE: LPS' in (tmp_path / 't.swc').read_text()
    np.testing.assert_array_equal(np.asarray(volume), volume.array)
    np.testing.assert_array_equal(quench.Volume(volume, 2).spacing, [2, 2, 2])
    np.testing.assert_array_equal(copy.copy(volume).array, volume.array)
    again = quench.medial_axis(volume, threshold=3, spacing=(1, 1, 1))  # an explicit size is another one
    assert again.radius.max() == pytest.approx(2 * quench.medial_axis(volume, threshold=3).radius.max())


@pytest.mark.parametrize('wrong, argument', [({'spacing': 0}, 'spacing'), ({'spacing': (1, 2)}, 'spacing'),
                                             ({'spacing': 'x'}, 'spacing'), ({'origin': 5}, 'origin'),
                                             ({'origin': (1, 2, np.nan)}, 'origin'),
                                             ({'direction': np.eye(2)}, 'direction'),
                                             ({'direction': [[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]}, 'direction'),
                                             ({'direction': 2 * np.eye(3)}, 'direction'), ({'space': 'MNI'}, 'space')])
def test_what_is_no_place_is_refused(wrong, argument):
    with pytest.raises(ValueError) as caught:
        quench.Volume(bent_tube(), **wrong)
    assert caught.value.argument == argument and str(caught.value).startswith(argument + '=')


def test_what_is_no_image_is_refused():
    for wrong in (np.zeros(5), np.zeros((2, 2, 2, 2)), np.zeros((3, 3), complex)):
        with pytest.raises(quench.Error):
            quench.Volume(wrong)
