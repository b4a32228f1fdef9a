-- One of every shape, for bench-shapes
--
-- Each is about as large as a ball of radius 1. To see what is measured:
--     snell bench/shapes.lua -D shape=lathe
-- A shape that is not listed here is measured with its defaults; one that has none needs a line here.

local name = param("shape", "sphere", "which one")

-- A grid of points closed both ways: a tube of radius 0.35 around a ring.
local function ring_mesh(columns, rows)
  local positions, indices = {}, {}
  for i = 0, columns - 1 do
    for j = 0, rows - 1 do
      local a, b = 2 * math.pi * i / columns, 2 * math.pi * j / rows
      local r = 0.65 + 0.35 * math.cos(b)
      positions[#positions + 1] = {r * math.cos(a), 0.35 * math.sin(b), r * math.sin(a)}
      local here, next = i * rows, (i + 1) % columns * rows
      local k = (j + 1) % rows
      for _, index in ipairs {here + j, here + k, next + j, next + j, here + k, next + k} do
        indices[#indices + 1] = index
      end
    end
  end
  return mesh { positions = positions, indices = indices }
end

-- Tufts that stand on the lower half of a ball.
local function hair(count)
  local points, starts = {}, {}
  for i = 0, count - 1 do
    local z, turn = 1 - (i + 0.5) / count, 2.39996 * i
    local flat = math.sqrt(1 - z * z)
    starts[#starts + 1] = #points
    for k = 0, 4 do
      local r = 0.6 + 0.1 * k
      points[#points + 1] = {r * flat * math.cos(turn + 0.1 * k), r * z - 0.02 * k * k, r * flat * math.sin(turn + 0.1 * k)}
    end
  end
  return curves { points = points, starts = starts, radius = 0.006 }
end

-- n by n patches of a wavy sheet.
local function sheet(n)
  local points, indices, side = {}, {}, 3 * n + 1
  for j = 0, side - 1 do
    for i = 0, side - 1 do
      local x, z = 2 * i / (side - 1) - 1, 2 * j / (side - 1) - 1
      points[#points + 1] = {x, 0.3 * math.sin(7 * x) * math.cos(5 * z), z}
    end
  end
  for q = 0, n - 1 do
    for p = 0, n - 1 do
      for j = 0, 3 do
        for i = 0, 3 do indices[#indices + 1] = (3 * q + j) * side + 3 * p + i end
      end
    end
  end
  return patch { points = points, indices = indices }
end

local examples = {
  sphere = function() return sphere { radius = 1 } end,
  plane = function() return plane { normal = {0.1, 1, 0.2} } end,
  box = function() return box { min = {-1, -0.6, -0.8}, max = {1, 0.6, 0.8} } end,
  disk = function() return disk { radius = 1, inner_radius = 0.3, normal = {0.3, 1, 0.2} } end,
  quad = function() return quad { corner = {-0.8, -0.5, -0.4}, u = {1.6, 0.2, 0}, v = {0, 1, 0.8} } end,
  mesh = function() return ring_mesh(200, 50) end,
  cylinder = function() return cylinder { from = {-0.5, -0.7, 0}, to = {0.5, 0.7, 0.2}, radius = 0.5 } end,
  cone = function() return cone { from = {-0.4, -0.7, 0}, to = {0.5, 0.8, 0.2}, radius = 0.6, radius_to = 0.15 } end,
  torus = function() return torus { major = 0.7, minor = 0.3, axis = {0.3, 1, 0.2} } end,
  lathe = function()
    return lathe { profile = {{0, -0.9}, {0.45, -0.9}, {0.42, -0.85}, {0.1, -0.75}, {0.07, -0.6}, {0.07, -0.3},
      {0.12, -0.15}, {0.35, 0.05}, {0.5, 0.35}, {0.52, 0.6}, {0.45, 0.95}, {0.42, 0.95}, {0.48, 0.6}, {0.46, 0.36},
      {0.32, 0.1}, {0, -0.05}} }
  end,
  capsule = function() return capsule { from = {-0.4, -0.4, 0}, to = {0.4, 0.5, 0.2}, radius = 0.4 } end,
  ellipsoid = function() return ellipsoid { radii = {1, 0.5, 0.7} } end,
  quadric = function() -- a hyperboloid of one sheet
    return quadric { square = {4, -1, 4}, constant = -0.5, min = {-0.8, -1, -0.8}, max = {0.8, 1, 0.8} }
  end,
  superellipsoid = function() return superellipsoid { radii = {1, 0.7, 0.8}, e1 = 0.4, e2 = 0.7 } end,
  curves = function() return hair(2000) end,
  heightfield = function()
    return heightfield { columns = 256, rows = 256, min = {-1, -0.3, -1}, max = {1, 0.3, 1},
      heights = function(x, z) return 0.5 + 0.3 * math.sin(5 * x) * math.cos(4 * z) + 0.1 * math.sin(31 * x + 17 * z) end }
  end,
  patch = function() return sheet(4) end,
  solid = function() -- a die with a hole
    return difference { intersection { box { min = {-0.8, -0.8, -0.8}, max = {0.8, 0.8, 0.8} }, sphere { radius = 1.1 } },
      cylinder { from = {0, -2, 0}, to = {0, 2, 0}, radius = 0.4 } }
  end,
  implicit = function() -- a gyroid in a ball
    return implicit { f = "max(abs(sin(6*x)*cos(6*y) + sin(6*y)*cos(6*z) + sin(6*z)*cos(6*x)) - 0.4, x*x + y*y + z*z - 1)",
      min = {-1, -1, -1}, max = {1, 1, 1} }
  end,
  blob = function()
    local points = {}
    for i = 0, 11 do points[#points + 1] = {0.6 * math.cos(2.4 * i), -0.6 + 0.11 * i, 0.6 * math.sin(2.4 * i)} end
    return blob { points = points, radius = 0.6, threshold = 0.4 }
  end,
  julia = function() return julia { c = {-0.2, 0.6, 0.2}, c_k = 0.2, iterations = 9 } end,
}

if examples[name] then examples[name]() end
