# SPDX-License-Identifier: Apache-2.0
"""Images of two dimensions: where things are, closed forms, pixels, labels, what is no image."""
import json
import math
import struct
import zlib

import numpy as np
import pytest
import quench

SPACING = (2.0, 0.5)  # of rows and columns
SYMMETRIES = [(turns, mirrored) for turns in range(4) for mirrored in (False, True)]


def bar(rows=9, columns=40, gap=2):
    image = np.zeros((rows, columns), bool)
    image[gap:-gap, gap:-gap] = True
    return image


def letter_f():
    """An F with odd strokes, so that its middle lines are in the middle of pixels: no two of its symmetries are the same."""
    image = np.zeros((40, 30), bool)
    image[3:38, 4:9] = image[3:8, 4:27] = image[17:22, 4:19] = True
    return image


def blobs(seed, shape=(40, 31), share=0.6):
    """A random shape with holes and several parts."""
    noise = np.random.default_rng(seed).random((shape[0] + 6, shape[1] + 6))
    smooth = sum(noise[i:i + shape[0], j:j + shape[1]] for i in range(7) for j in range(7))
    return smooth > np.quantile(smooth, share)


def corners(image):
    """Row and column of the corners of pixels whose four pixels are neither all in nor all out; of pixel centres 0, 1 ..."""
    padded = np.pad(image, 1).astype(int)
    count = padded[1:, 1:] + padded[1:, :-1] + padded[:-1, 1:] + padded[:-1, :-1]
    return np.argwhere((count > 0) & (count < 4)) - 0.5


def distance_to(places, points):
    return np.sqrt(((places[:, None, :] - points[None, :, :])**2).sum(axis=2)).min(axis=1)


def parts(mask):
    """How many 8-connected parts."""
    left, count = {tuple(p) for p in np.argwhere(mask)}, 0
    while left:
        count, front = count + 1, [left.pop()]
        while front:
            i, j = front.pop()
            near = left & {(i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1)}
            left -= near
            front.extend(near)
    return count


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ('vertices', 'radius', 'edges'))


def close(a, b):
    """The same but for rounding: of labels, coordinates are computed in their boxes."""
    return np.array_equal(a.edges, b.edges) and np.allclose(a.vertices, b.vertices) and np.allclose(a.radius, b.radius)


def rows(axis, places):
    table = np.round(np.column_stack([places, axis.radius]), 9) + 0.0
    return table[np.lexsort(table.T)]


