# SPDX-License-Identifier: Apache-2.0
"""Sheets, seams and junctions; their files as VTK reads them."""
import csv
import os
import subprocess

import numpy as np
import pytest
import quench

vtk = pytest.importorskip('vtk')
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

PROGRAM = os.environ.get('QUENCH_PROGRAM', '')


def t_of_plates():
    image = np.zeros((44, 50, 34), bool)
    image[4:-4, 4:-4, 4:10] = True
    image[19:25, 4:-4, 4:-4] = True
    return image


def hollow_ball():
    x = np.indices((36, 36, 36)) - 17.5
    r = np.sqrt((x**2).sum(axis=0))
    return (r < 16) & (r > 9)


@pytest.fixture(scope='module')
def parts():
    return quench.medial_axis(t_of_plates(), surface='voxels').skeleton().parts(remesh='2vox')


def areas_of(vertices, faces):
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def triangles_of(data):
    cells = vtk_to_numpy(data.GetPolys().GetConnectivityArray())
    assert data.GetNumberOfPolys() * 3 == len(cells)
    return cells.reshape(-1, 3)


def edges_that_are(data, **wanted):
    """The number of edges of one triangle (boundary=True), of three or more (manifold=False) that VTK finds."""
    edges = vtk.vtkFeatureEdges()
    edges.SetInputData(data)
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.SetBoundaryEdges(wanted.get('boundary', False))
    edges.SetNonManifoldEdges(not wanted.get('manifold', True))
    edges.Update()
    return edges.GetOutput().GetNumberOfLines()


def read(reader, path):
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, text=True)


def test_a_t_is_three_sheets_on_a_seam(parts):
    assert list(parts.sheets['sheet'][:1]) and len(parts.seams['seam']) >= 1
    large = parts.sheets['area'] > 0.2 * parts.sheets['area'].max()
    assert large.sum() == 3 and (np.diff(parts.sheets['area']) <= 0).all()
    main = parts.seams['length'].argmax()
    assert 34 < parts.seams['length'][main] < 46 and len(parts.seams['sheets'][main]) == 3
    assert sorted(parts.seams['sheets'][main]) == sorted(parts.sheets['sheet'][large])
    # Six voxels thick, and half a voxel of the staircase on both sides.
    assert np.allclose(parts.sheets['mean_thickness'][large], 7, atol=0.6)
    assert (parts.sheets['flatness'][large] < 0.6).all() and (parts.sheets['euler'][large] == 1).all()
    assert repr(parts).startswith('Parts: ')


def test_meshes_are_those_of_the_table(parts):
    for row, number in enumerate(parts.sheets['sheet']):
        mesh = parts.meshes[number]
        assert np.allclose(mesh.vertices, parts.vertices[mesh.point])
        assert np.allclose(mesh.thickness, 2 * (mesh.radius + 0.5)) and len(mesh.erosion_thickness) == len(mesh.radius)
        own = areas_of(parts.vertices, parts.faces[parts.face_sheet == number]).sum()
        assert areas_of(mesh.vertices, mesh.faces).sum() == pytest.approx(own)
        assert own == pytest.approx(parts.sheets['area'][row], rel=0.1, abs=1)
    # What two sheets have in common is the seam, and only that.
    main = parts.seams['length'].argmax()
    on_seam = set(parts.seam_edges[parts.edge_seam == main].ravel())
    for number in parts.seams['sheets'][main]:
        assert on_seam <= set(parts.meshes[number].point)


def test_triangles_are_even(parts):
    corners = parts.vertices[parts.faces]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert 1.6 < np.median(lengths) < 2.4
    assert areas_of(parts.vertices, parts.faces).min() > 0


def test_a_hollow_ball_has_a_closed_sheet():
    parts = quench.medial_axis(hollow_ball()).skeleton().parts(remesh='2vox')
    assert parts.sheets['borders'][0] == 0 and parts.sheets['euler'][0] == 2 and parts.sheets['orientable'][0] == 1
    mesh = parts.meshes[parts.sheets['sheet'][0]]
    assert parts.sheets['mean_thickness'][0] == pytest.approx(7, abs=0.8)
    assert areas_of(mesh.vertices, mesh.faces).sum() == pytest.approx(4 * np.pi * 12.5**2, rel=0.05)


def test_images_have_no_sheets():
    with pytest.raises(quench.Error, match='images'):
        quench.medial_axis(np.pad(np.ones((9, 20), bool), 2)).skeleton().parts()
    with pytest.raises(quench.Error):
        quench.medial_axis(t_of_plates()).skeleton().parts(remesh=0)


