# SPDX-License-Identifier: Apache-2.0
"""The medial geodesic function of volumes."""
import numpy as np
import pytest

import quench


def plate():
    volume = np.zeros((30, 24, 11), bool)
    volume[2:-2, 2:-2, 2:-2] = True
    return volume


def test_is_a_measure_on_request():
    assert 'mgf' not in quench.medial_axis(plate()).measures
    axis = quench.medial_axis(plate(), mgf=True)
    values = axis.measures['mgf'].values
    assert axis.detail is not None and len(values.vertices) == len(axis.vertices)
    straight = 2 * axis.measures['lambda'].values.polygons
    assert (values.polygons >= straight * (1 - 1e-12)).all()
    # In the middle of the plate 26 x 20 x 7: straight to the nearer side and back.
    assert values.polygons.max() == pytest.approx(10 + 7 + 10, abs=0.1)


def test_prunes():
    axis = quench.medial_axis(plate(), mgf='12vox')
    assert axis.detail is None and axis.lambda_ is None
    assert axis.topology.betti == (1, 0, 0)
    levels = axis.measures['mgf'].levels.polygons
    assert (levels >= 12).all()
    assert len(axis.pruned('20vox').edges) < len(axis.edges) < len(quench.medial_axis(plate(), mgf=0).edges)
    with pytest.raises(quench.Error, match='two measures'):
        quench.medial_axis(plate(), mgf=1, detail=0)
