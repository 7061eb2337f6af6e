# SPDX-License-Identifier: Apache-2.0
"""Every report that a command writes, checked against docs/report.schema.json, which allows no key that it does not
describe; and docs/user/report.md against the page that is made of it.

reports.py PROGRAM [--keep FOLDER] [--only COMMAND]     ends with 77, skipped, without jsonschema (python3-jsonschema)
"""
import argparse
import contextlib
import json
import os
import shlex
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', 'support'))
from program_starter import run_program  # noqa: E402

SCHEMA = os.path.join(HERE, '..', '..', 'docs', 'report.schema.json')
REPORT_PAGE = os.path.join(HERE, '..', '..', 'scripts', 'report-page')
SKIPPED = 77

PREPARE = [
    'sample fin-on-board --fineness 0.5 -o fin.ply', 'sample torus --fineness 0.3 -o torus.off.ply',
    'sample root --branches 6 --resolution 48 -o root.nrrd',
    'sample root --branches 8 --grey --touching 1 --gaps 1 --blur 0.6 --noise 0.05 --resolution 64 -o grey.nrrd',
    'sample hollow-sphere --resolution 16 -o hollow.nrrd', 'core fin.ply --resolution 24 -o core.vtp',
    'burn core.vtp -o burned.vtp', 'run fin.ply --resolution 24 --no-view --no-picture -o fin',
    'run image.png --no-view --no-picture -o image', 'tree root.nrrd --no-view --no-picture -o grown',
    'core fin.ply --resolution 24 -o core.obj', 'core fin.ply --resolution 24 -o core.r',
]

# The command whose report it is, and its line; {} is the report.
CASES = [
    ('run', 'fin.ply --resolution 24 -o {} --json {}.json'),
    ('run', 'fin.ply --resolution 24 --lambda 2% --theta2 inf --topology voxels --fill winding --surface voxels --full '
            '--no-picture --units mm -o {}'),
    ('run', 'open.off --resolution 16 --fill auto --largest-component --no-view -o {}'),
    ('run', 'twins.off --resolution 12 --no-view --no-picture -o {}'),
    ('run', 'root.nrrd --no-view --theta1 0 --theta2 0 -o {}'),
    ('run', 'grey.nrrd --threshold 90,120 --blur 0.5 --median 1 --close 1 --connectivity 26 --interpolate '
            '--spacing 1,1,1.5 --min-component 20 --fill-cavities --min-hole 3 --no-view -o {}'),
    ('run', 'grey.nrrd --threshold auto --smooth 0 --resample 1vox --detail 2vox --omega 0.01 --radius linear --no-view -o {}'),
    ('run', 'hollow.nrrd --invert --label 0 --subdivide 2 --no-view -o {}'),
    ('run', 'image.png -o {}'),
    ('run', 'image.png --threshold 100 --channel luminance --longest --extend --no-view -o {}'),
    ('run', 'plane.nrrd.png --dimension 3 --no-view --no-picture -o {}'),
    ('run', 'polygons.geojson -o {}'),
    ('run', 'polygons.geojson --feature 1 --pixel 0.05 --no-view -o {}'),
    ('run', 'polygons.geojson --feature 0 --resolution 40 --narrower 3abs --fill evenodd --no-view -o {}'),
    ('tree', 'root.nrrd -o {}'),
    ('tree', 'grey.nrrd --threshold thin --kind neuron --soma thickest --no-view -o {}'),
    ('tree', 'grey.nrrd --root 0,0,0 --down +z --axes length --reach 2vox --no-view -o {}'),
    ('tree', 'fin/core.vtp --no-view --no-picture -o {}'),
    ('tree', 'fin/core.vtp --shape fin.ply --no-view --no-picture -o {}'),
    ('tree', 'grown/tree.swc --no-view --no-picture -o {}'),
    ('tree', 'grown/tree.rsml --units mm --no-view --no-picture -o {}'),
    ('voxelize', 'fin.ply --resolution 24 -o {}.nrrd --json {}.json'),
    ('voxelize', 'root.nrrd -o {}.nrrd --json {}.json'),
    ('voxelize', 'image.png -o {}.nrrd --json {}.json'),
    ('core', 'fin.ply --resolution 24 -o {}.vtp --json {}.json'),
    ('core', 'fin.ply --resolution 24 --in-bricks --lambda 2vox -o {}.vtp --json {}.json'),
    ('core', 'image.png --full -o {}.vtp --json {}.json'),
    ('bricks plan', 'fin.ply --resolution 24 --size 16 -o work --json {}.json'),
    ('bricks status', 'work --json > {}.json'),
    ('bricks run', 'work'),
    ('bricks merge', 'work -o {}.vtp --json {}.json'),
    ('bricks status', 'work --json > {}.json'),
    ('burn', 'core.vtp -o {}.vtp --json {}.json'),
    ('burn', 'core.obj --radii core.r -o {}.vtp --json {}.json'),
    ('burn', 'image/core.vtp -o {}.vtp --json {}.json'),
    ('skeleton', 'burned.vtp --theta2 inf --swc {}.swc -o {}.vtp --json {}.json'),
    ('skeleton', 'burned.vtp --theta1 2vox --tips pruned -o {}.vtp --json {}.json'),
    ('skeleton', 'image/core.vtp -o {}.vtp --json {}.json'),
    ('reconstruct', 'core.vtp -o {}.nrrd --json {}.json'),
    ('reconstruct', 'core.vtp --envelope --shape fin.ply -o {}.ply --json {}.json'),
    ('reconstruct', 'image/core.vtp --shape image.png -o {}.nrrd --json {}.json'),
    ('parts', 'fin/skeleton.vtp -o {}.vtp --json {}.json'),
    ('parts', 'fin/core.vtp --remesh 5% -o {}'),
    ('parts', 'fin.ply --resolution 24 -o {}'),
    ('parts', 'core.vtp --whole -o {}.vtp --json {}.json'),
    ('thickness', 'root.nrrd -o {}.nrrd --json {}.json'),
    ('thickness', 'fin.ply --resolution 24 --surface {}.ply --png {}.png --page {}.html --bin 0.01 --correction 0 --json {}.json'),
    ('thickness', 'fin.ply --resolution 24 --csv {}.csv --axis core.vtp --balls vertices --json {}.json'),
    ('thickness', 'image.png --csv {}.csv --json {}.json'),
    ('simplify', 'core.vtp --vertices 60 --shape fin.ply -o {}.ma --json {}.json'),
    ('simplify', 'core.vtp --error 5% -o {}.vtp --json {}.json'),
    ('smooth', 'core.vtp -o {}.vtp --json {}.json'),
    ('view', 'burned.vtp --shape fin.ply -o {}.html --png {}.png --json {}.json'),
    ('view', 'fin/skeleton.vtp -o {}.html --json {}.json'),
    ('verify', 'fin.ply fin/core.vtp fin/skeleton.vtp --json {}.json'),
    ('verify', 'image.png image/core.vtp --json - > {}.json'),
    *(('info', f'{file} --json > {{}}.json') for file in (
        'fin.ply', 'core.vtp', 'fin/skeleton.vtp', 'root.nrrd', 'grey.nrrd', 'image.png', 'polygons.geojson', 'broken.geojson',
        'grown/tree.swc', 'grown/tree.rsml', 'open.off')),
]
MAY_FAIL = {4}  # verify that finds something still reports


