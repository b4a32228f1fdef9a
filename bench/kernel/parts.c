#include "parts.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "scene/description.h"
#include "textures/texture.h"

void bench_die(const char *what) {
    fprintf(stderr, "bench-kernel: %s\n", what);
    exit(1);
}

void *bench_need(void *memory) {
    if (memory == NULL) bench_die("out of memory");
    return memory;
}

uint32_t bench_add_vertex(bench_scene *s, dvec3 p) {
    if (!ARRAY_GROW(s->positions, s->position_count, s->position_capacity, 1) ||
        s->position_count >= UINT32_MAX)
        bench_die("out of memory");
    s->positions[s->position_count] = vec3_from(p);
    return (uint32_t)s->position_count++;
}

void bench_add_triangle(bench_scene *s, uint32_t a, uint32_t b, uint32_t c) {
    if (!ARRAY_GROW(s->indices, s->index_count, s->index_capacity, 3)) bench_die("out of memory");
    s->indices[s->index_count++] = a;
    s->indices[s->index_count++] = b;
    s->indices[s->index_count++] = c;
}

static void connect(bench_scene *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    bench_add_triangle(s, a, b, c);
    bench_add_triangle(s, a, c, d);
}

void bench_add_quad(bench_scene *s, dvec3 a, dvec3 b, dvec3 c, dvec3 d) {
    uint32_t first = bench_add_vertex(s, a);
    bench_add_vertex(s, b);
    bench_add_vertex(s, c);
    bench_add_vertex(s, d);
    connect(s, first, first + 1, first + 2, first + 3);
}

void bench_add_box(bench_scene *s, dvec3 low, dvec3 high) {
    uint32_t first = (uint32_t)s->position_count;
    for (int i = 0; i < 8; i++)
        bench_add_vertex(
            s, (dvec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
    static const uint8_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; f++)
        connect(s, first + faces[f][0], first + faces[f][1], first + faces[f][2],
                first + faces[f][3]);
}

void bench_add_sheet(bench_scene *s, uint32_t columns, uint32_t rows, bool closed,
                     bench_sheet *place, const void *user) {
    uint32_t first = (uint32_t)s->position_count, across = closed ? columns : columns + 1;
    for (uint32_t j = 0; j <= rows; j++)
        for (uint32_t i = 0; i < across; i++)
            bench_add_vertex(s, place(user, (double)i / columns, (double)j / rows));
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = first + j * across, b = (i + 1) % across;
            connect(s, a + i, a + b, a + across + b, a + across + i);
        }
}

/* One of the six faces: `axis` stands still at the index `side`, 0 or n. Points on a cube's edge are
 * the same three indices on both of its faces, so the same bits. */
static void add_face(bench_scene *s, uint32_t n, const double *place_of, uint32_t axis,
                     uint32_t side, bench_body *place, const void *user) {
    uint32_t first = (uint32_t)s->position_count, across = n + 1;
    for (uint32_t j = 0; j <= n; j++)
        for (uint32_t i = 0; i <= n; i++) {
            double p[3];
            p[axis] = place_of[side];
            p[(axis + 1) % 3] = place_of[i];
            p[(axis + 2) % 3] = place_of[j];
            bench_add_vertex(s, place(user, dvec3_normalize((dvec3){p[0], p[1], p[2]})));
        }
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t i = 0; i < n; i++) {
            uint32_t a = first + j * across + i;
            if (side)
                connect(s, a, a + 1, a + across + 1, a + across);
            else
                connect(s, a, a + across, a + across + 1, a + 1);
        }
}

void bench_add_body(bench_scene *s, uint32_t n, bench_body *place, const void *user) {
    double *place_of = bench_need(memory_resize(NULL, n + 1, sizeof *place_of));
    for (uint32_t i = 0; i <= n; i++) /* by angles, so that triangles are alike */
        place_of[i] = i == 0 ? -1 : i == n ? 1 : fn_tan(PI / 4 * (2.0 * i / n - 1));
    for (uint32_t axis = 0; axis < 3; axis++) {
        add_face(s, n, place_of, axis, 0, place, user);
        add_face(s, n, place_of, axis, n, place, user);
    }
    free(place_of);
}

