#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Centre lines of waters: length and mean width of a river and of lakes, by the program `quench` from GeoJSON to GeoJSON.

usage: river.py [-o FOLDER]

Draws a map of its own in metres (waters.geojson): a river that runs through a lake, a lake with a bay, and a ring of water
around an island. Writes the folders `lines` (one line through each, drawn out to the bank) and `mapped` (what is narrower
than 120 m as lines, the rest as polygons). The program is that of the variable QUENCH_PROGRAM, else `quench` of the PATH."""
import argparse
import json
import math
import os
import pathlib
import subprocess

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)


def river():
    """Both banks of a course that winds, 30 to 60 m wide, and 360 m where it runs through a lake."""
    course = [(x, 700 + 120 * math.sin(x / 260) + 60 * math.sin(x / 110)) for x in range(0, 3001, 20)]
    left, right = [], []
    for (x0, y0), (x, y), (x1, y1) in zip(course, course[1:], course[2:]):
        half = 15 + x / 200 + 165 * math.exp(-(((x - 1800) / 170) ** 4))
        length = math.hypot(x1 - x0, y1 - y0)
        across = (y0 - y1) / length * half, (x1 - x0) / length * half
        left.append((x + across[0], y + across[1]))
        right.append((x - across[0], y - across[1]))
    return [left + right[::-1]]


def around(x, y, radius, wave=0.0, waves=3):
    """A ring of points around (x, y), whose distance rises and falls `waves` times."""
    turns = [2 * math.pi * i / 120 for i in range(120)]
    distance = [radius * (1 + wave * math.cos(waves * turn)) for turn in turns]
    return [(x + d * math.cos(turn), y + d * math.sin(turn)) for d, turn in zip(distance, turns)]


def feature(rings, **properties):
    closed = [[[round(x, 2), round(y, 2)] for x, y in [*ring, ring[0]]] for ring in rings]
    return {'type': 'Feature', 'properties': properties, 'geometry': {'type': 'Polygon', 'coordinates': closed}}


waters = [
    feature(river(), name='Ash', water='river'),
    feature([around(700, 1250, 200, wave=0.35)], name='Clover Lake', water='lake'),
    feature([around(2300, 1280, 240), around(2330, 1280, 130)], name='Ring Lake', water='lake'),
]
file = options.output / 'waters.geojson'
file.write_text(json.dumps({'type': 'FeatureCollection', 'features': waters}), encoding='utf-8')


def run(folder, *arguments):
    """The lines and polygons that the program makes of the map, as features of GeoJSON."""
    program = os.environ.get('QUENCH_PROGRAM', 'quench')
    out = options.output / folder
    subprocess.run([program, 'run', file, '-o', out, '--overwrite', '--quiet', *arguments], check=True)
    return json.loads((out / 'skeleton.geojson').read_text(encoding='utf-8'))['features']


lengths, areas = {}, {}
for line in run('lines', '--pixel', '4', '--longest', '--extend'):
    properties = line['properties']
    lengths[properties['name']] = lengths.get(properties['name'], 0) + properties['length']
    areas[properties['name']] = areas.get(properties['name'], 0) + 2 * properties['mean_radius'] * properties['length']
print('name          water  centre line  mean width')
for water in waters:
    name = water['properties']['name']
    print(f'{name:13} {water["properties"]["water"]:6} {lengths[name]:9.0f} m {areas[name] / lengths[name]:9.0f} m')

kinds = [part['geometry']['type'] for part in run('mapped', '--pixel', '4', '--longest', '--narrower', '120abs')]
print('narrower than 120 m:', ', '.join(f'{kinds.count(kind)} {kind}' for kind in sorted(set(kinds))))
