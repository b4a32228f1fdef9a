-- Chessmen through a fast lens: one is sharp, and lamps far behind become images of the aperture
--
-- A pinhole sees everything sharp. Through a lens the light of a point comes together in one point
-- only at the distance in focus; of nearer and farther points each sends a cone that the film cuts in
-- a disk, the circle of confusion. Cook (1984): every ray starts somewhere else on the lens, and all
-- rays of a pixel meet in the plane of focus. The circle has the aperture's shape, which small
-- bright things show: here a diaphragm of six blades.
-- Try:  snell depth-of-field.lua -D aperture=0          the pinhole
--       snell depth-of-field.lua -D focus=3             the pawn in front
--       snell depth-of-field.lua -D blades=0            a round aperture

local aperture = param("aperture", 0.11, "radius of the lens in metres")
local focus = param("focus", 4.6, "distance of the sharp plane in metres")
local blades = param("blades", 6, "of the diaphragm; 0 is round")

render { integrator = "cook", width = 640, height = 480, samples = 100, max_depth = 3, exposure = 0.6 }
camera { from = {0.2, 1.55, 4.4}, at = {0, 0.62, -0.1}, fov = 32,
         lens_radius = aperture, focus = focus, blades = blades, blade_rotation = 30 }

background { color = {0.006, 0.006, 0.01}, top = {0.02, 0.03, 0.06} }
ambient { color = {0.018, 0.018, 0.024} }
light.quad { center = {-3.2, 4.4, 3.4}, at = {0, 0.4, 0}, width = 1.6, radiance = {26, 23, 19}, name = "window" }
light.quad { center = {4, 2.6, -3}, at = {0, 0.5, 0}, width = 1.2, radiance = {5, 7, 12}, name = "rim light" }

-- The board: squares of 0.5 m are large, but then chessmen of a metre are garden chess.
local board = material.glazed { reflectance = 0.035, base = material.lambert {
    color = texture.checker { "#e6d6b8", "#4a2f20", size = 0.5, map = "xz", filter = true } } }
box { min = {-2, -0.1, -5}, max = {2, 0, 4}, material = board, name = "board" }

-- A pawn is a line turned about an axis: foot, waist, collar, head.
local function pawn(x, z, material)
    local line = { {0, 0}, {0.19, 0}, {0.2, 0.02}, {0.2, 0.07}, {0.17, 0.1}, {0.165, 0.13} }
    for i = 0, 12 do                       -- the waist: from wide to narrow along a quarter of an ellipse
        local a = math.rad(90 * i / 12)
        line[#line + 1] = { 0.155 - 0.09 * math.sin(a), 0.14 + 0.3 * (1 - math.cos(a)) }
    end
    for _, p in ipairs { {0.065, 0.46}, {0.12, 0.475}, {0.125, 0.49}, {0.12, 0.505}, {0.07, 0.52} } do
        line[#line + 1] = p
    end
    for i = 0, 16 do                       -- the head: a ball of 0.125 m
        local a = math.rad(-57 + 147 * i / 16)
        line[#line + 1] = { i < 16 and 0.125 * math.cos(a) or 0, 0.62 + 0.125 * math.sin(a) }
    end
    return lathe { profile = line, material = material, transform = transform.translate {x, 0, z} }
end

local ivory = material.glazed { ior = 1.5, base = material.lambert { color = {0.78, 0.68, 0.5} } }
local ebony = material.glazed { ior = 1.5, base = material.lambert { color = {0.05, 0.03, 0.025} } }
for i = 0, 5 do
    local z = 1.75 - 1 * i
    pawn(-1.0 + 0.25 * i, z, i % 2 == 0 and ivory or ebony)
    pawn(0.75 + 0.25 * i, z - 0.5, i % 2 == 0 and ebony or ivory)
end

-- Lamps far behind. They only glow: ambient light is a constant that a material shows k_a times,
-- and lights nothing else.
local hues = { {1, 0.62, 0.28}, {1, 0.8, 0.5}, {0.45, 0.7, 1}, {1, 0.4, 0.3}, {0.6, 1, 0.7} }
for i = 1, 15 do
    local r, g, b = table.unpack(hues[1 + i % #hues])
    local x, y = -5.6 + 0.72 * i + 0.4 * math.sin(9 * i), 0.3 + 1.7 * (math.sin(2.4 * i) ^ 2)
    sphere { center = {x, y, -12 - 3 * math.sin(5 * i)}, radius = 0.1, material = material.lambert {
        color = 0, ambient = {400 * r, 400 * g, 400 * b} } }
end