void bench_add_tube(bench_scene *s, const bench_ring *rings, uint32_t count, uint32_t around) {
    dvec3 side = {0, 0, 0};
    uint32_t before = 0;
    for (uint32_t i = 0; i < count; i++) {
        dvec3 from = rings[i ? i - 1 : 0].center, to = rings[i + 1 < count ? i + 1 : i].center;
        dvec3 along = dvec3_normalize(dvec3_sub(to, from)), unused;
        if (i == 0) dvec3_frame(along, &side, &unused);
        /* carried along with as little turning as can be */
        side = dvec3_normalize(dvec3_sub(side, dvec3_scale(along, dvec3_dot(side, along))));
        dvec3 other = dvec3_cross(along, side);
        uint32_t first = (uint32_t)s->position_count, corners = rings[i].radius > 0 ? around : 1;
        for (uint32_t k = 0; k < corners; k++) {
            double turn = 2 * PI * k / around, r = rings[i].radius;
            dvec3 off = dvec3_add(dvec3_scale(side, r * fn_cos(turn)),
                                  dvec3_scale(other, r * fn_sin(turn)));
            bench_add_vertex(s, dvec3_add(rings[i].center, off));
        }
        for (uint32_t k = 0; i && k < around; k++) {
            uint32_t next = (k + 1) % around;
            if (corners == 1)
                bench_add_triangle(s, before + k, before + next, first);
            else
                connect(s, before + k, before + next, first + next, first + k);
        }
        before = first;
    }
}

typedef struct lathe {
    dvec3 at;
    const bench_profile *profile;
    uint32_t count, flutes;
} lathe;

static dvec3 lathe_point(const void *user, double u, double v) {
    const lathe *l = user;
    double along = v * (l->count - 1);
    uint32_t i = along < l->count - 2 ? (uint32_t)along : l->count - 2;
    const bench_profile *p = &l->profile[i];
    double radius = p[0].radius + (along - i) * (p[1].radius - p[0].radius);
    double height = p[0].height + (along - i) * (p[1].height - p[0].height), turn = 2 * PI * u;
    if (l->flutes) radius *= 1 - 0.06 * fabs(fn_sin(0.5 * l->flutes * turn));
    return dvec3_add(l->at, (dvec3){radius * fn_cos(turn), height, radius * fn_sin(turn)});
}

void bench_add_lathe(bench_scene *s, dvec3 at, const bench_profile *profile, uint32_t count,
                     uint32_t around, uint32_t flutes, double detail) {
    lathe l = {at, profile, count, flutes};
    bench_add_sheet(s, bench_steps(around, detail, 5), (count - 1) * bench_steps(1, detail, 1),
                    true, lathe_point, &l);
}

uint32_t bench_steps(uint32_t usual, double detail, uint32_t least) {
    double steps = floor(usual * sqrt(detail) + 0.5);
    return steps < least ? least : (uint32_t)steps;
}

/* ---- noise ---- */

/* The texture `noise`, of one octave, made once. */
static const texture *noise_texture(void) {
    static texture made;
    if (made.type) return &made;
    const type_info *info = type_find(CATEGORY_TEXTURE, "noise");
    void *desc = bench_need(memory_zeroed(1, info->desc_size));
    desc_init(info, desc);
    snell_param octaves = {.name = "octaves", .kind = SNELL_PARAM_INT, .value.i = 1};
    if (desc_set(info, desc, &octaves)) bench_die(error_last()->text);
    made = texture_make((const texture_type *)(const void *)info, desc);
    return &made;
}

double bench_noise(dvec3 p) {
    const texture *t = noise_texture();
    texture_point at = {.local = p};
    return 2 * t->type->evaluate(t, &at).color.x - 1;
}

double bench_noise_sum(dvec3 p, uint32_t octaves, double gain, bool ridged) {
    double sum = 0, weight = 1;
    for (uint32_t i = 0; i < octaves; i++) {
        double n = bench_noise(p);
        sum += weight * (ridged ? 1 - 2 * fabs(n) : n);
        weight *= gain;
        /* moved, so that the lattices of the octaves, where noise is 0, do not meet */
        p = dvec3_add(dvec3_scale(p, 2), (dvec3){0.37, 0.71, 0.13});
    }
    return sum;
}
