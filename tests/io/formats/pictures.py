# SPDX-License-Identifier: Apache-2.0
"""Pictures with colours, and what becomes of them: one value per pixel. By the words of the documentation, in exact
integers; Pillow, where it is installed, has to agree."""
import io

import numpy as np

from .cases import case, image

try:
    from PIL import Image
except ImportError:
    Image = None

CHANNELS = ('luminance', 'red', 'green', 'blue', 'alpha')


def random_pixels(dims, channels, bits):
    """pixels[x, y, channel] with 0 and the largest value among them."""
    random = np.random.default_rng(1000 * channels + 10 * bits + dims[0])
    pixels = random.integers(0, 2**bits, dims + (channels,))
    pixels[random.random(dims) < 0.2, -1] = 2**bits - 1
    pixels[random.random(dims) < 0.2, -1] = 0
    return pixels.astype('uint8' if bits == 8 else 'uint16')


def stencil(channels, bits):
    """One colour where anything is seen, another one where nothing is."""
    pixels = random_pixels((13, 9), channels, bits)
    pixels[:, :, :-1] = np.where(pixels[:, :, -1:] > 0, np.arange(1, channels) * 7, 99)
    return pixels


def rounded(numerator, denominator):
    return (2 * numerator + denominator) // (2 * denominator)


def value(pixels, channel):
    """pixels[..., channel] as one value each, of the same type."""
    white = np.iinfo(pixels.dtype).max
    p = pixels.astype(object)
    n = p.shape[-1]
    alpha = p[..., -1] if n % 2 == 0 else np.full(p.shape[:-1], white, dtype=object)
    red, green, blue = (p[..., c if n > 2 else 0] for c in range(3))
    if channel == 'alpha':
        result = alpha
    elif channel == 'luminance':
        light = rounded(19595 * red + 38470 * green + 7471 * blue, 65536)  # of 0.299, 0.587, 0.114
        result = rounded(light * alpha + white * (white - alpha), white)
    else:
        result = {'red': red, 'green': green, 'blue': blue}[channel]
    return result.astype(pixels.dtype)


def own_value(pixels):
    """Without a channel: alpha where it varies and all that is seen has one colour, else luminance."""
    if pixels.shape[-1] % 2 == 1:
        return value(pixels, 'luminance')
    alpha = pixels[..., -1]
    seen = pixels[alpha > 0][:, :-1]
    one_colour = len(np.unique(seen, axis=0)) <= 1
    return value(pixels, 'alpha' if one_colour and alpha.min() < alpha.max() else 'luminance')


def seen_by_pillow(data):
    """The pixels of a file as pixels[x, y, channel] of 8 bits, RGBA."""
    with Image.open(io.BytesIO(data)) as picture:
        return np.asarray(picture.convert('RGBA')).transpose(1, 0, 2)


def agrees(data, pixels):
    """Whether Pillow sees these pixels in the file."""
    if Image is None or pixels.dtype != np.uint8:
        return True
    n = pixels.shape[-1] if pixels.ndim == 3 else 1
    flat = pixels.reshape(pixels.shape[0], pixels.shape[1], n)
    colours = flat[:, :, [0, 0, 0] if n < 3 else [0, 1, 2]]
    alpha = flat[:, :, -1:] if n % 2 == 0 else np.full_like(flat[:, :, :1], 255)
    return np.array_equal(seen_by_pillow(data), np.concatenate([colours, alpha], axis=2))


def channel_cases(name, data, opened, pixels, damage=False, pillow=True):
    """The file with and without a channel. pixels[x, y, channel]; `pillow`: it reads such a file right."""
    assert not pillow or agrees(data, pixels), f'{name}: Pillow sees another picture'
    found = [case(name, data, opened, image(own_value(pixels)), damage=damage)]
    for channel in CHANNELS:
        how = (('channel', channel),)
        if channel == 'alpha' and pixels.shape[-1] % 2 == 1:
            found.append(case(f'{name}, {channel}', data, opened, usage=True, how=how))
        else:
            found.append(case(f'{name}, {channel}', data, opened, image(value(pixels, channel)), how=how))
    return found
