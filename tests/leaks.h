/* Leaks: closed meshes, and rays from inside them that must not get out. What test_accel_leaks.c asks
 * of a few rays and bench/leaks.c of very many. */
#ifndef SNELL_TESTS_LEAKS_H
#define SNELL_TESTS_LEAKS_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel.h"
#include "geometry/mesh.h"
#include "maths/functions.h"
#include "random_numbers.h"

/* ---- closed meshes ---- */

/* Grids of vertices closed around both ways, or around one way and by two poles. */
typedef struct leak_mesh_type {
    const char *name;
    uint32_t columns, rows; /* rings of vertices along the mesh, and vertices of a ring */
    bool poles;
    double size; /* about its extent */
    double room; /* around each of its middles a ball of this radius is inside */
    int far;     /* as far as 2^far sizes away it is still a surface around its middles */
    dvec3 (*vertex)(double along, double around, rng *r); /* each from 0 to 1; poles: along 0, 1 */
    dvec3 (*middle)(double along);
    bool uneven; /* the rings and the vertices of a ring are not evenly spaced */
} leak_mesh_type;

static inline dvec3 leak_on_sphere(double along, double around, double radius) {
    double latitude = PI * along, longitude = 2 * PI * around;
    return (dvec3){radius * sin(latitude) * cos(longitude), -radius * cos(latitude),
                   radius * sin(latitude) * sin(longitude)};
}
static inline dvec3 leak_globe(double along, double around, rng *r) {
    (void)r;
    return leak_on_sphere(along, around, 2);
}
static inline dvec3 leak_rock(double along, double around, rng *r) {
    return leak_on_sphere(along, around, 1 + rng_unit(r));
}
static inline dvec3 leak_center(double along) {
    (void)along;
    return (dvec3){0, 0, 0};
}
/* Long and thin triangles: 3,000 around, of 2 mm by 180 m, to either pole 10 m. */
static inline dvec3 leak_needle(double along, double around, rng *r) {
    (void)r;
    double y = along <= 0 ? -100 : along >= 1 ? 100 : along < 0.5 ? -90 : 90;
    double radius = along <= 0 || along >= 1 ? 0 : 1;
    return (dvec3){radius * cos(2 * PI * around), y, radius * sin(2 * PI * around)};
}
static inline dvec3 leak_needle_middle(double along) { return (dvec3){0, 160 * along - 80, 0}; }
/* A bumpy tube along a trefoil, which lies on a torus of radii 2 and 1. */
static inline dvec3 leak_knot_middle(double along) {
    double a = 2 * PI * 2 * along, b = 2 * PI * 3 * along, ring = 2 + cos(b);
    return (dvec3){ring * cos(a), sin(b), ring * sin(a)};
}
static inline dvec3 leak_knot(double along, double around, rng *r) {
    double a = 2 * PI * 2 * along, b = 2 * PI * 3 * along, radius = 0.2 + 0.1 * rng_unit(r);
    dvec3 n = {cos(b) * cos(a), sin(b), cos(b) * sin(a)};
    dvec3 next = leak_knot_middle(along + 1e-4), last = leak_knot_middle(along - 1e-4);
    dvec3 side = dvec3_cross(n, dvec3_normalize(dvec3_sub(next, last)));
    dvec3 out = dvec3_add(dvec3_scale(n, radius * cos(2 * PI * around)),
                          dvec3_scale(side, radius * sin(2 * PI * around)));
    return dvec3_add(leak_knot_middle(along), out);
}

static const leak_mesh_type leak_mesh_types[] = {
    {"globe", 199, 200, true, 4, 1.8, 16, leak_globe, leak_center, false},
    {"rock", 150, 250, true, 4, 0.8, 16, leak_rock, leak_center, true},
    {"needle", 2, 3000, true, 200, 0.5, 14, leak_needle, leak_needle_middle, false},
    {"knot", 900, 40, false, 6, 0.12, 16, leak_knot, leak_knot_middle, true},
};
enum { LEAK_MESHES = sizeof leak_mesh_types / sizeof leak_mesh_types[0] };

/* ---- where they are ---- */

/* Vertices are rounded to float where they are, so that far from the origin they lie on a coarse grid
 * and many triangles are flat or have no area; or a transform brings the mesh there. */
