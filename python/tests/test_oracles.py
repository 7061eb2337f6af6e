# SPDX-License-Identifier: Apache-2.0
"""Against code of others: scipy's distance transform, labels and Euler numbers of scikit-image."""
import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs, plate_with_tunnel

ndimage = pytest.importorskip('scipy.ndimage')
measure = pytest.importorskip('skimage.measure')


def boundary_vertices(image):
    """True at lattice points whose 8 voxels are neither all inside nor all outside; point (0, 0, 0) is at index -1/2."""
    padded = np.pad(image, 1).astype(int)
    count = sum(padded[i:padded.shape[0] - 1 + i, j:padded.shape[1] - 1 + j, k:padded.shape[2] - 1 + k]
                for i in (0, 1) for j in (0, 1) for k in (0, 1))
    return (count > 0) & (count < 8)


@pytest.mark.parametrize('image', [bent_tube(), plate_with_tunnel(), blobs(4), blobs(5, share=0.4)])
@pytest.mark.parametrize('spacing', [(1, 1, 1), (0.5, 1, 1.5)])
def test_radius_is_the_distance_to_the_nearest_boundary_vertex(image, spacing):
    fine = 4  # points of the distance transform per voxel
    sites = boundary_vertices(image)
    grid = np.ones([(n - 1) * fine + 1 for n in sites.shape], bool)
    grid[::fine, ::fine, ::fine] = ~sites
    step = np.array(spacing) / fine
    distance = ndimage.distance_transform_edt(grid, sampling=step)
    axis = quench.medial_axis(image, spacing=spacing, lambda_=0)
    where = (axis.vertices / spacing + 0.5) * fine
    near = np.rint(where).astype(int)
    found = distance[tuple(near.T)]
    off = np.linalg.norm((where - near) * step, axis=1)
    assert (np.abs(found - axis.radius) <= off + 1e-9).all()  # distances are 1-Lipschitz
    exact = off < 1e-9
    assert exact.sum() > 10 and np.allclose(found[exact], axis.radius[exact], rtol=1e-12, atol=1e-12)


def topology_of(image):
    """Of the open shape: foreground with 6 neighbours, background with 26."""
    padded = np.pad(image, 1)
    parts = measure.label(padded, connectivity=1).max()
    cavities = measure.label(~padded, connectivity=3).max() - 1
    euler = measure.euler_number(padded, connectivity=1)
    return euler, (parts, parts + cavities - euler, cavities)


@pytest.mark.parametrize('seed', range(12))
def test_topology_is_that_of_the_image(seed):
    image = blobs(seed, share=0.35 + 0.03 * seed)
    wanted = topology_of(image)
    axis = quench.medial_axis(image)
    assert (axis.topology.euler, axis.topology.betti) == wanted
    assert len(axis.vertices) - len(axis.edges) + len(axis.polygons[0]) - 1 == wanted[0]
    for thetas in ((0.03, 0.02), ('inf', 0.02), (0, 0), ('inf', 'inf')):
        skeleton = axis.skeleton(*thetas)
        assert skeleton.topology == axis.topology
        assert len(skeleton.vertices) - len(skeleton.edges) + len(skeleton.polygons[0]) - 1 == wanted[0]


@pytest.mark.parametrize('seed', range(6))
def test_the_balls_of_the_full_axis_fill_the_image(seed):
    image = blobs(seed + 50)
    filled = quench.medial_axis(image, lambda_=0).reconstruct()
    assert np.array_equal(filled, image)  # and of cubes no more
    longer = quench.medial_axis(image, spacing=(1, 0.5, 2), lambda_=0).reconstruct()
    assert not (image & ~longer).any()


def test_the_union_of_balls_ball_by_ball():
    image = blobs(7, (17, 13, 11))
    spacing = np.array([1.0, 0.7, 1.5])
    axis = quench.medial_axis(image, spacing=spacing)
    wide = (17, 20, 11)  # balls may bulge out of the image between corners of voxels that are no cubes
    places = np.stack(np.indices(wide), axis=-1) * spacing
    filled = np.zeros(wide, bool)
    for centre, r in zip(axis.vertices, axis.radius):
        filled |= ((places - centre)**2).sum(axis=-1) <= (r * (1 + 1e-9))**2
    assert np.array_equal(axis.reconstruct(), filled[:, :13])
    assert np.array_equal(axis.reconstruct((9, 20, 6)), filled[:9, :, :6])


@pytest.mark.parametrize('seed', range(6))
def test_voxels_of_a_skeleton_are_of_the_image_and_connected_like_it(seed):
    image = blobs(seed + 80)
    volume = quench.medial_axis(image).skeleton('inf').to_volume()
    assert not (volume & ~image).any()
    parts = measure.label(image, connectivity=1)
    for part in range(1, parts.max() + 1):
        assert measure.label(volume & (parts == part), connectivity=3).max() == 1


def column():
    image = np.zeros((100, 10, 10), bool)
    image[:, 3:7, 3:7] = True
    return image


def cube():
    return np.ones((128, 128, 128), bool)


def slices():
    """Round blobs three slices thick, and one of a single slice."""
    y, x = np.mgrid[:40, :60]
    image = np.zeros((9, 40, 60), bool)
    image[1:4] = (y - 20)**2 + (x - 15)**2 < 100
    image[5:8] = (y - 20)**2 + (x - 42)**2 < 200
    image[3, 2:5, 50:58] = True
    return image


@pytest.mark.parametrize('make', [column, cube, slices])
def test_objects_that_thinning_loses_are_kept(make):
    image = make()
    parts = measure.label(image, connectivity=1).max()
    skeleton = quench.medial_axis(image).skeleton('inf')
    assert skeleton.topology.betti[0] == parts
    assert measure.label(skeleton.to_volume(), connectivity=3).max() == parts
    if make is column:
        table = skeleton.branches()
        assert 90 < table['length'].max() < 101  # from end to end


def test_a_tube_against_thinning():
    """The same course as the skeleton of scikit-image, within a voxel."""
    morphology = pytest.importorskip('skimage.morphology')
    image = bent_tube()
    theirs = np.argwhere(getattr(morphology, 'skeletonize_3d', morphology.skeletonize)(image))
    path = np.concatenate(quench.medial_axis(image).skeleton('inf', '20%').graph().paths)
    for a, b in ((theirs[5:-5], path), ):
        assert (np.linalg.norm(a[:, None] - b[None], axis=2).min(axis=1) < 2).mean() > 0.9


@pytest.mark.parametrize('seed', range(6))
def test_images_of_two_dimensions(seed):
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).random((60, 45)), 1.5)
    image = noise > np.quantile(noise, 0.35 + 0.05 * seed)
    euler = measure.euler_number(image, connectivity=1)  # foreground by sides
    labels, parts = measure.label(image, connectivity=1, return_num=True)
    axis = quench.medial_axis(image)
    assert axis.topology == (euler, (parts, parts - euler, 0))
    assert axis.skeleton(theta1='inf').topology == axis.topology
    mask, distance = axis.to_image(return_distance=True)
    # To the centres of background pixels, not to corners: half a pixel to half a diagonal more, for another place in it.
    wanted = ndimage.distance_transform_edt(np.pad(image, 1))[1:-1, 1:-1]
    assert np.abs(wanted - distance)[mask].max() <= np.sqrt(2) and 0 < (wanted - distance)[mask].mean() < 0.6
    found = quench.skeletonize(labels)
    assert sorted(found) == list(range(1, parts + 1))
    for label, skeleton in found.items():
        shown = skeleton.to_image()
        assert (labels[shown] == label).all() and measure.label(shown, connectivity=2, return_num=True)[1] == 1
