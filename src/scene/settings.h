/* What a scene may say once about its picture: render{}, background{}, ambient{}. */
#ifndef SNELL_SCENE_SETTINGS_H
#define SNELL_SCENE_SETTINGS_H

#include "base/field.h"

/* The gradient that the studio puts around what has no background: looking down, and up. */
#define STUDIO_BOTTOM ((snell_vec3){0.20f, 0.21f, 0.23f})
#define STUDIO_TOP ((snell_vec3){0.8f, 0.82f, 0.85f})

/* "default", and the names of image/tonemap.h's registry. */
#define TONEMAP_CHOICES "default|clip|reinhard|neutral|aces|agx"

/* Fields below their range's first useful value mean "not said": 0, or -1 where 0 is meaningful. */
#define RENDER_FIELDS(F, T)                                                                        \
    F(T, integrator, CHOICE, DEFAULT(0), CHOICES("default|appel|whitted|cook|path"), "",           \
      "how light is followed")                                                                     \
    F(T, width, INT, DEFAULT(0), RANGE(0, 65536), "pixels", "0: 800")                              \
    F(T, height, INT, DEFAULT(0), RANGE(0, 65536), "pixels", "0: 600")                             \
    F(T, samples, INT, DEFAULT(0), RANGE(0, 1048576), "",                                          \
      "camera rays per pixel; 0: the integrator's default")                                        \
    F(T, noise, FLOAT, DEFAULT(0), RANGE(0, 1), "",                                                \
      "render until the error of every block is under this share of its mean, such as 0.01; then " \
      "samples is the most of them; 0: no bound")                                                  \
    F(T, max_depth, INT, DEFAULT(-1), RANGE(-1, 1000), "",                                         \
      "camera ray 0, each bounce one more; -1: the integrator's default")                          \
    F(T, min_weight, FLOAT, DEFAULT(-1), RANGE(-1, 1), "",                                         \
      "drop rays that matter less; -1: 0.002")                                                     \
    F(T, seed, INT, DEFAULT(0), RANGE(0, 2147483647), "", "of the random numbers")                 \
    F(T, filter, CHOICE, DEFAULT(0), CHOICES("box|tent|gaussian|blackman-harris"), "",             \
      "how samples around a pixel's centre make the pixel")                                        \
    F(T, filter_radius, FLOAT, DEFAULT(0), RANGE(0, 16), "pixels",                                 \
      "0: box 0.5, tent 1, gaussian 1.5 (three sigmas), blackman-harris 1.5")                      \
    F(T, pixel_center, BOOL, DEFAULT(0), ANY, "", "every sample through the pixel's centre")       \
    F(T, exposure, FLOAT, DEFAULT(0), RANGE(-50, 50), "stops", "2^exposure times the light")       \
    F(T, tonemap, CHOICE, DEFAULT(0), CHOICES(TONEMAP_CHOICES), "",                                \
      "default: clip; neutral for models")                                                         \
    F(T, white_balance, STRING, NO_DEFAULT, OR_NUMBER, "",                                         \
      "the light that is to look white: kelvin, such as 3200, or a colour as text, such as "       \
      "\"#ffd9b0\" or \"1,0.7,0.4\"; 6504 (D65) changes nothing")                                  \
    F(T, aov, STRING, NO_DEFAULT, ANY, "",                                                         \
      "layers beside the picture, as in \"depth,normal\": 'snell help aovs'")
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

/* The clock: time = (frame - 1) / fps seconds. */
#define FRAME_MAX 1000000
#define ANIMATION_FIELDS(F, T)                                                                     \
    F(T, fps, FLOAT, DEFAULT(24), RANGE(0.001, 100000), "1/s", "frames in a second")               \
    F(T, first, INT, DEFAULT(1), RANGE(1, FRAME_MAX), "", "the first frame")                       \
    F(T, last, INT, DEFAULT(120), RANGE(1, FRAME_MAX), "", "the last frame")                       \
    F(T, frame, INT, DEFAULT(1), RANGE(1, FRAME_MAX), "",                                          \
      "which one this is; a scene program has it from --frame")
DESCRIBE_STRUCT(animation, ANIMATION_FIELDS)

extern const type_info setting_animation;
extern const type_info setting_render, setting_background, setting_ambient;

#endif
