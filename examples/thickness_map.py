#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""How thick a part is everywhere on its surface: walls.ply (coloured), thickness.csv (a row per vertex and
triangle) and thickness.png.

usage: thickness_map.py [MESH] [--resolution N] [-o FOLDER]

The thickness at a vertex is the diameter of the largest ball inside the part that touches it (within half a voxel
diagonal); the point across is where that ball touches the other side. Without MESH a built-in part is taken. Needs numpy and
matplotlib. `quench thickness MESH --surface walls.ply --png thickness.png` does it without Python."""
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
# Thickness is known at vertices; those of a flat side may all lie on its edges. So triangles get one in their middle, too.
a, b, c = mesh.faces.T
middle = len(mesh.vertices) + np.arange(len(mesh.faces))
vertices = np.concatenate([mesh.vertices, mesh.vertices[mesh.faces].mean(axis=1)])
faces = np.concatenate([np.column_stack(part) for part in ((a, b, middle), (b, c, middle), (c, a, middle))])
walls = quench.surface_thickness((vertices, faces), resolution=options.resolution)

np.savetxt(options.output / 'thickness.csv', np.column_stack([walls.vertices, walls.thickness, walls.across]), delimiter=',',
           header='x,y,z,thickness,across_x,across_y,across_z', comments='', fmt='%.6g')
corners = mesh.vertices[mesh.faces]
normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
area = np.linalg.norm(normal, axis=1) / 2
thickness = walls.thickness[middle]  # of each triangle of the mesh
mean = (thickness * area).sum() / area.sum()
print(f'thickness from {walls.thickness.min():.4g} to {walls.thickness.max():.4g}, mean over the surface {mean:.4g}')

normal /= np.maximum(2 * area[:, None], 1e-300)
scale = colors.Normalize(0, thickness.max())
paint = colormaps['viridis'](scale(thickness))
with open(options.output / 'walls.ply', 'w', encoding='ascii') as ply:
    ply.write(f'ply\nformat ascii 1.0\nelement vertex {len(walls.vertices)}\nproperty float x\nproperty float y\n'
              'property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n'
              f'element face {len(walls.faces)}\nproperty list uchar int vertex_indices\nend_header\n')
    colour = (colormaps['viridis'](scale(walls.thickness))[:, :3] * 255).astype(int)
    np.savetxt(ply, np.column_stack([walls.vertices, colour]), fmt='%.7g %.7g %.7g %d %d %d')
    np.savetxt(ply, np.column_stack([np.full(len(walls.faces), 3), walls.faces]), fmt='%d')

paint[:, :3] *= 0.6 + 0.4 * np.abs(normal @ [[0.3], [-0.5], [0.81]])
axes = pyplot.figure(figsize=(7, 6)).add_subplot(projection='3d')
axes.add_collection3d(Poly3DCollection(corners, facecolors=paint, edgecolors=paint, linewidths=0.2))
for limit, low, high in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), walls.vertices.min(0), walls.vertices.max(0)):
    limit(low, high)
axes.set_box_aspect(np.ptp(walls.vertices, axis=0))
axes.figure.colorbar(pyplot.cm.ScalarMappable(scale), ax=axes, label='thickness', shrink=0.6)
axes.figure.savefig(options.output / 'thickness.png', dpi=100, bbox_inches='tight')
