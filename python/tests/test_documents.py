# SPDX-License-Identifier: Apache-2.0
"""What the documents tell people to write works."""
import glob
import os
import re
import shutil
import subprocess

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


@pytest.mark.parametrize('document', ['README.md', 'docs/user/python.md'])
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
    with open(os.path.join(ROOT, 'docs/user/python.md'), encoding='utf-8') as file:
        blocks = re.findall(r'```python\n(.*?)```', file.read(), re.S)
    image = np.zeros((30, 20, 12), bool)
    image[2:-2, 2:-2, 2:-2] = True
    exec(compile(blocks[1], 'docs/user/python.md', 'exec'), {'quench': quench, 'image': image})


def test_the_cell_of_the_plane(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with open(os.path.join(ROOT, 'docs/user/plane.md'), encoding='utf-8') as file:
        code = re.search(r'```python\n(.*?)```', file.read(), re.S).group(1)
    exec(compile(code, 'docs/user/plane.md', 'exec'), {})
    assert capsys.readouterr().out.count('wide') == 3
    assert (tmp_path / 'cell.png').stat().st_size > 5000


def pages():
    """Every page of the project, by its path from the root, with its text without blocks of code."""
    for pattern in ('*.md', 'docs/**/*.md', 'notes/*.md', 'examples/**/*.md', 'plugins/**/*.md', 'viewer/*.md'):
        for file in glob.glob(os.path.join(ROOT, pattern), recursive=True):
            with open(file, encoding='utf-8') as page:
                yield os.path.relpath(file, ROOT), re.sub(r'(?ms)^```.*?^```', '', page.read())


def anchor(heading):
    text = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', heading).strip().lower()
    return re.sub(r'[^\w\- ]', '', text).replace(' ', '-')


def test_links_lead_somewhere():
    anchors = {path: {anchor(h) for h in re.findall(r'(?m)^#+ (.*)$', text)} for path, text in pages()}
    assert len(anchors) > 30
    broken = []
    for path, text in pages():
        for target in re.findall(r'\]\(([^)\s]+)\)', text):
            if re.match(r'[a-z]+:', target):
                continue
            file, _, place = target.partition('#')
            found = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
            if not os.path.isfile(os.path.join(ROOT, found)) or (place and place not in anchors.get(found, ())):
                broken.append(f'{path}: {target}')
    assert not broken


def test_options_exist():
    """Options that the pages for users name are options of the program or of a script of the project."""
    known = ''
    for pattern in ('cli/*.cpp', 'cli/*.h', 'scripts/*', 'bench/*.py', 'tests/*.py', 'examples/*.py', 'examples/cluster/*'):
        for file in glob.glob(os.path.join(ROOT, pattern)):
            with open(file, encoding='utf-8') as source:
                known += source.read()
    unknown = set()
    for path, _ in pages():
        if not path.startswith(('README', 'docs/user', 'docs/tutorials', 'docs/algorithms', 'docs/glossary', 'docs/gallery', 'examples')):
            continue
        with open(os.path.join(ROOT, path), encoding='utf-8') as page:
            for line in page:
                if not re.search(r'\b(cmake|pkg-config|ctest|pip|venv|SBATCH|sbatch|dask worker|kubectl|aws|docker)\b', line):
                    unknown.update(f'{path}: {option}' for option in re.findall(r'(?<![\w-])--[a-z][a-z0-9-]+', line)
                                   if option not in known)
    assert not unknown


def test_pages_named_in_the_code_are_there():
    """A page of docs/ or notes/ that a comment or the changelog names exists."""
    named = set()
    for pattern in ('src/**/*', 'include/quench/*', 'cli/*', 'python/*/*', 'tests/**/*', 'bench/*', 'fuzz/*', 'examples/*',
                    'viewer/src/**/*', 'CHANGELOG.md', 'CMakeLists.txt', 'Makefile'):
        for file in glob.glob(os.path.join(ROOT, pattern), recursive=True):
            if file.endswith(('.cpp', '.h', '.py', '.pyi', '.ts', '.mjs', '.txt', '.md', 'Makefile')):
                with open(file, encoding='utf-8') as text:
                    named |= {(page, file) for page in re.findall(r'\b(?:docs|notes)/[a-z_/]+\.md\b', text.read())}
    assert len(named) > 20
    assert [found for found in sorted(named) if not os.path.exists(os.path.join(ROOT, found[0]))] == []


def test_cpp_snippets_compile(tmp_path):
    """Blocks without main() are the body of a function that has a mesh, a shape, a medial axis and a length."""
    compiler = shutil.which('c++')
    if not compiler or not shutil.which('pkg-config'):
        pytest.skip('needs a compiler and pkg-config')
    code = '#include <cstdio>\n#include <limits>\n#include "quench/quench.h"\n'
    for document in ('README.md', 'docs/user/cpp.md'):
        with open(os.path.join(ROOT, document), encoding='utf-8') as file:
            for block in re.findall(r'(?ms)^```cpp\n(.*?)^```', file.read()):
                if 'int main()' not in block:
                    block = ('{\n' + block + '}\n')
                    known = [f'const quench::{kind}& {name}' for kind, name in
                             (('TriangleMesh', 'mesh'), ('VoxelShape', 'shape'), ('MedialAxis', 'axis'))
                             if not re.search(rf'\b{name}\b(?: =|\{{)', block)]
                    block = f'void snippet_{len(code)}({", ".join([*known, "double side"])})\n{block}'
                code += block.replace('int main()', f'int main_{len(code)}()')
    (tmp_path / 'snippets.cpp').write_text(code)
    flags = subprocess.run(['pkg-config', '--cflags', 'eigen3'], capture_output=True, text=True, check=True).stdout.split()
    subprocess.run([compiler, '-std=c++20', '-fsyntax-only', '-I', os.path.join(ROOT, 'include'), *flags,
                    str(tmp_path / 'snippets.cpp')], check=True)
