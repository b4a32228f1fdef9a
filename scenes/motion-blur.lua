-- A billiard table while the shutter is open: each ball is as blurred as it is fast
--
-- In the picture of five billiard balls in "Distributed Ray Tracing" (Cook, Porter, Carpenter, 1984)
-- each ray has a time of its own while the shutter is open, and meets everything where it was at
-- that time. This is another table with the same lesson:
--   1. the white ball has hit the red one halfway through the exposure, and rebounds slowly;
--   2. the red ball lay still until then: its image is sharp at one end, and trails off;
--   3. the green ball rolls: its stripe turns, so that its top is more blurred than its foot;
--   4. the yellow ball spins on the spot: its outline is sharp, and what is painted on it is not.
-- Shadows, and the lamps mirrored in the balls, move (or do not) by the same times.
-- Try:  snell motion-blur.lua -D open=0        a frozen moment

local open = param("open", 1, "how long the shutter is open, in 1/24 s")

render { integrator = "cook", width = 640, height = 480, samples = 81, max_depth = 4 }
camera { from = {0.04, 0.44, 0.66}, at = {0.012, 0.012, -0.02}, fov = 29, shutter = {0, open} }

local exposure = 1 / 24                          -- seconds
local impact = 0.5 * exposure                   -- when white meets red

-- Two lamps over the table, and what light the room has. Units are metres: a ball is 57 mm wide.
background { color = {0.012, 0.012, 0.015}, top = {0.05, 0.05, 0.06} }
ambient { color = {0.022, 0.03, 0.024} }
for x = -0.3, 0.3, 0.6 do
    light.quad { corner = {x - 0.2, 0.8, -0.35}, u = {0.4, 0, 0}, v = {0, 0, 0.24},
                 radiance = {17, 15.5, 13.4}, name = x < 0 and "left lamp" or "right lamp" }
end

-- ---- the table ----
local cloth = material.lambert { color = texture.noise { size = 0.004, octaves = 3,
                                     color_a = {0.012, 0.16, 0.07}, color_b = {0.03, 0.27, 0.12} } }
local wood = material.glazed { ior = 1.45, base = material.lambert {
    color = texture.noise { kind = "marble", size = 0.09, distortion = 1.6, map = "object",
                            color_a = {0.13, 0.05, 0.022}, color_b = {0.19, 0.08, 0.035} } } }
quad { corner = {-2, 0, 1}, u = {4, 0, 0}, v = {0, 0, -1.42}, material = cloth, name = "cloth" }
box { min = {-2, 0, -0.47}, max = {2, 0.037, -0.42}, material = cloth, name = "cushion" }
box { min = {-2, -0.05, -0.62}, max = {2, 0.042, -0.47}, material = wood, name = "rail" }

-- ---- the balls: lacquer over paint ----
local radius = 0.0286
local function lacquer(color)
    return material.glazed { ior = 1.5, base = material.lambert { color = color } }
end
local ivory = lacquer "#f2ead2"

-- An arc of the ball from one latitude to another (degrees), turned about its axis.
local function zone(from, to, material)
    local profile, steps = {}, 24
    for i = 0, steps do
        local latitude = math.rad(from + (to - from) * i / steps)
        profile[#profile + 1] = { math.max(0, radius * 1.001 * math.cos(latitude)),
                                  radius * 1.001 * math.sin(latitude) }
    end
    return lathe { profile = profile, material = material }
end

-- A ball of one colour with a white spot at each pole, or white with a broad stripe.
local function ball(color, striped)
    local paint = lacquer(color)
    local core = sphere { radius = radius, material = striped and ivory or paint }
    if striped then return group { core, zone(-27, 27, paint) } end
    return group { core, zone(66, 90, ivory), zone(-90, -66, ivory) }
end

-- Where a ball is that rolls without slipping from `at`, `way` metres along the level direction
-- {x, z}: it turns by way / radius about the axis that lies across. `tilt` is how it lay before.
local function rolled(at, direction, way, tilt)
    return transform.translate { at[1] + way * direction[1], radius, at[2] + way * direction[2] }
         * transform.rotate { axis = {direction[2], 0, -direction[1]}, angle = math.deg(way / radius) }
         * tilt
end

local upright = transform.rotate { axis = {0, 0, 1}, angle = 0 }

-- White comes from the left along `aim`, and leaves most of its speed to red.
local red_at, aim = {0.075, 0.035}, {0.97, -0.243}
local touch = { red_at[1] - 2 * radius * aim[1], red_at[2] - 2 * radius * aim[2] }
instance { sphere { radius = radius, material = ivory }, name = "white", motion = function(t)
    local speed = t < impact and 2.2 or 0.25                        -- m/s
    return rolled(touch, aim, speed * (t - impact), upright)
end }
instance { ball "#a8150f", name = "red", motion = function(t)
    return rolled(red_at, aim, 1.9 * math.max(0, t - impact),
                  transform.rotate { axis = {1, 0, 0.4}, angle = 60 })
end }

-- Green rolls towards the cushion, its stripe about the axis that it does not turn about.
instance { ball("#0c6b3d", true), name = "green", motion = function(t)
    return rolled({-0.11, -0.16}, {0.6, -0.8}, 0.5 * t, transform.rotate { axis = {-0.5, 0, 1}, angle = 58 })
end }

-- Yellow spins on the spot, five turns a second. Black lies still.
instance { ball "#e0a010", name = "yellow", motion = function(t)
    return transform.translate { -0.035, radius, 0.17 }
         * transform.rotate { axis = {0, 1, 0}, angle = 360 * 5 * t }
         * transform.rotate { axis = {1, 0, -0.3}, angle = 62 }
end }
instance { ball "#15151a", name = "black", transform = rolled({0.13, -0.2}, {1, 0}, 0,
                                             transform.rotate { axis = {1, 0, -0.6}, angle = 55 }) }
