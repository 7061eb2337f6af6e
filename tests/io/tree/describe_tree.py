# SPDX-License-Identifier: Apache-2.0
"""Reads trees of every format by the rules of its specification, and none of Quench's code.

describe_tree.py FILE...  prints what is in each, "file NAME" and a fact per line; exit 1 with a sentence where one breaks
                          a rule. Of .vtp nothing where VTK is missing
"""
import collections
import math
import os
import sys
import xml.etree.ElementTree as ET


class Broken(Exception):
    pass


def need(condition, sentence):
    if not condition:
        raise Broken(sentence)


class Nodes:
    """A forest of nodes: what all formats have in common."""

    def __init__(self):
        self.points, self.radii, self.parents, self.levels, self.begins = [], [], [], [], []

    def add(self, point, radius, parent, level=None, begin=None):
        """`begin`: the radius at the beginning of the segment to the parent, where it is not that of the parent."""
        point = tuple(point)
        need(len(point) == 3 and all(math.isfinite(x) for x in point) and math.isfinite(radius) and radius >= 0, 'a number is not finite')
        self.points.append(point)
        self.radii.append(radius)
        self.parents.append(parent)
        self.levels.append(level)
        self.begins.append(begin)
        return len(self.points) - 1

    def facts(self):
        children = collections.Counter(p for p in self.parents if p is not None)
        length = moment = frusta = 0.0
        by_level = collections.Counter()
        for i, p in enumerate(self.parents):
            if p is None:
                continue
            a, b = self.points[p], self.points[i]
            step = math.dist(a, b)
            length += step
            moment += step * sum(w * (x + y) / 2 for w, x, y in zip((1, 2, 3), a, b))
            frusta += step * ((self.radii[p] if self.begins[i] is None else self.begins[i]) + self.radii[i]) / 2
            by_level[self.levels[i]] += step
        yield 'trees', sum(p is None for p in self.parents)
        yield 'nodes', len(self.points)
        yield 'tips', sum(children[i] == 0 for i in range(len(self.points)))
        yield 'forks', sum(children[i] > 1 for i in range(len(self.points)))
        yield 'length', length
        yield 'moment', moment
        yield 'frusta', frusta
        for level in sorted(by_level, key=str):
            if level is not None:
                yield f'length_of_level_{level}', by_level[level]


def swc(path):
    """SWC as MorphIO takes it: types of 1 to 19, parents first, the soma at roots only and of one sample."""
    nodes, index, types = Nodes(), {}, []
    with open(path, encoding='utf-8') as file:
        for number, line in enumerate(file, 1):
            if line.startswith('#') or not line.strip():
                need(line.startswith('#') and not index, f'line {number}: comments stand in front only')
                continue
            words = line.split(' ')
            need(len(words) == 7, f'line {number} has {len(words)} columns')
            name, kind, parent = int(words[0]), int(words[1]), int(words[6])
            need(name == len(index) + 1, f'line {number}: ids are 1, 2, 3 ...')
            need(1 <= kind <= 19, f'line {number}: type {kind}')
            need(parent == -1 or parent in index, f'line {number}: the parent does not come first')
            need(kind != 1 or parent == -1, f'line {number}: a soma has a parent')
            index[name] = nodes.add(map(float, words[2:5]), float(words[5]), None if parent == -1 else index[parent])
            types.append(kind)
    need(nodes.parents and nodes.parents[0] is None, 'the first sample is no root')
    yield from nodes.facts()
    yield 'somas', types.count(1)
    yield 'types', ','.join(f'{t}:{types.count(t)}' for t in sorted(set(types)))


