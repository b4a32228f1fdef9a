-- A million triangles as the other ray tracers see them: a lumpy ball over a half mirror
--
-- 1,000,000 smooth triangles, two lamps: nothing that POV-Ray, Tachyon and Cycles do not have as well.
-- bench/renders exports it and times them. They read the triangles from files, and so does snell there
-- (file), since it is reading, not making them, that is compared.
-- Z is up. Try:  snell scenes/peers/blob.lua -D around=200

local around = param("around", 1000, "corners around the ball; half as many rings between its poles")
local file = param("file", "", "a file with its triangles, instead of making them")

render { integrator = "whitted", width = 1024, height = 1024, samples = 1, max_depth = 5 }
camera { from = {4.2, 2.6, 2.4}, at = {0, 0, 1}, up = {0, 0, 1}, fov = 40 }
background { color = {0.078, 0.361, 0.753} }
light.point { position = {5, 0, 6}, intensity = 110 }
light.point { position = {1, -5, 4}, intensity = 77 }

plane { point = {0, 0, 0}, normal = {0, 0, 1},
        material = material.mix { a = material.lambert { color = 0.7875 }, b = material.mirror { color = 1 }, weight = 0.6 } }

local clay = material.lambert { color = {0.68, 0.36, 0.16} }
if file ~= "" then
  mesh { file = file, material = clay }
  return
end

local sin, cos, pi = math.sin, math.cos, math.pi
local points, normals, faces = {}, {}, {}

local function add_point(x, y, z) -- of the unit sphere
  local r = 1 + 0.08 * sin(9 * x) * sin(9 * y) * sin(9 * z) + 0.02 * sin(60 * x) * sin(60 * y) * sin(60 * z)
  points[#points + 1] = {x * r, y * r, z * r + 1.3}
  normals[#normals + 1] = {0, 0, 0}
end

-- Corners from 0. The normal of a corner is the sum of those of its triangles, as long as their areas.
local function add_face(i, j, k)
  faces[#faces + 1] = {i, j, k}
  local a, b, c = points[i + 1], points[j + 1], points[k + 1]
  local ux, uy, uz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
  local vx, vy, vz = c[1] - a[1], c[2] - a[2], c[3] - a[3]
  local x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
  for _, at in ipairs {i, j, k} do
    local n = normals[at + 1]
    n[1], n[2], n[3] = n[1] + x, n[2] + y, n[3] + z
  end
end

local rings = around // 2
for ring = 1, rings do
  local v = pi * ring / (rings + 1)
  for i = 0, around - 1 do
    local u = 2 * pi * i / around
    add_point(sin(v) * cos(u), sin(v) * sin(u), cos(v))
  end
end
add_point(0, 0, 1)
add_point(0, 0, -1)
for i = 0, around - 1 do
  local next = (i + 1) % around
  for ring = 0, rings - 2 do
    local a, b = ring * around, (ring + 1) * around
    add_face(a + i, b + i, b + next)
    add_face(a + i, b + next, a + next)
  end
  local last = (rings - 1) * around
  add_face(rings * around, i, next)
  add_face(rings * around + 1, last + next, last + i)
end
mesh { positions = points, normals = normals, indices = faces, material = clay }
