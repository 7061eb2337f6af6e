# SPDX-License-Identifier: Apache-2.0
"""Files of Quench without any other library than numpy: .vtp, .ply and .ma medial axes and skeletons, .swc trees.

`read(path)` gives a Data: points, edges, faces, and arrays per point, edge and face.
"""
import base64
import os
import re
import struct
import xml.etree.ElementTree
import zlib

import numpy


class Data:
    """Points (n, 3), edges (m, 2) of curves and, where the file has them, of sheets, faces (lists of numbers of points), and
    arrays by name."""

    def __init__(self, points):
        self.points = numpy.asarray(points, float).reshape(-1, 3)
        self.edges, self.faces = numpy.empty((0, 2), int), []
        self.of_points, self.of_edges, self.of_faces = {}, {}, {}
        self.paths = []  # of trees: numbers of points from a fork or root to the next fork or tip

    @property
    def size(self):
        return float(numpy.ptp(self.points, axis=0).max()) if len(self.points) else 0.0


def read(path):
    """Raises ValueError, with a sentence, for what is no such file."""
    kind = os.path.splitext(path)[1].lower()
    readers = {'.vtp': read_vtp, '.ply': read_ply, '.ma': read_ma, '.swc': read_swc}
    if kind not in readers:
        raise ValueError(f"'{path}' is none of {', '.join(sorted(readers))}")
    try:
        return readers[kind](path)
    except (KeyError, IndexError, StopIteration, struct.error, zlib.error, UnicodeDecodeError, TypeError,
            xml.etree.ElementTree.ParseError) as error:
        raise ValueError(f"'{path}' cannot be read: {error!r}") from error


# ---------------------------------------------------------------------------------------------------------------- VTP

TYPES = {'Int8': 'i1', 'UInt8': 'u1', 'Int16': 'i2', 'UInt16': 'u2', 'Int32': 'i4', 'UInt32': 'u4', 'Int64': 'i8',
         'UInt64': 'u8', 'Float32': 'f4', 'Float64': 'f8'}


