# SPDX-License-Identifier: Apache-2.0
"""MetaImage: .mha, .mhd with data files (itk.org/Wiki/ITK/MetaIO/Documentation)."""
import gzip
import zlib

import numpy as np

from .cases import ORIGIN, SPACING, TYPES, Grid, case, claims, damaged, image, one_slice, raw, rotation, slices, volume

NAMES = {'int8': 'MET_CHAR', 'uint8': 'MET_UCHAR', 'int16': 'MET_SHORT', 'uint16': 'MET_USHORT', 'int32': 'MET_INT',
         'uint32': 'MET_UINT', 'int64': 'MET_LONG_LONG', 'uint64': 'MET_ULONG_LONG', 'float32': 'MET_FLOAT',
         'float64': 'MET_DOUBLE'}


def header(samples, data_file='LOCAL', end='\n', separator=' = ', **more) -> bytes:
    """`more` replaces fields or adds them; None removes them."""
    fields = {'ObjectType': 'Image', 'NDims': 3, 'BinaryData': 'True', 'BinaryDataByteOrderMSB': 'False', 'CompressedData': 'False',
              'Offset': '%g %g %g' % ORIGIN, 'ElementSpacing': '%g %g %g' % SPACING, 'DimSize': '%d %d %d' % samples.shape,
              'ElementType': NAMES[samples.dtype.name]}
    fields.update(more)
    fields['ElementDataFile'] = data_file
    return ''.join(f'{k}{separator}{v}{end}' for k, v in fields.items() if v is not None).encode()


def text_of(samples) -> bytes:
    return ('\n'.join(' '.join(repr(v) for v in row) for row in samples.reshape(samples.shape[0], -1, order='F').T.tolist())
            + '\n').encode()


def placed(samples, **more) -> Grid:
    return Grid(samples, **{'spacing': SPACING, 'origin': ORIGIN, **more})


def encodings():
    found = []
    for kind in TYPES:
        samples = volume(kind)
        right = placed(samples)
        for order, msb in (('<', 'False'), ('>', 'True')):
            data = raw(samples, order)
            packed = zlib.compress(data)
            name = f'{kind} {"big" if order == ">" else "little"}'
            common = dict(damage=True, by_program=True)
            head = header(samples, BinaryDataByteOrderMSB=msb)
            found.append(case(f'{name} local', head + data, 'v.mha', right, **common))
            head = header(samples, CompressedData='True', CompressedDataSize=len(packed), BinaryDataByteOrderMSB=msb)
            found.append(case(f'{name} compressed', head + packed, 'v.mha', right, **common))
            for endian in ('BinaryDataByteOrderMSB', 'ElementByteOrderMSB'):
                fields = {'BinaryDataByteOrderMSB': None, endian: msb}
                found.append(case(f'{name} apart, {endian}', {'v.mhd': header(samples, 'v.raw', **fields), 'v.raw': data},
                                  'v.mhd', right, damage=endian.startswith('B'), by_program=endian.startswith('B')))
            fields = dict(CompressedData='True', BinaryDataByteOrderMSB=msb)
            found.append(case(f'{name} compressed apart', {'v.mhd': header(samples, 'v.zraw', **fields), 'v.zraw': packed},
                              'v.mhd', right, **common))
        finite = volume(kind, finite=True)
        data = header(finite, BinaryData='False') + text_of(finite)
        last_number = len(data) - 1 - len(data.split()[-1])
        found.append(case(f'{kind} as text', data, 'v.mha', placed(finite), damage=True, by_program=True,
                          cuts=range(last_number + 1)))  # half a number is a number
        found.append(case(f'{kind} as text apart', {'v.mhd': header(finite, 'v.txt', BinaryData='False'),
                                                    'v.txt': text_of(finite)}, 'v.mhd', placed(finite)))
    for kind, name in (('int32', 'MET_LONG'), ('uint32', 'MET_ULONG')):  # of 4 bytes, MET_ValueTypeSize in metaTypes.h
        samples = volume(kind)
        found.append(case(f'{name} of 4 bytes', header(samples, ElementType=name) + raw(samples), 'v.mha', placed(samples)))
    return found


