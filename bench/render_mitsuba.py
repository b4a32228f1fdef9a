"""Draws a scene.json of export_scene with Mitsuba 3, for bench/renders. Needs it as a module (pip install mitsuba).

    render_mitsuba.py SCENE.json THREADS SAMPLES SEED OUT.ppm

Only scenes that path tracing suits: it has no counterpart of Whitted's method, and its balls are left out.
"""
import json
import os
import sys

import drjit
import mitsuba

path, threads, samples, seed, out = sys.argv[1:6]
folder = os.path.dirname(path)
with open(path) as file:
    scene = json.load(file)

mitsuba.set_variant(os.environ.get('MITSUBA_VARIANT', 'scalar_rgb'))
drjit.set_thread_count(int(threads))


def rgb(color):
    return {'type': 'rgb', 'value': color}


place = mitsuba.ScalarTransform4f
made = {
    'type': 'scene',
    'integrator': {'type': 'path', 'max_depth': scene['depth'] + 1},
    'sensor': {
        'type': 'perspective', 'fov': scene['fov'], 'fov_axis': 'y',
        'to_world': place().look_at(origin=scene['from'], target=scene['at'], up=scene['up']),
        'film': {'type': 'hdrfilm', 'width': scene['width'], 'height': scene['height'],
                 'pixel_format': 'rgb', 'rfilter': {'type': 'box'}},
        'sampler': {'type': 'independent', 'sample_count': int(samples)},
    },
}
for number, look in enumerate(scene['materials']):
    if look['mirror'] or look['ior'] or look['square']:
        sys.exit('render_mitsuba.py: only matte materials are drawn')
    made['material-%d' % number] = {
        'type': 'twosided', 'bsdf': {'type': 'diffuse', 'reflectance': rgb(look['color'])}}
for number, shape in enumerate(scene['shapes']):
    if 'mesh' not in shape:
        sys.exit('render_mitsuba.py: only meshes are drawn')
    made['shape-%d' % number] = {
        'type': 'ply', 'filename': os.path.join(folder, shape['mesh']),
        'bsdf': {'type': 'ref', 'id': 'material-%d' % shape['material']}}
for number, light in enumerate(scene['lights']):
    if 'corner' not in light:
        sys.exit('render_mitsuba.py: only lamps with an area are drawn')
    corner, u, v = light['corner'], light['u'], light['v']
    n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    rows = [[u[i] / 2, v[i] / 2, n[i], corner[i] + u[i] / 2 + v[i] / 2] for i in range(3)]
    made['light-%d' % number] = {
        'type': 'rectangle', 'to_world': place(rows + [[0, 0, 0, 1]]),
        'emitter': {'type': 'area', 'radiance': rgb(light['radiance'])}}

image = mitsuba.render(mitsuba.load_dict(made), seed=int(seed))
bitmap = mitsuba.Bitmap(image)
bitmap.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.UInt8, srgb_gamma=True).write(out)
