-- A white room with one red and one blue wall: light that comes from walls
--
-- The room of Goral, Torrance, Greenberg and Battaile ("Modeling the Interaction of Light Between
-- Diffuse Surfaces", 1984), built with other measures and other colours. Only the lamp shines; the
-- ceiling, which it cannot reach, is lit by the floor and the walls alone, and white things near a
-- coloured wall take its colour. Path tracing (Kajiya 1986) follows one way that the light may have
-- come at a time, and joins it to a point of the lamp at every bounce.
-- Try:  snell cornell-box.lua --max-depth 1      direct light only: the ceiling is black
--       snell cornell-box.lua -D metal=true      the tall block in polished steel
--       snell cornell-box.lua --samples 1024     less noise: half of it for four times the samples

local metal = param("metal", false, "whether the tall block is a mirror")

render { integrator = "path", width = 420, height = 420, samples = 144, max_depth = 16 }
camera { from = {0, 1.2, 5.55}, at = {0, 1.2, 0}, fov = 30.5 }

local white = material.lambert { color = {0.74, 0.73, 0.7} }
local red = material.lambert { color = {0.6, 0.06, 0.04} }
local blue = material.lambert { color = {0.06, 0.15, 0.5} }

-- The room: 2.4 m wide, high and deep, open towards the camera.
local half, depth = 1.2, 2.4
local function wall(name, corner, u, v, material)
    quad { corner = corner, u = u, v = v, material = material, name = name }
end
wall("floor",   {-half, 0, half},      {depth, 0, 0}, {0, 0, -depth}, white)
wall("ceiling", {-half, depth, -half}, {depth, 0, 0}, {0, 0, depth}, white)
wall("back",    {-half, 0, -half},     {depth, 0, 0}, {0, depth, 0}, white)
wall("left",    {-half, 0, half},      {0, 0, -depth}, {0, depth, 0}, red)
wall("right",   {half, 0, -half},      {0, 0, depth}, {0, depth, 0}, blue)

-- The lamp: a square just below the ceiling that shines down.
light.quad { corner = {-0.3, depth - 0.004, -0.3}, u = {0.6, 0, 0}, v = {0, 0, 0.6},
             radiance = {27, 23.5, 19}, name = "lamp" }

-- Two blocks, turned a little. A box is made around the origin, turned, and then put down.
local function block(size, x, z, angle, material, name)
    box { min = {-size[1] / 2, 0, -size[3] / 2}, max = {size[1] / 2, size[2], size[3] / 2},
          transform = transform.translate {x, 0, z} * transform.rotate { axis = {0, 1, 0}, angle = angle },
          material = material, name = name }
end
block({0.7, 1.42, 0.7}, -0.42, -0.42, 19, metal and material.conductor { metal = "chromium" } or white, "tall block")
block({0.68, 0.68, 0.68}, 0.44, 0.4, -17, white, "cube")
