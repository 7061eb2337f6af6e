#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Medial axes of images beside scikit-image's: time, and whether the topology is that of the shape.

    bench/plane_peers.py --module build/release/python [IMAGE:THRESHOLD | IMAGE:-THRESHOLD ...]

Without images: noise blobs of several sizes, thresholded at their median. A threshold with a minus sign takes what is
darker. Per image, the median of processor times of five runs, in turns, on one thread:
  quench  the core with its measures and its pruning, from the array in memory to the axis in memory (Python module)
  medial_axis, skeletonize  of scikit-image
The last columns compare components and holes of the results with those of the shape: of pixels 4-connected
foreground and 8-connected background for the shape, 8-connected lines for scikit-image's.
"""
import argparse
import statistics
import sys
import time

import numpy as np
import scipy.ndimage as ndimage
import skimage
import skimage.io
from skimage.morphology import medial_axis, skeletonize

EIGHT = np.ones((3, 3))


def blobs(side, seed=1):
    noise = np.random.default_rng(seed).random((side, side), dtype=np.float32)
    smooth = ndimage.gaussian_filter(noise, 12, mode="wrap")
    return smooth > np.median(smooth)


def read(argument):
    name, threshold = argument.rsplit(":", 1)
    image = skimage.io.imread(name)
    if image.ndim == 3:
        image = image[..., :3].mean(axis=2)
    value = float(threshold)
    return image < -value if threshold.startswith("-") else image >= value


def topology(mask, foreground, background):
    holes = ndimage.label(~np.pad(mask, 1), background)[1] - 1
    return ndimage.label(mask, foreground)[1], holes


def timed(work):
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="*")
    parser.add_argument("--module", required=True, help="folder of the built Python module quench")
    options = parser.parse_args()
    sys.path.insert(0, options.module)
    import quench

    shapes = [(name, read(name)) for name in options.images]
    shapes = shapes or [(f"blobs {side}", blobs(side)) for side in (512, 1024, 2048, 4096)]
    print(f"scikit-image {skimage.__version__}")
    print(f"{'image':32} {'quench':>8} {'medial_axis':>12} {'ratio':>6} {'skeletonize':>12} {'ratio':>6}"
          "  components, holes of: shape | quench | medial_axis | skeletonize")
    for name, mask in shapes:
        works = [lambda: quench.medial_axis(mask, threads=1), lambda: medial_axis(mask, return_distance=True),
                 lambda: skeletonize(mask)]
        runs = [[timed(work) for work in works] for _ in range(5)]
        seconds = [statistics.median(run[i][0] for run in runs) for i in range(3)]
        axis, (theirs, _), thin = (result for _, result in runs[-1])
        found = [topology(mask, None, EIGHT), (axis.betti[0], axis.betti[1]), topology(theirs, EIGHT, None),
                 topology(thin, EIGHT, None)]
        print(f"{name[-32:]:32} {seconds[0]:8.3f} {seconds[1]:12.3f} {seconds[1] / seconds[0]:6.1f} {seconds[2]:12.3f} "
              f"{seconds[2] / seconds[0]:6.1f}  " + " | ".join(f"{a}, {b}" for a, b in found))


if __name__ == "__main__":
    main()
