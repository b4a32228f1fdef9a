-- The bsdf_spheres scenes of Mitsuba 3's render tests, after their XML: ten balls and two leaves
-- under one of three lights. The meshes and the texture are theirs and stay where they are.
--
-- Mitsuba's max_depth = 2 ends a path at the first light after one bounce. Here a ray of depth 1
-- still gathers light where it hits, so all objects but one are black: what is left of that ball is
-- exactly the picture of depth 2.

local models = param("models", "../../models/mitsuba-scenes", "the folder of Mitsuba's scenes")
local kind = param("light", "constant", "constant, area or point")
local lit = param("lit", "diffuse", "the ball that has its material")

render { integrator = "path", width = 48, height = 48, samples = 868, max_depth = 1 }

-- A 50 mm lens on a film whose diagonal is that of 36 x 24 mm, here a square.
local diagonal = math.sqrt(36 * 36 + 24 * 24) / 50
camera { from = {-24, 0, 0}, at = {0, 0, 0}, up = {0, 0, 1},
         fov = math.deg(2 * math.atan(diagonal / math.sqrt(2) / 2)) }

if kind == "constant" then
    light.environment { radiance = 1 }
elseif kind == "point" then
    light.point { position = {-4, 0, 6}, intensity = 300 }
else
    -- A square of 4 m, turned by 120 degrees about y. Its radiance is a spectrum (400 nm: 0, 500: 8,
    -- 600: 15.6, 700: 18.4), here times the CIE 1931 curves and in Rec. 709.
    local u = {4 * math.cos(math.rad(120)), 0, -4 * math.sin(math.rad(120))}
    light.quad { corner = {-4 - u[1] / 2, -2, 6 - u[3] / 2}, u = u, v = {0, 4, 0},
                 radiance = {20.710837, 10.854635, 2.771152} }
end

local black = material.lambert { color = 0 }
local air, glass = 1.000277, 1.5046
local function wood()
    return material.lambert { color = texture.image { file = models .. "/common/textures/wood.jpg" } }
end

-- name, y, z, material
local balls = {
    {"diffuse", -6, 0, function() return material.lambert { color = {0.2, 0.5, 0.3} } end},
    {"textured", -3, 0, wood},
    {"diamond", 0, 0, function() return material.dielectric { ior = 2.419 / air } end},
    -- Light that enters would leave after a second bounce: only what the front reflects counts.
    {"glass_beckmann", 6, 0, function()
        return material.cook_torrance { color = 0, m = 0.02, ior = glass / air } end},
    {"glass_ggx", 6, 3, function()
        return material.dielectric { ior = glass / air, roughness = math.sqrt(0.1),
                                     absorption = 1e6, shadow = "opaque" } end},
    {"plastic_beckmann", 3, 3, function()
        return material.cook_torrance { color = 0, m = 0.1, ior = 1.49 / air } end},
    {"conductor", -3, 3, function() return material.conductor { eta = 0.789, k = 6.15 } end},
    -- The closest that there is; not the same (docs/evidence/mitsuba.md).
    {"plastic", 3, 0, function()
        return material.ggx { color = {0.1, 0.27, 0.36}, roughness = 0, ior = 1.9 / air } end},
    {"plastic_diffuse", 0, 3, function()
        return material.ggx { color = 0.5, roughness = math.sqrt(0.05), ior = 1.49 / air } end},
    {"conductor_beckmann", -6, 3, function()
        return material.conductor { eta = 0.789, k = 6.15, roughness = math.sqrt(0.05) } end},
}

local sphere_mesh = mesh { file = models .. "/common/meshes/sphere.obj" }
for _, ball in ipairs(balls) do
    instance { sphere_mesh, transform = transform.translate {0, ball[2], ball[3]},
               material = ball[1] == lit and ball[4]() or black, name = ball[1] }
end

-- The leaves' outline is a texture that Mitsuba's data has elsewhere; to all but the camera the whole
-- square is in the way there, too.
quad { corner = {0, -7, -4}, u = {0, 2, 0}, v = {0, 0, 2}, material = black }
quad { corner = {0, -4, -4}, u = {0, 2, 0}, v = {0, 0, 2}, material = black }
