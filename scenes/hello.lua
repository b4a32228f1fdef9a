-- A red ball on a floor under one lamp: the smallest whole scene
--
--     snell example hello > my.lua
--     snell my.lua
--
-- Metres, degrees, +Y is up. Change a number and run it again.

camera {
  from = {0, 1.5, 5},   -- where the camera stands
  at = {0, 0.8, 0},     -- what it looks at
  fov = 40,             -- how wide it sees, from bottom to top
}

background { color = {0.2, 0.3, 0.5} }   -- what a ray sees that hits nothing

-- A lamp without size. Its light falls off with the square of the distance, so that the intensity
-- (watts per steradian) has to be larger the farther away it hangs.
light.point { position = {-3, 5, 4}, intensity = 75 }

-- Light that is everywhere, so that shadows are not black: a constant, not physics.
ambient { color = 0.03 }

-- Two materials: matt colours, given as the share of red, green and blue light that comes back.
local red = material.lambert { color = {0.8, 0.15, 0.1} }
local floor = material.lambert { color = 0.6 }

sphere { center = {0, 0.8, 0}, radius = 0.8, material = red }
disk { center = {0, 0, 0}, normal = {0, 1, 0}, radius = 3.5, material = floor }
