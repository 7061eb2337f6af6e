# SPDX-License-Identifier: Apache-2.0
"""MRC and CCP4 maps (MRC2014: Cheng et al. 2015, ccpem.ac.uk/mrc_format/mrc2014.php)."""
import itertools
import struct

import numpy as np

from .cases import DIMS, SPACING, Grid, case, claims, damaged, one_slice, raw, volume

MODES = {'int8': 0, 'int16': 1, 'float32': 2, 'uint16': 6, 'float16': 12}
IMOD = 1146047817


def header(samples, order='<', **more) -> bytes:
    """1024 bytes. `more` replaces fields; x, y, z of cells are along X, Y, Z, of n and start along columns, rows, sections."""
    n = samples.shape
    f = dict(n=n, mode=MODES.get(samples.dtype.name), start=(0, 0, 0), m=None, cell=None, angles=(90, 90, 90), axes=(1, 2, 3),
             group=1, symmetry=0, kind=b'\0' * 4, version=20140, origin=(0, 0, 0), map=b'MAP ', imod=0, flags=0,
             stamp=b'\x44\x44\0\0' if order == '<' else b'\x11\x11\0\0')
    assert set(more) <= set(f), more
    f.update(more)
    along = [0, 0, 0]
    for size, axis in zip(n, f['axes']):
        if 1 <= axis <= 3:
            along[axis - 1] = size
    m = f['m'] or tuple(along)
    cell = f['cell'] or tuple(s * k for s, k in zip(SPACING, m))
    extra = bytearray(100)
    extra[8:12] = f['kind']
    extra[12:16] = struct.pack(order + 'i', f['version'])
    extra[56:64] = struct.pack(order + 'ii', f['imod'], f['flags'])  # bytes 152 to 159 of the file
    return struct.pack(order + '3ii3i3i3f3f3i3fii100s3f4s4sfi800s', *f['n'], f['mode'], *f['start'], *m, *cell, *f['angles'],
                       *f['axes'], 0, 0, 0, f['group'], f['symmetry'], bytes(extra), *f['origin'], f['map'], f['stamp'], 0, 0, b'')


def mapped(samples, **more) -> Grid:
    return Grid(samples, **{'spacing': SPACING, 'units': ('Å', 'A', 'angstrom', 'Angstrom', '-'), 'space': ('-',), **more})


def encodings():
    found = []
    for kind in MODES:
        samples = volume(kind)
        right = mapped(samples.astype('float32') if kind == 'float16' else samples)
        for order, word in (('<', 'little'), ('>', 'big')):
            for opened in ('v.mrc', 'v.map'):
                found.append(case(f'{kind} {word}, {opened}', header(samples, order) + raw(samples, order), opened, right,
                                  damage=opened == 'v.mrc' and (order == '<' or kind == 'int16'), by_program=opened == 'v.mrc'))
    samples = volume('uint8')
    bytes_of = header(samples, mode=0, imod=IMOD, flags=0) + raw(samples)
    found.append(case('bytes without sign of IMOD', bytes_of, 'v.mrc', mapped(samples)))
    signed = volume('int8')
    found.append(case('bytes with sign of IMOD', header(signed, mode=0, imod=IMOD, flags=1) + raw(signed), 'v.mrc', mapped(signed)))
    found.append(case('flags without the stamp of IMOD', header(signed, mode=0, imod=5, flags=0) + raw(signed), 'v.mrc', mapped(signed)))
    samples = volume('int16')
    for order, stamps in (('<', (b'\x44\x41\0\0', b'\x44\x44\x44\x44', b'\x41\x41\0\0')), ('>', (b'\x11\x11\x11\x11', b'\x11\0\0\0'))):
        for stamp in stamps:
            found.append(case(f'stamp {stamp.hex()}', header(samples, order, stamp=stamp) + raw(samples, order), 'v.mrc',
                              mapped(samples), refusable=stamp in (b'\x41\x41\0\0', b'\x11\0\0\0')))
        word = 'little' if order == '<' else 'big'
        for stamp in (b'\0\0\0\0', b'\x12\x34\x56\x78', b'\x11\x11\0\0' if order == '<' else b'\x44\x44\0\0'):
            found.append(case(f'{word}, though the stamp is {stamp.hex()}', header(samples, order, stamp=stamp) + raw(samples, order),
                              'v.mrc', mapped(samples), refusable=True))
    old = header(samples, map=b'\0\0\0\0', stamp=b'\0\0\0\0', axes=(1, 2, 3)) + raw(samples)
    found.append(case('without MAP and stamp', old, 'v.mrc', mapped(samples), refusable=True))
    found.append(case('MAP with a zero', header(samples, map=b'MAP\0') + raw(samples), 'v.mrc', mapped(samples)))
    for size in (80, 160, 1024, 7):
        for kind in (b'CCP4', b'FEI1', b'\0\0\0\0'):
            data = header(samples, symmetry=size, kind=kind) + b'\xa5' * size + raw(samples)
            found.append(case(f'extended header of {size} bytes {kind!r}', data, 'v.mrc', mapped(samples), by_program=size == 160,
                              damage=size == 80 and kind == b'CCP4'))
    big = header(samples, '>', symmetry=80) + b'\xa5' * 80 + raw(samples, '>')
    found.append(case('extended header, big', big, 'v.mrc', mapped(samples)))
    for size in (-1, -1024, 119, 120, 2**31 - 1):
        found.append(case(f'extended header of {size} bytes that is not there', header(samples, symmetry=size) + raw(samples), 'v.mrc'))
    flat = volume('int16', (5, 4, 1))
    found += one_slice('NZ 1', header(flat) + raw(flat), 'v.mrc', mapped(flat))
    return found