def write_inputs(folder):
    def png(name, rows):
        data = b''.join(b'\0' + bytes(row) for row in rows)
        def chunk(kind, body):
            return struct.pack('>I', len(body)) + kind + body + struct.pack('>I', zlib.crc32(kind + body))
        head = struct.pack('>IIBBBBB', len(rows[0]), len(rows), 8, 0, 0, 0, 0)
        with open(os.path.join(folder, name), 'wb') as out:
            out.write(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunk(b'IDAT', zlib.compress(data)) + chunk(b'IEND', b''))
    bar = [[255 if 8 <= x < 40 and 8 <= y < 16 or 20 <= x < 28 and 8 <= y < 40 else 0 for x in range(48)] for y in range(48)]
    png('image.png', bar)
    png('plane.nrrd.png', bar)
    cube = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    def off(name, points, faces):
        with open(os.path.join(folder, name), 'w', encoding='ascii') as out:
            out.write(f'OFF\n{len(points)} {len(faces)} 0\n')
            out.writelines(' '.join(map(str, p)) + '\n' for p in points)
            out.writelines(' '.join(map(str, [len(f), *f])) + '\n' for f in faces)
    off('open.off', corners, cube[:5])
    near = [[x + 1.01, y, z] for x, y, z in corners]  # the gap is thinner than a voxel
    off('twins.off', corners + near, cube + [[i + 8 for i in f] for f in cube])
    def polygon(x, **properties):
        ring = [[x, 0], [x + 4, 0], [x + 4, 1], [x + 2, 1], [x + 2, 3], [x + 1, 3], [x + 1, 1], [x, 1], [x, 0]]
        return {'type': 'Feature', 'properties': properties, 'geometry': {'type': 'Polygon', 'coordinates': [ring]}}
    point = {'type': 'Feature', 'properties': {}, 'geometry': {'type': 'Point', 'coordinates': [0, 0]}}
    for name, features in (('polygons', [polygon(0, name='a'), polygon(10, name='b')]), ('broken', [polygon(0), point])):
        with open(os.path.join(folder, name + '.geojson'), 'w', encoding='utf-8') as out:
            json.dump({'type': 'FeatureCollection', 'features': features}, out)


