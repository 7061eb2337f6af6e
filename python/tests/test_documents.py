# SPDX-License-Identifier: Apache-2.0
"""What the documents tell people to write works."""
import os
import re

import numpy as np
import pytest
import quench

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')


@pytest.fixture
def root_file(tmp_path, monkeypatch):
    """root.nrrd in an empty folder: grey values, a root at 90."""
    monkeypatch.chdir(tmp_path)
    array = quench.voxelize(quench.sample('root', branches=6), resolution=120).array * np.uint8(90)
    head = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: {} {} {}\nencoding: raw\n\n'.format(*array.shape)
    (tmp_path / 'root.nrrd').write_bytes(head.encode() + array.tobytes(order='F'))
    try:
        quench.read('root.nrrd')
    except quench.Error as error:
        pytest.skip(f'this build reads no NRRD: {error}')
    return tmp_path


@pytest.mark.parametrize('document', ['README.md', 'docs/python.md'])
def test_the_five_lines(document, root_file):
    pytest.importorskip('matplotlib')
    with open(os.path.join(ROOT, document), encoding='utf-8') as file:
        code = re.search(r'```python\n(import quench\n.*?)```', file.read(), re.S).group(1)
    assert len(code.splitlines()) == 5
    exec(compile(code, document, 'exec'), {})
    assert (root_file / 'branches.csv').read_text().startswith('branch,from,to')
    assert (root_file / 'root.png').stat().st_size > 5000


def test_the_tour_of_results():
    pytest.importorskip('networkx')
    with open(os.path.join(ROOT, 'docs/python.md'), encoding='utf-8') as file:
        blocks = re.findall(r'```python\n(.*?)```', file.read(), re.S)
    image = np.zeros((30, 20, 12), bool)
    image[2:-2, 2:-2, 2:-2] = True
    exec(compile(blocks[1], 'docs/python.md', 'exec'), {'quench': quench, 'image': image})
