-- A lamp with a size: the farther a thing is from its shadow, the softer the shadow is
--
-- A point of the floor that sees the whole lamp is lit, one that sees none of it is in the umbra,
-- and between the two lies the penumbra, where a part of the lamp is hidden. Cook, Porter and
-- Carpenter ("Distributed Ray Tracing", 1984) send each shadow ray to another point of the lamp:
-- the mean of many is the visible part. Look along a shadow: where the stem stands on the floor it
-- is sharp, and the ball on top has a blurred one. The highest ball hides less than the whole lamp
-- from any point of the floor: its shadow has no core.
-- Try:  snell soft-shadow.lua -D lamp=0.02     almost a point: hard shadows
--       snell soft-shadow.lua -i whitted       one ray to the lamp's centre
--       snell soft-shadow.lua --samples 4      noise: four points of the lamp for each pixel

local lamp = param("lamp", 1.8, "radius of the lamp in metres")

render { integrator = "cook", width = 640, height = 480, samples = 64, max_depth = 3 }
camera { from = {0.5, 4.7, 7.2}, at = {0.5, 0.5, -0.3}, fov = 30 }

ambient { color = {0.030, 0.034, 0.045} }   -- what a sky would add; without it umbras are black

-- The lamp has the same power at every size: L = P / (4 pi^2 r^2) for a sphere.
light.sphere { center = {-9.5, 12, 4.5}, radius = lamp, power = 10500, name = "lamp" }

local paper = material.lambert { color = {0.74, 0.7, 0.63} }
quad { corner = {-40, 0, 40}, u = {80, 0, 0}, v = {0, 0, -80}, material = paper, name = "floor" }

local stem = material.lambert { color = {0.35, 0.25, 0.16} }
local colors = { "#b3261e", "#d9822b", "#d8b32a", "#3d8b4f", "#2c6fb0" }
for i, color in ipairs(colors) do
    local x, height = -1.9 + 0.8 * (i - 1), 0.3 + 0.4 * (i - 1)
    cylinder { from = {x, 0, 0}, to = {x, height, 0}, radius = 0.035, material = stem }
    sphere { center = {x, height, 0}, radius = 0.26, name = "ball " .. i,
             material = material.blinn_phong { color = color, specular = 0.12, exponent = 40 } }
end
