# SPDX-License-Identifier: Apache-2.0
"""Solids of axes: voxels, meshes checked by VTK, errors, distances."""
import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs, plate_with_tunnel


def test_balls_of_the_unpruned_core_are_the_image():
    for image in (bent_tube(), plate_with_tunnel(), blobs(3)):
        axis = quench.medial_axis(image, lambda_=0, surface='voxels')
        solid = axis.solid()
        assert not solid.envelope and (solid.voxels == image).all() and (axis.reconstruct() == image).all()
        assert solid.topology == axis.topology
        errors = solid.errors()
        assert errors['volume']['missing'] == errors['volume']['added'] == 0
        assert errors['volume']['shape'] == errors['volume']['solid'] == image.sum()
        assert errors['surface'] == 'voxels'
        full = axis.solid(envelope=True)
        assert full.envelope and (full.voxels | ~image).all() and full.errors()['volume']['missing'] == 0
        # The corners of voxels lie on balls; what is missing between them is less than a voxel.
        assert errors['surface_from_solid']['outside']['largest'] < 1


def test_spacing_and_skeletons():
    image = bent_tube()
    axis = quench.medial_axis(image, spacing=(0.5, 1, 2), detail=0)
    solid = axis.solid()
    assert solid.voxels.shape == image.shape and (solid.voxels | ~image).all()
    assert solid.errors()['volume']['shape'] == image.sum()  # 0.5 * 1 * 2
    of_curves = quench.medial_axis(image).skeleton(theta2='inf').solid()
    assert of_curves.envelope and of_curves.errors()['volume']['missing'] < 0.5 * image.sum()


def test_distances_are_signed_and_those_of_balls():
    image = np.zeros((9, 9, 9), bool)
    image[4, 4, 4] = True
    solid = quench.medial_axis(image, lambda_=0, surface='voxels').solid()  # one ball, through the corners of the voxel
    r = np.sqrt(3) / 2
    points = np.array([[4, 4, 4], [4, 4, 7], [0, 4, 4.0]])
    assert np.allclose(solid.distance(points), [-r, 3 - r, 4 - r], atol=1e-12)
    with pytest.raises(quench.UsageError):
        solid.distance([[1, 2]])


def test_images_have_an_area_and_no_mesh():
    image = np.zeros((20, 30), bool)
    image[3:-3, 4:-4] = True
    solid = quench.medial_axis(image, lambda_=0, surface='voxels').solid()
    assert (solid.voxels == image).all() and list(solid.errors()) == ['volume']
    assert solid.errors()['volume']['shape'] == image.sum()
    assert solid.distance([[12, 9.5]])[0] < 0
    with pytest.raises(quench.Error):
        solid.mesh()


def test_files(tmp_path):
    axis = quench.medial_axis(bent_tube())
    solid = axis.solid(envelope=True)
    solid.save(tmp_path / 'v.nrrd')
    solid.save(tmp_path / 'm.ply')
    axis.save(tmp_path / 'a.vtp')
    back = quench.read(tmp_path / 'a.vtp').solid(envelope=True)
    assert (back.voxels == solid.voxels).all() and back.errors() is None
    coarse = quench.read(tmp_path / 'a.vtp').solid(resolution=20)
    assert max(coarse.voxels.shape) in (21, 22)
    with pytest.raises(quench.UsageError):
        solid.save(tmp_path / 'v.stl')
    with pytest.raises(quench.UsageError):
        axis.solid(resolution=0)


@pytest.mark.parametrize('envelope', [False, True])
def test_vtk_finds_meshes_closed_and_manifold(envelope):
    vtk = pytest.importorskip('vtk')
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    for image in (bent_tube(), plate_with_tunnel(), blobs(4)):
        solid = quench.medial_axis(image).solid(envelope=envelope)
        points, triangles = solid.mesh()
        assert triangles.shape[1] == 3 and triangles.min() == 0 and triangles.max() == len(points) - 1
        data = vtk.vtkPolyData()
        holder = vtk.vtkPoints()
        holder.SetData(numpy_to_vtk(points, deep=True))
        cells = vtk.vtkCellArray()
        rows = np.insert(triangles.astype(np.int64), 0, 3, axis=1)
        cells.SetCells(len(rows), numpy_to_vtkIdTypeArray(np.ascontiguousarray(rows.ravel()), deep=True))
        data.SetPoints(holder)
        data.SetPolys(cells)
        edges = vtk.vtkFeatureEdges()
        edges.SetInputData(data)
        edges.BoundaryEdgesOn()
        edges.NonManifoldEdgesOn()
        edges.FeatureEdgesOff()
        edges.ManifoldEdgesOff()
        edges.Update()
        assert edges.GetOutput().GetNumberOfCells() == 0
        parts = vtk.vtkPolyDataConnectivityFilter()
        parts.SetInputData(data)
        parts.SetExtractionModeToAllRegions()
        parts.Update()
        euler, betti = solid.topology
        assert parts.GetNumberOfExtractedRegions() == betti[0] + betti[2]
        assert len(points) - len(triangles) // 2 == 2 * euler
        mass = vtk.vtkMassProperties()
        mass.SetInputData(data)
        low, high = points.min(axis=0) - 1, points.max(axis=0) + 1
        places = low + np.random.default_rng(1).random((100000, 3)) * (high - low)
        volume = (solid.distance(places) <= 0).mean() * np.prod(high - low)
        # Triangles cut off the creases between balls as wide as a few voxels: a quarter of a voxel, vertices half of one.
        assert abs(mass.GetVolume() - volume) < 0.25 * mass.GetSurfaceArea()
        assert np.abs(solid.distance(points)).max() < 0.5
