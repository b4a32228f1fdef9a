-- The sphereflake as the other ray tracers see it
--
-- 7,381 balls, matte and mirror by halves, over a floor, and three lamps: nothing that POV-Ray and
-- Tachyon do not have as well, so that all draw one picture. bench/renders exports it and times them.
-- Z is up. Try:  snell scenes/peers/balls.lua -D depth=5

local depth = param("depth", 4, "levels of balls around balls")

render { integrator = "whitted", width = 1024, height = 1024, samples = 1, max_depth = 5 }
camera { from = {2.1, 1.3, 1.7}, at = {0, 0, 0}, up = {0, 0, 1}, fov = 45 }
background { color = {0.078, 0.361, 0.753} }
light.point { position = {4, 3, 2}, intensity = 36 }
light.point { position = {1, -4, 4}, intensity = 40 }
light.point { position = {-3, 1, 5}, intensity = 42 }

plane { point = {0, 0, -0.5}, normal = {0, 0, 1}, material = material.lambert { color = {1, 0.75, 0.33} } }

local function add(a, b, scale) -- a + scale * b
  return {a[1] + scale * b[1], a[2] + scale * b[2], a[3] + scale * b[3]}
end
local function cross(a, b)
  return {a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1]}
end
local function normalize(a)
  local length = math.sqrt(a[1] * a[1] + a[2] * a[2] + a[3] * a[3])
  return {a[1] / length, a[2] / length, a[3] / length}
end

-- Nine directions: six around the equator, three nearer to the pole, which points away from the parent.
local places = {}
for i = 0, 5 do places[#places + 1] = {turn = 60 * i, tilt = 0} end
for i = 0, 2 do places[#places + 1] = {turn = 30 + 120 * i, tilt = 54.7356} end

local half_mirror = material.partial_mirror { color = 1, specularity = 0.5 }

local function flake(center, radius, pole, level)
  sphere { center = center, radius = radius, material = half_mirror }
  if level == depth then return end
  local u = normalize(cross(math.abs(pole[1]) < 0.9 and {1, 0, 0} or {0, 1, 0}, pole))
  local v = cross(pole, u)
  for _, place in ipairs(places) do
    local turn, tilt = math.rad(place.turn), math.rad(place.tilt)
    local flat = add(add({0, 0, 0}, u, math.cos(tilt) * math.cos(turn)), v, math.cos(tilt) * math.sin(turn))
    local direction = add(flat, pole, math.sin(tilt))
    flake(add(center, direction, radius * 4 / 3), radius / 3, direction, level + 1)
  end
end
flake({0, 0, 0}, 0.5, normalize {1, 1, 0}, 0)
