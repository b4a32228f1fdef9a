/* The kinds of rays that the kernel benchmark traces; the same bits in every run. */
#ifndef SNELL_BENCH_KERNEL_RAYS_H
#define SNELL_BENCH_KERNEL_RAYS_H

#include "subject.h"

/* From the camera, pixel by pixel in blocks of 8 x 8; and, in that order, from each of its hits: to
 * the light (any hit); along the mirrored direction; in a random direction, distributed as the cosine
 * to the normal; and in another such direction, any hit within RAY_AO_LENGTH of the scene's
 * diagonal. */
enum { RAY_PRIMARY, RAY_SHADOW, RAY_REFLECT, RAY_DIFFUSE, RAY_AO, RAY_KINDS };
#define RAY_AO_LENGTH 0.05
extern const char *const ray_kind_names[RAY_KINDS];
static inline bool ray_kind_any(uint32_t kind) { return kind == RAY_SHADOW || kind == RAY_AO; }
/* Neighbours go the same way. */
static inline bool ray_kind_coherent(uint32_t kind) {
    return kind == RAY_PRIMARY || kind == RAY_SHADOW;
}

typedef struct ray_set {
    ray *rays;
    size_t count;
} ray_set;

/* size: pixels across and down, a multiple of 8. */
void rays_make_primary(const subject *s, uint32_t size, ray_set *out);
/* Of another kind; hits: of the primary rays. No ray leaves where one missed. */
void rays_make(const subject *s, uint32_t kind, const ray_set *primary, const hit *hits,
               ray_set *out);
/* A copy in which one ray of RAY_SPOILED, at random, has a NaN or infinite part in its origin,
 * direction or interval, by which it hits nothing. */
enum { RAY_SPOILED = 8 };
void rays_spoil(const ray_set *from, ray_set *out);
static inline bool ray_is_spoiled(const ray *r) {
    float sum = (r->o.x + r->o.y + r->o.z + r->d.x + r->d.y + r->d.z + r->t_min) * 0;
    return !(sum == 0) || r->t_max != r->t_max;
}
void rays_free(ray_set *set);
/* The pixel of primary ray i. */
void rays_pixel(uint32_t size, size_t i, uint32_t *x, uint32_t *y);

#endif
