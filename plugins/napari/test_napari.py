# SPDX-License-Identifier: Apache-2.0
"""The plug-in without napari, which Debian does not have: the manifest against what npe2 documents (by npe2 itself where it
is installed), the reader on files, the widgets' functions on layers that are stand-ins."""
import importlib
import importlib.util
import inspect
import os
import re
import shutil
import subprocess
import sys
import tempfile
from types import SimpleNamespace

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.environ.get('QUENCH') or shutil.which('quench')
# What viewer.add_KIND() documents, of what is used.
KEYWORDS = {
    'image': {'name', 'scale', 'translate', 'affine', 'colormap', 'contrast_limits'},
    'vectors': {'name', 'scale', 'translate', 'affine', 'features', 'edge_color', 'edge_width', 'edge_colormap', 'vector_style'},
    'surface': {'name', 'scale', 'translate', 'affine', 'colormap', 'contrast_limits', 'shading'},
}


class Layer(SimpleNamespace):
    """Stands for napari.layers.Layer: first its scale and translation, then its affine matrix."""

    def __init__(self, **more):
        dimensions = np.ndim(more['data'])
        super().__init__(
            **{
                'scale': np.ones(dimensions),
                'translate': np.zeros(dimensions),
                'affine': np.eye(dimensions + 1),
                **more,
            }
        )

    def data_to_world(self, position):
        return tuple((self.affine @ np.append(np.asarray(position) * self.scale + self.translate, 1))[:-1])


class Image(Layer):
    """Stands for napari.layers.Image."""


class Labels(Layer):
    """Stands for napari.layers.Labels."""


def shown(keywords, points):
    """Where napari shows points of a layer."""
    dimensions = points.shape[1]
    moved = points * keywords.get('scale', np.ones(dimensions)) + keywords.get('translate', np.zeros(dimensions))
    affine = np.asarray(keywords.get('affine', np.eye(dimensions + 1)))
    return moved @ affine[:-1, :-1].T + affine[:-1, -1]


def check_manifest():
    import yaml

    file = os.path.join(HERE, 'napari_quench', 'napari.yaml')
    with open(file, encoding='utf-8') as opened:
        manifest = yaml.safe_load(opened)
    with open(os.path.join(HERE, 'pyproject.toml'), encoding='utf-8') as opened:
        project = opened.read()
    assert set(manifest) <= {'name', 'display_name', 'schema_version', 'visibility', 'contributions'}
    assert f'name = "{manifest["name"]}"' in project and f'{manifest["name"]} = "napari_quench:napari.yaml"' in project
    shown = r'[^\W_][\w -~:.\'"]{1,88}[^\W_]'
    assert re.fullmatch(shown, manifest['display_name']) and re.fullmatch(r'\d+\.\d+\.\d+', manifest['schema_version'])
    contributions = manifest['contributions']
    assert set(contributions) <= {
        'commands',
        'readers',
        'widgets',
        'writers',
        'sample_data',
        'themes',
        'menus',
        'keybindings',
    }
    commands = {}
    for command in contributions['commands']:
        assert set(command) <= {'id', 'title', 'python_name', 'short_title', 'icon', 'enablement'} and command['title']
        assert re.fullmatch(re.escape(manifest['name']) + r'\.[A-Za-z_]\w*', command['id'])
        module, _, name = command['python_name'].partition(':')
        commands[command['id']] = getattr(importlib.import_module(module), name)
    for reader in contributions['readers']:
        assert set(reader) <= {'command', 'filename_patterns', 'accepts_directories'} and reader['command'] in commands
        assert all(pattern.startswith('*.') for pattern in reader['filename_patterns'])
        for pattern in reader['filename_patterns']:
            assert commands[reader['command']](pattern.replace('*', 'file')), pattern
    for widget in contributions['widgets']:
        assert set(widget) <= {'command', 'display_name', 'autogenerate'} and re.fullmatch(
            shown, widget['display_name']
        )
        for parameter in inspect.signature(
            commands[widget['command']]
        ).parameters.values():  # what magicgui makes fields of
            assert parameter.annotation in (str, bool, float, int, 'napari.layers.Layer'), parameter
            assert parameter.annotation == 'napari.layers.Layer' or isinstance(parameter.default, parameter.annotation)
    if importlib.util.find_spec('npe2'):
        from npe2 import PluginManifest

        PluginManifest.from_file(file).validate_imports()
        return 'by npe2, too'
    return 'npe2 is not installed: its documented rules only'


