-- A model in a photographer's studio: softbox, reflector, and a backdrop without an edge
--
-- The light of product photographs: one large soft lamp from the side and above makes the shape, a
-- weaker one from the other side opens the shadows, a narrow one from behind draws the outline. The
-- backdrop is one sheet that bends from floor to wall, so that there is no line behind the
-- model. Everything is measured in sizes of the model: it fits a shoe and a house alike.
-- Try:  snell studio-shot.lua -D model=shoe.glb --allow .      your own model (the folder that it is in)
--       snell studio-shot.lua -D azimuth=120
-- Without a model it takes a teapot from the hands of the potter's wheel: lines turned about an axis.

local file = param.file("model", "", "what to photograph; empty: a teapot")
local azimuth = param("azimuth", 24, "degrees around the model")
local elevation = param("elevation", 14, "degrees above the floor")

render { integrator = "path", width = 640, height = 480, samples = 100, max_depth = 6 }

-- ---- the teapot: body, lid, handle, spout ----
local function teapot()
    local china = material.ggx { color = {0.035, 0.12, 0.2}, roughness = 0.22, ior = 1.55 }
    local copper = material.conductor { metal = "copper", roughness = 0.3 }
    local body, lid = { {0, 0}, {0.46, 0}, {0.48, 0.02}, {0.46, 0.07} }, { {0.44, 1.19} }
    for i = 0, 40 do                                      -- most of an egg
        local a = math.rad(-62 + 121 * i / 40)
        body[#body + 1] = { 0.92 * math.cos(a) + 0.02, 0.66 + 0.62 * math.sin(a) }
    end
    body[#body + 1] = { 0.42, 1.19 }
    body[#body + 1] = { 0, 1.19 }
    for i = 0, 16 do
        local a = math.rad(90 * i / 16)
        lid[#lid + 1] = { 0.46 * math.cos(a) + 0.04 * (1 - math.sin(a)), 1.2 + 0.14 * math.sin(a) }
    end
    lid[#lid] = { 0, 1.34 }
    -- The spout: rings of points along a curve, joined to a mesh.
    local function along(t) return 0.7 + 0.78 * t, 0.5 + 0.75 * t * t + 0.06 * math.sin(math.pi * t) end
    local points, outward, faces, rings, sides = {}, {}, {}, 32, 40
    for i = 0, rings do
        local t = i / rings
        local x, y = along(t)
        local nx, ny = along(t + 0.01)
        local length = math.sqrt((nx - x) ^ 2 + (ny - y) ^ 2)
        nx, ny = (y - ny) / length, (nx - x) / length     -- across the curve
        for k = 0, sides - 1 do
            local a, radius, at = 2 * math.pi * k / sides, 0.21 - 0.13 * t, i * sides + k
            local normal = { nx * math.cos(a), ny * math.cos(a), math.sin(a) }
            points[at + 1], outward[at + 1] = { x + radius * normal[1], y + radius * normal[2], radius * normal[3] }, normal
            local right = i * sides + (k + 1) % sides
            if i < rings then
                for _, v in ipairs { at, right, right + sides, at, right + sides, at + sides } do
                    faces[#faces + 1] = v
                end
            end
        end
    end
    local x, y = along(1)
    return group {
        lathe { profile = body, material = china }, lathe { profile = lid, material = china },
        sphere { center = {0, 1.41, 0}, radius = 0.09, material = copper },
        torus { center = {0, 1.195, 0}, axis = {0, 1, 0}, major = 0.47, minor = 0.025, material = copper },
        torus { center = {-0.96, 0.72, 0}, axis = {0, 0, 1}, major = 0.36, minor = 0.055, material = copper },
        mesh { positions = points, normals = outward, indices = faces, material = china },
        torus { center = {x, y, 0}, axis = {0.5, 0.85, 0}, major = 0.08, minor = 0.014, material = china },
    }
end

local subject = file ~= "" and model { file = file } or teapot()
local b = subject.bounds
local size = math.max(b.size[1], b.size[2], b.size[3])
camera { view = {azimuth, elevation}, of = subject, fov = 20 }

-- ---- the studio turns with the camera; lengths are in sizes, from the middle of the model's foot ----
local turn = transform.translate { b.center[1], b.min[2], b.center[3] }
           * transform.rotate { axis = {0, 1, 0}, angle = azimuth } * transform.scale(size)

-- The place of a point of the studio in the scene: as turn does it.
local s, c = math.sin(math.rad(azimuth)), math.cos(math.rad(azimuth))
local function place(x, y, z)
    return { b.center[1] + size * (c * x + s * z), b.min[2] + size * y, b.center[3] + size * (c * z - s * x) }
end
local middle = place(0, 0.3, 0)

-- The backdrop: floor, bend, wall.
local sheet, normals, triangles = {}, {}, {}
local function rib(y, z, ny, nz)
    for _, x in ipairs { -9, 9 } do
        sheet[#sheet + 1], normals[#normals + 1] = {x, y, z}, {0, ny, nz}
    end
end
rib(0, 9, 1, 0)
for i = 0, 32 do
    local a = math.rad(90 * i / 32)
    rib(1.6 * (1 - math.cos(a)), -1.1 - 1.6 * math.sin(a), math.cos(a), math.sin(a))
end
rib(9, -2.7, 0, 1)
for i = 0, #sheet / 2 - 2 do
    for _, k in ipairs { 0, 1, 3, 0, 3, 2 } do triangles[#triangles + 1] = 2 * i + k end
end
mesh { positions = sheet, normals = normals, indices = triangles, transform = turn, name = "backdrop",
       material = material.lambert { color = {0.62, 0.6, 0.58} } }

-- The lights. Radiance does not depend on size: a softbox twice as large, twice as far, is the same.
light.quad { center = place(-1.7, 2.1, 1.3), at = middle, width = 1.6 * size, radiance = {10.5, 10, 9.3}, name = "softbox" }
light.quad { center = place(2.4, 1.1, 1.0), at = middle, width = 1.3 * size, radiance = {1.4, 1.5, 1.7}, name = "reflector" }
light.quad { center = place(1.1, 1.9, -1.7), at = middle, width = 0.3 * size, height = 1.5 * size,
             radiance = {9, 9.5, 10.5}, visible = false, name = "rim light" }
