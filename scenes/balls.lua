-- The sphereflake: every ball carries nine of a third of its size: mirrors all the way down
--
-- After "balls" of Eric Haines' Standard Procedural Databases (1987), with which ray tracers have
-- been compared ever since. depth = 4 is 7,381 balls, 5 is 66,430, 6 is 597,871.
-- Try:  snell balls.lua -D depth=6
--       snell balls.lua -D shine=1      nothing but mirrors

local depth = param("depth", 4, "levels of balls around balls")
local shine = param("shine", 0.45, "how much of a ball is mirror, 0 to 1")

render { integrator = "whitted", width = 800, height = 600, samples = 16, max_depth = 8 }
camera { from = {2.2, 1.5, 3.1}, at = {0, -0.03, 0}, fov = 30 }

background { color = {0.75, 0.82, 0.9}, top = {0.02, 0.1, 0.36} }
ambient { color = 0.008 }

-- Three lights, as in the original: one key, two that fill.
light.point { position = {4, 6, 5}, intensity = 260 }
light.point { position = {-6, 4, 3}, intensity = 70 }
light.point { position = {1, 5, -6}, intensity = 90 }

-- One material for each level: the deeper, the warmer.
local materials = {}
for level = 0, depth do
    local t = depth > 0 and level / depth or 0
    materials[level] = material.partial_mirror {
        color = {0.75 + 0.2 * t, 0.78 - 0.18 * t, 0.85 - 0.6 * t}, specularity = shine }
end

-- ---- vectors are plain tables {x, y, z} ----

local function add(a, b, scale)   -- a + scale * b
    return { a[1] + scale * b[1], a[2] + scale * b[2], a[3] + scale * b[3] }
end

local function cross(a, b)
    return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

local function normalize(a)
    local length = math.sqrt(a[1] * a[1] + a[2] * a[2] + a[3] * a[3])
    return { a[1] / length, a[2] / length, a[3] / length }
end

-- Two directions that stand upright on n, and on each other.
local function frame(n)
    local other = math.abs(n[1]) < 0.9 and {1, 0, 0} or {0, 1, 0}
    local u = normalize(cross(n, other))
    return u, cross(n, u)
end

-- The places of the nine: six around the equator, three nearer to the pole. A ball's pole points
-- away from its parent, so that no child is inside the grandparent.
local places = {}
for i = 0, 5 do places[#places + 1] = { turn = 60 * i, tilt = 0 } end
for i = 0, 2 do places[#places + 1] = { turn = 30 + 120 * i, tilt = 55 } end

local function flake(center, radius, pole, level)
    sphere { center = center, radius = radius, material = materials[level] }
    if level == depth then return end
    local u, v = frame(pole)
    for _, place in ipairs(places) do
        local turn, tilt = math.rad(place.turn), math.rad(place.tilt)
        local flat = math.cos(tilt)
        local direction = add(add(add({0, 0, 0}, u, flat * math.cos(turn)),
                                  v, flat * math.sin(turn)), pole, math.sin(tilt))
        flake(add(center, direction, radius * 4 / 3), radius / 3, direction, level + 1)
    end
end

flake({0, 0, 0}, 0.5, normalize {0.1, 1, 0.05}, 0)

-- The ground, under the lowest ball.
plane { point = {0, -0.76, 0},
        material = material.lambert { color = {0.62, 0.46, 0.3} },
        name = "ground" }
