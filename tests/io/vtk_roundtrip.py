# SPDX-License-Identifier: Apache-2.0
"""VTK's side of the tests of VTP files.

vtk_roundtrip.py probe            exits with 0 when VTK is there
vtk_roundtrip.py describe FILE    what VTK reads from a VTP file, one line per fact
vtk_roundtrip.py write FOLDER     a small PolyData in every encoding VTK writes
"""
import os
import sys

try:
    import vtk
except ImportError:
    sys.exit(77)


def describe_arrays(kind, attributes):
    for i in range(attributes.GetNumberOfArrays()):
        array = attributes.GetAbstractArray(i)
        head = " ".join(str(part) for part in (kind, array.GetName(), array.GetDataTypeAsString(),
                                               array.GetNumberOfComponents(), array.GetNumberOfTuples()))
        if isinstance(array, vtk.vtkStringArray):
            print(head, "|".join(array.GetValue(k) for k in range(array.GetNumberOfValues())))
        else:
            ranges = [array.GetRange(c) for c in range(array.GetNumberOfComponents())]
            print(head, " ".join(f"{low:.9g} {high:.9g}" for low, high in ranges))


def describe(path):
    errors = []
    reader = vtk.vtkXMLPolyDataReader()
    for source in (reader, reader.GetReaderErrorObserver() if hasattr(reader, "GetReaderErrorObserver") else None):
        if source is not None:
            source.AddObserver("ErrorEvent", lambda *args: errors.append("error"))
            source.AddObserver("WarningEvent", lambda *args: errors.append("warning"))
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    print("errors", len(errors))
    print("counts", data.GetNumberOfPoints(), data.GetNumberOfVerts(), data.GetNumberOfLines(), data.GetNumberOfPolys(),
          data.GetNumberOfStrips())
    for i in range(data.GetNumberOfPoints()):
        print("point", *("%.17g" % x for x in data.GetPoint(i)))
    for i in range(data.GetNumberOfCells()):
        ids = data.GetCell(i).GetPointIds()
        print("cell", *(ids.GetId(k) for k in range(ids.GetNumberOfIds())))
    scalars = data.GetPointData().GetScalars()
    print("scalars", scalars.GetName() if scalars else "none")
    describe_arrays("point", data.GetPointData())
    describe_arrays("cell", data.GetCellData())
    describe_arrays("field", data.GetFieldData())


def add_array(attributes, kind, name, components, values):
    array = kind()
    array.SetName(name)
    array.SetNumberOfComponents(components)
    for value in values:
        array.InsertNextValue(value)
    attributes.AddArray(array)


def sample():
    """6 points, 2 vertex cells (one of 2 points), a line of 3 points, a triangle and a quadrangle, a strip of 4."""
    data = vtk.vtkPolyData()
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for i in range(6):
        points.InsertNextPoint(0.1 * i, i * i, -i / 3)
    data.SetPoints(points)
    verts, lines, polys, strips = (vtk.vtkCellArray() for _ in range(4))
    for cells, corners in ((verts, (5,)), (verts, (3, 4)), (lines, (0, 1, 2)), (polys, (0, 1, 2)), (polys, (2, 3, 4, 5)),
                           (strips, (0, 1, 2, 3))):
        cells.InsertNextCell(len(corners))
        for corner in corners:
            cells.InsertCellPoint(corner)
    data.SetVerts(verts)
    data.SetLines(lines)
    data.SetPolys(polys)
    data.SetStrips(strips)
    point_data = data.GetPointData()
    add_array(point_data, vtk.vtkDoubleArray, "radius", 1, [0.1, 0.2, 1 / 3, 1e-300, 5, 6])
    add_array(point_data, vtk.vtkFloatArray, "vector", 3, [0.5 * i for i in range(18)])
    add_array(point_data, vtk.vtkUnsignedCharArray, "flag", 1, [0, 1, 50, 100, 200, 255])
    add_array(point_data, vtk.vtkSignedCharArray, "signed", 1, [-128, -1, 0, 1, 2, 127])
    add_array(point_data, vtk.vtkUnsignedShortArray, "short", 1, [0, 1, 2, 3, 4, 65535])
    add_array(point_data, vtk.vtkIntArray, "int", 1, [-2**31, 1, 2, 3, 4, 2**31 - 1])
    add_array(point_data, vtk.vtkUnsignedIntArray, "uint", 1, [0, 1, 2, 3, 4, 2**32 - 1])
    add_array(point_data, vtk.vtkLongLongArray, "long", 1, [-2**62, 1, 2, 3, 4, 2**62])
    add_array(point_data, vtk.vtkIdTypeArray, "id", 1, [0, 1, 2, 3, 4, 5])
    add_array(point_data, vtk.vtkBitArray, "bits", 1, [0, 1, 1, 0, 1, 0])
    add_array(data.GetCellData(), vtk.vtkIntArray, "cell", 1, [10, 20, 30, 40, 50, 60])
    field = data.GetFieldData()
    add_array(field, vtk.vtkStringArray, "words", 1, ["alpha", "", "beta <&> \u00e4"])
    add_array(field, vtk.vtkIntArray, "sites", 3, [1, 2, 3, 4, 5, 6])
    return data


def write(folder):
    data = sample()
    for mode in ("ascii", "binary", "appended_raw", "appended_base64"):
        for compressed in (False, True):
            for wide in (False, True):
                writer = vtk.vtkXMLPolyDataWriter()
                writer.SetInputData(data)
                writer.SetFileName(os.path.join(folder, f"{mode}_{int(compressed)}_{int(wide)}.vtp"))
                if mode == "ascii":
                    writer.SetDataModeToAscii()
                elif mode == "binary":
                    writer.SetDataModeToBinary()
                else:
                    writer.SetDataModeToAppended()
                    writer.SetEncodeAppendedData(mode == "appended_base64")
                if compressed:
                    writer.SetCompressorTypeToZLib()
                    writer.SetBlockSize(32)  # many blocks
                else:
                    writer.SetCompressorTypeToNone()
                if wide:
                    writer.SetHeaderTypeToUInt64()
                else:
                    writer.SetHeaderTypeToUInt32()
                writer.Write()
    pieces = vtk.vtkXMLPolyDataWriter()
    triangles = vtk.vtkPlaneSource()
    triangles.SetResolution(3, 2)
    pieces.SetInputConnection(triangles.GetOutputPort())
    pieces.SetNumberOfPieces(2)
    pieces.SetFileName(os.path.join(folder, "pieces.vtp"))
    pieces.Write()
    big = vtk.vtkXMLPolyDataWriter()
    big.SetInputData(data)
    big.SetByteOrderToBigEndian()
    big.SetFileName(os.path.join(folder, "big_endian.vtp"))
    big.Write()


if __name__ == "__main__":
    if sys.argv[1] == "describe":
        describe(sys.argv[2])
    elif sys.argv[1] == "write":
        write(sys.argv[2])
