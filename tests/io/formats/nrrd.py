# SPDX-License-Identifier: Apache-2.0
"""NRRD, attached and detached (Definition of NRRD File Format, teem.sourceforge.net/nrrd/format.html)."""
import bz2
import gzip
import zlib

import numpy as np

from .cases import ORIGIN, SPACING, TYPES, Grid, case, claims, damaged, image, one_slice, raw, rotation, slices, volume

NAMES = {
    'int8': ['signed char', 'int8', 'int8_t'],
    'uint8': ['uchar', 'unsigned char', 'uint8', 'uint8_t'],
    'int16': ['short', 'short int', 'signed short', 'signed short int', 'int16', 'int16_t'],
    'uint16': ['ushort', 'unsigned short', 'unsigned short int', 'uint16', 'uint16_t'],
    'int32': ['int', 'signed int', 'int32', 'int32_t'],
    'uint32': ['uint', 'unsigned int', 'uint32', 'uint32_t'],
    'int64': ['longlong', 'long long', 'long long int', 'signed long long', 'signed long long int', 'int64', 'int64_t'],
    'uint64': ['ulonglong', 'unsigned long long', 'unsigned long long int', 'uint64', 'uint64_t'],
    'float32': ['float'], 'float64': ['double']}
# What turns coordinates of a space into left-posterior-superior ones.
TO_LPS = {'right-anterior-superior': (-1, -1, 1), 'left-anterior-superior': (1, -1, 1), 'left-posterior-superior': (1, 1, 1)}
OTHER_ANATOMICAL = {'right-posterior-superior': (-1, 1, 1), 'right-posterior-inferior': (-1, 1, -1),
                    'right-anterior-inferior': (-1, -1, -1), 'left-anterior-inferior': (1, -1, -1),
                    'left-posterior-inferior': (1, 1, -1)}


def header(fields, magic='NRRD0004', end='\n') -> bytes:
    lines = [magic] + [text if text.startswith('#') or value is None else f'{text}: {value}' for text, value in fields.items()]
    return (end.join(lines) + end + end).encode()


def fields_of(samples, **more):
    """`more` replaces fields, None removes them; names with _ for blanks."""
    fields = {'type': NAMES[samples.dtype.name][0], 'dimension': 3, 'sizes': '%d %d %d' % samples.shape,
              'spacings': '%g %g %g' % SPACING, 'encoding': 'raw', 'endian': 'little'}
    fields.update({name.replace('_', ' '): value for name, value in more.items()})
    first = ['type', 'dimension', 'space', 'space dimension']  # what others rely on comes before them
    return {name: fields[name] for name in sorted(fields, key=lambda name: name not in first) if fields[name] is not None}


def text_of(samples) -> bytes:
    return ('\n'.join(' '.join(repr(v) for v in row) for row in samples.reshape(samples.shape[0], -1, order='F').T.tolist())
            + '\n').encode()


def hex_of(data: bytes) -> bytes:
    digits = data.hex()
    return '\n'.join(digits[i:i + 70] for i in range(0, len(digits), 70)).encode() + b'\n'


def vectors(matrix) -> str:
    return ' '.join('(%r,%r,%r)' % tuple(float(x) for x in column) for column in np.asarray(matrix).T)


def point(p) -> str:
    return '(' + ','.join(repr(float(x)) for x in p) + ')'


def encodings():
    found = []
    for kind in TYPES:
        samples = volume(kind)
        right = Grid(samples, SPACING)
        for order, word in (('<', 'little'), ('>', 'big')):
            data = raw(samples, order)
            for encoding, packed in (('raw', data), ('gzip', gzip.compress(data, mtime=0)), ('hex', hex_of(data))):
                head = header(fields_of(samples, encoding=encoding, endian=word))
                found.append(case(f'{kind} {word} {encoding}', head + packed, 'v.nrrd', right, by_program=True, damage=True))
        finite = volume(kind, finite=True)
        data = header(fields_of(finite, encoding='ascii', endian=None)) + text_of(finite)
        last_number = len(data) - 1 - len(data.split()[-1])
        found.append(case(f'{kind} ascii', data, 'v.nrrd', Grid(finite, SPACING), by_program=True, damage=True,
                          cuts=range(last_number + 1)))  # half a number is a number
    return found


