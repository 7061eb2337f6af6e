# SPDX-License-Identifier: Apache-2.0
"""Opens core.vtp, skeleton.vtp, trees and volumes at their places in the world, z, y, x."""
import os

from . import layers

TREES = ('.swc', '.rsml')
VOLUMES = ('.nrrd', '.nii', '.nii.gz', '.mha', '.mrc', '.map', '.vol')


def get_reader(path):
    """The function that reads a path, or None; a list of several paths is not one image."""
    if isinstance(path, (list, tuple)):
        if len(path) != 1:
            return None
        path = path[0]
    return read if str(path).lower().endswith(('.vtp', *TREES, *VOLUMES)) else None


def read(path):
    """Layers of a file, as a list of (data, keywords, kind)."""
    import quench

    if isinstance(path, (list, tuple)):
        path = path[0]
    path = str(path)
    name = os.path.basename(path)
    if path.lower().endswith(TREES):
        return layers.tree_layers(quench.read_tree(path), name)
    result = quench.read(path)
    if isinstance(result, quench.Volume):
        return layers.volume_layer(result, name)
    if isinstance(result, quench.Mesh):
        raise ValueError(f'{name} is a mesh, not a medial axis; napari opens meshes by other readers')
    return layers.axis_layers(result, name)
