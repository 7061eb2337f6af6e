# SPDX-License-Identifier: Apache-2.0
"""Grey PNG files, alone and as the slices of a folder (PNG specification, 3rd edition)."""
import struct
import zlib

import numpy as np

from .cases import DIMS, Grid, case, damaged, volume


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))


def packed_rows(slice_, bits) -> list:
    """Bytes of every row of samples[x, y] of `bits` bits."""
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
    """`kind` 0 to 4 for all rows."""
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
    dims = dims or slice_.shape
    if body is None:
        if interlaced:
            passes = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
            pieces = [slice_[x::dx, y::dy] for x, y, dx, dy in passes]
            body = b''.join(filtered(packed_rows(p, bits), bits, kind) for p in pieces if p.size)
        else:
            body = filtered(packed_rows(slice_, bits), bits, kind)
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
                    found.append(case(name, png(flat[:, :, 0], bits, kind, interlaced=interlaced), 'v.png', stack(flat, bits)))
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
    flat = Grid(samples[:, :, :1])
    for name, data in (('one byte less', whole[:-1]), ('one row less', whole[:-6]), ('nothing', b''), ('filter 5', b'\5' + whole[1:])):
        found.append(case(name, png(samples[:, :, 0], body=data), 'v.png'))
    found.append(case('one byte more', png(samples[:, :, 0], body=whole + b'x'), 'v.png', flat, refusable=True))
    for bits in (0, 3, 5, 7, 24, 32):
        found.append(case(f'{bits} bits', png(samples[:, :, 0], body=whole, bits=bits, dims=(5, 4)) if bits else
                          png(samples[:, :, 0], body=whole).replace(b'\x08\0\0\0\0', b'\0\0\0\0\0', 1), 'v.png'))
    for dims in ((6, 4), (5, 5), (0, 4), (5, 0), (-1, 4), (2**31 - 1, 4), (5, 2**31), (2**31 - 1, 2**31 - 1)):
        found.append(case(f'header claims {dims}', png(samples[:, :, 0], dims=dims, body=whole), 'v.png'))
    found.append(case('header claims (5, 3)', png(samples[:, :, 0], dims=(5, 3), body=whole), 'v.png', Grid(samples[:, :3, :1]), refusable=True))
    image = png(samples[:, :, 0])
    for at in range(len(image)):
        changed = bytearray(image)
        changed[at] ^= 0x24
        found.append(case(f'byte {at} changed', bytes(changed), 'v.png', flat, refusable=True))
    return found + [c for whole_case in found if whole_case.damage for c in damaged(whole_case)]
