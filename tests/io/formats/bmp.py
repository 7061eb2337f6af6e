# SPDX-License-Identifier: Apache-2.0
"""Bitmaps of Windows and OS/2."""
import struct

import numpy as np

from . import pictures
from .cases import case, damaged, image

FIELDS = {'565': (16, (0xF800, 0x7E0, 0x1F)), '4444': (16, (0xF00, 0xF0, 0xF, 0xF000)), 'BGRA': (32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000)),
          'RGB': (32, (0xFF, 0xFF00, 0xFF0000)), '10 bits': (32, (0x3FF00000, 0xFFC00, 0x3FF))}


def bmp(dims, bits, body, compression=0, palette=b'', masks=(), old=False, down=False, long=0, colours=0, begin=None) -> bytes:
    """`long` bytes of header beyond 40; the masks are behind or in it."""
    if old:
        head = struct.pack('<IHHHH', 12, dims[0], dims[1], 1, bits)
    else:
        head = struct.pack('<IiiHHIIiiII', 40 + long, dims[0], -dims[1] if down else dims[1], 1, bits, compression, 0, 2835, 2835, colours, 0)
        inside = b''.join(struct.pack('<I', m) for m in masks)
        head += inside + bytes(max(0, long - len(inside)))
    offset = 14 + len(head) + len(palette)
    return b'BM' + struct.pack('<IHHI', offset + len(body), 0, 0, offset if begin is None else begin) + head + palette + body


