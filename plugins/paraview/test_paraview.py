# SPDX-License-Identifier: Apache-2.0
"""The plug-in and the view in ParaView, without windows: filters and readers give what the program writes, the view shows
the core. Ends with 77, skipped, without pvbatch. `--keep FOLDER` keeps pictures and files."""
import os
import shutil
import subprocess
import sys
import tempfile
import types

HERE = os.path.dirname(os.path.abspath(__file__))
INSIDE = r'''
import sys
sys.path.insert(0, sys.argv[1])
import load_quench as plugin
from paraview import servermanager, simple

def points(source):
    source.UpdatePipeline()
    return source.GetDataInformation().GetNumberOfPoints()

def box(source):
    source.UpdatePipeline()
    return source.GetDataInformation().GetBounds()

def count(source, kind):
    data = servermanager.Fetch(source)
    return {'lines': data.GetNumberOfLines, 'faces': data.GetNumberOfPolys}[kind]()

core = simple.XMLPolyDataReader(FileName=['core/core.vtp'])
mesh = simple.PLYReader(FileNames=['shape.ply'])
axis = plugin.QuenchMedialAxis(Input=mesh, Resolution=48)
assert points(axis) == points(core) > 500, (points(axis), points(core))
assert axis.PointData['erosion_thickness'].GetRange() == core.PointData['erosion_thickness'].GetRange()
axis.Result = 'Skeleton'
skeleton = simple.XMLPolyDataReader(FileName=['core/skeleton.vtp'])
assert points(axis) == points(skeleton) < points(core)
axis.Theta2 = 'inf'  # curves only
axis.UpdatePipeline()
assert count(axis, 'faces') == 0 < count(axis, 'lines')

thickness = plugin.QuenchThickness(Input=mesh, Resolution=48)
assert points(thickness) == points(mesh)
low, high = thickness.PointData['thickness'].GetRange()
assert 0 < low < high

ball = simple.Wavelet(WholeExtent=[-12, 12, -12, 12, -12, 12])  # values largest in the middle
of_image = plugin.QuenchMedialAxis(Input=ball, Threshold='200', Result='Skeleton')
assert points(of_image) > 0 and max(map(abs, box(of_image))) < 12

ma = plugin.QuenchMedialAxisReader(FileName='core.ma')
assert points(ma) == points(core) and count(ma, 'faces') >= count(core, 'faces') > 0
assert max(abs(a - b) for a, b in zip(box(ma), box(core))) < 1e-5
assert abs(ma.PointData['radius'].GetRange()[1] - core.PointData['radius'].GetRange()[1]) < 1e-6
opened = simple.OpenDataFile('tree/tree.swc')
assert points(opened) > 20 and 1 < count(opened, 'lines') < points(opened)

try:
    axis.Detail = 'much'
    axis.UpdatePipeline()
except RuntimeError as error:
    print(error)
print('inside: good')
'''
LOOK = r'''
import sys
from paraview import simple
from vtkmodules.vtkIOImage import vtkPNGReader

def shares(name):
    """Of all pixels: coloured ones, grey ones that are not white."""
    reader = vtkPNGReader()
    reader.SetFileName(name)
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    scalars = image.GetPointData().GetScalars()
    coloured = grey = 0
    for i in range(0, width * height):
        r, g, b = scalars.GetTuple(i)[:3]
        coloured += max(r, g, b) - min(r, g, b) > 60
        grey += max(r, g, b) - min(r, g, b) < 30 and r < 250
    return coloured / width / height, grey / width / height

coloured, grey = shares('view.png')
assert coloured > 0.02 and grey > 0.02, (coloured, grey)
simple._DisableFirstRenderCameraReset()
simple.LoadState('core.pvsm')  # as a user opens it later
view = simple.GetActiveView()
simple.Render(view)
simple.SaveScreenshot('again.png', view, ImageResolution=[400, 320])
again = shares('again.png')
assert abs(again[0] - coloured) < 0.05, (again, coloured)
print('looked: good')
'''


def run(*words, **more):
    done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False, **more)
    print(done.stdout, end='')
    assert done.returncode == 0, words
    return done.stdout


def check(folder):
    quench = os.environ.get('QUENCH', 'quench')
    for line in ('sample fin-on-board -o shape.ply', 'run shape.ply --resolution 48 --no-view --no-picture -o core',
                 'convert core/core.vtp core.ma', 'sample root --branches 6 --resolution 48 -o root.nrrd',
                 'tree root.nrrd --no-view --no-picture -o tree'):
        run(quench, *line.split(), '--quiet' if 'convert' not in line and 'sample' not in line else '--overwrite', cwd=folder)
    for name, text in (('inside.py', INSIDE), ('look.py', LOOK)):
        with open(os.path.join(folder, name), 'w', encoding='utf-8') as file:
            file.write(text)
    assert 'inside: good' in run('pvbatch', 'inside.py', HERE, cwd=folder)
    if not os.environ.get('DISPLAY'):
        print('no screen: the view was not drawn')
        return
    run('pvbatch', os.path.join(HERE, 'show_core.py'), 'core/core.vtp', '--shape', 'shape.ply', '-o', 'view.png', '--state',
        'core.pvsm', '--size', '400', '320', cwd=folder)
    assert 'looked: good' in run('pvbatch', 'look.py', cwd=folder)


def check_macro(folder):
    """A macro, which is a copy elsewhere, finds the plug-in of an installed Quench; without ParaView, by a stand-in."""
    folder, loaded, kept = os.path.realpath(folder), [], dict(os.environ)
    for name in ('opt/bin', 'opt/share/quench/paraview', 'links'):
        os.makedirs(os.path.join(folder, name))
    program, link, wanted = (os.path.join(folder, name) for name in
                             ('opt/bin/quench', 'links/quench', 'opt/share/quench/paraview/quench_paraview.py'))
    with open(program, 'w', encoding='utf-8'), open(wanted, 'w', encoding='utf-8'):
        os.chmod(program, 0o755)
    os.symlink(program, link)
    with open(os.path.join(HERE, 'load_quench.py'), encoding='utf-8') as file:
        macro = compile(file.read(), 'macro', 'exec')
    module = types.ModuleType('paraview')
    module.simple = types.SimpleNamespace(LoadPlugin=lambda path, **_: loaded.append(path))
    sys.modules['paraview'] = module
    try:
        os.environ.pop('QUENCH_PARAVIEW', None)
        for path, named in ((os.path.dirname(program), ''), (os.path.dirname(link), ''), ('/nowhere', program), ('/nowhere', link)):
            os.environ.update(PATH=path, QUENCH=named)
            exec(macro, {'__file__': os.path.join(folder, 'macro.py'), '__name__': 'macro'})
            assert loaded.pop() == wanted, (path, named)
    finally:
        del sys.modules['paraview']
        os.environ.clear()
        os.environ.update(kept)
    print('a macro finds the plug-in beside the program')


def main():
    with tempfile.TemporaryDirectory() as folder:
        check_macro(folder)
    if not shutil.which('pvbatch'):
        print('pvbatch is not installed (paraview, python3-paraview)')
        return 77
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, 'try.py')
        with open(script, 'w', encoding='utf-8') as file:
            file.write('import paraview.simple\n')
        if subprocess.run(['pvbatch', script], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode:
            print('pvbatch has no modules of Python (python3-paraview)')
            return 77
    if '--keep' in sys.argv:
        os.makedirs(sys.argv[sys.argv.index('--keep') + 1])
        check(os.path.abspath(sys.argv[sys.argv.index('--keep') + 1]))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        check(folder)
    return 0


if __name__ == '__main__':
    sys.exit(main())