def rsml(path):
    """RSML 1 (https://rootsystemml.github.io/format): metadata, scene, plants, nested roots."""
    root = ET.parse(path).getroot()
    need(root.tag == 'rsml', 'the document is no rsml')
    need([c.tag for c in root][:2] == ['metadata', 'scene'] or {c.tag for c in root} >= {'metadata', 'scene'},
         'metadata or scene are missing')
    metadata = root.find('metadata')
    for name in ('version', 'unit', 'resolution', 'software', 'user', 'file-key'):
        need(len(metadata.findall(name)) == 1, f'metadata has no {name}, or several')
    resolution = float(metadata.find('resolution').text)
    defined = {d.find('label').text: d.find('type').text for d in metadata.iterfind('property-definitions/property-definition')}
    nodes, ids, found = Nodes(), set(), collections.Counter()

    def visit(element, level, parent, parent_nodes, plant_root):
        name = element.attrib.get('id', element.attrib.get('ID'))
        need(name and name not in ids, 'a root has no id of its own')
        ids.add(name)
        polylines = element.findall('geometry/polyline')
        need(len(polylines) == 1, 'a root has no polyline, or several')
        points = [tuple(float(p.attrib[c]) / resolution for c in 'xyz' if c in p.attrib) for p in polylines[0]]
        need(all(p.tag == 'point' for p in polylines[0]) and len(points) > 1, 'a polyline is not made of points')
        need(len({len(p) for p in points}) == 1, 'a polyline is of several dimensions')
        points = [p + (0.0,) * (3 - len(p)) for p in points]
        radii = [0.0] * len(points)
        for function in element.iterfind('functions/function'):
            need(function.attrib['domain'] in ('polyline', 'uniform', 'length'), 'a function has no domain')
            samples = [s.attrib['value'] for s in function.iterfind('sample')]
            need(function.attrib['domain'] != 'polyline' or len(samples) == len(points),
                 f'{function.attrib["name"]} has {len(samples)} samples for {len(points)} points')
            found[function.attrib['name']] += 1
            if function.attrib['name'] == 'diameter':
                radii = [float(s) / 2 / resolution for s in samples]
        properties = {p.tag: p.attrib['value'] for p in element.iterfind('properties/*')}
        for label, value in properties.items():
            found[label] += 1
            if defined.get(label) in ('real', 'integer'):
                need(math.isfinite((float if defined[label] == 'real' else int)(value)), f'{label} is {value}')
        need(int(properties['level']) == level, 'a root has another level than depth')
        if parent is None:
            base = plant_root
        else:
            at = int(properties['parent-node'])
            need(1 <= at <= len(parent_nodes), 'parent-node is no node of the parent')
            base = parent_nodes[at - 1]
        if math.dist(nodes.points[base], points[0]) > 1e-9 * (1 + math.hypot(*points[0])):  # a link
            base = nodes.add(points[0], radii[0], base, level, radii[0])
        course = [base]
        for i in range(1, len(points)):
            course.append(nodes.add(points[i], radii[i], course[-1], level, radii[i - 1]))
        need(math.isclose(float(properties['length']), sum(math.dist(a, b) for a, b in zip(points, points[1:])), rel_tol=1e-9),
             'the length is another')
        for child in element.iterfind('root'):
            visit(child, level + 1, element, course, plant_root)

    plants = root.findall('scene/plant')
    for plant in plants:
        mains = plant.findall('root')
        longest = max(mains, key=lambda e: float(e.find('properties/length').attrib['value']))
        start = tuple(float(longest.find('geometry/polyline')[0].attrib.get(c, 0)) / resolution for c in 'xyz')
        ends = longest.findall("functions/function[@name='diameter']/sample")
        plant_root = nodes.add(start, float(ends[0].attrib['value']) / 2 / resolution if ends else 0.0, None, 0)
        for element in mains:
            visit(element, 0, None, [], plant_root)
    yield from nodes.facts()
    yield 'axes', len(ids)
    yield 'unit', metadata.find('unit').text
    yield 'last_modified', getattr(metadata.find('last-modified'), 'text', None) or 'none'
    yield 'labels', '|'.join(e.attrib['label'] for e in root.iter('root') if 'label' in e.attrib)
    yield 'found', ','.join(f'{k}:{v}' for k, v in sorted(found.items()))


