"""Draws a scene.json of export_scene with Cycles, for bench/renders. Needs Blender as a module (pip install bpy).

    render_cycles.py SCENE.json THREADS SAMPLES SEED OUT.ppm
"""
import json
import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix, Vector

path, threads, samples, seed, out = sys.argv[1:6]
folder = os.path.dirname(path)
with open(path) as file:
    scene = json.load(file)
path_traced = any('radiance' in light for light in scene['lights'])

bpy.ops.wm.read_factory_settings(use_empty=True)
view = bpy.context.scene
view.render.engine = 'CYCLES'
view.render.threads_mode = 'FIXED'
view.render.threads = int(threads)
view.render.resolution_x, view.render.resolution_y = scene['width'], scene['height']
view.render.use_compositing = view.render.use_sequencer = False
view.render.image_settings.file_format = 'BMP'  # plain bytes; it cannot write PPM
view.render.image_settings.color_mode = 'RGB'
view.render.filepath = out + '.bmp'
view.view_settings.view_transform = 'Standard'
cycles = view.cycles
cycles.device = 'CPU'
cycles.samples, cycles.seed = int(samples), int(seed)
cycles.use_adaptive_sampling = cycles.use_denoising = False
cycles.pixel_filter_type = 'BOX'
cycles.blur_glossy = cycles.sample_clamp_indirect = cycles.sample_clamp_direct = 0
cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = scene['depth']
cycles.diffuse_bounces = scene['depth'] if path_traced else 0  # else as Whitted's method


def material(look):
    made = bpy.data.materials.new('material')
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()

    def node(kind, **inputs):
        new = tree.nodes.new('ShaderNode' + kind)
        for name, value in inputs.items():
            new.inputs[name].default_value = value
        return new

    if look['ior'] or look['square']:
        sys.exit('render_cycles.py: glass and boards are not drawn')
    surface = node('BsdfDiffuse', Color=(*look['color'], 1))
    if look['mirror'] > 0:
        mirror = node('BsdfAnisotropic', Color=(1, 1, 1, 1), Roughness=0)
        mix = node('MixShader', Fac=look['mirror'])
        tree.links.new(surface.outputs[0], mix.inputs[1])
        tree.links.new(mirror.outputs[0], mix.inputs[2])
        surface = mix
    tree.links.new(surface.outputs[0], node('OutputMaterial').inputs[0])
    return made


def add(data, matrix=None):
    made = bpy.data.objects.new('object', data)
    if matrix is not None:
        made.matrix_world = matrix
    view.collection.objects.link(made)
    return made


def frame(x, y, z, at):  # columns
    return Matrix(((x[0], y[0], z[0], at[0]), (x[1], y[1], z[1], at[1]), (x[2], y[2], z[2], at[2]), (0, 0, 0, 1)))


def polygon(corners):
    mesh = bpy.data.meshes.new('polygon')
    mesh.from_pydata(corners, [], [range(len(corners))])
    return mesh


materials = [material(look) for look in scene['materials']]
balls = {}  # one finely divided sphere for each material


def ball(number):
    if number not in balls:
        import bmesh
        made, mesh = bmesh.new(), bpy.data.meshes.new('ball')
        bmesh.ops.create_icosphere(made, subdivisions=5, radius=1)
        made.to_mesh(mesh)
        made.free()
        mesh.polygons.foreach_set('use_smooth', [True] * len(mesh.polygons))
        mesh.materials.append(materials[number])
        balls[number] = mesh
    return balls[number]


for shape in scene['shapes']:
    number = shape['material']
    if 'center' in shape:
        add(ball(number), Matrix.Translation(shape['center']) @ Matrix.Scale(shape['radius'], 4))
    elif 'normal' in shape:
        n, p, far = Vector(shape['normal']).normalized(), Vector(shape['point']), 2000
        u = n.orthogonal().normalized() * far
        v = n.cross(u)
        mesh = polygon([p - u - v, p + u - v, p + u + v, p - u + v])
        mesh.materials.append(materials[number])
        add(mesh)
    else:
        bpy.ops.wm.ply_import(filepath=os.path.join(folder, shape['mesh']), forward_axis='Y', up_axis='Z')
        bpy.context.object.data.materials.append(materials[number])

for light in scene['lights']:
    if 'position' in light:
        lamp = bpy.data.lights.new('lamp', 'POINT')
        lamp.shadow_soft_size = 0
        strongest = max(light['intensity'])
        lamp.energy = 4 * math.pi * strongest
        lamp.color = [part / strongest for part in light['intensity']]
        add(lamp, Matrix.Translation(light['position']))
    else:
        c, u, v = (Vector(light[name]) for name in ('corner', 'u', 'v'))
        mesh = polygon([c, c + u, c + u + v, c + v])
        glow = bpy.data.materials.new('glow')
        glow.use_nodes = True
        glow.node_tree.nodes.clear()
        emission = glow.node_tree.nodes.new('ShaderNodeEmission')
        emission.inputs['Color'].default_value = (*light['radiance'], 1)
        output = glow.node_tree.nodes.new('ShaderNodeOutputMaterial')
        glow.node_tree.links.new(emission.outputs[0], output.inputs[0])
        mesh.materials.append(glow)
        add(mesh)

view.world = bpy.data.worlds.new('world')
view.world.use_nodes = True
view.world.node_tree.nodes['Background'].inputs[0].default_value = (*scene['background'], 1)
view.world.cycles_visibility.diffuse = path_traced
view.world.cycles.sampling_method = 'NONE'

eye = Vector(scene['from'])
z = (eye - Vector(scene['at'])).normalized()
x = Vector(scene['up']).cross(z).normalized()
camera = bpy.data.cameras.new('camera')
camera.sensor_fit, camera.angle, camera.clip_end = 'VERTICAL', math.radians(scene['fov']), 1e5
view.camera = add(camera, frame(x, z.cross(x), z, eye))

bpy.ops.render.render(write_still=True)

with open(out + '.bmp', 'rb') as file:  # from the lowest row up, blue first
    data = file.read()
width, height = scene['width'], scene['height']
start, row = int.from_bytes(data[10:14], 'little'), (3 * width + 3) // 4 * 4
rows = numpy.frombuffer(data, numpy.uint8, row * height, start).reshape(height, row)[::-1, :3 * width]
with open(out, 'wb') as file:
    file.write(b'P6\n%d %d\n255\n' % (width, height))
    file.write(rows.reshape(height, width, 3)[:, :, ::-1].tobytes())
os.remove(out + '.bmp')
