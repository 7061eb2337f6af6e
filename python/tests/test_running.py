# SPDX-License-Identifier: Apache-2.0
"""Long calls: progress, Ctrl-C, other threads, package hygiene."""
import inspect
import os
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs


@pytest.fixture(scope='module')
def long_input():
    """Tens of seconds of work."""
    return quench.sample('root', branches=300)


@pytest.mark.parametrize('delay', [0.2, 1.5])
def test_ctrl_c_stops_soon(long_input, delay):
    threading.Timer(delay, os.kill, (os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        quench.medial_axis(long_input, resolution=1500).skeleton()
        time.sleep(20)
    assert time.monotonic() - start < delay + 20
    assert quench.medial_axis(bent_tube()).topology.betti == (1, 0, 0)  # and nothing is left behind


def test_ctrl_c_stops_labels():
    image = np.kron(np.arange(1, 28).reshape(3, 3, 3), np.ones((40, 40, 40), int))
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        quench.skeletonize(image, detail=0)
        time.sleep(20)


def test_labels_are_done_by_the_threads_there_are():
    """Stacks of half a gigabyte in two and a half of addresses: the fourth or fifth thread cannot be started."""
    code = """
import resource, quench
import numpy as np
image = np.kron(np.arange(1, 28).reshape(3, 3, 3), np.ones((4, 4, 4), int))
wanted = quench.skeletonize(image, threads=1)
with open('/proc/self/statm') as file:
    used = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (5 << 29), resource.getrlimit(resource.RLIMIT_AS)[1]))
found = quench.skeletonize(image, threads=16)
print(len(found), all(np.array_equal(found[k].vertices, wanted[k].vertices) for k in wanted))
"""
    most = resource.getrlimit(resource.RLIMIT_STACK)[1]
    if most != resource.RLIM_INFINITY and most < 1 << 29:
        pytest.skip('stacks of this size are not allowed')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (1 << 29, most)))
    assert (done.returncode, done.stdout) == (0, '27 True\n'), done.stderr


def test_more_threads_than_processors_are_silent():
    code = 'import numpy, quench; quench.medial_axis(numpy.ones((30, 30, 30), bool), threads=200).skeleton()'
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_progress_is_reported_to_a_function():
    seen = []
    axis = quench.medial_axis(blobs(30), progress=lambda stage, fraction: seen.append((stage, fraction)))
    axis.skeleton()
    assert {'foreground', 'peel', 'burn', 'curves'} <= {stage for stage, _ in seen}
    assert all(0 <= fraction <= 1 for _, fraction in seen)
    main = []
    quench.skeletonize(blobs(31), progress=lambda stage, fraction: main.append(threading.current_thread()))
    assert set(main) == {threading.main_thread()}


def test_an_exception_in_progress_comes_out():
    class Enough(Exception):
        pass

    def stop(stage, fraction):
        raise Enough(stage)
    with pytest.raises(Enough):
        quench.medial_axis(blobs(32), progress=stop)


@pytest.mark.parametrize('with_tqdm', [True, False])
def test_progress_on_the_terminal(with_tqdm):
    hide = '' if with_tqdm else 'import sys; sys.modules["tqdm"] = None\n'
    code = hide + 'import numpy, quench; quench.medial_axis(numpy.ones((40, 40, 40), bool), progress=True).skeleton()'
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.returncode == 0 and 'peel' in done.stderr and done.stdout == ''


def test_silence():
    code = 'import numpy, quench; quench.medial_axis(numpy.ones((30, 30, 30), bool)).skeleton()'
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_other_threads_run_meanwhile():
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.005)
    thread = threading.Thread(target=tick)
    thread.start()
    start = time.monotonic()
    quench.medial_axis(np.ones((120, 110, 100), bool))
    end = time.monotonic()
    done.set()
    thread.join()
    inside = [t for t in ticks if start < t < end]
    assert len(inside) > 10 and np.diff(inside).max() < max(0.5, (end - start) / 2)


def test_several_at_a_time():
    images = [blobs(40 + i) for i in range(4)]
    alone = [quench.medial_axis(image).skeleton().vertices for image in images]
    results = [None] * len(images)

    def work(i):
        results[i] = quench.medial_axis(images[i], threads=i % 3).skeleton().vertices
    threads = [threading.Thread(target=work, args=(i, )) for i in range(len(images))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(alone, results))