def places():
    samples = volume('int16')
    data = raw(samples)
    found = []

    def add(name, right, refusable=False, **fields):
        found.append(case(name, header(samples, **fields) + data, 'v.mrc', *([right] if right else []),
                          refusable=refusable or right is None, by_program=bool(right) and not refusable))
    for axes in itertools.permutations((1, 2, 3)):
        # samples[c, r, s]; axis i of the file is X, Y or Z.
        order = [axes.index(k) for k in (1, 2, 3)]
        turned = samples.transpose(order)
        for what, fields, origin in (
                ('', {}, (0, 0, 0)),
                (' with NXSTART', dict(start=(-3, 7, 10)), [(-3, 7, 10)[order[k]] * SPACING[k] for k in range(3)]),
                (' with ORIGIN', dict(origin=(10, 20, 30)), (10, 20, 30))):
            for byte_order, word in (('<', ''), ('>', ' big')):
                content = header(samples, byte_order, axes=axes, **fields) + raw(samples, byte_order)
                found.append(case(f'axes {axes}{what}{word}', content, 'v.mrc', mapped(turned, origin=tuple(origin), any_axes=True),
                                  by_program=not what))
        for dims in ((6, 4, 3), (5, 4, 4)):
            found.append(case(f'axes {axes}, header claims {dims}', header(samples, n=dims, axes=axes) + data, 'v.mrc'))
    found.append(case('axes (3, 2, 1), cut', header(samples, axes=(3, 2, 1)) + data, 'v.mrc', mapped(samples.transpose(2, 1, 0), any_axes=True),
                      damage=True))
    for axes in ((1, 1, 2), (1, 2, 2), (1, 2, 4), (-1, 2, 3), (0, 1, 2), (2**31 - 1, 2, 3)):
        add(f'axes {axes}', None, axes=axes)
    add('axes (0, 0, 0)', mapped(samples), True, axes=(0, 0, 0), m=DIMS)  # nobody filled them in
    # MRC2014, note 10: "ORIGIN specifies the real space location of a subvolume taken from a larger volume"; maps of EMDB
    # and CCP4 leave it 0 and say where they are by NXSTART.
    add('both NXSTART and ORIGIN', mapped(samples, origin=(10, 20, 30)), start=(-3, 7, 10), origin=(10, 20, 30))
    for angles in ((90, 90, 120), (60, 90, 90), (90, 100, 90), (90, 90, 89)):
        add(f'angles {angles}', None, angles=angles)
    for angles in ((np.nan, 90, 90), (np.inf, 90, 90)):
        add(f'angles {angles}', mapped(samples), True, angles=angles)
    add('angles (0, 0, 0)', mapped(samples), True, angles=(0, 0, 0))  # nobody filled them in
    add('angles (90.00001, 90, 90)', mapped(samples), angles=(90.00001, 90, 90))
    add('a part of the cell', mapped(samples), m=(50, 40, 30))
    add('MX 0', mapped(samples, spacing=(1, 1, 1)), True, m=(0, 0, 0), cell=(2.5, 3, 6))
    add('MX -5', None, m=(-5, 4, 3), cell=(2.5, 3, 6))
    for cell in ((0.0, 0.0, 0.0), (0.0, 3, 6)):
        add(f'cell {cell}', mapped(samples, spacing=tuple(c / n or 1.0 for c, n in zip(cell, DIMS))), True, cell=cell)
    for cell in ((np.nan, 3, 6), (np.inf, 3, 6), (-2.5, 3, 6)):
        add(f'cell {cell}', None, cell=cell)
    add('ORIGIN not a number', None, origin=(np.nan, 0, 0))
    for start in (2**31 - 1, -2**31):
        add(f'NXSTART {start}', mapped(samples, origin=(start * SPACING[0], 0, 0)), True, start=(start, 0, 0))
    return found


def forms():
    samples = volume('int16')
    data = raw(samples)
    flat = samples[:, :, :1]
    found = [case('one section', header(flat, group=0) + raw(flat), 'v.mrc', mapped(flat), how=(('dimension', '3'),)),
             case('a stack of images', header(samples, group=0, m=(5, 4, 1), cell=(2.5, 3, 2)) + data, 'v.mrc', mapped(samples)),
             case('a stack of volumes', header(samples, group=401, m=(5, 4, 1), cell=(2.5, 3, 2)) + data, 'v.mrc', mapped(samples),
                  refusable=True)]
    for mode in (3, 4, 5, 7, 16, 101, -1, 2**31 - 1):
        found.append(case(f'mode {mode}', header(samples, mode=mode, n=(2, 2, 2)) + data, 'v.mrc'))
    found.append(case('no MRC', b'x' * 2000, 'v.mrc'))
    found.append(case('a header alone', header(samples), 'v.mrc'))
    return found


def sizes():
    found = []
    for kind in ('int16', 'float32'):
        samples = volume(kind)
        for order in '<>':
            def write(dims, samples=samples, order=order):
                return header(samples, order, n=dims, m=DIMS) + raw(samples, order)
            found += claims(f'{kind} {order}', mapped(samples), write, 'v.mrc', 2**31 - 1)
    return found


def cases():
    found = encodings() + places() + forms() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
