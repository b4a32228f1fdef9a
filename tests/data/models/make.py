#!/usr/bin/env python3
"""Writes the small model files of this folder, which the tests of the importers read."""
import base64, json, os, struct, zlib

HERE = os.path.dirname(os.path.abspath(__file__))
CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
FACES = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5]
TYPES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class File:
    """Collects accessors over one buffer."""

    def __init__(self):
        self.data = b""
        self.json = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, data, **more):
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, component, kind, rows, **more):
        flat = [n for row in rows for n in (row if isinstance(row, (tuple, list)) else (row,))]
        view = self.view(struct.pack("<%d%s" % (len(flat), TYPES[component]), *flat))
        return self.add(view, component, kind, len(flat) // WIDTH[kind], **more)

    def add(self, view, component, kind, count, **more):
        entry = {"componentType": component, "type": kind, "count": count, **more}
        if view is not None:
            entry["bufferView"] = view
        self.json["accessors"].append(entry)
        return len(self.json["accessors"]) - 1

    def mesh(self, attributes, **more):
        primitive = {"attributes": attributes, **more}
        self.json.setdefault("meshes", []).append({"name": "box", "primitives": [primitive]})
        self.json.setdefault("nodes", []).append({"mesh": len(self.json["meshes"]) - 1})
        self.json.setdefault("scenes", [{"nodes": []}])[0]["nodes"].append(
            len(self.json["nodes"]) - 1)
        self.json["scene"] = 0

    def save(self, name, uri="data"):
        j = self.json
        if not self.data:
            del j["bufferViews"]
        elif uri == "data":
            text = base64.b64encode(self.data).decode()
            j["buffers"] = [{"byteLength": len(self.data),
                             "uri": "data:application/octet-stream;base64," + text}]
        else:
            j["buffers"] = [{"byteLength": len(self.data)}]
            if uri:
                j["buffers"][0]["uri"] = uri.replace(" ", "%20")
                write(uri, self.data)
        if uri:
            write(name, (json.dumps(j, indent=1) + "\n").encode())
            return
        text = json.dumps(j, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text
        data = self.data + b"\0" * (-len(self.data) % 4)
        body += struct.pack("<II", len(data), 0x004E4942) + data
        write(name, struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body)


def write(name, data):
    with open(os.path.join(HERE, name), "wb") as f:
        f.write(data)


def png(width, height, channels, rows, bits=8):
    color = {1: 0, 2: 4, 3: 2, 4: 6}[channels]

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    raw = b"".join(b"\0" + bytes(row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b""))


def boxes():
    for name, component, uri in (("box_u8.gltf", 5121, "data"), ("box_u16.glb", 5123, None),
                                 ("box_u32.gltf", 5125, "box u32.bin")):
        f = File()
        i = f.accessor(component, "SCALAR", FACES)
        f.mesh({"POSITION": f.accessor(5126, "VEC3", CORNERS)}, indices=i)
        f.save(name, uri)
    f = File()  # without indices
    f.mesh({"POSITION": f.accessor(5126, "VEC3", [CORNERS[i] for i in FACES])})
    f.save("box_unindexed.gltf")
    f = File()  # position and normal interleaved
    i = f.accessor(5121, "SCALAR", FACES)
    rows = b"".join(struct.pack("<6f", *c, 0, 0, 1) for c in CORNERS)
    v = f.view(rows, byteStride=24)
    f.mesh({"POSITION": f.add(v, 5126, "VEC3", 8), "NORMAL": f.add(v, 5126, "VEC3", 8, byteOffset=12)},
           indices=i)
    f.save("box_interleaved.gltf")
    f = File()  # zeros, of which sparse values make a box
    i = f.accessor(5121, "SCALAR", FACES)
    where = f.view(bytes(range(1, 8)))
    what = f.view(struct.pack("<21f", *[n for c in CORNERS[1:] for n in c]))
    p = f.add(None, 5126, "VEC3", 8, sparse={"count": 7, "indices": {"bufferView": where, "componentType": 5121},
                                             "values": {"bufferView": what}})
    f.mesh({"POSITION": p}, indices=i)
    f.save("box_sparse.gltf")
    f = File()  # quantised positions and normalised colours, coordinates
    i = f.accessor(5121, "SCALAR", FACES)
    f.json["extensionsUsed"] = f.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    padded = b"".join(struct.pack("<4h", *(32767 * n for n in c), 0) for c in CORNERS)
    p = f.add(f.view(padded, byteStride=8), 5122, "VEC3", 8, normalized=True)
    c = f.accessor(5121, "VEC4", [(255 * x, 51, 255 * z, 102) for x, y, z in CORNERS], normalized=True)
    t = f.accessor(5123, "VEC2", [(65535 * x, 65535 * y) for x, y, z in CORNERS], normalized=True)
    f.mesh({"POSITION": p, "COLOR_0": c, "TEXCOORD_0": t}, indices=i, material=0)
    f.json["materials"] = [{"name": "glassy", "alphaMode": "BLEND"}]
    f.save("box_normalized.gltf")


def modes():
    row = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 2, 0)]
    for mode, name in ((5, "strip.gltf"), (6, "fan.gltf"), (0, "points.gltf")):
        f = File()
        f.mesh({"POSITION": f.accessor(5126, "VEC3", row)}, mode=mode)
        f.save(name)


