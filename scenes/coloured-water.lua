-- A glass of raspberry water with a straw: nested dielectrics, and Beer's law
--
-- Three things are in each other here: air, glass, water. Where the water touches the glass there is
-- no air between, and the light is bent by the ratio of 1.333 to 1.5. So the water is modelled
-- a tenth of a millimetre into the glass, and the glass has the higher priority: where both are,
-- glass is. The straw seems broken where it enters the water (Snell's law), and is wider below it:
-- a round glass of water is a lens. Colour comes from the way through the water alone (Beer's law):
-- exp(-a d), with a per metre. It is paler where the way is short, at the foot and the edges.
-- Try:  snell coloured-water.lua -D strength=3        more syrup
--       snell coloured-water.lua -D gap=true          an air gap instead: a mirror between water and glass

local strength = param("strength", 1, "how much syrup")
local gap = param("gap", false, "leave 0.1 mm of air between water and glass, which is wrong")

render { integrator = "path", width = 420, height = 480, samples = 100, max_depth = 24, exposure = 0.4 }
camera { from = {0, 0.16, 0.5}, at = {0, 0.07, 0}, fov = 23 }

-- Large lights: a ray that leaves the glass has to find them by itself.
light.environment { radiance = texture.gradient { map = "spherical", color_a = {0.3, 0.29, 0.27},
                        color_b = {0.5, 0.53, 0.58}, from = {0, 0.4, 0}, to = {0, 0.9, 0} } }
light.quad { center = {-0.55, 0.55, 0.05}, at = {0, 0.05, 0}, width = 0.6, height = 0.6, radiance = {4.2, 3.9, 3.4},
             name = "window" }

-- A table that runs up into a wall behind: one sheet, so that no line is behind the glass. It begins
-- 0.1 mm below the glass: where two faces are in one plane, nothing says which comes first.
local sheet, bend, low = { {-1, -0.0001, 0.8}, {1, -0.0001, 0.8} }, 0.25, -0.0001
for i = 0, 24 do
    local a = math.rad(90 * i / 24)
    local y, z = low + bend * (1 - math.cos(a)), -0.22 - bend * math.sin(a)
    sheet[#sheet + 1], sheet[#sheet + 2] = {-1, y, z}, {1, y, z}
end
sheet[#sheet + 1], sheet[#sheet + 2] = {-1, 1.5, -0.22 - bend}, {1, 1.5, -0.22 - bend}
local triangles = {}
for i = 0, #sheet / 2 - 2 do
    for _, k in ipairs { 0, 1, 3, 0, 3, 2 } do triangles[#triangles + 1] = 2 * i + k end
end
mesh { positions = sheet, indices = triangles, material = material.lambert { color = {0.72, 0.7, 0.66} },
       name = "table" }

-- ---- the glass: one closed line around wall and floor, turned about Y ----
local height, wall, floor = 0.125, 0.0022, 0.009
local function inner(y) return 0.0275 + 0.075 * y end         -- radius of the inside at a height
local line = { {0, 0}, {0.028, 0}, {0.0292, 0.0006}, {inner(0.002) + wall, 0.002} }
line[#line + 1] = { inner(height) + wall, height }
for i = 1, 7 do                                               -- the rim is round
    local a = math.rad(180 * i / 8)
    line[#line + 1] = { inner(height) + wall / 2 + wall / 2 * math.cos(a), height + wall / 2 * math.sin(a) }
end
line[#line + 1] = { inner(height), height }
line[#line + 1] = { inner(floor + 0.004), floor + 0.004 }
for i = 1, 6 do                                               -- and so is the edge of the bottom
    local a = math.rad(90 * i / 6)
    line[#line + 1] = { inner(floor + 0.004) - 0.004 * (1 - math.cos(a)), floor + 0.004 - 0.004 * math.sin(a) }
end
line[#line + 1] = { 0, floor }
lathe { profile = line, material = material.dielectric { ior = 1.5, priority = 1, absorption = {4, 1.2, 2.2} },
        name = "glass" }

-- ---- the water: the same inside, 0.1 mm larger; or smaller, for the wrong picture ----
local more, level = gap and -0.0001 or 0.0001, 0.086
local water = { {0, floor - more}, {inner(floor) - 0.004 + more, floor - more} }
for i = 5, 0, -1 do
    local a = math.rad(90 * i / 6)
    local r = 0.004 + more
    water[#water + 1] = { inner(floor + 0.004) - 0.004 + r * math.cos(a), floor + 0.004 - r * math.sin(a) }
end
water[#water + 1] = { inner(level) + more, level }
water[#water + 1] = { 0, level }
lathe { profile = water, name = "water", material = material.dielectric {
    ior = 1.333, absorption = {0.8 * strength, 24 * strength, 15 * strength} } }

-- ---- the straw: a tube, open at both ends, with stripes; it leans on the rim ----
local foot, top = {-0.021, floor + 0.004, 0.004}, {0.0564, height + 0.05, -0.006}
for i = 0, 15 do
    local function at(s)
        return { foot[1] + (top[1] - foot[1]) * s, foot[2] + (top[2] - foot[2]) * s, foot[3] + (top[3] - foot[3]) * s }
    end
    cylinder { from = at(i / 16), to = at((i + 1) / 16), radius = 0.0032, capped = false,
               material = material.lambert { color = i % 2 == 0 and {0.8, 0.8, 0.78} or {0.05, 0.25, 0.6} } }
end
