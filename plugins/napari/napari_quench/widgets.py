# SPDX-License-Identifier: Apache-2.0
"""Functions of which napari makes widgets: what they return is added to the viewer. Results lie on the layer they are of."""
from typing import TYPE_CHECKING, List

import numpy as np

from . import layers

if TYPE_CHECKING:
    import napari.layers
    import napari.types


def place(layer):
    """The size of a voxel, the matrix of the axes in the world, per voxel, and where the first voxel is. What turns the layer
    and its `affine` count, too."""
    dimensions = np.ndim(layer.data)
    scale, translate = np.asarray(layer.scale, float), np.asarray(layer.translate, float)
    first = np.asarray(layer.data_to_world(np.zeros(dimensions)), float)
    steps = np.stack([np.asarray(layer.data_to_world(axis), float) - first for axis in np.eye(dimensions)], axis=1)
    if np.allclose(steps, np.diag(scale)) and np.allclose(first, translate):
        return scale, np.diag(scale), translate  # exactly these
    size = np.linalg.norm(steps, axis=0)
    if not size.all() or not np.allclose((steps / size).T @ (steps / size), np.eye(dimensions), atol=1e-4):
        raise ValueError(f'{layer.name} is sheared: its voxels are no boxes, and nothing can be measured in it')
    return size, steps, first


def chosen(layer, threshold):
    """The array of a layer, and which of its values are the shape, as keywords of quench."""
    array = np.asarray(layer.data)
    if array.ndim not in (2, 3):
        raise ValueError(f'{layer.name} has {array.ndim} dimensions; choose a layer of two or three')
    keywords = {'spacing': tuple(float(size) for size in place(layer)[0])}
    if type(layer).__name__ == 'Labels':
        keywords['label'] = int(layer.selected_label)
    elif array.dtype != bool:
        low, comma, high = threshold.partition(',')
        keywords['threshold'] = (float(low), float(high)) if comma else threshold
        try:
            keywords['threshold'] = float(threshold)
        except ValueError:
            pass  # auto, otsu, thin, or two
    return array, keywords


def on(layer, results):
    """Moved to where the layer is, and turned as it is; all but images have the size of voxels in them."""
    size, steps, first = place(layer)
    turned = not np.array_equal(steps, np.diag(size))
    for _, keywords, kind in results:
        if turned:
            keywords['affine'] = np.eye(len(size) + 1)
            keywords['affine'][:-1, :-1] = steps if kind == 'image' else steps / size
            keywords['affine'][:-1, -1] = first
            continue
        keywords['translate'] = tuple(first)
        if kind == 'image':
            keywords['scale'] = tuple(size)
    return results


def skeleton(
    layer: 'napari.layers.Layer',
    threshold: str = 'auto',
    theta2: str = 'inf',
    theta1: str = '0.5r',
    invert: bool = False,
) -> List['napari.types.LayerDataTuple']:
    """Skeleton of an image (values from the threshold on) or of the selected label.

    Parameters
    ----------
    layer : Layer
        Image or labels, of two or three dimensions.
    threshold : str
        Values from this on, or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH. Of images only.
    theta2 : str
        Sheets that matter less are left out: inf (curves only), 3%, 8vox.
    theta1 : str
        Branches that stick out less are left out: 0.5r (radii of what they leave), 8vox.
    invert : bool
        All the rest instead.
    """
    import quench

    array, keywords = chosen(layer, threshold)
    axis = quench.medial_axis(array, invert=invert, **keywords)
    found = axis.skeleton(theta1=theta1) if array.ndim == 2 else axis.skeleton(theta2=theta2, theta1=theta1)
    return on(layer, layers.curves_of(found, f'Skeleton of {layer.name}', flip=array.ndim == 2))


def thickness(
    layer: 'napari.layers.Layer', threshold: str = 'auto', invert: bool = False
) -> List['napari.types.LayerDataTuple']:
    """Local thickness: at every pixel or voxel of the shape the diameter of the largest ball inside that contains it.

    Parameters
    ----------
    layer : Layer
        Image or labels, of two or three dimensions.
    threshold : str
        Values from this on, or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH. Of images only.
    invert : bool
        All the rest instead: pores.
    """
    import quench

    array, keywords = chosen(layer, threshold)
    found = quench.local_thickness(array, invert=invert, **keywords)
    keywords = {
        'name': f'Thickness of {layer.name}',
        'colormap': 'inferno',
        'contrast_limits': (0.0, float(found.max()) or 1.0),
    }
    return on(layer, [(found, keywords, 'image')])


def tree(
    layer: 'napari.layers.Layer', threshold: str = 'thin', kind: str = 'root'
) -> List['napari.types.LayerDataTuple']:
    """One tree, repaired, of roots, neurites, vessels or airways, coloured by level.

    Parameters
    ----------
    layer : Layer
        Image or labels of three dimensions.
    threshold : str
        Values from this on, or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH. Of images only.
    kind : str
        root, neuron, vessel or airway.
    """
    import quench

    array, keywords = chosen(layer, threshold)
    if array.ndim != 3:
        raise ValueError(f'{layer.name} has two dimensions; a tree is of a volume')
    return on(layer, layers.tree_layers(quench.tree(array, kind=kind, **keywords), f'Tree of {layer.name}', flip=False))
