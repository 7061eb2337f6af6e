# SPDX-License-Identifier: Apache-2.0
"""Writes volumes of every format Quench reads, whole, damaged and odd, and compares what Quench makes of each with what
was written: it is read right, or refused with exit 3 and a sentence, and nothing else.

volume_formats.py --reader READ_VOLUMES [--program QUENCH] [--format NAME ...] [--keep FOLDER] [--list]

READ_VOLUMES is built from read_volumes.cpp; it reads each file whole and slice by slice. The program itself reads those
that are whole. Nothing here reads an image but the NRRD the program writes: the samples are known. Ends with 77 where
numpy is missing.
"""
import argparse
import collections
import concurrent.futures
import gzip
import importlib
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print(f'skipped: {sys.executable} has no numpy')
    sys.exit(77)

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, '..', 'support')]
from formats.cases import Grid, difference, judge  # noqa: E402
from program_starter import run_program  # noqa: E402

FORMATS = ['nrrd', 'metaimage', 'nifti', 'mrc', 'npy', 'vol', 'out', 'png', 'pnm', 'bmp', 'zarr', 'jpeg', 'tiff', 'hdf5', 'dicom']
MOST_FAILURES = 40  # printed per format


def write(case, folder):
    os.mkdir(folder)
    for name, data in case.files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'wb') as out:
            out.write(data)
    return folder if case.opened == '.' else os.path.join(folder, case.opened)


def read_all(reader, requests):
    """One line of read_volumes per request; where it dies, that is the line, and another one goes on behind."""
    lines, noise = [], []
    while len(lines) < len(requests):
        left = ''.join(f'{how} {path}\n' for how, path in requests[len(lines):])
        run = subprocess.run([reader], input=left.encode(), capture_output=True)
        found = run.stdout.decode(errors='backslashreplace').split('\n')[:-1]
        lines += found
        if run.stderr and run.returncode == 0:
            noise.append(run.stderr.decode(errors='replace').strip())
        if run.returncode != 0:
            lines.append(f'crash: signal {-run.returncode} {run.stderr[:300]!r}' if run.returncode < 0
                         else f'crash: code {run.returncode} {run.stderr[:300]!r}')
        elif not found:
            raise RuntimeError(f'{reader} does not answer')
    return lines, noise


def written_volume(path):
    """The NRRD that `quench voxelize` writes: attached, gzip, uint8."""
    with open(path, 'rb') as file:
        text, data = file.read().split(b'\n\n', 1)
    fields = dict(line.split(': ', 1) for line in text.decode().split('\n')[1:] if ': ' in line and line[0] != '#')
    dims = tuple(map(int, fields['sizes'].split()))
    samples = np.frombuffer(gzip.decompress(data), np.uint8).reshape(dims + (1,) * (3 - len(dims)), order='F')
    columns = [[float(x) for x in v.strip('()').split(',')] for v in fields['space directions'].split(' ')]
    origin = [float(x) for x in fields['space origin'].strip('()').split(',')]
    matrix = np.eye(3)
    matrix[:len(dims), :len(dims)] = np.array(columns).T
    spacing = np.linalg.norm(matrix, axis=0)
    direction = matrix / spacing
    spacing[len(dims):] = min(spacing[:2])
    return Grid(samples, tuple(spacing), tuple(origin) + (0.0,) * (3 - len(dims)), direction, plane=len(dims) == 2)


