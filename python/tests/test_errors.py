# SPDX-License-Identifier: Apache-2.0
"""Errors are of the classes that Python has for them, and still those of Quench."""
import copy
import os
import pathlib
import pickle

import numpy as np
import pytest
import quench
from shapes import bent_tube


def test_the_classes():
    assert issubclass(quench.Error, RuntimeError)
    assert issubclass(quench.UsageError, (quench.Error, ValueError)) and issubclass(quench.UsageError, ValueError)
    assert issubclass(quench.ArgumentTypeError, quench.UsageError) and issubclass(quench.ArgumentTypeError, TypeError)
    assert issubclass(quench.MissingFileError, quench.Error) and issubclass(quench.MissingFileError, FileNotFoundError)
    for name in ('Error', 'UsageError', 'ArgumentTypeError', 'MissingFileError'):
        kind = getattr(quench, name)
        assert kind.__module__ == 'quench' and kind.__doc__


@pytest.mark.parametrize('call, argument', [
    (lambda image: quench.medial_axis(image, detail=[1]), 'detail'),
    (lambda image: quench.medial_axis(image, lambda_=True), 'lambda_'),
    (lambda image: quench.medial_axis(image, threshold=object()), 'threshold'),
    (lambda image: quench.medial_axis(image, label='one'), 'label'),
    (lambda image: quench.medial_axis(image, threads='two'), 'threads'),
    (lambda image: quench.medial_axis(image, blur=None), 'blur'),
    (lambda image: quench.medial_axis(image, median=None), 'median'),
    (lambda image: quench.medial_axis(None), 'image'),
    (lambda image: quench.medial_axis(object()), 'image'),
    (lambda image: quench.medial_axis(image).skeleton(theta2={}), 'theta2'),
    (lambda image: quench.medial_axis(image).skeleton().graph(smooth='x'), 'smooth'),
    (lambda image: quench.medial_axis(image).solid(resolution='x'), 'resolution'),
    (lambda image: quench.sample('root', seed='x'), 'seed')])
def test_wrong_types_are_type_errors(call, argument):
    with pytest.raises(TypeError) as caught:
        call(bent_tube())
    assert isinstance(caught.value, quench.UsageError) and caught.value.code == 2
    assert caught.value.argument == argument


@pytest.mark.parametrize('call, argument', [
    (lambda image: quench.medial_axis(image, detail='2mm'), 'detail'),
    (lambda image: quench.medial_axis(image, detail=-1), 'detail'),
    (lambda image: quench.medial_axis(image, threads=1.5), 'threads'),
    (lambda image: quench.medial_axis(image, blur=-1), 'blur'),
    (lambda image: quench.medial_axis(image, threshold='x'), 'threshold'),
    (lambda image: quench.medial_axis(image, surface='x'), 'surface'),
    (lambda image: quench.tree(image, down='up'), 'down'),
    (lambda image: quench.tree(image, 'bush'), 'kind')])
def test_wrong_values_are_value_errors_and_no_type_errors(call, argument):
    with pytest.raises(ValueError) as caught:
        call(bent_tube())
    assert isinstance(caught.value, quench.UsageError) and not isinstance(caught.value, TypeError)
    assert caught.value.argument == argument


def test_missing_files(tmp_path):
    axis = quench.medial_axis(bent_tube())
    skeleton = axis.skeleton()
    for name in ('a.nrrd', 'a.ply', 'a.vtp', 'a.png'):
        for path in (tmp_path / name, str(tmp_path / name)):
            for call in (quench.read, quench.medial_axis, quench.skeletonize, quench.voxelize, quench.local_thickness,
                         quench.surface_thickness, quench.tree):
                with pytest.raises(FileNotFoundError, match=name) as caught:
                    call(path)
                assert isinstance(caught.value, quench.Error) and isinstance(caught.value, OSError)
                assert caught.value.code == 1 and str(caught.value) == f"'{path}' does not exist"
    for call in (quench.read_tree, quench.tree):
        with pytest.raises(FileNotFoundError, match='t.swc'):
            call(tmp_path / 't.swc')
    axis.save(tmp_path / 'there.ply')
    with pytest.raises(FileNotFoundError, match='no.r'):
        quench.read(tmp_path / 'there.ply', radii=tmp_path / 'no.r')
    tree = quench.tree(axis)
    savers = [(axis.save, '.vtp'), (axis.save, '.png'), (skeleton.save, '.vtp'), (skeleton.save, '.swc'),
              (skeleton.save, '.csv'), (skeleton.graph().save, '.csv'), (axis.solid().save, '.nrrd'),
              (skeleton.parts().save, '.vtp'), (skeleton.parts().save, '.csv'), (tree.save, '.swc'), (tree.save, '.html'),
              (quench.medial_axis(bent_tube().any(axis=2)).to_geojson, '.geojson')]
    for save, ending in savers:
        with pytest.raises(FileNotFoundError, match='nowhere'):
            save(tmp_path / 'nowhere' / ('x' + ending))
    assert sorted(os.listdir(tmp_path)) == ['there.ply']


def test_a_file_name_alone_is_in_the_folder_we_are_in(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    axis = quench.medial_axis(bent_tube())
    axis.save('a.vtp')
    axis.save(pathlib.Path('b.vtp'))
    assert quench.read('a.vtp').topology == axis.topology and os.path.exists('b.vtp')


def test_errors_are_pickled(tmp_path):
    errors = []
    for call in (lambda: quench.medial_axis(bent_tube(), detail='2mm'), lambda: quench.medial_axis(bent_tube(), detail=[]),
                 lambda: quench.read(tmp_path / 'a.nrrd'), lambda: quench.medial_axis(np.zeros((3, 3, 3), bool))):
        with pytest.raises(quench.Error) as caught:
            call()
        errors.append(caught.value)
    assert [type(error).__name__ for error in errors] == ['UsageError', 'ArgumentTypeError', 'MissingFileError', 'Error']
    for error in errors:
        for twin in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
            assert type(twin) is type(error) and str(twin) == str(error)
            assert (twin.code, twin.argument) == (error.code, error.argument)
