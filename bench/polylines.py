# SPDX-License-Identifier: Apache-2.0
"""Lines of VTP files, for the scripts beside this one."""
import numpy as np
from vtk.util.numpy_support import vtk_to_numpy


def segments_of(data):
    """The segments of all polylines of a vtkPolyData."""
    corners = vtk_to_numpy(data.GetLines().GetConnectivityArray())
    starts = np.ones(len(corners), bool)
    starts[vtk_to_numpy(data.GetLines().GetOffsetsArray())[1:] - 1] = False  # the last corner of each starts none
    first = np.flatnonzero(starts)
    return np.stack([corners[first], corners[first + 1]], axis=1)
