# SPDX-License-Identifier: Apache-2.0
"""The sparse voxel lists of the DynamicRoots family: voxel size in mm, number of voxels, `x y z` per voxel."""
import numpy as np

from .cases import Grid, case, one_slice


def samples_of(dims, seed=1):
    """0 and 1; the box of the ones is the whole grid."""
    random = np.random.default_rng(seed)
    samples = (random.random(dims) < 0.4).astype(np.uint8)
    samples[0, 0, 0] = samples[-1, -1, -1] = 1
    return samples


def text(samples, scale='0.15', begin=(0, 0, 0), end='\n', seed=2, count=None):
    voxels = np.argwhere(samples) + np.array(begin)
    np.random.default_rng(seed).shuffle(voxels)
    lines = [scale, str(len(voxels) if count is None else count)] + [' '.join(map(str, v)) for v in voxels]
    return (end.join(lines) + end).encode()


def cases():
    samples = samples_of((5, 4, 3))

    def right(scale=0.15, begin=(0, 0, 0), of=samples):
        return Grid(of, (scale,) * 3, tuple(scale * b for b in begin), units=('mm',), space=('-',))

    found = [case('plain', text(samples), 'v.out', right(), by_program=True),
             case('another order', text(samples, seed=9), 'v.out', right()),
             case('CR LF', text(samples, end='\r\n'), 'v.out', right()),
             case('no last line end', text(samples)[:-1], 'v.out', right()),
             case('blank lines behind', text(samples) + b'\n \n\n', 'v.out', right()),
             case('extension in capitals', text(samples), 'v.OUT', right()),
             case('an exponent', text(samples, '1.5E-1'), 'v.out', right()),
             case('large', text(samples_of((40, 30, 20))), 'v.out', right(of=samples_of((40, 30, 20))), by_program=True)]
    for begin in ((10, 0, 3), (-7, -1, 100), (1000000, 5, 5)):
        found.append(case(f'from {begin}', text(samples, '2', begin), 'v.out', right(2, begin), by_program=True))
    lines = text(samples).split(b'\n')
    twice = b'\n'.join([lines[0], str(len(lines) - 2).encode()] + lines[2:-1] + [lines[2], b''])
    found.append(case('a voxel twice', twice, 'v.out', right()))
    flat = samples_of((5, 4, 1))
    found += one_slice('a list', text(flat), 'v.out', right(of=flat))
    number = int(lines[1])
    for name, data in (('a voxel less', text(samples, count=number + 1)), ('a voxel more', text(samples, count=number - 1)),
                       ('no voxel', b'0.15\n0\n'), ('an empty file', b''), ('a size only', b'0.15\n'),
                       ('a count that is negative', text(samples, count=-1)), ('a huge count', text(samples, count=2**62)),
                       ('a fraction as count', text(samples, count='7.5')), ('a size of 0', text(samples, '0')),
                       ('a negative size', text(samples, '-1')), ('a size that is none', text(samples, 'nan')),
                       ('an infinite size', text(samples, 'inf')), ('a size of words', text(samples, 'mm')),
                       ('a coordinate of words', b'1\n1\n0 zero 0\n'), ('a fraction as coordinate', b'1\n1\n0 0.5 0\n'),
                       ('a coordinate less', b'1\n2\n0 0 0\n1 1\n'), ('too far away', b'1\n1\n0 0 9999999999\n'),
                       ('bytes', bytes(range(256)))):
        found.append(case(name, data, 'v.out'))
    return found
