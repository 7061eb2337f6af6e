# SPDX-License-Identifier: Apache-2.0
"""NIfTI-1 in one file, plain and compressed (nifti1.h of the NIfTI Data Format Working Group); NIfTI-2 may be refused."""
import gzip
import struct
from dataclasses import replace

import numpy as np

from .cases import DIMS, ORIGIN, SPACING, TYPES, Grid, case, claims, damaged, image, one_slice, raw, rotation, volume

CODES = {'uint8': 2, 'int16': 4, 'int32': 8, 'float32': 16, 'float64': 64, 'int8': 256, 'uint16': 512, 'uint32': 768,
         'int64': 1024, 'uint64': 1280}
TO_LPS = np.diag([-1.0, -1, 1])  # its world is right, anterior, superior


def header(samples, order='<', **more) -> bytes:
    """348 bytes and 4 of "no extension". `more` replaces fields."""
    f = dict(size=348, dim=(3, *samples.shape, 1, 1, 1, 1), code=CODES.get(samples.dtype.name), bits=samples.dtype.itemsize * 8,
             pixdim=(1, *SPACING, 1, 1, 1, 1), offset=352, slope=0, inter=0, units=2, qform=0, sform=0, quatern=(0, 0, 0),
             qoffset=(0, 0, 0), srow=(0,) * 12, magic=b'n+1\0', extension=b'\0\0\0\0')
    assert set(more) <= set(f), more
    f.update(more)
    floats = [np.float32(x) for x in (*f['pixdim'], f['offset'], f['slope'], f['inter'])]
    return struct.pack(order + 'i10s18sihcB8h3fhhhh8f3fhBB4fii80s24shh6f12f16s4s', f['size'], b'', b'', 0, 0, b'r', 0, *f['dim'],
                       0, 0, 0, 0, f['code'], f['bits'], 0, *floats, 0, 0, f['units'], 0, 0, 0, 0, 0, 0, b'', b'', f['qform'],
                       f['sform'], *f['quatern'], *f['qoffset'], *f['srow'], b'', f['magic']) + f['extension']


def quaternion(matrix):
    """b, c, d of a rotation of less than 180 degrees."""
    a = np.sqrt(1 + np.trace(matrix)) / 2
    return ((matrix[2, 1] - matrix[1, 2]) / (4 * a), (matrix[0, 2] - matrix[2, 0]) / (4 * a),
            (matrix[1, 0] - matrix[0, 1]) / (4 * a))


def rows(matrix, spacing=SPACING, origin=ORIGIN):
    return tuple(np.column_stack([np.asarray(matrix) * spacing, origin]).ravel())


def anatomical(samples, matrix=np.eye(3), spacing=SPACING, origin=ORIGIN, **more) -> Grid:
    """What an affine in the file's world is in ours."""
    return Grid(samples, spacing, tuple(TO_LPS @ origin), TO_LPS @ matrix, **more)


def plain(samples, **more) -> Grid:
    """Without qform and sform: sizes of voxels and nothing else."""
    return Grid(samples, **{'spacing': SPACING, 'space': ('-',), 'units': ('mm',), **more})


def both(name, data, *right, **more):
    found = [case(f'{name}, .nii', data, 'v.nii', *right, **more)]
    if more.get('damage') or more.get('by_program'):
        found.append(case(f'{name}, .nii.gz', gzip.compress(data, mtime=0), 'v.nii.gz', *right, **more))
    return found


def encodings():
    found = []
    for kind in TYPES:
        samples = volume(kind)
        for order, word in (('<', 'little'), ('>', 'big')):
            found += both(f'{kind} {word}', header(samples, order) + raw(samples, order), plain(samples), by_program=True,
                          damage=order == '<' or kind == 'int16')
    for kind in TYPES[:8] + ['float32 of whole numbers']:
        samples = volume(kind) if kind in TYPES else volume('int16').astype('float32')
        for slope, inter in ((0.5, -1024), (2, 0), (1, 3), (-1, 0), (1.5, 10)):
            scaled = plain(samples.astype(float) * slope + inter, any_type=True)
            for order in '<>' if kind == 'int16' else '<':
                data = header(samples, order, slope=slope, inter=inter) + raw(samples, order)
                name = f'{kind} x {slope} + {inter}' + (' big' if order == '>' else '')
                found += both(name, data, scaled, damage=kind in ('uint8', 'int16') and slope == 0.5,
                              by_program=kind in ('uint8', 'int16') and slope == 0.5)
    samples = volume('int16')
    for slope, inter in ((0, 0), (0, 5), (1, 0)):
        found += both(f'slope {slope}, inter {inter}: as it is', header(samples, slope=slope, inter=inter) + raw(samples),
                      plain(samples))
    for slope, inter in ((np.nan, 0), (np.inf, 0), (1, np.nan), (2, np.inf), (np.nan, np.nan)):
        found += both(f'slope {slope}, inter {inter}', header(samples, slope=slope, inter=inter) + raw(samples), plain(samples),
                      refusable=True)
    return found


