#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How thick a part is everywhere on its surface: thickness.csv (a row per triangle) and thickness.png.

usage: thickness_map.py [MESH] [--resolution N] [-o FOLDER]

The thickness at a place is the diameter of the largest ball inside the part that touches it (within a voxel and a half); it is
computed at the middle of each triangle. Without MESH a built-in part is taken. Needs numpy and matplotlib."""
import argparse
import pathlib

import matplotlib
import numpy as np
import quench

matplotlib.use('Agg')
from matplotlib import colormaps, colors, pyplot  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('mesh', nargs='?')
parser.add_argument('--resolution', type=int, default=128)
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)

mesh = quench.read(options.mesh) if options.mesh else quench.sample('fin-on-board', fineness=0.35)
axis = quench.medial_axis(mesh, resolution=options.resolution, lambda_='1vox')
voxel = axis.longest_side / options.resolution

# From the largest ball down: the first one that touches a place is its thickness.
corners = mesh.vertices[mesh.faces]
places = corners.mean(axis=1)
thickness = np.full(len(places), np.nan)
left = np.arange(len(places))
for ball in np.argsort(-axis.radius, kind='stable'):
    reach = axis.radius[ball] + 1.5 * voxel
    touches = ((places[left] - axis.vertices[ball])**2).sum(axis=1) <= reach**2
    if touches.any():
        thickness[left[touches]] = 2 * axis.radius[ball] + voxel  # radii end at corners of voxels, half a voxel early
        left = left[~touches]
        if len(left) == 0:
            break

np.savetxt(options.output / 'thickness.csv', np.column_stack([places, thickness]), delimiter=',',
           header='x,y,z,thickness', comments='', fmt='%.6g')
print(f'thickness from {np.nanmin(thickness):.4g} to {np.nanmax(thickness):.4g}, median {np.nanmedian(thickness):.4g}; '
      f'{np.isnan(thickness).mean() * 100:.1f} % of the triangles touch no ball (sharp edges, which are pruned)')

normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
scale = colors.Normalize(0, np.nanmax(thickness))
paint = colormaps['viridis'](scale(np.nan_to_num(thickness)))
paint[np.isnan(thickness)] = (0.7, 0.7, 0.7, 1)
paint[:, :3] *= 0.6 + 0.4 * np.abs(normal @ [[0.3], [-0.5], [0.81]])
axes = pyplot.figure(figsize=(7, 6)).add_subplot(projection='3d')
axes.add_collection3d(Poly3DCollection(corners, facecolors=paint, edgecolors=paint, linewidths=0.2))
for limit, low, high in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), mesh.vertices.min(0), mesh.vertices.max(0)):
    limit(low, high)
axes.set_box_aspect(np.ptp(mesh.vertices, axis=0))
axes.figure.colorbar(pyplot.cm.ScalarMappable(scale), ax=axes, label='thickness', shrink=0.6)
axes.figure.savefig(options.output / 'thickness.png', dpi=100, bbox_inches='tight')
