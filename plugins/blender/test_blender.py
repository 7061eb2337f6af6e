# SPDX-License-Identifier: Apache-2.0
"""The add-on in Blender without windows: what it imports, what the sliders do, what its operators make. Ends with 77,
skipped, without Blender. `--keep FOLDER` keeps pictures and files."""
import os
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
INSIDE = r'''
import math, os, sys, zipfile
import bpy, numpy

# Installed as users do it.
bpy.ops.preferences.addon_install(filepath=os.path.abspath('quench_blender.zip'))
bpy.ops.preferences.addon_enable(module='quench_blender')
import quench_blender
from quench_blender import nodes, readers
bpy.ops.wm.read_homefile(use_empty=True)

def values_of(thing, name):
    attribute = thing.data.attributes[name]
    values = numpy.empty(len(attribute.data), numpy.float32)
    attribute.data.foreach_get('value', values)
    return values

def load(name, **more):
    assert bpy.ops.import_scene.quench(filepath=os.path.abspath(name), **more) == {'FINISHED'}
    return bpy.context.object

def shown(thing):
    """Faces of the evaluated mesh, and its instances with their scales."""
    thing.update_tag()
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(graph)
    mesh = evaluated.to_mesh()
    faces = len(mesh.polygons)
    evaluated.to_mesh_clear()
    balls = [tuple(i.matrix_world.to_scale()) for i in graph.object_instances
             if i.is_instance and i.parent and i.parent.original == thing]
    return faces, balls

# The same medial axis in three formats.
core = load('core/core.vtp')
ply, ma = load('core.ply'), load('core.ma')
radius = values_of(core, 'radius')
for other in (ply, ma):
    assert len(other.data.vertices) == len(core.data.vertices) == len(radius) > 500
    assert len(other.data.polygons) >= len(core.data.polygons) > 100
    assert numpy.allclose(values_of(other, 'radius'), radius, rtol=1e-5)
assert numpy.allclose(values_of(ply, 'erosion_thickness'), values_of(core, 'erosion_thickness'), rtol=1e-5)
assert {'burn_time', 'detail', 'detail_level', 'kind'} <= set(core.data.attributes.keys())
for thing in (ply, ma):
    bpy.data.objects.remove(thing)

# Sliders: faces whose mean erosion thickness is below theta2 go; balls have the radii.
modifier = core.modifiers['Quench']
assert modifier[nodes.identifier('Measure')] == 'erosion_thickness'
modifier[nodes.identifier('Tubes')] = 0.0
modifier[nodes.identifier('Theta1')] = 1e9  # no curves, to count the faces of sheets
measure = values_of(core, 'erosion_thickness')
faces = numpy.array([measure[list(face.vertices)].mean() for face in core.data.polygons])
for theta in (0.0, float(numpy.median(faces)), float(faces.max()) * 2):
    modifier[nodes.identifier('Theta2')] = theta
    count, balls = shown(core)
    assert abs(count - (faces >= theta).sum()) <= 2 and not balls, (theta, count, (faces >= theta).sum())
modifier[nodes.identifier('Theta2')], modifier[nodes.identifier('Theta1')] = 0.0, 0.0
modifier[nodes.identifier('Balls')] = True
count, balls = shown(core)
assert len(balls) >= len(radius) - 5
scales = sorted(scale[0] for scale in balls)
assert math.isclose(scales[-1], radius.max(), rel_tol=1e-4) and math.isclose(numpy.median(scales), numpy.median(radius), rel_tol=0.01)
modifier[nodes.identifier('Share')], modifier[nodes.identifier('Size')] = 0.2, 0.5
count, some = shown(core)
assert 0.1 * len(balls) < len(some) < 0.3 * len(balls)
assert max(scale[0] for scale in some) <= 0.5001 * radius.max()

# A skeleton with levels, and trees as curves and as a mesh.
skeleton = load('core/skeleton.vtp')
assert {'sheet_level', 'branch', 'sheet'} <= set(skeleton.data.attributes.keys())
tree = load('tree/tree.swc')
assert tree.type == 'CURVE' and len(tree.data.splines) > 1
lines = load('tree/centerlines.vtp')
assert lines.type == 'MESH' and len(lines.data.edges) > 20 and not lines.data.polygons
assert sum(len(spline.points) - 1 for spline in tree.data.splines) == len(lines.data.edges)
faces, _ = shown(lines)
assert faces > 8 * 20  # tubes

# Wrong files are refused with a sentence.
with open('wrong.ma', 'w') as file:
    file.write('3 0 1\nv 0 0 0 1\n')
try:
    assert bpy.ops.import_scene.quench(filepath=os.path.abspath('wrong.ma')) == {'CANCELLED'}
except RuntimeError as error:
    assert 'wrong.ma' in str(error), error

# Operators of an object, here a torus of quads that is turned and moved.
bpy.ops.mesh.primitive_torus_add(major_radius=1, minor_radius=0.3, major_segments=48, minor_segments=24,
                                 location=(5, 0, 1), rotation=(0.3, 0.2, 0.1))
torus = bpy.context.object
assert bpy.ops.object.quench_thickness(resolution=64) == {'FINISHED'}
thickness = values_of(torus, 'thickness')
assert len(thickness) == 48 * 24 and abs(numpy.median(thickness) - 0.6) < 0.06, numpy.median(thickness)
assert bpy.ops.object.quench_medial_axis(resolution=64, result='skeleton', theta2='inf') == {'FINISHED'}
made = bpy.context.object
bpy.context.view_layer.update()
assert made is not torus and numpy.allclose(made.matrix_world, numpy.eye(4), atol=1e-6), made.matrix_world
def around(made, size=1):
    """How far from the axis of the torus the vertices are, in the world."""
    back = torus.matrix_world.inverted()
    return [size * math.hypot(*(back @ made.matrix_world @ v.co)[:2]) for v in made.data.vertices]
away = around(made)
assert len(away) > 8 and max(abs(a - 1) for a in away) < 0.1, (min(away), max(away))
# As it is seen: twice the size and mirrored, and with a modifier.
def activate(thing):
    bpy.context.view_layer.objects.active = thing
activate(torus)
torus.scale = (2, 2, -2)
bpy.context.view_layer.update()
assert bpy.ops.object.quench_thickness(resolution=64) == {'FINISHED'} and bpy.context.object is torus
assert abs(numpy.median(values_of(torus, 'thickness')) - 1.2) < 0.12, numpy.median(values_of(torus, 'thickness'))
assert bpy.ops.object.quench_medial_axis(resolution=64, result='skeleton', theta2='inf') == {'FINISHED'}
away = around(bpy.context.object, 2)
assert len(away) > 8 and max(abs(a - 2) for a in away) < 0.2, (min(away), max(away))
assert abs(numpy.median(values_of(bpy.context.object, 'radius')) - 0.6) < 0.1
activate(torus)
torus.modifiers.new('finer', 'SUBSURF').levels = 1
assert bpy.ops.object.quench_thickness(resolution=64) == {'FINISHED'}
finer = bpy.context.object
bpy.context.view_layer.update()
assert finer is not torus and numpy.allclose(finer.matrix_world, torus.matrix_world, atol=1e-5) and not finer.modifiers
assert len(values_of(finer, 'thickness')) == 4 * 48 * 24 and abs(numpy.median(values_of(finer, 'thickness')) - 1.2) < 0.15
torus.hide_set(False)
bpy.context.view_layer.objects.active = torus
try:
    assert bpy.ops.object.quench_medial_axis(theta2='much') == {'CANCELLED'}
except RuntimeError as error:
    assert 'much' in str(error), error
bpy.ops.preferences.addon_disable(module='quench_blender')
print('inside: good')
'''
LOOK = r'''
import bpy, numpy
image = bpy.data.images.load('//view.png')
pixels = numpy.array(image.pixels[:]).reshape(-1, 4)[:, :3]
coloured = (pixels.max(axis=1) - pixels.min(axis=1) > 0.2).mean()
assert 0.02 < coloured < 0.7, coloured
print('looked: good')
'''


