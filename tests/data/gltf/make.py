#!/usr/bin/env python3
"""Writes the glTF files of this folder: animations, sets of texture coordinates, extensions."""
import base64, os, sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "..", "models"))
import make

FLOAT = 5126
TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
# Two pixels, lossless: (64, 192, 16) and (255, 0, 128).
WEBP = base64.b64decode("UklGRiAAAABXRUJQVlA4TBQAAAAvAQAAAA8wwA/6PyDk/IcWMqL/AQ==")
# Made by draco_encoder without quantisation: (0, 0), (2, 0), (2, 1), (0, 1) with uvs and normals.
DRACO = base64.b64decode(
    "RFJBQ08CAgEBAAAABAICAgAAAR//ARH/ARH/ARED/wAAAAAAAQAAAQAJAwAAAAEDCQIAAQABAQkDAAIAAAAAAAAAAAAAAAAAAAAAQAAA"
    "gD8AAAAAAAAAAAAAgD8AAAAAAAAAQAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAIA/AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
    "AAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8=")


def save(f, name):
    f.save(os.path.join("..", "gltf", name))


def track(f, animation, node, path, times, values, kind, interpolation="LINEAR"):
    while len(f.json.setdefault("animations", [])) <= animation:
        f.json["animations"].append({"channels": [], "samplers": []})
    a = f.json["animations"][animation]
    a["channels"].append({"sampler": len(a["samplers"]), "target": {"node": node, "path": path}})
    a["samplers"].append({"input": f.accessor(FLOAT, "SCALAR", times, min=[times[0]], max=[times[-1]]),
                          "output": f.accessor(FLOAT, kind, values), "interpolation": interpolation})
    return a


def animated():
    f = make.File()
    half = 0.5 ** 0.5
    f.mesh({"POSITION": f.accessor(FLOAT, "VEC3", TRIANGLE)})
    f.json["cameras"] = [{"type": "perspective", "name": "eye", "perspective": {"yfov": 0.5, "znear": 0.1}}]
    f.json["nodes"] = [{"name": "mover", "mesh": 0, "children": [1]},
                       {"name": "child", "mesh": 0, "translation": [0, 1, 0]},
                       {"name": "cubic", "mesh": 0},
                       {"name": "turntable", "camera": 0, "scale": [3, 3, 3], "translation": [1, 0, 0]},
                       {"name": "still", "mesh": 0, "translation": [5, 0, 0]}]
    f.json["scenes"] = [{"nodes": [0, 2, 3, 4]}]
    track(f, 0, 0, "translation", [0, 1], [(0, 0, 0), (24, 0, 0)], "VEC3")
    track(f, 0, 0, "rotation", [0, 2], [(0, 0, 0, 1), (0, 0, half, half)], "VEC4")
    track(f, 0, 1, "scale", [0, 0.4], [(1, 1, 1), (2, 2, 2)], "VEC3", "STEP")
    track(f, 0, 2, "translation", [0, 1], [(9, 9, 9), (0, 0, 0), (4, 0, 0), (0, 2, 0), (1, 0, 0), (9, 9, 9)],
          "VEC3", "CUBICSPLINE")
    track(f, 0, 3, "rotation", [0, 2], [(0, 0, 0, 1), (0, -half, 0, -half)], "VEC4")["name"] = "first"
    track(f, 1, 4, "translation", [0, 0.25], [(5, 0, 0), (5, 7, 0)], "VEC3", "STEP")["name"] = "second"
    save(f, "animated.gltf")


def deforming():
    f = make.File()
    half = 0.5 ** 0.5
    p = f.accessor(FLOAT, "VEC3", TRIANGLE)
    n = f.accessor(FLOAT, "VEC3", [(0, 0, 1), (1, 0, 0), (0, 0, 1)])
    j = f.accessor(5121, "VEC4", [(0, 0, 0, 0)] * 3)
    w = f.accessor(FLOAT, "VEC4", [(1, 0, 0, 0)] * 3)
    f.mesh({"POSITION": p, "NORMAL": n, "JOINTS_0": j, "WEIGHTS_0": w})
    up = f.accessor(FLOAT, "VEC3", [(0, 0, 4), (0, 0, 0), (0, 0, 0)])
    f.mesh({"POSITION": p}, targets=[{"POSITION": up}])
    f.json["skins"] = [{"joints": [2]}]
    f.json["nodes"] = [{"mesh": 0, "skin": 0}, {"mesh": 1}, {}]
    f.json["scenes"] = [{"nodes": [0, 1, 2]}]
    track(f, 0, 2, "rotation", [0, 1], [(0, 0, 0, 1), (0, 0, half, half)], "VEC4")
    track(f, 0, 1, "weights", [0, 1], [0, 1], "SCALAR")
    save(f, "deforming.gltf")


