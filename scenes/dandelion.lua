-- A dandelion clock: hair, stalk and grass from curves
--
-- Each thread is a cubic curve with a thickness, found by the ray itself: thinner than a pixel and
-- still round, without a triangle. A parachute is a stem and a fan of bristles; the meadow is ribbons that
-- taper to a point. 17,000 strands in two shapes and some instances.
-- Try:  snell dandelion.lua -D seeds=60        after a gust

local seeds = param("seeds", 190, "parachutes left on the head")
local blades = param("blades", 6000, "blades of grass")

render { integrator = "cook", width = 640, height = 480, samples = 49 }
camera { from = {0, 0.56, 1.35}, at = {0.02, 0.5, 0}, fov = 38, lens_radius = 0.006, focus = 1.33 }

local state = 12345
local function random()                    -- a plain linear generator: the same everywhere
    state = (state * 1103515245 + 12345) & 0x7fffffff
    return state / 0x7fffffff
end

-- ---- one parachute, from the origin along +Y ----
local points, radii, starts = {}, {}, {}
local function begin() starts[#starts + 1] = #points end
local function add(x, y, z, r) points[#points + 1], radii[#radii + 1] = {x, y, z}, r end

begin()
add(0, -0.02, 0, 0.0012) add(0, 0, 0, 0.0022) add(0, 0.02, 0, 0.0008)
add(0, 0.07, 0, 0.0005) add(0, 0.15, 0, 0.0005) add(0, 0.16, 0, 0.0005)
for i = 1, 40 do
    local angle, lift = 2.39996 * i, 0.25 + 0.5 * (i % 5) / 5
    local c, s = math.cos(angle), math.sin(angle)
    begin()
    add(0, 0.14, 0, 0.0005)
    for k = 0, 4 do
        local t = k / 4
        add(0.075 * t * c, 0.15 + 0.06 * lift * t * (1.6 - 0.7 * t), 0.075 * t * s, 0.0006 - 0.0004 * t)
    end
    add(0.085 * c, 0.15 + 0.06 * lift, 0.085 * s, 0.0001)
end
local white = material.lambert { color = {0.92, 0.9, 0.86} }
local parachute = group { curves { points = points, radii = radii, starts = starts, material = white } }

-- ---- the head: parachutes at the places of a spiral over the sphere ----
local head = {0, 0.56, 0}
for i = 1, seeds do
    local y = 1 - 1.86 * (i - 0.5) / seeds
    local r, angle = math.sqrt(1 - y * y), 2.39996 * i
    local x, z = r * math.cos(angle), r * math.sin(angle)
    local tilt = math.deg(math.acos(y))
    instance { parachute, transform = transform.translate(head)
        * transform.rotate { axis = {z, 0, -x}, angle = tilt } * transform.translate {0, 0.045, 0} }
end
sphere { center = head, radius = 0.045, material = material.lambert { color = {0.5, 0.42, 0.24} }, name = "receptacle" }

-- ---- stalk and meadow ----
curves { points = { {0.05, -0.1, -0.02}, {0.04, 0, -0.02}, {-0.02, 0.2, 0}, {0.01, 0.4, 0}, {0, 0.53, 0}, {0, 0.58, 0} },
         radius = 0.011, material = material.lambert { color = {0.42, 0.46, 0.16} }, name = "stalk" }

local grass, widths, firsts = {}, {}, {}
for _ = 1, blades do
    local x, z = 3.4 * (random() - 0.5), 0.75 - 3.6 * random()
    local height, lean, angle = 0.12 + 0.2 * random(), 0.05 + 0.12 * random(), 2 * math.pi * random()
    local dx, dz = lean * math.cos(angle), lean * math.sin(angle)
    firsts[#firsts + 1] = #grass
    for k = -1, 5 do
        local t = k / 4
        grass[#grass + 1] = { x + dx * t * math.abs(t), height * t * (1.3 - 0.3 * t), z + dz * t * math.abs(t) }
        widths[#widths + 1] = math.max(0.0003, 0.0042 * (1 - math.max(t, 0) ^ 2))
    end
end
curves { points = grass, radii = widths, starts = firsts, kind = "ribbon", name = "grass",
         material = material.lambert { color = {0.13, 0.26, 0.05} } }
plane { material = material.lambert { color = {0.08, 0.1, 0.04} }, name = "ground" }

background { color = {0.4, 0.5, 0.62}, top = {0.1, 0.22, 0.5} }
light.environment { radiance = {0.36, 0.42, 0.52}, visible = false, name = "sky" }
light.directional { direction = {0.8, -1, 0.45}, irradiance = {2.9, 2.75, 2.4}, angle = 0.53 }
