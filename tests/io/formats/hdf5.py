# SPDX-License-Identifier: Apache-2.0
"""Volumes in HDF5, written by h5py."""
import io

import h5py
import numpy as np

from .cases import DIMS, TYPES, Grid, case, damaged, image, one_slice, volume


def filled(fill, **how) -> bytes:
    """A file: fill(file) makes what is in it."""
    out = io.BytesIO()
    with h5py.File(out, 'w', **how) as file:
        fill(file)
    return out.getvalue()


def stored(samples, name='volume', order='<', attributes=None, **how) -> bytes:
    """A file of one dataset, z first."""
    def fill(file):
        data = samples.T if samples.ndim else samples
        file.create_dataset(name, data=data.astype(data.dtype.newbyteorder(order)), **how)
        for key, value in (attributes or {}).items():
            file[name].attrs[key] = value
    return filled(fill)


def several() -> bytes:
    def fill(file):
        file['a/raw'] = volume('uint8').T
        file['a/labels'] = volume('int16').T
        file['b'] = volume('float32').T
        file['table'] = np.ones((7, 2))
        file['names'] = np.array([b'x', b'y'])
    return filled(fill)


def kinds():
    found = []
    for kind in TYPES:
        samples = volume(kind)
        for order, word in (('<', 'little'), ('>', 'big')):
            found.append(case(f'{kind} {word}', stored(samples, order=order), 'v.h5', Grid(samples), by_program=order == '<',
                              damage=kind == 'int16'))
    half = volume('float16')
    found.append(case('halves', stored(half), 'v.h5', Grid(half.astype('float32'))))
    found.append(case('Booleans', stored(volume('uint8') > 3), 'v.h5', Grid((volume('uint8') > 3).astype('int8'))))
    samples = volume('int16')
    for name in ('v.hdf5', 'v.hdf', 'v.H5', 'v.ims'):
        found.append(case(name, stored(samples), name, Grid(samples)))
    large = volume('uint16', (23, 17, 11))
    for chunks in ((1, 1, 1), (4, 5, 6), (11, 17, 23), (2, 17, 23), (11, 1, 1)):
        for how in ({}, dict(compression='gzip'), dict(compression='gzip', shuffle=True, fletcher32=True)):
            name = f'chunks {chunks}, ' + (', '.join(how) or 'raw')
            found.append(case(name, stored(large, chunks=chunks, **how), 'v.h5', Grid(large), by_program=chunks == (4, 5, 6),
                              damage=chunks == (4, 5, 6) and len(how) == 3))
    found.append(case('compressed by LZF', stored(large, chunks=(4, 5, 6), compression='lzf'), 'v.h5'))

    def sparse(file):
        data = file.create_dataset('v', (11, 17, 23), 'uint16', chunks=(4, 5, 6), fillvalue=7)
        data[4:8, 5:10, 6:12] = 9
    right = np.full((11, 17, 23), 7, 'uint16')
    right[4:8, 5:10, 6:12] = 9
    found.append(case('chunks that are not there', filled(sparse), 'v.h5', Grid(np.ascontiguousarray(right.T))))
    found.append(case('the newest layout', filled(lambda f: f.create_dataset('v', data=large.T, chunks=(4, 5, 6), compression='gzip'),
                                                  libver='latest'), 'v.h5', Grid(large), damage=True))
    found.append(case('compact', filled(lambda f: h5py.h5d.create(f.id, b'v', h5py.h5t.NATIVE_INT16, h5py.h5s.create_simple((3, 4, 5)), compact())
                                        .write(h5py.h5s.ALL, h5py.h5s.ALL, np.ascontiguousarray(samples.T))), 'v.h5', Grid(samples)))
    return found


def compact():
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_layout(h5py.h5d.COMPACT)
    return made