def test_one_axis_in_several_threads():
    axis = quench.medial_axis(blobs(50))
    wanted = axis.skeleton(0.05).vertices
    axis.forget()
    results = []
    calls = [lambda: axis.skeleton(0.05).vertices, lambda: axis.erosion_thickness(omega='0.3vox'), axis.burn_time] * 3
    threads = [threading.Thread(target=lambda c=call: results.append(c())) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 9 and sum(np.array_equal(r, wanted) for r in results) == 3


def test_errors_are_quench_errors():
    with pytest.raises(quench.Error) as caught:
        quench.medial_axis(np.zeros((3, 3, 3), bool))
    assert isinstance(caught.value, RuntimeError) and caught.value.code == 3
    assert quench.Error.__module__ == 'quench' and str(caught.value).startswith('no voxel')


def test_everything_public_is_documented_and_typed():
    assert os.path.exists(os.path.join(os.path.dirname(quench.__file__), 'py.typed'))
    for name in quench.__all__:
        value = getattr(quench, name)
        if name.startswith('__'):
            continue
        assert value.__doc__, name
        for member, function in inspect.getmembers(value, inspect.isfunction):
            if not member.startswith('_'):
                assert function.__doc__, (name, member)
                assert 'return' in function.__annotations__, (name, member)
        if inspect.isfunction(value):
            assert set(inspect.signature(value).parameters) | {'return'} >= set(value.__annotations__)


def test_import_needs_numpy_only():
    code = ('import sys\nfor name in ("matplotlib", "scipy", "skimage", "networkx", "trimesh", "pyvista", "tqdm", "pandas"):\n'
            '    sys.modules[name] = None\nimport numpy, quench\n'
            'print(len(quench.medial_axis(numpy.ones((9, 9, 9), bool)).skeleton().vertices) > 0)')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    assert done.stdout == 'True\n', done.stderr


def test_wrong_arguments_are_value_errors():
    image = bent_tube()
    axis = quench.medial_axis(image)
    for call, argument in ((lambda: quench.medial_axis(image, lambda_='2mm'), 'lambda_'),
                           (lambda: quench.medial_axis(image, detail=None), 'detail'),
                           (lambda: quench.medial_axis(image, detail='2mm'), 'detail'),
                           (lambda: quench.medial_axis(image, detail=0, lambda_=0), 'lambda_'),
                           (lambda: quench.skeletonize(image, lambda_='2mm'), 'lambda_'),
                           (lambda: axis.pruned(lambda_='2vox'), 'lambda_'),
                           (lambda: axis.pruned(0), 'detail'),
                           (lambda: quench.medial_axis(image, subdivide=65), 'subdivide'),
                           (lambda: quench.medial_axis(image, threads=-1), 'threads'),
                           (lambda: axis.skeleton(theta2='x'), 'theta2'),
                           (lambda: axis.skeleton().graph(resample='inf'), 'resample'),
                           (lambda: axis.skeleton().graph(smooth=20000), 'smooth'),
                           (lambda: axis.erosion_thickness(omega=0), 'omega'),
                           (lambda: quench.medial_axis(quench.sample('torus'), resolution=99999), 'resolution')):
        with pytest.raises(ValueError) as caught:
            call()
        error = caught.value
        assert isinstance(error, quench.UsageError) and isinstance(error, quench.Error), error
        assert error.code == 2 and error.argument == argument and str(error).startswith(argument + '='), error
    with pytest.raises(quench.Error) as caught:  # an input that cannot be used is not a wrong argument
        quench.medial_axis(np.zeros((3, 3, 3), bool))
    assert not isinstance(caught.value, ValueError) and caught.value.argument == 'threshold'


def test_threads_and_progress_of_every_long_call(tmp_path):
    axis = quench.medial_axis(bent_tube())
    skeleton = axis.skeleton()
    wanted = skeleton.to_volume()
    for call in (axis.pruned, axis.erosion_thickness, axis.burn_time, axis.skeleton, axis.reconstruct, axis.verify,
                 axis.save, skeleton.verify, skeleton.to_volume, skeleton.reconstruct, skeleton.graph,
                 skeleton.reconstructed_share, skeleton.save, quench.medial_axis, quench.read, quench.voxelize,
                 quench.skeletonize):
        assert {'threads', 'progress'} <= set(inspect.signature(call).parameters), call
    stages = []
    for call in (axis.verify, axis.reconstruct, skeleton.verify, skeleton.reconstruct, skeleton.to_volume):
        heard = []
        call(threads=1, progress=lambda stage, fraction: heard.append(stage))
        stages.append(bool(heard))
        with pytest.raises(ValueError, match='threads'):
            call(threads=-1)
    assert stages[0] and stages[2], stages
    assert np.array_equal(skeleton.to_volume(threads=2), wanted)


def test_old_spellings_work_and_warn():
    axis = quench.medial_axis(bent_tube(), lambda_='auto')
    skeleton = axis.skeleton()
    with pytest.warns(DeprecationWarning, match='face_lambda_level'):
        assert np.array_equal(axis.lambda_level, axis.face_lambda_level)
    with pytest.warns(DeprecationWarning, match='reconstructed_share'):
        assert skeleton.reconstructed == skeleton.reconstructed_share()
    assert len(axis.edge_lambda) == len(axis.edges) and len(axis.vertex_lambda) == len(axis.vertices)


def test_modules_are_imported_in_one_direction():
    """No import of a module of the package inside a function, and none that leads back."""
    import ast
    folder = os.path.dirname(quench.__file__)
    leads_to = {}
    for name in os.listdir(folder):
        if not name.endswith('.py'):
            continue
        with open(os.path.join(folder, name), encoding='utf-8') as file:
            tree = ast.parse(file.read())
        leads_to[name[:-3]] = set()
        for node in tree.body:
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                leads_to[name[:-3]] |= {node.module} if node.module else {alias.name for alias in node.names}
        inside = [n for top in tree.body if isinstance(top, (ast.FunctionDef, ast.ClassDef)) for n in ast.walk(top)
                  if isinstance(n, ast.ImportFrom) and n.level]
        assert not inside, (name, [n.lineno for n in inside])
    left = dict(leads_to)
    while left:
        free = [name for name, others in left.items() if not others & set(left)]
        assert free, left
        for name in free:
            del left[name]
