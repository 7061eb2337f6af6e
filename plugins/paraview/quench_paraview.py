# SPDX-License-Identifier: Apache-2.0
"""A plug-in of ParaView: filters that run Quench on a surface or an image, readers of medial axes (.ma) and of trees
(.swc). Load it with Tools -> Manage Plugins -> Load New, or with load_quench.py where ParaView has Python 3.11 or newer
and is older than 5.12, e.g. that of Debian 12.

The program is what QUENCH names, the one this file was installed or built with, or the first `quench` in PATH.
"""
import os
import shutil
import subprocess
import tempfile

from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIntArray, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkTriangleFilter
from vtkmodules.vtkIOImage import vtkMetaImageWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

HERE = os.path.dirname(os.path.realpath(__file__))


def program():
    """The path of the program. Raises RuntimeError where there is none."""
    for path in (os.environ.get('QUENCH'), os.path.join(HERE, '..', '..', '..', 'bin', 'quench'),
                 os.path.join(HERE, '..', '..', 'build', 'release', 'quench'), shutil.which('quench')):
        if path and os.access(path, os.X_OK) and os.path.isfile(path):
            return os.path.abspath(path)
    raise RuntimeError("the program 'quench' is not in PATH; set the environment variable QUENCH to where it is")


def run(*words):
    """Runs a command of Quench. Raises RuntimeError with its sentence where it fails."""
    environment = {name: value for name, value in os.environ.items()
                   if name not in ('LD_LIBRARY_PATH', 'DYLD_LIBRARY_PATH')}  # ParaView's libraries are not Quench's
    done = subprocess.run([program(), *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False, env=environment)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().split('\n')[-1])
    return done.stderr


def write_input(data, folder):
    """A data set as a file that Quench reads; its name."""
    if isinstance(data, vtkImageData):
        writer = vtkMetaImageWriter()
        name = os.path.join(folder, 'input.mha')
        writer.SetInputData(data)
    else:
        triangles = vtkTriangleFilter()
        triangles.SetInputData(data)
        triangles.PassLinesOff()
        triangles.PassVertsOff()
        writer = vtkXMLPolyDataWriter()
        name = os.path.join(folder, 'input.vtp')
        writer.SetInputConnection(triangles.GetOutputPort())
    writer.SetFileName(name)
    writer.Write()
    return name


def read_result(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


class OfShape(VTKPythonAlgorithmBase):
    """What filters of a surface or an image share."""

    def __init__(self):
        super().__init__(nInputPorts=1, nOutputPorts=1, outputType='vtkPolyData')
        self.resolution, self.threshold = 128, ''

    def FillInputPortInformation(self, port, information):
        information.Set(self.INPUT_REQUIRED_DATA_TYPE(), 'vtkPolyData')
        information.Append(self.INPUT_REQUIRED_DATA_TYPE(), 'vtkImageData')
        return 1

    def set(self, name, value):
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    def shape_words(self, data, folder):
        """The words of a command for its input."""
        words = [write_input(data, folder)]
        if isinstance(data, vtkImageData):
            return words + (['--threshold', self.threshold] if self.threshold else [])
        return words + ['--resolution', str(self.resolution)]


@smproxy.filter(name='QuenchMedialAxis', label='Quench Medial Axis')
@smproperty.input(name='Input', port_index=0)
@smdomain.datatype(dataTypes=['vtkPolyData', 'vtkImageData'], composite_data_supported=False)
class QuenchMedialAxis(OfShape):
    """The medial axis or the skeleton of a closed surface or of an image."""

    def __init__(self):
        super().__init__()
        self.result, self.detail, self.theta1, self.theta2 = 0, 'auto', 'auto', 'auto'
        self.made = None  # of which input and values, and both results

    @smproperty.xml('''<IntVectorProperty name="Result" command="SetResult" number_of_elements="1" default_values="0">
        <EnumerationDomain name="enum"><Entry value="0" text="Medial axis"/><Entry value="1" text="Skeleton"/>
        </EnumerationDomain><Documentation>Both are computed at once.</Documentation></IntVectorProperty>''')
    def SetResult(self, value):
        self.set('result', value)

    @smproperty.intvector(name='Resolution', default_values=[128])
    @smdomain.intrange(min=16, max=1024)
    def SetResolution(self, value):
        self.set('resolution', value)

    @smproperty.stringvector(name='Detail', default_values=['auto'])
    def SetDetail(self, value):
        self.set('detail', value)

    @smproperty.stringvector(name='Theta2', default_values=['auto'])
    def SetTheta2(self, value):
        self.set('theta2', value)

    @smproperty.stringvector(name='Theta1', default_values=['auto'])
    def SetTheta1(self, value):
        self.set('theta1', value)

    @smproperty.stringvector(name='Threshold', default_values=[''])
    def SetThreshold(self, value):
        self.set('threshold', value)

    def RequestData(self, request, inputs, outputs):
        source = self.GetInputData(inputs, 0, 0)
        values = (source.GetMTime(), self.resolution, self.detail, self.theta1, self.theta2, self.threshold)
        if not self.made or self.made[0] != values:
            with tempfile.TemporaryDirectory(prefix='quench-') as folder:
                out = os.path.join(folder, 'out')
                run('run', *self.shape_words(source, folder), '--detail', self.detail, '--theta1', self.theta1,
                    '--theta2', self.theta2, '--no-view', '--no-picture', '-o', out)
                self.made = values, [read_result(os.path.join(out, name)) for name in ('core.vtp', 'skeleton.vtp')]
        vtkPolyData.GetData(outputs, 0).ShallowCopy(self.made[1][self.result])
        return 1


@smproxy.filter(name='QuenchThickness', label='Quench Thickness')
@smproperty.input(name='Input', port_index=0)
@smdomain.datatype(dataTypes=['vtkPolyData', 'vtkImageData'], composite_data_supported=False)
class QuenchThickness(OfShape):
    """The surface with the local thickness of its solid at every vertex."""

    @smproperty.intvector(name='Resolution', default_values=[128])
    @smdomain.intrange(min=16, max=1024)
    def SetResolution(self, value):
        self.set('resolution', value)

    @smproperty.stringvector(name='Threshold', default_values=[''])
    def SetThreshold(self, value):
        self.set('threshold', value)

    def RequestData(self, request, inputs, outputs):
        with tempfile.TemporaryDirectory(prefix='quench-') as folder:
            out = os.path.join(folder, 'thickness.vtp')
            run('thickness', *self.shape_words(self.GetInputData(inputs, 0, 0), folder), '--surface', out)
            vtkPolyData.GetData(outputs, 0).ShallowCopy(read_result(out))
        return 1


def cells(lists):
    array = vtkCellArray()
    for ids in lists:
        array.InsertNextCell(len(ids))
        for number in ids:
            array.InsertCellPoint(number)
    return array


def with_radius(output, points, radii):
    """Points with the array `radius`, which is the active one."""
    positions, radius = vtkPoints(), vtkDoubleArray()
    positions.SetDataTypeToDouble()
    radius.SetName('radius')
    for point, r in zip(points, radii):
        positions.InsertNextPoint(point)
        radius.InsertNextValue(r)
    output.SetPoints(positions)
    output.GetPointData().SetScalars(radius)


class OfFile(VTKPythonAlgorithmBase):
    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType='vtkPolyData')
        self.name = None

    def set_name(self, name):
        if self.name != name:
            self.name = name
            self.Modified()


