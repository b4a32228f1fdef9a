-- Four cords that sound: the first four overtones, blurred where they swing, sharp at their nodes
--
-- Each cord is a mesh that deforms: its vertices are given at several moments, its keys, and go
-- straight from one to the next while the shutter is open. The nth swings in n parts, n times as
-- fast. Every part stays longest where it turns round, so its blur has an edge; a node does not move
-- and is as sharp as the pegs. Shadows are of the same times: each ray meets the cord where it is at
-- its own.
-- Try:  snell overtones.lua -D open=0        a frozen moment

local open = param("open", 1, "how long the shutter is open, in swings of the lowest cord")

render { integrator = "cook", width = 640, height = 480, samples = 81, max_depth = 4 }
camera { from = {0.12, 0.14, 1.5}, at = {0.004, -0.004, 0}, fov = 25.5, shutter = {0, open} }

background { color = 0.02, top = 0.05 }
ambient { color = 0.035 }
light.quad { corner = {-0.75, 0.55, 0.75}, u = {0.34, 0, 0.1}, v = {0, -0.3, 0.1}, radiance = 30 }
light.quad { corner = {0.9, 0.8, 0.2}, u = {0, 0, 0.5}, v = {-0.4, 0.2, 0}, radiance = {4, 4.5, 5.5} }

-- ---- the board ----
local board = material.lambert { color = {0.19, 0.165, 0.15} }
local peg = material.phong { color = {0.6, 0.4, 0.12}, specular = 0.4, exponent = 30 }
box { min = {-0.46, -0.3, -0.07}, max = {0.46, 0.29, -0.05}, material = board, name = "board" }
plane { point = {0, 0, -0.07}, normal = {0, 0, 1}, material = material.lambert { color = {0.35, 0.37, 0.4} } }

-- ---- the cords ----
local half, radius = 0.38, 0.0075              -- metres
local pieces, sides = 96, 10
local swing = 1 / 24                           -- seconds, of the lowest

-- A tube along x, bent to the nth standing wave at `phase`, 0 to 1 of a swing.
local function tube(n, height, phase)
    local points, normals = {}, {}
    for i = 0, pieces do
        local along = i / pieces
        local reach = height * math.cos(2 * math.pi * phase)
        local y = reach * math.sin(n * math.pi * along)
        local slope = reach * n * math.pi / (2 * half) * math.cos(n * math.pi * along)
        local long = math.sqrt(1 + slope * slope)
        for k = 0, sides - 1 do
            local c, s = math.cos(2 * math.pi * k / sides), math.sin(2 * math.pi * k / sides)
            local normal = { -slope / long * c, c / long, s }
            normals[#normals + 1] = normal
            points[#points + 1] = { half * (2 * along - 1) + radius * normal[1],
                                    y + radius * normal[2], radius * normal[3] }
        end
    end
    return points, normals
end

local faces = {}
for i = 0, pieces - 1 do
    for k = 0, sides - 1 do
        local a, b = i * sides + k, i * sides + (k + 1) % sides
        faces[#faces + 1] = { a, b, a + sides }
        faces[#faces + 1] = { b, b + sides, a + sides }
    end
end

local colors = { "#c8361f", "#e09a1c", "#2f8f4e", "#2a62b8" }
for n = 1, 4 do
    local keys, steps = {}, 16 * n             -- sixteen straight pieces a swing
    for k = 0, steps do
        local points, normals = tube(n, 0.045 / n ^ 0.4, n * k / steps)
        keys[#keys + 1] = { time = swing * k / steps, positions = points, normals = normals }
    end
    local place = transform.translate { 0, 0.2 - 0.135 * (n - 1), 0 }
    local rubber = material.phong { color = colors[n], specular = 0.25, exponent = 40 }
    group { mesh { keys = keys, indices = faces, material = rubber },
            cylinder { from = {-half, 0, -0.05}, to = {-half, 0, 0.014}, radius = 0.014, material = peg },
            cylinder { from = {half, 0, -0.05}, to = {half, 0, 0.014}, radius = 0.014, material = peg },
            transform = place, name = "cord " .. n }
end
