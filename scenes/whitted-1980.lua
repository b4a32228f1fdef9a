-- A glass sphere and a mirror sphere over a checkered floor: the picture that started it
--
-- After the picture of Turner Whitted, "An Improved Illumination Model for Shaded Display",
-- Communications of the ACM 23(6), 1980: the first one in which a ray, where it hits something,
-- sends out more rays. Look for three things in it:
--   1. the mirror sphere shows the floor, the sky and the glass (reflected rays);
--   2. the glass bends what is behind it (refracted rays), and mirrors the sky at its rim (Fresnel);
--   3. shadows are sharp: one shadow ray to each point light. The bubble's shadow is pale, because
--      a shadow ray is filtered by glass, straight through.
-- Try:  snell whitted-1980.lua -i appel        1968: the same scene before there were ray trees
--       snell whitted-1980.lua --max-depth 1   what is lost when the tree is cut

render { integrator = "whitted", width = 800, height = 600, samples = 16, max_depth = 10 }

camera { from = {0.1, 1.5, 6.4}, at = {0.16, 1.18, 0}, fov = 37 }

-- The sky: a gradient from straight down (color) to straight up (top).
background { color = {0.62, 0.84, 1.1}, top = {0.01, 0.08, 0.42} }

-- Whitted's illumination model has a constant ambient term. It is the same on every surface,
-- whatever its colour, so a little is enough: more makes everything grey.
ambient { color = {0.012, 0.014, 0.02} }
light.point { position = {5, 9, 6}, intensity = 480 }   -- the main light, over the right shoulder
light.point { position = {-6, 7, 4}, intensity = 90 }   -- a weaker one: its shadows are the pale ones

-- The floor: a rectangle, as in the original, not a plane. Squares of one metre.
local tiles = material.lambert {
    color = texture.checker { "#e8c81e", "#c4161c", size = 1, map = "xz" },
}
quad { corner = {-7, 0, 4}, u = {14, 0, 0}, v = {0, 0, -24}, material = tiles, name = "floor" }

-- A glass bubble: a sphere of glass with a sphere of air in it. Where two solids overlap, the one
-- with the higher priority is there, so the air is cut out of the glass.
local glass = material.dielectric { ior = 1.5, absorption = {0.25, 0.08, 0.12} }
local air = material.dielectric { ior = 1, priority = 1 }
local center = {-0.42, 1.62, 1.3}
sphere { center = center, radius = 0.95, material = glass, name = "bubble" }
sphere { center = center, radius = 0.86, material = air, name = "inside of the bubble" }

-- The second sphere is a mirror in part: s * Trace + (1 - s) * Direct.
local mirror = material.partial_mirror { color = {0.9, 0.92, 0.97}, specularity = 0.88 }
sphere { center = {0.98, 0.98, -0.75}, radius = 0.98, material = mirror, name = "mirror" }
