#include "picture.h"

#include <stdlib.h>

#include "base/memory.h"
#include "image/write.h"
#include "parts.h"
#include "rays.h"

static uint8_t *occlude(const subject *s, const ray_set *set) {
    uint8_t *blocked = bench_need(memory_zeroed(set->count + 1, 1));
    accel_occluded(s->accel, SNELL_ISA_AUTO, set->rays, blocked, set->count, NULL);
    return blocked;
}

void picture_write(const subject *s, uint32_t size, const char *path) {
    ray_set primary, shadow, ao;
    rays_make_primary(s, size, &primary);
    hit *hits = bench_need(memory_zeroed(primary.count, sizeof *hits));
    accel_trace(s->accel, SNELL_ISA_AUTO, primary.rays, hits, primary.count, NULL);
    rays_make(s, RAY_SHADOW, &primary, hits, &shadow);
    rays_make(s, RAY_AO, &primary, hits, &ao);
    uint8_t *dark = occlude(s, &shadow), *near = occlude(s, &ao);
    float *pixels = bench_need(memory_zeroed(primary.count, 3 * sizeof *pixels));
    for (size_t i = 0, k = 0; i < primary.count; i++) {
        if (hits[i].instance == NO_ID) continue;
        const ray *r = &primary.rays[i];
        dvec3 p = dvec3_add(dvec3_from(r->o), dvec3_scale(dvec3_from(r->d), hits[i].t));
        dvec3 n = subject_normal(s, &hits[i], p, r->time);
        if (dvec3_dot(n, dvec3_from(r->d)) > 0) n = dvec3_negate(n);
        double lit = dvec3_dot(n, dvec3_normalize(dvec3_from(shadow.rays[k].d)));
        double light = (dark[k] || lit < 0 ? 0 : 0.7 * lit) + (near[k] ? 0.02 : 0.12);
        uint32_t x, y;
        rays_pixel(size, i, &x, &y);
        float *to = pixels + 3 * ((size_t)y * size + x);
        to[0] = to[1] = to[2] = (float)light;
        k++;
    }
    if (image_write(path, &(image_pixels){pixels, size, size, 3}, &(image_options){0}))
        bench_die(error_last()->text);
    free(pixels);
    free(dark);
    free(near);
    free(hits);
    rays_free(&primary);
    rays_free(&shadow);
    rays_free(&ao);
}
