#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the structure of the code: `include_direction.py [ROOT]`.

Every include points down the floors of docs/architecture.md, the namespace of a file is that of its folder, no two
files of src/ have the same name in different rooms, headers of the system are included in src/base/platform/ only, and
no modules of the Python package import each other in a circle.
"""
import ast
import pathlib
import re
import sys

# What each room of src/ may include, beside itself. A public header belongs to the room that implements it.
ROOMS = {
    'base': '',
    'complex': 'base',
    'record': 'base',
    'shape': 'base complex',
    'polygons': 'base shape complex',
    'voxelization': 'base complex shape',
    'samples': 'base',
    'delaunay': 'base shape',
    'dual': 'base complex shape delaunay',
    'surface': 'base shape',
    'geodesic': 'base shape',
    'axis': 'base complex record shape surface delaunay dual geodesic',
    'thickness': 'base complex shape surface axis',
    'envelope': 'base complex shape surface axis',
    'simplification': 'base complex shape surface axis envelope',
    'burning': 'base complex record axis',
    'skeleton': 'base complex record axis burning',
    'parts': 'base complex record surface axis skeleton',
    'graph': 'base shape polygons skeleton',
    'preparation': 'base shape',
    'tree': 'base shape skeleton graph',
    'io': 'base record shape polygons graph tree',
    'page': 'base complex record shape axis thickness simplification burning skeleton parts graph tree io',
    'picture': 'base record io page',
    'pipeline': 'base complex record shape polygons preparation voxelization surface dual axis thickness envelope simplification burning skeleton parts graph tree io page',
    'verification': 'base complex record shape',
}
PUBLIC = {'error': 'base', 'context': 'base', 'geometry': 'base', 'voxelize': 'voxelization', 'burn': 'burning', 'verify': 'verification', 'structure': 'complex', 'measures': 'record', 'table': 'base', 'bricks': 'pipeline', 'lengths': 'pipeline', 'solid_stages': 'pipeline', 'simplify': 'simplification'}
FRONT_ENDS = {'cli': 'cli', 'mpi': 'mpi', 'python/src': 'python'}  # public headers, base/ and their own files

# Of Unix, and not of C++; beside them, the parts of the program that start and end processes. What is a hint to Linux
# alone, between "#if defined(__linux__)" and "#endif", may be anywhere.
SYSTEM = re.compile(r'^#include <((?:sys|netinet|arpa|linux)/\S+|unistd\.h|fcntl\.h|dirent\.h|pthread\.h|poll\.h|signal\.h|'
                    r'spawn\.h|dlfcn\.h|termios\.h|malloc\.h|windows\.h)>', re.M)
PLATFORM = 'src/base/platform/'
PROCESSES = ('cli/batch_children.h', 'cli/batch_children.cpp', 'cli/interrupts.cpp')


def includes(file):
    return re.findall(r'^#include "([^"]+)"', file.read_text(), re.M)


def room_of(include):
    """The room of an included file: of a public header the one that implements it."""
    folder, name = include.split('/', 1) if '/' in include else ('', include)
    return PUBLIC.get(name[:-2], name[:-2]) if folder == 'quench' else folder


def forwards(header):
    return 'deprecated: ' in header.read_text()


def wrong_includes(root):
    public = root / 'include/quench'
    for file in sorted([*public.glob('*.h'), *root.glob('src/**/*.h'), *root.glob('src/**/*.cpp')]):
        own = PUBLIC.get(file.stem, file.stem) if file.parent == public else file.relative_to(root / 'src').parts[0]
        if file.parent == public and (own == 'quench' or forwards(file)):
            continue
        if own not in ROOMS:
            yield f'{file.relative_to(root)}: its room is not known to {__file__}'
            continue
        for include in includes(file):
            room = room_of(include)
            if include.startswith('quench/') and (room == 'quench' or forwards(root / 'include' / include)):
                yield f'{file.relative_to(root)}: {include} is for users of the library; include what it stands for'
            elif '/' not in include:
                yield f'{file.relative_to(root)}: write "{include}" with its folder'
            elif file.parent == public and not include.startswith('quench/'):
                yield f'{file.relative_to(root)}: {include} is not public'
            elif room != own and room not in ROOMS[own].split():
                yield f'{file.relative_to(root)}: {include} is not below src/{own}'
    for folder in FRONT_ENDS:
        for file in sorted([*root.glob(f'{folder}/*.h'), *root.glob(f'{folder}/*.cpp')]):
            for include in includes(file):
                if '/' in include and not include.startswith(('quench/', 'base/')):
                    yield f'{file.relative_to(root)}: {include} is not public'


def wrong_names(root):
    """Namespaces that are not those of the folder, and names of files that two rooms have."""
    places = {}
    for file in sorted([*root.glob('src/**/*.h'), *root.glob('src/**/*.cpp')]):
        parts = file.relative_to(root / 'src').parts[:-1]
        allowed = {'quench', *('quench::' + '::'.join(parts[:i + 1]) for i in range(len(parts)))}
        for name in re.findall(r'^namespace ([\w:]+) \{', file.read_text(), re.M):
            if name not in allowed:
                yield f'{file.relative_to(root)}: the namespace {name} is not that of its folder'
        if places.setdefault(file.name, parts) != parts:
            yield f'{file.relative_to(root)}: src/{"/".join(places[file.name])} has a file of that name too'


def wrong_systems(root):
    """Headers of the system elsewhere than in src/base/platform/."""
    for folder in ('include', 'src', 'cli', 'mpi', 'python/src'):
        for file in sorted([*root.glob(f'{folder}/**/*.h'), *root.glob(f'{folder}/**/*.cpp')]):
            name = str(file.relative_to(root))
            if name.startswith(PLATFORM) or name in PROCESSES:
                continue
            text = re.sub(r'^#if defined\(__(?:linux|GLIBC)__\)$.*?^#endif', '', file.read_text(), flags=re.M | re.S)
            for header in SYSTEM.findall(text):
                yield f'{name}: <{header}> is of Unix; put what needs it into {PLATFORM}'


def circles(package):
    """Modules of the package that import each other, functions included; what only annotations need is left out."""
    imports = {}
    for file in sorted(package.glob('*.py')):
        found = set()
        tree = ast.parse(file.read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == 'TYPE_CHECKING':
                node.body.clear()
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                found |= {node.module} if node.module else {alias.name for alias in node.names}
        imports[file.stem] = {name for name in found if (package / f'{name}.py').exists()}
    done = set()

    def visit(name, path):
        if name in path:
            yield 'python: a circle of imports: ' + ' -> '.join([*path[path.index(name):], name])
        elif name not in done:
            for other in sorted(imports[name]):
                yield from visit(other, [*path, name])
            done.add(name)
    for name in imports:
        yield from visit(name, [])


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    wrong = [*wrong_includes(root), *wrong_names(root), *wrong_systems(root), *circles(root / 'python/quench')]
    print('\n'.join(wrong) or 'every include points down')
    return bool(wrong)


if __name__ == '__main__':
    sys.exit(main())
