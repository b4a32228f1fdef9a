-- A die, a lens, a bowl and a drilled mesh: solids put together
--
-- Closed shapes are points inside and points outside, and so they can be united, cut out of one another
-- and kept where they overlap (Roth, "Ray Casting for Modeling Solids", 1982): a ray is cut into
-- stretches by each shape, and the stretches are put together. The die is a box and a ball in common,
-- less its pips; the lens two balls in common; the bowl a ball less a smaller one, cut off by a plane;
-- the icosahedron is a mesh with holes drilled through its corners.
-- Try:  snell solids.lua -D hole=0.2           a finer drill
--       snell solids.lua -i path --samples 64  the light that the lens gathers

local hole = param("hole", 0.42, "radius of the drill")

render { integrator = "whitted", width = 640, height = 400, samples = 9, max_depth = 12 }
camera { from = {0.6, 2.6, 6.2}, at = {0.1, 0.62, 0}, fov = 34 }
background { color = {0.35, 0.45, 0.6} }
ambient { color = 0.12 }
light.point { position = {-4, 7, 5}, intensity = 260 }
light.point { position = {6, 5, 3}, intensity = 70 }

local ivory = material.phong { color = {0.85, 0.8, 0.68}, specular = 0.25, exponent = 80 }
local ink = material.lambert { color = {0.04, 0.05, 0.12} }
local red = material.phong { color = {0.62, 0.07, 0.05}, specular = 0.3, exponent = 60 }
local brass = material.partial_mirror { color = {0.85, 0.62, 0.25}, specularity = 0.35 }
local clear = material.dielectric { ior = 1.5 }
local green = material.dielectric { ior = 1.45, absorption = {1.6, 0.25, 0.9} }
plane { material = material.lambert { color = texture.checker { {0.62, 0.6, 0.56}, {0.3, 0.33, 0.38}, size = 0.4 } } }

-- The die: each face has its number; opposite ones make seven.
local pips = {
  { {0, 0} }, { {-1, -1}, {1, 1} }, { {-1, -1}, {0, 0}, {1, 1} }, { {-1, -1}, {-1, 1}, {1, -1}, {1, 1} },
  { {-1, -1}, {-1, 1}, {0, 0}, {1, -1}, {1, 1} }, { {-1, -1}, {-1, 0}, {-1, 1}, {1, -1}, {1, 0}, {1, 1} },
}
local function die(size, place)
  local half, parts = size / 2, {}
  parts[1] = intersection {
    box { min = {-half, -half, -half}, max = {half, half, half} },
    sphere { radius = 0.71 * size },
    material = ivory,
  }
  local faces = { [1] = {2, 1}, [6] = {2, -1}, [2] = {3, 1}, [5] = {3, -1}, [3] = {1, 1}, [4] = {1, -1} }
  for number = 1, 6 do
    local axis, side = faces[number][1], faces[number][2]
    for _, at in ipairs(pips[number]) do
      local p = {0, 0, 0}
      p[axis] = side * 1.07 * half
      p[axis % 3 + 1] = 0.27 * size * at[1]
      p[(axis + 1) % 3 + 1] = 0.27 * size * at[2]
      parts[#parts + 1] = sphere { center = p, radius = 0.115 * size, material = ink }
    end
  end
  parts.transform = place
  return difference(parts)
end
die(1, transform.translate {-1.75, 0.5, 0.1} * transform.rotate { axis = {0, 1, 0}, angle = 33 }
       * transform.rotate { axis = {0, 0, 1}, angle = 90 })
die(0.6, transform.translate {-0.75, 0.3, 1.35} * transform.rotate { axis = {0, 1, 0}, angle = -22 }
         * transform.rotate { axis = {1, 0, 0}, angle = 90 })

-- The lens stands on its edge, in a brass ring.
local tilt = transform.translate {0.35, 0.78, 0.5} * transform.rotate { axis = {0, 1, 0}, angle = -12 }
intersection {
  sphere { center = {0, 0, -1.5}, radius = 1.68 },
  sphere { center = {0, 0, 1.5}, radius = 1.68 },
  material = clear, transform = tilt,
}
difference {
  cylinder { from = {0, 0, -0.1}, to = {0, 0, 0.1}, radius = 0.78 },
  cylinder { from = {0, 0, -1}, to = {0, 0, 1}, radius = 0.7 },
  material = brass, transform = tilt,
}

-- The bowl.
difference {
  sphere { radius = 0.62 },
  sphere { radius = 0.54 },
  plane { point = {0, 0.2, 0}, normal = {0, -1, 0} },
  material = green, transform = transform.translate {1.75, 0.63, 1.0},
}

-- The icosahedron: every face has its own vertices, as in an STL file; a solid does not mind.
local t = (1 + 5 ^ 0.5) / 2
local corners = {
  {-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0}, {0, -1, t}, {0, 1, t},
  {0, -1, -t}, {0, 1, -t}, {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1},
}
local faces = {
  0,11,5, 0,5,1, 0,1,7, 0,7,10, 0,10,11, 1,5,9, 5,11,4, 11,10,2, 10,7,6, 7,1,8,
  3,9,4, 3,4,2, 3,2,6, 3,6,8, 3,8,9, 4,9,5, 2,4,11, 6,2,10, 8,6,7, 9,8,1,
}
local positions, indices = {}, {}
for i, corner in ipairs(faces) do
  positions[i] = corners[corner + 1]
  indices[i] = i - 1
end
local drill = { mesh { positions = positions, indices = indices } }
for _, c in ipairs(corners) do
  drill[#drill + 1] = cylinder { from = {0, 0, 0}, to = {1.2 * c[1], 1.2 * c[2], 1.2 * c[3]}, radius = hole, material = brass }
end
drill.material = red
drill.transform = transform.translate {1.55, 0.83, -1.1} * transform.rotate { axis = {0, 1, 0}, angle = 48 } * transform.scale(0.55)
difference(drill)
