# SPDX-License-Identifier: Apache-2.0
"""Zarr of version 2 and 3, OME-Zarr and N5. Most arrays are written here after the specifications; where python3-zarr is
installed, it writes the same ones, and those packed by zstd and Blosc. Arrays of Zarr are indexed z, y, x."""
import gzip
import itertools
import json
import os
import struct
import tempfile
import zlib
from dataclasses import replace

import numpy as np

from .cases import DIMS, TYPES, Grid, case, damaged, image, one_slice, volume

try:
    import numcodecs
    import zarr
except ImportError:
    numcodecs = zarr = None
    print('zarr: what python3-zarr writes, zstd and Blosc are skipped: it is not installed', flush=True)

CHUNK = (2, 3, 4)  # z, y, x of arrays of 3, 4, 5: two chunks along each axis, the last ones cut
NAME = 'v.zarr'


def crc32c(data: bytes) -> bytes:
    table = []
    for i in range(256):
        for _ in range(8):
            i = i >> 1 ^ (0x82F63B78 if i & 1 else 0)
        table.append(i)
    value = 0xFFFFFFFF
    for byte in data:
        value = table[(value ^ byte) & 255] ^ value >> 8
    return struct.pack('<I', value ^ 0xFFFFFFFF)


PACKERS = {'raw': bytes, 'zlib': lambda data: zlib.compress(data, 6), 'gzip': lambda data: gzip.compress(data, 6, mtime=0),
           'crc32c': lambda data: data + crc32c(data)}
if numcodecs:
    PACKERS['zstd'] = lambda data: bytes(numcodecs.Zstd(3).encode(data))
    for inside, shuffle in itertools.product(['lz4', 'lz4hc', 'blosclz', 'zstd', 'zlib'], [0, 1, 2]):
        def packer(data, inside=inside, shuffle=shuffle):
            return bytes(numcodecs.Blosc(inside, 5, shuffle).encode(np.frombuffer(data, np.uint16 if len(data) % 2 == 0 else np.uint8)))
        PACKERS[f'blosc {inside} {shuffle}'] = packer


def array_of(samples: np.ndarray) -> np.ndarray:
    """samples[x, y, z] as an array of Zarr."""
    return samples.transpose()


def chunks_of(array: np.ndarray, chunk, fill=0):
    """Index and samples of every chunk; those at the far ends are filled up."""
    counts = [-(-n // c) for n, c in zip(array.shape, chunk)]
    for index in itertools.product(*map(range, counts)):
        part = array[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunk))]
        whole = np.full(chunk, fill, array.dtype)
        whole[tuple(map(slice, part.shape))] = part
        yield index, whole


def zarr2(array, chunk=CHUNK, order='C', packing='raw', separator='.', fill=0, endian='<', attributes=None, missing=(), **more):
    kind = array.dtype.newbyteorder(endian).str if array.dtype.itemsize > 1 else array.dtype.str
    meta = {'zarr_format': 2, 'shape': array.shape, 'chunks': chunk, 'dtype': kind, 'order': order, 'fill_value': fill, 'filters': None,
            'compressor': None if packing == 'raw' else {'id': packing.split()[0], 'level': 6}}
    if separator != '.':
        meta['dimension_separator'] = separator
    meta.update(more)
    files = {'.zarray': json.dumps(meta).encode()}
    if attributes is not None:
        files['.zattrs'] = json.dumps(attributes).encode()
    for index, samples in chunks_of(array, chunk, 0 if fill is None or isinstance(fill, str) else fill):
        if index not in missing:
            files[separator.join(map(str, index))] = PACKERS[packing](samples.astype(kind).tobytes(order=order))
    return files


def codecs_of(packing, endian, size):
    packed = {'gzip': {'level': 6}, 'zstd': {'level': 3, 'checksum': False}, 'blosc': {'cname': 'lz4', 'clevel': 5, 'shuffle': 'shuffle', 'typesize': 2,
                                                                                       'blocksize': 0}}
    codecs = [{'name': 'bytes', 'configuration': {'endian': {'<': 'little', '>': 'big'}[endian]}} if size > 1 else {'name': 'bytes'}]
    names = [] if packing == 'raw' else packing.split('+')
    return codecs + [{'name': name.split()[0], **({'configuration': packed[name.split()[0]]} if name.split()[0] in packed else {})}
                     for name in names]


