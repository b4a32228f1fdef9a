-- A ball over a floor that is matte or a mirror: questions 3 and 4.

local mirror = param("mirror", false, "the floor is a mirror")
local ball = param("ball", true, "there is a ball")

render { integrator = "whitted", width = 320, height = 240, samples = 16 }
camera { from = {0, 1.5, 5}, at = {0, 0.8, 0}, fov = 36 }
background { color = {0.35, 0.4, 0.45}, top = {0.08, 0.14, 0.3} }
light.point { position = {2, 4, 3}, intensity = 60, name = "lamp" }
if ball then
    sphere { center = {0, 1, 0}, radius = 1, name = "ball", material = material.lambert { color = {0.7, 0.15, 0.1} } }
end
plane { name = "floor", material = mirror and material.mirror { color = 0.9 } or material.lambert { color = 0.6 } }
