# SPDX-License-Identifier: Apache-2.0
"""PNG files of every kind, alone and as the slices of a folder (PNG specification, 3rd edition)."""
import struct
import zlib

import numpy as np

from . import pictures
from .cases import DIMS, Grid, case, damaged, image, volume


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))


def packed_rows(slice_, bits) -> list:
    """Bytes of every row of samples[x, y] or samples[x, y, channel] of `bits` bits."""
    if slice_.ndim == 3:
        return [row.astype('>u2' if bits == 16 else 'u1').tobytes() for row in slice_.transpose(1, 0, 2)]
    if bits == 16:
        return [row.astype('>u2').tobytes() for row in slice_.T]
    if bits == 8:
        return [row.astype('u1').tobytes() for row in slice_.T]
    found = []
    for row in slice_.T:
        digits = ''.join(f'{int(v):0{bits}b}' for v in row)
        digits += '0' * (-len(digits) % 8)
        found.append(int(digits, 2).to_bytes(len(digits) // 8, 'big'))
    return found


def filtered(rows, bits, kind) -> bytes:
    """`kind` 0 to 4 for all rows; `bits` of a pixel."""
    step = max(1, bits // 8)
    above = bytes(len(rows[0])) if rows else b''
    out = b''
    for row in rows:
        out += bytes([kind])
        for i, value in enumerate(row):
            a = row[i - step] if i >= step else 0
            b, c = above[i], above[i - step] if i >= step else 0
            p = a + b - c
            paeth = min((abs(p - v), k, v) for k, v in enumerate((a, b, c)))[2]
            out += bytes([(value - (0, a, b, (a + b) // 2, paeth)[kind]) % 256])
        above = row
    return out


def png(slice_, bits=8, kind=0, colour=0, dims=None, body=None, interlaced=False, before=b'', parts=1) -> bytes:
    dims = dims or slice_.shape[:2]
    if body is None:
        pixel = bits * (slice_.shape[2] if slice_.ndim == 3 else 1)
        if interlaced:
            passes = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
            pieces = [slice_[x::dx, y::dy] for x, y, dx, dy in passes]
            body = b''.join(filtered(packed_rows(p, bits), pixel, kind) for p in pieces if p.size)
        else:
            body = filtered(packed_rows(slice_, bits), pixel, kind)
    data = zlib.compress(body)
    step = -(-len(data) // parts)
    head = struct.pack('>IIBBBBB', *(d % 2**32 for d in dims), bits, colour, 0, 0, int(interlaced))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + before
            + b''.join(chunk(b'IDAT', data[i:i + step]) for i in range(0, len(data), step)) + chunk(b'IEND', b''))


def stack(samples, bits):
    """What a folder of slices of `bits` bits is: fewer than 8 are stretched to 255."""
    return Grid(samples * np.uint8(255 // (2**bits - 1)) if bits < 8 else samples, units=('-',))


def one_bit(bits, dims=DIMS):
    return (volume('uint8', dims) >> (8 - bits)).astype('uint8') if bits < 8 else volume('uint8' if bits == 8 else 'uint16', dims)


def folder(samples, name='{}.png', **more):
    return {name.format(z): png(samples[:, :, z], **more) for z in range(samples.shape[2])}


COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # of so many channels


def coloured():
    """Every colour type with more than one channel, and every channel of it."""
    found = []
    for bits in (8, 16):
        for channels in (2, 3, 4):
            for dims in ((13, 9), (1, 1), (1, 7), (6, 1)):
                pixels = pictures.random_pixels(dims, channels, bits)
                for interlaced in (False, True):
                    data = png(pixels, bits, 4 if interlaced else 1, COLOUR_TYPES[channels], interlaced=interlaced)
                    name = f'{dims} of {channels} channels of {bits} bits' + (', interlaced' if interlaced else '')
                    found += pictures.channel_cases(name, data, 'v.png', pixels, damage=dims == (13, 9) and interlaced)
            stencil = pictures.stencil(channels, bits)
            if channels % 2 == 0:
                found += pictures.channel_cases(f'stencil of {channels} channels of {bits} bits',
                                                png(stencil, bits, colour=COLOUR_TYPES[channels]), 'v.png', stencil)
    rgb = np.stack([pictures.random_pixels((5, 4), 3, 8) for _ in range(3)], axis=2)
    names = {f'{z}.png': png(rgb[:, :, z], 8, colour=2) for z in range(3)}
    found.append(case('folder of RGB', names, '.'))
    for channel in ('luminance', 'red', 'green', 'blue'):
        found.append(case(f'folder of RGB, {channel}', names, '.', Grid(pictures.value(rgb, channel)), how=(('channel', channel),)))
    found.append(case('folder of RGB, alpha', names, '.', usage=True, how=(('channel', 'alpha'),)))
    greys = folder(volume('uint8'))
    found.append(case('folder of greys, red', greys, '.', Grid(volume('uint8')), how=(('channel', 'red'),)))
    found.append(case('folder of one slice', {'1.png': greys['1.png']}, '.', usage=True))
    found.append(case('folder of one slice, a slab', {'1.png': greys['1.png']}, '.', Grid(volume('uint8')[:, :, 1:2]), how=(('dimension', '3'),)))
    found.append(case('folder of one slice, an image', {'1.png': greys['1.png']}, '.', image(volume('uint8')[:, :, 1]), how=(('dimension', '2'),)))
    found.append(case('folder as an image', greys, '.', usage=True, how=(('dimension', '2'),)))
    found.append(case('image as a slab', greys['1.png'], 'v.png', Grid(volume('uint8')[:, :, 1:2]), how=(('dimension', '3'),)))
    return found


def palettes():
    found = []
    random = np.random.default_rng(7)
    for bits in (1, 2, 4, 8):
        indices = one_bit(bits, (13, 9, 1))[:, :, 0]
        for name, colours in (('colours', random.integers(0, 256, (2**bits, 3))), ('greys', random.integers(0, 256, (2**bits, 1)).repeat(3, 1))):
            plte = chunk(b'PLTE', colours.astype('u1').tobytes())
            alphas = np.full(2**bits, 255)
            alphas[:2**(bits - 1)] = random.integers(0, 256, 2**(bits - 1))
            alphas[0] = 3
            trns = chunk(b'tRNS', alphas[:2**(bits - 1)].astype('u1').tobytes())
            for interlaced in (False, True):
                for before, table in ((plte, colours), (plte + trns, np.column_stack([colours, alphas]))):
                    if name == 'greys':
                        table = table[:, [0] + [3] * (table.shape[1] == 4)]
                    data = png(indices, bits, 2, 3, before=before, interlaced=interlaced)
                    pixels = table[indices].astype('uint8')
                    what = f'palette of {name}{", transparent" if before != plte else ""}, {bits} bits' + (', interlaced' if interlaced else '')
                    found += pictures.channel_cases(what, data, 'v.png', pixels, damage=bits == 4 and not interlaced)
    indices = one_bit(2, (13, 9, 1))[:, :, 0]
    plte = chunk(b'PLTE', bytes(range(9)))  # three colours, and index 3 is used
    assert indices.max() == 3
    for name, before in (('wrong index', plte), ('palette of 7 bytes', chunk(b'PLTE', bytes(7))), ('palette twice', plte * 2),
                         ('tRNS before the palette', chunk(b'tRNS', b'\0') + plte), ('tRNS too long', plte + chunk(b'tRNS', bytes(4))),
                         ('palette of 300 colours', chunk(b'PLTE', bytes(900)))):
        found.append(case(name, png(indices, 2, colour=3, before=before), 'v.png'))
    return found


def keyed():
    """One colour of a picture without alpha is transparent."""
    found = []
    for bits in (1, 4, 8, 16):
        greys = one_bit(bits, (13, 9, 1))[:, :, 0]
        key = int(greys[3, 3])
        scaled = (greys * np.uint8(255 // (2**bits - 1)) if bits < 8 else greys)
        alpha = np.where(greys == key, 0, 65535 if bits == 16 else 255).astype(scaled.dtype)
        data = png(greys, bits, before=chunk(b'tRNS', struct.pack('>H', key)))
        found += pictures.channel_cases(f'grey of {bits} bits with a transparent one', data, 'v.png', np.stack([scaled, alpha], axis=2),
                                        pillow=bits == 8)  # it compares values that are stretched with one that is not
    for bits in (8, 16):
        rgb = pictures.random_pixels((13, 9), 3, bits)
        rgb[2:5, 2:5] = rgb[0, 0]
        alpha = np.where((rgb == rgb[0, 0]).all(axis=2), 0, 2**bits - 1).astype(rgb.dtype)
        data = png(rgb, bits, colour=2, before=chunk(b'tRNS', struct.pack('>3H', *map(int, rgb[0, 0]))))
        found += pictures.channel_cases(f'RGB of {bits} bits with a transparent one', data, 'v.png', np.dstack([rgb, alpha]))
    found.append(case('tRNS of another kind', png(one_bit(8, (13, 9, 1))[:, :, 0], before=chunk(b'tRNS', bytes(6))), 'v.png'))
    return found


def cases():
    found = []
    for bits in (1, 2, 4, 8, 16):
        samples = one_bit(bits)
        found.append(case(f'folder of {bits} bits', folder(samples, bits=bits), '.', stack(samples, bits), damage=True, by_program=True))
        for dims in ((13, 9, 1), (1, 1, 1), (8, 1, 1), (1, 9, 1)):
            flat = one_bit(bits, dims)
            for kind in range(5):
                for interlaced in (False, True):
                    name = f'{dims[0]} x {dims[1]} of {bits} bits, filter {kind}' + (', interlaced' if interlaced else '')
                    found.append(case(name, png(flat[:, :, 0], bits, kind, interlaced=interlaced), 'v.png', image(stack(flat, bits).samples)))
    samples = volume('uint8')
    right = Grid(samples)
    found.append(case('numbers without zeros', folder(volume('uint8', (5, 4, 12)), 'slice{}.png'), '.', Grid(volume('uint8', (5, 4, 12)))))
    found.append(case('capitals', folder(samples, 'S{}.PNG'), '.', right))
    found.append(case('other files beside', {**folder(samples), 'notes.txt': b'x', '.hidden.png': b'x'}, '.', right))
    first = {**folder(samples)}
    found.append(case('several IDAT', {**first, '1.png': png(samples[:, :, 1], parts=3)}, '.', right))
    resolution = chunk(b'pHYs', struct.pack('>IIB', 2835, 2835, 1)) + chunk(b'tEXt', b'Title\0x')
    found.append(case('with pHYs and tEXt', {**first, '1.png': png(samples[:, :, 1], before=resolution)}, '.', right))
    palette = chunk(b'PLTE', b''.join(bytes([v] * 3) for v in range(256)))
    found.append(case('palette of greys', {**first, '1.png': png(samples[:, :, 1], colour=3, before=palette)}, '.', right))
    colours = chunk(b'PLTE', b''.join(bytes([v, 0, v]) for v in range(256)))
    refused = {'palette of colours': png(samples[:, :, 1], colour=3, before=colours), 'palette missing': png(samples[:, :, 1], colour=3),
               'palette too short': png(samples[:, :, 1], colour=3, before=chunk(b'PLTE', palette[8:17])),
               'another size': png(samples[:4, :, 1]), 'another type': png(volume('uint16')[:, :, 1], 16), 'no PNG': b'hello' * 20,
               'empty': b'', 'a necessary chunk nobody knows': png(samples[:, :, 1], before=chunk(b'ABCD', b''))}
    for colour, channels in ((2, 3), (4, 2), (6, 4)):
        body = filtered([bytes(range(5 * channels))] * 4, 8, 0)
        refused[f'colour type {colour}'] = png(samples[:, :, 1], colour=colour, body=body)
    for name, data in refused.items():
        found.append(case(f'{name} in a folder', {**first, '1.png': data}, '.'))
    # Numbered slices are complete; free names are taken in their order.
    long = volume('uint8', (5, 4, 12))
    numbered = folder(long, 'img_{:04}.png')
    found.append(case('a slice is missing', {name: data for name, data in numbered.items() if '0006' not in name}, '.'))
    found.append(case('a number twice', {**numbered, 'img_6.png': numbered['img_0006.png']}, '.'))
    found.append(case('a preview among the slices', {**numbered, 'preview.png': numbered['img_0006.png']}, '.'))
    found.append(case('numbers in steps of 5', {f's{5 * z}.png': png(long[:, :, z]) for z in range(12)}, '.', Grid(long)))
    found.append(case('free names', {f'{name}.png': png(samples[:, :, z]) for z, name in enumerate(('a', 'b7', 'c'))}, '.', right))
    found.append(case('a folder of PNG and TIFF', {**first, 'x.tif': b'II*\0'}, '.'))
    whole = filtered(packed_rows(samples[:, :, 0], 8), 8, 0)
    flat = image(samples[:, :, 0])
    for name, data in (('one byte less', whole[:-1]), ('one row less', whole[:-6]), ('nothing', b''), ('filter 5', b'\5' + whole[1:])):
        found.append(case(name, png(samples[:, :, 0], body=data), 'v.png'))
    found.append(case('one byte more', png(samples[:, :, 0], body=whole + b'x'), 'v.png', flat, refusable=True))
    for bits in (0, 3, 5, 7, 24, 32):
        found.append(case(f'{bits} bits', png(samples[:, :, 0], body=whole, bits=bits, dims=(5, 4)) if bits else
                          png(samples[:, :, 0], body=whole).replace(b'\x08\0\0\0\0', b'\0\0\0\0\0', 1), 'v.png'))
    for dims in ((6, 4), (5, 5), (0, 4), (5, 0), (-1, 4), (2**31 - 1, 4), (5, 2**31), (2**31 - 1, 2**31 - 1)):
        found.append(case(f'header claims {dims}', png(samples[:, :, 0], dims=dims, body=whole), 'v.png'))
    found.append(case('header claims (5, 3)', png(samples[:, :, 0], dims=(5, 3), body=whole), 'v.png', image(samples[:, :3, 0]), refusable=True))
    bytes_ = png(samples[:, :, 0])
    for at in range(len(bytes_)):
        changed = bytearray(bytes_)
        changed[at] ^= 0x24
        found.append(case(f'byte {at} changed', bytes(changed), 'v.png', flat, refusable=True))
    found += coloured() + palettes() + keyed()
    return found + [c for whole_case in found if whole_case.damage for c in damaged(whole_case)]
