#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How far simplified axes are from the surface, for every number of vertices.

usage: simplification.py MESH... [--quench PROGRAM] [--resolution 256] [--work DIR]

`quench core` with default parameters, then `quench simplify --levels`. Prints rows of a Markdown table: mean / 99 % /
largest distance of the surface from that of the envelope, in thousandths of the longest side; vertices and triangles of
the core, seconds of `simplify` alone, and whether the Betti numbers are those of the core (the program refuses others)."""
import argparse
import csv
import json
import subprocess
import tempfile
from pathlib import Path

WANTED = (1000, 500, 250, 125, 62)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('mesh', nargs='+', type=Path)
    parser.add_argument('--quench', default='build/release/quench')
    parser.add_argument('--resolution', default='256')
    parser.add_argument('--work', type=Path)
    options = parser.parse_args()
    work = options.work or Path(tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    print('| shape | vertices of the core |' + ''.join(f' {n} |' for n in WANTED) + ' fewest |')
    print('|---' * (len(WANTED) + 3) + '|')
    for mesh in options.mesh:
        core, table, report = (work / f'{mesh.stem}.{end}' for end in ('vtp', 'csv', 'json'))
        subprocess.run([options.quench, 'core', mesh, '--resolution', options.resolution, '-o', core, '--quiet',
                        '--overwrite'], check=True)
        subprocess.run([options.quench, 'simplify', core, '--shape', mesh, '--vertices', '250', '--levels', table,
                        '-o', work / f'{mesh.stem}.ma', '--json', report, '--quiet', '--overwrite'], check=True)
        said = json.loads(report.read_text())
        scale = 1000 / said['errors']['longest_side']
        with table.open() as file:
            rows = {int(row['vertices']): row for row in csv.DictReader(file)}
        cells = [' / '.join(f'{scale * float(rows[n][key]):.3g}' for key in ('mean', 'p99', 'largest')) if n in rows else '-'
                 for n in WANTED]
        print(f"| {mesh.stem} | {said['input']['vertices']:,} | {' | '.join(cells)} | "
              f"{said['simplified']['fewest_vertices']} |", flush=True)


if __name__ == '__main__':
    main()
