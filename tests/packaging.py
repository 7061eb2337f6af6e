#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks packaging/: `packaging.py [ROOT]`. All files name one version, that of CMakeLists.txt; every recipe has the
dependencies of scripts/install-deps by the names in packaging/dependencies.json, no fewer and no more; and the recipes
are well-formed as far as what is installed can tell (Ruby, Nix, PyYAML: left out where they are not)."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ECOSYSTEMS = ('conda-forge', 'vcpkg', 'homebrew', 'nix')


def found(pattern, text):
    match = re.search(pattern, text, re.M)
    return match.group(1) if match else None


def wrong_versions(root):
    version = found(r'^project\(quench VERSION ([0-9.]+)', (root / 'CMakeLists.txt').read_text())
    header = (root / 'include/quench/quench.h').read_text()
    versions = {'include/quench/quench.h': '.'.join(
        found(rf'^#define QUENCH_VERSION_{part} (\d+)', header) or '?' for part in ('MAJOR', 'MINOR', 'PATCH'))}
    for name, pattern in {
            'CITATION.cff': r'^version: (\S+)$',
            'Dockerfile': r'image\.version="([^"]*)"',
            'packaging/debian/changelog': r'\Aquench \(([0-9.]+)-\d+\) ',
            'packaging/conda-forge/recipe.yaml': r'^  version: "([^"]*)"$',
            'packaging/vcpkg/vcpkg.json': r'"version-semver": "([^"]*)"',
            'packaging/homebrew/quench.rb': r'^  version "([^"]*)"$',
            'packaging/nix/package.nix': r'^  version = "([^"]*)";$'}.items():
        versions[name] = found(pattern, (root / name).read_text())
    versions['packaging/homebrew/quench.rb (url)'] = found(r'^  url "[^"]*/quench-([0-9.]+)\.tar\.gz"',
                                                           (root / 'packaging/homebrew/quench.rb').read_text())
    # What has been released is a heading; before, all is "Unreleased".
    released = found(r'^## \[?([0-9][0-9.]*)', (root / 'CHANGELOG.md').read_text())
    if released:
        versions['CHANGELOG.md'] = released
    for name, other in versions.items():
        if other != version:
            yield f'{name}: version {other}, but CMakeLists.txt has {version}'
    # The wheel asks CMakeLists.txt; a version in pyproject.toml would be another one.
    if re.search(r'^version\s*=', (root / 'pyproject.toml').read_text(), re.M):
        yield 'pyproject.toml: names a version; python/backend.py takes that of CMakeLists.txt'
    sys.path.insert(0, str(root / 'python'))
    import backend
    if backend._version() != version:
        yield f'python/backend.py: makes wheels of version {backend._version()}, but CMakeLists.txt has {version}'


def names_of_recipes(root):
    """The dependencies each recipe has."""
    recipe = (root / 'packaging/conda-forge/recipe.yaml').read_text()
    part = recipe[recipe.index('\nrequirements:'):recipe.index('\ntests:')]
    conda = {re.sub(r' [<>=].*', '', name) for name in re.findall(r'^    - (.*)$', part, re.M)}
    manifest = json.loads((root / 'packaging/vcpkg/vcpkg.json').read_text())
    listed = [*manifest['dependencies'], *(d for f in manifest['features'].values() for d in f['dependencies'])]
    formula = (root / 'packaging/homebrew/quench.rb').read_text()
    derivation = (root / 'packaging/nix/package.nix').read_text()
    arguments = derivation[derivation.index('{') + 1:derivation.index('}:')]
    return {'conda-forge': conda - {"${{ stdlib('c') }}"},
            # Without the functions of portfile.cmake, which are ports, too.
            'vcpkg': {d if isinstance(d, str) else d['name'] for d in listed} - {'vcpkg-cmake', 'vcpkg-cmake-config'},
            'homebrew': set(re.findall(r'^  depends_on "([^"]*)"', formula, re.M)),
            'nix': ({name.strip() for name in arguments.split(',')} - {'', 'lib', 'stdenv'}
                    | set(re.findall(r'\bp\.(\w+)', derivation)))}


