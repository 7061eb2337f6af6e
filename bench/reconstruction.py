#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What is left of a shape in the solids of its axes: errors both ways, topology, time.

usage: reconstruction.py MESH... [--quench PROGRAM] [--resolution 256] [--work DIR] [--axis FILE]

A row per mesh and axis: the default core, its balls alone and with cones and slabs; the core at detail 2 % (few vertices) and
with --axis another axis of the (one) mesh, such as a .ma file. Distances in thousandths of the longest side: mean / 99 % /
largest of the surface outside the solid, and of the solid outside the surface. Volumes in per cent of the shape."""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path


def figures(of, side):
    return ' / '.join(f'{1000 * of["outside"][name] / side:.3g}' for name in ('mean', 'p99', 'largest'))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('mesh', nargs='+')
    parser.add_argument('--quench', default='quench')
    parser.add_argument('--resolution', default='256')
    parser.add_argument('--axis')
    parser.add_argument('--work')
    options = parser.parse_args()
    work = Path(options.work or tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    print('| shape | axis | vertices | solid | surface outside solid | solid outside surface | missing, added % | '
          'b0/b1/b2 | seconds |\n|---|---|---|---|---|---|---|---|---|')
    for mesh in options.mesh:
        axes = []
        if options.axis:
            axes.append((Path(options.axis).name, options.axis))
        else:
            for name, core in (('default', []), ('detail 2 %', ['--detail', '2%'])):
                file = work / f'{Path(mesh).stem}_{name.split()[0]}.vtp'
                subprocess.run([options.quench, 'core', mesh, '--resolution', options.resolution, *core, '-o', file, '--quiet',
                                '--overwrite'], check=True)
                axes.append((name, file))
        for name, axis in axes:
            for solid in ('balls', 'envelope'):
                report = work / 'report.json'
                subprocess.run([options.quench, 'reconstruct', axis, '--shape', mesh, '-o', work / 'solid.ply', '--overwrite',
                                '--quiet', '--json', report, *(['--resolution', options.resolution] if options.axis else []),
                                *(['--envelope'] if solid == 'envelope' else [])], check=True)
                r = json.loads(report.read_text())
                e, side = r['errors'], r['errors']['longest_side']
                volume = e['volume']
                share = [100 * volume[part] / volume['shape'] for part in ('missing', 'added')]
                betti = '/'.join(map(str, r['solid']['betti']))
                right = '' if r['solid']['betti'] == e['shape_betti'] else ' (not the shape\'s)'
                print(f'| {Path(mesh).stem} | {name} | {r["input"]["vertices"]} | {solid} | '
                      f'{figures(e["surface_from_solid"], side)} | {figures(e["solid_from_surface"], side)} | '
                      f'{share[0]:.2f}, {share[1]:.2f} | {betti}{right} | {r["seconds"]["total"]:.1f} |', flush=True)


if __name__ == '__main__':
    main()
