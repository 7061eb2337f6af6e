# SPDX-License-Identifier: Apache-2.0
"""The measures one can prune by; the medial geodesic function of volumes."""
import numpy as np
import pytest

import quench


def plate():
    volume = np.zeros((30, 24, 11), bool)
    volume[2:-2, 2:-2, 2:-2] = True
    return volume


def test_is_a_measure_on_request():
    assert 'mgf' not in quench.medial_axis(plate()).measures
    axis = quench.medial_axis(plate(), measures='mgf')
    values = axis.measures['mgf'].values
    assert axis.detail is not None and len(values.vertices) == len(axis.vertices)
    straight = 2 * axis.measures['lambda'].values.polygons
    assert (values.polygons >= straight * (1 - 1e-12)).all()
    # In the middle of the plate 26 x 20 x 7: straight to the nearer side and back.
    assert values.polygons.max() == pytest.approx(10 + 7 + 10, abs=0.1)


def test_prunes():
    axis = quench.medial_axis(plate(), prune_by=('mgf', '12vox'))
    assert axis.detail is None and axis.lambda_ is None
    assert axis.pruned_by == ('mgf', 12) and axis.topology.betti == (1, 0, 0)
    levels = axis.measures['mgf'].levels.polygons
    assert (levels >= 12).all()
    assert len(axis.pruned('20vox').edges) < len(axis.edges) < len(quench.medial_axis(plate(), prune_by=('mgf', 0)).edges)
    with pytest.raises(quench.Error, match='two measures'):
        quench.medial_axis(plate(), prune_by=('mgf', 1), detail=0)


THRESHOLDS = {'detail': '1vox', 'lambda': '3vox', 'cap_height': '1vox', 'object_angle': 100, 'circumradius': '3vox',
              'mgf': '12vox', 'chord_residual': '4vox', 'core_erosion_thickness': '2vox',
              'relative_erosion_thickness': 0.3, 'scale_axis': 1.2}


@pytest.mark.parametrize('name', THRESHOLDS)
def test_prunes_by_every_measure(name):
    axis = quench.medial_axis(plate(), prune_by=(name, THRESHOLDS[name]))
    assert axis.pruned_by[0] == name and axis.topology.betti == (1, 0, 0)
    values, levels = axis.measures[name]
    assert (levels.polygons >= axis.pruned_by[1] * (1 - 1e-9)).all() and (levels.polygons >= values.polygons).all()
    assert axis.verify()
    image = np.zeros((30, 50), bool)
    image[3:-3, 3:-3] = True
    assert quench.medial_axis(image, prune_by=(name, THRESHOLDS[name])).verify()


def test_all_measures_are_there():
    axis = quench.medial_axis(plate(), measures='all')
    assert set(axis.measures) == set(THRESHOLDS)
    two = quench.medial_axis(plate(), measures=['scale_axis', 'circumradius'])
    assert {'scale_axis', 'circumradius'} <= set(two.measures) and 'mgf' not in two.measures
    assert quench.medial_axis(plate()).pruned_by == ('detail', pytest.approx(3 ** 0.5 / 2))


@pytest.mark.parametrize('prune_by, match', [
    (('thickness', 1), 'is not a measure'), (('erosion_thickness', 1), 'core_erosion_thickness'),
    (('object_angle', '2vox'), 'degrees'), (('object_angle', 200), 'degrees'), (('relative_erosion_thickness', 2), '0 to 1'),
    (('scale_axis', 0.5), 'at least 1'), (('mgf', 'auto'), 'no automatic'), ('mgf', 'a measure and its threshold')])
def test_refuses(prune_by, match):
    with pytest.raises(quench.Error, match=match) as refused:
        quench.medial_axis(plate(), prune_by=prune_by)
    assert refused.value.argument == 'prune_by'


def test_refuses_measures():
    for names in ('thickness', ['mgf', ''], [1]):
        with pytest.raises(quench.Error):
            quench.medial_axis(plate(), measures=names)


def test_prunes_further_by_numbers():
    axis = quench.medial_axis(plate(), prune_by=('scale_axis', 1))
    assert len(axis.pruned(1.6).edges) < len(axis.edges)
    with pytest.raises(quench.Error, match='at least 1'):
        axis.pruned('2vox')


def test_files_are_burned_beside_the_measure(tmp_path):
    file = tmp_path / 'core.vtp'
    axis = quench.medial_axis(plate(), prune_by=('core_erosion_thickness', '2vox'))
    axis.erosion_thickness()
    axis.save(file)
    read = quench.read(file)
    assert read.pruned_by == axis.pruned_by
    assert (read.erosion_thickness() == axis.erosion_thickness()).all()
