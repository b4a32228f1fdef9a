/* From a place in the picture to a ray. One file per camera; one line in cameras.def. */
#ifndef SNELL_CAMERAS_CAMERA_H
#define SNELL_CAMERAS_CAMERA_H

#include "base/field.h"
#include "maths/motion.h"
#include "sampling/sampling.h"

/* A place in the whole picture, in pixels from its top left corner (a filter may reach beyond the
 * picture's edges), one on the lens, and a moment. */
typedef struct camera_sample {
    double x, y;
    sample2 lens;
    float time; /* seconds */
} camera_sample;

/* A camera made ready: its axes, and what its own ray function needs. */
typedef struct camera_frame {
    vec3 position;        /* in the world, when the shutter opens */
    const motion *motion; /* what the camera is moved by; NULL: it stands still */
    /* Its own space: the world, if it does not move. */
    vec3 origin;
    dvec3 forward, right, up; /* unit */
    /* Perspective: the direction of the top left corner, and the steps to the next column and row.
     * Orthographic: the same as places on the plane of the origin. */
    dvec3 corner, column, row;
    double lens_radius, focus; /* metres; radius 0: a pinhole */
    unsigned blades;           /* 0: a round lens */
    double blade_rotation;     /* radians */
    double width, height;      /* pixels, of the whole picture */
    double fov;                /* radians: fisheye */
} camera_frame;

/* Every camera's description begins with these. */
#define CAMERA_FIELDS(F, T)                                                                        \
    F(T, from, VEC3, DEFAULT(0, 0, 5), ANY, "m", "where the eye is")                               \
    F(T, at, VEC3, DEFAULT(0, 0, 0), ANY, "m", "what it looks at")                                 \
    F(T, up, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "what is up in the picture")                   \
    F(T, shutter, VEC2, DEFAULT(0, 0.5f), RANGE(-1000, 1000), "frames",                            \
      "when it opens and closes, from the frame's own time; seen where something moves")           \
    F(T, motion, KEYS, NO_DEFAULT, ANY, "", "moves the camera from where 'from' and 'at' put it")
DESCRIBE_STRUCT(camera_common, CAMERA_FIELDS)
typedef camera_common_desc camera_common;

typedef struct camera_type {
    type_info info;
    snell_status (*check)(const void *desc);
    /* What all rays of a picture share; axes, origin and sizes are set already. */
    void (*prepare)(const void *desc, camera_frame *out);
    /* In the camera's own space; d of any length. false: no ray goes there, it is black. */
    bool (*ray)(const camera_frame *frame, const camera_sample *sample, vec3 *o, dvec3 *d);
    /* The place in the picture where a point is seen, from the middle of the lens; v: from the origin,
     * in the camera's own space. false: nowhere, as what is behind a perspective one. */
    bool (*project)(const camera_frame *frame, dvec3 v, double *x, double *y);
    bool has_plane; /* its picture is one of a plane: depth counts along the axis, not along rays */
} camera_type;

extern const camera_type *const camera_types[];
extern const uint32_t camera_type_count;
extern const camera_type camera_perspective; /* snell_view is one of these by value */

/* What every camera checks of its common fields. */
snell_status camera_check(const void *desc, const char *name);
/* `moved`: NULL, or the camera's own motion over its shutter, kept by the caller. */
void camera_prepare(const camera_type *type, const void *desc, uint32_t width, uint32_t height,
                    const motion *moved, camera_frame *out);
/* d: unit, rounded. false: no ray goes there. */
bool camera_ray(const camera_type *type, const camera_frame *frame, const camera_sample *sample,
                vec3 *o, vec3 *d);
/* The same for a point of the world, at a time. */
bool camera_project(const camera_type *type, const camera_frame *frame, float time, dvec3 p,
                    double *x, double *y);

/* How deep in the picture a point of the world is, metres: along the camera's axis, or where that has
 * no meaning (panorama, fisheye) from the eye. */
double camera_depth(const camera_type *type, const camera_frame *frame, float time, dvec3 p);

#define PERSPECTIVE_FIELDS(F, T)                                                                   \
    CAMERA_FIELDS(F, T)                                                                            \
    F(T, fov, FLOAT, DEFAULT(0.6981317f), RANGE(1e-4, 3.1415), "rad", "vertical field of view")    \
    F(T, lens_radius, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                                        \
      "0: a pinhole, everything sharp; larger: more blur out of focus")                            \
    F(T, focus, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                                              \
      "distance of the sharp plane along the view; 0: that of 'at'")                               \
    F(T, blades, INT, DEFAULT(0), RANGE(0, 16), "", "sides of the aperture, 3 to 16; 0: round")    \
    F(T, blade_rotation, FLOAT, DEFAULT(0), ANY, "rad",                                            \
      "turns the aperture, whose first corner is on the right")
DESCRIBE_STRUCT(perspective, PERSPECTIVE_FIELDS)

#endif
