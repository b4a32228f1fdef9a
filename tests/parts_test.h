/* What the tests of shapes of many parts share: the shape is built into a tree and traced as pictures
 * are, and each ray is held against a slow solver in long double that knows nothing of parts. */
#ifndef SNELL_TESTS_PARTS_TEST_H
#define SNELL_TESTS_PARTS_TEST_H

#include <math.h>
#include <stdbool.h>

#include "accel_test.h"
#include "base/error.h"
#include "geometry/surface.h"
#include "maths/functions.h"

typedef long double real;
typedef struct wide {
    real x, y, z;
} wide;

static inline wide wide_from(vec3 v) { return (wide){v.x, v.y, v.z}; }
static inline wide wide_from_d(dvec3 v) { return (wide){v.x, v.y, v.z}; }
static inline wide wide_add(wide a, wide b) { return (wide){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline wide wide_sub(wide a, wide b) { return (wide){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline wide wide_scale(wide a, real s) { return (wide){a.x * s, a.y * s, a.z * s}; }
static inline real wide_dot(wide a, wide b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline real wide_length(wide a) { return sqrtl(wide_dot(a, a)); }
static inline wide wide_cross(wide a, wide b) {
    return (wide){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* A place where the line meets the surface. margin: how far from its edge, or from passing by, as a
 * part of 1; under 1e-8 either way nobody can tell. slack: how far off t may be. */
typedef struct root {
    real t, margin, slack;
} root;
enum { ROOTS_MAX = 256 };

typedef struct subject {
    const char *type;
    int variants;
    /* What it points to is the subject's own, until the next call. */
    void (*make)(void *desc, rng *r, dvec3 at, double size, int variant);
    int (*solve)(const void *desc, wide o, wide d, root *roots);
    /* Of p from the surface, < 0 inside; NULL: the surface is not the same for every ray. */
    real (*distance)(const void *desc, wide p);
} subject;

typedef union part_desc {
    size_t struct_size;
    char room[256];
} part_desc;

typedef struct setting {
    const subject *of;
    const primitive_type *type;
    part_desc desc;
    dvec3 at;
    double size;
    int variant;
    accel *tree;
    bounds3 box;
    long hits, misses, unclear, again;
} setting;

static inline rng *shared_rng(void) {
    static rng r;
    return &r;
}

static inline double between(double low, double high) {
    return low + (high - low) * rng_unit(shared_rng());
}

static inline dvec3 any_direction(void) {
    double z = between(-1, 1), angle = between(0, 2 * PI), ring = sqrt(1 - z * z);
    return (dvec3){ring * cos(angle), ring * sin(angle), z};
}

static inline void setting_release(setting *s) {
    accel_destroy(s->tree);
    s->tree = NULL;
}

static inline void setting_make_at(setting *s, double size, dvec3 at, int variant) {
    setting_release(s);
    s->size = size;
    s->variant = variant;
    s->at = at;
    desc_init(&s->type->info, &s->desc);
    s->of->make(&s->desc, shared_rng(), s->at, size, variant);
    if (desc_check(&s->type->info, &s->desc, NULL) || s->type->check(&s->desc))
        fail_msg("%s", error_last()->text);
    accel_geometry geometry = {.type = s->type, .desc = &s->desc};
    accel_instance instance = {.mask = ~0u,
                               .identity = true,
                               .to_world = transform_identity(),
                               .to_local = transform_identity()};
    accel_input input = {&geometry, 1, &instance, 1};
    assert_int_equal(accel_build(&input, NULL, NULL, &s->tree), SNELL_OK);
    s->box = s->type->bounds(&s->desc);
}

static inline void setting_make(setting *s, double size, double offset, int variant) {
    setting_make_at(s, size, dvec3_scale(any_direction(), size * offset), variant);
}

/* Traces the ray and compares; true if there is a hit. */
static inline bool setting_compare(setting *s, const ray *r, hit *found) {
    static root roots[ROOTS_MAX];
    accel_trace(s->tree, SNELL_ISA_AUTO, r, found, 1, NULL);
    bool is_hit = found->instance != NO_ID;
    int count = s->of->solve(&s->desc, wide_from(r->o), wide_from(r->d), roots);
    const root *nearest = NULL;
    bool unclear = false;
    for (int i = 0; i < count; i++) {
        const root *at = &roots[i];
        real slack = at->slack + 0x1p-21L * fabsl(at->t);
        if (at->margin < -1e-8L) continue;
        if (nearest && at->t - slack > nearest->t + nearest->slack) continue;
        if (at->t + slack < r->t_min) continue;
        if (fabsl(at->t - r->t_min) <= slack || at->margin < 1e-8L) {
            unclear = true;
            continue;
        }
        if (nearest == NULL || at->t < nearest->t) nearest = at;
    }
    if (unclear) {
        s->unclear++;
        return is_hit;
    }
    if (is_hit != (nearest != NULL))
        fail_msg("%s %d: hit %d (t %g), expected %d (t %Lg, margin %Lg); size %g, at %g",
                 s->of->type, s->variant, is_hit, (double)found->t, nearest != NULL,
                 nearest ? nearest->t : 0, nearest ? nearest->margin : 0, s->size,
                 dvec3_length(s->at));
    s->hits += is_hit;
    s->misses += !is_hit;
    if (is_hit &&
        fabsl((real)found->t - nearest->t) > nearest->slack + 0x1p-21L * fabsl(nearest->t))
        fail_msg("%s %d: t %.9g, expected %.12Lg +- %Lg; size %g, at %g", s->of->type, s->variant,
                 (double)found->t, nearest->t, nearest->slack, s->size, dvec3_length(s->at));
    return is_hit;
}

static inline void setting_surface(const setting *s, const ray *r, const hit *found, surface *out) {
    local_ray beam = {r->o, r->d, r->t_min, r->t_max};
    s->type->surface(&s->desc, &beam, found, out);
    const double numbers[] = {out->p.x,    out->p.y,      out->p.z,    out->n.x,    out->n.y,
                              out->n.z,    out->ns.x,     out->ns.y,   out->ns.z,   out->error,
                              out->dpdu.x, out->dpdu.y,   out->dpdu.z, out->dpdv.x, out->dpdv.y,
                              out->dpdv.z, out->curvature};
    for (size_t i = 0; i < COUNT_OF(numbers); i++) assert_true(isfinite(numbers[i]));
    assert_true(out->u >= 0 && out->u <= 1 && out->v >= 0 && out->v <= 1);
    assert_true(out->error >= 0 && fabs(dvec3_length(out->n) - 1) < 1e-14);
    assert_true(dvec3_dot(out->n, out->ns) > 0 && fabs(dvec3_length(out->ns) - 1) < 1e-14);
    assert_true(out->p.x >= (double)s->box.min.x && out->p.x <= (double)s->box.max.x);
    assert_true(out->p.y >= (double)s->box.min.y && out->p.y <= (double)s->box.max.y);
    assert_true(out->p.z >= (double)s->box.min.z && out->p.z <= (double)s->box.max.z);
    if (s->of->distance == NULL) return;
    real magnitude = fabsl((real)out->p.x) + fabsl((real)out->p.y) + fabsl((real)out->p.z);
    real distance = fabsl(s->of->distance(&s->desc, wide_from_d(out->p)));
    if (!(distance <= 1e-11L * (magnitude + 10 * s->size)) || !(distance <= out->error))
        fail_msg("%s %d: a point is %Lg from the surface, its error %g; size %g", s->of->type,
                 s->variant, distance, out->error, s->size);
}

static inline dvec3 setting_target(const setting *s) {
    dvec3 low = dvec3_from(s->box.min), high = dvec3_from(s->box.max), size = dvec3_sub(high, low);
    return dvec3_add(
        low, (dvec3){size.x * between(0, 1), size.y * between(0, 1), size.z * between(0, 1)});
}

static inline ray ray_between(dvec3 from, dvec3 to) {
    vec3 o = vec3_from(from);
    dvec3 d = dvec3_scale(dvec3_normalize(dvec3_sub(to, dvec3_from(o))), between(0.3, 3));
    return ray_make(o, vec3_from(d), 0, INFINITY);
}

/* last: a surface point that was met. */
static inline ray setting_ray(const setting *s, int kind, const surface *last) {
    dvec3 target = setting_target(s);
    double far = s->size * exp2(between(0, 14));
    ray r;
    switch (kind) {
    case 0: return ray_between(dvec3_add(s->at, dvec3_scale(any_direction(), far)), target);
    case 1: return ray_between(setting_target(s), target);
    case 2: { /* along an axis */
        r = ray_between(setting_target(s), target);
        uint32_t axis = rng_below(shared_rng(), 3);
        float step = rng_bits(shared_rng()) & 1 ? 1.0f : -1.0f;
        r.d = (vec3){axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
        return r;
    }
    case 3: { /* grazes: through a point that was met, along a tangent or nearly so */
        double angle = between(0, 2 * PI), out = exp2(-between(1, 40));
        dvec3 d = dvec3_from_frame(last->n, (dvec3){cos(angle), sin(angle), out});
        return ray_between(dvec3_sub(last->p, dvec3_scale(d, far)), last->p);
    }
    default: /* towards a point that was met */
        return ray_between(dvec3_add(last->p, dvec3_scale(any_direction(), far)), last->p);
    }
}

#endif