def run(program, folder, line):
    """Runs a line; what stands behind '>' is the file of stdout."""
    words, _, target = line.partition(' > ')
    done = run_program([program, *shlex.split(words), '--quiet'], folder)
    assert done.returncode == 0 or done.returncode in MAY_FAIL and words.startswith('verify'), (line, done.stderr.decode())
    if target:
        with open(os.path.join(folder, target), 'wb') as out:
            out.write(done.stdout)


def reports_of(program, folder, only=None):
    """Command, line and report of every case."""
    write_inputs(folder)
    for line in PREPARE:
        run(program, folder, line)
    for number, (command, arguments) in enumerate(CASES):
        name = f'case_{number}'
        line = f'{command} {arguments.replace("{}", name)}'
        if only and not command.startswith(only):
            continue
        run(program, folder, line)
        for file in (f'{name}.json', f'{name}/report.json'):
            if os.path.exists(os.path.join(folder, file)):
                with open(os.path.join(folder, file), encoding='utf-8') as report:
                    yield command, line, json.load(report)


def load_schema():
    with open(SCHEMA, encoding='utf-8') as file:
        return json.load(file)


def definition_of(command):
    return 'command_' + command.replace(' ', '_')


def validators(schema, jsonschema):
    """A validator for the reports of each command."""
    checker = jsonschema.Draft202012Validator
    checker.check_schema(schema)
    return {name: checker({**schema, 'anyOf': [{'$ref': f'#/$defs/{name}'}]})
            for name in (reference['$ref'].split('/')[-1] for reference in schema['anyOf'])}


def undescribed(schema):
    """Keys without a description, and objects that allow others."""
    def walk(part, place):
        if 'properties' in part and 'additionalProperties' not in part:
            yield f'{place} allows keys that it does not describe'
        for name, of in part.get('properties', {}).items():
            if not of.get('description'):
                yield f'{place}/{name} has no description'
        for kind in ('properties', '$defs'):
            for name, of in part.get(kind, {}).items():
                yield from walk(of, f'{place}/{name}')
        for kind in ('items', 'additionalProperties'):
            if isinstance(part.get(kind), dict):
                yield from walk(part[kind], f'{place}/{kind}')
        for number, of in enumerate(part.get('anyOf', ())):
            yield from walk(of, f'{place}/{number}')
    return list(walk(schema, ''))


def deepest(errors):
    """What is wrong, where an alternative fails the one that came farthest."""
    for error in errors:
        parts = list(error.context or ())
        yield from deepest([max(parts, key=lambda e: len(e.absolute_path))] if parts else [])
        if not parts:
            yield f'{"/".join(map(str, error.absolute_path))}: {error.message[:300]}'


class AnyReport:
    """For tests that run the program for other reasons: what is wrong with a report of whatever command."""

    def __init__(self):
        try:
            import jsonschema
            self.checks = validators(load_schema(), jsonschema)
        except ImportError:
            self.checks = {}

    def errors(self, data):
        """Of the bytes of a file, which need not be a report."""
        try:
            report = json.loads(data)
        except ValueError:
            return []
        of_run = isinstance(report, dict) and isinstance(report.get('seconds'), dict)
        if not of_run and not (isinstance(report, dict) and {'file', 'kind'} <= {*report}):
            return []
        found = [sorted(set(deepest(check.iter_errors(report)))) for check in self.checks.values()]
        return [] if not all(found) else min(found, key=len)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('program')
    parser.add_argument('--keep', metavar='FOLDER', help='a folder for the reports')
    parser.add_argument('--only', metavar='COMMAND')
    options = parser.parse_args()
    try:
        import jsonschema
    except ImportError:
        print('skipped: no jsonschema (python3-jsonschema)')
        return SKIPPED
    schema = load_schema()
    wrong = undescribed(schema)
    if subprocess.run([sys.executable, '-B', REPORT_PAGE, '--check'], check=False).returncode != 0:
        wrong.append('docs/user/report.md is another page than that of the schema')
    checks = validators(schema, jsonschema)
    used, count = set(), 0
    with contextlib.ExitStack() as stack:
        folder = options.keep or stack.enter_context(tempfile.TemporaryDirectory())
        for command, line, report in reports_of(os.path.abspath(options.program), folder, options.only):
            name = definition_of(command)
            count += 1
            used.add(name)
            found = sorted(set(deepest(checks[name].iter_errors(report))))
            wrong += [f'{line}: {text}' for text in found]
            strange = {**report, 'not_a_key': 1}
            if name != 'command_verify' and checks[name].is_valid(strange):
                wrong.append(f'{name}: a key that is not described passes')
    if not options.only:
        wrong += [f'no case writes the report of {name}' for name in sorted(set(checks) - used)]
    print(''.join(f'FAIL {text}\n' for text in wrong) + f'{count} reports of {len(used)} commands, {len(wrong)} failures')
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