def packed(values, bits, down=False) -> bytes:
    """values[x, y] of `bits` bits, rows filled up to four bytes, from the bottom."""
    rows = []
    for row in values.T if down else values.T[::-1]:
        if bits >= 8:
            data = b''.join(int(v).to_bytes(bits // 8, 'little') for v in row)
        else:
            digits = ''.join(f'{int(v):0{bits}b}' for v in row)
            digits += '0' * (-len(digits) % 8)
            data = int(digits, 2).to_bytes(len(digits) // 8, 'big')
        rows.append(data + bytes(-len(data) % 4))
    return b''.join(rows)


def table(colours, old=False):
    return b''.join(bytes([b, g, r] if old else [b, g, r, 0]) for r, g, b in colours.tolist())


def palettes():
    found = []
    random = np.random.default_rng(3)
    for bits in (1, 4, 8):
        for dims in ((13, 5), (8, 3), (1, 1), (3, 7)):
            indices = random.integers(0, 2**bits, dims)
            for name, colours in (('greys', random.integers(0, 256, (2**bits, 1)).repeat(3, 1)), ('colours', random.integers(0, 256, (2**bits, 3)))):
                pixels = colours[indices][:, :, :1 if name == 'greys' else 3].astype('uint8')
                for form in ('usual', 'old', 'down'):
                    data = bmp(dims, bits, packed(indices, bits, form == 'down'), palette=table(colours, form == 'old'), old=form == 'old', down=form == 'down')
                    found += pictures.channel_cases(f'{name}, {bits} bits, {dims}, {form}', data, 'v.bmp', pixels, damage=dims == (13, 5) and form == 'usual')
    indices = random.integers(0, 5, (7, 5))
    colours = random.integers(0, 256, (5, 3))
    few = table(colours)
    found += pictures.channel_cases('five colours', bmp((7, 5), 8, packed(indices, 8), palette=few, colours=5), 'v.bmp', colours[indices].astype('uint8'))
    found.append(case('wrong index', bmp((7, 5), 8, packed(indices + 1, 8), palette=few, colours=5), 'v.bmp'))
    found.append(case('no palette', bmp((7, 5), 8, packed(indices, 8)), 'v.bmp'))
    found.append(case('300 colours', bmp((7, 5), 8, packed(indices, 8), palette=few * 60, colours=300), 'v.bmp'))
    return found


def direct():
    found = []
    for dims in ((7, 5), (1, 1), (4, 3)):
        pixels = pictures.random_pixels(dims, 3, 8)
        r, g, b = (pixels[:, :, c].astype(object) for c in range(3))
        whole = r << 16 | g << 8 | b
        found += pictures.channel_cases(f'24 bits, {dims}', bmp(dims, 24, packed(whole, 24)), 'v.bmp', pixels, damage=dims == (7, 5))
        found += pictures.channel_cases(f'32 bits, {dims}', bmp(dims, 32, packed(whole, 32)), 'v.bmp', pixels)
        found += pictures.channel_cases(f'24 bits down, {dims}', bmp(dims, 24, packed(whole, 24, True), down=True), 'v.bmp', pixels)
    random = np.random.default_rng(5)
    for name, (bits, masks) in FIELDS.items():
        values = random.integers(0, 2**bits, (7, 5))
        pixels = np.stack([(values & m) * 255 // m if m & 1 else ((values & m) >> (m & -m).bit_length() - 1) * 255 // (m >> (m & -m).bit_length() - 1)
                           for m in masks], axis=2).astype('uint8')
        for long in (0, 16, 84) if len(masks) == 3 else (16, 84):
            data = bmp((7, 5), bits, packed(values, bits), 3, masks=masks, long=long)
            found.append(case(f'fields {name}, header {40 + long}', data, 'v.bmp', image(pictures.own_value(pixels))))
    values = random.integers(0, 2**15, (7, 5))
    pixels = np.stack([(values >> s & 31) * 255 // 31 for s in (10, 5, 0)], axis=2).astype('uint8')
    found.append(case('16 bits', bmp((7, 5), 16, packed(values, 16)), 'v.bmp', image(pictures.own_value(pixels))))
    for masks in ((0, 0xFF00, 0xFF), (0xF0F, 0xF000, 0xF0000), (0xFF00, 0xFF00, 0xFF)):
        found.append(case(f'masks {masks}', bmp((7, 5), 32, packed(values, 32), 3, masks=masks), 'v.bmp'))
    return found


def run_length():
    found = []
    random = np.random.default_rng(9)
    colours = random.integers(0, 256, (256, 3))
    for bits in (4, 8):
        plte = table(colours[:2**bits])

        def values(number, first, second):
            digits = [first if i % 2 == 0 else second for i in range(number)]
            return digits if bits == 4 else [first * 16 + second] * number

        def literal(row):
            row = list(row)
            if bits == 4:
                data = bytes((a << 4 | b) for a, b in zip(row[::2], row[1::2] + [0]))
            else:
                data = bytes(row)
            return bytes([0, len(row)]) + data + bytes(len(data) % 2)

        def check(name, body, rows, dims, **more):
            indices = np.array(rows[::-1]).T  # from the bottom
            pixels = colours[indices].astype('uint8')
            found.append(case(f'RLE{bits} {name}', bmp(dims, bits, body, 2 if bits == 4 else 1, palette=plte), 'v.bmp', image(pictures.own_value(pixels)), **more))

        run = values(7, 3, 5)
        mixed = [1, 2, 3, 4, 5, 6, 7]
        check('runs', (bytes([7, 0x35]) + b'\0\0') * 2 + b'\0\1', [run, run], (7, 2), damage=True)
        check('single pixels', literal(mixed) + b'\0\0' + bytes([4, 0x35]) + literal(mixed[:3]) + b'\0\1',
              [mixed, values(4, 3, 5) + mixed[:3]], (7, 2))
        check('left out', bytes([2, 0x35]) + b'\0\0' + b'\0\2\3\1' + bytes([2, 0x35]) + b'\0\1',
              [values(2, 3, 5) + [0] * 5, [0] * 7, [0] * 3 + values(2, 3, 5) + [0] * 2], (7, 3))
        for name, body in (('run too long', bytes([9, 0x35]) + b'\0\1'), ('too many rows', b'\0\0\0\0\0\0' + bytes([1, 0x35]) + b'\0\1'),
                           ('no end', bytes([7, 0x35])), ('half a delta', b'\0\2\1'), ('beyond the picture', b'\0\2\x09\0' + bytes([1, 0x35]) + b'\0\1')):
            found.append(case(f'RLE{bits} {name}', bmp((7, 2), bits, body, 2 if bits == 4 else 1, palette=plte), 'v.bmp'))
        found.append(case(f'RLE{bits} from the top', bmp((7, 2), bits, b'\0\1', 2 if bits == 4 else 1, palette=plte, down=True), 'v.bmp'))
        for dims in ((2**31 - 1, 2), (2**20, 2**20), (60000, 60000)):
            found.append(case(f'RLE{bits} claims {dims}', bmp(dims, bits, b'\0\1', 2 if bits == 4 else 1, palette=plte), 'v.bmp'))
    return found


def hostile():
    pixels = pictures.random_pixels((7, 5), 3, 8)
    whole = pixels[:, :, 0].astype(object) << 16 | pixels[:, :, 1].astype(object) << 8 | pixels[:, :, 2]
    body, right = packed(whole, 24), image(pictures.own_value(pixels))
    found = []
    for dims in ((9, 5), (7, 6), (0, 5), (7, 0), (2**31 - 1, 5), (7, 2**31 - 1), (2**31 - 1, 2**31 - 1), (-7, 5)):
        found.append(case(f'claims {dims}', bmp(dims, 24, body), 'v.bmp'))
    found.append(case('height -2^31', bmp((7, 5), 24, body)[:22] + b'\0\0\0\x80' + bmp((7, 5), 24, body)[26:], 'v.bmp'))
    for bits in (0, 2, 3, 5, 12, 48, 64):
        found.append(case(f'{bits} bits', bmp((7, 5), bits, body), 'v.bmp'))
    for compression in (1, 2, 3, 4, 5, 6, 11, 2**31):
        found.append(case(f'compression {compression}', bmp((7, 5), 24, body, compression), 'v.bmp'))
    for begin in (0, 14, 53, 2**31, 2**32 - 1):
        found.append(case(f'pixels at {begin}', bmp((7, 5), 24, body, begin=begin), 'v.bmp'))
    for size in (0, 13, 39, 2**16, 2**32 - 1):
        data = bmp((7, 5), 24, body)
        found.append(case(f'header of {size} bytes', data[:14] + struct.pack('<I', size) + data[18:], 'v.bmp'))
    found.append(case('no bitmap', b'hello' * 20, 'v.bmp'))
    found.append(case('empty', b'', 'v.bmp'))
    found.append(case('capitals', bmp((7, 5), 24, body), 'V.BMP', right))
    return found


def cases():
    found = palettes() + direct() + run_length() + hostile()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
