-- A glass ball under a lamp: light through glass, which paths find by chance
render { integrator = "path", width = 128, height = 128, samples = 256, max_depth = 12 }
camera { from = {0, 2.2, 4.2}, at = {0, 0.3, 0}, fov = 34 }
background { color = 0.05 }
light.quad { center = {-1.4, 2.6, -0.6}, at = {0, 0, 0}, width = 1.4, radiance = 8 }
plane { point = {0, 0, 0}, material = material.lambert { color = {0.6, 0.55, 0.5} } }
sphere { center = {-0.45, 0.5, 0}, radius = 0.5, material = material.dielectric { ior = 1.5 } }
sphere { center = {0.1, 0.18, 0.8}, radius = 0.18, material = material.lambert { color = {0.7, 0.2, 0.1} } }
