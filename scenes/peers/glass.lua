-- Glass as the other ray tracers see it: five balls and a lumpy body on a chessboard
--
-- Smooth glass to depth 10, one lamp whose light passes through glass as if straight on: what POV-Ray
-- has as well. bench/renders exports it and times them. bunny = "bunny.obj" puts another mesh, with
-- +Y up, in the body's place, as high; it should be closed.
-- Z is up. Try:  snell scenes/peers/glass.lua --samples 16

local bunny = param("bunny", "", "a file with a mesh instead of the lumpy body")

render { integrator = "whitted", width = 1024, height = 1024, samples = 1, max_depth = 10 }
camera { from = {4.6, 3, 2.4}, at = {0, 0, 0.7}, up = {0, 0, 1}, fov = 40 }
background { color = {0.078, 0.361, 0.753} }
light.point { position = {4, -3, 6}, intensity = 167 }

local board = texture.checker { {0.68, 0.68, 0.68}, {0.12, 0.12, 0.12}, size = 0.5, map = "object" }
plane { point = {0, 0, 0}, normal = {0, 0, 1}, material = material.lambert { color = board } }

local glass = material.dielectric { ior = 1.5 }
for _, ball in ipairs {
  {0, 0, 0.8, 0.8}, {1.5, 0.2, 0.45, 0.45}, {-0.3, 1.5, 0.5, 0.5}, {1.1, 1.3, 0.3, 0.3}, {0.4, -1.5, 0.55, 0.55},
} do
  sphere { center = {ball[1], ball[2], ball[3]}, radius = ball[4], material = glass }
end

-- About 3,700 triangles, as the usual small bunny has.
local function lumpy()
  local around, rings = 60, 31
  local points, faces = {}, {}
  for ring = 0, rings do -- each pole is one corner, at the end of the list
    local v = math.pi * ring / rings
    for i = 0, around - 1 do
      local u = 2 * math.pi * i / around
      local x, y, z = math.sin(v) * math.cos(u), math.cos(v), math.sin(v) * math.sin(u)
      local r = 1 + 0.12 * math.sin(5 * x + 1) * math.sin(4 * y) * math.sin(5 * z)
      if ring > 0 and ring < rings then points[#points + 1] = {x * r, y * r, z * r} end
    end
  end
  points[#points + 1] = {0, 1, 0}
  points[#points + 1] = {0, -1, 0}
  local north, last = #points - 2, (rings - 2) * around
  for i = 0, around - 1 do
    local next = (i + 1) % around
    faces[#faces + 1] = {north, next, i}
    faces[#faces + 1] = {north + 1, last + i, last + next}
    for row = 0, last - around, around do
      faces[#faces + 1] = {row + i, row + next, row + around + next}
      faces[#faces + 1] = {row + i, row + around + next, row + around + i}
    end
  end
  return points, faces
end

-- Corners' normals: the sum of those of their triangles, as long as these are large.
local function smooth(points, faces)
  local normals = {}
  for i = 1, #points do normals[i] = {0, 0, 0} end
  for _, face in ipairs(faces) do
    local a, b, c = points[face[1] + 1], points[face[2] + 1], points[face[3] + 1]
    local ux, uy, uz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
    local vx, vy, vz = c[1] - a[1], c[2] - a[2], c[3] - a[3]
    for _, at in ipairs(face) do
      local n = normals[at + 1]
      n[1], n[2], n[3] = n[1] + uy * vz - uz * vy, n[2] + uz * vx - ux * vz, n[3] + ux * vy - uy * vx
    end
  end
  return normals
end

local body
if bunny ~= "" then
  body = mesh { file = bunny, material = glass }
else
  local points, faces = lumpy()
  body = mesh { positions = points, indices = faces, normals = smooth(points, faces), material = glass }
end
local size = 0.96 / body.bounds.size[2]
instance { body, transform = transform.translate {1.35, -0.85, 0.0012 - body.bounds.min[2] * size}
                           * transform.rotate { axis = {1, 0, 0}, angle = 90 } * transform.scale(size) }
