-- Looking up from under water: all the world in one bright circle, and the pool's floor around it
--
-- Light that enters water is bent towards the normal: sin(a) = n sin(b), n = 1.333. Even a ray that
-- grazes the surface (a = 90 degrees) arrives at b = asin(1/n) = 48.6 degrees. So from below, the
-- whole sky down to the horizon is pressed into a cone of 97 degrees: Snell's window. Beyond that
-- angle nothing comes in from above; the surface is a perfect mirror (total internal reflection) and
-- shows the floor and the walls of the pool.
-- Try:  snell snells-window.lua -D depth=1     nearer to the surface: the same circle, bigger things
--       snell snells-window.lua -D ior=1.1     a liquid that bends less has a wider window

local depth = param("depth", 2.2, "metres from the eye to the surface")
local ior = param("ior", 1.333, "index of refraction of the liquid")

render { integrator = "whitted", width = 800, height = 600, samples = 16, max_depth = 8 }

-- The eye looks up, a little tilted towards the pier. It starts inside the water; snell finds that
-- out by itself.
camera { from = {0, -depth, 0}, at = {0, 0, -0.2}, up = {0, 0, -1}, fov = 116 }

background { color = {1.5, 1.25, 1.0}, top = {0.2, 0.48, 1.0} }
ambient { color = {0.01, 0.02, 0.025} }
light.directional { direction = {0.45, -1, 0.35}, irradiance = 2.2 }
-- Two lamps in the pool, and one over it: without them all that hangs above, seen from its shadow
-- side, would be dark against the sky.
light.point { position = {-3.2, -2.6, 2.6}, intensity = 22 }
light.point { position = {3.2, -2.6, -1.2}, intensity = 22 }
light.point { position = {0.2, 0.9, 0.9}, intensity = 75 }

-- The water: everything under a plane. Red light is lost first: exp(-a d), with a per metre.
local water = material.dielectric { ior = ior, absorption = {0.16, 0.035, 0.02} }
plane { point = {0, 0, 0}, normal = {0, 1, 0}, material = water, name = "water" }

-- The pool: a floor and four walls of tiles, all inward.
local floor_y, side = -3.6, 5
local floor_tiles = material.lambert { color = texture.checker { "#f2f6f5", "#1f7f9c", size = 0.5, map = "xz" } }
local wall_tiles = material.lambert { color = texture.checker { "#eef4f2", "#62b6c4", size = 0.5, map = "object" } }
quad { corner = {-side, floor_y, side}, u = {2 * side, 0, 0}, v = {0, 0, -2 * side},
       material = floor_tiles, name = "pool floor" }
for i = 0, 3 do
    quad { corner = {-side, floor_y, -side}, u = {2 * side, 0, 0}, v = {0, -floor_y + 0.12, 0},
           transform = transform.rotate { axis = {0, 1, 0}, angle = 90 * i },
           material = wall_tiles, name = "pool wall " .. i + 1 }
end

-- Above: a pier of planks on posts, running out over the water.
local wood = material.lambert { color = "#9a6b3f" }
local dark_wood = material.lambert { color = "#6e4627" }
for i = 0, 8 do
    local z = -1.15 - 0.46 * i
    box { min = {-0.85, 0.62, z - 0.2}, max = {0.85, 0.7, z + 0.2},
          material = i % 2 == 0 and wood or dark_wood, name = "plank " .. i + 1 }
end
for i = 0, 2 do
    for side_x = -1, 1, 2 do
        local x, z = 0.72 * side_x, -1.3 - 1.6 * i
        box { min = {x - 0.09, floor_y, z - 0.09}, max = {x + 0.09, 1.35, z + 0.09},
              material = dark_wood }
    end
end

-- Three balls float half in the water. Paper lanterns hang over it in a spiral, each lower and
-- farther than the last, and show how the window squeezes what is near the horizon.
local function paint(color) return material.blinn_phong { color = color, specular = 0.6, exponent = 80 } end
sphere { center = {1.25, 0.08, 0.55}, radius = 0.34, material = paint "#e0281e", name = "red float" }
sphere { center = {-1.5, 0.05, 0.35}, radius = 0.26, material = paint "#f5f2ea", name = "white float" }
sphere { center = {-0.55, 0.05, 1.15}, radius = 0.2, material = paint "#f2b90f", name = "yellow float" }

for i = 1, 9 do
    local angle = math.rad(-20 + 25 * i)               -- round the eye
    local high, far = 6.5 - 0.62 * i, 5 + 0.75 * i     -- lower and farther
    local hue = (i - 1) / 8                            -- from blue to orange
    local r, g, b = 0.15 + 0.85 * hue, 0.3 + 0.15 * hue, 1 - 0.95 * hue
    sphere { center = {far * math.cos(angle), high, far * math.sin(angle)}, radius = 1,
             material = material.lambert { color = {r, g, b}, emission = {0.6 * r, 0.6 * g, 0.6 * b} },
             name = "lantern " .. i }
end