def check_layers(found, dimensions):
    """LayerData as napari documents it."""
    assert isinstance(found, list) and found
    for data, keywords, kind in found:
        assert set(keywords) <= KEYWORDS[kind], set(keywords) - KEYWORDS[kind]
        if kind == 'vectors':
            assert data.ndim == 3 and data.shape[1:] == (2, dimensions) and np.isfinite(data).all()
            assert all(len(column) == len(data) for column in keywords['features'].values())
            assert keywords['edge_color'] in keywords['features']
        elif kind == 'surface':
            vertices, faces, values = data
            assert (
                vertices.shape[1] == dimensions and faces.shape[1] == 3 and faces.max() < len(vertices) == len(values)
            )
            assert np.isfinite(values).all()
        else:
            assert data.ndim == dimensions
    return {kind for _, _, kind in found}


def inside(vectors, shape, scale=1.0, translate=0.0):
    """The share of segments that begin in the shape, as napari would show both."""
    at = np.rint((vectors[:, 0] - translate) / scale).astype(int)
    at = np.clip(at, 0, np.array(shape.shape) - 1)
    return shape[tuple(at.T)].mean()


def wider(shape):
    """The shape and the voxels around it."""
    padded = np.pad(shape, 1)
    return np.any(
        [padded[tuple(slice(d, d + n) for d, n in zip(step, shape.shape))] for step in np.ndindex(3, 3, 3)], axis=0
    )


def check_places(folder, reader, widgets):
    """Results lie on volumes that a file has moved and turned, and have their lengths in the world."""
    from napari_quench import layers

    array = np.zeros((40, 30, 20), np.uint8)  # x, y, z
    array[2:38, 9:20, 8:11] = 200
    half = np.sqrt(0.5)
    turned = np.array([[half, -half, 0], [half, half, 0], [0, 0, 1]])
    for name, direction in (('straight', np.eye(3)), ('turned', turned)):
        vectors = ' '.join('(%r,%r,%r)' % tuple(axis) for axis in (direction * [0.5, 0.5, 2.0]).T.tolist())
        with open(f'{folder}/{name}.nrrd', 'wb') as file:
            file.write(
                b'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 40 30 20\nencoding: raw\nspace dimension: 3\n'
                + f'space directions: {vectors}\nspace origin: (30,-20,5)\n\n'.encode()
                + array.tobytes(order='F')
            )
        ((data, keywords, kind),) = reader.read(f'{folder}/{name}.nrrd')
        assert kind == 'image' and ('affine' in keywords) == (name == 'turned'), keywords
        corner = shown(keywords, np.array([[3.0, 7.0, 11.0]]))[0]  # z, y, x
        assert np.allclose(corner[::-1], np.array([30, -20, 5]) + direction @ np.array([5.5, 3.5, 6.0])), corner
        layer = Image(**{'data': data, **keywords})
        first = np.array(layer.data_to_world(np.zeros(3)))
        world = np.linalg.inv(np.stack([layer.data_to_world(axis) - first for axis in np.eye(3)], 1))
        for found in (widgets.skeleton(layer, threshold='100'), widgets.skeleton(layer, threshold='100', theta2='0.1abs')):
            check_layers(found, 3)
            for points, keywords, kind in found:
                places = points[:, 0] if kind == 'vectors' else points[0]
                index = (shown(keywords, places) - first) @ world.T
                assert (data[tuple(np.rint(index).astype(int).T)] == 200).all(), f'{name}: a skeleton leaves its volume'
        ((data, keywords, kind),) = widgets.thickness(layer, threshold='100')
        assert 5 < data.max() < 7, data.max()  # 11 voxels of 0.5, 3 of 2
        assert np.allclose(shown(keywords, np.eye(3)), [layer.data_to_world(axis) for axis in np.eye(3)])
    picture = SimpleNamespace(
        array=np.zeros((4, 6)), spacing=[2.0, 0.5], origin=[10.0, 20.0], direction=[[0, 1], [1, 0]]
    )
    ((data, keywords, kind),) = layers.volume_layer(picture, 'picture')
    assert np.allclose(shown(keywords, np.array([[1.0, 2.0]])), [[22, 11]]) and 'affine' not in keywords
    # The same place, once as a scale, once as a matrix: the same lengths, as another plug-in may have it.
    image = np.where(np.abs(np.indices((60, 90))[0] - 30) < 9, 200, 5).astype(np.uint8)
    scaled = Image(name='bar', data=image, scale=np.array([0.5, 0.5]), affine=np.diag([2.0, 2.0, 1.0]))
    ((data, keywords, _),) = widgets.thickness(scaled, threshold='100')
    assert abs(data.max() - 17) < 1.2 and np.allclose(shown(keywords, np.eye(2)), np.eye(2)), data.max()


