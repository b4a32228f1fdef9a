-- The teapot of 1975, from its 32 Bezier patches: no triangle in it
--
-- Martin Newell drew it at the University of Utah with a pencil and gave the world its curves. Body,
-- rim, lid and bottom are quarter turns of a profile, which cubics follow to 3 in 10,000 of the radius;
-- handle and spout are halves, mirrored. Every ray is tested with the patches themselves: the
-- outline stays smooth however near the camera comes.
-- Try:  snell teapot.lua -D azimuth=200        the handle's side
--       snell teapot.lua -D fov=3              the spout at twelve times the size: still no corner

local azimuth = param("azimuth", 32, "degrees around the pot")
local fov = param("fov", 34, "degrees; the smaller, the nearer")

render { integrator = "cook", width = 640, height = 480, samples = 36 }

local a = math.rad(azimuth)
camera { from = {9.4 * math.sin(a), 5.2, 9.4 * math.cos(a)}, at = fov < 20 and {3, 2.2, 0} or {0.15, 1.2, 0}, fov = fov }

-- ---- the data, z up as Newell drew it: cubic profiles as {radius, height} ----
local bottom = { {0, 0}, {1.425, 0}, {1.5, 0.075}, {1.5, 0.15} }
local lower = { {1.5, 0.15}, {1.5, 0.225}, {2, 0.45}, {2, 0.9} }
local upper = { {2, 0.9}, {2, 1.35}, {1.75, 1.875}, {1.5, 2.4} }
local rim = { {1.5, 2.4}, {1.4375, 2.53125}, {1.3375, 2.53125}, {1.4, 2.4} }
local cover = { {1.3, 2.25}, {1.3, 2.4}, {0.4, 2.4}, {0.2, 2.55} }
local knob = { {0.2, 2.55}, {0, 2.7}, {0.8, 3.15}, {0, 3.15} }
-- Halves: four rows of {x, depth, z}, the first and last point of a row in the plane of symmetry.
local handle = {
    { {-1.6, 0, 2.025}, {-1.6, 0.3, 2.025}, {-1.5, 0.3, 2.25}, {-1.5, 0, 2.25} },
    { {-2.3, 0, 2.025}, {-2.3, 0.3, 2.025}, {-2.5, 0.3, 2.25}, {-2.5, 0, 2.25} },
    { {-2.7, 0, 2.025}, {-2.7, 0.3, 2.025}, {-3, 0.3, 2.25}, {-3, 0, 2.25} },
    { {-2.7, 0, 1.8}, {-2.7, 0.3, 1.8}, {-3, 0.3, 1.8}, {-3, 0, 1.8} },
    { {-2.7, 0, 1.575}, {-2.7, 0.3, 1.575}, {-3, 0.3, 1.35}, {-3, 0, 1.35} },
    { {-2.5, 0, 1.125}, {-2.5, 0.3, 1.125}, {-2.65, 0.3, 0.9375}, {-2.65, 0, 0.9375} },
    { {-2, 0, 0.9}, {-2, 0.3, 0.9}, {-1.9, 0.3, 0.6}, {-1.9, 0, 0.6} },
}
local spout = {
    { {1.7, 0, 1.425}, {1.7, 0.66, 1.425}, {1.7, 0.66, 0.6}, {1.7, 0, 0.6} },
    { {2.6, 0, 1.425}, {2.6, 0.66, 1.425}, {3.1, 0.66, 0.825}, {3.1, 0, 0.825} },
    { {2.3, 0, 2.1}, {2.3, 0.25, 2.1}, {2.4, 0.25, 2.025}, {2.4, 0, 2.025} },
    { {2.7, 0, 2.4}, {2.7, 0.25, 2.4}, {3.3, 0.25, 2.4}, {3.3, 0, 2.4} },
    { {2.8, 0, 2.475}, {2.8, 0.25, 2.475}, {3.525, 0.25, 2.49375}, {3.525, 0, 2.49375} },
    { {2.9, 0, 2.475}, {2.9, 0.15, 2.475}, {3.45, 0.15, 2.5125}, {3.45, 0, 2.5125} },
    { {2.8, 0, 2.4}, {2.8, 0.15, 2.4}, {3.2, 0.15, 2.4}, {3.2, 0, 2.4} },
}

-- ---- 16 controls per patch ----
local function turn(points, profile)
    local arm = 0.56                       -- of a quarter circle by one cubic; Newell's own value
    for quarter = 0, 3 do
        local c, s = ({1, 0, -1, 0})[quarter + 1], ({0, 1, 0, -1})[quarter + 1]
        for _, p in ipairs(profile) do
            local r, h = p[1], p[2]
            for _, q in ipairs { {r, 0}, {r, arm * r}, {arm * r, r}, {0, r} } do
                points[#points + 1] = { c * q[1] - s * q[2], h, -(s * q[1] + c * q[2]) }
            end
        end
    end
end

local function mirror(points, rows)
    for first = 1, 4, 3 do
        for side = -1, 1, 2 do
            for i = first, first + 3 do
                for _, p in ipairs(rows[i]) do points[#points + 1] = { p[1], p[3], side * p[2] } end
            end
        end
    end
end

local pot = {}
for _, profile in ipairs { bottom, lower, upper, rim, cover, knob } do turn(pot, profile) end
mirror(pot, handle)
mirror(pot, spout)

-- ---- glazed earthenware on a table, in the light of a window ----
local glaze = material.glazed { base = material.lambert { color = {0.5, 0.09, 0.05} }, ior = 1.5 }
patch { points = pot, material = glaze, name = "teapot" }

plane { material = material.lambert { color = texture.noise { kind = "marble", size = 1.1, octaves = 5, color_a = {0.52, 0.5, 0.47}, color_b = {0.3, 0.29, 0.29} } },
        name = "table" }
background { color = {0.55, 0.52, 0.5}, top = {0.3, 0.36, 0.46} }
light.environment { radiance = {0.3, 0.33, 0.38}, visible = false, name = "room" }
light.quad { center = {-6, 7, 4}, at = {0, 1, 0}, width = 4, height = 5, radiance = 13, name = "window" }