def places():
    samples = volume('uint8')
    data = raw(samples)
    found = []

    def add(name, *right, refusable=False, program=False, **fields):
        for order in '<>':
            found.extend(both(name + (', big' if order == '>' else ''), header(samples, order, **fields) + data, *right,
                              refusable=refusable or not right, by_program=program and order == '<'))
    mirror = np.diag([1.0, 1, -1])
    for what, matrix in (('straight', np.eye(3)), ('turned', rotation()), ('turned by 90', rotation((0, 0, 1), 90)),
                         ('turned by 170', rotation((3, -1, 2), 170))):
        for qfac in (1, -1, 0):  # "if pixdim[0] is 0, use 1"
            q = dict(qform=1, quatern=quaternion(matrix), qoffset=ORIGIN, pixdim=(qfac, *SPACING, 1, 1, 1, 1))
            effect = matrix @ mirror if qfac < 0 else matrix
            add(f'qform {what}, qfac {qfac}', anatomical(samples, effect), program=qfac != 0, **q)
            s = dict(sform=1, srow=rows(effect))
            if qfac:
                add(f'sform {what}, as with qfac {qfac}', anatomical(samples, effect), program=True, **s)
                add(f'both {what}, qfac {qfac}', anatomical(samples, effect), **q, **s)
            if qfac == 1:
                other = dict(sform=1, srow=rows(rotation((0, 1, 0), 30), origin=(1, 2, 3)))
                add(f'qform {what} and another sform', anatomical(samples, rotation((0, 1, 0), 30), origin=(1, 2, 3)), **q, **other)
                aligned = dict(sform=2, srow=rows(rotation((0, 1, 0), 30), origin=(1, 2, 3)))
                add(f'qform {what} and an aligned sform', anatomical(samples, rotation((0, 1, 0), 30), origin=(1, 2, 3)),
                    anatomical(samples, matrix), **q, **aligned)
    add('sform of other spacings than pixdim', anatomical(samples, spacing=(3, 4, 5)), sform=1, srow=rows(np.eye(3), (3, 4, 5)))
    for code in (1, 2, 3, 4, 5):
        add(f'sform code {code}', anatomical(samples, rotation()), sform=code, srow=rows(rotation()))
        add(f'qform code {code}', anatomical(samples, rotation()), qform=code, quatern=quaternion(rotation()), qoffset=ORIGIN)
    add('neither', plain(samples), program=True)
    add('neither, though their numbers are there', plain(samples), srow=rows(rotation()), quatern=quaternion(rotation()),
        qoffset=ORIGIN, pixdim=(-1, *SPACING, 1, 1, 1, 1))
    shear = np.array([[1, 0.2, 0], [0, 1, 0], [0, 0, 1]])
    for what, matrix in (('sheared', shear), ('zero', np.zeros((3, 3))), ('flat', np.diag([1.0, 1, 0])),
                         ('infinite', np.diag([np.inf, 1, 1])), ('not a number', np.full((3, 3), np.nan)),
                         ('huge', np.diag([3e38, 1, 1]))):
        # A qform beside it is another place, but a right one.
        add(f'sform {what}', sform=1, srow=rows(matrix))
        add(f'sform {what} beside a qform', anatomical(samples), refusable=True, sform=1, srow=rows(matrix), qform=1, qoffset=ORIGIN)
    sizes = np.linalg.norm((1.0, 1, 1))
    half_turn = 2 * np.ones((3, 3)) / sizes**2 - np.eye(3)  # about (1, 1, 1)
    add('quaternion too long', anatomical(samples, half_turn), refusable=True, qform=1, quatern=(1, 1, 1), qoffset=ORIGIN)
    add('quaternion not a number', qform=1, quatern=(np.nan, 0, 0))
    add('quaternion infinite', qform=1, quatern=(np.inf, 0, 0))
    add('qoffset not a number', qform=1, qoffset=(np.nan, 0, 0))
    for pixdim in ((0.5, 0, 2), (0.5, np.inf, 2), (0.5, np.nan, 2), (0, 0, 0)):
        # Sizes nobody filled in: 1, or refused.
        ones = [plain(samples, spacing=tuple(p or 1.0 for p in pixdim))] if np.isfinite(pixdim).all() else []
        add(f'pixdim {pixdim}', *ones, refusable=True, pixdim=(1, *pixdim, 1, 1, 1, 1))
    add('pixdim negative', plain(samples), plain(samples, direction=np.diag([1.0, -1, 1])), refusable=True,
        pixdim=(1, 0.5, -0.75, 2, 1, 1, 1, 1))
    for code, name, size in ((0, '-', 1), (1, 'm', 1000), (2, 'mm', 1), (3, 'um', 0.001)):
        kept = plain(samples, units=(name, 'μm', 'micron') if name == 'um' else (name, 'mm') if code == 0 else (name,))
        in_mm = plain(samples, units=('mm',), spacing=tuple(s * size for s in SPACING))
        for time in (0, 8, 16, 24):
            add(f'units {name}, of time {time}', kept, in_mm, program=False, units=code | time)
        far = anatomical(samples)
        in_mm = replace(far, spacing=tuple(s * size for s in SPACING), origin=tuple(o * size for o in far.origin), units=('mm',))
        add(f'units {name} with sform', replace(far, units=kept.units), in_mm, sform=1, srow=rows(np.eye(3)), units=code)
    for spacing in ((0.520832896, 0.520833731, 0.650000155), (0.488281, 0.488281, 0.625), (0.9765625, 0.9765625, 2.5000033),
                    (0.33333334, 0.33333334, 0.33333331), (0.7421875, 0.7421875, 1.25), (0.199219, 0.199219, 0.2)):
        add(f'spacing of a scanner {spacing}', plain(samples, spacing=spacing), program=True, pixdim=(1, *spacing, 1, 1, 1, 1))
    return found


