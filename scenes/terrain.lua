-- A million posts: mountains at evening, one height for every metre
--
-- A heightfield keeps the heights alone and is traced as it is: two triangles between four posts, made
-- when a ray comes near. The sun stands low, so that each ridge draws its shadow on the next; what
-- the sun does not reach is lit by the sky.
-- The mountains are made as Fournier, Fussell and Carpenter made them in 1982: every new post is the mean of
-- its neighbours and a little chance, less with each halving.
-- Try:  snell terrain.lua -D levels=11         four million posts
--       snell terrain.lua -D seed=2            other mountains

local levels = param("levels", 10, "halvings: 2^levels + 1 posts along a side")
local seed = param("seed", 3, "which mountains")
local rough = param("rough", 0.5, "how much of its chance each halving keeps")

render { integrator = "cook", width = 640, height = 480, samples = 36 }

local state = seed
local function chance()                    -- -1 .. 1
    state = (state * 6364136223846793005 + 1442695040888963407) & 0x7fffffffffffffff
    return (state >> 31) / 0x80000000 - 1
end

-- Post (i, j) is h[j * n + i + 1]. First the middles of squares, then those of their sides.
local side = 1 << levels
local n, h, spread = side + 1, {}, 0.5
for i = 1, n * n do h[i] = 0 end
h[1], h[n], h[n * n - n + 1], h[n * n] = 0.45, 0.35, 0.3, 0.4
local step = side
while step > 1 do
    local half = step // 2
    for j = half, side, step do
        local row, above, below = j * n + 1, (j - half) * n + 1, (j + half) * n + 1
        for i = half, side, step do
            h[row + i] = (h[above + i - half] + h[above + i + half] + h[below + i - half] + h[below + i + half]) / 4
                       + spread * chance()
        end
    end
    for j = 0, side, half do
        local row, away = j * n + 1, half * n
        for i = (j // half) % 2 == 0 and half or 0, side, step do
            local sum, count, at = 0, 0, row + i
            if i > 0 then sum, count = sum + h[at - half], count + 1 end
            if i < side then sum, count = sum + h[at + half], count + 1 end
            if j > 0 then sum, count = sum + h[at - away], count + 1 end
            if j < side then sum, count = sum + h[at + away], count + 1 end
            h[at] = sum / count + spread * chance()
        end
    end
    step, spread = half, spread * rough
end
-- Valleys are flat and peaks are steep.
local low, high = math.huge, -math.huge
for i = 1, n * n do
    if h[i] < low then low = h[i] end
    if h[i] > high then high = h[i] end
end
for i = 1, n * n do
    local t = (h[i] - low) / (high - low)
    h[i] = t * t * (0.4 + 0.6 * t)
end

heightfield {
    columns = n, rows = n, heights = h, min = {-500, 0, -500}, max = {500, 230, 500},
    name = "mountains", material = material.lambert { color = {0.36, 0.31, 0.27} },
}

camera { from = {0, 150, 560}, at = {0, 45, 0}, fov = 50 }
background { color = {1.0, 0.72, 0.5}, top = {0.18, 0.3, 0.62} }
light.environment { radiance = {0.3, 0.42, 0.66}, visible = false, name = "sky" }
light.directional { direction = {0.9, -0.42, -0.35}, irradiance = {3.4, 2.3, 1.3}, angle = 0.53 }