def threshold_of(samples):
    """A value near the middle that an option can say exactly."""
    values = samples[np.isfinite(samples)] if samples.dtype.kind == 'f' else samples
    values = sorted(v for v in values.ravel().tolist() if abs(v) < 2**53)
    return values[len(values) // 2]


def arguments_of(case):
    return [f'--{name}={value}' for name, value in case.how]


def by_program(program, case, path, folder):
    """What is wrong with the outcome of `quench voxelize`; empty: nothing."""
    output = os.path.join(folder, 'out.nrrd')
    threshold = threshold_of(case.right[0].samples)
    run = run_program([program, 'voxelize', path, f'--threshold={threshold!r}', '-o', output] + arguments_of(case))
    if run.returncode != 0:
        return f'exit {run.returncode}: {run.stderr.decode(errors="replace").strip()[:400]}'
    got = written_volume(output)
    found = []
    for right in case.right:
        inside = (right.samples >= threshold).astype(np.uint8)
        found.append(difference(got, Grid(inside, right.spacing, right.origin, right.direction, placed=right.placed,
                                          any_axes=right.any_axes, space=('-', 'LPS'), plane=right.plane)))
    return min(found, key=len)


def refused_by_program(program, case, path, folder):
    run = run_program([program, 'voxelize', path, '--threshold=1', '-o', os.path.join(folder, 'out.nrrd')]
                      + arguments_of(case))
    sentence = run.stderr.decode(errors='replace').strip()
    if run.returncode != case.code():
        return f'exit {run.returncode}: {sentence[:400]}'
    return '' if sentence and '\n' not in sentence else f'refused, but not with one sentence: {sentence!r}'


def run_format(name, options, folder):
    """The failures of a format: lines of text."""
    try:
        cases = importlib.import_module(f'formats.{name}').cases()
    except ModuleNotFoundError as error:
        print(f'{name}: skipped: {sys.executable} has no {error.name}')
        return []
    doubles = [n for n, count in collections.Counter(c.name for c in cases).items() if count > 1]
    assert not doubles, f'cases of the same name: {doubles[:3]}'
    if options.list:
        print('\n'.join(f'{name}: {c.name}: {c.expected()}' for c in cases))
        return []
    base = os.path.join(folder, name)
    os.mkdir(base)
    paths = [write(case, os.path.join(base, str(i))) for i, case in enumerate(cases)]
    requests = [(':'.join([how] + [f'{name}={value}' for name, value in c.how]), path)
                for c, path in zip(cases, paths) for how in ('volume', 'slices')]
    lines, noise = read_all(options.reader, requests)
    failures = [f'a library writes to standard error: {text[:300]}' for text in noise]
    for i, ((how, path), line) in enumerate(zip(requests, lines)):
        wrong = judge(cases[i // 2], line)
        if wrong:
            failures.append(f'{cases[i // 2].name} [{how}]: expected {cases[i // 2].expected()}; got {wrong}'
                            + (f' ({path})' if options.keep else ''))
    count = len(requests)
    if options.program:
        tried = [(by_program, c, p) for c, p in zip(cases, paths) if c.by_program]
        hopeless = [(refused_by_program, c, p) for c, p in zip(cases, paths) if not c.right]
        tried += hopeless[::max(1, len(hopeless) // 12)]
        folders = [os.path.join(base, os.path.relpath(p, base).split(os.sep)[0]) for _, _, p in tried]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            wrong = list(pool.map(lambda t: t[0][0](options.program, t[0][1], t[0][2], t[1]), zip(tried, folders)))
        failures += [f'{c.name} [program]: expected {c.expected()}; got {w}' for (_, c, _), w in zip(tried, wrong) if w]
        count += len(tried)
    print(f'{name}: {len(cases)} files, {count} readings, {len(failures)} failures', flush=True)
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    build = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'build', 'release')
    parser.add_argument('--reader', default=os.path.join(build, 'tests', 'read_volumes'))
    parser.add_argument('--program', default=os.path.join(build, 'quench'))
    parser.add_argument('--format', nargs='+', choices=FORMATS, default=FORMATS)
    parser.add_argument('--keep', help='a folder that keeps the files')
    parser.add_argument('--list', action='store_true', help='prints the cases and what is expected of them')
    parser.add_argument('--all', action='store_true', help='prints all failures')
    options = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as temporary:
        if options.keep:
            os.makedirs(options.keep)
        for name in options.format:
            failures = run_format(name, options, options.keep or temporary)
            failed = failed or bool(failures)
            most = len(failures) if options.all else MOST_FAILURES
            print(''.join(f'FAIL {name}: {line}\n' for line in failures[:most]), end='', flush=True)
            if len(failures) > most:
                print(f'... and {len(failures) - most} more (--all)')
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