class VtpArrays:
    """The arrays of an XML file of VTK: inline or appended, ascii or binary, packed or not."""

    def __init__(self, root, appended, raw):
        self.order = '<' if root.get('byte_order', 'LittleEndian') == 'LittleEndian' else '>'
        self.header = self.order + ('u8' if root.get('header_type') == 'UInt64' else 'u4')
        self.packed = root.get('compressor')
        if self.packed not in (None, 'vtkZLibDataCompressor'):
            raise ValueError(f'{self.packed} is not supported')
        self.appended, self.raw = appended, raw

    def numbers(self, data, count):
        """`count` numbers of a header from the beginning, and where they end."""
        size = count * int(self.header[-1])
        if isinstance(data, str):
            end = (size + 2) // 3 * 4
            return numpy.frombuffer(base64.b64decode(data[:end])[:size], self.header), end
        return numpy.frombuffer(data[:size], self.header), size

    def bytes_of(self, data):
        decoded = base64.b64decode if isinstance(data, str) else bytes
        if not self.packed:
            size, end = self.numbers(data, 1)
            if isinstance(data, str):
                return base64.b64decode(data[:(int(size[0]) + int(self.header[-1]) + 2) // 3 * 4])[int(self.header[-1]):]
            return bytes(data[end:end + int(size[0])])
        blocks = int(self.numbers(data, 1)[0][0])
        header, end = self.numbers(data, 3 + blocks)
        sizes = header[3:].astype(int)
        total = int(sizes.sum())
        body = decoded(data[end:end + ((total + 2) // 3 * 4 if isinstance(data, str) else total)])
        ends = numpy.cumsum(sizes)
        return b''.join(zlib.decompress(body[e - s:e]) for s, e in zip(sizes, ends))

    def of(self, node):
        kind, components = TYPES[node.get('type')], int(node.get('NumberOfComponents') or 1)
        if node.get('format') == 'ascii':
            values = numpy.array((node.text or '').split(), float).astype(kind)
        else:
            inline = node.get('format') == 'binary'
            data = (node.text or '').strip() if inline else self.appended[int(node.get('offset')):]
            values = numpy.frombuffer(self.bytes_of(data), self.order + kind)
        return values.reshape(-1, components) if components > 1 else values


def read_vtp(path):
    with open(path, 'rb') as file:
        text = file.read()
    begin = text.find(b'<AppendedData')
    appended, raw = b'', False
    if begin >= 0:
        raw = b'raw' in text[begin:text.index(b'>', begin)]
        start = text.index(b'_', begin) + 1
        appended = memoryview(text)[start:] if raw else text[start:text.index(b'<', start)].decode('ascii')
        text = text[:begin] + b'</VTKFile>'
    root = xml.etree.ElementTree.fromstring(text)
    arrays = VtpArrays(root, appended, raw)
    piece = root.find('PolyData/Piece')
    if piece is None:
        raise ValueError(f"'{path}' is no VTK file of polygons")
    data = Data(arrays.of(piece.find('Points/DataArray')))
    cells = {}
    for name in ('Verts', 'Lines', 'Polys'):
        found = {node.get('Name'): node for node in piece.findall(f'{name}/DataArray')}
        if len(found) < 2 or not int(piece.get(f'NumberOf{name}') or 0):
            cells[name] = []
            continue
        ends = arrays.of(found['offsets']).astype(int)
        cells[name] = numpy.split(arrays.of(found['connectivity']).astype(int), ends[:-1])
    segments = [(line[:-1], line[1:]) for line in cells['Lines']]
    if segments:
        data.edges = numpy.stack([numpy.concatenate(side) for side in zip(*segments)], axis=1)
    data.faces = [face.tolist() for face in cells['Polys']]
    data.paths = [line.tolist() for line in cells['Lines']]

    def each(group):
        for node in piece.findall(f'{group}/DataArray'):
            if node.get('type') in TYPES:
                values = arrays.of(node)
                if values.ndim == 1:
                    yield node.get('Name'), values

    data.of_points.update(each('PointData'))
    before, lines = len(cells['Verts']), len(cells['Lines'])
    lengths = [len(line) - 1 for line in cells['Lines']]
    for name, values in each('CellData'):
        data.of_edges[name] = numpy.repeat(values[before:before + lines], lengths)
        data.of_faces[name] = values[before + lines:before + lines + len(data.faces)]
    return data


# ---------------------------------------------------------------------------------------------------- other formats

PLY_TYPES = {'char': 'i1', 'int8': 'i1', 'uchar': 'u1', 'uint8': 'u1', 'short': 'i2', 'int16': 'i2', 'ushort': 'u2',
             'uint16': 'u2', 'int': 'i4', 'int32': 'i4', 'uint': 'u4', 'uint32': 'u4', 'float': 'f4', 'float32': 'f4',
             'double': 'f8', 'float64': 'f8'}


def ply_header(text, path):
    """The format, elements as (name, count, [(property, type, type of the length of a list)]), and where bodies begin."""
    end = re.search(rb'end_header\r?\n', text)
    if not text.startswith(b'ply') or not end:
        raise ValueError(f"'{path}' is no PLY file")
    kind, elements = '', []
    for line in text[:end.start()].decode('latin-1').splitlines():
        words = line.split()
        if words and words[0] == 'format':
            kind = words[1]
        elif words and words[0] == 'element':
            elements.append((words[1], int(words[2]), []))
        elif words and words[0] == 'property' and words[1] == 'list':
            elements[-1][2].append((words[4], PLY_TYPES[words[3]], PLY_TYPES[words[2]]))
        elif words and words[0] == 'property':
            elements[-1][2].append((words[2], PLY_TYPES[words[1]], None))
    return kind, elements, end.end()


def read_ply(path):
    with open(path, 'rb') as file:
        text = file.read()
    kind, elements, at = ply_header(text, path)
    words = iter(text[at:].split()) if kind == 'ascii' else None
    order = '>' if kind == 'binary_big_endian' else '<'

    def one(code):
        nonlocal at
        if words is not None:
            return float(next(words))
        value = numpy.frombuffer(text, order + code, 1, at)[0]
        at += int(code[1])
        return value

    def rows(count, properties):
        """Columns by name; those of lists are lists of lists."""
        nonlocal at
        if words is None and all(length is None for _, _, length in properties):
            table = numpy.frombuffer(text, [(name, order + code) for name, code, _ in properties], count, at)
            at += table.nbytes
            return {name: table[name] for name, _, _ in properties}
        if words is None and len(properties) == 1 and count:  # lists of one length, as of triangles
            name, code, length = properties[0]
            n = int(numpy.frombuffer(text, order + length, 1, at)[0])
            shape = [('n', order + length), ('ids', order + code, (n,))]
            if at + count * numpy.dtype(shape).itemsize <= len(text):
                table = numpy.frombuffer(text, shape, count, at)
                if (table['n'] == n).all():
                    at += table.nbytes
                    return {name: table['ids'].tolist()}
        columns = {name: [] for name, _, _ in properties}
        for _ in range(count):
            for name, code, length in properties:
                value = one(code) if length is None else [int(one(code)) for _ in range(int(one(length)))]
                columns[name].append(value)
        return {name: values if any(length for n, _, length in properties if n == name) else numpy.array(values)
                for name, values in columns.items()}

    tables = {name: rows(count, properties) for name, count, properties in elements}
    vertices = tables['vertex']
    data = Data(numpy.stack([vertices[axis] for axis in 'xyz'], axis=1))
    data.of_points = {name: values for name, values in vertices.items()
                      if name not in ('x', 'y', 'z', 'red', 'green', 'blue', 'alpha')}
    data.faces = next((list(values) for values in tables.get('face', {}).values() if isinstance(values, list)), [])
    if 'edge' in tables and len(tables['edge'].get('vertex1', ())):
        data.edges = numpy.stack([tables['edge']['vertex1'], tables['edge']['vertex2']], axis=1).astype(int)
    return data


def read_ma(path):
    points, radii, edges, faces = [], [], [], []
    with open(path, encoding='utf-8') as file:
        counts = [int(word) for word in next(file).split()][:3]
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0] == 'v':
                points.append([float(word) for word in words[1:4]])
                radii.append(float(words[4]))
            elif words[0] == 'e':
                edges.append([int(word) for word in words[1:3]])
            elif words[0] == 'f':
                faces.append([int(word) for word in words[1:4]])
    if counts != [len(points), len(edges), len(faces)] or any(not 0 <= i < len(points) for ids in edges + faces for i in ids):
        raise ValueError(f"'{path}' is not a medial axis in the MAT format, or not all of it")
    data = Data(points)
    sides = {frozenset(pair) for face in faces for pair in zip(face, face[1:] + face[:1])}
    data.edges = numpy.array([edge for edge in edges if frozenset(edge) not in sides], int).reshape(-1, 2)
    data.faces = faces
    data.of_points['radius'] = numpy.array(radii)
    return data


def read_swc(path):
    rows = []
    with open(path, encoding='utf-8') as file:
        for line in file:
            words = line.split('#')[0].split()
            if len(words) >= 7:
                rows.append([float(word) for word in words[:7]])
    if not rows:
        raise ValueError(f"'{path}' has no samples")
    table = numpy.array(rows)
    number_of = {int(number): i for i, number in enumerate(table[:, 0])}
    up = [number_of.get(int(parent), -1) for parent in table[:, 6]]
    children = [0] * len(up)
    for parent in up:
        if parent >= 0:
            children[parent] += 1
    data = Data(table[:, 2:5])
    data.of_points = {'radius': table[:, 5], 'type': table[:, 1].astype(int)}
    data.edges = numpy.array([(parent, i) for i, parent in enumerate(up) if parent >= 0], int).reshape(-1, 2)
    for end, parent in enumerate(up):
        if parent < 0 or children[end] == 1:
            continue
        path_up = [end, parent]
        while up[path_up[-1]] >= 0 and children[path_up[-1]] == 1:
            path_up.append(up[path_up[-1]])
        data.paths.append(path_up[::-1])
    return data
