# SPDX-License-Identifier: Apache-2.0
"""Results of Quench as layers of napari: tuples of data, what add_LAYER() takes, and the kind of layer.

Arrays of napari are image[row, column] or volume[z, y, x], and so are the places in its layers."""
import numpy as np


def lines(starts, ends, radius, name, level=None):
    """A layer of vectors, one per segment, coloured by radius or level."""
    data = np.stack([starts, np.asarray(ends) - starts], axis=1).astype(np.float32)
    features = {'radius': np.asarray(radius, float)}
    if level is not None:
        features['level'] = np.asarray(level)
    wide = float(np.median(features['radius'])) / 2 if len(data) else 1.0
    return (
        data,
        {
            'name': name,
            'features': features,
            'edge_color': 'level' if level is not None else 'radius',
            'edge_width': wide or 1.0,
            'edge_colormap': 'turbo' if level is not None else 'viridis',
            'vector_style': 'line',
        },
        'vectors',
    )


def surface(vertices, faces, values, name):
    """A layer of triangles, coloured by a value per vertex."""
    values = np.asarray(values, float)
    finite = values[np.isfinite(values)]
    largest = float(finite.max()) if len(finite) else 1.0
    values = np.where(np.isfinite(values), values, largest)
    return (
        (np.asarray(vertices, np.float32), np.asarray(faces), values.astype(np.float32)),
        {'name': name, 'colormap': 'viridis', 'contrast_limits': (0.0, largest or 1.0), 'shading': 'smooth'},
        'surface',
    )


def curves_of(result, name, flip):
    """The curves of a skeleton as lines, its sheets as a surface; `flip`: places are x, y(, z)."""
    order = slice(None, None, -1) if flip else slice(None)
    layers = []
    if len(result.curves.edges):
        ends = result.curves.vertices[result.curves.edges][:, :, order]
        layers.append(lines(ends[:, 0], ends[:, 1], result.curves.radius[result.curves.edges].mean(axis=1), name))
    if len(result.sheets.faces):
        layers.append(
            surface(
                result.sheets.vertices[:, order],
                result.sheets.faces,
                result.sheets.erosion_thickness,
                f'{name}: sheets',
            )
        )
    return layers


def axis_layers(axis, name, flip=True):
    """A medial axis: its faces as a surface, edges without faces as lines."""
    order = slice(None, None, -1) if flip else slice(None)
    layers = []
    if len(axis.faces):
        layers.append(surface(axis.vertices[:, order], axis.faces, axis.erosion_thickness(), name))
    bare = axis.edges[np.asarray(axis.edge_degree) == 0] if len(axis.edges) else axis.edges
    if len(bare):
        ends = axis.vertices[bare][:, :, order]
        layers.append(lines(ends[:, 0], ends[:, 1], axis.radius[bare].mean(axis=1), f'{name}: curves'))
    return layers


def tree_layers(tree, name, flip=True):
    """A tree: a line per piece of its branches, coloured by the level of their axes."""
    order = slice(None, None, -1) if flip else slice(None)
    starts, ends, radius, level = [], [], [], []
    for branch in tree.branches:
        points = np.asarray(branch.points)[:, order]
        starts.append(points[:-1])
        ends.append(points[1:])
        radius.append((branch.radius[:-1] + branch.radius[1:]) / 2)
        level.append(np.full(len(points) - 1, tree.axes[branch.axis].level))
    if not starts:
        return []
    return [lines(np.concatenate(starts), np.concatenate(ends), np.concatenate(radius), name, np.concatenate(level))]


def volume_layer(volume, name):
    """A volume or an image at its place in the world: a scale and a translation, or a matrix where its axes are turned."""
    array = np.asarray(volume.array)
    columns = slice(None) if array.ndim == 2 else slice(None, None, -1)  # of an image y, x already
    direction = np.asarray(volume.direction)[::-1, columns]  # its rows are x, y(, z)
    scale, translate = np.asarray(volume.spacing)[columns], np.asarray(volume.origin)[::-1]
    keywords = {'name': name}
    if np.allclose(direction, np.eye(array.ndim)):
        keywords.update(scale=tuple(scale), translate=tuple(translate))
    else:
        keywords['affine'] = np.eye(array.ndim + 1)
        keywords['affine'][:-1, :-1], keywords['affine'][:-1, -1] = direction * scale, translate
    return [(array if array.ndim == 2 else array.transpose(2, 1, 0), keywords, 'image')]