def forms():
    samples = volume('int16')
    data, right = raw(samples), plain(samples)
    flat = samples[:, :, :1]
    found = []
    for dim in ((4, *DIMS, 1, 1, 1, 1), (5, *DIMS, 1, 1, 1, 1), (7, *DIMS, 1, 1, 1, 1), (3, *DIMS, 0, 0, 0, 0), (3, *DIMS, 7, 7, 7, 7)):
        found += both(f'dim {dim}', header(samples, dim=dim) + data, right, by_program=True)
    found += both('dim (2, 5, 4)', header(samples, dim=(2, 5, 4, 1, 1, 1, 1, 1)) + raw(flat),
                  image(flat[:, :, 0], SPACING[:2], units=('mm',)), by_program=True)
    found += both('dim (2, 5, 4), rest 0', header(samples, dim=(2, 5, 4, 0, 0, 0, 0, 0)) + raw(flat),
                  image(flat[:, :, 0], SPACING[:2], units=('mm',)))
    found += one_slice('dim (3, 5, 4, 1)', header(samples, dim=(3, 5, 4, 1, 1, 1, 1, 1)) + raw(flat), 'v.nii', plain(flat))
    found += both('dim (4, 5, 4, 3, 0)', header(samples, dim=(4, *DIMS, 0, 0, 0, 0)) + data, right, refusable=True)
    for dim in ((4, 5, 4, 1, 3, 1, 1, 1), (5, 5, 4, 1, 1, 3, 1, 1), (0, *DIMS, 1, 1, 1, 1), (8, *DIMS, 1, 1, 1, 1),
                (-1, *DIMS, 1, 1, 1, 1), (768, *DIMS, 1, 1, 1, 1)):
        found += both(f'dim {dim}', header(samples, dim=dim) + data)
    comment = struct.pack('<ii', 16, 6) + b'comment\0'
    extended = header(samples, offset=368, extension=b'\1\0\0\0') + comment + data
    found += both('an extension', extended, right, by_program=True, damage=True)
    swapped = header(samples, '>', offset=368, extension=b'\1\0\0\0') + struct.pack('>ii', 16, 6) + b'comment\0' + raw(samples, '>')
    found += both('an extension, big', swapped, right)
    for size in (0, -16, 15, 2**31 - 1):  # an extension that claims another size: vox_offset says where the samples are
        hostile = header(samples, offset=368, extension=b'\1\0\0\0') + struct.pack('<ii', size, 6) + b'comment\0' + data
        found += both(f'an extension of {size} bytes', hostile, right, refusable=True)
    for offset in (353, 354, 400, 512, 4096):
        found += both(f'vox_offset {offset}', header(samples, offset=offset) + b'\xa5' * (offset - 352) + data, right)
    found += both('vox_offset 0', header(samples, offset=0) + data, right, refusable=True)
    found += both('vox_offset 348', header(samples, offset=348)[:348] + data, right, refusable=True)
    for offset in (353, 472, 473, 10000, 2**31, 2.0**40, 1e30, -352, -1, 1, 347, np.nan, np.inf, 352.5):
        rights = [right] if offset in (-352, -1, 352.5, 1) else []
        found += both(f'vox_offset {offset} of a file without', header(samples, offset=offset) + data, *rights, refusable=True)
    found += both('vox_offset 1e9, compressed', header(samples, offset=1e9) + data)
    for code, name in ((0, 'unknown'), (1, 'bits'), (32, 'complex'), (128, 'RGB'), (1536, 'of 128 bits'), (1792, 'complex 128'),
                       (2304, 'RGBA'), (3, 'of no kind'), (-4, 'negative')):
        found += both(f'samples {name}', header(samples, code=code, dim=(3, 2, 2, 2, 1, 1, 1, 1)) + data)
    found += both('bitpix that does not fit', header(samples, bits=8) + data, right, refusable=True)
    for magic in (b'ni1\0', b'\0\0\0\0', b'n+3\0', b'xxxx'):
        found += both(f'magic {magic!r}', header(samples, magic=magic) + data, right, refusable=True)
    for size in (0, 347, 540, 1024):
        found += both(f'sizeof_hdr {size}', header(samples, size=size) + data, right, refusable=True)
    found.append(case('compressed, without .gz', gzip.compress(header(samples) + data), 'v.nii', right, refusable=True))
    found.append(case('plain, with .gz', header(samples) + data, 'v.nii.gz', right, refusable=True))
    whole = header(samples) + data
    found.append(case('two gzip members', gzip.compress(whole[:400]) + gzip.compress(whole[400:]), 'v.nii.gz', right))
    for back in (1, 5, 9, 30):
        changed = bytearray(gzip.compress(whole))
        changed[-back] ^= 0x55
        found.append(case(f'gzip with byte {-back} changed', bytes(changed), 'v.nii.gz', right, refusable=True))
    found.append(case('gzip of a header alone', gzip.compress(header(samples)), 'v.nii.gz'))
    for kind in ('int16', 'float64'):
        samples = volume(kind)
        found.append(case(f'NIfTI-2 {kind}', second(samples) + raw(samples), 'v.nii', plain(samples), refusable=True, damage=kind == 'int16'))
        found.append(case(f'NIfTI-2 {kind} compressed', gzip.compress(second(samples) + raw(samples)), 'v.nii.gz', plain(samples),
                          refusable=True))
    return found


