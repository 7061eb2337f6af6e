# SPDX-License-Identifier: Apache-2.0
"""Writes volumes with the program, as NRRD and as OME-Zarr, and compares what python3-zarr reads of the one with what is
in the other: voxels, spacing, origin, units, and which chunks there are.

zarr_writer.py --program QUENCH

Ends with 77, skipped, where numpy or zarr are missing.
"""
import argparse
import filecmp
import gzip
import os
import random
import re
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import zarr
except ImportError as missing:
    print(f'skipped: {missing}')
    sys.exit(77)

SIDE = 128


def read_nrrd(path):
    """The samples of a NRRD file of the program (z, y, x), its spacing and its origin, x first."""
    with open(path, 'rb') as file:
        header, _, data = file.read().partition(b'\n\n')
    fields = dict(re.findall(r'^([a-z ]+): (.*)$', header.decode(), re.M))
    sizes = [int(size) for size in fields['sizes'].split()]
    data = gzip.decompress(data) if fields['encoding'] == 'gzip' else data
    columns = [np.array(eval(column)) for column in fields['space directions'].split()]
    return (np.frombuffer(data, np.uint8).reshape(sizes[::-1]), np.diag(np.array(columns)),
            np.array(eval(fields['space origin'])))


def chunks_of(folder):
    """The chunks that have a file, as z, y, x."""
    found = set()
    for path, _, names in os.walk(os.path.join(folder, '0')):
        found |= {tuple(os.path.relpath(os.path.join(path, name), os.path.join(folder, '0')).split('/'))
                  for name in names if not name.startswith('.')}
    return {tuple(int(part) for part in chunk) for chunk in found}


def check(folder, nrrd, fill, unit=None):
    voxels, spacing, origin = read_nrrd(nrrd)
    group = zarr.open_group(folder, mode='r')
    (image,) = group.attrs['multiscales']
    assert image['version'] == '0.4', image
    axes = [{'name': name, 'type': 'space', **({'unit': unit} if unit else {})} for name in 'zyx']
    assert image['axes'] == axes, image
    (level,) = image['datasets']
    scale, translation = level['coordinateTransformations']
    assert scale == {'type': 'scale', 'scale': list(spacing[::-1])}, (scale, spacing)
    assert translation == {'type': 'translation', 'translation': list(origin[::-1])}, (translation, origin)
    array = group[level['path']]
    assert array.dtype == np.uint8 and array.fill_value == fill and array.chunks == (SIDE,) * 3, array.info
    assert array.shape == voxels.shape and np.array_equal(array[...], voxels), 'other voxels'
    filled = {(z, y, x) for z in range(-(-voxels.shape[0] // SIDE)) for y in range(-(-voxels.shape[1] // SIDE))
              for x in range(-(-voxels.shape[2] // SIDE))
              if (voxels[z * SIDE:(z + 1) * SIDE, y * SIDE:(y + 1) * SIDE, x * SIDE:(x + 1) * SIDE] != fill).any()}
    assert chunks_of(folder) == filled, (sorted(chunks_of(folder)), sorted(filled))
    return len(filled), array.nchunks


def same_folders(a, b):
    compared = filecmp.dircmp(a, b)
    assert not (compared.left_only or compared.right_only or compared.funny_files), compared.report()
    for name in compared.common_files:
        with open(os.path.join(a, name), 'rb') as one, open(os.path.join(b, name), 'rb') as other:
            assert one.read() == other.read() or name == '.zattrs', name  # which has the name of the folder
    for name in compared.common_dirs:
        same_folders(os.path.join(a, name), os.path.join(b, name))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--program', required=True)
    program = os.path.abspath(parser.parse_args().program)

    def quench(*arguments):
        subprocess.run([program, *arguments, '--quiet', '--overwrite'], check=True)

    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        dice = random.Random(1)
        for seed in range(12):
            shape = [dice.choice([1, 5, 60, 127, 128, 129, 200, 257]) for _ in range(3)]
            voxels = (np.random.RandomState(seed).rand(*shape) < dice.choice([1e-5, 1e-3, 0.1, 1])).astype(np.uint8)
            voxels[tuple(dice.randrange(side) for side in shape)] = 1
            np.save('in.npy', voxels)
            spacing = ','.join(dice.choice(['1', '0.5', '0.25', '3']) for _ in range(3))
            options = ['--spacing', spacing, '--dimension', '3', '--threshold', '1']
            quench('voxelize', 'in.npy', *options, '-o', 'out.nrrd')
            quench('voxelize', 'in.npy', *options, '-o', 'out.ome.zarr')
            check('out.ome.zarr', 'out.nrrd', 0)
            assert np.array_equal(zarr.open('out.ome.zarr', mode='r')['0'][...], voxels)
        quench('sample', 'fin-on-board', '--resolution', '200', '-o', 'fin.nrrd')
        quench('sample', 'fin-on-board', '--resolution', '200', '-o', 'fin.zarr')
        check('fin.zarr', 'fin.nrrd', 0)
        root = ['sample', 'root', '--branches', '12', '--thickness', '0.4', '--resolution', '400']
        for grey, sparse in (([], True), (['--grey'], True), (['--grey', '--blur', '1.2', '--gaps', '4'], True),
                             (['--grey', '--noise', '0.02', '--resolution', '140'], False)):
            words = root[:-2] + grey if '--resolution' in grey else root + grey
            quench(*words, '-o', 'root.nrrd')
            with open('root.json', 'rb') as file:
                truth = file.read()
            for threads in ('1', '3'):
                quench(*words, '-o', f'root{threads}.zarr', '--threads', threads)
            there, most = check('root1.zarr', 'root.nrrd', 50 if grey else 0)
            assert (there < most) == sparse, (there, most)
            same_folders('root1.zarr', 'root3.zarr')
            with open('root1.json', 'rb') as file:
                assert file.read() == truth
    print('ok')


main()