def png(path, image):
    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    packed = zlib.compress(b''.join(b'\0' + row.tobytes() for row in image.astype(np.uint8)))
    colour = {2: 0, 3: {3: 2, 4: 6}.get(image.shape[-1])}[image.ndim]
    head = struct.pack('>IIBBBBB', image.shape[1], image.shape[0], 8, colour, 0, 0, 0)
    path.write_bytes(b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', head) + chunk(b'IDAT', packed) + chunk(b'IEND', b''))


def test_the_axis_of_a_bar():
    axis = quench.medial_axis(bar(), detail=0)
    assert axis.dimension == 2 and axis.vertices.shape[1] == 2 and axis.topology == (1, (1, 0, 0))
    middle = axis.vertices[:, 1] == 4  # x, y: rows 2 .. 6
    assert np.array_equal(np.sort(axis.vertices[middle, 0]), np.arange(4, 36))
    assert np.allclose(axis.radius[middle], math.hypot(2.5, 0.5))
    diagonals = {(x, y) for a in (2, 3) for x in (a, 39 - a) for y in (a, 8 - a)}
    assert set(map(tuple, axis.vertices[~middle])) == diagonals
    assert len(axis.edges) == len(axis.vertices) - 1 and len(axis.faces) == 0 and not axis.edge_degree.any()
    assert 'polygons' not in repr(axis)
    # Fire from the middles of the pixels in the corners, along the diagonals, then along the bar.
    burned = dict(zip(map(tuple, axis.vertices), axis.burn_time()))
    assert burned[19, 4] == pytest.approx(math.sqrt(0.5) + 2 * math.sqrt(2) + 15)
    assert burned[2, 2] == pytest.approx(math.sqrt(0.5)) and burned[3, 3] == pytest.approx(math.sqrt(4.5))
    assert np.allclose(axis.erosion_thickness(), axis.burn_time() - axis.radius)
    # The two nearest corners of an edge in the middle are above each other, 5 apart.
    across = (axis.vertices[axis.edges][:, :, 1] == 4).all(axis=1)
    assert np.allclose(axis.measures['lambda'].values.edges[across], 2.5) and np.allclose(axis.edge_lambda[across], 2.5)
    assert np.allclose(axis.measures['cap_height'].values.edges[across], math.hypot(2.5, 0.5) - 0.5)
    assert len(axis.measures['mgf'].values.edges) == len(axis.edges)


def test_a_ring_is_a_loop_that_never_burns():
    image = bar(30, 40)
    image[10:-10, 10:-10] = False
    axis = quench.medial_axis(image)
    assert axis.topology == (0, (1, 1, 0))
    assert np.isinf(axis.erosion_thickness()).any()
    skeleton = axis.skeleton(theta1='inf')
    assert skeleton.topology == axis.topology and len(skeleton.vertices) == len(skeleton.edges)
    branches = skeleton.branches()
    assert np.isinf(branches['thickness']).all() and branches['from_kind'].tolist() == ['loop']
    assert quench.medial_axis(image, fill_cavities=True).topology == (1, (1, 0, 0))
    assert quench.medial_axis(~image).topology == (1, (2, 1, 0))


@pytest.mark.parametrize('spacing', [(1, 1), SPACING, (0.75, 1)])
@pytest.mark.parametrize('seed', range(4))
def test_radius_is_the_distance_to_the_nearest_corner(seed, spacing):
    image = blobs(seed)
    axis = quench.medial_axis(image, spacing=spacing, detail=0)
    assert np.allclose(axis.radius, distance_to(axis.vertices, (corners(image) * spacing)[:, ::-1]))
    assert np.allclose(axis.row_col * spacing, axis.vertices[:, ::-1])
    assert image[tuple(np.floor(axis.row_col + 0.5 + 1e-9).astype(int).T)].all()
    assert len(axis.vertices) - len(axis.edges) == axis.topology.euler
    assert axis.longest_side == ((np.ptp(np.argwhere(image), axis=0) + 1) * spacing).max()
    pruned = quench.medial_axis(image, spacing=spacing)
    assert pruned.detail == pytest.approx(np.hypot(*spacing) / 2) and pruned.topology == axis.topology
    assert 0 <= pruned.coverage <= np.hypot(*spacing) * (1 + 1e-9)
    assert same(axis.pruned(f'{pruned.detail!r}abs'), pruned)


@pytest.mark.parametrize('turns, mirrored', SYMMETRIES)
def test_turned_and_mirrored_images(turns, mirrored):
    def turned(image):
        return np.rot90(image.T if mirrored else image, turns)
    for image in (letter_f(), blobs(3), blobs(8, share=0.4)):
        axis, other = (quench.medial_axis(i, detail=0) for i in (image, turned(image)))
        places = np.stack(np.indices(image.shape), axis=-1)
        place = np.stack([turned(places[..., a]) for a in (0, 1)], axis=-1)  # row, column in `image` of each pixel of the other
        steps = np.stack([place[-1, 0] - place[0, 0], place[0, -1] - place[0, 0]]) / (np.array(place.shape[:2]) - 1)[:, None]
        assert np.array_equal(rows(axis, axis.row_col), rows(other, place[0, 0] + other.row_col @ steps))
        if turns == 0:  # what lies between two pixels goes to the later one
            assert np.array_equal(other.to_image(), turned(axis.to_image()))
    mask, distance = quench.medial_axis(turned(letter_f())).skeleton().to_image(return_distance=True)
    wanted = quench.medial_axis(letter_f()).skeleton().to_image(return_distance=True)
    assert np.array_equal(mask, turned(wanted[0])) and np.allclose(distance, turned(wanted[1]))


@pytest.mark.parametrize('layout', ['F', 'reversed', 'strided', 'transposed view', 'offset', 'read-only', 'broadcast'])
def test_the_order_in_memory_does_not_matter(layout):
    image = blobs(1)
    if layout == 'broadcast':
        image = np.broadcast_to(image[20], image.shape)
        assert image.strides[0] == 0
    wanted = quench.medial_axis(np.ascontiguousarray(image), spacing=SPACING)
    given = image.copy()
    if layout == 'F':
        given = np.asfortranarray(image)
    elif layout == 'reversed':
        given = np.ascontiguousarray(image[::-1, ::-1])[::-1, ::-1]
        assert max(given.strides) < 0
    elif layout == 'strided':
        room = np.ones((2 * image.shape[0], 3 * image.shape[1]), bool)
        room[::2, 1::3] = image
        given = room[::2, 1::3]
    elif layout == 'transposed view':
        given = np.ascontiguousarray(image.T).T
    elif layout == 'offset':
        given = np.pad(image, 3, constant_values=True)[3:-3, 3:-3]
    elif layout == 'read-only':
        given.setflags(write=False)
    else:
        given = image
    assert np.array_equal(given, image)
    axis = quench.medial_axis(given, spacing=SPACING)
    assert same(axis, wanted) and np.array_equal(axis.to_image(), wanted.to_image())
    assert same(quench.skeletonize(given, spacing=SPACING)[1], wanted.skeleton())
    assert np.array_equal(axis.reconstruct(), wanted.reconstruct())


@pytest.mark.parametrize('kind', ['b1', 'i1', 'u2', 'i4', 'u8', 'f2', 'f4', 'f8', '>i4', '>f8'])
def test_types(kind):
    image = blobs(2)
    wanted = quench.medial_axis(image)
    assert same(quench.medial_axis(image.astype(kind)), wanted)
    if kind != 'b1':
        scaled = (image * 90 + 5).astype(kind)
        assert same(quench.medial_axis(scaled, threshold=50), wanted)
        assert same(quench.medial_axis(scaled, label=95), wanted)
        assert same(quench.medial_axis(scaled, label=5, invert=True), wanted)


def test_not_a_number_is_background():
    image = np.full((9, 8), np.nan)
    image[2:6, 2:5] = 3
    assert quench.medial_axis(image, threshold=1, detail=0).reconstruct().sum() == 12


@pytest.mark.parametrize('spacing', [(1, 1), SPACING])
@pytest.mark.parametrize('seed', range(4))
def test_pixels_and_distances(seed, spacing):
    image = blobs(seed, share=0.5)
    near = distance_to(np.argwhere(np.ones_like(image)) * spacing, corners(image) * spacing).reshape(image.shape)
    axis = quench.medial_axis(image, spacing=spacing)
    for result in (axis, axis.skeleton(), axis.skeleton(theta1='inf')):
        mask, distance = result.to_image(return_distance=True)
        assert mask.dtype == bool and mask.shape == image.shape and not (mask & ~image).any()
        assert parts(mask) <= axis.topology.betti[0] and mask[tuple(np.floor(result.row_col + 0.5 + 1e-9).astype(int).T)].all()
        assert np.array_equal(distance > 0, mask) and np.array_equal(result.to_image(), mask)
        if result is axis:  # the distance of some place in the pixel; distances are 1-Lipschitz
            assert (np.abs(distance - near)[mask] <= np.hypot(*spacing) / 2 + 1e-6).all()
            assert distance.max() == pytest.approx(axis.radius.max())
        small = result.to_image((20, 15), return_distance=True)
        assert np.array_equal(small[0], mask[:20, :15]) and np.array_equal(small[1], distance[:20, :15])
    with pytest.raises(quench.UsageError, match='3 sides'):
        axis.to_image((3, 4, 5))


@pytest.mark.parametrize('spacing', [(1, 1), SPACING])
@pytest.mark.parametrize('seed', range(3))
def test_results_verify(seed, spacing):
    image = blobs(seed + 30, share=0.5)
    for detail in ('auto', 0):
        axis = quench.medial_axis(image, spacing=spacing, detail=detail)
        assert axis.verify(), axis.verify()
        for theta1 in ('auto', 0, 'inf'):
            assert axis.skeleton(theta1=theta1).verify(), axis.skeleton(theta1=theta1).verify()
    assert len(axis.skeleton(theta1=0).edges) >= len(axis.edges)


def test_labels_of_pixels_are_rows_of_branches():
    skeleton = quench.medial_axis(letter_f()).skeleton()
    labels, distance = skeleton.to_image(labels=True, return_distance=True)
    branches = skeleton.branches()
    assert labels.dtype == np.int32 and set(np.unique(labels)) == set(range(len(branches['length']) + 1))
    assert np.array_equal(labels > 0, skeleton.to_image()) and np.array_equal(distance > 0, labels > 0)
    for b, path in enumerate(skeleton.graph().paths):
        column, row = path[len(path) // 2]
        assert labels[int(row + 0.5 + 1e-9), int(column + 0.5 + 1e-9)] == b + 1
        assert (labels == b + 1).sum() <= branches['length'][b] * 2 + 2


def test_labels():
    image = np.zeros((40, 50), np.uint16)
    image[2:20, 2:9] = 3
    image[2:8, 12:48] = 7
    image[20:36, 20:40] = 65535
    image[26:30, 26:34] = 3
    found = quench.skeletonize(image, spacing=SPACING)
    assert list(found) == [3, 7, 65535]
    for label, skeleton in found.items():
        alone = quench.medial_axis(image, label=label, spacing=SPACING).skeleton()
        assert close(skeleton, alone) and skeleton.topology == alone.topology and skeleton.dimension == 2
        mask = skeleton.to_image()
        assert mask.shape == image.shape and (image[mask] == label).all()
    assert [s.topology.betti for s in found.values()] == [(2, 0, 0), (1, 0, 0), (1, 1, 0)]
    assert same(quench.skeletonize(image, spacing=SPACING, labels=[7])[7], found[7])
    assert same(quench.skeletonize(image == 7, spacing=SPACING)[1], found[7])
    with pytest.raises(quench.Error, match='no pixel of the image has the label 4'):
        quench.skeletonize(image, labels=[4])


def test_geojson(tmp_path):
    image = np.zeros((60, 70), bool)
    image[4:44, 3:33] = letter_f()
    image[50:57, 3:10] = True  # a square: a component that is one point
    image[20:50, 40:65] = True
    image[27:43, 47:58] = False
    skeleton = quench.medial_axis(image, spacing=SPACING).skeleton()
    (tmp_path / 'a.geojson').write_text('old')
    found = skeleton.to_geojson(tmp_path / 'a.geojson')

    def strict(name):
        raise AssertionError(name)
    assert json.loads((tmp_path / 'a.geojson').read_text(), parse_constant=strict) == found
    assert [p.name for p in tmp_path.iterdir()] == ['a.geojson']
    assert found['type'] == 'FeatureCollection' and found['y_axis'] == 'down'
    graph, branches = skeleton.graph(), skeleton.branches()
    lines = [f for f in found['features'] if f['geometry']['type'] == 'LineString']
    points = [f for f in found['features'] if f['geometry']['type'] == 'Point']
    assert len(lines) == len(branches['length']) and len(points) == (graph.nodes['kind'] == 'isolated').sum()
    for b, line in enumerate(lines):
        row = line['properties']
        path = np.array(line['geometry']['coordinates'])
        assert np.array_equal(path, graph.paths[b]) and np.array_equal(row['radius'], graph.radii[b]) and row['branch'] == b
        assert row['length'] == pytest.approx(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
        assert row['min_radius'] == min(row['radius']) <= row['mean_radius'] <= row['max_radius'] == max(row['radius'])
        assert row['thickness'] == (None if np.isinf(branches['thickness'][b]) else branches['thickness'][b])
        assert all(len(row[name]) == len(path) for name in ('radius', 'erosion_thickness', 'mgf'))
        if row['thickness'] is not None:
            assert 0 <= min(row['erosion_thickness']) <= row['thickness'] * (1 + 1e-9)
        pixel = np.floor(path[:, ::-1] / SPACING + 0.5 + 1e-9).astype(int)
        assert image[tuple(pixel.T)].all()
    loop, = [line for line in lines if line['properties']['from_kind'] == 'loop']
    assert loop['geometry']['coordinates'][0] == loop['geometry']['coordinates'][-1]
    assert loop['properties']['thickness'] is None and loop['properties']['tortuosity'] is None
    assert set(loop['properties']['erosion_thickness']) == set(loop['properties']['mgf']) == {None}
    point, = points
    assert point['properties']['kind'] == 'isolated' and np.allclose(point['geometry']['coordinates'], [6 * 0.5, 53 * 2])
    smooth = skeleton.graph(smooth=0, resample='3vox')
    assert [len(path) for path in smooth.paths] == [len(values) for values in smooth.mgf] == [len(r) for r in smooth.radii]
    skeleton.save(tmp_path / 'b.geojson')
    assert (tmp_path / 'b.geojson').read_bytes() == (tmp_path / 'a.geojson').read_bytes()
    axis = quench.medial_axis(image)
    whole = axis.to_geojson()
    assert sum(len(f['geometry']['coordinates']) for f in whole['features']) > len(axis.vertices)
    with pytest.raises(quench.Error, match='cannot write.*does not exist'):
        skeleton.to_geojson(tmp_path / 'no' / 'a.geojson')


def test_a_file_of_an_image_gives_what_its_array_gives(tmp_path):
    image = (letter_f() * 200).astype(np.uint8)
    png(tmp_path / 'f.png', image)
    volume = quench.read(tmp_path / 'f.png')
    assert np.array_equal(volume.array, image) and volume.shape == image.shape and repr(volume).startswith('Image of (40, 30)')
    assert volume.spacing.tolist() == [1, 1] and volume.origin.tolist() == [0, 0] and volume.array.flags.c_contiguous
    wanted = quench.medial_axis(image, threshold=100, spacing=SPACING)
    for source in (tmp_path / 'f.png', str(tmp_path / 'f.png'), volume, quench.read(tmp_path / 'f.png', spacing=SPACING)):
        axis = quench.medial_axis(source, threshold=100, spacing=SPACING)
        assert same(axis, wanted) and np.array_equal(axis.to_image(), wanted.to_image())
        assert axis.skeleton().to_geojson()['y_axis'] == 'down'
    assert quench.read(tmp_path / 'f.png', spacing=SPACING).spacing.tolist() == list(SPACING)
    assert np.allclose(volume.origin + (volume.direction @ (volume.spacing * [7, 3])), [3, 7])  # of row 7, column 3
    assert close(quench.skeletonize(tmp_path / 'f.png', spacing=SPACING)[200], wanted.skeleton())
    for bad in ((1, 2, 3), (1, 2, 2), (1,)):
        with pytest.raises(quench.UsageError, match='pixel size; give one positive number|three numbers') as caught:
            quench.medial_axis(tmp_path / 'f.png', threshold=100, spacing=bad)
        assert caught.value.argument == 'spacing'


def test_channels_and_dimensions_of_files(tmp_path):
    colours = np.random.default_rng(1).integers(0, 256, (40, 30, 4), np.uint8)
    for image in (colours, colours[..., :3]):
        png(tmp_path / 'c.png', np.ascontiguousarray(image))
        for channel in ('luminance', 'red', 'green', 'blue', 'alpha')[:image.shape[2] + 1]:
            read = quench.read(tmp_path / 'c.png', channel=channel)
            assert read.array.dtype == np.uint8
            for threshold in (64, 128, 200):
                assert same(quench.medial_axis(image, channel=channel, threshold=threshold),
                            quench.medial_axis(read, threshold=threshold))
    with pytest.raises(quench.UsageError, match='alpha'):
        quench.read(tmp_path / 'c.png', channel='alpha')
    np.save(tmp_path / 'plane.npy', letter_f())
    np.save(tmp_path / 'slice.npy', letter_f()[None])
    wanted = quench.medial_axis(letter_f())
    assert same(quench.medial_axis(tmp_path / 'plane.npy'), wanted)
    for call in (quench.read, quench.medial_axis, quench.skeletonize):
        with pytest.raises(quench.UsageError, match='one slice|dimension') as caught:
            call(tmp_path / 'slice.npy')
        assert caught.value.argument == 'dimension'
    assert same(quench.medial_axis(tmp_path / 'slice.npy', dimension=2), wanted)
    assert quench.read(tmp_path / 'slice.npy', dimension=3).array.shape == (30, 40, 1)
    with pytest.raises(quench.UsageError, match='are for images'):
        quench.medial_axis(([[0, 0, 0]], [[0, 0, 0]]), dimension=2)


def test_results_in_files(tmp_path):
    axis = quench.medial_axis(letter_f(), spacing=SPACING)
    skeleton = axis.skeleton()
    axis.save(tmp_path / 'axis.vtp')
    again = quench.read(tmp_path / 'axis.vtp')
    assert same(again, axis) and again.dimension == 2 and again.detail == axis.detail
    assert np.array_equal(again.erosion_thickness(), axis.erosion_thickness())
    # Without the shape, which says what is inside, branches are smoothed less.
    assert np.array_equal(again.skeleton(theta1='1vox').edges, axis.skeleton(theta1='1vox').edges)
    with pytest.raises(quench.Error, match='does not hold the image'):
        again.to_image()
    for name in ('s.vtp', 's.swc', 's.graphml', 's.csv', 's.geojson'):
        skeleton.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize('bad, code, word', [
    (np.ones((0, 4)), 3, 'no pixels'), (np.ones((4, 0), bool), 3, 'no pixels'), (np.zeros((4, 5)), 3, 'no voxel|no pixel'),
    (np.full((4, 5), np.nan), 3, 'NaN'), (np.arange(12).reshape(3, 4), 2, 'more than two values'),
    (np.ones((4, 4), complex), 3, 'complex'), (np.full((4, 4), 'a'), 3, 'type'), (np.ones(7), 3, '1 dimensions')])
def test_images_that_are_none(bad, code, word):
    with pytest.raises(quench.Error, match=word) as caught:
        quench.medial_axis(bad)
    assert caught.value.code == code


@pytest.mark.parametrize('sides', [(1, 1), (1, 9), (9, 1), (4, 6)])
def test_images_that_are_all_foreground(sides):
    image = np.ones(sides, bool)
    axis = quench.medial_axis(image, detail=0)
    assert axis.topology.betti == (1, 0, 0) and axis.skeleton(theta1='inf').topology == axis.topology
    assert np.array_equal(axis.reconstruct(), image) and axis.to_image().any()
    if sides == (1, 1):
        assert axis.vertices.tolist() == [[0, 0]] and axis.radius[0] == pytest.approx(math.sqrt(0.5))
        point, = axis.skeleton().to_geojson()['features']
        assert point['geometry'] == {'type': 'Point', 'coordinates': [0, 0]}
        labels = axis.skeleton().to_image(labels=True)
        assert labels.tolist() == [[0]]


def test_one_slice_is_asked_for():
    plane = letter_f()
    wanted = quench.medial_axis(plane)
    for axis, slice_, text in ((0, plane[None], r'image\[0\]'), (1, plane[:, None], r'image\[:, 0\]'),
                               (2, plane[..., None], r'image\[..., 0\]')):
        for call in (quench.medial_axis, quench.skeletonize):
            with pytest.raises(ValueError, match=text + '.*dimension=3') as caught:
                call(slice_)
            assert caught.value.argument == 'dimension'
        assert same(quench.medial_axis(slice_, dimension=2), wanted)
        thick = quench.medial_axis(slice_, dimension=3)
        assert thick.dimension == 3 and np.ptp(thick.vertices[:, axis]) == 0
    assert same(quench.skeletonize(plane[None], dimension=2)[1], wanted.skeleton())
    for image, dimension in ((plane, 3), (np.ones((5, 6, 7), bool), 2), (plane, 4)):
        with pytest.raises(quench.UsageError, match=f'^dimension={dimension}'):
            quench.medial_axis(image, dimension=dimension)


def test_colours_are_asked_for():
    shape = letter_f()
    colours = np.zeros((*shape.shape, 4), np.uint8)
    colours[..., :3] = (250, 240, 230)
    colours[shape, :3] = (10, 200, 30)
    colours[..., 3] = 255
    wanted = quench.medial_axis(shape)
    for image in (colours, colours[..., :3], colours / 255):
        with pytest.raises(ValueError, match='choose a channel') as caught:
            quench.medial_axis(image, threshold=100)
        assert caught.value.argument == 'channel'
    for channel, low, high in (('red', 10, 250), ('green', 200, 240), ('blue', 30, 230), ('luminance', 124, 242)):
        for image, white in ((colours, 1), (colours[..., :3], 1), (colours.astype(np.uint16) * 257, 257),
                             (colours / 255, 1 / 255)):
            cut = (low + high) / 2 * white
            assert same(quench.medial_axis(image, channel=channel, threshold=cut, invert=True), wanted)
            assert len(quench.medial_axis(image, channel=channel, threshold=(low - 1) * white).vertices)
            with pytest.raises(quench.Error, match='no voxel|no pixel'):
                quench.medial_axis(image, channel=channel, threshold=(high + 1) * white)
    clear = colours.copy()
    clear[~shape, 3] = 0  # white where it is transparent
    assert same(quench.medial_axis(clear, channel='alpha'), wanted)
    assert same(quench.medial_axis(clear, channel='luminance', threshold=250, invert=True), wanted)
    for bad, channel in ((shape, 'red'), (colours[..., :3], 'alpha'), (colours, 'grey'), (colours[..., :2], 'red')):
        with pytest.raises(quench.UsageError, match=f'^channel={channel!r}'):
            quench.medial_axis(bad, channel=channel)
    with pytest.raises(quench.UsageError, match='give one of them'):
        quench.medial_axis(colours, channel='red', dimension=3)
    assert quench.medial_axis(np.ones((9, 9, 3), np.uint8), dimension=3).dimension == 3


def test_what_only_volumes_or_images_have():
    axis, volume = quench.medial_axis(letter_f()), quench.medial_axis(np.ones((9, 8, 7), bool))
    skeleton = axis.skeleton()
    assert math.isinf(skeleton.theta2) and skeleton.theta1_radii == 0.5 and same(axis.skeleton('inf'), skeleton)
    for call in (lambda: axis.skeleton(theta2=0.03), lambda: axis.skeleton(0),
                 lambda: quench.skeletonize(letter_f(), theta2='2vox')):
        with pytest.raises(quench.UsageError, match='theta1') as caught:
            call()
        assert caught.value.argument == 'theta2'
    with pytest.raises(quench.UsageError, match='^omega='):
        axis.burn_time(omega='1vox')
    for call in (skeleton.to_volume, skeleton.to_trimesh, axis.to_trimesh):
        with pytest.raises(quench.UsageError, match='of images there is'):
            call()
    for call in (volume.to_image, volume.to_geojson, volume.skeleton().to_image, volume.skeleton().to_geojson,
                 lambda: volume.row_col):
        with pytest.raises(quench.UsageError, match='is of images of two dimensions'):
            call()
    with pytest.raises(quench.Error, match="surface.*'voxels'"):
        quench.medial_axis(letter_f(), surface='smooth')
    for bad in (0, (1, 2, 3), (1, 0), 'x', math.nan):
        with pytest.raises(quench.UsageError, match='pixel size') as caught:
            quench.medial_axis(letter_f(), spacing=bad)
        assert caught.value.argument == 'spacing'


def test_threads_and_subdivision():
    image = blobs(5, (90, 120))
    axis = quench.medial_axis(image, threads=1)
    assert same(axis, quench.medial_axis(image, threads=2))
    assert same(axis.skeleton(threads=1), axis.skeleton(threads=2))
    fine = quench.medial_axis(letter_f(), subdivide=3, detail=0)
    assert fine.topology.betti == (1, 0, 0) and fine.to_image().shape == (40, 30)
    assert not (fine.to_image() & ~letter_f()).any() and np.array_equal(fine.reconstruct(), letter_f())
    assert np.abs(fine.radius.max() - quench.medial_axis(letter_f(), detail=0).radius.max()) < 0.5


def test_plots_lie_on_the_image():
    matplotlib = pytest.importorskip('matplotlib')
    matplotlib.use('Agg')
    from matplotlib import pyplot
    axis = quench.medial_axis(letter_f())
    for result in (axis, axis.skeleton(), quench.medial_axis(np.ones((1, 1), bool))):
        alone = result.plot()
        low, high = alone.get_ylim()
        assert low > high or len(result.edges) == 0  # y grows downwards
        over = pyplot.figure().add_subplot()
        over.imshow(letter_f())
        limits = over.get_xlim(), over.get_ylim()
        assert result.plot(over) is over and (over.get_xlim(), over.get_ylim()) == limits
        pyplot.close('all')


def test_pictures_and_pages(tmp_path):
    skeleton = quench.medial_axis(letter_f()).skeleton()
    results = {'axis': skeleton.axis, 'skeleton': skeleton, 'label': quench.skeletonize(letter_f())[1]}
    for name, result in results.items():
        result.save(tmp_path / f'{name}.png')
        assert (tmp_path / f'{name}.png').read_bytes().startswith(b'\x89PNG')
        if quench._core.has_pages:
            result.save(tmp_path / f'{name}.html')
            assert b'</html>' in (tmp_path / f'{name}.html').read_bytes()


def test_tables_and_networkx():
    networkx = pytest.importorskip('networkx')
    graph = quench.medial_axis(letter_f(), spacing=SPACING).skeleton().graph()
    assert set(graph.nodes) >= {'x', 'y', 'radius', 'kind'} and 'z' not in graph.nodes
    assert {'from_x', 'from_y', 'to_x', 'to_y'} <= set(graph.branches) and 'to_z' not in graph.branches
    assert all(path.shape[1] == 2 for path in graph.paths)
    made = graph.to_networkx()
    assert networkx.number_connected_components(made) == 1 and made.number_of_edges() == len(graph.paths)


def test_the_thinnest_branch_is_measured_in_pixels():
    image = np.zeros((60, 100), bool)
    image[10:21, 10:90] = image[10:50, 40:51] = True
    assert quench.medial_axis(image).skeleton().theta1 == pytest.approx(4.5 * np.sqrt(2) / 2)
    assert quench.medial_axis(image, spacing=(2, 0.5)).skeleton().theta1 == pytest.approx(4.5 * np.hypot(2, 0.5) / 2)