def test_files_of_all_sheets(parts, tmp_path):
    for name in ('p.vtp', 'p.vtu', 'p.ply', 'p.obj', 'p.stl', 'p.csv'):
        parts.save(tmp_path / name)
    data = read(vtk.vtkXMLPolyDataReader(), tmp_path / 'p.vtp')
    order = np.argsort(parts.face_sheet, kind='stable')
    assert (triangles_of(data) == parts.faces[order]).all() and data.GetNumberOfLines() == len(parts.seam_edges)
    assert np.allclose(vtk_to_numpy(data.GetPointData().GetArray('thickness')), parts.thickness)
    sheet = vtk_to_numpy(data.GetCellData().GetArray('sheet'))
    assert (sheet[:len(parts.seam_edges)] == -1).all() and (sheet[len(parts.seam_edges):] == parts.face_sheet[order]).all()
    assert edges_that_are(data, manifold=False) == len(parts.seam_edges)
    grid = read(vtk.vtkXMLUnstructuredGridReader(), tmp_path / 'p.vtu')
    assert grid.GetNumberOfCells() == len(parts.faces) + len(parts.seam_edges)
    types = vtk_to_numpy(grid.GetCellTypesArray())
    assert ((types == 3).sum(), (types == 5).sum()) == (len(parts.seam_edges), len(parts.faces))
    assert np.allclose(vtk_to_numpy(grid.GetPoints().GetData()), parts.vertices)
    assert grid.GetCellData().GetArray('sheet').GetRange() == data.GetCellData().GetArray('sheet').GetRange()
    for name, reader in (('p.ply', vtk.vtkPLYReader()), ('p.obj', vtk.vtkOBJReader()), ('p.stl', vtk.vtkSTLReader())):
        assert read(reader, tmp_path / name).GetNumberOfPolys() == len(parts.faces)
    groups = [line for line in (tmp_path / 'p.obj').read_text().splitlines() if line.startswith('g ')]
    assert groups == [f'g sheet_{number}' for number in sorted(parts.sheets['sheet'])]
    with open(tmp_path / 'p.csv', newline='') as file:
        rows = list(csv.DictReader(file))
    assert [int(row['sheet']) for row in rows] == list(parts.sheets['sheet'])


@pytest.mark.skipif(not PROGRAM, reason='the program is not built')
def test_sheets_of_the_program_are_manifolds(tmp_path):
    run('sample', 'torus', '-o', tmp_path / 'torus.ply')
    quench.medial_axis(t_of_plates(), surface='voxels').save(tmp_path / 'axis.vtp')
    for how in ([], ['--remesh', '2vox'], ['--whole'], ['--whole', '--remesh', '3vox']):
        folder = tmp_path / 'parts'
        run('parts', tmp_path / 'axis.vtp', *how, '--format', 'vtp', '--overwrite', '-o', folder)
        with open(folder / 'parts.csv', newline='') as file:
            rows = list(csv.DictReader(file))
        names = sorted(path.name for path in (folder / 'sheets').iterdir())
        assert names == sorted(f'sheet_{row["sheet"]}.vtp' for row in rows[:100])
        for row in rows[:100]:
            sheet = read(vtk.vtkXMLPolyDataReader(), folder / 'sheets' / f'sheet_{row["sheet"]}.vtp')
            assert edges_that_are(sheet, manifold=False) == 0
            assert (edges_that_are(sheet, boundary=True) == 0) == (int(row['borders']) == 0)
            points, faces = vtk_to_numpy(sheet.GetPoints().GetData()), triangles_of(sheet)
            if '--remesh' not in how:
                assert areas_of(points, faces).sum() == pytest.approx(float(row['area']), rel=1e-9, abs=1e-9)
            edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
            assert len(points) - len(edges) + len(faces) == int(row['euler'])
    result = run('parts', tmp_path / 'torus.ply', '--resolution', '64', '-o', tmp_path / 'torus.vtu', '--csv',
                 tmp_path / 'torus.csv')
    assert 'torus.vtu' in result.stderr


@pytest.mark.skipif(not PROGRAM, reason='the program is not built')
def test_the_program_says_what_is_wrong(tmp_path):
    quench.medial_axis(t_of_plates()).save(tmp_path / 'axis.vtp')

    def fails(*arguments):
        done = subprocess.run([PROGRAM, 'parts', *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 2
        return done.stderr

    assert 'remesh' in fails(tmp_path / 'axis.vtp', '-o', tmp_path / 'p.vtp', '--remesh', '0')
    assert 'parts.csv' in fails(tmp_path / 'axis.vtp', '-o', tmp_path / 'p', '--csv', tmp_path / 'p.csv')
    assert '.csv' in fails(tmp_path / 'axis.vtp', '-o', tmp_path / 'p.vtp', '--csv', tmp_path / 'p.txt')