def main():
    if importlib.util.find_spec('yaml') is None:
        print('there is no PyYAML (Debian: python3-yaml)')
        sys.exit(77)
    sys.path.insert(0, HERE)
    print('manifest:', check_manifest())
    from napari_quench import reader, widgets

    folder = tempfile.mkdtemp(prefix='quench-napari-')
    try:
        run = lambda *words: subprocess.run(
            [PROGRAM, *words, '--quiet'], check=True, cwd=folder, stdout=subprocess.DEVNULL
        )
        run('sample', 'root', '--branches', '12', '--resolution', '96', '-o', 'root.nrrd')
        run('tree', 'root.nrrd', '--no-view', '--no-picture', '-o', 'tree')
        run('sample', 'fin-on-board', '--fineness', '0.1', '-o', 'part.ply')
        run('run', 'part.ply', '--resolution', '48', '--no-view', '--no-picture', '-o', 'part')
        read = lambda name: reader.get_reader(f'{folder}/{name}')(f'{folder}/{name}')
        assert 'surface' in check_layers(read('part/core.vtp'), 3)
        assert 'surface' in check_layers(read('part/skeleton.vtp'), 3)
        ((volume, keywords, kind),) = read('root.nrrd')
        assert kind == 'image' and volume.shape == tuple(reversed(np.asarray(read_volume(f'{folder}/root.nrrd')).shape))
        for name in ('tree/tree.swc', 'tree/tree.rsml'):
            found = read(name)
            assert check_layers(found, 3) == {'vectors'} and len(np.unique(found[0][1]['features']['level'])) > 1
            place = (found[0][0][:, 0] - keywords['translate']) / keywords['scale']
            index = np.rint(place).astype(int)
            share = wider(volume.astype(bool))[tuple(np.clip(index, 0, np.array(volume.shape) - 1).T)].mean()
            assert share == 1, f'{name}: {share:.2f} of its points lie within a voxel of the volume it is of'
        assert reader.get_reader('picture.png') is None and reader.get_reader(['a.swc', 'b.swc']) is None
        print('reader: a medial axis, a skeleton, trees that lie in their volume')

        row, column = np.indices((80, 120))
        bar = (abs(row - 30) < 9) & (column > 8) & (column < 110)
        layer = Image(
            name='bar',
            data=np.where(bar, 200, 5).astype(np.uint8),
            scale=np.array([0.5, 0.5]),
            translate=np.array([7.0, 3.0]),
        )
        found = widgets.skeleton(layer, threshold='100')
        assert check_layers(found, 2) == {'vectors'}
        data, keywords, _ = found[0]
        assert inside(data, bar, 0.5) == 1 and tuple(keywords['translate']) == (7, 3)
        assert abs(keywords['features']['radius'].max() - 4.25) < 0.3  # 17 pixels of 0.5
        ((data, keywords, kind),) = widgets.thickness(layer, threshold='100')
        assert kind == 'image' and data.shape == bar.shape and (data > 0)[bar].all() and not data[~bar].any()
        assert abs(data.max() - 8.5) < 0.6 and tuple(keywords['scale']) == (0.5, 0.5)
        ball = np.hypot(np.hypot(*(np.indices((24, 40, 60))[1:] - np.array([20, 30]).reshape(2, 1, 1, 1))), 0) < 8
        labels = Labels(
            name='two',
            data=np.where(ball, 3, 1),
            scale=np.array([2.0, 1.0, 1.0]),
            translate=np.zeros(3),
            selected_label=3,
        )
        found = widgets.skeleton(labels)
        assert check_layers(found, 3) == {'vectors'} and inside(found[0][0], ball, np.array([2.0, 1.0, 1.0])) == 1
        grown = widgets.tree(
            Image(name='root', data=volume * np.uint8(90), scale=np.ones(3), translate=np.zeros(3)), threshold='50'
        )
        assert check_layers(grown, 3) == {'vectors'} and inside(grown[0][0], wider(volume.astype(bool))) == 1
        check_places(folder, reader, widgets)
        for wrong in (
            Image(name='film', data=np.zeros((2, 3, 4, 5)), scale=np.ones(4), translate=np.zeros(4)),
            Image(name='sheared', data=np.eye(30), affine=np.array([[1, 0.3, 0], [0, 1, 0], [0, 0, 1]])),
            Image(name='dark', data=np.zeros((30, 30), np.uint8), scale=np.ones(2), translate=np.zeros(2)),
        ):
            try:
                widgets.skeleton(wrong, threshold='100')
            except Exception as error:
                assert len(str(error)) > 20
            else:
                raise AssertionError(f'{wrong.name}: no error')
        print('widgets: skeleton, thickness and tree lie on their layers')
        print(
            'napari itself is not in Debian: nothing was shown'
            if not importlib.util.find_spec('napari')
            else 'napari is here'
        )
    finally:
        shutil.rmtree(folder)


def read_volume(file):
    import quench

    return quench.read(file).array


if __name__ == '__main__':
    main()
