# SPDX-License-Identifier: Apache-2.0
"""Portable bitmaps, greymaps and pixmaps (Netpbm), plain and raw."""
import numpy as np

from . import pictures
from .cases import case, damaged, image, slab


def header(kind, dims, most=None, blank='\n'):
    return f'P{kind}{blank}{dims[0]} {dims[1]}{blank}'.encode() + (f'{most}{blank}'.encode() if most is not None else b'')


def rows(pixels):
    return pixels.swapaxes(0, 1)


def plain(pixels):
    return ' '.join(str(v) for v in rows(pixels).ravel()).encode()


def raw(pixels, most):
    return rows(pixels).astype('>u2' if most > 255 else 'u1').tobytes()


def greys_and_colours():
    found = []
    for most in (1, 7, 255, 256, 1000, 65535):
        for channels, kind in ((1, 2), (3, 3)):
            for dims in ((7, 5), (1, 1), (9, 1)):
                random = np.random.default_rng(most + channels)
                pixels = random.integers(0, most + 1, dims + (channels,)).astype('uint8' if most < 256 else 'uint16')
                pixels[-1, -1] = most
                for form, data in (('plain', header(kind, dims, most) + plain(pixels) + b'\n'), ('raw', header(kind + 3, dims, most) + raw(pixels, most))):
                    name = f'{form} P{kind}, {dims}, values up to {most}'
                    if most in (255, 65535):
                        found += pictures.channel_cases(name, data, 'v.ppm' if channels == 3 else 'v.pgm', pixels, damage=dims == (7, 5) and form == 'raw')
                    elif channels == 1:  # as they are
                        found.append(case(name, data, 'v.pgm', image(pixels[:, :, 0]), damage=dims == (7, 5) and form == 'raw', by_program=most > 1))
    return found


def bits():
    found = []
    for dims in ((13, 5), (8, 3), (1, 4), (1, 1)):
        black = np.random.default_rng(dims[0]).integers(0, 2, dims).astype('uint8')
        black[-1, -1] = 1
        right = image((1 - black) * np.uint8(255))
        packed = np.packbits(rows(black), axis=1).tobytes()
        found.append(case(f'raw bits {dims}', header(4, dims) + packed, 'v.pbm', right, damage=dims == (13, 5)))
        for between in ('', ' ', '\n# 1 0 1\n'):
            data = header(1, dims) + between.join(str(v) for v in rows(black).ravel()).encode()
            found.append(case(f'plain bits {dims} with {between!r} between', data, 'v.pbm', right))
        assert pictures.agrees(header(4, dims) + packed, right.samples)
    return found


def forms():
    pixels = np.arange(35).reshape(7, 5, 1).astype('uint8')
    data, right = raw(pixels, 255), image(pixels[:, :, 0])
    found = []
    for name, text in (('comments', b'P5 # a comment\n#another\n7 # width\n5\n# largest\n255\n'), ('tabs and CR', b'P5\t7\r\n5\t255\n'),
                       ('zeros in front', b'P5 0007 05 00255 ')):
        found.append(case(name, text + data, 'v.pgm', right))
    found.append(case('another ending', header(5, (7, 5), 255) + data, 'v.pnm', right))
    found.append(case('as a slab', header(5, (7, 5), 255) + data, 'v.pgm', slab(right.samples), how=(('dimension', '3'),)))
    for name, text in (('nothing', b''), ('P', b'P'), ('P7', b'P7\nWIDTH 7\nHEIGHT 5\nDEPTH 1\nMAXVAL 255\nENDHDR\n'), ('P0', b'P0 7 5 255 '),
                       ('no size', b'P5\n'), ('width 0', b'P5 0 5 255 '), ('height 0', b'P5 7 0 255 '), ('largest value 0', b'P5 7 5 0 '),
                       ('largest value 65536', b'P5 7 5 65536 '), ('width -7', b'P5 -7 5 255 '), ('a fraction', b'P5 7.0 5 255 '),
                       ('only a comment', b'P5 # 7 5 255 ')):
        found.append(case(name, text + (data if text else b''), 'v.pgm'))
    for dims in ((8, 5), (7, 6), (2**31 - 1, 5), (2**31, 5), (7, 10**30), (2**31 - 2, 2**31 - 2)):
        for kind in (1, 2, 3, 4, 5, 6):
            found.append(case(f'P{kind} claims {dims}', header(kind, dims, 255 if kind % 3 != 1 else None) + b'1' * 30, 'v.pgm'))
    found.append(case('a value too large, plain', b'P2 2 1 10 3 11', 'v.pgm'))
    found.append(case('a value too large, raw', b'P5 2 1 10 \3\13', 'v.pgm'))
    found.append(case('a value that is none', b'P2 2 1 10 3 x', 'v.pgm'))
    found.append(case('a bit that is none', b'P1 2 1 1 2', 'v.pbm'))
    found.append(case('two pictures', (header(5, (7, 5), 255) + data) * 2, 'v.pgm'))
    return found


def cases():
    found = greys_and_colours() + bits() + forms()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