def second(samples) -> bytes:
    return struct.pack('<i8shh8q3d8dq6dqq80s24sii6d12diii16s16s', 540, b'n+2\0\r\n\x1a\n', CODES[samples.dtype.name],
                       samples.dtype.itemsize * 8, 3, *samples.shape, 1, 1, 1, 1, 0, 0, 0, 1, *SPACING, 1, 1, 1, 1, 544, 1, 0, 0, 0,
                       0, 0, 0, 0, b'', b'', 0, 0, *([0.0] * 18), 0, 2, 0, b'', b'') + b'\0\0\0\0'


def sizes():
    found = []
    for name, opened, pack in (('plain', 'v.nii', bytes), ('compressed', 'v.nii.gz', gzip.compress)):
        for scaled in (False, True):
            samples = volume('int16')
            values = plain(samples * 0.5 + 1 if scaled else samples, any_type=scaled)

            def write(dims, samples=samples, scaled=scaled, pack=pack):
                scale = dict(slope=0.5, inter=1) if scaled else {}
                return pack(header(samples, dim=(3, *dims, 1, 1, 1, 1), **scale) + raw(samples))
            found += claims(name + (' scaled' if scaled else ''), values, write, opened, 2**15 - 1)
    return found


def cases():
    found = encodings() + places() + forms() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
