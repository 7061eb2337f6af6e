# SPDX-License-Identifier: Apache-2.0
"""A view that shows a medial axis well: sheets and curves coloured by a measure, in the transparent shape.

In ParaView: File -> Load State of this file, which shows the 'core.vtp' of the folder that ParaView was started in (or of
QUENCH_CORE, with the mesh QUENCH_SHAPE). As a program:

    pvbatch show_core.py core.vtp --shape shape.ply --color radius -o picture.png --state core.pvsm
"""
import argparse
import os

from paraview import servermanager, simple


def percentile(data, name, share):
    """Of the finite values of a point array, without those of closed pockets, which never burn."""
    from vtkmodules.numpy_interface import dataset_adapter

    arrays = dataset_adapter.WrapDataObject(servermanager.Fetch(data)).PointData
    values = arrays[name]
    good = (values < 1e38) & (values > -1e38)
    if 'unburned' in arrays.keys():
        good &= arrays['unburned'] == 0
    values = sorted(values[good])
    return float(values[round(share * (len(values) - 1))]) if values else 1.0


def show(core, shape=None, color='erosion_thickness', curves=0.004, turn=25):
    """The view. `curves`: their radius as a share of the box; `turn`: of the camera around the shape, in degrees."""
    simple._DisableFirstRenderCameraReset()
    view = simple.GetActiveViewOrCreate('RenderView')
    view.Background = [1, 1, 1]
    view.UseColorPaletteForBackground = 0
    view.OrientationAxesVisibility = 0
    reader = simple.XMLPolyDataReader(registrationName='core', FileName=[core])
    reader.UpdatePipeline()
    if color not in reader.PointData.keys():
        color = 'radius'
    bounds = reader.GetDataInformation().GetBounds()
    size = max(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4])

    table = simple.GetColorTransferFunction(color)
    table.ApplyPreset('Viridis (matplotlib)', True)
    table.RescaleTransferFunction(0 if color != 'radius' else percentile(reader, color, 0.02), percentile(reader, color, 0.98))
    sheets = simple.Show(reader, view)
    simple.ColorBy(sheets, ('POINTS', color))
    sheets.Ambient, sheets.Diffuse = 0.35, 0.7

    # Cells of curves have kind 1; as tubes they are seen from afar.
    lines = simple.Threshold(registrationName='curves', Input=reader, Scalars=['CELLS', 'kind'], LowerThreshold=1,
                             UpperThreshold=1)
    surface = simple.ExtractSurface(Input=lines)
    tubes = simple.Tube(registrationName='tubes', Input=surface, Radius=curves * size, NumberofSides=8)
    tubes.Scalars, tubes.Vectors = ['POINTS', color], [None, '']
    lines.UpdatePipeline()
    if lines.GetDataInformation().GetNumberOfCells():
        shown = simple.Show(tubes, view)
        simple.ColorBy(shown, ('POINTS', color))
    if shape:
        mesh = simple.OpenDataFile(shape)
        simple.RenameSource('shape', mesh)
        outside = simple.Show(mesh, view)
        outside.ColorArrayName = ['POINTS', '']
        outside.DiffuseColor, outside.Opacity = [0.75, 0.78, 0.85], 0.15
    bar = simple.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = color.replace('_', ' '), ''
    bar.TitleColor = bar.LabelColor = [0, 0, 0]
    bar.TitleFontSize, bar.LabelFontSize, bar.ScalarBarThickness = 12, 11, 12
    bar.WindowLocation, bar.Position, bar.ScalarBarLength = 'Any Location', [0.82, 0.06], 0.3
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, '%.3g', '%.3g'
    sheets.SetScalarBarVisibility(view, True)
    view.ResetCamera(False)
    camera = simple.GetActiveCamera()
    camera.Azimuth(turn)
    camera.Elevation(15)
    camera.Dolly(1.3)
    simple.Render(view)
    return view


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('core', nargs='?', default=os.environ.get('QUENCH_CORE', 'core.vtp'))
    parser.add_argument('--shape', default=os.environ.get('QUENCH_SHAPE'), help='the mesh, in a format that ParaView reads')
    parser.add_argument('--color', default='erosion_thickness', help='a point array')
    parser.add_argument('-o', '--output', help='a picture of the view')
    parser.add_argument('--state', help='a state file of the view')
    parser.add_argument('--turn', type=float, default=25, help='of the camera around the shape, in degrees')
    parser.add_argument('--size', type=int, nargs=2, default=[1000, 800])
    arguments = parser.parse_args()
    view = show(os.path.abspath(arguments.core), arguments.shape and os.path.abspath(arguments.shape), arguments.color,
                turn=arguments.turn)
    view.ViewSize = arguments.size
    simple.Render(view)
    if arguments.output:
        simple.SaveScreenshot(arguments.output, view, ImageResolution=arguments.size)
    if arguments.state:
        simple.SaveState(arguments.state)


if __name__ in ('__main__', '__vtkconsole__'):
    main()