def spellings():
    found = []
    for kind, names in NAMES.items():
        samples = volume(kind)
        for name in names:
            found.append(case(f'type: {name}', header(fields_of(samples, type=name)) + raw(samples), 'v.nrrd',
                              Grid(samples, SPACING)))
    samples = volume('int16')
    data, right = raw(samples), Grid(samples, SPACING)
    plain = fields_of(samples)
    for encoding, packed in (('gz', gzip.compress(data)), ('txt', text_of(samples)), ('text', text_of(samples)),
                             ('RAW', data), ('ascii', text_of(samples).replace(b' ', b',\t'))):
        found.append(case(f'encoding: {encoding}', header(fields_of(samples, encoding=encoding)) + packed, 'v.nrrd', right,
                          refusable=encoding == 'ascii'))
    found.append(case('encoding: bzip2', header(fields_of(samples, encoding='bzip2')) + bz2.compress(data), 'v.nrrd', right,
                      refusable=True))
    found.append(case('zlib data for gzip', header(fields_of(samples, encoding='gzip')) + zlib.compress(data), 'v.nrrd', right,
                      refusable=True))
    two = gzip.compress(data[:50]) + gzip.compress(data[50:])
    found.append(case('two gzip members', header(fields_of(samples, encoding='gzip')) + two, 'v.nrrd', right))
    for magic in ('NRRD0001', 'NRRD0002', 'NRRD0003', 'NRRD0005'):
        found.append(case(magic, header(plain, magic) + data, 'v.nrrd', right))
    found.append(case('lines end with CR LF', header(plain, end='\r\n') + data, 'v.nrrd', right, by_program=True))
    noisy = {'# sizes: 9 9 9': None, **plain, 'sizes:=7 7 7': None, 'content': 'sizes: 8 8 8', '#': None, 'kinds': 'space space space',
             'key:=a value: with a colon': None}
    found.append(case('comments, keys and values', header(noisy) + data, 'v.nrrd', right))
    found.append(case('fields in another order', header(dict(reversed(list(plain.items())))) + data, 'v.nrrd', right,
                      refusable=True))  # dimension has to come before what is per axis
    found.append(case('field names in capitals', header({k.upper(): v for k, v in plain.items()}) + data, 'v.nrrd', right))
    found.append(case('type in capitals', header(fields_of(samples, type='SHORT')) + data, 'v.nrrd', right))
    found.append(case('8 bits without endian', header(fields_of(volume('uint8'), endian=None)) + raw(volume('uint8')), 'v.nrrd',
                      Grid(volume('uint8'), SPACING)))
    found.append(case('number: 60', header({**plain, 'number': 60}) + data, 'v.nrrd', right, refusable=True))
    return found


