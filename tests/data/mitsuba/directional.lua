-- floating_sphere/test_directional_direct.xml of Mitsuba 3's render tests: a small white ball over a
-- white square under a lamp at infinity.

local models = param("models", "../../models/mitsuba-scenes", "the folder of Mitsuba's scenes")

-- Their integrator "direct" is depth 0 here.
render { integrator = "path", width = 48, height = 48, samples = 868, max_depth = 0 }
local diagonal = math.sqrt(36 * 36 + 24 * 24) / 50
camera { from = {0, -5, 1}, at = {0, 0, 0.5}, up = {0, 0, 1},
         fov = math.deg(2 * math.atan(diagonal / math.sqrt(2) / 2)) }
light.directional { direction = {0, 0, -1}, irradiance = 1 }

local white = material.lambert { color = 1 }
mesh { file = models .. "/common/meshes/rectangle.obj", material = white }
mesh { file = models .. "/common/meshes/sphere.obj", material = white,
       transform = transform.translate {0, 0, 1} * transform.scale(0.1) }
