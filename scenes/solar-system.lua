-- The planets in their order, one frame of an animation: the inner ones are the faster ones
--
-- Kepler's third law: the square of a planet's year is as the cube of its distance. Distances and
-- sizes are squeezed here, or there would be nothing to see; the order of the years is kept. Every
-- planet has its place as a function of time. The program runs once for each frame; within a frame the
-- shutter is open for half of it, and what moves is blurred along its way.
-- Try:  snell solar-system.lua --frames 1..240 -o planets.png     ten seconds; planets.0001.png and on
--       snell solar-system.lua -D asteroids=3000

local count = param("asteroids", 700, "between Mars and Jupiter")
local year = param("year", 4, "seconds that the earth takes round the sun")

animation { fps = 24, first = 1, last = 240 }

render { integrator = "cook", width = 768, height = 432, samples = 64, max_depth = 3,
         exposure = 1.5, tonemap = "reinhard" }
camera { from = {0, 10.5, 20}, at = {0, -0.5, 0}, fov = 29, shutter = {0, 0.5} }

background { color = {0.0004, 0.0004, 0.001} }
ambient { color = 0.004 }

-- What lights the planets is not seen: a disk so much brighter than white has steps for an edge. What
-- is seen of the sun, and the stars, only glow: ambient light is a constant that a material shows k_a
-- times, and lights nothing else.
light.sphere { center = {0, 0, 0}, radius = 0.8, radiance = {60, 46, 28}, visible = false, name = "sunlight" }
sphere { center = {0, 0, 0}, radius = 0.8, name = "Sun",
         material = material.lambert { color = 0, ambient = {1000, 560, 190}, shadow = "none" } }
for i = 1, 1500 do
    local longitude, height = math.random() * 2 * math.pi, 2 * math.random() - 1
    local flat = math.sqrt(1 - height * height)
    local bright = 30 + 500 * math.random() ^ 4
    sphere { center = {90 * flat * math.cos(longitude), 90 * height, 90 * flat * math.sin(longitude)},
             radius = 0.07, material = material.lambert { color = 0, ambient = bright } }
end

-- Round the sun from angle `start`, at distance r, by Kepler: the year grows with r^(3/2).
local function orbit(r, start, t, height)
    local angle = math.rad(start) + 2 * math.pi * t / (year * (r / 3.2) ^ 1.5)
    return transform.translate { r * math.cos(angle), height or 0, -r * math.sin(angle) }
end
local function spin(t, tilt, turns)
    return transform.rotate { axis = {0, 0, 1}, angle = tilt } * transform.rotate { axis = {0, 1, 0}, angle = 360 * turns * t }
end

local way = material.lambert { color = 0, ambient = {5, 6, 8}, shadow = "none" }
local function planet(name, r, start, radius, tilt, material, parts)
    torus { center = {0, 0, 0}, axis = {0, 1, 0}, major = r, minor = 0.006, material = way }
    local ball = sphere { radius = radius, material = material }
    instance { group { ball, table.unpack(parts or {}) }, name = name,
               motion = function(t) return orbit(r, start, t) * spin(t, tilt, 0.25) end }
end
local function clouds(a, b, size, kind)
    return material.lambert { color = texture.noise { color_a = a, color_b = b, size = size, kind = kind or "fbm" } }
end

planet("Mercury", 1.6, 205, 0.11, 0, clouds({0.25, 0.22, 0.2}, {0.6, 0.55, 0.5}, 0.05))
planet("Venus", 2.4, 320, 0.19, 3, clouds({0.75, 0.5, 0.22}, {0.95, 0.85, 0.6}, 0.2))

-- The earth, with a moon that goes round it thirteen times a year.
planet("Earth", 3.2, 245, 0.21, 23, clouds({0.02, 0.08, 0.35}, {0.75, 0.85, 0.8}, 0.14))
instance { sphere { radius = 0.06, material = material.lambert { color = 0.5 } }, name = "Moon", motion = function(t)
    local a = 2 * math.pi * 13 * t / year + 0.7
    return orbit(3.2, 245, t) * transform.translate { 0.4 * math.cos(a), 0.1 * math.cos(a), -0.4 * math.sin(a) }
end }
planet("Mars", 4.05, 160, 0.15, 25, clouds({0.3, 0.07, 0.03}, {0.75, 0.35, 0.16}, 0.12))

-- Saturn has rings, Uranus lies on its side.
planet("Jupiter", 6.3, 140, 0.62, 3, clouds({0.4, 0.22, 0.12}, {0.9, 0.8, 0.65}, 0.3))
planet("Saturn", 8.1, 36, 0.5, 27, clouds({0.6, 0.45, 0.25}, {0.9, 0.8, 0.55}, 0.5), {
    disk { normal = {0, 1, 0}, radius = 0.86, inner_radius = 0.66, material = material.lambert { color = {0.62, 0.54, 0.4} } },
    disk { normal = {0, 1, 0}, radius = 1.12, inner_radius = 0.9, material = material.lambert { color = {0.5, 0.44, 0.34} } },
})
planet("Uranus", 9.6, 187, 0.32, 98, material.lambert { color = {0.45, 0.75, 0.78} })
planet("Neptune", 10.9, 78, 0.3, 28, clouds({0.06, 0.14, 0.6}, {0.2, 0.4, 0.85}, 0.3))

-- The asteroids: each on its own way.
local rock = material.lambert { color = {0.42, 0.38, 0.34} }
for i = 1, count do
    local r, start = 4.75 + 0.62 * math.random(), 360 * math.random()
    local height, radius = 0.16 * (math.random() - 0.5), 0.008 + 0.022 * math.random() ^ 3
    instance { sphere { radius = radius, material = rock }, motion = function(t) return orbit(r, start, t, height) end }
end