def axes():
    """More or fewer than three axes."""
    samples = volume('int16')
    data = raw(samples)
    found = []
    for sizes, spacings in (('5 4 3 1', '0.5 0.75 2 nan'), ('5 4 3 1', '0.5 0.75 2 1'), ('5 4 3 1 1', '0.5 0.75 2 1 1')):
        fields = fields_of(samples, dimension=len(sizes.split()), sizes=sizes, spacings=spacings)
        found.append(case(f'sizes: {sizes}, spacings: {spacings}', header(fields) + data, 'v.nrrd', Grid(samples, SPACING),
                          refusable='nan' in spacings or sizes.count('1') > 1))
    fields = fields_of(samples, dimension=4, sizes='1 5 4 3', spacings='nan 0.5 0.75 2', kinds='list domain domain domain')
    found.append(case('sizes: 1 5 4 3', header(fields) + data, 'v.nrrd', Grid(samples, SPACING), refusable=True))
    fields = fields_of(samples, dimension=4, sizes='1 5 4 3', spacings=None, space='LPS', space_origin=point(ORIGIN),
                       space_directions='none ' + vectors(np.diag(SPACING)), kinds='list domain domain domain')
    found.append(case('sizes: 1 5 4 3, space directions: none ...', header(fields) + data, 'v.nrrd',
                      Grid(samples, SPACING, ORIGIN), refusable=True))
    flat = samples[:, :, :1]
    found.append(case('two axes', header(fields_of(flat, dimension=2, sizes='5 4', spacings='0.5 0.75')) + raw(flat), 'v.nrrd',
                      image(flat[:, :, 0], (0.5, 0.75)), by_program=True))
    two = fields_of(flat, dimension=2, sizes='5 4', spacings=None, space_dimension=2, space_origin='(1,2)',
                    space_directions='(0.5,0) (0,0.75)')
    found.append(case('two axes in a plane', header(two) + raw(flat), 'v.nrrd',
                      image(flat[:, :, 0], (0.5, 0.75), origin=(1, 2, 0)), by_program=True))
    turn = rotation((0, 0, 1), 30)
    in_space = fields_of(flat, dimension=2, sizes='5 4', spacings=None, space='LPS', space_origin=point(ORIGIN),
                         space_directions=' '.join(vectors(turn * (0.5, 0.75, 1)).split(' ')[:2]))
    found.append(case('two axes in space', header(in_space) + raw(flat), 'v.nrrd',
                      image(flat[:, :, 0], (0.5, 0.75), origin=(*ORIGIN[:2], 0), direction=turn, space=('-',))))
    oblique = fields_of(flat, dimension=2, sizes='5 4', spacings=None, space='LPS', space_origin=point(ORIGIN),
                        space_directions='(0.5,0,0) (0,0,0.75)')
    found.append(case('two axes of an upright plane', header(oblique) + raw(flat), 'v.nrrd', image(flat[:, :, 0], (0.5, 0.75), space=('-',))))
    found += one_slice('three axes', header(fields_of(flat)) + raw(flat), 'v.nrrd', Grid(flat, SPACING))
    found.append(case('three axes as an image', header(fields_of(samples)) + data, 'v.nrrd', usage=True, how=(('dimension', '2'),)))
    found.append(case('alpha of a volume', header(fields_of(samples)) + data, 'v.nrrd', usage=True, how=(('channel', 'alpha'),)))
    found.append(case('red of a volume', header(fields_of(samples)) + data, 'v.nrrd', Grid(samples, SPACING), how=(('channel', 'red'),)))
    colours = {'colours': ('3 5 4 1', 'RGB-color domain domain domain'), 'vectors': ('5 4 1 3', 'domain domain domain vector'),
               'points of time': ('5 2 2 3', 'space space space time')}
    for what, (sizes, kinds) in colours.items():
        fields = fields_of(samples, dimension=4, sizes=sizes, spacings=None, kinds=kinds)
        found.append(case(what, header(fields) + data, 'v.nrrd'))
    fields = fields_of(samples, sizes='3 5 4', spacings=None, kinds='RGB-color domain domain')
    found.append(case('a picture in colours', header(fields) + data, 'v.nrrd'))
    return found