def axes():
    samples = volume('int16')
    flat = samples[:, :, 0]
    found = [case('an image', stored(flat), 'v.h5', image(flat))]
    for shape in ((1, 3, 4, 5), (3, 4, 5, 1), (1, 3, 4, 5, 1), (1, 1, 3, 4, 5), (3, 1, 4, 5)):
        found.append(case(f'axes {shape}', stored(samples.T.reshape(shape).T), 'v.h5', Grid(samples), by_program=len(shape) == 5))
    found += one_slice('axes', stored(samples[:, :, :1]), 'v.h5', Grid(samples[:, :, :1]))
    for shape in ((60,), (2, 2, 3, 5), (), (3, 0, 5)):
        data = np.zeros(int(np.prod(shape)), 'int16').reshape(shape)
        found.append(case(f'axes {shape}', stored(data.T), 'v.h5'))
        found.append(case(f'axes {shape}, named', {'v.h5': stored(data.T)}, 'v.h5:/volume'))
    return found


def names():
    data = several()
    found = [case('several', data, 'v.h5'), case('several in a group', {'v.h5': data}, 'v.h5:/a')]
    for path, kind in (('/a/raw', 'uint8'), ('a/raw', 'uint8'), ('/a/labels', 'int16'), ('/b', 'float32'), ('b', 'float32')):
        found.append(case(f'named {path}', {'v.h5': data}, f'v.h5:{path}', Grid(volume(kind)), by_program=True))
    found.append(case('named table', {'v.h5': data}, 'v.h5:/table', image(np.ones((2, 7)))))
    for path in ('/none', '/a/none', '/names', '/b/x', '/a/raw/', ':', '/../a/raw'):
        found.append(case(f'named {path}', {'v.h5': data}, f'v.h5:{path}', *([Grid(volume('uint8'))] if path == '/a/raw/' else []),
                          refusable=True))
    one = stored(volume('int16'), name='deep/in/groups')
    found.append(case('a group with one', {'v.h5': one}, 'v.h5:/deep', Grid(volume('int16'))))
    found.append(case('a name with a colon', {'v.h5': stored(volume('int16'), name='a:b')}, 'v.h5:/a:b', Grid(volume('int16'))))
    found.append(case('a folder with a colon', {'x:y/v.h5': one}, 'x:y/v.h5', Grid(volume('int16'))))

    def linked(file):
        file['v'] = volume('int16').T
        file['hard'] = file['v']
        file['soft'] = h5py.SoftLink('/v')
        file['loop'] = h5py.SoftLink('/loop')
        file.create_group('g')['up'] = file['/']
    found.append(case('links', filled(linked), 'v.h5', Grid(volume('int16'))))
    for path in ('/hard', '/soft', '/g/up/v'):
        found.append(case(f'linked {path}', {'v.h5': filled(linked)}, f'v.h5:{path}', Grid(volume('int16'))))
    found.append(case('a link in circles', {'v.h5': filled(linked)}, 'v.h5:/loop'))
    records = np.zeros((3, 4, 5), [('a', 'int16'), ('b', 'float32')])
    found.append(case('records', filled(lambda f: f.create_dataset('v', data=records)), 'v.h5'))
    found.append(case('complex numbers', stored(np.zeros(DIMS, 'complex64')), 'v.h5'))
    found.append(case('strings', filled(lambda f: f.create_dataset('v', data=np.full((3, 4, 5), b'abc'))), 'v.h5'))
    found.append(case('nothing in it', filled(lambda f: None), 'v.h5'))
    found += [case('no HDF5', b'hello' * 100, 'v.h5'), case('empty', b'', 'v.h5'), case('the mark alone', b'\x89HDF\r\n\x1a\n', 'v.h5')]
    return found