def mtg(path):
    """MTG, form A (Godin and Caraglio 1998; OpenAlea's user guide): sections, then a vertex per line."""
    with open(path, encoding='utf-8') as file:
        lines = [line.rstrip('\n') for line in file]
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith('#')]
    sections = ['CODE', 'CLASSES', 'DESCRIPTION', 'FEATURES', 'MTG']
    at = [next(i for i, line in enumerate(lines) if line.startswith(name + ':')) for name in sections]
    need(at == sorted(at), 'the sections are not in order')
    need(lines[at[0]].split() == ['CODE:', 'FORM-A'], 'another form')
    need(lines[at[1] + 1].split() == ['SYMBOL', 'SCALE', 'DECOMPOSITION', 'INDEXATION', 'DEFINITION'], 'the head of CLASSES')
    scales = {words[0]: int(words[1]) for words in map(str.split, lines[at[1] + 2:at[2]])}
    need(lines[at[2] + 1].split() == ['LEFT', 'RIGHT', 'RELTYPE', 'MAX'], 'the head of DESCRIPTION')
    relations = {tuple(words[:3]) for words in map(str.split, lines[at[2] + 2:at[3]])}
    need(lines[at[3] + 1].split() == ['NAME', 'TYPE'], 'the head of FEATURES')
    types = dict(map(str.split, lines[at[3] + 2:at[4]]))
    header = lines[at[4] + 1]
    need(header.startswith('ENTITY-CODE\t'), 'no ENTITY-CODE')
    columns = len(header) - len('ENTITY-CODE') - len(header[len('ENTITY-CODE'):].lstrip('\t'))
    features = header[len('ENTITY-CODE'):].split()
    need(all(f in types for f in features), 'a feature is not declared')
    nodes = Nodes()
    last = {}  # per column: the vertex of each scale above
    counts, names = collections.Counter(), []
    index = {}  # per column: the number of the last S
    vertex, successors = {}, set()  # lines: of the last S per column, and those that another S follows
    for number, line in enumerate(lines[at[4] + 2:], at[4] + 3):
        fields = line.split('\t')
        column = next(i for i, f in enumerate(fields) if f)
        need(column < columns and len(fields) == columns + len(features), f'{line!r}: columns')
        code = fields[column]
        values = dict(zip(features, fields[columns:]))
        for name, value in values.items():
            if value:
                {'REAL': float, 'INT': int, 'ALPHA': str}[types[name]](value)
        follows = code.startswith('^')
        relation, label = code[follows], code[follows + 1:]
        symbol = label.rstrip('0123456789')
        need(relation in '/<+' and symbol in scales and label[len(symbol):].isdigit(), f'{code}: not a vertex')
        scale = scales[symbol]
        for deeper in [c for c in last if c > column]:
            del last[deeper]
        if relation == '+':
            need(not follows and column > 0, f'{code}: a branch is in the next column')
            bearer = last[column - 1]
            need(('A', 'A', '+') in relations and ('S', 'S', '+') in relations, 'the relation + is not described')
            last[column] = {s: v for s, v in bearer.items() if s < scale}
            pending = bearer[3]
        elif relation == '/':
            need(follows or column == 0, f'{code}: no vertex above')
            here = last.setdefault(column, {})
            need(scale == 1 or scale - 1 in here, f'{code}: what it is a part of is missing')
            for s in [s for s in here if s >= scale]:
                del here[s]
            if not follows:
                pending = None
        else:
            need(follows and (symbol, symbol, '<') in relations and scale in last[column], f'{code}: nothing to follow')
        counts[symbol] += 1
        if symbol == 'P':
            last[column][1] = label
            pending = None
            names.append(values['Name'])
        elif symbol == 'A':
            last[column][2] = int(values['Level'])
            names.append(values['Name'])
        else:
            parent = last[column][3] if relation == '<' else pending
            if relation == '<':
                need(vertex[column] not in successors, f'{code}: a vertex has two successors')
                successors.add(vertex[column])
            need(relation != '<' or int(label[1:]) == index[column] + 1, f'{code}: it follows S{index.get(column)}')
            index[column] = int(label[1:])
            vertex[column] = number
            place = tuple(float(values[c]) for c in ('XX', 'YY', 'ZZ'))
            if parent is None:  # the roots of a plant are one place
                same = [i for i, p in enumerate(nodes.parents) if p is None and nodes.points[i] == place]
                last[column][3] = same[0] if same else nodes.add(place, float(values['Radius']), None, last[column][2])
            else:
                last[column][3] = nodes.add(place, float(values['Radius']), parent, last[column][2])
    yield from nodes.facts()
    yield 'axes', counts['A']
    yield 'plants', counts['P']
    yield 'names', '|'.join(filter(None, names))