def run(*words, **more):
    done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False, **more)
    print('\n'.join(line for line in done.stdout.split('\n') if not line.startswith('Fra:')), end='')
    assert done.returncode == 0, words
    return done.stdout


def blender(folder, *words):
    # Blender finds Python's modules itself, and the folder it works in by PWD. No user's settings are touched.
    environment = {name: value for name, value in os.environ.items() if name != 'PYTHONPATH'}
    environment.update(BLENDER_USER_RESOURCES=os.path.join(folder, 'settings'), HOME=folder, PWD=folder)
    return run('blender', '-b', '--python-exit-code', '1', *words, cwd=folder, env=environment)


def check(folder):
    quench = os.environ.get('QUENCH', 'quench')
    for line in ('sample fin-on-board -o shape.ply', 'run shape.ply --resolution 48 --no-view --no-picture -o core',
                 'convert core/core.vtp core.ma', 'convert core/core.vtp core.ply',
                 'sample root --branches 6 --resolution 48 -o root.nrrd', 'tree root.nrrd --no-view --no-picture -o tree'):
        run(quench, *line.split(), cwd=folder)
    shutil.make_archive(os.path.join(folder, 'quench_blender'), 'zip', HERE, 'quench_blender')
    for name, text in (('inside.py', INSIDE), ('look.py', LOOK)):
        with open(os.path.join(folder, name), 'w', encoding='utf-8') as file:
            file.write(text)
    assert 'inside: good' in blender(folder, '--python', 'inside.py')
    blender(folder, '--python', os.path.join(HERE, 'render_core.py'), '--', 'core/core.vtp', '--shape', 'shape.ply', '--size',
            '160', '120', '--samples', '4', '--up', 'z', '-o', 'view.png', '--save', 'view.blend')
    assert 'looked: good' in blender(folder, 'view.blend', '--python', 'look.py')


def main():
    if not shutil.which('blender'):
        print('blender is not installed')
        return 77
    if '--keep' in sys.argv:
        folder = os.path.abspath(sys.argv[sys.argv.index('--keep') + 1])
        os.makedirs(folder)
        check(folder)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        check(folder)
    return 0


if __name__ == '__main__':
    sys.exit(main())
