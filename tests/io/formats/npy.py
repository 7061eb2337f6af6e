# SPDX-License-Identifier: Apache-2.0
"""NPY (numpy.lib.format). In C order the last axis of the array is x, in Fortran order the first."""
import struct

from .cases import DIMS, INTEGERS, TYPES, Grid, case, claims, damaged, image, one_slice, raw, volume


def header(text: str, version: int = 1) -> bytes:
    size = 2 if version == 1 else 4
    text += ' ' * (-(8 + size + len(text) + 1) % 64) + '\n'
    return b'\x93NUMPY' + bytes([version, 0]) + struct.pack('<H' if size == 2 else '<I', len(text)) + text.encode()


def described(dtype, shape, fortran=True, descr=None, version=1) -> bytes:
    return header(repr({'descr': descr or dtype, 'fortran_order': fortran, 'shape': tuple(shape)}), version)


def encodings():
    found = []
    for kind in TYPES + ['float16', 'bool']:
        samples = volume(kind) if kind != 'bool' else (volume('uint8') % 2).astype(bool)
        right = Grid(samples.astype({'float16': 'float32', 'bool': 'uint8'}.get(kind, kind)), units=('-',))
        for order, word in (('<', 'little'), ('>', 'big')) if samples.dtype.itemsize > 1 else (('|', 'one byte'),):
            descr = order + samples.dtype.str[1:]
            data = samples.astype(descr).tobytes(order='F')
            for fortran in (True, False):
                shape = samples.shape if fortran else samples.shape[::-1]
                for version in (1, 2, 3):
                    content = described(None, shape, fortran, descr, version) + data
                    name = f'{kind} {word}, {"Fortran" if fortran else "C"} order, version {version}'
                    found.append(case(name, content, 'v.npy', right, damage=version == 1 and fortran, by_program=version == 1 and kind != 'bool'))
    return found


def forms():
    samples = volume('int16')
    data, right = raw(samples), Grid(samples)
    found = []
    for shape, dims in (((5, 4, 3, 1), DIMS), ((1, 5, 4, 3), DIMS), ((5, 1, 4, 3), DIMS), ((1, 12, 5), (1, 12, 5))):
        found.append(case(f'shape {shape}', described('<i2', shape) + data, 'v.npy', Grid(samples.reshape(dims, order='F'))))
    flat = samples.reshape(5, 12, order='F')
    found.append(case('two axes', described('<i2', (5, 12)) + data, 'v.npy', image(flat), by_program=True))
    found.append(case('two axes, C order', described('<i2', (12, 5), False) + data, 'v.npy', image(flat)))
    found.append(case('two axes, as a slab', described('<i2', (5, 12)) + data, 'v.npy', Grid(flat.reshape(5, 12, 1)), how=(('dimension', '3'),)))
    for shape in ((5, 12, 1), (5, 12, 1, 1), (60, 1, 1)):
        dims = shape[:3]
        found += one_slice(f'shape {shape}', described('<i2', shape) + data, 'v.npy', Grid(samples.reshape(dims, order='F')))
    for shape in ((5, 2, 2, 3), (60,), ()):
        found.append(case(f'shape {shape}', described('<i2', shape) + data, 'v.npy', refusable=True))
    for descr in ('<c8', '<M8[s]', '<U2', '|S2', '|O', '|V2', '<f16', '<i3', '<u0', 'i2x', '', '<', '?'):
        found.append(case(f'descr {descr!r}', header(repr({'descr': descr, 'fortran_order': True, 'shape': DIMS})) + data, 'v.npy'))
    found.append(case('descr of fields', header("{'descr': [('a', '<i2')], 'fortran_order': True, 'shape': (5, 4, 3), }") + data, 'v.npy'))
    for name, text in (('without blanks', "{'descr':'<i2','fortran_order':True,'shape':(5,4,3)}"),
                       ('with other quotes', '{"descr": "<i2", "fortran_order": True, "shape": (5, 4, 3,), }'),
                       ('in another order', "{'shape': (5, 4, 3), 'fortran_order': True, 'descr': '<i2', }"),
                       ('with long integers', "{'descr': '<i2', 'fortran_order': True, 'shape': (5L, 4L, 3L), }")):
        found.append(case(f'a header {name}', header(text) + data, 'v.npy', right))
    for name, text in (('empty', ''), ('without descr', "{'fortran_order': True, 'shape': (5, 4, 3)}"),
                       ('without shape', "{'descr': '<i2', 'fortran_order': True}"), ('without end', "{'descr': '<i2', 'shape': (5, 4"),
                       ('with another key', "{'descr': '<i2', 'fortran_order': True, 'shape': (5, 4, 3), 'x': 1}"),
                       ('of 40 axes', "{'descr': '<i2', 'fortran_order': True, 'shape': (" + '1, ' * 40 + ')}'),
                       ('with a fraction', "{'descr': '<i2', 'fortran_order': True, 'shape': (5, 4.5, 3)}"),
                       ('with a huge number', "{'descr': '<i2', 'fortran_order': True, 'shape': (5, 4, %d)}" % 10**30),
                       ('with order 2', "{'descr': '<i2', 'fortran_order': 2, 'shape': (5, 4, 3)}")):
        found.append(case(f'a header {name}', header(text) + data, 'v.npy'))
    whole = described('<i2', DIMS) + data
    for version in (0, 4, 255):
        found.append(case(f'version {version}', whole[:6] + bytes([version]) + whole[7:], 'v.npy'))
    for length in (0, 1, 2**16 - 1):
        found.append(case(f'header of {length} bytes', whole[:8] + struct.pack('<H', length) + whole[10:], 'v.npy'))
    second = described('<i2', DIMS, version=2) + data
    for length in (2**31, 2**32 - 1):
        found.append(case(f'header of {length} bytes, version 2', second[:8] + struct.pack('<I', length) + second[12:], 'v.npy'))
    return found


def sizes():
    found = []
    for kind in INTEGERS[2:4]:
        samples = volume(kind)

        def write(dims, samples=samples):
            return described(samples.dtype.str, dims) + raw(samples)
        found += claims(kind, Grid(samples), write, 'v.npy')
    return found


def cases():
    found = encodings() + forms() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
