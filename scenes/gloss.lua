-- Five plates from mirror to matt: a reflection blurs with roughness, and with distance
--
-- A polished plate has one normal, a rough one has many tiny facets with normals of their own. Cook
-- (1984) sends the reflected ray in a direction drawn from the lobe that such facets make, and the
-- mean of many rays is the blurred image. The cones stand on the plates: at the foot the blur has
-- had no way to spread, at the tip it has.
-- Roughness from left to right: 0, 0.1, 0.17, 0.25, 0.4; alpha of the GGX lobe is its square.
-- Try:  snell gloss.lua -D metal=copper
--       snell gloss.lua --samples 4            one ray for each lobe: gloss is noise first

local metal = param("metal", "silver", "what the plates are made of")

render { integrator = "cook", width = 640, height = 480, samples = 100, max_depth = 6 }
camera { from = {0, 2.5, 6.2}, at = {0, 0.28, 0}, fov = 31 }

-- The hall: dark below, bright above. Rays that leave a plate see it, and the large lamp.
background { color = {0.03, 0.03, 0.04}, top = {0.34, 0.38, 0.46} }
ambient { color = 0.02 }
light.quad { center = {-2.5, 5.5, 4.5}, at = {0, 0, 0}, width = 4.5, radiance = 4.6, name = "softbox" }

quad { corner = {-30, -0.1, 30}, u = {60, 0, 0}, v = {0, 0, -60}, name = "table",
       material = material.lambert { color = {0.16, 0.13, 0.12} } }

local roughnesses = { 0, 0.1, 0.17, 0.25, 0.4 }
local colors = { {"#c8321f", "#f1e9da"}, {"#d98a1f", "#f1e9da"}, {"#3f8f4a", "#f1e9da"},
                 {"#2a74b8", "#f1e9da"}, {"#7a4aa0", "#f1e9da"} }
for i, roughness in ipairs(roughnesses) do
    local x = 1.04 * (i - 3)
    box { min = {x - 0.5, -0.1, -1.2}, max = {x + 0.5, 0, 1.9},
          material = material.conductor { metal = metal, roughness = roughness },
          name = "plate " .. i }
    -- A cone of six rings, so that one can count how far up the image stays readable.
    for ring = 0, 5 do
        local low, high = ring / 6, (ring + 1) / 6
        cone { from = {x, 1.3 * low, -0.55}, to = {x, 1.3 * high, -0.55}, capped = false,
               radius = 0.34 * (1 - low), radius_to = 0.34 * (1 - high),
               material = material.lambert { color = colors[i][1 + ring % 2] } }
    end
end