def vtp(path):
    """VTK's own reader."""
    try:
        import vtk
    except ImportError:
        return
    reader = vtk.vtkXMLPolyDataReader()
    errors = []
    reader.AddObserver('ErrorEvent', lambda *_: errors.append(1))
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    need(not errors, 'VTK sees an error')
    need(data.GetNumberOfVerts() == 0 and data.GetNumberOfPolys() == 0 and data.GetNumberOfStrips() == 0, 'not only lines')
    radius, same = (data.GetPointData().GetArray(n) for n in ('radius', 'MaximumInscribedSphereRadius'))
    cells = {data.GetCellData().GetArrayName(i): data.GetCellData().GetArray(i) for i in range(data.GetCellData().GetNumberOfArrays())}
    for name in ('branch', 'order', 'strahler', 'plant', 'type'):
        need(name in cells, f'no array {name}')
    parents = [None] * data.GetNumberOfPoints()
    levels = [None] * data.GetNumberOfPoints()
    for c in range(data.GetNumberOfLines()):
        need(int(cells['branch'].GetValue(c)) == c, 'branches are in another order')
        ids = data.GetCell(c).GetPointIds()
        line = [ids.GetId(k) for k in range(ids.GetNumberOfIds())]
        for a, b in zip(line, line[1:]):
            need(parents[b] is None, 'a point has two parents')
            parents[b] = a
            levels[b] = int(cells['level'].GetValue(c)) if 'level' in cells else None
    nodes = Nodes()
    for i in range(data.GetNumberOfPoints()):
        need(radius.GetValue(i) == same.GetValue(i), 'the radii differ')
        nodes.add(data.GetPoint(i), radius.GetValue(i), parents[i], levels[i])
    yield from nodes.facts()
    yield 'branches', data.GetNumberOfLines()
    if 'axis' in cells:
        yield 'axes', len({cells['axis'].GetValue(c) for c in range(data.GetNumberOfLines())})
    yield 'strahler', int(cells['strahler'].GetRange()[1])
    yield 'order', int(cells['order'].GetRange()[1])


def graphml(path):
    """GraphML 1.0: keys declared per domain, a directed tree."""
    space = '{http://graphml.graphdrawing.org/xmlns}'
    root = ET.parse(path).getroot()
    keys = {k.attrib['id']: (k.attrib['for'], k.attrib['attr.name'], k.attrib['attr.type']) for k in root.iterfind(space + 'key')}
    graph = root.find(space + 'graph')
    need(graph.attrib['edgedefault'] == 'directed', 'not directed')

    def data(element, domain):
        values = {}
        for d in element.iterfind(space + 'data'):
            where, name, kind = keys[d.attrib['key']]
            need(where == domain and name not in values, f'the key {name}')
            values[name] = {'double': float, 'long': int, 'string': str}[kind](d.text or '')
        return values

    at, kinds = {}, collections.Counter()
    for n in graph.iterfind(space + 'node'):
        values = data(n, 'node')
        at[n.attrib['id']] = (values['x'], values['y'], values['z']), values['radius'], values['kind']
        kinds[values['kind']] += 1
    nodes, index, strahler = Nodes(), {}, 0
    for e in graph.iterfind(space + 'edge'):
        values = data(e, 'edge')
        course = [tuple(map(float, p.split())) for p in values['course'].split(',')]
        radii = list(map(float, values['radii'].split()))
        source, target = e.attrib['source'], e.attrib['target']
        need(len(course) == len(radii) and course[0] == at[source][0] and course[-1] == at[target][0], 'a course ends elsewhere')
        if source not in index:
            need(at[source][2] in ('root', 'soma'), 'edges do not come after their parents')
            index[source] = nodes.add(*at[source][:2], None)
        need(target not in index, 'a node has two parents')
        last = index[source]
        for i in range(1, len(course)):
            last = nodes.add(course[i], radii[i], last, values.get('level'), radii[i - 1])
        index[target] = last
        need(math.isclose(values['length'], sum(math.dist(a, b) for a, b in zip(course, course[1:])), rel_tol=1e-9), 'the length is another')
        strahler = max(strahler, values['strahler'])
    yield from nodes.facts()
    yield 'kinds', ','.join(f'{k}:{v}' for k, v in sorted(kinds.items()))
    yield 'strahler', strahler


def main():
    sys.setrecursionlimit(10000)
    for path in sys.argv[1:]:
        read = {'.swc': swc, '.rsml': rsml, '.mtg': mtg, '.vtp': vtp, '.graphml': graphml}[os.path.splitext(path)[1]]
        try:
            facts = list(read(path))
        except (Broken, ValueError, KeyError, IndexError, ET.ParseError) as error:
            print(f'{path}: {type(error).__name__}: {error}')
            return 1
        print('file', os.path.basename(path))
        for name, value in facts:
            print(name, repr(value) if isinstance(value, float) else value)
    return 0


if __name__ == '__main__':
    sys.exit(main())
