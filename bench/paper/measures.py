# SPDX-License-Identifier: Apache-2.0
"""Measures of significance of the polygons of a burned medial axis, for Figs. 3.8 and 3.9."""
import numpy as np

NAMES = {'object_angle': 'object angle', 'radius': 'circumradius', 'lambda': 'λ', 'mgf': 'MGF', 'erosion_thickness': 'erosion thickness'}


def of_polygons(axis, name):
    """One value per polygon."""
    if name == 'erosion_thickness':
        return axis.least(axis.thickness())
    if name == 'radius':
        return axis.least(axis.at['radius'].astype(float))
    values = axis.faces[name]
    return np.where(values > 3e38, np.inf, values).astype(float)


def threshold_of(values, area, share):
    """The threshold above which polygons have that share of the area."""
    order = np.argsort(-values)
    return values[order][min(np.searchsorted(np.cumsum(area[order]), share * area.sum()), len(order) - 1)]
