# SPDX-License-Identifier: Apache-2.0
"""TIFF stacks and folders of TIFF slices (TIFF 6.0, BigTIFF, what ImageJ and OME write)."""
import struct
import zlib

import numpy as np

from . import pictures
from .cases import DIMS, FLOATS, INTEGERS, SPACING, Grid, case, damaged, image, raw, volume

NONE, LZW, DEFLATE, PACKBITS, OLD_DEFLATE = 1, 5, 8, 32773, 32946
SHORT, LONG, RATIONAL, ASCII, LONG8 = 3, 4, 5, 2, 16
FORMATS = {'u': 1, 'i': 2, 'f': 3}
MICRONS = ('um', 'µm', 'μm', 'micron', 'microns')


def packbits(data: bytes) -> bytes:
    out, at = b'', 0
    while at < len(data):
        run = 1
        while at + run < len(data) and run < 128 and data[at + run] == data[at]:
            run += 1
        if run > 1:
            out += bytes([257 - run, data[at]])
        else:
            end = at + 1
            while end < len(data) and end - at < 128 and data[end] != data[end - 1]:
                end += 1
            run = end - at
            out += bytes([run - 1]) + data[at:end]
        at += run
    return out


def lzw(data: bytes) -> bytes:
    """Literals only, and a new table before codes get longer than 9 bits."""
    codes = [256]
    for i, value in enumerate(data):
        if i and i % 200 == 0:
            codes.append(256)
        codes.append(value)
    digits = ''.join(f'{c:09b}' for c in codes + [257])
    digits += '0' * (-len(digits) % 8)
    return int(digits, 2).to_bytes(len(digits) // 8, 'big')


def compress(rows, kind) -> bytes:
    data = b''.join(rows)
    if kind == LZW:
        return lzw(data)
    if kind in (DEFLATE, OLD_DEFLATE):
        return zlib.compress(data)
    return b''.join(map(packbits, rows)) if kind == PACKBITS else data


def row_bytes(row, order, bits, predictor) -> bytes:
    if bits < 8:
        digits = ''.join(f'{int(v):0{bits}b}' for v in row)
        digits += '0' * (-len(digits) % 8)
        return int(digits, 2).to_bytes(len(digits) // 8, 'big')
    if predictor == 2:
        whole = row.view(f'u{row.dtype.itemsize}')
        row = np.concatenate([whole[:1], whole[1:] - whole[:-1]])
    if predictor == 3:  # planes of bytes, the highest first, whatever the byte order; then differences of bytes
        planes = row.astype(row.dtype.newbyteorder('>')).view('u1').reshape(len(row), -1).T.ravel()
        return np.concatenate([planes[:1], planes[1:] - planes[:-1]]).tobytes()
    return row.astype(row.dtype.newbyteorder(order)).tobytes()


class Writer:
    """A TIFF file of pages[x, y]. `tags` replaces or adds (type, values) of every page, or removes (None)."""

    def __init__(self, order='<', big=False):
        self.order, self.big = order, big
        self.data = bytearray((b'II' if order == '<' else b'MM') + struct.pack(order + 'H', 43 if big else 42))
        if big:
            self.data += struct.pack(order + 'HH', 8, 0)
        self.link = len(self.data)  # where the place of the next directory stands
        self.data += bytes(8 if big else 4)
        self.directories = []

    def align(self):
        self.data += bytes(-len(self.data) % 8)

    def place(self, at, value):
        fmt = self.order + ('Q' if self.big else 'I')
        self.data[at:at + struct.calcsize(fmt)] = struct.pack(fmt, value)

    def value_bytes(self, kind, values) -> bytes:
        if kind == ASCII:
            return values
        if kind == RATIONAL:
            return b''.join(struct.pack(self.order + 'II', *v) for v in values)
        return b''.join(struct.pack(self.order + {SHORT: 'H', LONG: 'I', LONG8: 'Q', 12: 'd', 1: 'B'}[kind], v) for v in values)

    def pieces(self, page, bits, compression, predictor, rows_per_strip, tile):
        if tile:
            width, height = tile
            padded = np.zeros((-(-page.shape[0] // width) * width, -(-page.shape[1] // height) * height), page.dtype)
            padded[:page.shape[0], :page.shape[1]] = page
            blocks = [padded[x:x + width, y:y + height] for y in range(0, padded.shape[1], height)
                      for x in range(0, padded.shape[0], width)]
        else:
            rows = rows_per_strip or page.shape[1]
            blocks = [page[:, y:y + rows] for y in range(0, page.shape[1], rows)]
        return [compress([row_bytes(row, self.order, bits, predictor) for row in np.ascontiguousarray(block.T)], compression)
                for block in blocks]

    def page(self, page, bits=None, compression=NONE, predictor=1, rows_per_strip=None, tile=None, photometric=1, tags=None,
             directory_first=False, body=None):
        bits = bits or page.dtype.itemsize * 8
        pieces = body or self.pieces(page, bits, compression, predictor, rows_per_strip, tile)
        entries = {256: (LONG, [page.shape[0]]), 257: (LONG, [page.shape[1]]), 258: (SHORT, [bits]), 259: (SHORT, [compression]),
                   262: (SHORT, [photometric]), 277: (SHORT, [1]), 339: (SHORT, [FORMATS[page.dtype.kind]])}
        if predictor != 1:
            entries[317] = (SHORT, [predictor])
        where, sizes = (324, 325) if tile else (273, 279)
        if tile:
            entries.update({322: (LONG, [tile[0]]), 323: (LONG, [tile[1]])})
        else:
            entries[278] = (LONG, [rows_per_strip or page.shape[1]])
        wide = LONG8 if self.big else LONG
        entries[where] = (wide, [0] * len(pieces))
        entries[sizes] = (wide, [len(p) for p in pieces])
        entries.update(tags or {})
        entries = {tag: entry for tag, entry in sorted(entries.items()) if entry}
        self.align()
        if not directory_first:
            offsets = self.append(pieces)
        start = len(self.data)
        block = self.directory(entries, start)
        if directory_first:
            offsets, at = [], start + len(block)
            for piece in pieces:
                offsets.append(at)
                at += len(piece)
        if where not in (tags or {}):
            entries[where] = (wide, offsets)
        self.place(self.link, start)
        self.directories.append(start)
        self.data += self.directory(entries, start)
        self.link = start + (8 + 20 * len(entries) if self.big else 2 + 12 * len(entries))
        if directory_first:
            self.append(pieces)
        return self

    def append(self, pieces):
        offsets = []
        for piece in pieces:
            offsets.append(len(self.data))
            self.data += piece
        return offsets

    def directory(self, entries, start) -> bytes:
        count, entry, inline = ('Q', 'HHQ', 8) if self.big else ('H', 'HHI', 4)
        head = struct.pack(self.order + count, len(entries))
        size = len(head) + len(entries) * (struct.calcsize('=' + entry) + inline) + inline
        listed, behind = b'', b''
        for tag, (kind, values) in entries.items():
            data = self.value_bytes(kind, values)
            if len(data) > inline:
                behind += bytes(-len(behind) % 2)
                place = struct.pack(self.order + ('Q' if self.big else 'I'), start + size + len(behind))
                behind += data
            else:
                place = data + bytes(inline - len(data))
            listed += struct.pack(self.order + entry, tag, kind, len(values)) + place
        return head + listed + bytes(inline) + behind


def stack(samples, order='<', big=False, tags=None, first_tags=None, **more) -> bytes:
    """`tags` are of every page, `first_tags` of the first one only."""
    writer = Writer(order, big)
    for z in range(samples.shape[2]):
        writer.page(samples[:, :, z], tags={**(tags or {}), **(first_tags if first_tags and z == 0 else {})}, **more)
    return bytes(writer.data)


def encodings():
    found = []
    for kind in INTEGERS + FLOATS + ['float16']:
        samples = volume(kind)
        rare = kind in ('uint64', 'int64', 'float16')
        right = Grid(samples.astype('float32') if kind == 'float16' else samples)
        more = dict(refusable=rare, by_program=not rare)
        for order, word in (('<', 'little'), ('>', 'big')):
            found.append(case(f'{kind} {word}', stack(samples, order), 'v.tif', right, damage=order == '<' or kind == 'int16', **more))
        found.append(case(f'{kind}, strips of a row', stack(samples, rows_per_strip=1), 'v.tiff', right, refusable=rare))
        found.append(case(f'{kind}, strips of three rows, big', stack(samples, '>', rows_per_strip=3), 'v.tif', right, refusable=rare))
        found.append(case(f'{kind}, directory first', stack(samples, directory_first=True), 'v.tif', right, refusable=rare,
                          damage=kind == 'int16'))
        for order, word in (('<', 'little'), ('>', 'big')):
            found.append(case(f'{kind}, BigTIFF, {word}', stack(samples, order, big=True), 'v.tif', right, refusable=rare,
                              damage=kind == 'int16' and order == '<'))
            found.append(case(f'{kind}, tiled, {word}', stack(samples, order, tile=(16, 16)), 'v.tif', right, refusable=rare,
                              damage=kind == 'uint8' and order == '<', by_program=kind == 'uint8'))
            for name, compression in (('LZW', LZW), ('deflate', DEFLATE), ('packbits', PACKBITS), ('old deflate', OLD_DEFLATE)):
                found.append(case(f'{kind}, {name}, {word}', stack(samples, order, compression=compression, rows_per_strip=3), 'v.tif', right,
                                  refusable=rare, damage=kind == 'uint8' and order == '<', by_program=kind == 'uint8' and order == '<'))
                if compression in (LZW, DEFLATE) and samples.dtype.kind != 'f':
                    found.append(case(f'{kind}, {name} of differences, {word}', stack(samples, order, compression=compression, predictor=2),
                                      'v.tif', right, refusable=rare))
            if kind in FLOATS:
                found.append(case(f'{kind}, deflate of differences of floats, {word}', stack(samples, order, compression=DEFLATE, predictor=3),
                                  'v.tif', right))
    wide = volume('uint8', (37, 21, 2))
    for order in '<>':
        found.append(case(f'several tiles {order}', stack(wide, order, tile=(16, 16)), 'v.tif', Grid(wide)))
        found.append(case(f'several tiles, deflate {order}', stack(wide, order, tile=(16, 32), compression=DEFLATE), 'v.tif', Grid(wide)))
    for bits in (1, 2, 4):
        samples = (volume('uint8', (13, 4, 3)) >> (8 - bits)).astype('uint8')
        for name, options in (('', {}), (', packbits', dict(compression=PACKBITS)), (', deflate', dict(compression=DEFLATE)),
                              (', tiled', dict(tile=(16, 16)))):
            # Their numbers, or stretched to 255 as in PNG files.
            found.append(case(f'{bits} bits{name}', stack(samples, bits=bits, **options), 'v.tif', Grid(samples),
                              Grid(samples * np.uint8(255 // (2**bits - 1))), refusable=bits > 1))
    return found


def resolution(x, y, unit) -> dict:
    return {282: (RATIONAL, [x]), 283: (RATIONAL, [y]), 296: (SHORT, [unit])}


def description(text) -> dict:
    data = text.encode() + b'\0'
    return {270: (ASCII, data)}


def places():
    samples = volume('uint8')
    found = []
    anywhere = Grid(samples, placed=False)
    for x, y, unit in (((72, 1), (72, 1), 2), ((10, 1), (20, 1), 3), ((1, 1), (1, 1), 1), ((0, 0), (0, 0), 2), ((0, 1), (0, 1), 3),
                       ((2**32 - 1, 1), (1, 2**32 - 1), 2), ((300, 1), (0, 1), 2), ((20000, 1), (40000, 3), 3)):
        for order in '<>':
            found.append(case(f'resolution {x}, {y}, unit {unit} {order}', stack(samples, order, tags=resolution(x, y, unit)), 'v.tif',
                              anywhere, by_program=order == '<', damage=order == '<' and unit == 3 and x == (10, 1)))
    spaced = Grid(samples, SPACING, units=MICRONS)
    imagej = 'ImageJ=1.53t\nimages=3\nslices=3\nunit={}\nspacing=2.0\nloop=false\nmin=0.0\nmax=255.0\n'
    per_unit = resolution((2000000, 1000000), (4, 3), 1)
    for unit in ('micron', 'um', '\\u00B5m', 'mm'):
        right = spaced if unit != 'mm' else Grid(samples, SPACING, units=('mm',))
        for order in '<>':
            found.append(case(f'ImageJ, {unit} {order}', stack(samples, order, first_tags={**per_unit, **description(imagej.format(unit))}),
                              'v.tif', right, by_program=True, damage=unit == 'micron' and order == '<'))
    for kind, c0, c1, becomes in (('uint16', -32768, 1, 'int16'), ('uint8', 10.5, 0.25, 'float32'), ('uint8', 0, 2, 'uint16')):
        grey = volume(kind)
        text = imagej.format('micron') + f'cf=0\nc0={c0}\nc1={c1}\nvunit=Gray Value\n'
        found.append(case(f'ImageJ, {kind} calibrated by {c0} + {c1} x', stack(grey, first_tags={**per_unit, **description(text)}),
                          'v.tif', Grid((grey.astype(float) * c1 + c0).astype(becomes), SPACING, units=MICRONS), by_program=True))
    everywhere = {**per_unit, **description(imagej.format('micron'))}
    found.append(case('ImageJ, said of every page', stack(samples, tags=everywhere), 'v.tif', spaced))
    found.append(case('ImageJ without resolution', stack(samples, first_tags=description(imagej.format('micron'))), 'v.tif', anywhere))
    found.append(case('ImageJ without spacing', stack(samples, first_tags={**per_unit, **description('ImageJ=1.53t\nimages=3\nslices=3\n')}),
                      'v.tif', anywhere))
    for spacing in ('0', '-2.0', 'nan', 'inf', 'x', '1e999', ''):
        text = imagej.format('micron').replace('spacing=2.0', 'spacing=' + spacing)
        found.append(case(f'ImageJ, spacing={spacing}', stack(samples, first_tags={**per_unit, **description(text)}), 'v.tif', anywhere,
                          refusable=True))
    # Six pages that are no six slices.
    six = volume('uint8', (5, 4, 6))
    for images in (5, 12):  # a stack longer than its description is whole
        found.append(case(f'ImageJ, {images} images on 6 pages', stack(six, first_tags=description(f'ImageJ=1.53t\nimages={images}\n')),
                          'v.tif', *([Grid(six)] if images == 5 else [])))
    for what in ('channels=2\nslices=3', 'frames=2\nslices=3', 'channels=2\nslices=3\nhyperstack=true', 'frames=6', 'channels=6'):
        text = f'ImageJ=1.53t\nimages=6\n{what}\n'
        found.append(case('ImageJ ' + what.replace('\n', ' '), stack(six, first_tags=description(text)), 'v.tif',
                          *([Grid(six, placed=False)] if what == 'frames=6' else []), refusable=True))
    # Stacks beyond 4 GB have one directory, and the slices follow each other.
    short = Writer()
    short.page(samples[:, :, 0], directory_first=True, tags=description(imagej.format('micron')))
    followed = bytes(short.data) + raw(samples[:, :, 1:])
    found.append(case('ImageJ, one directory for all slices', followed, 'v.tif', anywhere, refusable=True))
    ome = ('<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0">'
           '<Pixels ID="Pixels:0" DimensionOrder="{}" Type="uint8" SizeX="5" SizeY="4" SizeZ="{}" SizeC="{}" SizeT="{}" {}>'
           '<Channel ID="Channel:0:0" SamplesPerPixel="1"/><TiffData/></Pixels></Image></OME>')
    sizes = 'PhysicalSizeX="0.5" PhysicalSizeY="0.75" PhysicalSizeZ="2.0"'
    units = sizes + ''.join(f' PhysicalSize{a}Unit="{{0}}"' for a in 'XYZ')
    for name, text, right in (('', sizes, spaced), (' in µm', units.format('µm'), spaced),
                              (' in mm', units.format('mm'), Grid(samples, SPACING, units=('mm',)))):
        for order in '<>':
            tags = {**description(ome.format('XYZCT', 3, 1, 1, text)), **resolution((72, 1), (72, 1), 2)}
            found.append(case(f'OME{name} {order}', stack(samples, order, first_tags=tags), 'v.ome.tif', right, by_program=order == '<'))
    found.append(case('OME without sizes', stack(samples, first_tags=description(ome.format('XYZCT', 3, 1, 1, ''))), 'v.ome.tif', anywhere))
    found.append(case('OME, 24 slices on 3 pages', stack(samples, first_tags=description(ome.format('XYZCT', 24, 1, 1, ''))), 'v.ome.tif'))
    found.append(case('folder of slices with the OME of their stack', {
        f's{z}.ome.tif': stack(samples[:, :, z:z + 1], tags=description(ome.format('XYZCT', 3, 1, 1, sizes))) for z in range(3)}, '.', anywhere))
    found.append(case('OME, damaged', stack(samples, first_tags=description(ome.format('XYZCT', 3, 1, 1, sizes)[:250])), 'v.ome.tif', anywhere,
                      refusable=True))
    for z, c, t in ((3, 2, 1), (3, 1, 2), (1, 6, 1)):
        found.append(case(f'OME of {c} channels, {t} times', stack(six, first_tags=description(ome.format('XYZCT', z, c, t, sizes))),
                          'v.ome.tif'))
    return found


def forms():
    samples = volume('uint8')
    right = Grid(samples)
    found = []
    one = image(samples[:, :, 0])
    first = samples[:, :, :1]
    found.append(case('one page', stack(first), 'v.tif', one))
    found.append(case('one page, deflate', stack(first, compression=DEFLATE), 'v.tif', one))
    found.append(case('one page, a slab', stack(first), 'v.tif', Grid(first), how=(('dimension', '3'),)))
    found.append(case('several pages, an image', stack(samples), 'v.tif', usage=True, how=(('dimension', '2'),)))
    microns = description('ImageJ=1.53c\nunit=micron\n')
    for name, tags, spacing in (('in microns', {**microns, **resolution((2000000, 1000000), (4, 1), 1)}, (0.5, 0.25)),
                                ('of a scanner', resolution((300, 1), (300, 1), 2), (1, 1))):
        found.append(case(f'one page, {name}', stack(first, tags=tags), 'v.tif', image(samples[:, :, 0], spacing)))
    for kind in ('uint8', 'uint16', 'float32'):
        values = volume(kind)
        found.append(case(f'folder of {kind}', {f's{z}.tif': stack(values[:, :, z:z + 1]) for z in range(3)}, '.', Grid(values), damage=True,
                          by_program=True))
        tags = resolution((10, 1), (20, 1), 3)
        found.append(case(f'folder of {kind} with resolution', {f's{z}.tif': stack(values[:, :, z:z + 1], tags=tags) for z in range(3)}, '.',
                          Grid(values, placed=False), by_program=True))
    found.append(case('folder with a stack', {'a.tif': stack(first), 'b.tif': stack(samples)}, '.'))
    found.append(case('folder of two types', {'a.tif': stack(first), 'b.tif': stack(volume('uint16')[:, :, :1])}, '.'))
    found.append(case('folder of two sizes', {'a.tif': stack(first), 'b.tif': stack(samples[:4, :, :1])}, '.'))
    # Without a tag, its default holds.
    for tag, name in ((277, 'SamplesPerPixel'), (339, 'SampleFormat'), (278, 'RowsPerStrip'), (259, 'Compression')):
        found.append(case(f'no {name}', stack(samples, tags={tag: None}), 'v.tif', right))
    for tag, name in ((262, 'photometric interpretation'), (279, 'StripByteCounts')):
        found.append(case(f'no {name}', stack(samples, tags={tag: None}), 'v.tif', right, refusable=True))
    for tag, name in ((256, 'width'), (257, 'length'), (273, 'StripOffsets')):
        found.append(case(f'no {name}', stack(samples, tags={tag: None}), 'v.tif'))
    found.append(case('SampleFormat void', stack(samples, tags={339: (SHORT, [4])}), 'v.tif', right, refusable=True))
    found.append(case('sizes as SHORT', stack(samples, tags={256: (SHORT, [5]), 257: (SHORT, [4]), 278: (SHORT, [4])}), 'v.tif', right))
    found.append(case('NewSubfileType 2', stack(samples, tags={254: (LONG, [2])}), 'v.tif', right))
    found.append(case('private tags', stack(samples, tags={65000: (LONG, [1, 2, 3]), 50838: (LONG, [12, 8])}), 'v.tif', right))
    # White is 0: turned over, or refused.
    found.append(case('white is 0', stack(samples, photometric=0), 'v.tif', Grid(255 - samples), refusable=True))
    for orientation, turned in ((2, samples[::-1]), (3, samples[::-1, ::-1]), (4, samples[:, ::-1]), (5, samples.transpose(1, 0, 2)),
                                (6, samples[:, ::-1].transpose(1, 0, 2)), (7, samples[::-1, ::-1].transpose(1, 0, 2)),
                                (8, samples[::-1].transpose(1, 0, 2))):
        found.append(case(f'orientation {orientation}', stack(samples, tags={274: (SHORT, [orientation])}), 'v.tif', Grid(turned),
                          refusable=True))
    greys = [v * 257 for v in range(256)] * 3
    found.append(case('palette of greys', stack(samples, photometric=3, tags={320: (SHORT, greys)}), 'v.tif', right, refusable=True))
    colours = [v * 257 for v in range(256)] * 2 + [v * 100 for v in range(256)]
    # The indices of the colours, as ImageJ saves labels, or refused.
    found.append(case('palette of colours', stack(samples, photometric=3, tags={320: (SHORT, colours)}), 'v.tif', right, refusable=True))
    found.append(case('palette missing', stack(samples, photometric=3), 'v.tif', right, refusable=True))
    rgb = {277: (SHORT, [3]), 258: (SHORT, [8, 8, 8]), 262: (SHORT, [2]), 257: (LONG, [1])}
    found.append(case('RGB', stack(samples, tags=rgb), 'v.tif'))
    alpha = {277: (SHORT, [2]), 258: (SHORT, [8, 8]), 338: (SHORT, [2]), 257: (LONG, [2])}
    found.append(case('grey with alpha', stack(samples, tags=alpha), 'v.tif'))
    for compression in (2, 3, 4, 6, 7, 34712, 34925, 50000, 65535):
        found.append(case(f'compression {compression} that it is not', stack(samples, tags={259: (SHORT, [compression])}), 'v.tif'))
    for bits in (0, 3, 7, 12, 24, 128, 65535):
        found.append(case(f'{bits} bits', stack(samples, tags={258: (SHORT, [bits])}), 'v.tif'))
    found.append(case('bits of complex numbers', stack(volume('float32'), tags={339: (SHORT, [6])}), 'v.tif'))
    return found


def coloured():
    found = []
    for bits in (8, 16):
        for n, photometric, extra in ((3, 2, None), (4, 2, 2), (2, 1, 2), (4, 2, 0)):
            pixels = pictures.random_pixels((20, 9), n, bits)
            known = pixels[:, :, :3] if extra == 0 else pixels  # of a sample nobody has named
            flat = pixels.transpose(0, 2, 1).reshape(20 * n, 9, 1)
            tags = {256: (LONG, [20]), 258: (SHORT, [bits] * n), 277: (SHORT, [n]), 262: (SHORT, [photometric]),
                    338: None if extra is None else (SHORT, [extra])}
            name = f'{n} samples of {bits} bits' + ('' if extra is None else f', extra {extra}')
            for order in '<>':
                data = stack(flat, order=order, tags=tags, rows_per_strip=4)
                found += pictures.channel_cases(f'{name} {order}', data, 'v.tif', known, damage=order == '<' and extra == 2, pillow=False)
            for what, more in (('tiles', dict(tile=(16 * n, 16), tags={**tags, 322: (LONG, [16])})), ('deflate', dict(tags=tags, compression=DEFLATE))):
                found.append(case(f'{name}, {what}', stack(flat, **more), 'v.tif', image(pictures.own_value(known))))
            for orientation, turned in ((3, known[::-1, ::-1]), (6, known[:, ::-1].transpose(1, 0, 2))):
                found.append(case(f'{name}, orientation {orientation}', stack(flat, tags={**tags, 274: (SHORT, [orientation])}), 'v.tif',
                                  image(pictures.own_value(turned))))
            two = np.concatenate([flat, flat[::-1]], axis=2)
            found.append(case(f'{name}, two pages', stack(two, tags=tags), 'v.tif'))
            reds = np.stack([pictures.value(p, 'red') for p in (known, two[:, :, 1].reshape(20, n, 9).transpose(0, 2, 1)[:, :, :known.shape[2]])], axis=2)
            found.append(case(f'{name}, two pages, red', stack(two, tags=tags), 'v.tif', Grid(reds), how=(('channel', 'red'),)))
            found.append(case(f'{name}, planes', stack(flat, tags={**tags, 284: (SHORT, [2])}), 'v.tif'))
            found.append(case(f'{name}, in a folder', {'a.tif': stack(flat, tags=tags), 'b.tif': stack(flat, tags=tags)}, '.'))
    stencil = pictures.stencil(4, 8)
    tags = {256: (LONG, [13]), 258: (SHORT, [8] * 4), 277: (SHORT, [4]), 262: (SHORT, [2]), 338: (SHORT, [2])}
    found += pictures.channel_cases('stencil', stack(stencil.transpose(0, 2, 1).reshape(52, 9, 1), tags=tags), 'v.tif', stencil)
    associated = stencil.copy()
    associated[:, :, :3] = pictures.rounded(stencil[:, :, :3].astype(int) * stencil[:, :, 3:], 255)
    found.append(case('associated alpha', stack(associated.transpose(0, 2, 1).reshape(52, 9, 1), tags={**tags, 338: (SHORT, [1])}), 'v.tif',
                      image(stencil[:, :, 3]), how=(('channel', 'alpha'),)))
    indices = volume('uint8')
    table = np.random.default_rng(2).integers(0, 256, (256, 3))
    mapped = {320: (SHORT, [int(v) * 257 for v in table.T.ravel()])}
    data = stack(indices[:, :, :1], photometric=3, tags=mapped)
    found.append(case('palette of one page', data, 'v.tif', image(indices[:, :, 0])))  # labels, as ImageJ saves them
    pixels = table[indices].astype('uint8')
    for channel in ('luminance', 'red', 'green', 'blue'):
        how = (('channel', channel),)
        found.append(case(f'palette of one page, {channel}', data, 'v.tif', image(pictures.value(pixels[:, :, 0], channel)), how=how))
        found.append(case(f'palette of a stack, {channel}', stack(indices, photometric=3, tags=mapped), 'v.tif',
                          Grid(pictures.value(pixels, channel)), how=how))
    return found


def pages():
    """Stacks with a page that is another or damaged: never one slice less without a word."""
    samples = volume('uint8', (5, 4, 12))
    right = Grid(samples)
    found = [case('12 pages', stack(samples), 'v.tif', right, by_program=True)]
    for order in '<>':
        writer = Writer(order)
        for z in range(12):
            writer.page(samples[:, :, z])
        whole, places = bytes(writer.data), writer.directories
        fmt, short = order + 'I', order + 'H'
        for page in (1, 5, 11):
            at = places[page]
            count = struct.unpack(short, whole[at:at + 2])[0]

            def changed(place, data):
                return whole[:place] + data + whole[place + len(data):]
            before = places[page - 1] + 2 + 12 * count  # the link to this page
            for name, data in (
                    ('of no entries', changed(at, struct.pack(short, 0))), ('of 65535 entries', changed(at, struct.pack(short, 65535))),
                    ('overwritten', changed(at, b'\xff' * (2 + 12 * count))), ('zeroed', changed(at, bytes(2 + 12 * count))),
                    ('with a type of no kind', changed(at + 4, struct.pack(short, 99))),
                    ('with a huge count', changed(at + 2 + 12 * (count - 2) + 4, struct.pack(fmt, 2**32 - 1))),
                    ('beyond the file', changed(before, struct.pack(fmt, 2**31))), ('at the last byte', changed(before, struct.pack(fmt, len(whole) - 1))),
                    ('in the header', changed(before, struct.pack(fmt, 1)))):
                found.append(case(f'page {page} {name} {order}', data, 'v.tif', right, refusable=True))
            found.append(case(f'page {page} is the first one again {order}', changed(before, struct.pack(fmt, places[0])), 'v.tif'))
            found.append(case(f'page {page} leads to itself {order}', changed(at + 2 + 12 * count, struct.pack(fmt, at)), 'v.tif',
                              *([right] if page == 11 else []), refusable=True))
        found.append(case(f'no page {order}', whole[:4] + bytes(4) + whole[8:], 'v.tif'))
    others = {'of 16 bits': volume('uint16', (5, 4, 1)), 'of signed samples': volume('int8', (5, 4, 1)), 'wider': volume('uint8', (6, 4, 1)),
              'lower': volume('uint8', (5, 3, 1)), 'of floats': volume('float32', (5, 4, 1))}
    for name, other in others.items():
        for where in (0, 1, 2):
            writer = Writer()
            for z in range(3):
                writer.page(other[:, :, 0] if z == where else samples[:, :, z])
            found.append(case(f'page {where} {name}', bytes(writer.data), 'v.tif'))
    for name, options, refusable in (('deflated', dict(compression=DEFLATE), False), ('tiled', dict(tile=(16, 16)), True),
                                     ('of strips', dict(rows_per_strip=1), False)):
        writer = Writer()
        for z in range(3):
            writer.page(samples[:, :, z], **(options if z == 1 else {}))
        found.append(case(f'page 1 {name}', bytes(writer.data), 'v.tif', Grid(samples[:, :, :3]), refusable=refusable))
    writer = Writer()
    for z in range(3):
        writer.page(samples[:, :, z])
        writer.page(samples[::2, ::2, z], tags={254: (LONG, [1])})
    found.append(case('reduced pages between', bytes(writer.data), 'v.tif', Grid(samples[:, :, :3]), refusable=True))
    writer = Writer()
    for z in range(3):
        writer.page(samples[:, :, z])
    writer.page(samples[:, :, 3], tags={254: (LONG, [4]), 262: (SHORT, [4])})
    found.append(case('a mask behind', bytes(writer.data), 'v.tif', Grid(samples[:, :, :3]), refusable=True))
    return found


def sizes():
    samples = volume('uint16')
    found = []

    # Of the header: the samples are those of 5 x 4 pixels.
    def with_tags(tags, **more):
        return stack(samples, tags=tags, **more)
    for tag, axis in ((256, 0), (257, 1)):
        for size in (DIMS[axis] + 1, DIMS[axis] - 1, 0, 2**15, 2**31 - 1, 2**31, 2**32 - 1):
            dims = tuple(size if a == axis else DIMS[a] for a in range(2))
            rights = []
            if 0 < size < DIMS[axis]:  # of every page a prefix
                prefix = [samples[:, :, z].ravel(order='F')[:dims[0] * dims[1]].reshape(dims, order='F') for z in range(3)]
                rights = [Grid(np.stack(prefix, axis=2))]
            for compression in (NONE, DEFLATE):
                found.append(case(f'header claims {dims}, compression {compression}', with_tags({tag: (LONG, [size])}, compression=compression),
                                  'v.tif', *rights, refusable=True))
    for rows in (0, 1, 2, 5, 2**31, 2**32 - 1):
        found.append(case(f'rows per strip {rows}', with_tags({278: (LONG, [rows])}), 'v.tif', Grid(samples), refusable=rows < 4))
    for count in (0, 1, 39, 2**31, 2**32 - 1):
        found.append(case(f'strip of {count} bytes', with_tags({279: (LONG, [count])}), 'v.tif', Grid(samples), refusable=True))
    for offset in (0, 4, 2**31, 2**32 - 1):  # in the header of the file, or beyond its end
        found.append(case(f'strip at {offset}', with_tags({273: (LONG, [offset])}), 'v.tif'))
    for tile in ((0, 16), (16, 0), (17, 16), (2**31, 16), (2**32 - 1, 2**32 - 1)):
        found.append(case(f'tiles of {tile}', stack(samples, tile=(16, 16), tags={322: (LONG, [tile[0]]), 323: (LONG, [tile[1]])}), 'v.tif',
                          refusable=True))
    for size in (6, 0, 2**32 - 1):
        found.append(case(f'width {size}, tiled', stack(samples, tile=(16, 16), tags={256: (LONG, [size])}), 'v.tif',
                          *([Grid(np.concatenate([samples, np.zeros((1, 4, 3), 'uint16')]))] if size == 6 else []), refusable=True))
    return found


def cases():
    found = encodings() + places() + forms() + coloured() + pages() + sizes()
    return found + [c for whole in found if whole.damage for c in damaged(whole)]
