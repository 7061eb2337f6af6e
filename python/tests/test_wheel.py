# SPDX-License-Identifier: Apache-2.0
"""The wheel: right for this Python, installed into a fresh environment without a network, and of use there."""
import base64
import csv
import hashlib
import importlib.util
import os
import re
import subprocess
import sys
import zipfile

import numpy as np
import pytest
import quench

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
PACKAGE = os.path.dirname(os.path.abspath(quench.__file__))


@pytest.fixture(scope='module')
def backend():
    path = os.path.join(ROOT, 'python', 'backend.py')
    spec = importlib.util.spec_from_file_location('quench_backend', path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope='module')
def wheel(backend, tmp_path_factory):
    folder = tmp_path_factory.mktemp('wheel')
    # The folder of the build, not the sources that its links lead to.
    return folder / backend.pack_wheel(folder, os.environ.get('QUENCH_PACKAGE', PACKAGE))


def test_its_tags_are_those_of_this_python(wheel, backend):
    name, version, *tag = wheel.stem.split('-')
    assert (name, version) == ('quench', quench.__version__) and '-'.join(tag) == backend._tag()
    tags = pytest.importorskip('pip._vendor.packaging.tags')
    assert '-'.join(tag) in {str(known) for known in tags.sys_tags()}


def test_tags_of_other_pythons(backend, monkeypatch):
    import sysconfig
    version = f'{sys.version_info[0]}{sys.version_info[1]}'
    monkeypatch.setattr(sysconfig, 'get_platform', lambda: 'macosx-11.0-arm64')
    for abi, wanted in ((f'cpython-{version}-darwin', f'cp{version}-cp{version}'),
                        (f'cpython-{version}t-darwin', f'cp{version}-cp{version}t'),
                        (f'pypy{version}-pp73-darwin', f'pp{version}-pypy{version}_pp73'),
                        (None, f'cp{version}-cp{version}')):
        monkeypatch.setattr(sysconfig, 'get_config_var', lambda name, abi=abi: abi)
        assert backend._tag() == wanted + '-macosx_11_0_arm64'


def test_its_record_is_right(wheel):
    info = f'quench-{quench.__version__}.dist-info'
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        rows = list(csv.reader(archive.read(f'{info}/RECORD').decode().splitlines()))
        assert [row[0] for row in rows] == names
        for name, digest, size in rows[:-1]:
            data = archive.read(name)
            assert digest == 'sha256=' + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()
            assert int(size) == len(data)
        assert rows[-1] == [f'{info}/RECORD', '', '']
    packed = {name[len('quench/'):] for name in names if name.startswith('quench/')}
    there = {name for name in os.listdir(PACKAGE) if name.endswith(('.py', '.pyi', '.so', 'py.typed'))}
    assert packed == there and len([name for name in packed if name.endswith('.so')]) == 1


def test_a_module_of_another_python_is_not_packed(backend, tmp_path):
    (tmp_path / '_core.cpython-26-x86_64-linux-gnu.so').write_bytes(b'')
    with pytest.raises(RuntimeError, match='another Python'):
        backend.pack_wheel(tmp_path, tmp_path)


def test_a_fresh_environment(wheel, tmp_path):
    for module in ('venv', 'ensurepip'):
        pytest.importorskip(module)
    made = subprocess.run([sys.executable, '-m', 'venv', '--system-site-packages', tmp_path / 'env'], capture_output=True,
                          text=True)
    if made.returncode:
        pytest.skip(f'no environment can be made: {made.stdout[-200:]}')
    python = tmp_path / 'env' / 'bin' / 'python'
    clean = {name: value for name, value in os.environ.items() if name not in ('PYTHONPATH', 'PIP_INDEX_URL')}
    done = subprocess.run([python, '-m', 'pip', 'install', '--no-index', '--no-deps', '--disable-pip-version-check', wheel],
                          capture_output=True, text=True, env=clean)
    assert done.returncode == 0, done.stdout + done.stderr
    work = tmp_path / 'work'
    work.mkdir()
    array = quench.voxelize(quench.sample('root', branches=4), resolution=80).array * np.uint8(90)
    head = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: {} {} {}\nencoding: raw\n\n'.format(*array.shape)
    (work / 'root.nrrd').write_bytes(head.encode() + array.tobytes(order='F'))
    with open(os.path.join(ROOT, 'README.md'), encoding='utf-8') as file:
        snippet = re.search(r'```python\n(import quench\n.*?)```', file.read(), re.S).group(1)
    (work / 'snippet.py').write_text(snippet + '\nprint(quench.__file__, quench.__version__)\n', encoding='utf-8')
    ran = subprocess.run([python, 'snippet.py'], cwd=work, capture_output=True, text=True, env=clean)
    assert ran.returncode == 0, ran.stderr
    assert str(tmp_path / 'env') in ran.stdout and ran.stdout.split()[-1] == quench.__version__
    assert (work / 'branches.csv').read_text().startswith('branch,from,to')
    assert (work / 'root.png').stat().st_size > 5000