def placed():
    samples = volume('int16')
    found = []
    zyx = (2.0, 0.75, 0.5)

    def add(name, attributes, right, data=samples, opened='v.h5', **more):
        found.append(case(name, stored(data, attributes=attributes), opened, right, **more))
    add('element_size_um', {'element_size_um': zyx}, Grid(samples, zyx[::-1], units=('um',)), by_program=True)
    add('element_size_um of five axes', {'element_size_um': (1,) + zyx + (1,)}, Grid(samples, zyx[::-1], units=('um',)),
        samples.T.reshape(1, 3, 4, 5, 1).T)
    add('element_size_um of three of five axes', {'element_size_um': zyx}, Grid(samples, zyx[::-1], units=('um',)),
        samples.T.reshape(1, 3, 4, 5, 1).T)
    add('element_size_um of an image', {'element_size_um': zyx[1:]}, image(samples[:, :, 0], zyx[:0:-1], units=('um',)), samples[:, :, 0])
    add('CREMI', {'resolution': zyx, 'offset': (30.0, 20.0, 10.0)}, Grid(samples, zyx[::-1], (10, 20, 30), units=('-',)))
    add('voxel_size', {'voxel_size': np.array([40, 4, 8]), 'units': 'nm'}, Grid(samples, (8, 4, 40), units=('nm',)))
    add('spacing', {'spacing': zyx, 'unit': b'mm'}, Grid(samples, zyx[::-1], units=('mm',)))
    tags = '{"axes": [%s]}' % ', '.join(f'{{"key": "{k}", "typeFlags": 2, "resolution": {r}}}' for k, r in zip('zyx', zyx))
    add('axistags', {'axistags': tags}, Grid(samples, zyx[::-1], units=('-',)))
    add('axistags without resolutions', {'axistags': tags.replace('2.0', '0').replace('0.75', '0')}, Grid(samples, units=('-',)))
    for bad in ((0, 1, 1), (-1, 1, 1), (np.nan, 1, 1), (np.inf, 1, 1), (1, 2), (1, 2, 3, 4), 'abc', b'', (1 + 1j, 1, 1)):
        add(f'element_size_um is {bad}', {'element_size_um': bad}, Grid(samples, units=('-',)))
    for bad in ('{', '[]', '{"axes": 3}', '{"axes": [1, 2, 3]}', '{"axes": [{"resolution": "x"}, {}, {}]}'):
        add(f'axistags {bad}', {'axistags': bad}, Grid(samples, units=('-',)))
    return found


def hostile():
    found = []

    def huge(shape, **how):
        return filled(lambda f: f.create_dataset('v', shape, 'uint8', **how))
    for shape in ((2**31, 4, 5), (2**40, 4, 5), (3, 2**40, 5), (2**20, 2**20, 2**20), (3, 2**31 - 2, 2**31 - 2)):
        for how in (dict(chunks=(1, 2, 2)), dict(chunks=(1, 2, 2), compression='gzip')):
            found.append(case(f'claims {shape}, {", ".join(how)}', huge(shape, **how), 'v.h5', memory=shape == (2**20,) * 3))

    def outside(file):
        file.create_dataset('v', (3, 4, 5), 'uint8', external=[('/dev/zero', 0, h5py.h5f.UNLIMITED)])
    found.append(case('samples in a device', filled(outside), 'v.h5', Grid(np.zeros(DIMS, 'uint8')), refusable=True))
    found.append(case('a link to a file that is not there', filled(lambda f: f.__setitem__('v', h5py.ExternalLink('none.h5', '/v'))), 'v.h5'))
    samples = volume('int16')
    for how in ({}, dict(chunks=(2, 3, 3), compression='gzip', shuffle=True)):
        data = stored(samples, attributes={'element_size_um': (2.0, 0.75, 0.5)}, **how)
        for at in range(0, len(data), 29):
            changed = bytearray(data)
            changed[at] ^= 0x24
            found.append(case(f'byte {at} changed{", compressed" if how else ""}', bytes(changed), 'v.h5', Grid(samples, anything=True),
                              refusable=True))
    return found


def cases():
    found = kinds() + axes() + names() + placed() + hostile()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
