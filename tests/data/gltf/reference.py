#!/usr/bin/env python3
"""Positions of Khronos' BoxAnimated and Fox in an animation, by a straight reading of the specification:
the numbers in tests/test_gltf.c.   reference.py FOLDER_OF_SAMPLES"""
import json, math, os, struct, sys

WIDTH = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
LETTER = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
FPS = 24


class Model:
    def __init__(self, folder, name):
        data = open(os.path.join(folder, name, "glTF-Binary", name + ".glb"), "rb").read()
        length = struct.unpack("<I", data[12:16])[0]
        self.json, self.bin = json.loads(data[20:20 + length]), data[20 + length + 8:]

    def accessor(self, index):
        a = self.json["accessors"][index]
        view, n, c = self.json["bufferViews"][a["bufferView"]], WIDTH[a["type"]], LETTER[a["componentType"]]
        stride = view.get("byteStride", n * struct.calcsize(c))
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        return [struct.unpack_from("<%d%s" % (n, c), self.bin, start + k * stride) for k in range(a["count"])]

    def pose(self, animation, time):
        """A function from a node to its matrix in the world."""
        nodes = self.json["nodes"]
        local = [{"translation": n.get("translation", [0, 0, 0]), "rotation": n.get("rotation", [0, 0, 0, 1]),
                  "scale": n.get("scale", [1, 1, 1])} for n in nodes]
        a = self.json["animations"][animation]
        for channel in a["channels"]:
            s, target = a["samplers"][channel["sampler"]], channel["target"]
            assert s.get("interpolation", "LINEAR") == "LINEAR"
            times = [t[0] for t in self.accessor(s["input"])]
            local[target["node"]][target["path"]] = interpolate(
                times, self.accessor(s["output"]), time, target["path"] == "rotation")
        parent = {child: i for i, n in enumerate(nodes) for child in n.get("children", [])}

        def world(i):
            m = nodes[i].get("matrix")
            here = [[m[4 * c + r] for c in range(4)] for r in range(4)] if m else matrix(**local[i])
            return multiply(world(parent[i]), here) if i in parent else here

        return world


def matrix(translation, rotation, scale):
    x, y, z, w = rotation
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [[turn[r][c] * scale[c] for c in range(3)] + [translation[r]] for r in range(3)] + [[0, 0, 0, 1]]


def multiply(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def interpolate(times, values, time, is_rotation):
    if time <= times[0]:
        return values[0]
    if time >= times[-1]:
        return values[-1]
    i = max(k for k in range(len(times)) if times[k] <= time)
    s, a, b = (time - times[i]) / (times[i + 1] - times[i]), values[i], values[i + 1]
    cosine = sum(p * q for p, q in zip(a, b))
    if not is_rotation or abs(cosine) > 1 - 1e-10:
        return [p + (q - p) * s for p, q in zip(a, b)]
    sign, angle = math.copysign(1, cosine), math.acos(min(abs(cosine), 1))
    return [(math.sin((1 - s) * angle) * p + sign * math.sin(s * angle) * q) / math.sin(angle)
            for p, q in zip(a, b)]


def box(folder):
    model = Model(folder, "BoxAnimated")
    for frame in (30, 60):
        world = model.pose(0, (frame - 1) / FPS)
        for i, node in enumerate(model.json["nodes"]):
            if "mesh" in node:
                print("box, frame", frame, "node", i, [["%.6f" % n for n in row] for row in world(i)[:3]])


def fox(folder):
    model, run, frame = Model(folder, "Fox"), 2, 6
    world, skin = model.pose(run, (frame - 1) / FPS), model.json["skins"][0]
    bind = model.accessor(skin["inverseBindMatrices"])
    joints = [multiply(world(n), [[bind[k][4 * c + r] for c in range(4)] for r in range(4)])
              for k, n in enumerate(skin["joints"])]
    attributes = model.json["meshes"][0]["primitives"][0]["attributes"]
    place, number, weight = (model.accessor(attributes[a]) for a in ("POSITION", "JOINTS_0", "WEIGHTS_0"))
    for v in (0, 100, 500, 1500):
        p = [sum(weight[v][k] * sum(joints[number[v][k]][r][c] * (*place[v], 1)[c] for c in range(4))
                 for k in range(4)) for r in range(3)]
        print("fox, vertex", v, ["%.5f" % n for n in p])


box(sys.argv[1])
fox(sys.argv[1])
