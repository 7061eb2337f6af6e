# SPDX-License-Identifier: Apache-2.0
"""MeshLab reads the PLY files of the program: all vertices, colours and the measure as quality; the filter script selects."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.environ.get('QUENCH') or shutil.which('quench')

SCRIPT = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Per Vertex Quality Stat"/>
</FilterScript>
"""


def server(folder, source, target, script):
    """What meshlabserver says, and the vertices it writes: x, y, z, red, green, blue, alpha, quality."""
    done = subprocess.run(
        ['meshlabserver', '-i', source, '-o', target, '-m', 'vc', 'vq', '-s', script],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0 and f'saved as {os.path.join(folder, target)}' in said, said
    return said, *vertices(f'{folder}/{target}')


def vertices(file):
    """Places, colours and quality of the vertices of a binary PLY, and the number of its faces."""
    kinds = {'float': '<f4', 'double': '<f8', 'uchar': 'u1', 'int': '<i4', 'short': '<i2'}
    with open(file, 'rb') as opened:
        head = opened.readline()
        while not head.endswith(b'end_header\n'):
            head += opened.readline()
        text = head.decode()
        count = int(re.search(r'element vertex (\d+)', text)[1])
        faces = int(re.search(r'element face (\d+)', text)[1])
        names = re.findall(r'property (\w+) (\w+)', text.split('element face')[0])
        table = np.fromfile(opened, np.dtype([(name, kinds[kind]) for kind, name in names]), count)
    return table, faces


def main():
    if not shutil.which('meshlabserver'):
        print('there is no MeshLab with meshlabserver (Debian 12: meshlab 2020.09)')
        sys.exit(77)
    if not os.environ.get('DISPLAY'):
        print('there is no display for MeshLab; run it under xvfb-run')
        sys.exit(77)
    folder = tempfile.mkdtemp(prefix='quench-meshlab-')
    try:
        run = lambda *words: subprocess.run(
            [PROGRAM, *words, '--quiet'], check=True, cwd=folder, stdout=subprocess.DEVNULL
        )
        run('sample', 'fin-on-board', '--fineness', '0.2', '-o', 'part.ply')
        run('thickness', 'part.ply', '--resolution', '96', '--surface', 'walls.ply')
        run('run', 'part.ply', '--resolution', '64', '--no-view', '--no-picture', '-o', 'part')
        run('convert', 'part/core.vtp', 'core.ply', '--quality', 'erosion_thickness')
        run('convert', 'part/skeleton.vtp', 'skeleton.ply', '--quality', 'radius')
        with open(f'{folder}/quality.mlx', 'w', encoding='utf-8') as file:
            file.write(SCRIPT)
        for name in ('walls', 'core', 'skeleton'):
            ours, faces = vertices(f'{folder}/{name}.ply')
            said, theirs, triangles = server(folder, f'{name}.ply', f'{name}_seen.ply', 'quality.mlx')
            assert len(theirs) == len(ours) and triangles >= faces, f'{name}: {len(theirs)} of {len(ours)} vertices'
            assert np.array_equal(theirs['quality'], ours['quality'].astype(np.float32)), f'{name}: another quality'
            assert all(np.array_equal(theirs[c], ours[c]) for c in ('red', 'green', 'blue')), f'{name}: other colours'
            low, high = map(float, re.search(r'Min (\S+) Max (\S+)', said).groups())
            assert abs(low - ours['quality'].min()) < 1e-5 and abs(high - ours['quality'].max()) < 1e-5
            print(f'{name}: {len(ours)} vertices, quality from {low:.3f} to {high:.3f}, colours')
        with open(f'{HERE}/select_thin.mlx', encoding='utf-8') as file:
            script = file.read().replace(
                '</FilterScript>', ' <filter name="Delete Selected Faces and Vertices"/>\n</FilterScript>'
            )
        with open(f'{folder}/select.mlx', 'w', encoding='utf-8') as file:
            file.write(script)
        _, left, _ = server(folder, 'walls.ply', 'thick.ply', 'select.mlx')
        ours, _ = vertices(f'{folder}/walls.ply')
        gone = len(ours) - len(left)
        assert gone == (ours['quality'] <= np.float32(0.1)).sum() > 20, f'{gone} vertices selected'
        print(f'select_thin.mlx: {gone} vertices of at most 0.1')
    finally:
        shutil.rmtree(folder)


if __name__ == '__main__':
    main()
