# SPDX-License-Identifier: Apache-2.0
"""The .vol of DGtal and Simplevol: a header as text, raw samples (version 2) or zlib ones (version 3)."""
import zlib

from .cases import DIMS, Grid, case, claims, damaged, one_slice, raw, volume


def header(dims=DIMS, size=1, version=2, endian=None, **more) -> bytes:
    """`more` replaces fields; None removes them; names with _ for -."""
    fields = {'Center-X': dims[0] // 2, 'Center-Y': dims[1] // 2, 'Center-Z': dims[2] // 2, 'X': dims[0], 'Y': dims[1], 'Z': dims[2],
              'Voxel-Size': size, 'Alpha-Color': 0, 'Voxel-Endian': endian or '0', 'Int-Endian': '0123', 'Version': version}
    fields.update({name.replace('_', '-'): value for name, value in more.items()})
    return ''.join(f'{name}: {value}\n' for name, value in fields.items() if value is not None).encode() + b'.\n'


def cases():
    found = []
    for kind in ('uint8', 'uint16', 'uint32', 'uint64'):
        samples = volume(kind)
        size = samples.dtype.itemsize
        straight = ''.join(map(str, range(size)))
        for order, endian in (('<', straight), ('>', straight[::-1])) if size > 1 else (('<', '0'),):
            for version, pack in ((2, bytes), (3, zlib.compress)):
                data = header(size=size, version=version, endian=endian) + pack(raw(samples, order))
                found.append(case(f'{kind} {endian}, version {version}', data, 'v.vol', Grid(samples, units=('-',)), damage=True,
                                  by_program=True))
    samples = volume('uint8')
    data, right = raw(samples), Grid(samples)
    for name, fields in (('no Version', dict(Version=None)), ('no Voxel-Size', dict(Voxel_Size=None)), ('no centre', dict(Center_X=None)),
                         ('no Voxel-Endian', dict(Voxel_Endian=None)), ('other fields', dict(Author='x: y'))):
        found.append(case(name, header(**fields) + data, 'v.vol', right))
    flat = volume('uint8', (5, 4, 1))
    found += one_slice('X, Y and Z', header((5, 4, 1)) + raw(flat), 'v.vol', Grid(flat))
    found.append(case('CR LF', header().replace(b'\n', b'\r\n') + data, 'v.vol', right))
    for name, fields in (('no X', dict(X=None)), ('X of words', dict(X='five')), ('a fraction', dict(X='5.0')), ('an empty X', dict(X='')),
                         ('3 bytes', dict(Voxel_Size=3)), ('0 bytes', dict(Voxel_Size=0)), ('-1 bytes', dict(Voxel_Size=-1)),
                         ('version 9', dict(Version=9)), ('version -1', dict(Version=-1))):
        found.append(case(name, header(**fields) + data, 'v.vol'))
    found.append(case('no dot', header()[:-2] + data, 'v.vol'))
    found.append(case('a line without colon', b'hello\n' + header() + data, 'v.vol', right, refusable=True))
    found.append(case('a line without end', b'X: ' + b'5' * 200000, 'v.vol'))
    found.append(case('zlib data that are none', header(version=3) + data, 'v.vol'))
    for missing in (1, 30):
        found.append(case(f'{missing} samples less in zlib data', header(version=3) + zlib.compress(data[:-missing]), 'v.vol'))
    packed = zlib.compress(data)
    for back in (1, 5, 20):
        changed = bytearray(header(version=3) + packed)
        changed[-back] ^= 0x55
        found.append(case(f'zlib data with byte {-back} changed', bytes(changed), 'v.vol', right, refusable=True))
    for name, version, pack in (('raw', 2, bytes), ('zlib', 3, zlib.compress)):
        def write(dims, version=version, pack=pack):
            return header(dims, version=version, Center_X=None, Center_Y=None, Center_Z=None) + pack(data)
        found += claims(name, right, write, 'v.vol')
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
