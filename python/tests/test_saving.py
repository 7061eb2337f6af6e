# SPDX-License-Identifier: Apache-2.0
"""A name means the same file in Python and in the program, byte for byte."""
import os
import subprocess

import numpy as np
import pytest
import quench
from shapes import bent_tube, plate_with_tunnel

PROGRAM = os.environ.get('QUENCH_PROGRAM', '')
pytestmark = pytest.mark.skipif(not os.path.exists(PROGRAM), reason='needs the program')


def run(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def same(a, b):
    assert a.read_bytes() == b.read_bytes(), a.name


def core_file(tmp_path, image=None):
    """A core of Python and what both read of it."""
    quench.medial_axis(plate_with_tunnel() if image is None else image).save(tmp_path / 'core.vtp')
    return tmp_path / 'core.vtp', quench.read(tmp_path / 'core.vtp')


def test_axes(tmp_path):
    core, axis = core_file(tmp_path)
    for ending in ('.csv', '.ply', '.obj', '.ma', '.r', '.stl', '.vtu'):
        run('convert', core, '-o', tmp_path / ('program' + ending))
        axis.save(tmp_path / ('python' + ending))
        same(tmp_path / ('program' + ending), tmp_path / ('python' + ending))


def test_skeletons(tmp_path):
    core, axis = core_file(tmp_path)
    beside = {option: tmp_path / ('program-branches.' + option) for option in ('csv', 'swc', 'graphml')}
    options = [word for option, file in beside.items() for word in ('--' + option, file)]
    skeleton = axis.skeleton()
    for n, ending in enumerate(('.csv', '.ply', '.obj')):
        run('skeleton', core, '-o', tmp_path / ('program' + ending), *(options if n == 0 else ()))
        skeleton.save(tmp_path / ('python' + ending))
        same(tmp_path / ('program' + ending), tmp_path / ('python' + ending))
    assert (tmp_path / 'python.csv').read_text().startswith('x,y,z,radius')  # a row per vertex
    assert len((tmp_path / 'python.csv').read_text().splitlines()) == 1 + len(skeleton.vertices)
    graph = skeleton.graph()
    for option, file in beside.items():
        graph.save(tmp_path / ('python-branches.' + option))
        same(file, tmp_path / ('python-branches.' + option))
    skeleton.save(tmp_path / 'again.swc')
    same(beside['swc'], tmp_path / 'again.swc')


def test_images(tmp_path):
    core, axis = core_file(tmp_path, bent_tube().any(axis=2))
    run('skeleton', core, '-o', tmp_path / 'program.csv', '--geojson', tmp_path / 'program.geojson')
    axis.skeleton().save(tmp_path / 'python.csv')
    same(tmp_path / 'program.csv', tmp_path / 'python.csv')


def test_parts(tmp_path):
    core, axis = core_file(tmp_path)
    run('parts', core, '-o', tmp_path / 'program')
    parts = axis.skeleton().parts()
    parts.save(tmp_path / 'parts.csv')
    same(tmp_path / 'program' / 'parts.csv', tmp_path / 'parts.csv')


def test_trees(tmp_path):
    core, axis = core_file(tmp_path, bent_tube())
    run('tree', core, '-o', tmp_path / 'program', '--kind', 'neuron', '--columns', 'quench')
    tree = quench.tree(core, 'neuron')
    for name, ending in (('axes', '.csv'), ('tree', '.swc'), ('tree', '.graphml'), ('tree', '.mtg')):
        tree.save(tmp_path / ('python' + ending))
        same(tmp_path / 'program' / (name + ending), tmp_path / ('python' + ending))
    rows = np.loadtxt(tmp_path / 'python.swc')
    np.testing.assert_array_equal(tree.swc()['radius'], rows[:, 5])