def uvs():
    f = make.File()
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    image = make.png(2, 1, 3, [[255, 0, 0, 0, 255, 0]])
    f.json["images"] = [{"bufferView": f.view(image), "mimeType": "image/png"}]
    f.json["samplers"] = [{"magFilter": 9728}]
    f.json["textures"] = [{"source": 0, "sampler": 0}]
    attributes = {"POSITION": f.accessor(FLOAT, "VEC3", corners),
                  "NORMAL": f.accessor(FLOAT, "VEC3", [(0, 0, 1)] * 4),
                  "TANGENT": f.accessor(FLOAT, "VEC4", [(0, 1, 0, -1)] * 4),
                  "TEXCOORD_0": f.accessor(FLOAT, "VEC2", [(0.25, 0.5)] * 4),
                  "TEXCOORD_1": f.accessor(FLOAT, "VEC2", [(0, 1), (1, 1), (1, 0), (0, 0)])}
    indices = f.accessor(5121, "SCALAR", [0, 1, 2, 0, 2, 3])
    for material in range(2):
        f.mesh(attributes, indices=indices, material=material)
    f.json["extensionsUsed"] = ["KHR_texture_transform", "KHR_materials_clearcoat"]
    f.json["materials"] = [{
        "name": "both", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0, "texCoord": 1},
        "normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 1}}}}, {
        "name": "varnished", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatNormalTexture": {
            "index": 0, "scale": 0.5, "extensions": {"KHR_texture_transform": {"texCoord": 1, "scale": [2, 4]}}}}}}]
    save(f, "uvs.gltf")


def extensions():
    f = make.File()
    p = f.accessor(FLOAT, "VEC3", TRIANGLE)
    t = f.accessor(FLOAT, "VEC2", [(0, 0), (1, 0), (0, 1)])
    f.json["images"] = [{"bufferView": f.view(make.png(1, 1, 4, [[255, 51, 204, 102]])), "mimeType": "image/png"}]
    f.json["textures"] = [{"source": 0}]
    f.json["materials"] = [
        {"name": "glossy", "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 1, 0.5], "specularFactor": [0.2, 0.04, 1], "glossinessFactor": 0.75}},
         "alphaMode": "BLEND"},
        {"name": "map", "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "glossinessFactor": 0.5, "specularGlossinessTexture": {"index": 0}}}},
        {"name": "brushed", "extensions": {"KHR_materials_anisotropy": {
            "anisotropyStrength": 0.5, "anisotropyRotation": 1.25, "anisotropyTexture": {"index": 0}}}},
        {"name": "film", "extensions": {"KHR_materials_iridescence": {
            "iridescenceFactor": 0.75, "iridescenceIor": 1.6, "iridescenceThicknessMaximum": 500}}},
        {"name": "films", "extensions": {"KHR_materials_iridescence": {
            "iridescenceFactor": 1, "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 400,
            "iridescenceThicknessTexture": {"index": 0}}}},
        {"name": "prism", "extensions": {"KHR_materials_dispersion": {"dispersion": 0.5},
                                        "KHR_materials_transmission": {"transmissionFactor": 1},
                                        "KHR_materials_volume": {"thicknessFactor": 1}}}]
    f.json["extensionsUsed"] = ["KHR_materials_pbrSpecularGlossiness", "KHR_materials_anisotropy",
                                "KHR_materials_iridescence", "KHR_materials_dispersion",
                                "KHR_materials_transmission", "KHR_materials_volume"]
    for m in range(len(f.json["materials"])):
        f.mesh({"POSITION": p, "TEXCOORD_0": t}, material=m)
    save(f, "extensions.gltf")


def webp():
    f = make.File()
    f.json["images"] = [{"bufferView": f.view(WEBP), "mimeType": "image/webp"}]
    f.json["textures"] = [{"extensions": {"EXT_texture_webp": {"source": 0}}}]
    f.json["extensionsUsed"] = f.json["extensionsRequired"] = ["EXT_texture_webp"]
    f.json["materials"] = [{"name": "painted", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    f.mesh({"POSITION": f.accessor(FLOAT, "VEC3", TRIANGLE),
            "TEXCOORD_0": f.accessor(FLOAT, "VEC2", [(0, 0), (1, 0), (0, 1)])}, material=0)
    save(f, "webp.gltf")


def draco():
    f = make.File()
    view = f.view(DRACO)
    p = f.add(None, FLOAT, "VEC3", 4, min=[0, 0, 0], max=[2, 1, 0])
    t, n, i = f.add(None, FLOAT, "VEC2", 4), f.add(None, FLOAT, "VEC3", 4), f.add(None, 5123, "SCALAR", 6)
    f.mesh({"POSITION": p, "TEXCOORD_0": t, "NORMAL": n}, indices=i, extensions={
        "KHR_draco_mesh_compression": {"bufferView": view,
                                       "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 2}}})
    f.json["extensionsUsed"] = f.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]
    save(f, "draco.gltf")


def lines():
    f = make.File()
    p = f.accessor(FLOAT, "VEC3", [(0, 0, 0), (3, 0, 0), (3, 4, 0), (0, 4, 0)], min=[0, 0, 0], max=[3, 4, 0])
    c = f.accessor(FLOAT, "VEC3", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)])
    for mode in (0, 1, 2, 3):
        f.mesh({"POSITION": p, "COLOR_0": c}, mode=mode)
    save(f, "lines.gltf")


if __name__ == "__main__":
    animated()
    deforming()
    uvs()
    extensions()
    webp()
    draco()
    lines()