def alpha():
    f = File()
    pixels = png(2, 2, 4, [[255, 0, 0, 255, 0, 255, 0, 0], [0, 0, 255, 51, 255, 255, 255, 255]])
    f.json["images"] = [{"bufferView": f.view(pixels), "mimeType": "image/png"}]
    f.json["samplers"] = [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]
    f.json["textures"] = [{"source": 0, "sampler": 0}]
    base = {"baseColorFactor": [0.5, 1, 1, 0.75], "baseColorTexture": {"index": 0}, "metallicFactor": 0}
    f.json["materials"] = [{"pbrMetallicRoughness": base, **m} for m in (
        {}, {"alphaMode": "MASK", "alphaCutoff": 0.25}, {"alphaMode": "BLEND"})]
    p = f.accessor(5126, "VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    t = f.accessor(5126, "VEC2", [(0, 0), (1, 0), (0, 1)])
    for m in range(3):
        f.mesh({"POSITION": p, "TEXCOORD_0": t}, material=m)
    f.save("alpha.gltf")


def materials():
    f = File()
    p = f.accessor(5126, "VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    pbr = lambda metal, rough: {"pbrMetallicRoughness": {"metallicFactor": metal, "roughnessFactor": rough}}
    f.json["materials"] = [
        {"name": "metal", **pbr(1, 0.5)}, {"name": "smooth", **pbr(0, 0.1)}, {"name": "rough", **pbr(0, 1)},
        {"name": "glass", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0, "baseColorFactor": [0.5, 0.25, 1, 1]}, "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.25},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 1, 0.25]}}},
        {"name": "flat", **pbr(0, 1), "extensions": {"KHR_materials_unlit": {}}},
        {"name": "lamp", **pbr(0, 1), "emissiveFactor": [1, 0.5, 0], "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 4}}},
        {"name": "layers", **pbr(0, 1), "extensions": {
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 1, 0]},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25},
            "KHR_materials_sheen": {"sheenColorFactor": [0, 0.5, 1], "sheenRoughnessFactor": 0.5},
            "KHR_materials_transmission": {"transmissionFactor": 0.25}}}]
    f.json["extensionsUsed"] = ["KHR_materials_" + e for e in
                                ("transmission", "ior", "volume", "unlit", "emissive_strength", "specular", "clearcoat", "sheen", "pearl")]
    for m in range(len(f.json["materials"])):
        f.mesh({"POSITION": p}, material=m)
    f.save("materials.gltf")