@smproxy.reader(name='QuenchMedialAxisReader', label='Quench Medial Axis Reader', extensions='ma',
                file_description='Medial axes (MAT format)')
class QuenchMedialAxisReader(OfFile):
    """Medial axes as Q-MAT and its successors write them: 'v x y z radius', 'e a b', 'f a b c'."""

    @smproperty.stringvector(name='FileName', panel_visibility='never')
    @smdomain.filelist()
    @smhint.filechooser(extensions='ma', file_description='Medial axes (MAT format)')
    def SetFileName(self, name):
        self.set_name(name)

    def RequestData(self, request, inputs, outputs):
        points, radii, edges, faces = [], [], [], []
        with open(self.name, encoding='utf-8') as file:
            counts = [int(word) for word in next(file).split()]
            for line in file:
                words = line.split()
                if words and words[0] == 'v':
                    numbers = [float(word) for word in words[1:5]]
                    points.append(numbers[:3])
                    radii.append(numbers[3])
                elif words and words[0] in 'ef':
                    (edges if words[0] == 'e' else faces).append([int(word) for word in words[1:]])
        if [len(points), len(edges), len(faces)] != counts[:3] or any(
                not 0 <= number < len(points) for ids in edges + faces for number in ids):
            raise RuntimeError(f"'{self.name}' is not a medial axis in the MAT format, or not all of it")
        sides = {frozenset(pair) for face in faces for pair in zip(face, face[1:] + face[:1])}
        output = vtkPolyData.GetData(outputs, 0)
        with_radius(output, points, radii)
        output.SetLines(cells(edge for edge in edges if frozenset(edge) not in sides))  # curves, not sides of sheets
        output.SetPolys(cells(faces))
        return 1


@smproxy.reader(name='QuenchTreeReader', label='Quench Tree Reader', extensions='swc', file_description='Trees (SWC)')
class QuenchTreeReader(OfFile):
    """Neurons and other trees: a line per sample, 'id type x y z radius parent'."""

    @smproperty.stringvector(name='FileName', panel_visibility='never')
    @smdomain.filelist()
    @smhint.filechooser(extensions='swc', file_description='Trees (SWC)')
    def SetFileName(self, name):
        self.set_name(name)

    def RequestData(self, request, inputs, outputs):
        points, radii, types, parents, number_of = [], [], [], [], {}
        with open(self.name, encoding='utf-8') as file:
            for line in file:
                words = line.split('#')[0].split()
                if len(words) < 7:
                    continue
                number_of[int(words[0])] = len(points)
                types.append(int(words[1]))
                points.append([float(word) for word in words[2:5]])
                radii.append(float(words[5]))
                parents.append(int(words[6]))
        children = [0] * len(points)
        up = [number_of.get(parent, -1) for parent in parents]
        for parent in up:
            if parent >= 0:
                children[parent] += 1
        lines = []
        for end in range(len(points)):  # from every tip and fork up to the next fork
            if children[end] == 1 or up[end] < 0:
                continue
            line = [end]
            while up[line[-1]] >= 0 and (len(line) == 1 or children[line[-1]] == 1):
                line.append(up[line[-1]])
            lines.append(line[::-1])
        output = vtkPolyData.GetData(outputs, 0)
        with_radius(output, points, radii)
        output.SetLines(cells(lines))
        kind = vtkIntArray()
        kind.SetName('type')
        for value in types:
            kind.InsertNextValue(value)
        output.GetPointData().AddArray(kind)
        return 1
