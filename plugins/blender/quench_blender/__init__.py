# SPDX-License-Identifier: Apache-2.0
"""Medial axes and skeletons of Quench in Blender: import of .vtp, .ply, .ma and .swc, sliders for theta, medial balls; and
the medial axis or the thickness of an object, by the program."""
import os
import shutil
import subprocess
import tempfile

import bpy
import numpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import nodes, readers

bl_info = {
    'name': 'Quench: medial axes and skeletons',
    'author': 'The authors of Quench',
    'version': (0, 1, 0),
    'blender': (3, 4, 0),
    'location': 'File > Import > Quench; View3D > Sidebar > Quench',
    'description': 'Imports medial axes, skeletons and trees; medial axis and thickness of an object',
    'category': 'Import-Export',
}

LARGEST = 1e38  # what is more stands for infinite


def attribute(mesh, name, domain, values):
    whole = numpy.issubdtype(values.dtype, numpy.integer)
    made = mesh.attributes.new(name, 'INT' if whole else 'FLOAT', domain)
    made.data.foreach_set('value', numpy.ascontiguousarray(values, numpy.int32 if whole else numpy.float32))


def mesh_of(data, name):
    """A mesh with all arrays as attributes; those of edges are called 'curve_...', where faces have them, too."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(data.points.tolist(), data.edges.tolist(), data.faces)
    for array, values in data.of_points.items():
        attribute(mesh, array, 'POINT', values)
    used = set(data.of_points)
    for array, values in data.of_faces.items():
        if len(values) == len(mesh.polygons) and len(values):
            attribute(mesh, array if array not in used else 'face_' + array, 'FACE', values)
            used.add(array)
    given = {tuple(sorted(edge)): i for i, edge in enumerate(data.edges.tolist())}
    order = [given.get(tuple(sorted(edge.vertices)), -1) for edge in mesh.edges] if given else []
    for array, values in data.of_edges.items():
        if given and len(values) == len(data.edges):
            padded = numpy.append(values, values.dtype.type(0))  # of sides of faces: 0
            attribute(mesh, array if array not in used else 'curve_' + array, 'EDGE', padded[order])
    return mesh


def curve_of(data, name):
    """Branches as splines with their radii."""
    curve = bpy.data.curves.new(name, 'CURVE')
    curve.dimensions, curve.bevel_depth, curve.use_fill_caps = '3D', 1.0, True
    radius = data.of_points.get('radius', numpy.full(len(data.points), data.size / 200))
    for path in data.paths:
        spline = curve.splines.new('POLY')
        spline.points.add(len(path) - 1)
        ids = numpy.array(path)
        spline.points.foreach_set('co', numpy.c_[data.points[ids], numpy.ones(len(ids))].ravel())
        spline.points.foreach_set('radius', radius[ids])
    return curve


def percentile(values, share):
    values = values[numpy.abs(values) < LARGEST]
    return float(numpy.quantile(values, share)) if len(values) else 1.0


def add_object(context, data, name, measure='', as_curves=False):
    """An object of what was read, with material and sliders. Returns it."""
    if as_curves and data.paths and not data.faces:
        made = bpy.data.objects.new(name, curve_of(data, name))
        context.collection.objects.link(made)
    else:
        made = bpy.data.objects.new(name, mesh_of(data, name))
        context.collection.objects.link(made)
        if measure not in data.of_points:
            measure = next((m for m in ('erosion_thickness', 'thickness', 'radius') if m in data.of_points), '')
        if measure:
            values = data.of_points[measure].astype(float)
            low = 0.0 if 'thickness' in measure and measure != 'thickness' else percentile(values, 0.02)
            made.data.materials.append(nodes.measure_material(f'{name} {measure}', measure, low, percentile(values, 0.98)))
        if 'radius' in data.of_points:
            modifier = made.modifiers.new('Quench', 'NODES')
            modifier.node_group = nodes.group()
            modifier[nodes.identifier('Tubes')] = data.size / 400
            if measure:
                modifier[nodes.identifier('Measure')] = 'erosion_thickness' if 'erosion_thickness' in data.of_points else measure
    for other in context.selected_objects:
        other.select_set(False)
    made.select_set(True)
    context.view_layer.objects.active = made
    return made


class ImportQuench(bpy.types.Operator, ImportHelper):
    """Import a medial axis, a skeleton or a tree"""
    bl_idname, bl_label, bl_options = 'import_scene.quench', 'Import Quench', {'REGISTER', 'UNDO'}
    filter_glob: StringProperty(default='*.vtp;*.ply;*.ma;*.swc', options={'HIDDEN'})
    measure: StringProperty(name='Colour by', default='erosion_thickness', description='An array of points')
    as_curves: BoolProperty(name='Trees as curves', default=True,
                            description='Files without sheets become curves with their radii; else meshes with attributes')
    scale: FloatProperty(name='Scale', default=1.0, min=1e-9, description='Of the object; its attributes stay')

    def execute(self, context):
        name = os.path.basename(self.filepath)
        try:
            data = readers.read(self.filepath)
        except (OSError, ValueError) as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}
        as_curves = self.as_curves and name.lower().endswith('.swc')
        made = add_object(context, data, os.path.splitext(name)[0], self.measure, as_curves)
        made.scale = (self.scale,) * 3
        self.report({'INFO'}, f'{len(data.points)} points, {len(data.edges)} edges of curves, {len(data.faces)} faces')
        return {'FINISHED'}


# ------------------------------------------------------------------------------------------------------- the program


def program():
    """Its path; raises RuntimeError where there is none."""
    addon = bpy.context.preferences.addons.get(__package__)
    for path in (addon.preferences.program if addon else '', os.environ.get('QUENCH'), shutil.which('quench')):
        if path and os.path.isfile(path) and os.access(path, os.X_OK):
            return path
    raise RuntimeError("the program 'quench' is not in PATH; name it in the preferences of the add-on")


def run(*words):
    done = subprocess.run([program(), *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().split('\n')[-1])


def write_mesh(mesh, path, matrix):
    """Triangles of the mesh, in the world by a matrix, as PLY, with all its vertices in their order."""
    mesh.calc_loop_triangles()
    points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get('co', points)
    matrix = numpy.array(matrix)
    points = (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]).ravel()
    corners = numpy.empty(3 * len(mesh.loop_triangles), numpy.int32)
    mesh.loop_triangles.foreach_get('vertices', corners)
    table = numpy.empty(len(corners) // 3, [('n', 'u1'), ('ids', '<i4', (3,))])
    table['n'], table['ids'] = 3, corners.reshape(-1, 3)[:, ::-1 if numpy.linalg.det(matrix[:3, :3]) < 0 else 1]
    header = ('ply\nformat binary_little_endian 1.0\n'
              f'element vertex {len(points) // 3}\nproperty float x\nproperty float y\nproperty float z\n'
              f'element face {len(table)}\nproperty list uchar int vertex_indices\nend_header\n')
    with open(path, 'wb') as file:
        file.write(header.encode() + points.astype('<f4').tobytes() + table.tobytes())


class OfObject:
    """What operators of the active object share."""
    bl_options = {'REGISTER', 'UNDO'}
    resolution: IntProperty(name='Resolution', default=128, min=16, soft_max=512, max=4096,
                            description='Voxels along the longest side')

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == 'MESH' and context.mode == 'OBJECT'

    @staticmethod
    def write(context, path):
        """Writes the object as it is seen: with its modifiers, in the world. Returns how many vertices that has."""
        shape = context.object
        if not shape.matrix_world.determinant():
            raise RuntimeError('the object is flat: its scale is 0 along an axis')
        evaluated = shape.evaluated_get(context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        try:
            write_mesh(mesh, path, shape.matrix_world)
            return len(mesh.vertices)
        finally:
            evaluated.to_mesh_clear()

    def execute(self, context):
        try:
            with tempfile.TemporaryDirectory(prefix='quench-') as folder:
                return self.work(context, folder)
        except (OSError, RuntimeError, ValueError) as error:
            self.report({'ERROR'}, str(error))
            return {'CANCELLED'}


class MedialAxisOfObject(OfObject, bpy.types.Operator):
    """Medial axis or skeleton of the active object, which is closed, by the program; with its modifiers, sizes of the world"""
    bl_idname, bl_label = 'object.quench_medial_axis', 'Medial axis'
    result: EnumProperty(name='Result', items=(('core', 'Medial axis', 'Pruned of what is noise'),
                                               ('skeleton', 'Skeleton', 'Sheets and curves')))
    detail: StringProperty(name='Detail', default='auto', description='What sticks out less is dropped')
    theta2: StringProperty(name='Theta2', default='auto', description='Sheets of a smaller erosion thickness are dropped')
    theta1: StringProperty(name='Theta1', default='auto', description='Branches that stick out less are dropped')

    def work(self, context, folder):
        shape = context.object
        source, out = os.path.join(folder, 'shape.ply'), os.path.join(folder, 'out')
        self.write(context, source)
        run('run', source, '--resolution', str(self.resolution), '--detail', self.detail, '--theta2', self.theta2, '--theta1',
            self.theta1, '--no-view', '--no-picture', '-o', out)
        add_object(context, readers.read(os.path.join(out, self.result + '.vtp')), f'{shape.name} {self.result}')
        return {'FINISHED'}


class ThicknessOfObject(OfObject, bpy.types.Operator):
    """Local thickness at the vertices of the active object, which is closed: the attribute 'thickness', in sizes of the world.
    Where modifiers make other vertices, a copy with the modifiers applied gets it"""
    bl_idname, bl_label = 'object.quench_thickness', 'Thickness'

    def work(self, context, folder):
        shape = context.object
        source, out = os.path.join(folder, 'shape.ply'), os.path.join(folder, 'thickness.vtp')
        count = self.write(context, source)
        run('thickness', source, '--resolution', str(self.resolution), '--surface', out)
        values = readers.read(out).of_points['thickness']
        if len(values) != count:
            raise RuntimeError('the object has vertices without faces; remove them')
        if count != len(shape.data.vertices):
            shape = self.applied(context, shape)
        mesh = shape.data
        if 'thickness' in mesh.attributes:
            mesh.attributes.remove(mesh.attributes['thickness'])
        attribute(mesh, 'thickness', 'POINT', values)
        mesh.materials.append(nodes.measure_material(f'{mesh.name} thickness', 'thickness', percentile(values, 0.02),
                                                     percentile(values, 0.98)))
        shape.active_material_index = len(mesh.materials) - 1
        mesh.polygons.foreach_set('material_index', [len(mesh.materials) - 1] * len(mesh.polygons))
        mesh.update()
        return {'FINISHED'}

    def applied(self, context, shape):
        """A copy of the object with its modifiers applied, in its place."""
        graph = context.evaluated_depsgraph_get()
        mesh = bpy.data.meshes.new_from_object(shape.evaluated_get(graph), depsgraph=graph)
        made = bpy.data.objects.new(f'{shape.name} thickness', mesh)
        context.collection.objects.link(made)
        made.matrix_world = shape.matrix_world
        shape.select_set(False)
        shape.hide_set(True)
        made.select_set(True)
        context.view_layer.objects.active = made
        self.report({'INFO'}, f'{made.name}: a copy with the modifiers applied; {shape.name} is hidden')
        return made


class QuenchPanel(bpy.types.Panel):
    bl_idname, bl_label = 'VIEW3D_PT_quench', 'Quench'
    bl_space_type, bl_region_type, bl_category = 'VIEW_3D', 'UI', 'Quench'

    def draw(self, context):
        layout = self.layout
        layout.operator(ImportQuench.bl_idname, icon='IMPORT')
        layout.operator(MedialAxisOfObject.bl_idname)
        layout.operator(ThicknessOfObject.bl_idname)
        modifier = context.object.modifiers.get('Quench') if context.object else None
        if modifier and modifier.node_group:
            for socket in nodes.sliders(modifier.node_group):
                layout.prop(modifier, f'["{socket.identifier}"]', text=socket.name)


class QuenchPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name='Program', subtype='FILE_PATH', description="'quench', where it is not in PATH")

    def draw(self, _):
        self.layout.prop(self, 'program')


CLASSES = (ImportQuench, MedialAxisOfObject, ThicknessOfObject, QuenchPanel, QuenchPreferences)


def menu(self, _):
    self.layout.operator(ImportQuench.bl_idname, text='Quench (.vtp, .ply, .ma, .swc)')


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.TOPBAR_MT_file_import.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