def packed_by(packing, data):
    for name in [] if packing == 'raw' else packing.split('+'):
        data = PACKERS[name](data)
    return data


def zarr3(array, chunk=CHUNK, packing='raw', endian='<', fill=0, transpose=None, encoding=None, shard=None, index_location=None,
          index_checked=True, attributes=None, missing=(), **more):
    kind = array.dtype.newbyteorder(endian)
    codecs = codecs_of(packing, endian, array.dtype.itemsize)
    if transpose:
        codecs = [{'name': 'transpose', 'configuration': {'order': list(transpose)}}] + codecs
    encoding = encoding or {'name': 'default', 'configuration': {'separator': '/'}}

    def name_of(index):
        separator = encoding.get('configuration', {}).get('separator', '/' if encoding['name'] == 'default' else '.')
        return separator.join((['c'] if encoding['name'] == 'default' else []) + list(map(str, index)))

    def packed(samples):
        return packed_by(packing, (samples.transpose(transpose) if transpose else samples).astype(kind).tobytes())
    number = 0 if isinstance(fill, str) else fill
    files = {}
    if shard:
        codecs = [{'name': 'sharding_indexed', 'configuration': {
            'chunk_shape': chunk, 'codecs': codecs,
            'index_codecs': [{'name': 'bytes', 'configuration': {'endian': 'little'}}] + ([{'name': 'crc32c'}] if index_checked else []),
            **({'index_location': index_location} if index_location else {})}}]
        for index, samples in chunks_of(array, shard, number):
            if index in missing:
                continue
            count = int(np.prod([s // c for s, c in zip(shard, chunk)]))
            begin = 16 * count + 4 * index_checked if index_location == 'start' else 0
            data, table = b'', b''
            for number_inside, (_, inner) in enumerate(chunks_of(samples, chunk)):
                if (inner == number).all() and number_inside > 0:
                    table += b'\xff' * 16
                    continue
                one = packed(inner)
                table += struct.pack('<QQ', begin + len(data), len(one))
                data += one
            table += crc32c(table) if index_checked else b''
            files[name_of(index)] = table + data if index_location == 'start' else data + table
    else:
        for index, samples in chunks_of(array, chunk, number):
            if index not in missing:
                files[name_of(index)] = packed(samples)
    meta = {'zarr_format': 3, 'node_type': 'array', 'shape': array.shape, 'data_type': array.dtype.name,
            'chunk_grid': {'name': 'regular', 'configuration': {'chunk_shape': shard or chunk}}, 'chunk_key_encoding': encoding,
            'fill_value': fill, 'codecs': codecs, 'attributes': attributes or {}}
    meta.update(more)
    return {'zarr.json': json.dumps(meta).encode(), **files}


def n5(array, chunk=CHUNK, packing='raw', cut=True, attributes=None, missing=()):
    compression = {'raw': {'type': 'raw'}, 'gzip': {'type': 'gzip', 'level': -1}, 'zlib': {'type': 'gzip', 'useZlib': True, 'level': -1}}
    meta = {'dimensions': array.shape[::-1], 'blockSize': chunk[::-1], 'dataType': array.dtype.name,
            'compression': compression.get(packing, {'type': packing.split()[0]}), **(attributes or {})}
    files = {'attributes.json': json.dumps(meta).encode()}
    for index, samples in chunks_of(array, chunk):
        if index in missing:
            continue
        if cut:
            samples = samples[tuple(slice(0, n - i * c) for n, i, c in zip(array.shape, index, chunk))]
        header = struct.pack('>HH', 0, samples.ndim) + struct.pack(f'>{samples.ndim}I', *samples.shape[::-1])
        files['/'.join(map(str, index[::-1]))] = header + PACKERS[packing](samples.astype(samples.dtype.newbyteorder('>')).tobytes())
    return files


def inside(folder, files):
    return {f'{folder}/{name}': data for name, data in files.items()}


def array_case(name, files, *right, **more):
    more.setdefault('by_program', False)
    return case(name, inside(NAME, files), NAME, *right, **more)


def of_kind(kind):
    samples = (volume('uint8') % 2).astype(bool) if kind == 'bool' else volume(kind)
    return samples, Grid(samples.astype({'float16': 'float32', 'bool': 'uint8'}.get(kind, kind)), units=('-',), space=('-',))


def types():
    found = []
    for kind in TYPES + ['float16', 'bool']:
        samples, right = of_kind(kind)
        array = array_of(samples)
        for endian in '<>' if array.dtype.itemsize > 1 else '<':
            found.append(array_case(f'version 2, {kind} {endian}', zarr2(array, endian=endian), right, by_program=kind != 'bool'))
            found.append(array_case(f'version 3, {kind} {endian}', zarr3(array, endian=endian), right, by_program=kind == 'uint16'))
        if kind not in ('float16', 'bool'):
            found.append(array_case(f'N5, {kind}', n5(array), right, by_program=True))
    return found


def packings():
    samples, right = of_kind('uint16')
    array = array_of(samples)
    found = []
    for packing in PACKERS:
        wide = packing in ('raw', 'zlib', 'gzip', 'zstd', 'blosc lz4 1')
        for order, separator in itertools.product('CF', './'):
            if packing != 'crc32c':
                found.append(array_case(f'version 2, {packing}, order {order}, {separator}', zarr2(array, order=order, packing=packing, separator=separator),
                                        right, damage=wide and order == 'C' and separator == '.'))
        if packing != 'zlib':
            found.append(array_case(f'version 3, {packing}', zarr3(array, packing=packing), right, damage=wide or packing == 'crc32c'))
        if packing not in ('raw', 'zlib', 'crc32c'):
            found.append(array_case(f'version 3, {packing}, checksum', zarr3(array, packing=packing + '+crc32c'), right))
            found.append(array_case(f'version 3, checksum, {packing}', zarr3(array, packing='crc32c+' + packing), right))
        if packing != 'crc32c':
            for cut in (True, False):
                found.append(array_case(f'N5, {packing}, blocks {"cut" if cut else "whole"}', n5(array, packing=packing, cut=cut), right,
                                        damage=wide and cut))
    return found


def version3():
    samples, right = of_kind('int32')
    array = array_of(samples)
    found = []
    for order in itertools.permutations(range(3)):
        found.append(array_case(f'transpose {order}', zarr3(array, transpose=order, packing='gzip'), right))
    for name, separator in itertools.product(('default', 'v2'), (None, '.', '/')):
        encoding = {'name': name, **({'configuration': {'separator': separator}} if separator else {})}
        found.append(array_case(f'keys {name} {separator}', zarr3(array, encoding=encoding), right))
    for where, checked, packing, order in itertools.product((None, 'start', 'end'), (True, False), ('raw', 'gzip'), (None, (2, 0, 1))):
        files = zarr3(array, chunk=(1, 2, 2), shard=(2, 2, 4), index_location=where, index_checked=checked, packing=packing, transpose=order)
        found.append(array_case(f'shards, index {where} {checked}, {packing}, {order}', files, right, damage=where is None and checked and not order))
    empty = array.copy()
    empty[:, :2] = 7
    files = zarr3(empty, chunk=(1, 2, 2), shard=(2, 2, 4), fill=7, missing=[(0, 0, 0)])
    found.append(array_case('shards with holes', files, Grid(empty.transpose())))
    for name, more in (('an unknown codec', {'codecs': [{'name': 'bytes', 'configuration': {'endian': 'little'}}, {'name': 'lzma'}]}),
                       ('no codec', {'codecs': []}), ('codecs that are no list', {'codecs': 3}),
                       ('packed before bytes', {'codecs': [{'name': 'gzip'}, {'name': 'bytes', 'configuration': {'endian': 'little'}}]}),
                       ('packed twice', {'codecs': [{'name': 'bytes', 'configuration': {'endian': 'little'}}, {'name': 'gzip'}, {'name': 'gzip'}]}),
                       ('no byte order', {'codecs': ['bytes']}), ('an unknown type', {'data_type': 'complex64'}), ('an unknown grid', {'chunk_grid': {'name': 'rectilinear'}}),
                       ('unknown keys', {'chunk_key_encoding': {'name': 'x'}}), ('another separator', {'chunk_key_encoding': {'name': 'v2', 'configuration': {'separator': '../'}}}),
                       ('a transformer', {'storage_transformers': [{'name': 'x'}]}),
                       ('a transpose of two axes', {'codecs': [{'name': 'transpose', 'configuration': {'order': [1, 0]}}, {'name': 'bytes', 'configuration': {'endian': 'little'}}]})):
        found.append(array_case(f'version 3, {name}', zarr3(array, **more)))
    return found


def fills():
    found = []
    for kind, fill, value in (('uint8', 7, 7), ('uint8', None, 0), ('int16', -5, -5), ('uint64', 2**64 - 1, 2**64 - 1), ('int64', -2**63, -2**63),
                              ('float32', 'NaN', np.nan), ('float64', 'Infinity', np.inf), ('float32', '-Infinity', -np.inf), ('float32', 0.1, 0.1),
                              ('float16', 0.1, 0.1), ('float64', 3, 3), ('uint16', 2.0, 2), ('float16', 'NaN', np.nan), ('bool', True, True)):
        samples, right = of_kind(kind)
        array = array_of(samples).copy()
        array[2:, 3:, :] = value
        array[:2, 3:, 4:] = value
        right = replace(right, samples=array.transpose().astype(right.samples.dtype))
        missing = [(1, 1, 0), (1, 1, 1), (0, 1, 1)]
        found.append(array_case(f'version 2, {kind}, fill value {fill}', zarr2(array, fill=fill, missing=missing), right))
        if fill is not None:
            found.append(array_case(f'version 3, {kind}, fill value {fill}', zarr3(array, fill=fill, missing=missing), right))
    samples, right = of_kind('float32')
    array = array_of(samples).copy()
    array[2:, 3:, :] = np.nan
    files = zarr3(array, fill='0x7fc00000', missing=[(1, 1, 0), (1, 1, 1)])
    found.append(array_case('version 3, fill value in bits', files, replace(right, samples=array.transpose())))
    for kind, fill in (('uint8', 256), ('uint8', -1), ('int8', 0.5), ('uint8', 'NaN'), ('float32', 'x'), ('float32', 1e300), ('float32', '0x7fc0'), ('uint16', [1])):
        array = array_of(of_kind(kind)[0])
        files = zarr2(array)
        files['.zarray'] = json.dumps({**json.loads(files['.zarray']), 'fill_value': fill}).encode()
        found.append(array_case(f'{kind}, fill value {fill}', files))
    samples, right = of_kind('uint16')
    array = array_of(samples).copy()
    array[2:, 3:, :] = 0
    array[2:, :, 4:] = 0
    right = replace(right, samples=array.transpose())
    found.append(array_case('N5, blocks missing', n5(array, missing=[(1, 1, 0), (1, 1, 1), (1, 0, 1)]), right))
    everything = list(itertools.product(range(2), repeat=3))
    found.append(array_case('no chunk at all', zarr2(array, fill=9, missing=everything), replace(right, samples=np.full(DIMS, 9, np.uint16))))
    return found


def shapes():
    samples, right = of_kind('int16')
    array = array_of(samples)
    found = []
    flat = samples.reshape(5, 12, order='F')
    for name, files in (('version 2', zarr2(array_of(flat), chunk=(5, 2))), ('version 3', zarr3(array_of(flat), chunk=(5, 2))), ('N5', n5(array_of(flat), chunk=(5, 2)))):
        found.append(array_case(f'{name}, two axes', files, image(flat), by_program=True))
    for shape in ((1, 3, 4, 5), (3, 1, 4, 5), (1, 1, 3, 4, 5), (3, 4, 5, 1)):
        found.append(array_case(f'shape {shape}', zarr2(array.reshape(shape), chunk=(1,) * len(shape)), right))
    for shape, dims in (((1, 12, 5), (5, 12, 1)), ((1, 1, 1, 12, 5), (5, 12, 1))):
        right_slab = Grid(samples.reshape(dims, order='F'))
        found += one_slice(f'shape {shape}', inside(NAME, zarr2(array.reshape(shape), chunk=(1,) * (len(shape) - 2) + (5, 5))), NAME, right_slab)
    for shape in ((60,), (3, 2, 2, 5), (2, 2, 3, 5, 1)):
        found.append(array_case(f'shape {shape}', zarr2(array.reshape(shape), chunk=(1,) * len(shape))))
    names = {'_ARRAY_DIMENSIONS': ['x', 'y', 'z']}
    found.append(array_case('named x, y, z', zarr2(samples, attributes=names), right))
    found.append(array_case('named y, z, x', zarr3(samples.transpose(1, 2, 0), dimension_names=['y', 'z', 'x'], packing='gzip'), right))
    for name, more in (('no shape', {'shape': None}), ('a side of 0', {'shape': [3, 0, 5]}), ('a negative side', {'shape': [3, -4, 5]}), ('a huge side', {'shape': [3, 4, 2**40]}),
                       ('huge sides', {'shape': [2**31 - 3] * 3}), ('a side of 2^64', {'shape': [3, 4, 2**64]}), ('a fraction', {'shape': [3, 4, 5.5]}), ('sides as text', {'shape': ['3', 4, 5]}),
                       ('40 axes', {'shape': [1] * 40, 'chunks': [1] * 40}), ('chunks of 0', {'chunks': [2, 0, 4]}), ('negative chunks', {'chunks': [2, -3, 4]}),
                       ('huge chunks', {'chunks': [2**20, 2**20, 2**20]}), ('chunks that wrap around', {'chunks': [2**62, 4, 1]}), ('chunks of two axes', {'chunks': [2, 3]}),
                       ('a structured type', {'dtype': [['a', '<u2']]}), ('complex numbers', {'dtype': '<c8'}), ('text', {'dtype': '<U4'}), ('objects', {'dtype': '|O'}), ('no byte order', {'dtype': '|u2'}),
                       ('16 bytes', {'dtype': '<f16'}), ('3 bytes', {'dtype': '<i3'}), ('an empty type', {'dtype': ''}), ('an order of A', {'order': 'A'}), ('a filter', {'filters': [{'id': 'delta'}]}),
                       ('bz2', {'compressor': {'id': 'bz2'}}), ('a packing without name', {'compressor': {}}), ('unicode in its packing', {'compressor': {'id': '\u00fc\n'}})):
        found.append(array_case(f'version 2, {name}', zarr2(array, **more)))
    for shape in ((4, 4, 5), (3, 5, 5), (3, 4, 6), (6, 8, 10)):  # chunks that are not there have the fill value, those at the far ends more samples than needed
        padded = np.zeros(shape, array.dtype)
        files = zarr2(array, fill=0, shape=shape)
        padded[tuple(slice(0, min(n, 2 * c)) for n, c in zip(shape, CHUNK))] = 0
        for index, part in chunks_of(array, CHUNK):
            at = tuple(slice(i * c, min((i + 1) * c, n)) for i, c, n in zip(index, CHUNK, shape))
            padded[at] = part[tuple(slice(0, s.stop - s.start) for s in at)]
        found.append(array_case(f'a shape of {shape}', files, Grid(padded.transpose())))
    return found


def transformed(*steps):
    return [{'type': 'scale' if i % 2 == 0 else 'translation', 'scale' if i % 2 == 0 else 'translation': list(step)} for i, step in enumerate(steps)]


def multiscale(axes, levels, version='0.4', whole=None):
    content = [{'version': version, 'axes': axes, 'datasets': [{'path': path, 'coordinateTransformations': steps} for path, steps in levels],
                **({'coordinateTransformations': whole} if whole else {})}]
    return {'ome': {'version': version, 'multiscales': content}} if version >= '0.5' else {'multiscales': content}


def image_of(levels, attributes, version=2):
    """An image of several arrays: {path: files}."""
    files = {}
    for path, array in levels.items():
        files.update(inside(path, array))
    if version == 3:
        files['zarr.json'] = json.dumps({'zarr_format': 3, 'node_type': 'group', 'attributes': attributes}).encode()
    else:
        files['.zgroup'] = b'{"zarr_format": 2}'
        files['.zattrs'] = json.dumps(attributes).encode()
    return inside(NAME, files)


def spaces(unit, names='zyx'):
    return [{'name': name, 'type': 'space', 'unit': unit} for name in names]


def ome():
    samples, _ = of_kind('uint16')
    array = array_of(samples)
    small = np.ascontiguousarray(array[::2, ::2, ::2])
    fine = Grid(samples, (0.5, 0.75, 2.0), (10, 20, 30), units=('um',), space=('-',))
    coarse = Grid(small.transpose(), (1.0, 1.5, 4.0), (10.25, 20.375, 31), units=('um',), space=('-',))
    levels = [('0', transformed((2, 0.75, 0.5), (30, 20, 10))), ('1', transformed((4, 1.5, 1), (31, 20.375, 10.25)))]
    found = []
    for version, write, group in (('0.4', zarr2, 2), ('0.5', zarr3, 3)):
        files = image_of({'0': write(array), '1': write(small)}, multiscale(spaces('micrometer'), levels, version), group)
        for opened, right in (('', fine), ('/0', fine), ('/1', coarse), ('/', fine), ('/1/', coarse), ('/../v.zarr/1', coarse)):
            found.append(case(f'OME {version} {opened}', files, NAME + opened, right, by_program=opened in ('', '/1'), damage=not opened))
    axes = [{'name': 't', 'type': 'time', 'unit': 'second'}, {'name': 'c', 'type': 'channel'}] + spaces('nanometer')
    steps = transformed((9, 1, 2, 0.75, 0.5), (5, 0, 30, 20, 10))
    single = image_of({'0': zarr2(array.reshape(1, 1, 3, 4, 5), chunk=(1, 1, 2, 3, 4))}, multiscale(axes, [('0', steps)]))
    found.append(case('OME, five axes', single, NAME, replace(fine, units=('nm',)), by_program=True))
    other = volume('uint16')[::-1]
    both = np.stack([array, array_of(other)])
    for chunk in (1, 2):
        many = image_of({'0': zarr2(both[np.newaxis], chunk=(1, chunk, 2, 3, 4), packing='gzip')}, multiscale(axes, [('0', steps)]))
        found.append(case(f'two channels, chunks of {chunk}', many, NAME, damage=False))
        for opened, right in ((':c=0', samples), (':c=1', other), (':c=1,t=0', other), ('/0:c=1', other)):
            found.append(case(f'two channels, chunks of {chunk}, {opened}', many, NAME + opened, replace(fine, samples=right, units=('nm',)), by_program=opened == ':c=1'))
        for opened in (':c=2', ':c=-1', ':c=1,c=1', ':d=1', ':x=1', ':c', ':', ':c=1,', ':c=1x'):
            found.append(case(f'two channels, chunks of {chunk}, {opened}', many, NAME + opened, refusable=True) if opened not in (':c=1,', ':') else
                         case(f'two channels, chunks of {chunk}, {opened}', many, NAME + opened, *([replace(fine, samples=other, units=('nm',))] if opened == ':c=1,' else []), refusable=True))
    found.append(case('one transformation of all', image_of({'a/b': zarr2(array)}, multiscale(spaces('millimeter'), [('a/b', transformed((1, 1, 1), (15, 10, 5)))], whole=transformed((2, 2, 2)))),
                      NAME, Grid(samples, (2, 2, 2), (10, 20, 30), units=('mm',))))
    mixed = spaces('micrometer')
    mixed[0]['unit'] = 'millimeter'
    found.append(case('axes in different units', image_of({'0': zarr2(array)}, multiscale(mixed, [('0', transformed((0.002, 0.75, 0.5), (0.03, 20, 10)))])), NAME, fine))
    mixed[0]['unit'] = 'parsnip'
    found.append(case('axes in unknown units', image_of({'0': zarr2(array)}, multiscale(mixed, [('0', transformed((2, 0.75, 0.5), (30, 20, 10)))])), NAME, replace(fine, units=('-',))))
    found.append(case('a mirrored axis', image_of({'0': zarr2(array)}, multiscale(spaces('micrometer'), [('0', transformed((2, -0.75, 0.5), (30, 20, 10)))])), NAME,
                      replace(fine, direction=np.diag([1.0, -1, 1]))))
    found.append(case('axes x, y, z', image_of({'0': zarr2(samples)}, multiscale(spaces('micrometer', 'xyz'), [('0', transformed((0.5, 0.75, 2), (10, 20, 30)))])), NAME, fine))
    found.append(case('version 0.1', image_of({'0': zarr2(array.reshape(1, 1, 3, 4, 5), chunk=(1, 1, 2, 3, 4))}, {'multiscales': [{'datasets': [{'path': '0'}]}]}), NAME, Grid(samples, units=('-',))))
    found.append(case('version 0.3', image_of({'0': zarr2(array)}, {'multiscales': [{'axes': ['z', 'y', 'x'], 'datasets': [{'path': '0'}]}]}), NAME, Grid(samples, units=('-',))))
    flat = samples.reshape(5, 12, order='F')
    found.append(case('an image of the plane', image_of({'0': zarr2(array_of(flat), chunk=(5, 2))}, multiscale(spaces('micrometer', 'yx'), [('0', transformed((0.75, 0.5)))])), NAME,
                      image(flat, (0.5, 0.75), units=('um',))))
    for name, attributes in (('a level that is not there', multiscale(spaces('micrometer'), [('7', transformed((1, 1, 1)))])), ('no datasets', {'multiscales': [{'datasets': []}]}),
                             ('a dataset without path', {'multiscales': [{'datasets': [{}]}]}), ('a scale of two numbers', multiscale(spaces('micrometer'), [('0', transformed((1, 1)))])),
                             ('a scale of 0', multiscale(spaces('micrometer'), [('0', transformed((1, 0, 1)))])), ('a scale of text', multiscale(spaces('micrometer'), [('0', transformed('abc'))])),
                             ('an unknown transformation', multiscale(spaces('micrometer'), [('0', [{'type': 'affine', 'affine': [1]}])])),
                             ('two axes', multiscale(spaces('micrometer', 'yx'), [('0', transformed((1, 1)))])),
                             ('a path that leads out', multiscale(spaces('micrometer'), [('../../etc', transformed((1, 1, 1)))]))):
        found.append(case(f'OME, {name}', image_of({'0': zarr2(array)}, attributes), NAME, refusable=True))
    return found


def groups():
    samples, right = of_kind('uint16')
    array = array_of(samples)
    group = {'.zgroup': b'{"zarr_format": 2}'}
    found = [case('a group of one array', inside(NAME, {**group, **inside('scan', zarr2(array))}), NAME, right),
             case('a group of two arrays', inside(NAME, {**group, **inside('a', zarr2(array)), **inside('b', zarr2(array))}), NAME, refusable=True),
             case('one of two arrays', inside(NAME, {**group, **inside('a', zarr2(array)), **inside('b', zarr2(array))}), NAME + '/b', right),
             case('an empty group', inside(NAME, group), NAME, refusable=True),
             case('a group of version 3', inside(NAME, {'zarr.json': b'{"zarr_format": 3, "node_type": "group"}', **inside('scan', zarr3(array))}), NAME, right),
             case('a folder without metadata', inside(NAME, {'readme': b'x'}), NAME, refusable=True),
             case('N5 of levels', inside('v.n5', {'attributes.json': b'{"n5": "2.0.0"}', **inside('s1', n5(array[::2, ::2, ::2])), **inside('s0', n5(array))}), 'v.n5', right)]
    wells = image_of({'0': zarr2(array)}, multiscale(spaces('micrometer'), [('0', transformed((2, 0.75, 0.5)))]))
    layout = {NAME + '/.zgroup': b'{"zarr_format": 2}', NAME + '/.zattrs': b'{"bioformats2raw.layout": 3}', NAME + '/OME/.zgroup': b'{"zarr_format": 2}',
              **{name.replace(NAME, NAME + '/0'): data for name, data in wells.items()}}
    found.append(case('as bioformats2raw writes it', layout, NAME, Grid(samples, (0.5, 0.75, 2.0), units=('um',))))
    placed = Grid(samples, (0.5, 0.75, 2.0), units=('um',))
    for name, attributes, grid in (
            ('pixelResolution', {'pixelResolution': {'dimensions': [0.5, 0.75, 2], 'unit': 'um'}}, placed),
            ('resolution', {'resolution': [0.5, 0.75, 2], 'units': ['um', 'um', 'um'], 'offset': [10, 20, 30]}, replace(placed, origin=(10, 20, 30))),
            ('downsamplingFactors', {'pixelResolution': {'dimensions': [0.25, 0.25, 2], 'unit': 'um'}, 'downsamplingFactors': [2, 3, 1]}, replace(placed, origin=(0.125, 0.25, 0))),
            ('transform', {'transform': {'axes': ['z', 'y', 'x'], 'units': ['um'] * 3, 'scale': [2, 0.75, 0.5], 'translate': [30, 20, 10]}}, replace(placed, origin=(10, 20, 30)))):
        found.append(array_case(f'N5, {name}', n5(array, attributes=attributes), grid, by_program=True))
    return found


def stored(make):
    """The files that python3-zarr writes."""
    with tempfile.TemporaryDirectory() as folder:
        make(folder)
        files = {}
        for root, _, names in os.walk(folder):
            for name in names:
                path = os.path.join(root, name)
                with open(path, 'rb') as file:
                    files[os.path.relpath(path, folder)] = file.read()
    return files


def by_python():
    if not zarr:
        return []
    found = []
    packers = [None, numcodecs.Zlib(6), numcodecs.GZip(6), numcodecs.Zstd(3)] + [numcodecs.Blosc(inside, 5, shuffle)
                                                                                 for inside in ('lz4', 'zstd', 'blosclz') for shuffle in (0, 1, 2)]
    for kind in ('uint8', 'uint16', '>i4', 'int64', 'float32', '>f8', 'float16', 'bool'):
        samples, right = of_kind(np.dtype(kind).name)
        array = array_of(samples).astype(kind)
        for packer, order, separator in itertools.product(packers, 'CF', './'):
            if (order == 'F' or separator == '/') and kind not in ('uint16', '>i4'):
                continue

            def make(folder, array=array, packer=packer, order=order, separator=separator):
                zarr.open(zarr.DirectoryStore(folder, dimension_separator=separator), 'w', shape=array.shape, chunks=CHUNK, dtype=array.dtype, order=order,
                          compressor=packer)[:] = array
            found.append(array_case(f'python3-zarr, {kind}, {packer}, {order}, {separator}', stored(make), right))
    for kind, packer in itertools.product(('uint8', 'uint16', 'int32', 'float64'), packers[:4] + packers[5:6]):
        samples, right = of_kind(kind)
        array = array_of(samples)

        def make(folder, array=array, packer=packer):
            zarr.open(zarr.N5Store(folder), 'w', shape=array.shape, chunks=CHUNK, dtype=array.dtype, compressor=packer)[:] = array
        found.append(array_case(f'python3-zarr, N5, {kind}, {packer}', stored(make), right))
    samples, right = of_kind('float32')

    def sparse(folder):
        array = zarr.open(folder, 'w', shape=DIMS[::-1], chunks=CHUNK, dtype='f4', fill_value=np.nan)
        array[:2, :3, :4] = array_of(samples)[:2, :3, :4]
    holes = np.full(DIMS[::-1], np.nan, np.float32)
    holes[:2, :3, :4] = array_of(samples)[:2, :3, :4]
    found.append(array_case('python3-zarr, a chunk of NaN', stored(sparse), replace(right, samples=holes.transpose())))
    return found


def damaged_once(whole):
    """As damaged(), of the metadata, the first chunk and the last one: the others are read as these."""
    last = list(whole.files)[-1].split('/')[-1]
    first = next((name for name in whole.files if name[-1] == '0' and '.z' not in name[-5:]), '')
    chosen = {name: data for name, data in whole.files.items() if name.endswith(('json', '.zarray', '.zattrs', '/' + last)) or name == first}
    return [replace(c, files={**whole.files, **c.files}) for c in damaged(replace(whole, files=chosen))]


def cases():
    found = types() + packings() + version3() + fills() + shapes() + ome() + groups() + by_python()
    return found + [c for whole in found if whole.damage for c in damaged_once(whole)]
