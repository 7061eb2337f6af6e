# SPDX-License-Identifier: Apache-2.0
"""Medial axes and skeletons of real 3D shapes: exact, pruned without changing topology.

>>> import numpy as np, quench
>>> image = np.zeros((50, 20, 20), bool)
>>> image[5:-5, 5:-5, 5:-5] = True
>>> skeleton = quench.medial_axis(image).skeleton(theta2='inf', theta1='10%')
>>> len(skeleton.branches()['length'])
1
"""
from ._axis import MedialAxis
from ._common import ArgumentTypeError, Certificate, MissingFileError, Topology
from ._core import Error, UsageError, __version__
from ._graph import Graph
from ._inputs import Mesh, Volume, sample, samples, voxelize
from ._making import medial_axis, read
from ._parts import Parts, SheetMesh
from ._simplification import Simplification
from ._show import View
from ._skeleton import Curves, Sheets, Skeleton, skeletonize
from ._solid import Solid
from ._thickness import SurfaceThickness, local_thickness, surface_thickness
from ._tree import Tree, read_tree, tree

__all__ = ['ArgumentTypeError', 'Certificate', 'Curves', 'Error', 'Graph', 'MedialAxis', 'Mesh', 'MissingFileError', 'Parts', 'SheetMesh', 'Sheets',
           'Simplification', 'Skeleton', 'Solid', 'SurfaceThickness', 'Topology', 'Tree', 'UsageError', 'View', 'Volume',
           '__version__', 'local_thickness', 'medial_axis', 'read', 'read_tree', 'sample', 'samples', 'skeletonize',
           'surface_thickness', 'tree', 'voxelize']
