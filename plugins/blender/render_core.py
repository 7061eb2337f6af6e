# SPDX-License-Identifier: Apache-2.0
"""Renders a medial axis, cut by theta, in its transparent shape; beside it medial balls where asked.

    blender -b --python render_core.py -- core.vtp --shape shape.ply --theta2 0.003 --balls 0.05 -o picture.png
"""
import argparse
import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # the add-on, whether it is installed or not
import quench_blender  # noqa: E402
from quench_blender import nodes, readers  # noqa: E402


def transparent():
    material = bpy.data.materials.new('Quench shape')
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    out, clear, grey, mix = (tree.nodes.new(kind) for kind in ('ShaderNodeOutputMaterial', 'ShaderNodeBsdfTransparent',
                                                               'ShaderNodeBsdfDiffuse', 'ShaderNodeMixShader'))
    rim = tree.nodes.new('ShaderNodeLayerWeight')
    rim.inputs['Blend'].default_value = 0.12
    grey.inputs['Color'].default_value = (0.45, 0.5, 0.6, 1)
    tree.links.new(rim.outputs['Facing'], mix.inputs['Fac'])
    tree.links.new(clear.outputs['BSDF'], mix.inputs[1])
    tree.links.new(grey.outputs['BSDF'], mix.inputs[2])
    tree.links.new(mix.outputs['Shader'], out.inputs['Surface'])
    return material


def main():
    parser = argparse.ArgumentParser(prog='render_core.py')
    parser.add_argument('core')
    parser.add_argument('--shape')
    parser.add_argument('--theta2', type=float, default=0.0)
    parser.add_argument('--theta1', type=float, default=0.0)
    parser.add_argument('--balls', type=float, default=0.0, help='the share of vertices whose balls are shown, beside')
    parser.add_argument('--turn', type=float, default=25.0)
    parser.add_argument('--up', default='y', choices='yz')
    parser.add_argument('--size', type=int, nargs=2, default=[800, 640])
    parser.add_argument('--samples', type=int, default=48)
    parser.add_argument('-o', '--output', required=True)
    parser.add_argument('--save', help='the scene as .blend')
    o = parser.parse_args(sys.argv[sys.argv.index('--') + 1:])

    bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types, 'IMPORT_SCENE_OT_quench'):
        quench_blender.register()
    bpy.ops.import_scene.quench(filepath=os.path.abspath(o.core))
    core = bpy.context.object
    size = max(core.dimensions)
    low, high = (Vector(f(corner[i] for corner in core.bound_box) for i in range(3)) for f in (min, max))
    upright = Matrix.Rotation(math.pi / 2 if o.up == 'y' else 0, 4, 'X')
    place = Matrix.Rotation(math.radians(o.turn), 4, 'Z') @ upright @ Matrix.Translation(-(low + high) / 2)
    core.matrix_world = place
    modifier = core.modifiers['Quench']
    modifier[nodes.identifier('Theta2')], modifier[nodes.identifier('Theta1')] = o.theta2, o.theta1
    shown = [core]
    if o.balls:
        balls = core.copy()  # the same mesh, other sliders
        bpy.context.collection.objects.link(balls)
        for name, value in (('Axis', False), ('Balls', True), ('Share', o.balls)):
            balls.modifiers['Quench'][nodes.identifier(name)] = value
        surface = nodes.ball_material().node_tree.nodes['Principled BSDF']
        surface.inputs['Alpha'].default_value = 1
        surface.inputs['Base Color'].default_value = (0.1, 0.22, 0.4, 1)
        surface.inputs['Roughness'].default_value = 0.35
        balls.matrix_world = Matrix.Translation((size * 0.9, 0, 0)) @ place
        shown.append(balls)
    if o.shape:
        data = readers.read(o.shape)
        mesh = bpy.data.meshes.new('shape')
        mesh.from_pydata(data.points.tolist(), [], data.faces)
        mesh.polygons.foreach_set('use_smooth', [True] * len(mesh.polygons))
        mesh.materials.append(transparent())
        shape = bpy.data.objects.new('shape', mesh)
        shape.matrix_world = place
        bpy.context.collection.objects.link(shape)

    scene = bpy.context.scene
    world = scene.world = bpy.data.worlds.new('white')
    world.use_nodes = True
    world.node_tree.nodes['Background'].inputs['Color'].default_value = (1, 1, 1, 1)
    world.node_tree.nodes['Background'].inputs['Strength'].default_value = 0.55
    sun = bpy.data.objects.new('sun', bpy.data.lights.new('sun', 'SUN'))
    sun.data.energy, sun.data.angle = 2.2, 0.1
    sun.rotation_euler = (0.7, 0.2, 0.5)
    scene.collection.objects.link(sun)
    camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
    camera.data.type, camera.data.ortho_scale = 'ORTHO', size * (1.15 if len(shown) == 1 else 1.95)
    middle = size * 0.45 * (len(shown) - 1)
    camera.location, camera.rotation_euler = (middle, -5 * size, 0.6 * size), (math.pi / 2 - 0.12, 0, 0)
    camera.data.clip_end = 100 * size
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = 'CYCLES', o.samples, False
    scene.cycles.transparent_max_bounces = 32
    scene.render.film_transparent = True
    scene.view_settings.view_transform = 'Standard'
    scene.render.resolution_x, scene.render.resolution_y = o.size
    scene.render.filepath = os.path.abspath(o.output)
    if o.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(o.save))
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)  # on white
    pixels = numpy.array(image.pixels[:]).reshape(-1, 4)
    pixels = pixels[:, :3] * pixels[:, 3:] + 1 - pixels[:, 3:]
    image.pixels = numpy.c_[pixels, numpy.ones(len(pixels))].ravel()
    image.save()


main()
