-- The Cornell box as the other path tracers see it
--
-- The room that was measured at Cornell University (Goral and others, 1984; www.graphics.cornell.edu/
-- online/box/data.html), in metres, its colours as three numbers each. bench/renders exports it and
-- measures the time that snell, Cycles and Mitsuba take to equal noise.
-- Try:  snell scenes/peers/cornell.lua --samples 1024

render { integrator = "path", width = 512, height = 512, samples = 64, max_depth = 8 }
camera { from = {2.78, 2.73, -8}, at = {2.78, 2.73, 0}, fov = 39.3 }

local white = material.lambert { color = 0.73 }
local red = material.lambert { color = {0.63, 0.065, 0.05} }
local green = material.lambert { color = {0.14, 0.45, 0.091} }

-- Few of the measured walls are parallelograms: each is two triangles.
local function wall(material, ...)
  local corners = {...}
  for i, p in ipairs(corners) do corners[i] = {p[1] / 100, p[2] / 100, p[3] / 100} end
  mesh { positions = corners, indices = {0, 1, 2, 0, 2, 3}, material = material }
end
wall(white, {552.8, 0, 0}, {0, 0, 0}, {0, 0, 559.2}, {549.6, 0, 559.2})
wall(white, {556, 548.8, 0}, {556, 548.8, 559.2}, {0, 548.8, 559.2}, {0, 548.8, 0})
wall(white, {549.6, 0, 559.2}, {0, 0, 559.2}, {0, 548.8, 559.2}, {556, 548.8, 559.2})
wall(green, {0, 0, 559.2}, {0, 0, 0}, {0, 548.8, 0}, {0, 548.8, 559.2})
wall(red, {552.8, 0, 0}, {549.6, 0, 559.2}, {556, 548.8, 559.2}, {556, 548.8, 0})

local function block(height, ...)
  local base, top = {...}, {}
  for i, p in ipairs(base) do top[i] = {p[1], height, p[2]} end
  wall(white, table.unpack(top))
  for i, p in ipairs(base) do
    local q = base[i % 4 + 1]
    wall(white, {p[1], 0, p[2]}, {p[1], height, p[2]}, {q[1], height, q[2]}, {q[1], 0, q[2]})
  end
end
block(165, {130, 65}, {82, 225}, {240, 272}, {290, 114})
block(330, {423, 247}, {265, 296}, {314, 456}, {472, 406})

light.quad { corner = {3.43, 5.487, 2.27}, u = {0, 0, 1.05}, v = {-1.3, 0, 0}, radiance = {17, 12, 4} }