typedef enum leak_place {
    LEAK_NEAR,
    LEAK_AWAY, /* 2^7 sizes from the origin */
    LEAK_FAR,  /* 2^14 sizes, or 2^16 */
    LEAK_INSTANCE,
    LEAK_FAR_INSTANCE, /* 2^14 sizes */
    LEAK_PLACES
} leak_place;
static const char *const leak_place_names[] = {"at the origin", "2^7 sizes away",
                                               "as far as can be", "turned", "turned, 2^14 away"};

/* Turned, sheared and mirrored. */
static const transform leak_turn = {
    {{1.3f, -0.4f, 0.2f, 0}, {0.7f, 0.9f, -0.1f, 0}, {0.3f, 0.2f, -1.1f, 0}}};
static const dvec3 leak_direction = {0.55, 0.05, -0.83};

typedef struct leak_case {
    const leak_mesh_type *type;
    leak_place place;
    mesh_desc mesh;
    vec3 *positions;
    uint32_t *indices;
    dvec3 at;           /* where the mesh's middle is, in its own space */
    transform to_world; /* the identity where there is no instance */
    accel *accel;
} leak_case;

/* `count` + 1 places from 0 to 1; uneven: some gaps a hundred times those of others. */
static inline void leak_spacing(double *out, uint32_t count, bool uneven, rng *r) {
    out[0] = 0;
    for (uint32_t i = 0; i < count; i++) {
        double u = rng_unit(r);
        out[i + 1] = out[i] + (uneven ? u * u * u + 0.01 : 1);
    }
    for (uint32_t i = 1; i < count; i++) out[i] /= out[count];
    out[count] = 1;
}

static inline vec3 leak_rounded(const leak_case *c, dvec3 p) {
    return vec3_from(dvec3_add(c->at, p));
}

static inline void leak_add_triangle(leak_case *c, uint32_t i, uint32_t j, uint32_t k) {
    uint32_t corners[3] = {i, j, k};
    memcpy(c->indices + c->mesh.indices_count, corners, sizeof corners);
    c->mesh.indices_count += 3;
}

static inline void leak_connect(leak_case *c) {
    uint32_t rows = c->type->rows, columns = c->type->columns;
    uint32_t first = columns * rows, last = first + 1;
    for (uint32_t j = 0; j < rows; j++) {
        uint32_t k = (j + 1) % rows, end = (columns - 1) * rows;
        if (c->type->poles) {
            leak_add_triangle(c, first, j, k);
            leak_add_triangle(c, last, end + k, end + j);
        }
        for (uint32_t i = 0; i + (c->type->poles ? 1 : 0) < columns; i++) {
            uint32_t here = i * rows, next = (i + 1) % columns * rows;
            leak_add_triangle(c, here + j, next + j, here + k);
            leak_add_triangle(c, here + k, next + j, next + k);
        }
    }
}

static inline bool leak_fill(leak_case *c) {
    const leak_mesh_type *type = c->type;
    uint32_t rows = type->rows, columns = type->columns, gaps = columns + (type->poles ? 1 : 0);
    double *along = calloc(gaps + 1, sizeof *along), *around = calloc(rows + 1, sizeof *around);
    size_t vertices = (size_t)columns * rows + (type->poles ? 2 : 0);
    c->positions = calloc(vertices, sizeof *c->positions);
    c->indices = calloc(6 * (size_t)gaps * rows, sizeof *c->indices);
    bool ok = along && around && c->positions && c->indices;
    rng r = {7};
    if (ok) leak_spacing(along, gaps, type->uneven, &r);
    for (uint32_t i = 0; ok && i < columns; i++) {
        if (i == 0 || (type->uneven && type->poles)) leak_spacing(around, rows, type->uneven, &r);
        for (uint32_t j = 0; j < rows; j++)
            c->positions[i * rows + j] =
                leak_rounded(c, type->vertex(along[i + (type->poles ? 1 : 0)], around[j], &r));
    }
    if (ok && type->poles) {
        c->positions[vertices - 2] = leak_rounded(c, type->vertex(0, 0, &r));
        c->positions[vertices - 1] = leak_rounded(c, type->vertex(1, 0, &r));
    }
    if (ok) leak_connect(c);
    c->mesh.positions = c->positions;
    c->mesh.positions_count = vertices;
    c->mesh.indices = c->indices;
    free(along);
    free(around);
    return ok;
}

static inline void leak_case_clear(leak_case *c) {
    accel_destroy(c->accel);
    free(c->positions);
    free(c->indices);
    *c = (leak_case){0};
}