def nodes():
    f = File()
    p = f.accessor(5126, "VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    f.json.update(
        extensionsUsed=["KHR_lights_punctual"],
        extensions={"KHR_lights_punctual": {"lights": [
            {"type": "directional", "intensity": 683, "color": [1, 0.5, 0.25]},
            {"type": "point", "intensity": 1366}, {"type": "spot", "spot": {}}]}},
        cameras=[{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
                 {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}],
        meshes=[{"name": "leaf", "primitives": [{"attributes": {"POSITION": p}}]}],
        nodes=[{"name": "root", "translation": [1, 2, 3], "rotation": [0, 0.70710678, 0, 0.70710678],
                "scale": [2, 2, 2], "children": [1, 2, 3, 4, 5, 6]},
               {"name": "leaf", "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1]},
               {"name": "leaf", "mesh": 0, "translation": [0, 1, 0]},
               {"name": "eye", "camera": 0}, {"camera": 1},
               {"extensions": {"KHR_lights_punctual": {"light": 0}}},
               {"translation": [0, 1, 0], "extensions": {"KHR_lights_punctual": {"light": 1}},
                "children": [7]},
               {"extensions": {"KHR_lights_punctual": {"light": 2}}},
               {"name": "not in the scene", "mesh": 0}],
        scenes=[{"nodes": [8]}, {"nodes": [0]}], scene=1)
    f.save("nodes.gltf")


def skin_and_morph():
    f = File()
    p = f.accessor(5126, "VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    joints = f.accessor(5121, "VEC4", [(0, 1, 0, 0)] * 3)
    weights = f.accessor(5126, "VEC4", [(1, 0, 0, 0), (0.5, 0.5, 0, 0), (0, 1, 0, 0)])
    bind = f.accessor(5126, "MAT4", [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1),
                                     (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1)])
    f.json.update(
        meshes=[{"primitives": [{"attributes": {"POSITION": p, "JOINTS_0": joints, "WEIGHTS_0": weights}}]}],
        skins=[{"joints": [1, 2], "inverseBindMatrices": bind}],
        nodes=[{"mesh": 0, "skin": 0, "translation": [50, 0, 0]},
               {"translation": [0, 0, 2], "children": [2]}, {"translation": [0, 3, 0]}],
        scenes=[{"nodes": [0, 1]}])
    f.save("skin.gltf")
    f = File()
    p = f.accessor(5126, "VEC3", [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    m = f.accessor(5126, "VEC3", [(0, 0, 4), (0, 0, 4), (0, 0, 4)])
    f.mesh({"POSITION": p}, targets=[{"POSITION": m}, {"POSITION": m}])
    f.json["meshes"][0]["weights"] = [0.5, 0]
    f.json["nodes"].append({"mesh": 0, "weights": [0, 0.25]})
    f.json["scenes"][0]["nodes"].append(1)
    f.save("morph.gltf")


def others():
    write("quad.obj", b"# two triangles, a texture, a concave polygon\nmtllib quad.mtl\no quad\n"
          b"v .0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.25 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
          b"usemtl painted\nf 1/1 2/2 3/3 4/4\no dart\nusemtl shiny\nf 1 2 3 5\no glass\nusemtl clear\nf -5 -4 -3\n"
          b"o facets\nusemtl facets\nf 1 2 3\n")
    write("quad.mtl", b"newmtl painted\nKd 1 1 1\nillum 1\nmap_Kd textures\\grey.png\naniso 0.5\n"
          b"newmtl shiny\nKd 0.2 0.4 0.6\nKs 0.5 0.5 0.5\nNs 40\nillum 2\nd 0.5\n"
          b"newmtl clear\nKd 0 0 0\nNi 1.4\nillum 7\n"
          b"newmtl facets\nKd 0.5 0.25 0\nPm 1\nPr 0.25\n")
    os.makedirs(os.path.join(HERE, "textures"), exist_ok=True)
    write("textures/grey.png", png(2, 1, 1, [[64, 192]]))
    write("textures/deep.png", png(1, 1, 3, [[255, 255, 128, 0, 0, 0]], bits=16))
    write("textures/grey_alpha.png", png(1, 1, 2, [[100, 200]]))
    write("triangle.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
          b"property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
          b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
          b"0 0 0 255 0 0\n1 0 0 0 188 0\n0 1 0 0 0 255\n3 0 1 2\n")
    write("triangle.stl", b"solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 5\nvertex 1 0 5\n"
          b"vertex 0 1 5\nendloop\nendfacet\nendsolid one\n")
    write("binary.stl", b"solid in name only".ljust(80) + struct.pack("<I", 1)
          + struct.pack("<12fH", 0, 0, 1, 0, 0, 5, 1, 0, 5, 0, 1, 5, 0))
    write("tetrahedron.off", b"OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    write("points.obj", b"v 0 0 0\nv 1 0 0\np 1 2\n")


if __name__ == "__main__":
    boxes()
    modes()
    alpha()
    materials()
    nodes()
    skin_and_morph()
    others()
