-- A ball on a floor under a lamp: the scene of docs/learn. Its -D values change one thing at a time.

local of = param("material", "matte", "of the ball: matte, phong, blinn_phong, mirror, partial, glazed, glass, red_glass, gold, facets")
local lamps = param("lamps", 1, "1 or 2")
local constant = param("ambient", 0.0, "the constant of ambient light")
local exponent = param("exponent", 50.0, "of phong and blinn_phong")
local m = param("m", 0.2, "the slope of facets")
local at_camera = param("headlight", 0.0, "intensity of a dim light at the camera, W/sr")

render { integrator = "whitted", width = 320, height = 240, samples = 16 }
camera { from = {0, 1.5, 5}, at = {0, 0.8, 0}, fov = 36 }
background { color = {0.35, 0.4, 0.45}, top = {0.08, 0.14, 0.3} }
ambient { color = constant }

light.point { position = {2, 4, 3}, intensity = 60, name = "lamp" }
if lamps > 1 then light.point { position = {-4, 3, 2}, intensity = 30, name = "second lamp" } end
if at_camera > 0 then light.headlight { intensity = at_camera } end

local red = {0.7, 0.15, 0.1}
local materials = {
    matte = material.lambert { color = red },
    phong = material.phong { color = red, specular = 0.5, exponent = exponent },
    blinn_phong = material.blinn_phong { color = red, specular = 0.5, exponent = exponent },
    mirror = material.mirror { color = 0.9 },
    partial = material.partial_mirror { color = {0.9, 0.6, 0.5}, specularity = 0.5 },
    glazed = material.glazed { base = material.lambert { color = red }, ior = 1.5 },
    glass = material.dielectric { ior = 1.5 },
    red_glass = material.dielectric { ior = 1.5, absorption = {0.1, 1.2, 1.5} },
    gold = material.conductor { metal = "gold" },
    facets = material.cook_torrance { color = red, m = m, ior = 1.5 },
}
sphere { center = {0, 1, 0}, radius = 1, material = materials[of], name = "ball" }
quad { corner = {-8, 0, 4}, u = {16, 0, 0}, v = {0, 0, -16}, name = "floor",
       material = material.lambert {
           color = texture.checker { {0.75, 0.75, 0.75}, {0.2, 0.3, 0.35}, size = 1, map = "xz" } } }
