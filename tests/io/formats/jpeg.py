# SPDX-License-Identifier: Apache-2.0
"""JPEG of blocks of one value each: then what a decoder makes of it is exact."""
import struct

import numpy as np

from . import pictures
from .cases import case, damaged, image, slab


def segment(marker, data):
    return struct.pack('>BBH', 0xFF, marker, len(data) + 2) + data


class Bits:
    def __init__(self):
        self.text = ''

    def put(self, value, size):
        self.text += f'{value:0{size}b}' if size else ''

    def data(self):
        text = self.text + '1' * (-len(self.text) % 8)
        return int(text, 2).to_bytes(len(text) // 8, 'big').replace(b'\xff', b'\xff\0') if text else b''


def jpeg(blocks, dims=None, adobe=None, progressive=False, precision=8, components=None, scans=1, tail=b'\xff\xd9'):
    """blocks[x, y, component] of 8 x 8 pixels of one value. DC alone: every difference in 12 bits, of category 0 to 11
    by codes of four bits; a block ends with a code of one bit (progressive: in a scan of its own per component, without
    which decoders smooth)."""
    w, h, n = blocks.shape
    width, height = dims or (8 * w, 8 * h)
    found = b'\xff\xd8'
    if adobe is not None:
        found += segment(0xEE, b'Adobe' + struct.pack('>HHHB', 100, 0, 0, adobe))
    found += segment(0xDB, b'\0' + b'\1' * 64)
    frame = b''.join(bytes([c + 1, 0x11, 0]) for c in range(components or n))
    found += segment(0xC2 if progressive else 0xC0, struct.pack('>BHHB', precision, height, width, components or n) + frame)
    found += segment(0xC4, b'\0' + bytes([0, 0, 0, 12] + [0] * 12) + bytes(range(12)))
    found += segment(0xC4, b'\x10' + bytes([1] + [0] * 15) + b'\0')
    bits, last = Bits(), [0] * n
    for y in range(h):
        for x in range(w):
            for c in range(n):
                level = 8 * (int(blocks[x, y, c]) - 128)
                step, last[c] = level - last[c], level
                size = abs(step).bit_length()
                bits.put(size, 4)
                bits.put(step if step >= 0 else step + 2**size - 1, size)
                if not progressive:
                    bits.put(0, 1)
    rest = b''
    if progressive:
        empty = Bits()
        empty.put(0, w * h)
        rest = b''.join(segment(0xDA, bytes([1, c + 1, 0, 1, 63, 0])) + empty.data() for c in range(n))
    scan = segment(0xDA, bytes([n]) + b''.join(bytes([c + 1, 0]) for c in range(n)) + (b'\0\0\0' if progressive else b'\0\x3f\0'))
    return found + (scan + bits.data()) * min(scans, 1) + rest + (scan + bits.data()) * max(0, scans - 1) + tail


def cases():
    found = []
    random = np.random.default_rng(11)
    for w, h in ((1, 1), (3, 2), (5, 4)):
        for dims in ((8 * w, 8 * h), (8 * w - 5, 8 * h - 3)):
            for progressive in (False, True):
                def pixels_of(blocks):
                    return blocks.repeat(8, 0).repeat(8, 1)[:dims[0], :dims[1]]
                greys = random.integers(0, 256, (w, h, 1)).astype('uint8')
                form = ', progressive' if progressive else ''
                small = (w, h) == (3, 2) and dims[0] == 24
                found += pictures.channel_cases(f'grey {dims}{form}', jpeg(greys, dims, progressive=progressive), 'v.jpg', pixels_of(greys), damage=small)
                rgb = random.integers(0, 256, (w, h, 3)).astype('uint8')
                found += pictures.channel_cases(f'RGB {dims}{form}', jpeg(rgb, dims, 0, progressive), 'v.jpeg', pixels_of(rgb), damage=small)
                neutral = greys.repeat(3, 2)
                ycc = np.dstack([greys, np.full((w, h, 2), 128)])
                found += pictures.channel_cases(f'YCbCr {dims}{form}', jpeg(ycc, dims, 1, progressive), 'v.jpg', pixels_of(neutral))
    blocks = random.integers(0, 256, (3, 2, 1)).astype('uint8')
    four = random.integers(0, 256, (3, 2, 4)).astype('uint8')
    right = image(blocks[:, :, 0].repeat(8, 0).repeat(8, 1))
    refused = {'CMYK': jpeg(four, adobe=0), 'YCCK': jpeg(four, adobe=2), '12 bits': jpeg(blocks, precision=12), 'empty': b'',
               'no JPEG': b'hello' * 20, 'a start alone': b'\xff\xd8', 'a start and an end': b'\xff\xd8\xff\xd9',
               'no scan': jpeg(blocks, scans=0), 'two components for one': jpeg(blocks, components=2),
               'no end': jpeg(blocks, tail=b''), 'many scans': jpeg(blocks, progressive=True, scans=1000)}
    for dims in ((25, 16), (24, 17), (0, 16), (24, 0), (65535, 16), (65535, 65535), (65500, 65500)):
        refused[f'claims {dims}'] = jpeg(blocks, dims)
        refused[f'claims {dims}, progressive'] = jpeg(blocks, dims, progressive=True)
    found += [case(name, data, 'v.jpg') for name, data in refused.items()]
    found.append(case('as a slab', jpeg(blocks), 'v.jpg', slab(right.samples), how=(('dimension', '3'),)))
    # Sequential scans of the same component may come twice, or be refused.
    found.append(case('two scans', jpeg(blocks, scans=2), 'v.jpg', right, refusable=True))
    return found + [c for whole in found if whole.damage for c in damaged(whole)]

