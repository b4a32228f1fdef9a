-- Nearly black: a black hall, one faint lamp behind a wall, and a few dark things that it reaches
render { integrator = "path", width = 128, height = 128, samples = 256, max_depth = 8 }
camera { from = {0, 1.2, 5}, at = {0, 0.8, 0}, fov = 36 }
light.sphere { center = {-2.2, 1.4, -0.4}, radius = 0.08, radiance = 4 }
box { min = {-1.3, 0, -1.2}, max = {-1.2, 2.2, 1}, material = material.lambert { color = 0.02 } }
quad { corner = {-3, 0, -1.5}, u = {6, 0, 0}, v = {0, 3, 0}, material = material.lambert { color = 0.04 } }
plane { point = {0, 0, 0}, material = material.lambert { color = 0.03 } }
sphere { center = {0.6, 0.4, 0}, radius = 0.4, material = material.lambert { color = {0.3, 0.05, 0.05} } }
sphere { center = {-0.4, 0.3, 0.6}, radius = 0.3, material = material.conductor { metal = "gold", roughness = 0.3 } }
