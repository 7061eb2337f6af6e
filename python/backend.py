# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel of the Python module with CMake (the hooks of PEP 517, nothing to download).

Environment: QUENCH_CMAKE_ARGS, more arguments for CMake; CMAKE_BUILD_PARALLEL_LEVEL, how many compilers at a time. What was
compiled stays in build/wheel-..., so that a second time takes seconds.
"""
import base64
import glob
import hashlib
import os
import re
import shlex
import subprocess
import sys
import sysconfig
import tarfile
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def _version():
    with open(os.path.join(ROOT, 'CMakeLists.txt'), encoding='utf-8') as file:
        return re.search(r'project\(quench VERSION ([0-9.]+)', file.read()).group(1)


def _tag():
    """For this Python only: pybind11 knows no stable ABI (docs/user/python.md)."""
    platform = re.sub(r'[^A-Za-z0-9]', '_', sysconfig.get_platform())
    version = f'{sys.version_info[0]}{sys.version_info[1]}'
    abi = sysconfig.get_config_var('SOABI') or f'cpython-{version}'  # cpython-313t-x86_64-linux-gnu, pypy310-pp73-...
    kind, detail = abi.split('-')[:2]
    if kind == 'cpython':
        return f'cp{version}-cp{detail}-{platform}'
    return f'{"pp" if kind.startswith("pypy") else sys.implementation.name}{version}-{kind}_{detail}-{platform}'


def _metadata():
    with open(os.path.join(ROOT, 'README.md'), encoding='utf-8') as file:
        readme = file.read()
    head = ['Metadata-Version: 2.1', 'Name: quench', f'Version: {_version()}',
            'Summary: Medial axes and skeletons of real 3D shapes', 'License: Apache-2.0', 'Requires-Python: >=3.9',
            'Requires-Dist: numpy (>=1.20)', 'Description-Content-Type: text/markdown']
    return '\n'.join(head) + '\n\n' + readme


def _wheel_text():
    return f'Wheel-Version: 1.0\nGenerator: quench\nRoot-Is-Purelib: false\nTag: {_tag()}\n'


def _compile():
    """The folder with the compiled module."""
    build = os.path.join(ROOT, 'build', f'wheel-{_tag()}')
    # Without ninja make does.
    ninja = any(os.access(os.path.join(folder, 'ninja'), os.X_OK) for folder in os.environ.get('PATH', '').split(os.pathsep))
    generator = ['-G', 'Ninja'] if ninja and not os.environ.get('CMAKE_GENERATOR') else []
    off = [f'-DQUENCH_{part}=OFF' for part in ('PROGRAM', 'TESTS', 'BENCH', 'INSTALL', 'WERROR')]
    subprocess.run(['cmake', '-S', ROOT, '-B', build, *generator, '-DCMAKE_BUILD_TYPE=Release', '-DQUENCH_PYTHON=ON', *off,
                    f'-DPython3_EXECUTABLE={sys.executable}', *shlex.split(os.environ.get('QUENCH_CMAKE_ARGS', ''))],
                   check=True)
    jobs = os.environ.get('CMAKE_BUILD_PARALLEL_LEVEL') or str(os.cpu_count() or 1)
    subprocess.run(['cmake', '--build', build, '-j', jobs, '--target', 'quench_python'], check=True)
    return os.path.join(build, 'python', 'quench')


def _write_wheel(folder, files):
    """A wheel of (name, bytes) with its record, the same bytes for the same files."""
    name = f'quench-{_version()}-{_tag()}.whl'
    info = f'quench-{_version()}.dist-info'
    files = [*files, (f'{info}/METADATA', _metadata().encode()), (f'{info}/WHEEL', _wheel_text().encode())]
    with open(os.path.join(ROOT, 'LICENSE'), 'rb') as file:
        files.append((f'{info}/LICENSE', file.read()))
    record = ''
    with zipfile.ZipFile(os.path.join(folder, name), 'w', zipfile.ZIP_DEFLATED) as wheel:
        def put(path, data):
            entry = zipfile.ZipInfo(path, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if path.endswith('.so') else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)

        for path, data in files:
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()
            record += f'{path},sha256={digest},{len(data)}\n'
            put(path, data)
        put(f'{info}/RECORD', (record + f'{info}/RECORD,,\n').encode())
    return name


def get_requires_for_build_wheel(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    name = f'quench-{_version()}.dist-info'
    os.makedirs(os.path.join(metadata_directory, name), exist_ok=True)
    for file, text in (('METADATA', _metadata()), ('WHEEL', _wheel_text())):
        with open(os.path.join(metadata_directory, name, file), 'w', encoding='utf-8') as out:
            out.write(text)
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    return pack_wheel(wheel_directory, _compile())


def pack_wheel(wheel_directory, compiled):
    """The wheel of a module that is compiled for this Python, in the folder `compiled`. Returns its name."""
    module = os.path.join(compiled, '_core' + sysconfig.get_config_var('EXT_SUFFIX'))
    if not os.path.exists(module):
        raise RuntimeError(f'{module} was expected, and it is not there: the module is that of another Python')
    sources = [path for path in sorted(glob.glob(os.path.join(ROOT, 'python', 'quench', '*')))
               if path.endswith(('.py', '.pyi', 'py.typed'))]
    files = []
    for path in [*sources, module]:
        with open(path, 'rb') as file:
            files.append(('quench/' + os.path.basename(path), file.read()))
    return _write_wheel(wheel_directory, files)


def get_requires_for_build_sdist(config_settings=None):
    return []


def build_sdist(sdist_directory, config_settings=None):
    base = f'quench-{_version()}'

    def wanted(entry):
        return None if os.path.basename(entry.name) in ('__pycache__', 'node_modules') else entry

    with tarfile.open(os.path.join(sdist_directory, base + '.tar.gz'), 'w:gz') as archive:
        for name in ('CMakeLists.txt', 'LICENSE', 'README.md', 'pyproject.toml', 'cmake', 'include', 'src', 'cli', 'viewer', 'python'):
            archive.add(os.path.join(ROOT, name), f'{base}/{name}', filter=wanted)
    return base + '.tar.gz'
