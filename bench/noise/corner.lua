-- Easy but for one corner: a matt wall in even light, and a glass ball over a small lamp in a box
render { integrator = "path", width = 128, height = 128, samples = 256, max_depth = 12 }
camera { from = {0, 0, 8}, at = {0, 0, 0}, fov = 34 }
background { color = 0.6 }
quad { corner = {-4, -4, -1}, u = {8, 0, 0}, v = {0, 8, 0}, material = material.lambert { color = 0.5 } }
light.quad { center = {-1.9, 2.3, 0.4}, at = {-1.9, 1.9, -1}, width = 0.25, radiance = 40 }
sphere { center = {-1.9, 1.8, -0.5}, radius = 0.32, material = material.dielectric { ior = 1.5 } }