def intensities():
    """A line of values, that of the field of MetaIO."""
    found = []
    samples = volume('int16')
    for slope, offset in ((0.5, -1024), (2, 0), (1, 3), (1, 0), (0, 0)):
        data = header(samples, ElementToIntensityFunctionSlope=slope, ElementToIntensityFunctionOffset=offset) + raw(samples)
        right = placed(samples) if (slope or 1, offset) == (1, 0) else placed((samples.astype(float) * slope + offset).astype('float32'))
        found.append(case(f'intensities {slope} x + {offset}', data, 'v.mha', right, by_program=True))
    for slope in ('x', '1 2', 'nan'):
        found.append(case(f'intensities {slope} x', header(samples, ElementToIntensityFunctionSlope=slope) + raw(samples), 'v.mha'))
    return found


def compressed():
    samples = volume('int16')
    data = raw(samples)
    packed = zlib.compress(data)
    right = placed(samples)
    found = []

    def add(name, size, body, refusable=False, right=right):
        head = header(samples, CompressedData='True', CompressedDataSize=size)
        found.append(case(name, head + body, 'v.mha', *([right] if right else []), refusable=refusable or right is None))
    add('compressed, size missing', None, packed)
    add('compressed, size 0', 0, packed)
    for size in (1, len(packed) - 1, len(packed) // 2):
        add(f'compressed, size {size} of {len(packed)}', size, packed)
    for size in (len(packed) + 1, 2**31, 2**40, 2**63):
        add(f'compressed, size {size} of {len(packed)}', size, packed, refusable=True)
    for size in (-1, 'x', '1.5'):
        add(f'compressed, size {size}', size, packed, refusable=True)
    add('compressed by gzip', None, gzip.compress(data), refusable=True)
    add('compressed, not', None, data, right=None)
    add('compressed, one sample less', None, zlib.compress(data[:-2]), right=None)
    add('compressed, one byte less', None, zlib.compress(data[:-1]), right=None)
    add('compressed, one sample more', None, zlib.compress(data + b'xy'), refusable=True)
    for back in (1, 5, 20):
        changed = bytearray(packed)
        changed[-back] ^= 0x55
        add(f'compressed with byte {-back} changed', None, bytes(changed), True)
    found.append(case('compressed text', header(samples, CompressedData='True', BinaryData='False') + zlib.compress(text_of(samples)),
                      'v.mha', right, refusable=True))
    return found


def files():
    samples = volume('int16')
    data, pieces, right = raw(samples), slices(samples), placed(samples)
    named = {f'slice{z + 1:03d}.raw': piece for z, piece in enumerate(pieces)}
    names = '\n'.join(named)
    backwards = placed(samples[:, :, ::-1])
    found = []

    def add(name, data_file, others, right=right, refusable=False, cut=False, program=False, **more):
        text = header(samples, data_file, **more)
        found.append(case(name, {'v.mhd': text, **others}, 'v.mhd', *([right] if right else []),
                          refusable=refusable or right is None, damage=cut, by_program=program))
    add('list', 'LIST\n' + names, named, cut=True, program=True)
    found.append(case('list without a last line end', {'v.mhd': header(samples, 'LIST\n' + names)[:-1], **named}, 'v.mhd', right))
    found.append(case('list in .mha', {'v.mha': header(samples, 'LIST\n' + names), **named}, 'v.mha', right, refusable=True))
    add('list 2', 'LIST 2\n' + names, named)
    add('list 2D', 'LIST 2D\n' + names, named)
    add('list of one volume', 'LIST 3\nv.raw', {'v.raw': data}, refusable=True)
    add('list backwards', 'LIST\n' + '\n'.join(reversed(named)), named, backwards)
    add('list of compressed', 'LIST\na\nb\nc', {n: zlib.compress(p) for n, p in zip('abc', pieces)}, refusable=True,
        CompressedData='True')
    add('list of text', 'LIST\na\nb\nc', {n: text_of(samples[:, :, z:z + 1]) for z, n in enumerate('abc')}, BinaryData='False')
    add('list with HeaderSize', 'LIST\n' + names, {n: b'rubbish' + p for n, p in named.items()}, HeaderSize=7)
    add('list with HeaderSize -1', 'LIST\n' + names, {n: b'rubbish' + p for n, p in named.items()}, HeaderSize=-1)
    add('list with an empty line behind', 'LIST\n' + names + '\n', named)
    add('pattern', 'slice%03d.raw 1 3 1', named, cut=True, program=True)
    add('pattern with dimension', 'slice%03d.raw 1 3 1 2', named, refusable=True)
    add('pattern in steps', 's%d.raw 0 10 5', {f's{5 * z}.raw': p for z, p in enumerate(pieces)})
    add('pattern without step', 'slice%03d.raw 1 3', named, refusable=True)
    add('pattern backwards', 'slice%03d.raw 3 1 -1', named, backwards, refusable=True)
    add('in a folder', 'data/v.raw', {'data/v.raw': data})
    add('name with a blank', 'the data.raw', {'the data.raw': data})
    add('HeaderSize 7', 'v.raw', {'v.raw': b'rubbish' + data}, cut=True, program=True, HeaderSize=7)
    add('HeaderSize 0', 'v.raw', {'v.raw': data}, HeaderSize=0)
    add('HeaderSize -1', 'v.raw', {'v.raw': b'rubbish' + data}, HeaderSize=-1, program=True)
    add('HeaderSize -1 without a header', 'v.raw', {'v.raw': data}, HeaderSize=-1)
    add('HeaderSize -1 of too few bytes', 'v.raw', {'v.raw': data[:-1]}, None, HeaderSize=-1)
    add('HeaderSize 7, compressed', 'v.zraw', {'v.zraw': b'rubbish' + zlib.compress(data)}, refusable=True, HeaderSize=7,
        CompressedData='True')
    for size in (1, 120, 2**31, 2**40, 2**63 - 1, -2, 'x'):
        add(f'HeaderSize {size} of a file without', 'v.raw', {'v.raw': data}, None, HeaderSize=size)
    found.append(case('HeaderSize -1, local', header(samples, HeaderSize=-1) + data, 'v.mha', right, refusable=True))
    short = {**named, 'slice002.raw': pieces[1][:-1]}
    for name, data_file, others in (
            ('absent', 'absent.raw', {}), ('a list of two', 'LIST\nslice001.raw\nslice002.raw', named), ('an empty list', 'LIST', named),
            ('a list of absent ones', 'LIST\na\nb\nc', {}), ('a list with a short one', 'LIST\n' + names, short),
            ('a list with an absent one', 'LIST\nslice001.raw\nx\nslice003.raw', named), ('a list of empty ones', 'LIST\na\nb\nc',
                                                                                      dict.fromkeys('abc', b'')),
            ('a pattern of two', 'slice%03d.raw 1 2 1', named), ('a pattern with a short one', 'slice%03d.raw 1 3 1', short),
            ('a pattern of absent ones', 'slice%03d.raw 2 4 1', named), ('a step of 0', 'slice%03d.raw 1 3 0', named),
            ('a pattern that never ends', 'slice%03d.raw 1 3 -1', named), ('a hostile pattern', 'slice%s%n.raw 1 3 1', named),
            ('a wide pattern', 'slice%0999999999d.raw 1 3 1', named), ('4000000000 files', 'slice%d.raw 1 4000000000 1', named),
            ('itself', 'v.mhd', {}), ('a folder', '.', {}), ('no name', '', {}), ('a list of dimension 0', 'LIST 0\n' + names, named),
            ('a list of dimension 9', 'LIST 9\n' + names, named), ('a list of dimension -1', 'LIST -1\n' + names, named)):
        add(f'data file: {name}', data_file, others, None)
    add('a short file', 'v.raw', {'v.raw': data[:-1]}, None)
    add('an empty file', 'v.raw', {'v.raw': b''}, None)
    return found


def places():
    samples = volume('uint8')
    data = raw(samples)
    found = []

    def add(name, right, refusable=False, program=False, **fields):
        found.append(case(name, header(samples, **fields) + data, 'v.mha', *([right] if right else []),
                          refusable=refusable or right is None, by_program=program))
    for key in ('Offset', 'Origin', 'Position'):
        add(f'{key}', placed(samples), **{'Offset': None, key: '10 20 30'})
    add('no Offset', Grid(samples, SPACING), Offset=None)
    add('no ElementSpacing', Grid(samples, (1, 1, 1), ORIGIN), ElementSpacing=None)
    add('ElementSize alone', placed(samples), ElementSpacing=None, ElementSize='0.5 0.75 2')
    add('ElementSize beside ElementSpacing', placed(samples), ElementSize='3 3 3')
    add('ElementSpacing with exponents', placed(samples), ElementSpacing='5e-1 7.5E-1 +2.0')
    matrices = {'turned': rotation(), 'swapped': np.array([[0.0, 0, 1], [-1, 0, 0], [0, 1, 0]]), 'mirrored': np.diag([1.0, 1, -1])}
    for what, matrix in matrices.items():
        text = ' '.join(repr(float(x)) for x in matrix.T.ravel())  # a row of the file is an axis of the image
        for key in ('TransformMatrix', 'Rotation', 'Orientation'):
            add(f'{key} {what}', placed(samples, direction=matrix), program=key[0] == 'T', **{key: text})
        add(f'TransformMatrix {what}, with all that ITK writes', placed(samples, direction=matrix), TransformMatrix=text,
            CenterOfRotation='0 0 0', AnatomicalOrientation='RAI')
    for orientation in ('RAI', 'LPS', '???', 'RAS'):  # says what the matrix is, and does not change places
        add(f'AnatomicalOrientation {orientation}', placed(samples), AnatomicalOrientation=orientation)
    shear = np.array([[1, 0.2, 0], [0, 1, 0], [0, 0, 1]])
    for what, matrix in (('sheared', shear), ('zero', np.zeros((3, 3))), ('flat', np.diag([1.0, 1, 0])),
                         ('not finite', np.diag([np.inf, 1, 1])), ('huge', np.diag([1e200, 1, 1]))):
        add(f'TransformMatrix {what}', None, TransformMatrix=' '.join(repr(float(x)) for x in matrix.T.ravel()))
    add('TransformMatrix of 8 numbers', None, TransformMatrix='1 0 0 0 1 0 0 0')
    add('TransformMatrix of words', None, TransformMatrix='1 0 0 0 one 0 0 0 1')
    for text in ('0.5 0 2', '0.5 inf 2', '0.5 nan 2', '0.5 0.75', '0.5 a 2', '0,5 0,75 2,0'):
        add(f'ElementSpacing {text}', None, ElementSpacing=text)
    add('ElementSpacing negative', placed(samples, direction=np.diag([1.0, -1, 1])), True, ElementSpacing='0.5 -0.75 2')
    for text in ('nan 0 0', '0 0', 'a b c'):
        add(f'Offset {text}', None, Offset=text)
    return found


def forms():
    samples = volume('int16')
    data, right = raw(samples), placed(samples)
    flat = samples[:, :, :1]
    found = [
        case('NDims 2', header(flat, NDims=2, DimSize='5 4', Offset='10 20', ElementSpacing='0.5 0.75') + raw(flat), 'v.mha',
             image(flat[:, :, 0], (0.5, 0.75), origin=(10, 20, 0), space=('-',)), by_program=True),
        *one_slice('NDims 3', header(flat) + raw(flat), 'v.mha', placed(flat)),
        case('NDims 4', header(samples, NDims=4, DimSize='5 4 3 1', Offset='10 20 30 7', ElementSpacing='0.5 0.75 2 9',
                               TransformMatrix='1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1') + data, 'v.mha', right),
        case('NDims 4, several', header(samples, NDims=4, DimSize='5 2 2 3', Offset='10 20 30 7', ElementSpacing='1 1 1 1') + data,
             'v.mha'),
        case('no BinaryData', header(samples, BinaryData=None) + data, 'v.mha', right),  # MetaImage::Clear(): true
        case('no CompressedData', header(samples, CompressedData=None) + data, 'v.mha', right),
        case('no ObjectType', header(samples, ObjectType=None) + data, 'v.mha', right, refusable=True),
        case('8 bits without byte order', header(volume('uint8'), BinaryDataByteOrderMSB=None) + raw(volume('uint8')), 'v.mha',
             placed(volume('uint8'))),
        case('no byte order', header(samples, BinaryDataByteOrderMSB=None) + data, 'v.mha', right, refusable=True),
        case('CR LF', header(samples, end='\r\n') + data, 'v.mha', right),
        case('no blanks', header(samples, separator='=') + data, 'v.mha', right),
        case('colons', header(samples, separator=': ') + data, 'v.mha', right, refusable=True),
        case('true in small letters', header(samples, BinaryData='true', BinaryDataByteOrderMSB='false') + data, 'v.mha', right),
        case('1 and 0', header(samples, BinaryData='1', BinaryDataByteOrderMSB='0') + data, 'v.mha', right),
        case('local in small letters', header(samples, 'Local') + data, 'v.mha', right),
        case('comments and other fields', b'Comment = DimSize = 9 9 9\nName = x\nID = 1\n' + header(samples, Modality='MET_MOD_CT')
             + data, 'v.mha', right),
        case('ElementNumberOfChannels 1', header(samples, ElementNumberOfChannels=1) + data, 'v.mha', right),
        case('ElementNumberOfChannels 3', header(samples, DimSize='5 4 1', ElementNumberOfChannels=3) + data, 'v.mha'),
        case('ElementMin and ElementMax', header(samples, ElementMin=-3, ElementMax=5) + data, 'v.mha', right),
        case('ElementType MET_UCHAR_ARRAY', header(samples, DimSize='5 4 1', ElementType='MET_UCHAR_ARRAY',
                                                   ElementNumberOfChannels=3) + data, 'v.mha')]
    for name, fields in (
            ('no DimSize', dict(DimSize=None)), ('no NDims', dict(NDims=None)), ('no ElementType', dict(ElementType=None)),
            ('an unknown type', dict(ElementType='MET_HALF')), ('type MET_STRING', dict(ElementType='MET_STRING')),
            ('two sizes', dict(DimSize='5 4')), ('sizes of words', dict(DimSize='5 x 3')), ('a fraction as size', dict(DimSize='5 4.5 3')),
            ('NDims 0', dict(NDims=0)), ('NDims -1', dict(NDims=-1)), ('NDims 11', dict(NDims=11)), ('NDims 2^40', dict(NDims=2**40)),
            ('NDims of words', dict(NDims='three')), ('ObjectType Tube', dict(ObjectType='Tube'))):
        found.append(case(name, header(samples, **fields) + data, 'v.mha'))
    found.append(case('no ElementDataFile', b'\n'.join(header(samples).split(b'\n')[:-2]) + b'\n', 'v.mha'))
    found.append(case('no header', data, 'v.mha'))
    found.append(case('a line without end', b'NDims = 3\nComment = ' + b'x' * 200000, 'v.mha'))
    for words in (b'x', b'70000', b'1.5', b'', b'0x10'):
        found.append(case(f'text with {words!r} as last number', header(samples, BinaryData='False')
                          + b'\n'.join(text_of(samples).split()[:-1]) + b'\n' + words + b'\n', 'v.mha'))
    return found


def sizes():
    samples = volume('int16')
    right = placed(samples)

    def local(dims):
        return header(samples, DimSize='%d %d %d' % dims) + raw(samples)

    def packed(dims):
        return header(samples, DimSize='%d %d %d' % dims, CompressedData='True') + zlib.compress(raw(samples))

    def text(dims):
        return header(samples, DimSize='%d %d %d' % dims, BinaryData='False') + text_of(samples)

    def apart(dims):
        return {'v.mhd': header(samples, 'v.raw', DimSize='%d %d %d' % dims), 'v.raw': raw(samples)}

    def from_the_end(dims):
        return {'v.mhd': header(samples, 'v.raw', DimSize='%d %d %d' % dims, HeaderSize=-1), 'v.raw': raw(samples)}
    found = claims('local', right, local, 'v.mha') + claims('compressed', right, packed, 'v.mha')
    found += claims('text', right, text, 'v.mha') + claims('apart', right, apart, 'v.mhd')
    longer = [c for c in claims('HeaderSize -1', right, from_the_end, 'v.mhd') if not c.right]  # else: other samples
    return found + longer


def cases():
    found = encodings() + intensities() + compressed() + files() + places() + forms() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