def wrong_dependencies(root):
    with tempfile.TemporaryDirectory() as empty:  # a machine with neither Node.js nor a browser, so that all are listed
        os.symlink(shutil.which('bash'), os.path.join(empty, 'bash'))
        for tool in ('grep', 'id', 'apt-get', 'dpkg-query'):
            path = shutil.which(tool) or shutil.which('true')
            os.symlink(path, os.path.join(empty, tool))
        run = subprocess.run(['bash', str(root / 'scripts/install-deps'), '--build', '--dry-run'], env={'PATH': empty},
                             capture_output=True, text=True, executable=shutil.which('bash'))
    if run.returncode:
        yield f'scripts/install-deps: {run.stderr.strip()}'
        return
    debian = set(run.stdout.split())
    table = json.loads((root / 'packaging/dependencies.json').read_text())
    table.pop('//')
    for name in sorted(debian - set(table)):
        yield f'packaging/dependencies.json: {name} of scripts/install-deps is missing'
    for name in sorted(set(table) - debian):
        yield f'packaging/dependencies.json: {name} is not in scripts/install-deps'
    names = names_of_recipes(root)
    for ecosystem in ECOSYSTEMS:
        expected = {row[ecosystem] for row in table.values()} - {None}
        for name in sorted(expected - names[ecosystem]):
            yield f'packaging/{ecosystem}: {name} is missing, by packaging/dependencies.json'
        for name in sorted(names[ecosystem] - expected):
            yield f'packaging/{ecosystem}: {name} is not in packaging/dependencies.json'
    # The development files that who links the library needs: those of the optional formats, and what it always has.
    packages = (root / 'cmake/QuenchPackages.cmake').read_text()
    linked = {name for name in debian if re.fullmatch(r'(lib.*|zlib1g)-dev', name)} - {'libcli11-dev'}
    same = {'libjpeg62-turbo-dev': 'libjpeg-dev'}
    for name in sorted(linked):
        if not re.search(rf'[ ":]{re.escape(same.get(name, name))}[ ",)\n]', packages):
            yield f'cmake/QuenchPackages.cmake: libquench-dev does not depend on {name}'


def ill_formed(root):
    checks = [(['ruby', '-c', 'packaging/homebrew/quench.rb'], 'ruby')]
    checks += [(['nix-instantiate', '--parse', str(file)], 'nix-instantiate') for file in sorted((root / 'packaging/nix').glob('*.nix'))]
    checks += [(['bash', '-n', name], 'bash') for name in
               ('packaging/conda-forge/build.sh', 'scripts/make-packages', 'scripts/make-tarball', 'scripts/test-packages')]
    for command, tool in checks:
        if shutil.which(tool):
            run = subprocess.run(command, cwd=root, capture_output=True, text=True)
            if run.returncode:
                yield f'{command[-1]}: {run.stderr.strip()}'
    try:
        import yaml
    except ImportError:
        return
    recipe = yaml.safe_load((root / 'packaging/conda-forge/recipe.yaml').read_text())
    for key in ('schema_version', 'package', 'source', 'build', 'requirements', 'tests', 'about'):
        if key not in recipe:
            yield f'packaging/conda-forge/recipe.yaml: {key} is missing'
    if not set(recipe['requirements']) <= {'build', 'host', 'run'}:
        yield 'packaging/conda-forge/recipe.yaml: requirements are build, host and run'
    citation = yaml.safe_load((root / 'CITATION.cff').read_text())
    for key in ('cff-version', 'message', 'title', 'authors'):
        if key not in citation:
            yield f'CITATION.cff: {key} is missing'


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent).resolve()
    wrong = [*wrong_versions(root), *wrong_dependencies(root), *ill_formed(root)]
    print('\n'.join(wrong) or 'one version, the same dependencies everywhere')
    return bool(wrong)


if __name__ == '__main__':
    sys.exit(main())
