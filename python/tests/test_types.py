# SPDX-License-Identifier: Apache-2.0
"""The package and a script that uses it pass mypy --strict."""
import importlib.util
import os
import shutil
import subprocess
import sys

import pytest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')

USER = '''
from typing import Dict, Optional

import numpy as np
import numpy.typing as npt

import quench
from quench import Error, MedialAxis, Skeleton, UsageError, Volume

image: npt.NDArray[np.bool_] = np.zeros((20, 14, 9), dtype=np.bool_)
volume = Volume(image, spacing=(0.5, 0.5, 2), origin=(1, 2, 3), units='mm')
axis: MedialAxis = quench.medial_axis(volume, threshold=None, detail='2vox')
skeleton: Skeleton = axis.skeleton(theta2='inf', theta1=0.02)
detail: Optional[float] = axis.detail
components, tunnels, cavities = axis.topology.betti
lengths = skeleton.branches()['length']
total: float = float(lengths.sum())
labels: Dict[int, Skeleton] = quench.skeletonize(image, labels=[1])
page: str = skeleton.view(height=400).html
tree = quench.tree(volume, 'neuron', root=(1, 2, 3))
for branch in tree.branches:
    print(branch.points[0], branch.strahler + 1)
found = quench.read('core.vtp')
if isinstance(found, MedialAxis):
    print(found.vertices[0], found.measures['detail'].values)
try:
    axis.pruned(detail='3vox').save('a.vtp')
except UsageError as error:
    print(error.argument, error.code)
except (Error, FileNotFoundError):
    pass
'''

WRONG = '''
import quench

axis = quench.medial_axis([[1]], theta='x')
axis.skeleton(theta2=[1])
number: str = axis.longest_side
quench.sample(3)
axis.vertices.nothing
'''


def mypy(folder, *arguments):
    command = [sys.executable, '-m', 'mypy'] if importlib.util.find_spec('mypy') else [shutil.which('mypy')]
    if command[0] is None:
        pytest.skip('mypy is not installed')
    environment = {**os.environ, 'MYPYPATH': os.path.join(ROOT, 'python')}
    return subprocess.run([*command, '--strict', '--python-executable', sys.executable, '--cache-dir',
                           str(folder / 'cache'), '--no-error-summary', '--config-file', os.devnull, *arguments], cwd=folder,
                          capture_output=True, text=True, env=environment)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp('types')


def test_the_package(folder):
    done = mypy(folder, '-p', 'quench')
    assert (done.returncode, done.stdout) == (0, ''), done.stdout + done.stderr


def test_a_script(folder):
    (folder / 'user.py').write_text(USER)
    done = mypy(folder, 'user.py')
    assert (done.returncode, done.stdout) == (0, ''), done.stdout + done.stderr


def test_mistakes_are_found(folder):
    (folder / 'wrong.py').write_text(WRONG)
    done = mypy(folder, 'wrong.py')
    assert done.returncode == 1
    lines = {int(line.split(':')[1]) for line in done.stdout.splitlines() if 'error' in line}
    assert {4, 5, 6, 7} <= lines, done.stdout
