-- A glass ball and a mirror ball over a checkered floor: the picture that made ray tracing known.
--
-- After the title picture of Turner Whitted's "An Improved Illumination Model for Shaded Display" (1980).
-- Try:  -i appel               what 1968 saw: shadows, but neither mirrors nor glass
--       --max-depth 1, 2, 3    one more generation of the ray tree each time
--       -D ior=1.0             glass that bends nothing, or 2.417 for diamond

local ior = param("ior", 1.5, "index of refraction of the glass ball")

render { integrator = "whitted", width = 800, height = 600, samples = 16 }

camera { from = {0, 1.75, 7.6}, at = {0.15, 1.02, 0}, fov = 36 }

-- The sky: from a bright horizon up to deep blue. Rays that hit nothing see it, so mirrors do too.
background { color = {0.62, 0.76, 0.95}, top = {0.04, 0.14, 0.50} }
ambient { color = 0.03 } -- fills the shadows a little; a constant, not physics

-- The sun of this small world, and a weaker lamp from the left.
light.directional { direction = {0.55, -1.0, -0.62}, irradiance = 2.6 }
light.point { position = {-5, 4, 5}, intensity = 22 }

-- Squares of 85 cm, measured along x and z; the floor ends far away, where the sky begins.
local tiles = texture.checker { {0.90, 0.66, 0.07}, {0.72, 0.05, 0.04}, size = 0.85, map = "xz" }
quad { corner = {-17, 0, -34}, u = {0, 0, 42}, v = {34, 0, 0},
       material = material.lambert { color = tiles } }

-- Glass: at every hit the ray splits into a reflected and a refracted ray, by Fresnel's formulas.
-- The little absorption is Beer's law: a trace of green where light travels far in it.
sphere { name = "glass", center = {-0.62, 1.42, 2.3}, radius = 0.92,
         material = material.dielectric { ior = ior, absorption = {0.06, 0.02, 0.04} } }

-- The mirror ball stands behind it, to the right.
sphere { name = "mirror", center = {1.02, 0.98, 0.15}, radius = 0.98,
         material = material.partial_mirror { color = {0.95, 0.93, 0.90}, specularity = 0.86 } }
