#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 4.1: the chain of fires. The shape's fire leaves the medial axis with R; the fire of the axis leaves curves with BT; that of
the curves leaves points. Below, what each fire says of importance: ET on the axis, ET on the curves."""
import numpy as np
import vtk
from paper import Complex, Scene, colours, isosurface, main, polydata, read_nrrd, sheet, table
from scipy import ndimage


def make(paper):
    mesh = paper.real('meshes/armadillo.off')
    if mesh is None:
        return
    view, up = (-0.6, -0.25, 1.5), (0, 1, 0)
    folder = paper.file('chain')
    paper.quench('run', mesh, '--resolution', 160, '--theta2', 'inf', '--theta1', '2%', '-o', folder)
    paper.quench('voxelize', mesh, '--resolution', 96, '-o', paper.file('chain.nrrd'))
    samples, spacing, origin = read_nrrd(paper.file('chain.nrrd'))
    distance = ndimage.distance_transform_edt(np.pad(samples > 0, 1)) * spacing[0]
    axis, curves = Complex(folder / 'core.vtp'), Complex(folder / 'skeleton.vtp')
    surface = paper.surface(mesh)
    bounds = surface.GetBounds()

    def scene():
        return Scene(view, up).add(surface, (0.8, 0.8, 0.8), 0.10)

    # Level sets of the distance, cut open in front so that the inner ones are seen.
    fire = Scene(view, up)
    top = distance.max()
    for level in (0.08, 0.25, 0.42, 0.6, 0.78):
        shell = isosurface(distance.astype(np.float32), float(level * top), spacing, origin - spacing)
        rgb = colours(np.full(shell.GetNumberOfPoints(), level), 0, 1)
        fire.add(shell, points=rgb, opacity=0.16 if level < 0.7 else 1.0)
    at = axis.at
    hot = np.quantile(at['burn_time'], 0.998)
    pair = curves.lines[curves.only_curves()]
    both = {name: curves.at[name].astype(float) for name in ('radius', 'burn_time', 'curve_burn_time', 'curve_erosion_thickness')}
    both['curve_erosion_thickness'][curves.at['curve_unburned'] == 1] = np.inf
    time = both['curve_burn_time']
    used = np.unique(pair)
    last = used[np.argmax(np.where(np.isfinite(time[used]), time[used], -1))]

    def curve_scene(name, point=False):
        values = both[name]
        found = scene()
        finite = values[used][np.isfinite(values[used])]
        found.add(polydata(curves.points, None, None, pair), points=colours(values, 0, np.quantile(finite, 0.99)), width=6, light=False)
        if point:

            ball = vtk.vtkSphereSource()
            ball.SetCenter(*curves.points[last])
            ball.SetRadius(0.012 * max(np.subtract(bounds[1::2], bounds[::2])))
            ball.SetThetaResolution(24)
            ball.SetPhiResolution(24)
            ball.Update()
            found.add(ball.GetOutput(), (0.05, 0.05, 0.05))
        return found

    rows = [[fire, scene().add(axis.sheets(), points=colours(at['radius'].astype(float), 0, hot)),
             scene().add(axis.sheets(), points=colours(at['burn_time'].astype(float), 0, hot)), curve_scene('burn_time'),
             curve_scene('curve_burn_time', True)],
            [None, None, scene().add(axis.sheets(), points=colours(axis.thickness(), 0, np.quantile(at['erosion_thickness'], 0.998))),
             None, curve_scene('curve_erosion_thickness')]]
    pictures = [[s and s.render((400, 450), bounds) for s in row] for row in rows]
    captions = [['distance in O', 'medial axis M, with R', 'its burn time BT', 'curves MC, with BT', 'their burn time, and the point left'],
                ['', '', 'ET = BT − R', '', 'ET of curves: BT_MC − BT']]
    et = axis.thickness()
    table(('level', 'dimension', 'cells', 'b0, b1, b2', 'largest burn time', 'largest ET'),
          [('medial axis', 2, f'{axis.count} polygons', axis.betti(), f'{at["burn_time"].max():.4f}', f'{et[np.isfinite(et)].max():.4f}'),
           ('curves, theta1 2 %', 1, f'{len(pair)} segments', curves.betti(), f'{time[used][np.isfinite(time[used])].max():.4f}',
            f'{both["curve_erosion_thickness"][used][np.isfinite(both["curve_erosion_thickness"][used])].max():.4f}'),
           ('point', 0, '1', '(1, 0, 0)', '', '')])
    print(f'\nThe point left lies at {np.round(curves.points[last], 4)}, where the last two fires of the curves meet.')
    paper.save(sheet(pictures, captions=captions, width=2.7), '4_1')


if __name__ == '__main__':
    main(make, __doc__)
