# SPDX-License-Identifier: Apache-2.0
"""Images for the tests. All are different along each axis, so that a swapped one shows."""
import numpy as np


def bent_tube():
    """An L of different arms in a box of three different sides: tips near (3, 4, 5) and (40, 25, 5)."""
    image = np.zeros((46, 30, 11), bool)
    image[2:43, 2:7, 3:8] = True
    image[37:42, 2:27, 3:8] = True
    return image


def blobs(seed, shape=(23, 18, 14), share=0.6):
    """A random shape with tunnels, cavities and several parts."""
    from scipy import ndimage
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).random(shape), 1.2)
    return noise > np.quantile(noise, share)


def plate_with_tunnel():
    image = np.zeros((34, 28, 11), bool)
    image[2:-2, 2:-2, 3:-3] = True
    image[10:15, 8:18, :] = False
    return image