def places():
    samples = volume('uint8')
    data = raw(samples)
    found = []

    def add(name, right, refusable=False, **fields):
        found.append(case(name, header(fields_of(samples, **fields)) + data, 'v.nrrd', *([right] if right else []),
                          refusable=refusable or right is None, by_program=right is not None and not refusable))
    turned = rotation()
    swapped = np.array([[0.0, 0, 1], [-1, 0, 0], [0, 1, 0]])
    for what, matrix in (('straight', np.eye(3)), ('turned', turned), ('swapped', swapped), ('mirrored', np.diag([1.0, 1, -1]))):
        directions = matrix @ np.diag(SPACING)
        where = dict(spacings=None, space_origin=point(ORIGIN), space_directions=vectors(directions))
        for space, signs in {**TO_LPS, **OTHER_ANATOMICAL}.items():
            right = Grid(samples, SPACING, tuple(np.multiply(signs, ORIGIN)), np.diag(signs) @ matrix, space=('LPS', '-'))
            short = ''.join(word[0] for word in space.split('-')).upper()
            standard = space in TO_LPS
            for spelled in (space, short, space.title()):
                add(f'space: {spelled}, {what}', right, refusable=not standard, space=spelled, **where)
            if standard and what != 'swapped':
                for spelled in (space + '-time', short + 'T'):
                    in_time = ' '.join(f'({x!r},{y!r},{z!r},0)' for x, y, z in directions.T.tolist()) + ' (0,0,0,1)'
                    add(f'space: {spelled}, {what}', right, dimension=4, sizes='5 4 3 1', spacings=None, space=spelled,
                        space_origin='(10,20,30,7)', space_directions=in_time)
        unnamed = Grid(samples, SPACING, ORIGIN, matrix, space=('-',))
        for space in ('scanner-xyz', '3D-right-handed', '3D-left-handed'):
            add(f'space: {space}, {what}', Grid(samples, SPACING, ORIGIN, matrix, space=(space,)), space=space, **where)
        add(f'space dimension: 3, {what}', unnamed, **{'space_dimension': 3, **where})
    units = Grid(samples, SPACING, ORIGIN, units=('mm', '-'))
    straight = dict(space='LPS', spacings=None, space_directions=vectors(np.diag(SPACING)))
    add('space units', units, space_units='"mm" "mm" "mm"', space_origin=point(ORIGIN), **straight)
    add('units', Grid(samples, SPACING, units=('mm', '-')), units='"mm" "mm" "mm"')
    add('no spacing', Grid(samples), spacings=None)
    add('directions without origin', Grid(samples, SPACING), **straight)
    add('measurement frame', Grid(samples, SPACING, ORIGIN), space_origin=point(ORIGIN),
        measurement_frame='(0,1,0) (1,0,0) (0,0,1)', **straight)
    add('blanks in vectors', Grid(samples, SPACING, ORIGIN), space='LPS', spacings=None, space_origin='( 10 , 20, 30 )',
        space_directions='(0.5, 0, 0)  ( 0, 0.75,0 ) (0,0, 2.0)')
    add('exponents', Grid(samples, SPACING), spacings='5e-1 7.5E-1 +2.0e0')
    for centre, shift in (('cell', 0.5), ('node', 0.0)):
        at = tuple(m + shift * s for m, s in zip((1, 2, 3), SPACING))
        for name in ('axis mins', 'axismins'):
            add(f'{name} of {centre}s', Grid(samples, SPACING, at), centers=f'{centre} {centre} {centre}', **{name: '1 2 3'})
    for name, spacings in (('0 in one axis', '0.5 0 2'), ('infinite', '0.5 inf 2'), ('two', '0.5 0.75'), ('words', '0.5 a 2'),
                           ('commas', '0,5 0,75 2,0')):
        add(f'spacings: {name}', None, spacings=spacings)
    add('spacings: negative', Grid(samples, SPACING, direction=np.diag([1.0, -1, 1])), True, spacings='0.5 -0.75 2')
    add('spacings: unknown', Grid(samples, (0.5, 1, 2)), True, spacings='0.5 nan 2')
    sheared = np.diag(SPACING) @ np.array([[1, 0.2, 0], [0, 1, 0], [0, 0, 1]])
    for name, matrix in (('sheared', sheared), ('zero', np.diag([0.5, 0, 2])), ('flat', np.array([[1.0, 1, 0], [0, 0, 0], [0, 0, 1]])),
                         ('huge', np.diag([1e200, 1, 1])), ('not finite', np.diag([np.inf, 1, 1]))):
        add(f'directions: {name}', None, space='LPS', spacings=None, space_origin=point(ORIGIN), space_directions=vectors(matrix))
    add('directions: two', None, space='LPS', spacings=None, space_directions='(1,0,0) (0,1,0)')
    add('directions: none for a spatial axis', None, space='LPS', spacings=None, space_directions='(1,0,0) (0,1,0) none')
    add('origin: not finite', None, space_origin='(nan,0,0)', **straight)
    return found


