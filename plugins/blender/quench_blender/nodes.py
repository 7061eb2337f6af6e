# SPDX-License-Identifier: Apache-2.0
"""The group of geometry nodes with the sliders, and the materials."""
import bpy

GROUP = 'Quench'
# Names and kinds of what the sliders set, with their values; lengths are set from the size of the object.
INPUTS = (('Theta2', 'NodeSocketFloat', 0.0, 'Sheets: faces of a smaller measure are hidden'),
          ('Theta1', 'NodeSocketFloat', 0.0, 'Curves: edges of a smaller measure are hidden'),
          ('Measure', 'NodeSocketString', 'erosion_thickness', 'The attribute that both compare'),
          ('Axis', 'NodeSocketBool', True, 'Whether sheets and curves are shown'),
          ('Tubes', 'NodeSocketFloat', 0.01, 'Radius of the tubes that show curves'),
          ('Balls', 'NodeSocketBool', False, 'Whether medial balls are shown'),
          ('Share', 'NodeSocketFloat', 1.0, 'The share of vertices whose balls are shown'),
          ('Size', 'NodeSocketFloat', 1.0, 'Radii of balls are multiplied by this'))
VIRIDIS = ((0.0, 0.267, 0.005, 0.329), (0.25, 0.229, 0.322, 0.546), (0.5, 0.127, 0.566, 0.551), (0.75, 0.369, 0.789, 0.383),
           (1.0, 0.993, 0.906, 0.144))


