-- A slice of a quaternion Julia set: the points that q -> q^2 + c never sends far away
-- (Hart, Sandin, Kauffman, Ray Tracing Deterministic 3-D Fractals, 1989).
-- Try: snell julia.lua -D iterations=12, which shows more of it
local iterations = param("iterations", 9, "steps of q -> q^2 + c")

render { integrator = "whitted", width = 640, height = 480, samples = 4 }
camera { from = {1.9, 1.5, 2.9}, at = {0, -0.08, 0}, fov = 38 }
background { color = {0.02, 0.02, 0.03}, top = {0.1, 0.14, 0.25} }
ambient { color = {0.05, 0.06, 0.09} }
light.directional { direction = {-1, -1.5, -0.45}, irradiance = 2.6 }

julia {
    c = {-0.2, 0.6, 0.2}, c_k = 0.2, iterations = iterations,
    material = material.blinn_phong { color = {0.9, 0.36, 0.08}, specular = 0.35, exponent = 60 }
}
plane { point = {0, -1.05, 0}, material = material.lambert { color = {0.12, 0.14, 0.2} } }
