-- Twenty balls of facets: rougher to the right, denser upwards
--
-- Cook and Torrance ("A Reflectance Model for Computer Graphics", 1982) take a surface for a heap of
-- tiny mirrors:  f = R/pi + D G F / (4 cos cos').  D, after Beckmann, says how many facets have
-- the normal that mirrors the lamp into the eye; its m is their mean slope and grows from left to
-- right: the highlight widens and dims. F is Fresnel's share for an index of refraction that grows
-- from row to row, 1.25 to 5: the highlight brightens, most of all near the middle, where a plain
-- surface mirrors little. At the rim F comes near 1 whatever the index: every ball there mirrors its
-- surroundings.
-- Try:  snell cook-torrance.lua -D color=0      the facets alone

local color = param("color", 0.28, "how bright the matt part is, 0 to 1")

render { integrator = "path", width = 640, height = 480, samples = 144, max_depth = 3, exposure = 0.7 }
camera { from = {0, 0, 12}, at = {0, 0, 0}, fov = 29 }

-- Two lamps and a dim room. The left lamp is a tall window, whose image shows the width of the lobe.
light.environment { radiance = {0.10, 0.11, 0.13}, visible = false }
light.quad { center = {-6, 3.5, 7}, at = {0, 0, 0}, width = 2.6, height = 4.4, radiance = {8, 7.5, 6.6}, name = "window" }
light.quad { center = {7, -1, 4}, at = {0, 0, 0}, width = 2.5, height = 5, radiance = {1.2, 1.6, 2.2}, name = "fill" }
background { color = {0.018, 0.018, 0.02} }

local slopes = { 0.05, 0.12, 0.22, 0.35, 0.6 }
local indices = { 1.25, 1.6, 2.5, 5 }
for row, ior in ipairs(indices) do
    for column, m in ipairs(slopes) do
        sphere { center = {1.5 * (column - 3), 1.5 * (row - 2.5), 0}, radius = 0.6,
                 name = string.format("m %.2f, ior %.2f", m, ior),
                 material = material.cook_torrance { m = m, ior = ior, color = {color, 0.22 * color, 0.12 * color} } }
    end
end
