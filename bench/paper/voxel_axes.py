#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Two methods that thin the whole volume to a medial axis of voxels, as published, written anew for comparison; not the programs of
their authors, of which nothing is used here. figure_2_7.py measures them, check_peers.py tests them.

hamilton_jacobi  K. Siddiqi, S. Bouix, A. Tannenbaum, S. W. Zucker, Hamilton-Jacobi skeletons, 2002: simple voxels are removed in the
                 order of the average outward flux of the gradient of the distance, unless they are at the end of a sheet (Pudney 1998)
                 and their flux is below a threshold. Here in 64 steps of the flux; a heap takes them one by one.
mass_transport   A. Jalba, A. Sobiecki, A. Telea, An unified multiscale framework for planar, surface, and curve skeletonization, 2016,
                 in its outline: simple voxels are removed in the order of their distance, each hands its mass, one per voxel at the
                 boundary in the beginning, to the neighbours that are left and lie along the gradient; voxels with more than
                 `threshold` stay. Their momentum and the second stage, to curves, are not here.

Both hold distances, gradients and what they transport for every voxel of the box, as the published programs do. Topology: 26 neighbours
for the shape, 6 for the rest. Within a step the eight classes of voxels by parity take turns, so that no two neighbours go at once.

usage: voxel_axes.py METHOD VOLUME.nrrd [OUT.npy]"""
import gzip
import sys

import numpy as np
from scipy import ndimage

AROUND = np.array([(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) != (0, 0, 0)])


def spread_table(joined):
    """Of a set of neighbours, in two halves of 13 bits: all that are joined to one of them, and themselves."""
    rows = [sum(1 << int(b) for b in np.flatnonzero(joined[a])) | 1 << a for a in range(26)]
    tables = []
    for half in (0, 13):
        table = np.zeros(1 << 13, np.int32)
        for bit in range(13):
            table[1 << bit:2 << bit] = table[:1 << bit] | rows[half + bit]
        tables.append(table)
    return tables


STEP = np.abs(AROUND[:, None] - AROUND[None])
OBJECT = spread_table(STEP.max(2) == 1)
NEAR18 = np.abs(AROUND).sum(1) <= 2
REST = spread_table((STEP.sum(2) == 1) & NEAR18[:, None] & NEAR18[None])
SIX = sum(1 << int(b) for b in np.flatnonzero(np.abs(AROUND).sum(1) == 1))
EIGHTEEN = sum(1 << int(b) for b in np.flatnonzero(NEAR18))
ALL = (1 << 26) - 1
NORMALS = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
PLANES = [sum(1 << int(b) for b in np.flatnonzero(AROUND @ np.array(n) == 0)) for n in NORMALS]


def one_part(of, seeds, tables):
    """Whether all of the sets `seeds`, parts of `of`, are in one part of `of`; not where there is no seed."""
    reached = seeds & -seeds
    while True:
        more = (tables[0][reached & 8191] | tables[1][reached >> 13]) & of
        if (more == reached).all():
            return (seeds & ~reached == 0) & (seeds != 0)
        reached = more


def simple(code):
    """Whether a voxel with these neighbours (26 bits) can go without a change of topology (Malandain and Bertrand)."""
    rest = ~code & EIGHTEEN
    found = one_part(rest, rest & SIX, REST)
    found[found] = one_part(code[found], code[found], OBJECT)
    return found


def end_of_sheet(code):
    """In one of nine planes there is at most one neighbour."""
    end = np.zeros(len(code), bool)
    for plane in PLANES:
        some = code & plane
        end |= some & (some - 1) == 0
    return end


class Volume:
    """A mask with two layers of background around it, flat."""

    def __init__(self, inside):
        padded = np.pad(inside, 2)
        self.shape, self.inside = padded.shape, padded.ravel()
        self.strides = np.array([padded.shape[1] * padded.shape[2], padded.shape[2], 1])
        self.around = AROUND @ self.strides

    def code(self, voxels):
        bits = np.zeros(len(voxels), np.int32)
        for b, step in enumerate(self.around):
            bits |= self.inside[voxels + step].astype(np.int32) << b
        return bits

    def classes(self, voxels):
        x, rest = np.divmod(voxels, self.strides[0])
        y, z = np.divmod(rest, self.strides[1])
        return (x & 1) * 4 + (y & 1) * 2 + (z & 1)

    def gradient(self, voxels, nearest):
        """The direction away from the nearest background voxel, whose indices are `nearest` (3 x volume)."""
        place = np.stack(np.unravel_index(voxels, self.shape))
        way = (place - nearest.reshape(3, -1)[:, voxels]).astype(np.float32)
        return way / np.maximum(np.sqrt((way ** 2).sum(0)), 1e-6)

    def thin(self, order, steps, stays, removed=lambda voxels: None):
        """Removes simple voxels, those with small `order` first (`steps`: ascending bounds), unless `stays(voxels, code)`."""
        inside, steps = self.inside, np.asarray(steps)
        queued, parked = np.zeros(len(inside), bool), np.zeros(len(inside), bool)
        waiting = [[] for _ in steps]

        def wait(voxels, now):
            """Puts voxels off until their step; those whose step has come are given back."""
            queued[voxels] = True
            step = np.searchsorted(steps, order[voxels])
            later = np.argsort(step, kind='stable')
            voxels, step = voxels[later], step[later]
            first = np.flatnonzero(np.append(True, step[1:] != step[:-1])) if len(step) else []
            for start, end in zip(first, [*first[1:], len(step)]):
                if step[start] > now:
                    waiting[step[start]].append(voxels[start:end])
            return voxels[step <= now]

        padded = inside.reshape(self.shape)
        wait(np.flatnonzero((padded & ~ndimage.binary_erosion(padded)).ravel()), -1)
        for now in range(len(steps)):
            new = np.concatenate([np.zeros(0, np.int64), *waiting[now]])
            waiting[now] = []
            while len(new):
                kind, more, fresh = self.classes(new), [], []
                for k in range(8):
                    voxels = new[kind == k]
                    code = self.code(voxels)
                    go = simple(code)
                    go[go] = ~stays(voxels[go], code[go])
                    gone = voxels[go]
                    parked[voxels[~go]] = True  # until a neighbour goes
                    if not len(gone):
                        continue
                    inside[gone] = False
                    removed(gone)
                    for step in self.around:
                        near = gone + step
                        near = near[inside[near]]
                        again = near[parked[near]]
                        parked[again] = False
                        more.append(again)
                        near = near[~queued[near]]
                        queued[near] = True
                        fresh.append(near)
                new = np.concatenate([np.zeros(0, np.int64), *more, wait(np.concatenate([np.zeros(0, np.int64), *fresh]), now)])
        return inside.reshape(self.shape)[2:-2, 2:-2, 2:-2]


def hamilton_jacobi(inside, threshold=-0.2, levels=64):
    volume = Volume(inside)
    padded = volume.inside.reshape(volume.shape)
    distance = ndimage.distance_transform_edt(padded).astype(np.float32)
    gradient = [g.ravel() for g in np.gradient(distance)]
    voxels = np.flatnonzero(volume.inside)
    flux = np.zeros(len(volume.inside), np.float32)
    for step, way in zip(volume.around, AROUND / np.linalg.norm(AROUND, axis=1)[:, None]):
        at = voxels + step
        flux[voxels] += sum(w * g[at] for w, g in zip(way.astype(np.float32), gradient) if w) / 26
    steps = np.quantile(-flux[voxels], np.linspace(0, 1, levels + 1)[1:])
    # The flux is largest outside the axis: those go first.
    return volume.thin(-flux, steps, lambda voxels, code: (flux[voxels] < threshold) & end_of_sheet(code))


def mass_transport(inside, threshold=16.0, account=None):
    volume = Volume(inside)
    padded = volume.inside.reshape(volume.shape)
    distance, nearest = ndimage.distance_transform_edt(padded, return_indices=True)
    distance, nearest = distance.ravel().astype(np.float32), nearest.astype(np.int16)
    mass = (padded & ~ndimage.binary_erosion(padded)).ravel().astype(np.float32)
    ways = (AROUND / np.linalg.norm(AROUND, axis=1)[:, None]).astype(np.float32)

    def removed(voxels):
        share = np.maximum(ways @ volume.gradient(voxels, nearest), 0) ** 4  # 26 x voxels: narrow about the gradient
        left = volume.inside[voxels[None] + volume.around[:, None]]
        share *= left
        none = share.sum(0) == 0
        share[:, none] = left[:, none]
        share *= mass[voxels] / share.sum(0)
        np.add.at(mass, (voxels[None] + volume.around[:, None])[left], share[left])
        mass[voxels] = 0

    steps = np.arange(1, distance.max() + 0.25, 0.25)  # of the distance, a quarter of a voxel
    result = volume.thin(distance, steps, lambda voxels, code: mass[voxels] > threshold, removed)
    if account is not None:
        account['mass'] = mass.reshape(volume.shape)[2:-2, 2:-2, 2:-2]
    return result


def read(file):
    """A mask [z, y, x] of an NRRD of bytes."""
    head, samples = open(file, 'rb').read().split(b'\n\n', 1)
    if b'gzip' in head:
        samples = gzip.decompress(samples)
    sizes = [int(n) for line in head.split(b'\n') if line.startswith(b'sizes:') for n in line.split()[1:]]
    return np.frombuffer(samples, np.uint8).reshape(sizes[::-1]) > 0


if __name__ == '__main__':
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    found = {'hamilton_jacobi': hamilton_jacobi, 'mass_transport': mass_transport}[sys.argv[1]](read(sys.argv[2]))
    if len(sys.argv) == 4:
        np.save(sys.argv[3], found)
    print(found.sum())
