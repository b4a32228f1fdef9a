-- spot_light/test_spot_direct.xml of Mitsuba 3's render tests: a spot light with a picture in front of
-- it shines on a white wall; a little light comes from everywhere.
--
-- Our spot light has no picture, and fades by a smoothstep where Mitsuba's fades linearly with the
-- angle. So this is a slide projector: a spot light with a hard edge, a slide, and a ring that fades,
-- both of a glass that bends nothing (ior = 1).

local models = param("models", "../../models/mitsuba-scenes", "the folder of Mitsuba's scenes")
local cutoff, beam = math.rad(20), math.rad(15)
local slide_z, ring_z, eye_z, wall_z = 0.01, 0.012, 0.02, 1

-- A bounce may meet the surroundings; nothing else is in its way.
render { integrator = "path", width = 48, height = 48, samples = 868, max_depth = 1 }

-- Their camera is where the lamp is. Ours stands before the slide and sees as much of the wall: on a
-- flat matte wall that is the same picture.
camera { from = {0, 0, eye_z}, at = {0, 0, wall_z}, up = {0, 1, 0},
         fov = math.deg(2 * math.atan(math.tan(math.rad(25)) * wall_z / (wall_z - eye_z))) }

light.environment { radiance = 0.1 }
light.spot { position = {0, 0, 0}, at = {0, 0, 1}, intensity = 5, cone = math.deg(cutoff), blend = 0 }

local side = slide_z * math.tan(cutoff)
quad { corner = {-side, -side, slide_z}, u = {2 * side, 0, 0}, v = {0, 2 * side, 0},
       material = material.dielectric { ior = 1,
           color = texture.image { file = models .. "/scenes/spot_light/textures/de_bruijn_pattern.png" } } }

-- From 1 at the edge of the beam to 0 at the cutoff, and a little beyond.
local steps, around = 21, 360
local positions, colors, indices = {}, {}, {}
for i = 0, steps do
    local angle = beam + (cutoff - beam) * i / (steps - 1)
    local radius = ring_z * math.tan(angle)
    for j = 0, around - 1 do
        local turn = 2 * math.pi * j / around
        positions[#positions + 1] = {radius * math.cos(turn), radius * math.sin(turn), ring_z}
        local left = math.max(0, (cutoff - angle) / (cutoff - beam))
        colors[#colors + 1] = {left, left, left}
    end
end
for i = 0, steps - 1 do
    for j = 0, around - 1 do
        local a, b = i * around + j, i * around + (j + 1) % around
        for _, corner in ipairs { a, b + around, b, a, a + around, b + around } do
            indices[#indices + 1] = corner
        end
    end
end
mesh { positions = positions, colors = colors, indices = indices,
       material = material.dielectric { ior = 1 } }

quad { corner = {-3, -3, wall_z}, u = {0, 6, 0}, v = {6, 0, 0}, material = material.lambert { color = 1 } }
