-- Leaves: rectangles whose outline is in the alpha of a texture, as foliage of games and scans has it
--
-- The same rays and boxes whether the outline is cut or not, so that a pair of runs says what cutting costs:
--     snell bench bench/foliage.lua --json                    cut by alpha
--     snell bench bench/foliage.lua --json -D cut=false       whole rectangles
-- With -D trees=1 there is one mesh alone in its world.

local cut = param("cut", true, "leaves have the outline of the texture; false: whole rectangles")
local trees = param("trees", 25, "crowns, copies of one mesh")
local leaves = param("leaves", 20000, "of a crown")
local soft = param("soft", false, "edges let light through in part, else alpha is cut off at a half")

render { integrator = "path", width = 640, height = 480, samples = 4 }
background { color = {0.5, 0.65, 0.9} }
light.directional { direction = {-0.5, -1, -0.3}, irradiance = {3, 2.9, 2.6}, angle = 0.53 }

local state = 12345
local function random()                    -- a plain linear generator: the same everywhere
    state = (state * 1103515245 + 12345) & 0x7fffffff
    return state / 0x7fffffff
end

-- A leaf with a wavy edge: 40 % of its rectangle.
local outline = texture.image { file = "leaf.png", encoding = "linear", channel = "r",
                                wrap_u = "clamp", wrap_v = "clamp" }

local green = { color = {0.16, 0.34, 0.08} }
if cut then green.alpha = outline end
if cut and not soft then green.alpha_cutoff = 0.5 end

-- ---- one crown: a shell around a point two metres up ----
local positions, uvs, indices = {}, {}, {}
for i = 1, leaves do
    local y, turn = 2 * random() - 1, 2 * math.pi * random()
    local r, far = math.sqrt(1 - y * y), 0.45 + 0.55 * math.sqrt(random())
    local at = {far * r * math.cos(turn), 2 + far * y, far * r * math.sin(turn)}
    local a, b = 2 * math.pi * random(), math.acos(2 * random() - 1)
    local along = {math.sin(b) * math.cos(a), math.cos(b), math.sin(b) * math.sin(a)}
    local across = {-math.sin(a), 0, math.cos(a)}
    for k = 0, 3 do
        local u, v = k % 2, k // 2
        local p = {}
        for j = 1, 3 do p[j] = at[j] + 0.1 * v * along[j] + 0.06 * (u - 0.5) * across[j] end
        positions[#positions + 1], uvs[#uvs + 1] = p, {u, v}
    end
    for _, k in ipairs {0, 1, 2, 2, 1, 3} do indices[#indices + 1] = 4 * (i - 1) + k end
end
local crown = mesh { positions = positions, uvs = uvs, indices = indices, material = material.lambert(green) }

local side = math.ceil(math.sqrt(trees))
for i = 0, trees - 1 do
    instance { crown, transform = transform.translate {2.2 * (i % side - (side - 1) / 2), 0, -2.2 * (i // side)}
                      * transform.rotate { axis = {0, 1, 0}, angle = 77 * i } }
end
if trees > 1 then
    quad { corner = {-40, 0, 40}, u = {80, 0, 0}, v = {0, 0, -80}, material = material.lambert { color = {0.3, 0.25, 0.2} } }
end
camera { from = {0, 2.6, 5.5}, at = {0, 1.9, 0}, fov = 40 }