def linear(value):
    """Of a colour as screens have it."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055)**2.4


def new_socket(tree, kind, name, inwards=True):
    if hasattr(tree, 'interface'):  # from Blender 4.0 on
        return tree.interface.new_socket(name, in_out='INPUT' if inwards else 'OUTPUT', socket_type=kind)
    return (tree.inputs if inwards else tree.outputs).new(kind, name)


def sliders(tree):
    """The inputs of a group but the first, which is the geometry."""
    if hasattr(tree, 'interface'):
        return [item for item in tree.interface.items_tree if item.item_type == 'SOCKET' and item.in_out == 'INPUT'][1:]
    return list(tree.inputs)[1:]


def group():
    """The group, made once per file."""
    found = bpy.data.node_groups.get(GROUP)
    if found:
        return found
    tree = bpy.data.node_groups.new(GROUP, 'GeometryNodeTree')
    new_socket(tree, 'NodeSocketGeometry', 'Geometry')
    for name, kind, value, text in INPUTS:
        socket = new_socket(tree, kind, name)
        socket.default_value, socket.description = value, text
        if kind == 'NodeSocketFloat':
            socket.min_value = 0
            socket.max_value = 1 if name == 'Share' else 1e30
    new_socket(tree, 'NodeSocketGeometry', 'Geometry', False)

    def node(kind, **values):
        made = tree.nodes.new(kind)
        for name, value in values.items():
            setattr(made, name, value)
        made.location = (200 * (len(tree.nodes) % 8), -260 * (len(tree.nodes) // 8))
        return made

    def link(a, b):
        tree.links.new(a, b)

    def output(of, name='Geometry'):
        return next(socket for socket in of.outputs if socket.name == name and socket.enabled)

    given, result = node('NodeGroupInput'), node('NodeGroupOutput')

    def below(theta):
        """Whether the measure is below a slider."""
        measure = node('GeometryNodeInputNamedAttribute', data_type='FLOAT')
        compare = node('FunctionNodeCompare', data_type='FLOAT', operation='LESS_THAN')
        link(given.outputs['Measure'], measure.inputs['Name'])
        link(output(measure, 'Attribute'), compare.inputs[0])
        link(given.outputs[theta], compare.inputs[1])
        return compare.outputs['Result']

    def no_faces():
        """Whether an edge is one of a curve."""
        neighbours = node('GeometryNodeInputMeshEdgeNeighbors')
        compare = node('FunctionNodeCompare', data_type='INT', operation='EQUAL')
        link(neighbours.outputs['Face Count'], compare.inputs[2])
        return compare.outputs['Result']

    def both(a, b):
        logic = node('FunctionNodeBooleanMath', operation='AND')
        link(a, logic.inputs[0])
        link(b, logic.inputs[1])
        return logic.outputs['Boolean']

    # Curves and sheets apart, so that no edge of a sheet becomes a curve when the sheet goes.
    curves = node('GeometryNodeSeparateGeometry', domain='EDGE')
    link(given.outputs['Geometry'], curves.inputs['Geometry'])
    link(no_faces(), curves.inputs['Selection'])
    cut_curves = node('GeometryNodeDeleteGeometry', domain='EDGE', mode='ALL')
    link(curves.outputs['Selection'], cut_curves.inputs['Geometry'])
    link(below('Theta1'), cut_curves.inputs['Selection'])
    sheets = node('GeometryNodeDeleteGeometry', domain='EDGE', mode='EDGE_FACE')
    link(given.outputs['Geometry'], sheets.inputs['Geometry'])
    link(no_faces(), sheets.inputs['Selection'])
    cut_sheets = node('GeometryNodeDeleteGeometry', domain='FACE', mode='ALL')
    link(sheets.outputs['Geometry'], cut_sheets.inputs['Geometry'])
    link(below('Theta2'), cut_sheets.inputs['Selection'])

    tubes, circle = node('GeometryNodeCurveToMesh'), node('GeometryNodeCurvePrimitiveCircle', mode='RADIUS')
    lines = node('GeometryNodeMeshToCurve')
    circle.inputs['Resolution'].default_value = 8
    link(given.outputs['Tubes'], circle.inputs['Radius'])
    link(cut_curves.outputs['Geometry'], lines.inputs['Mesh'])
    link(lines.outputs['Curve'], tubes.inputs['Curve'])
    link(circle.outputs['Curve'], tubes.inputs['Profile Curve'])
    axis = node('GeometryNodeJoinGeometry')
    link(tubes.outputs['Mesh'], axis.inputs[0])
    link(cut_sheets.outputs['Geometry'], axis.inputs[0])

    # A vertex of sheets and curves would have its ball twice: the points of both, and one of a place.
    of_balls = node('GeometryNodeJoinGeometry')
    link(cut_sheets.outputs['Geometry'], of_balls.inputs[0])
    link(cut_curves.outputs['Geometry'], of_balls.inputs[0])
    merged = node('GeometryNodeMergeByDistance')
    merged.inputs['Distance'].default_value = 0
    link(of_balls.outputs['Geometry'], merged.inputs['Geometry'])
    chance = node('FunctionNodeRandomValue', data_type='BOOLEAN')
    link(given.outputs['Share'], chance.inputs['Probability'])
    ball = node('GeometryNodeMeshIcoSphere')
    ball.inputs['Radius'].default_value, ball.inputs['Subdivisions'].default_value = 1, 3
    smooth = node('GeometryNodeSetShadeSmooth')
    link(ball.outputs['Mesh'], smooth.inputs['Geometry'])
    radius = node('GeometryNodeInputNamedAttribute', data_type='FLOAT')
    radius.inputs['Name'].default_value = 'radius'
    scale = node('ShaderNodeMath', operation='MULTIPLY')
    link(output(radius, 'Attribute'), scale.inputs[0])
    link(given.outputs['Size'], scale.inputs[1])
    points = node('GeometryNodeMeshToPoints', mode='VERTICES')
    link(merged.outputs['Geometry'], points.inputs['Mesh'])
    link(output(chance, 'Value'), points.inputs['Selection'])
    balls = node('GeometryNodeInstanceOnPoints')
    link(points.outputs['Points'], balls.inputs['Points'])
    link(smooth.outputs['Geometry'], balls.inputs['Instance'])
    link(scale.outputs['Value'], balls.inputs['Scale'])
    glass = node('GeometryNodeSetMaterial')
    glass.inputs['Material'].default_value = ball_material()
    link(balls.outputs['Instances'], glass.inputs['Geometry'])

    # What is not shown is left out by a switch.
    shown = node('GeometryNodeJoinGeometry')
    for flag, geometry in (('Axis', axis.outputs['Geometry']), ('Balls', glass.outputs['Geometry'])):
        switch = node('GeometryNodeSwitch', input_type='GEOMETRY')
        link(given.outputs[flag], next(s for s in switch.inputs if s.name == 'Switch' and s.enabled))
        link(geometry, next(s for s in switch.inputs if s.name == 'True' and s.enabled))
        link(next(s for s in switch.outputs if s.enabled), shown.inputs[0])
    link(shown.outputs['Geometry'], result.inputs['Geometry'])
    return tree


def ball_material():
    found = bpy.data.materials.get('Quench balls')
    if found:
        return found
    material = bpy.data.materials.new('Quench balls')
    material.use_nodes = True
    material.diffuse_color = (0.75, 0.8, 0.9, 0.2)
    material.blend_method = 'BLEND'
    surface = material.node_tree.nodes['Principled BSDF']
    surface.inputs['Base Color'].default_value = (0.75, 0.8, 0.9, 1)
    surface.inputs['Alpha'].default_value = 0.15
    return material


def measure_material(name, attribute, low, high):
    """Colours by an attribute, from low to high."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    value = nodes.new('ShaderNodeAttribute')
    value.attribute_name, value.name = attribute, 'Quench measure'
    span = nodes.new('ShaderNodeMapRange')
    span.name = 'Quench range'
    span.inputs['From Min'].default_value, span.inputs['From Max'].default_value = low, high
    ramp = nodes.new('ShaderNodeValToRGB')
    while len(ramp.color_ramp.elements) < len(VIRIDIS):
        ramp.color_ramp.elements.new(0.5)
    for element, (position, *colour) in zip(ramp.color_ramp.elements, VIRIDIS):
        element.position, element.color = position, (*map(linear, colour), 1)
    for i, made in enumerate((value, span, ramp)):
        made.location = (-900 + 250 * i, 300)
    links.new(value.outputs['Fac'], span.inputs['Value'])
    links.new(span.outputs['Result'], ramp.inputs['Fac'])
    surface = nodes['Principled BSDF']
    surface.inputs['Roughness'].default_value = 0.7
    links.new(ramp.outputs['Color'], surface.inputs['Base Color'])
    return material


def identifier(name):
    """Of an input, as modifiers call it."""
    return next(socket.identifier for socket in sliders(group()) if socket.name == name)
