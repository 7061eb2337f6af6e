# SPDX-License-Identifier: Apache-2.0
"""Local thickness against balls painted one by one with numpy, and what it refuses."""
import os
import pathlib

import numpy as np
import pytest
import quench

BONE = pathlib.Path(os.environ.get('QUENCH_DATA', '')) / 'volumes' / 'trabecular_bone_128.nrrd'
FULL = bool(os.environ.get('QUENCH_TEST_FULL'))


def painted(image, spacing, between):
    """The definition: of every ball of the unpruned core, the diameter where it is the largest. Between the ends of an edge
    the balls whose spheres pass through the circle of both; in the order of nothing."""
    spacing = np.broadcast_to(np.asarray(spacing, float), image.ndim)
    axis = quench.medial_axis(image, spacing=spacing, detail=0, surface='voxels')
    centres = axis.vertices if image.ndim == 3 else axis.vertices[:, 1::-1]  # in the order of the axes
    radius = axis.radius
    squared = np.zeros(image.shape)
    near = 1 + 2e-9

    def box_of(centre, r):
        low = np.maximum(np.ceil((centre - r) / spacing - 1e-6).astype(int), 0)
        high = np.minimum(np.floor((centre + r) / spacing + 1e-6).astype(int) + 1, image.shape)
        return low, high

    def distances(centre, low, high):
        along = np.ogrid[tuple(slice(a, b) for a, b in zip(low, high))]
        return sum((o * s - c) ** 2 for o, s, c in zip(along, spacing, centre))

    for centre, r in zip(centres, radius):
        low, high = box_of(centre, r)
        part = squared[tuple(slice(a, b) for a, b in zip(low, high))]
        inside = distances(centre, low, high) <= r * r * near
        part[inside & (part < r * r)] = r * r
    if between:
        for a, b in np.asarray(axis.edges):
            u, v = (a, b) if radius[a] <= radius[b] else (b, a)
            low, high = box_of(centres[u], radius[u])
            part = squared[tuple(slice(x, y) for x, y in zip(low, high))]
            pu = distances(centres[u], low, high) - radius[u]**2 * near
            pv = distances(centres[v], low, high) - radius[v]**2 * near
            lune = (pu <= 0) & (pv > 0)
            if not lune.any():
                continue
            t = pu[lune] / (pu[lune] - pv[lune])
            d = ((centres[u] - centres[v])**2).sum()
            part[lune] = np.maximum(part[lune], (1 - t) * radius[u]**2 + t * radius[v]**2 - t * (1 - t) * d)
    return np.where(image, 2 * np.sqrt(squared), 0)


def histogram(values, width):
    # No value is at the end of a bin, where rounding would tell.
    bins = np.arange(0, values.max() + 2 * width, width) - 0.38196601 * width
    return np.histogram(values[values > 0], bins=bins)[0]


def sponge(level):
    place = np.arange(3**level)
    holes = np.zeros((3**level,) * 3, bool)
    for k in range(level):
        middle = (place // 3**k % 3 == 1).astype(int)
        holes |= middle[:, None, None] + middle[:, None] + middle >= 2
    return ~holes


def check(image, spacing=1.0, message=''):
    for balls in ('all', 'vertices'):
        found = quench.local_thickness(image, spacing=spacing, balls=balls, correction=0)
        expected = painted(image, spacing, balls == 'all')
        assert found.shape == image.shape and found.dtype == np.float32
        np.testing.assert_allclose(found, expected, rtol=1e-6, err_msg=f'{message} {balls}')
        width = float(np.min(spacing)) / 10
        assert np.array_equal(histogram(found, width), histogram(expected.astype(np.float32), width)), message


def test_random_images():
    random = np.random.default_rng(1)
    for n in range(40 if FULL else 14):
        image = random.random(random.integers(3, 12, size=3)) < random.uniform(0.2, 0.9)
        if image.any():
            check(image, random.integers(1, 4, size=3) / 2 if n % 2 else 1.0, f'image {n}')


def test_random_images_of_two_dimensions():
    random = np.random.default_rng(2)
    for n in range(40 if FULL else 14):
        image = random.random(random.integers(3, 20, size=2)) < random.uniform(0.4, 0.95)
        if image.any():
            check(image, random.integers(1, 4, size=2) / 2 if n % 2 else 1.0, f'image {n}')


def test_sponge():
    check(sponge(3 if FULL else 2), 0.02)


@pytest.mark.skipif(not FULL or not BONE.exists(), reason='only in make test-full')
def test_bone():
    check(np.asarray(quench.read(BONE)) >= 64)


def test_order_in_memory():
    image = sponge(2)
    image[:3] = False
    expected = quench.local_thickness(image)
    for other in (np.asfortranarray(image), image[::-1].copy()[::-1], image.astype(np.uint16)):
        assert np.array_equal(quench.local_thickness(other), expected)


def test_pores_mask_and_correction():
    image = sponge(2)
    pores = quench.local_thickness(image, invert=True)
    assert np.array_equal(pores > 0, ~image)
    assert np.array_equal(quench.local_thickness(~image), pores)
    mask = np.arange(image.size).reshape(image.shape) % 5 > 1
    masked = quench.local_thickness(image, mask=mask)
    assert np.array_equal(masked, np.where(mask, quench.local_thickness(image), 0))
    plain = quench.local_thickness(image, correction=0)
    assert np.allclose(quench.local_thickness(image)[image], plain[image] + 1, rtol=1e-6)
    assert np.allclose(quench.local_thickness(image, correction='2vox')[image], plain[image] + 4, rtol=1e-6)


@pytest.mark.parametrize('wrong', [{'balls': 'some'}, {'correction': 'much'}, {'mask': np.ones((2, 2, 2), bool)}])
def test_refusals(wrong):
    with pytest.raises(quench.UsageError):
        quench.local_thickness(sponge(1), **wrong)


def test_surface_of_a_mesh():
    mesh = quench.sample('torus', fineness=0.4)
    walls = quench.surface_thickness(mesh, resolution=96)
    assert np.array_equal(walls.vertices, mesh.vertices) and np.array_equal(walls.faces, mesh.faces)
    assert np.ptp(walls.thickness) / walls.thickness.mean() < 0.05  # the same tube everywhere
    ratio = np.linalg.norm(walls.across - walls.vertices, axis=1) / walls.thickness
    assert abs(ratio - 1).max() < 0.1


def test_surface_of_an_image():
    image = np.zeros((20, 20, 20), bool)
    image[5:15, 5:15, 5:15] = True
    walls = quench.surface_thickness(image)
    assert len(walls.across) == len(walls.vertices) > 0
    with pytest.raises(quench.UsageError):
        quench.surface_thickness(image[10])
