-- A lens and a shutter: balls out of focus, one of them moving
render { integrator = "cook", width = 128, height = 128, samples = 64, max_depth = 6 }
camera { from = {0, 1, 4}, at = {0, 0.4, 0}, fov = 36, lens_radius = 0.1, focus = 4, shutter = {0, 1} }
background { color = {0.4, 0.45, 0.55}, top = {0.1, 0.2, 0.5} }
light.quad { center = {1.5, 4, 2.5}, at = {0, 0, 0}, width = 1.5, radiance = 14 }
plane { point = {0, 0, 0}, material = material.lambert { color = {0.5, 0.45, 0.4} } }
for i = -2, 2 do
    sphere { center = {0.8 * i, 0.3, -0.9 * i}, radius = 0.3,
             material = material.glazed { ior = 1.5, base = material.lambert {
                 color = { 0.5 + 0.2 * i, 0.4, 0.5 - 0.2 * i } } } }
end
instance { sphere { radius = 0.25, material = material.lambert { color = {0.9, 0.7, 0.1} } },
           motion = function(t) return transform.translate { -0.5 + 24 * t, 1.1, 0.5 } end }
