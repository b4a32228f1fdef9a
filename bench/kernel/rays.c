#include "rays.h"

#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "parts.h"
#include "sampling/warp.h"

const char *const ray_kind_names[RAY_KINDS] = {"primary", "shadow", "reflect", "diffuse", "ao"};

static void allocate(ray_set *set, size_t count) {
    set->rays = bench_need(memory_aligned(count * sizeof *set->rays));
    set->count = 0;
}

void rays_free(ray_set *set) { memory_free_aligned(set->rays); }

void rays_pixel(uint32_t size, size_t i, uint32_t *x, uint32_t *y) {
    uint32_t block = (uint32_t)(i / 64), inside = (uint32_t)(i % 64);
    *x = block % (size / 8) * 8 + inside % 8;
    *y = block / (size / 8) * 8 + inside / 8;
}

void rays_make_primary(const subject *s, uint32_t size, ray_set *out) {
    const bench_camera *c = &s->scene.camera;
    dvec3 forward = dvec3_normalize(dvec3_sub(c->look, c->eye));
    bool vertical = fabs(forward.y) > 0.9999;
    dvec3 above = {0, !vertical, -(double)vertical};
    dvec3 right = dvec3_normalize(dvec3_cross(forward, above));
    dvec3 up = dvec3_cross(right, forward);
    double wide = 2 * fn_tan(c->fov * PI / 360);
    allocate(out, (size_t)size * size);
    for (uint32_t i = 0; i < size * size; i++) {
        uint32_t x, y;
        rays_pixel(size, i, &x, &y);
        double sx = wide * ((x + 0.5) / size - 0.5), sy = wide * (0.5 - (y + 0.5) / size);
        dvec3 d = dvec3_add(dvec3_add(dvec3_scale(right, sx), dvec3_scale(up, sy)), forward);
        ray *r = &out->rays[out->count++];
        *r = ray_make(vec3_from(c->eye), vec3_from(dvec3_normalize(d)), 0, INFINITY);
        r->time = (float)(i * 2654435769u >> 8) * 0x1p-24f;
    }
}

static ray ray_of_kind(const subject *s, uint32_t kind, dvec3 o, dvec3 d, dvec3 n, rng *random) {
    if (kind == RAY_SHADOW)
        return ray_make(vec3_from(o), vec3_from(dvec3_sub(s->scene.light, o)), 0, 1);
    if (kind == RAY_REFLECT) {
        dvec3 r = dvec3_sub(d, dvec3_scale(n, 2 * dvec3_dot(n, d)));
        return ray_make(vec3_from(o), vec3_from(r), 0, INFINITY);
    }
    double u = rng_unit(random), v = rng_unit(random);
    dvec3 r = dvec3_from_frame(n, warp_cosine_hemisphere((sample2){u, v}));
    double length = kind == RAY_AO ? RAY_AO_LENGTH * s->size : INFINITY;
    return ray_make(vec3_from(o), vec3_from(r), 0, (float)length);
}

void rays_make(const subject *s, uint32_t kind, const ray_set *primary, const hit *hits,
               ray_set *out) {
    rng random = {100 + kind};
    allocate(out, primary->count);
    for (size_t i = 0; i < primary->count; i++) {
        const hit *h = &hits[i];
        const ray *from = &primary->rays[i];
        if (h->instance == NO_ID) continue;
        dvec3 d = dvec3_from(from->d);
        dvec3 p = dvec3_add(dvec3_from(from->o), dvec3_scale(d, h->t));
        dvec3 n = subject_normal(s, h, p, from->time);
        if (dvec3_dot(n, d) > 0) n = dvec3_negate(n);
        dvec3 o = dvec3_add(p, dvec3_scale(n, 1e-4 * s->size)); /* a little off the surface */
        ray *r = &out->rays[out->count++];
        *r = ray_of_kind(s, kind, o, d, n, &random);
        r->time = from->time;
    }
}

void rays_spoil(const ray_set *from, ray_set *out) {
    rng random = {7};
    allocate(out, from->count);
    out->count = from->count;
    memcpy(out->rays, from->rays, from->count * sizeof *from->rays);
    const float bad[3] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < out->count; i++) {
        ray *r = &out->rays[i];
        float *parts[8] = {&r->o.x, &r->o.y, &r->o.z,   &r->d.x,
                           &r->d.y, &r->d.z, &r->t_min, &r->t_max};
        if (rng_below(&random, RAY_SPOILED)) continue;
        uint32_t part = rng_below(&random, 8), value = rng_below(&random, 3);
        /* An interval may begin at -infinity and end at infinity. */
        *parts[part] = part == 7 ? NAN : part == 6 ? bad[value % 2] : bad[value];
    }
}
