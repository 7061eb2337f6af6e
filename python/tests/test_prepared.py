# SPDX-License-Identifier: Apache-2.0
"""Volumes made ready before the threshold."""
import numpy as np
import pytest
import quench
from scipy import ndimage


def noisy_tube():
    x, y, z = np.meshgrid(np.arange(24), np.arange(18), np.arange(20), indexing='ij')
    inside = 3.5 - np.hypot(y - 8.3 - 0.1 * x, z - 9.6)
    noise = np.random.default_rng(1).normal(size=inside.shape) * 4
    return np.round(100 + 50 * np.clip(inside, -1, 1) + noise).astype(np.uint8)


def parts(axis):
    return axis.topology.betti[0]


def test_options_are_those_of_the_program():
    volume = noisy_tube()
    for options in (dict(threshold='auto'), dict(threshold='otsu'), dict(threshold=(100, 140)),
                    dict(threshold=100, blur=0.8), dict(threshold=100, median=1),
                    dict(threshold='auto', blur=0.8, median=1, close=1, connectivity=26)):
        axis = quench.medial_axis(volume, **options)
        assert parts(axis) == 1, options
        assert 2.5 < axis.radius.max() < 5.5, options
        assert bool(axis.verify())


def test_order_in_memory_does_not_matter():
    volume = noisy_tube()
    options = dict(threshold='auto', blur=1, median=1, close=1, connectivity=26)
    axis = quench.medial_axis(volume, **options)
    for other in (np.asfortranarray(volume), volume[::-1, :, ::-1].copy()[::-1, :, ::-1]):
        assert np.array_equal(quench.medial_axis(other, **options).vertices, axis.vertices)


def test_joins_what_touches():
    volume = np.zeros((3, 3, 3), np.uint8)
    for i in range(3):
        volume[i, i, 1] = 90
    assert parts(quench.medial_axis(volume, threshold=50)) == 3
    assert parts(quench.medial_axis(volume, threshold=50, connectivity=26)) == 1
    assert parts(quench.medial_axis(volume > 50, connectivity=26)) == 1
    assert parts(quench.medial_axis(volume[:, :, 1], threshold=50, connectivity=26)) == 1  # pixels


def test_medians_are_those_of_scipy():
    volume = noisy_tube()
    median = ndimage.median_filter(volume, 3, mode='nearest')
    a = quench.medial_axis(volume, threshold=100, median=1, surface='voxels')
    b = quench.medial_axis(median, threshold=100, surface='voxels')
    assert np.array_equal(a.vertices, b.vertices)


def test_thick_slices_become_cubes():
    x, y = np.meshgrid(np.arange(30), np.arange(30), indexing='ij')
    slices = np.stack([np.hypot(x - 14.5, y - 14.5) < 12 - 2 * k for k in range(5)], axis=2).astype(np.uint8) * 3
    axis = quench.medial_axis(slices, label=3, spacing=(1, 1, 4), interpolate=True)
    assert parts(axis) == 1
    assert np.allclose(axis.vertices[axis.radius.argmax()][:2], 14.5, atol=1)


@pytest.mark.parametrize('options, argument', [
    (dict(threshold='automatic'), 'threshold'), (dict(threshold=(1, 2, 3)), 'threshold'),
    (dict(threshold=(120, 100)), 'threshold'), (dict(threshold='auto', label=3), 'threshold'),
    (dict(threshold=100, blur='much'), 'blur'), (dict(threshold=100, blur=-1), 'blur'),
    (dict(threshold=100, median=1.5), 'median'), (dict(threshold=100, median=17), 'median'),
    (dict(threshold=100, close=65), 'close'), (dict(threshold=100, connectivity=18), 'connectivity'),
    (dict(label=100, blur=1), 'blur')])
def test_refuses_what_makes_no_sense(options, argument):
    with pytest.raises(quench.Error) as refused:
        quench.medial_axis(noisy_tube(), **options)
    assert refused.value.code == 2
    assert refused.value.argument == argument


def test_meshes_take_none():
    with pytest.raises(quench.Error):
        quench.medial_axis(quench.sample('torus'), resolution=20, blur=1)
