/* A point source that shines into a cone. The intensity is that on the axis; between the inner and
 * the outer half-angle it falls by a smoothstep of the cosine (as pbrt's spot light does). */
#include "lights/light.h"

#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "maths/functions.h"

#define SPOT_FIELDS(F, T)                                                                          \
    F(T, position, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "where it is")                           \
    F(T, at, VEC3, DEFAULT(0, 0, 0), REQUIRED, "m", "a point that it shines at")                   \
    F(T, intensity, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/sr",                                 \
      "power per solid angle, on the axis")                                                        \
    F(T, power, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W",                                        \
      "instead of intensity: all the light that leaves the cone")                                  \
    F(T, cone, FLOAT, DEFAULT(0.5235988f), RANGE(1e-4, 3.1415927), "rad",                          \
      "the half-angle from the axis to the edge, where it is dark")                                \
    F(T, blend, FLOAT, DEFAULT(0.0872665f), RANGE(0, 3.1415927), "rad",                            \
      "over this angle inside the edge it fades; 0: a hard edge")
DESCRIBE(spot, SPOT_FIELDS)

static snell_status check(const void *desc) {
    const spot_desc *l = desc;
    dvec3 axis = dvec3_sub(dvec3_from(l->at), dvec3_from(l->position));
    if (!(dvec3_length(axis) > 0))
        return error_set(SNELL_ERR_ARGUMENT, "move one of them",
                         "spot: 'position' and 'at' are the same point");
    if (l->blend > l->cone)
        return error_set(SNELL_ERR_ARGUMENT, "it is a part of the cone's half-angle",
                         "spot: 'blend' is wider than 'cone'");
    return SNELL_OK;
}

static dvec3 axis_of(const spot_desc *l) {
    return dvec3_normalize(dvec3_sub(dvec3_from(l->at), dvec3_from(l->position)));
}

/* The fraction of the axis' intensity at an angle of this cosine. */
static double falloff(double cosine, double cos_outer, double cos_inner) {
    if (cosine <= cos_outer) return 0;
    if (cosine >= cos_inner) return 1;
    double t = (cosine - cos_outer) / (cos_inner - cos_outer);
    return t * t * (3 - 2 * t);
}

typedef struct spot_state {
    dvec3 intensity, axis;
    double cos_outer, cos_inner;
} spot_state;

/* The smoothstep's mean over the cosine is a half, so the cone holds
 * 2 pi I ((1 - cos_inner) + (cos_inner - cos_outer) / 2). */
static double cone_solid_angle(const spot_state *s) {
    return 2 * PI * (1 - s->cos_inner + (s->cos_inner - s->cos_outer) / 2);
}

static spot_state state_of(const spot_desc *l) {
    spot_state s = {.axis = axis_of(l),
                    .cos_outer = fn_cos((double)l->cone),
                    .cos_inner = fn_cos((double)l->cone - (double)l->blend)};
    dvec3 power = dvec3_from(l->power);
    s.intensity = dvec3_largest(power) > 0 ? dvec3_scale(power, 1 / cone_solid_angle(&s))
                                           : dvec3_from(l->intensity);
    return s;
}

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)eye, (void)u;
    const spot_state *s = l->state;
    dvec3 position = dvec3_from(((const spot_desc *)l->desc)->position);
    double cosine = dvec3_dot(dvec3_normalize(dvec3_sub(p, position)), s->axis);
    double fraction = falloff(cosine, s->cos_outer, s->cos_inner);
    return fraction > 0 &&
           light_sample_point(position, dvec3_scale(s->intensity, fraction), p, out);
}

static dvec3 power(const light *l, double scene_radius) {
    (void)scene_radius;
    const spot_state *s = l->state;
    return dvec3_scale(s->intensity, cone_solid_angle(s));
}

static void place(const light *l, dvec3 *position, dvec3 *axis, double *cos_spread) {
    const spot_state *s = l->state;
    *position = dvec3_from(((const spot_desc *)l->desc)->position);
    *axis = s->axis;
    *cos_spread = s->cos_outer;
}

static snell_status prepare(const void *desc, const texture *textures, thread_pool *pool,
                            void **state) {
    (void)textures, (void)pool;
    spot_state *s = memory_resize(NULL, 1, sizeof *s);
    if (s == NULL) return error_no_memory();
    *s = state_of(desc);
    *state = s;
    return SNELL_OK;
}

const light_type light_spot = {
    .info = TYPE_INFO_EITHER(CATEGORY_LIGHT, spot, "spot", "shines from one point into a cone",
                             "intensity|power"),
    .check = check,
    .sample = sample,
    .power = power,
    .place = place,
    .prepare = prepare,
    .release = free,
    .casts_shadow = true,
};