def detached():
    samples = volume('int16')
    data, right = raw(samples), Grid(samples, SPACING)
    found = []

    def add(name, files, right=right, cut=True, **fields):
        head = fields_of(samples, **{k: v for k, v in fields.items() if k != 'data_file'})
        text = header({**head, 'data file': fields['data_file']})[:-1]  # the last field, so that a cut one does not fit
        rights = [right] if right else []
        found.append(case(name, {'v.nhdr': text, **files}, 'v.nhdr', *rights, damage=bool(rights) and cut,
                          by_program=bool(rights)))
    add('detached raw', {'v.raw': data}, data_file='v.raw')
    add('detached gzip', {'v.raw.gz': gzip.compress(data)}, encoding='gzip', data_file='v.raw.gz')
    add('detached gzip by its content only', {'v.bin': gzip.compress(data)}, encoding='gz', data_file='./v.bin')
    # Half of the last number is a number: these are not cut.
    add('detached ascii', {'v.txt': text_of(samples)}, encoding='text', data_file='v.txt', cut=False)
    add('detached hex', {'v.hex': hex_of(data)}, encoding='hex', data_file='v.hex')
    add('detached in a folder, with a blank', {'the data/v.raw': data}, data_file='the data/v.raw')
    pieces = slices(samples)
    named = {f'slice{z + 1:03d}.raw': piece for z, piece in enumerate(pieces)}
    lists = '\n'.join(named)
    add('LIST', named, data_file='LIST\n' + lists)
    add('LIST 2', named, data_file='LIST 2\n' + lists)
    add('LIST 3', {'a.raw': data[:80], 'b.raw': data[80:]}, sizes='5 4 3', data_file='LIST 3\na.raw\nb.raw', right=None)
    stacked = {'a.raw': raw(samples[:, :, :1]), 'b.raw': raw(samples[:, :, 1:2]), 'c.raw': raw(samples[:, :, 2:])}
    add('LIST backwards', stacked, data_file='LIST\nc.raw\nb.raw\na.raw', right=Grid(samples[:, :, ::-1], SPACING))
    add('pattern', named, data_file='slice%03d.raw 1 3 1')
    add('pattern with dimension', named, data_file='slice%03d.raw 1 3 1 2')
    add('pattern backwards', named, data_file='slice%03d.raw 3 1 -1', right=Grid(samples[:, :, ::-1], SPACING))
    add('pattern in steps', {f's{5 * z:d}.raw': piece for z, piece in enumerate(pieces)}, data_file='s%d.raw 0 10 5')
    add('pattern of gzip', {f's{z}.gz': gzip.compress(piece) for z, piece in enumerate(pieces)}, encoding='gzip',
        data_file='s%d.gz 0 2 1')
    for name, what in (('absent', 'absent.raw'), ('a list of two', 'LIST\nslice001.raw\nslice002.raw'), ('an empty list', 'LIST'),
                       ('a list of absent ones', 'LIST\na\nb\nc'), ('a pattern of two', 'slice%03d.raw 1 2 1'),
                       ('a pattern of absent ones', 'slice%03d.raw 2 4 1'), ('a step of 0', 'slice%03d.raw 1 3 0'),
                       ('a pattern that never ends', 'slice%03d.raw 1 3 -1'), ('a hostile pattern', 'slice%s%n.raw 1 3 1'),
                       ('a wide pattern', 'slice%0999999999d.raw 1 3 1'), ('itself', 'v.nhdr'), ('a folder', '.'),
                       ('no name', ''), ('a list of dimension 9', 'LIST 9\n' + lists),
                       ('4000000000 files', 'slice%d.raw 1 4000000000 1')):
        add(f'data file: {name}', named, data_file=what, right=None)
    rubbish = b'a line\nanother\n'
    for skips, before in ((dict(byte_skip=15), rubbish), (dict(byteskip=15), rubbish), (dict(line_skip=2), rubbish),
                          (dict(line_skip=1, byte_skip=8), rubbish), (dict(byte_skip=-1), rubbish), (dict(byte_skip=-1), b'')):
        what = ', '.join(f'{k.replace("_", " ")}: {v}' for k, v in skips.items()) + f' ({len(before)} before)'
        add(what, {'v.raw': before + data}, data_file='v.raw', cut='-1' not in what, **skips)
        found.append(case(what + ', attached', header(fields_of(samples, **skips)) + before + data, 'v.nrrd', right,
                          by_program=True))
    short = header(fields_of(samples, byte_skip=-1)) + data[:-1]
    found.append(case('byte skip: -1 of too few bytes', short, 'v.nrrd'))
    for skip in (1, 2**31, 2**40, 2**63 - 1, -2, 'x'):
        add(f'byte skip: {skip} of a file without', {'v.raw': data}, data_file='v.raw', right=None, byte_skip=skip)
        add(f'line skip: {skip} of a file without', {'v.raw': b'\0' * 120}, data_file='v.raw', right=None, line_skip=skip)
    before_gzip = {'v.gz': gzip.compress(rubbish + data)}
    found.append(case('byte skip of gzip', {'v.nhdr': header(fields_of(samples, encoding='gzip', byte_skip=15,
                                                                       data_file='v.gz')), **before_gzip},
                      'v.nhdr', right, refusable=True))
    return found


