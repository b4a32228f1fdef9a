/* What a scene may say once about its picture: render{}, background{}, ambient{}. */
#ifndef SNELL_SCENE_SETTINGS_H
#define SNELL_SCENE_SETTINGS_H

#include "base/field.h"

/* "default", and the names of image/tonemap.h's registry. */
#define TONEMAP_CHOICES "default|clip|reinhard|neutral"

/* Fields below their range's first useful value mean "not said": 0, or -1 where 0 is meaningful. */
#define RENDER_FIELDS(F, T)                                                                        \
    F(T, integrator, CHOICE, DEFAULT(0), CHOICES("default|appel|whitted|cook|path"), "",           \
      "how light is followed")                                                                     \
    F(T, width, INT, DEFAULT(0), RANGE(0, 65536), "pixels", "0: 800")                              \
    F(T, height, INT, DEFAULT(0), RANGE(0, 65536), "pixels", "0: 600")                             \
    F(T, samples, INT, DEFAULT(0), RANGE(0, 1048576), "",                                          \
      "camera rays per pixel; 0: the integrator's default")                                        \
    F(T, max_depth, INT, DEFAULT(-1), RANGE(-1, 1000), "",                                         \
      "camera ray 0, each bounce one more; -1: the integrator's default")                          \
    F(T, min_weight, FLOAT, DEFAULT(-1), RANGE(-1, 1), "",                                         \
      "drop rays that matter less; -1: 0.002")                                                     \
    F(T, seed, INT, DEFAULT(0), RANGE(0, 2147483647), "", "of the random numbers")                 \
    F(T, pixel_center, BOOL, DEFAULT(0), ANY, "", "every sample through the pixel's centre")       \
    F(T, exposure, FLOAT, DEFAULT(0), RANGE(-50, 50), "stops", "2^exposure times the light")       \
    F(T, tonemap, CHOICE, DEFAULT(0), CHOICES(TONEMAP_CHOICES), "",                                \
      "default: clip; neutral for models")
DESCRIBE_STRUCT(render, RENDER_FIELDS)

/* The sky: color, or a gradient by the ray's direction d: color + (top - color) (1 + d.y) / 2. */
#define BACKGROUND_FIELDS(F, T)                                                                    \
    F(T, color, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W/(m^2 sr)",                               \
      "radiance that a ray that leaves sees")                                                      \
    F(T, top, COLOR, DEFAULT(-1, -1, -1), RANGE(-1, INFINITY), "W/(m^2 sr)",                       \
      "straight up, color then being straight down; -1: color everywhere")                         \
    F(T, alpha, FLOAT, DEFAULT(1), RANGE(0, 1), "", "0: the picture is transparent there")
DESCRIBE_STRUCT(background, BACKGROUND_FIELDS)

#define AMBIENT_FIELDS(F, T)                                                                       \
    F(T, color, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W/(m^2 sr)",                               \
      "L_a: added once to every lit surface, times its k_a")
DESCRIBE_STRUCT(ambient, AMBIENT_FIELDS)

extern const type_info setting_render, setting_background, setting_ambient;

#endif
