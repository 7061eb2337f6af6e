# SPDX-License-Identifier: Apache-2.0
"""Runs tests for CTest: `pytest FILE`, `doctest FOLDER` or `script FILE ...`. Ends with 77 where something is missing."""
import importlib.util
import runpy
import sys


class Passed:
    """Whether any test did more than to say that something is missing."""
    any = False

    def pytest_runtest_logreport(self, report):
        self.any |= report.when == 'call' and report.outcome != 'skipped'


def main():
    kind, target = sys.argv[1:3]
    needed = {'pytest': ['numpy', 'pytest'], 'doctest': ['numpy', 'pytest'], 'script': ['numpy', 'matplotlib']}[kind]
    missing = [name for name in needed if importlib.util.find_spec(name) is None]
    if missing:
        print(f'skipped: {sys.executable} has no {", ".join(missing)}')
        sys.exit(77)
    if kind == 'script':
        sys.argv = sys.argv[2:]
        runpy.run_path(target, run_name='__main__')
        sys.exit(0)
    import pytest

    options = ['-q', '-rs', '-p', 'no:cacheprovider', '-o', 'doctest_optionflags=ELLIPSIS NORMALIZE_WHITESPACE']
    passed = Passed()
    code = pytest.main([*options, *(['--doctest-modules'] if kind == 'doctest' else []), target], plugins=[passed])
    skipped = code == pytest.ExitCode.NO_TESTS_COLLECTED or (code == pytest.ExitCode.OK and not passed.any)
    sys.exit(77 if skipped else int(code))


if __name__ == '__main__':  # processes that a test starts import this file
    main()