/* The mesh and its tree. pool: may be NULL. Clear with leak_case_clear, also after false: no memory. */
static inline bool leak_case_make(leak_case *c, const leak_mesh_type *type, leak_place place,
                                  thread_pool *pool) {
    *c = (leak_case){.type = type, .place = place, .to_world = transform_identity()};
    int power = place == LEAK_FAR ? type->far : place == LEAK_AWAY ? 7 : -1;
    if (power >= 0) c->at = dvec3_scale(leak_direction, ldexp(type->size, power));
    if (place == LEAK_INSTANCE || place == LEAK_FAR_INSTANCE) c->to_world = leak_turn;
    dvec3 shift = dvec3_scale(leak_direction, ldexp(type->size, 14));
    if (place == LEAK_FAR_INSTANCE) {
        c->to_world.m[0][3] = (float)shift.x;
        c->to_world.m[1][3] = (float)shift.y;
        c->to_world.m[2][3] = (float)shift.z;
    }
    if (!leak_fill(c)) return false;
    accel_geometry geometry = {.type = &primitive_mesh, .desc = &c->mesh};
    accel_instance instance = {.mask = ~0u,
                               .identity = place < LEAK_INSTANCE,
                               .to_world = c->to_world,
                               .to_local = transform_identity()};
    if (!instance.identity && !transform_inverse(&c->to_world, &instance.to_local)) return false;
    accel_input input = {&geometry, 1, &instance, 1};
    accel_options options = {0};
    return accel_build(&input, &options, pool, &c->accel) == SNELL_OK;
}

/* ---- rays ---- */

typedef enum leak_aim {
    LEAK_ANYWHERE,
    LEAK_EDGE_MIDDLE,
    LEAK_EDGE,
    LEAK_VERTEX,
    LEAK_AIMS
} leak_aim;
static const char *const leak_aim_names[] = {"random points", "middles of edges", "shared edges",
                                             "shared vertices"};

/* In the mesh's own space. */
static inline dvec3 leak_target(const leak_case *c, leak_aim at, rng *r) {
    uint32_t triangle = rng_below(r, (uint32_t)mesh_triangle_count(&c->mesh));
    const uint32_t *index = c->indices + 3 * (size_t)triangle;
    uint32_t corner = rng_below(r, 3);
    dvec3 p = dvec3_from(c->positions[index[corner]]);
    dvec3 q = dvec3_from(c->positions[index[(corner + 1) % 3]]);
    dvec3 s = dvec3_from(c->positions[index[(corner + 2) % 3]]);
    double u = 0, v = 0;
    if (at == LEAK_EDGE_MIDDLE) u = 0.5;
    if (at == LEAK_EDGE) u = rng_unit(r);
    if (at == LEAK_ANYWHERE) {
        u = rng_unit(r);
        v = (1 - u) * rng_unit(r);
    }
    return dvec3_add(dvec3_scale(p, 1 - u - v), dvec3_add(dvec3_scale(q, u), dvec3_scale(s, v)));
}

static inline ray leak_ray(const leak_case *c, leak_aim at, rng *r) {
    dvec3 target = transform_point(&c->to_world, leak_target(c, at, r)), offset;
    do {
        offset = dvec3_from(rng_vec3(r, c->type->room));
    } while (dvec3_length(offset) > c->type->room);
    dvec3 middle = dvec3_add(c->at, c->type->middle(rng_unit(r)));
    vec3 o = vec3_from(transform_point(&c->to_world, dvec3_add(middle, offset)));
    return ray_make(o, vec3_from(dvec3_sub(target, dvec3_from(o))), 0, INFINITY);
}

/* How many of `count` rays leak: there is no nearest hit, or no hit at all is found. *example: one of
 * them, if any; may be NULL. Depends on the seed alone. */
static inline size_t leak_count(const leak_case *c, snell_isa isa, leak_aim at, uint64_t seed,
                                size_t count, ray *example) {
    enum { BATCH = 500 };
    ray rays[BATCH];
    hit hits[BATCH];
    uint8_t blocked[BATCH];
    rng r = {seed};
    size_t leaks = 0;
    for (size_t done = 0; done < count; done += BATCH) {
        size_t n = count - done < BATCH ? count - done : BATCH;
        for (size_t i = 0; i < n; i++) rays[i] = leak_ray(c, at, &r);
        accel_trace(c->accel, isa, rays, hits, n, NULL);
        accel_occluded(c->accel, isa, rays, blocked, n, NULL);
        for (size_t i = 0; i < n; i++) {
            if (hits[i].instance != NO_ID && blocked[i]) continue;
            leaks++;
            if (example) *example = rays[i];
        }
    }
    return leaks;
}

#endif
