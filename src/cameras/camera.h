/* From a place in the picture to a ray. One file per camera; one line in cameras.def. */
#ifndef SNELL_CAMERAS_CAMERA_H
#define SNELL_CAMERAS_CAMERA_H

#include "base/field.h"
#include "maths/vec.h"

/* A place in the whole picture, in pixels from its top left corner. */
typedef struct camera_sample {
    double x, y;
} camera_sample;

/* A camera made ready: where it is, its axes, and what its own ray function needs. */
typedef struct camera_frame {
    vec3 position;
    /* Perspective: the direction of the top left corner, and the steps to the next column and row. */
    dvec3 corner, right, down;
} camera_frame;

typedef struct camera_type {
    type_info info;
    snell_status (*check)(const void *desc);
    /* What all rays of a picture share. */
    void (*prepare)(const void *desc, uint32_t width, uint32_t height, camera_frame *out);
    void (*ray)(const camera_frame *frame, const camera_sample *sample, vec3 *o,
                vec3 *d); /* d: unit, rounded */
} camera_type;

extern const camera_type *const camera_types[];
extern const uint32_t camera_type_count;
extern const camera_type camera_perspective; /* snell_view is one of these by value */

#define PERSPECTIVE_FIELDS(F, T)                                                                   \
    F(T, from, VEC3, DEFAULT(0, 0, 5), ANY, "m", "where the eye is")                               \
    F(T, at, VEC3, DEFAULT(0, 0, 0), ANY, "m", "what it looks at")                                 \
    F(T, up, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "what is up in the picture")                   \
    F(T, fov, FLOAT, DEFAULT(0.6981317f), RANGE(1e-4, 3.1415), "rad", "vertical field of view")
DESCRIBE_STRUCT(perspective, PERSPECTIVE_FIELDS)

#endif