def refused():
    samples = volume('int16')
    data = raw(samples)
    found = []
    for name, fields in (('an unknown type', dict(type='half')), ('blocks', {'type': 'block', 'block size': 2}),
                         ('no type', dict(type=None)), ('no sizes', dict(sizes=None)), ('no dimension', dict(dimension=None)),
                         ('no encoding', dict(encoding=None)), ('no endian', dict(endian=None)),
                         ('an unknown encoding', dict(encoding='zstd')), ('an unknown endian', dict(endian='middle')),
                         ('two sizes', dict(sizes='5 4')), ('four sizes', dict(sizes='5 4 3 1')),
                         ('a size of words', dict(sizes='5 x 3')), ('a fraction as size', dict(sizes='5 4.5 3')),
                         ('dimension 0', dict(dimension=0)), ('dimension -1', dict(dimension=-1)),
                         ('dimension 17', dict(dimension=17)), ('dimension 2^40', dict(dimension=2**40)),
                         ('dimension of words', dict(dimension='three')), ('an unknown space', dict(space='sideways'))):
        found.append(case(name, header(fields_of(samples, **fields)) + data, 'v.nrrd'))
    found.append(case('version 9', header(fields_of(samples), magic='NRRD0009') + data, 'v.nrrd', Grid(samples, SPACING),
                      refusable=True))
    found.append(case('no magic', header(fields_of(samples), magic='NOTNRRD') + data, 'v.nrrd'))
    found.append(case('no empty line', header(fields_of(samples))[:-1], 'v.nrrd'))
    twice = header({**fields_of(samples), 'sizes ': '4 5 3'}) + data
    found.append(case('sizes twice', twice.replace(b'sizes :', b'sizes:'), 'v.nrrd', refusable=True))
    found.append(case('a line without end', b'NRRD0004\ntype: ' + b'x' * 200000, 'v.nrrd'))
    damaged_gzip = bytearray(header(fields_of(samples, encoding='gzip')) + gzip.compress(data))
    for back in (1, 5, 9, 30):  # length, checksum, the data
        changed = bytearray(damaged_gzip)
        changed[-back] ^= 0x55
        found.append(case(f'gzip with byte {-back} changed', bytes(changed), 'v.nrrd', Grid(samples, SPACING),
                          refusable=True))
    for digits in (b'zz', b'0'):
        found.append(case(f'hex with {digits!r} behind', header(fields_of(samples, encoding='hex')) + hex_of(data)[:-3] + digits,
                          'v.nrrd'))
    for words in (b'x', b'70000', b'1.5', b'', b'0x10'):
        found.append(case(f'ascii with {words!r} as last number', header(fields_of(samples, encoding='ascii'))
                          + b'\n'.join(text_of(samples).split()[:-1]) + b'\n' + words + b'\n', 'v.nrrd'))
    return found


def sizes():
    samples = volume('int16')
    found = []
    for encoding, pack in (('raw', bytes), ('gzip', gzip.compress), ('hex', hex_of)):
        def write(dims, encoding=encoding, pack=pack):
            return header(fields_of(samples, sizes='%d %d %d' % dims, encoding=encoding)) + pack(raw(samples))
        found += claims(encoding, Grid(samples, SPACING), write, 'v.nrrd')

    def write_text(dims):
        return header(fields_of(samples, sizes='%d %d %d' % dims, encoding='ascii')) + text_of(samples)

    def write_detached(dims):
        return {'v.nhdr': header(fields_of(samples, sizes='%d %d %d' % dims, data_file='v.raw')), 'v.raw': raw(samples)}
    found += claims('ascii', Grid(samples, SPACING), write_text, 'v.nrrd')
    return found + claims('detached', Grid(samples, SPACING), write_detached, 'v.nhdr')


def cases():
    found = encodings() + spellings() + axes() + places() + detached() + refused() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
