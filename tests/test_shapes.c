/* geometry: points drawn on shapes that shine, for every registered shape. What they are held against
 * is Crofton's formula: lines drawn uniformly through a ball of surface S around a surface of area A
 * meet it 2 A / S times on average, and where they do is uniform by area. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/error.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
#include "maths/functions.h"
#include "sampling/warp.h"

static uint64_t random_state;
static double uniform(void) { /* splitmix64 */
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}
static dvec3 direction(void) {
    double z = 2 * uniform() - 1, angle = 2 * PI * uniform(), ring = sqrt(1 - z * z);
    return (dvec3){ring * cos(angle), ring * sin(angle), z};
}

/* ---- examples of every shape, at a scale ---- */

typedef struct value {
    const char *type, *field;
    float x, y, z;
} value;
/* One value per row; what has one number only leaves y at NAN. */
static const value values[] = {
    {"sphere", "center", 1, 2, 3},
    {"sphere", "radius", 0.7f, NAN, 0},
    {"box", "min", -1, 0, 0.5f},
    {"box", "max", 1, 0.5f, 1.25f},
    {"disk", "center", 0.5f, 1, 0},
    {"disk", "normal", 1, 2, -1},
    {"disk", "radius", 1.5f, NAN, 0},
    {"quad", "corner", 1, 0, 0},
    {"quad", "u", 1, 0.5f, 0},
    {"quad", "v", 0, 1, 1},
    {"cylinder", "from", 0, 0, 0},
    {"cylinder", "to", 1, 0.5f, 0.5f},
    {"cylinder", "radius", 0.4f, NAN, 0},
    {"cone", "from", 1, 0, 0},
    {"cone", "to", 1, 1, 0.5f},
    {"cone", "radius", 0.8f, NAN, 0},
    {"torus", "center", 0, 1, 0},
    {"torus", "axis", 1, 1, 0},
    {"torus", "major", 1, NAN, 0},
    {"torus", "minor", 0.6f, NAN, 0},
    {"capsule", "from", 0, 0, 0},
    {"capsule", "to", 1, 0.5f, 0.5f},
    {"capsule", "radius", 0.4f, NAN, 0},
    {"ellipsoid", "center", 1, 2, 3},
    {"ellipsoid", "radii", 0.7f, 0.4f, 1.2f},
    {"quadric", "min", -1, -0.8f, -1},
    {"quadric", "max", 1, 1, 0.9f},
    {"superellipsoid", "center", 1, 2, 3},
    {"superellipsoid", "radii", 0.7f, 0.5f, 1.1f},
};
/* These do not grow with the scale. */
static const value shares[] = {
    {"quadric", "square", 4, -1, 4}, /* scaled in `example` */
    {"superellipsoid", "e1", 0.4f, NAN, 0},
    {"superellipsoid", "e2", 1.3f, NAN, 0},
};
/* A second example differs from the first one in this. */
static const value seconds[] = {
    {"disk", "inner_radius", 0.9f, NAN, 0},
    {"quad", "v", -0.5f, 1, 0.75f}, /* a rectangle */
    {"cylinder", "capped", 0, NAN, 0},
    {"cone", "radius_to", 0.3f, NAN, 0},
    {"torus", "minor", 0.05f, NAN, 0},
    {"ellipsoid", "radii", 1, 0.1f, 0.02f},
    {"superellipsoid", "radii", 1.2f, 0.3f, 0.3f},
};
static const vec2 goblet[] = {{0, 0},    {0.5f, 0}, {0.5f, 0.1f}, {0.1f, 0.2f},
                              {0.1f, 1}, {0.6f, 2}, {0.5f, 2},    {0, 1.25f}};
#define GOBLET_COUNT (sizeof goblet / sizeof goblet[0])

typedef union any_desc {
    size_t struct_size;
    char room[256];
    struct {
        size_t struct_size;
        const vec2 *profile;
        size_t profile_count;
    } lathe;
} any_desc;

static void set(const primitive_type *type, void *desc, const value *v, double scale) {
    const field *f = type_find_field(&type->info, v->field);
    assert_non_null(f);
    snell_param param = {.name = v->field, .kind = SNELL_PARAM_FLOAT, .value.f = v->x * scale};
    if (f->kind == FIELD_VEC3) {
        param.kind = SNELL_PARAM_VEC3;
        param.value.v = vec3_from(dvec3_scale((dvec3){v->x, v->y, v->z}, scale));
    } else if (f->kind == FIELD_BOOL) {
        param.kind = SNELL_PARAM_BOOL;
        param.value.b = v->x > 0;
    }
    assert_int_equal(desc_set(&type->info, desc, &param), SNELL_OK);
}

static void example(const primitive_type *type, bool second, double scale, any_desc *desc) {
    static vec2 profile[GOBLET_COUNT];
    assert_true(type->info.desc_size <= sizeof *desc);
    desc_init(&type->info, desc);
    long given = 0;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        if (strcmp(values[i].type, type->info.name) != 0) continue;
        set(type, desc, &values[i], scale);
        given++;
    }
    for (size_t i = 0; second && i < sizeof seconds / sizeof seconds[0]; i++)
        if (strcmp(seconds[i].type, type->info.name) == 0) set(type, desc, &seconds[i], scale);
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; i++)
        if (strcmp(shares[i].type, type->info.name) == 0) set(type, desc, &shares[i], 1);
    if (strcmp(type->info.name, "quadric") == 0) { /* a hyperboloid of one sheet, or two */
        value constant = {"quadric", "constant", second ? 0.1f : -0.5f, NAN, 0};
        set(type, desc, &constant, scale * scale);
    }
    if (strcmp(type->info.name, "lathe") == 0) {
        for (size_t i = 0; i < GOBLET_COUNT; i++) {
            profile[i].x = (float)(goblet[i].x * scale);
            profile[i].y = (float)(goblet[i].y * scale);
        }
        desc->lathe.profile = profile;
        desc->lathe.profile_count = GOBLET_COUNT - (second ? 2 : 0);
        given++;
    }
    if (given == 0) fail_msg("no example here of the shape '%s'", type->info.name);
    assert_int_equal(desc_check(&type->info, desc, NULL), SNELL_OK);
    if (type->check) assert_int_equal(type->check(desc), SNELL_OK);
}

/* Shapes of many parts: test_curves.c, test_heightfield.c, test_patch.c. */
static bool has_examples(const primitive_type *type) {
    return type->area && !type->primitive_count;
}

/* ---- lines ---- */

typedef struct ball {
    dvec3 center;
    double radius;
} ball;

static ball ball_around(const primitive_type *type, const void *desc) {
    bounds3 box = type->bounds(desc);
    dvec3 low = dvec3_from(box.min), high = dvec3_from(box.max);
    dvec3 half = dvec3_scale(dvec3_sub(high, low), 0.5);
    return (ball){dvec3_add(low, half), dvec3_length(half) * 1.01};
}

/* Uniform over the lines that meet the ball: a direction, and a point of the disk across it. */
static local_ray random_line(const ball *around) {
    dvec3 d = direction(), x, y;
    dvec3_frame(d, &x, &y);
    double distance = around->radius * sqrt(uniform()), angle = 2 * PI * uniform();
    dvec3 at =
        dvec3_add(dvec3_scale(x, distance * cos(angle)), dvec3_scale(y, distance * sin(angle)));
    dvec3 o = dvec3_sub(dvec3_add(around->center, at), dvec3_scale(d, 2 * around->radius));
    return (local_ray){vec3_from(o), vec3_from(d), 0, INFINITY};
}

static const double scales[] = {1e-3, 1, 1e3};
#define SCALES 3

static void areas_agree_with_crossing_lines(void **state) {
    (void)state;
    enum { LINES = 100000 };
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!has_examples(type)) continue;
        random_state = 17 + i;
        for (int n = 0; n < 2 * SCALES; n++) {
            any_desc desc;
            example(type, n & 1, scales[n / 2], &desc);
            ball around = ball_around(type, &desc);
            double sum = 0, squares = 0;
            for (int k = 0; k < LINES; k++) {
                local_ray beam = random_line(&around);
                hit found;
                int count = 0;
                while (type->intersect(&desc, &beam, &found)) {
                    count++;
                    beam.t_min = found.t;
                }
                sum += count;
                squares += count * count;
            }
            double mean = sum / LINES, deviation = sqrt((squares / LINES - mean * mean) / LINES);
            double ball_area = 4 * PI * around.radius * around.radius;
            double area = mean * ball_area / 2, error = deviation * ball_area / 2;
            double claimed = type->area(&desc, 0);
            if (!(fabs(claimed - area) < 4 * error))
                fail_msg("%s: area %g, but lines say %g +- %g", type->info.name, claimed, area,
                         error);
        }
    }
}

static void fit(const primitive_type *type, any_desc *desc, const value *given, int count) {
    desc_init(&type->info, desc);
    for (int i = 0; i < count; i++) set(type, desc, &given[i], 1);
}

/* Of the frusta that a profile sweeps. */
static double swept_area(const vec2 *profile, size_t count) {
    double sum = 0;
    for (size_t i = 0; i + 1 < count; i++) {
        double r0 = profile[i].x, r1 = profile[i + 1].x;
        sum += PI * (r0 + r1) * hypot(r1 - r0, (double)profile[i + 1].y - (double)profile[i].y);
    }
    return sum;
}

/* Every example by the formula of its shape, at every scale. */
static void examples_have_their_closed_forms(void **state) {
    (void)state;
    const double r = 0.4, h = sqrt(1.5), a = 0.8, b = 0.3, tall = sqrt(1.25);
    const struct {
        const char *type;
        double first, second; /* 0: below */
    } areas[] = {
        {"sphere", 4 * PI * 0.49, 4 * PI * 0.49},
        {"box", 5.75, 5.75},
        {"disk", 2.25 * PI, (2.25 - 0.81) * PI},
        {"quad", 1.5, sqrt(2.265625)},
        {"cylinder", 2 * PI * r * (h + r), 2 * PI * r * h},
        {"cone", PI * a * (hypot(a, tall) + a),
         PI * ((a + b) * hypot(a - b, tall) + a * a + b * b)},
        {"torus", 4 * PI * PI * 0.6, 4 * PI * PI * 0.05},
        {"capsule", 2 * PI * r * (h + 2 * r), 2 * PI * r * (h + 2 * r)},
        {"lathe", swept_area(goblet, GOBLET_COUNT), swept_area(goblet, GOBLET_COUNT - 2)},
        {"ellipsoid", 0, 0},
        {"superellipsoid", 0, 0},
        {"quadric", 0, 0},
    };
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!has_examples(type)) continue;
        size_t k = 0, count = sizeof areas / sizeof areas[0];
        while (k < count && strcmp(areas[k].type, type->info.name) != 0) k++;
        if (k == count) fail_msg("no area here of the shape '%s'", type->info.name);
        for (int n = 0; n < 8; n++) {
            const double sizes[] = {1e-3, 1, 1e3, 1e6};
            double expected = (n & 1 ? areas[k].second : areas[k].first), scale = sizes[n / 2];
            if (expected == 0) continue;
            any_desc desc;
            example(type, n & 1, scale, &desc);
            double area = type->area(&desc, 0) / (scale * scale);
            if (fabs(area - expected) > 1e-6 * expected)
                fail_msg("%s: area %.9g, not %.9g, at scale %g", type->info.name, area, expected,
                         scale);
        }
    }
}

static void areas_have_their_closed_forms(void **state) {
    (void)state;
    any_desc desc;
    const primitive_type *type = primitive_find("ellipsoid");
    const value round[] = {{"ellipsoid", "radii", 1.5f, 1.5f, 1.5f}};
    fit(type, &desc, round, 1);
    assert_true(fabs(type->area(&desc, 0) - 9 * PI) < 1e-13 * 9 * PI);
    /* Spheroids: 2 pi a^2 (1 + (1 - e^2) / e artanh e), flat; 2 pi a^2 (1 + c / (a e) asin e), long. */
    for (int i = 0; i < 40; i++) {
        double a = (double)(float)exp2(i - 20), expected;
        const value spheroid[] = {{"ellipsoid", "radii", 1, (float)a, 1}};
        fit(type, &desc, spheroid, 1);
        double e = sqrt(a < 1 ? 1 - a * a : 1 - 1 / (a * a));
        expected = 2 * PI * (a < 1 ? 1 + a * a / e * atanh(e) : 1 + a / e * asin(e));
        if (e == 0) continue;
        if (e < 1 && fabs(type->area(&desc, 0) - expected) > 1e-11 * expected)
            fail_msg("ellipsoid of 1 and %g: %.15g, not %.15g", a, type->area(&desc, 0), expected);
    }
    const value stretched[] = {{"ellipsoid", "radii", 0.7f, 0.4f, 1.2f}};
    fit(type, &desc, stretched, 1);
    double ellipsoid = type->area(&desc, 0);
    type = primitive_find("superellipsoid");
    value super[] = {{"superellipsoid", "radii", 0.7f, 0.4f, 1.2f},
                     {"superellipsoid", "e1", 1, NAN, 0},
                     {"superellipsoid", "e2", 1, NAN, 0}};
    fit(type, &desc, super, 1);
    assert_true(fabs(type->area(&desc, 0) - ellipsoid) < 1e-7 * ellipsoid);
    super[1].x = super[2].x = 2; /* an octahedron: eight triangles */
    fit(type, &desc, super, 3);
    double x = 0.7, y = 0.4, z = 1.2;
    double octahedron = 4 * sqrt(x * x * y * y + y * y * z * z + z * z * x * x);
    assert_true(fabs(type->area(&desc, 0) - octahedron) < 1e-5 * octahedron);
    super[1].x = super[2].x = 0.015625f; /* nearly its box */
    fit(type, &desc, super, 3);
    double box = 8 * (x * y + y * z + z * x);
    assert_true(fabs(type->area(&desc, 0) - box) < 0.02 * box);
    super[1].x = 1; /* nearly a cylinder */
    super[0].z = super[0].x;
    fit(type, &desc, super, 3);
    double cylinder = 2 * PI * x * x + 2 * PI * x * 2 * y;
    assert_true(fabs(type->area(&desc, 0) - cylinder) < 0.02 * cylinder);
    type = primitive_find("quadric");
    const value globe[] = {{"quadric", "square", 1, 1, 1}, {"quadric", "constant", -0.64f, NAN, 0}};
    fit(type, &desc, globe, 2);
    assert_true(fabs(type->area(&desc, 0) - 4 * PI * 0.64) < 2e-4 * 4 * PI * 0.64);
    const value tube[] = {{"quadric", "square", 1, 0, 1}, {"quadric", "constant", -0.25f, NAN, 0}};
    fit(type, &desc, tube, 2);
    assert_true(fabs(type->area(&desc, 0) - 2 * PI) < 2e-3 * 2 * PI);
}

/* Which cell of a 4 x 4 x 4 grid in the ball's box, and which side of two planes the normal is on. */
enum { CELLS = 64 * 4 };
static int cell_of(const ball *around, const surface *s) {
    dvec3 f = dvec3_scale(dvec3_sub(s->p, around->center), 1 / around->radius);
    const double at[3] = {f.x, f.y, f.z};
    int cell = 0;
    for (int i = 0; i < 3; i++) cell = 4 * cell + (int)(4 * clamp01(at[i] / 2 + 0.5) * 0.999999);
    return 4 * cell + 2 * (s->n.x + 0.3 * s->n.z > 0.1) + (s->n.y - 0.2 * s->n.x > 0.1);
}

static void count_crossings(const primitive_type *type, const void *desc, const ball *around,
                            double counts[CELLS], int lines) {
    for (int k = 0; k < lines; k++) {
        local_ray beam = random_line(around);
        hit found;
        /* One hit of a line at most, each with the same chance: hits of one line are not independent. */
        int wanted = (int)(6 * uniform()), at = 0;
        bool met = type->intersect(desc, &beam, &found);
        for (; met && at < wanted; at++) {
            beam.t_min = found.t;
            met = type->intersect(desc, &beam, &found);
        }
        assert_true(at < 6 || !met);
        if (!met) continue;
        surface s;
        type->surface(desc, &beam, &found, &s);
        counts[cell_of(around, &s)]++;
    }
}

/* Two samples of one distribution: sum of (a sqrt(B/A) - b sqrt(A/B))^2 / (a + b), which is about
 * chi-square distributed. */
static void assert_same(const char *name, const double a[CELLS], const double b[CELLS]) {
    double all_a = 0, all_b = 0, square = 0;
    int cells = 0;
    for (int i = 0; i < CELLS; i++) {
        all_a += a[i];
        all_b += b[i];
    }
    double ratio = sqrt(all_b / all_a);
    assert_true(all_a > 5000 && all_b > 5000);
    for (int i = 0; i < CELLS; i++) {
        if (a[i] + b[i] == 0) continue;
        double difference = a[i] * ratio - b[i] / ratio;
        square += difference * difference / (a[i] + b[i]);
        cells++;
    }
    if (!(square < cells - 1 + 5 * sqrt(2.0 * cells)))
        fail_msg("%s: chi-square %g over %d cells", name, square, cells);
}

static void drawn_points_are_uniform_by_area(void **state) {
    (void)state;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!has_examples(type)) continue;
        random_state = 170 + i;
        for (int n = 0; n < 2 * SCALES; n++) {
            any_desc desc;
            example(type, n & 1, scales[n / 2], &desc);
            ball around = ball_around(type, &desc);
            double drawn[CELLS] = {0}, crossed[CELLS] = {0};
            for (int k = 0; k < 40000; k++) {
                double u = uniform(), v = uniform();
                surface s;
                type->sample_area(&desc, 0, u, v, &s);
                drawn[cell_of(&around, &s)]++;
            }
            count_crossings(type, &desc, &around, crossed, 400000);
            assert_same(type->info.name, drawn, crossed);
        }
    }
}

/* A ray onto a drawn point meets the shape there, and says the same about it. */
static void drawn_points_lie_on_the_surface(void **state) {
    (void)state;
    const double edges[] = {0, 0.5, 1 - 0x1p-53};
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!has_examples(type)) continue;
        random_state = 99 + i;
        long met = 0;
        for (int n = 0; n < 6000; n++) {
            any_desc desc;
            double scale = scales[n % SCALES];
            example(type, n / 3 % 2, scale, &desc);
            double u = uniform(), v = uniform();
            bool edge = n < 54;
            if (edge) u = edges[n / 6 % 3], v = edges[n / 18 % 3];
            surface s, seen;
            type->sample_area(&desc, 0, u, v, &s);
            assert_true(isfinite(s.p.x + s.p.y + s.p.z) && s.error >= 0);
            assert_true(fabs(dvec3_length(s.n) - 1) < 1e-12 && dvec3_dot(s.n, s.ns) > 0);
            double height = 0.01 * scale;
            dvec3 o = dvec3_add(s.p, dvec3_scale(s.n, height));
            local_ray beam = {vec3_from(o), vec3_from(dvec3_negate(s.n)), 0, INFINITY};
            hit found;
            if (!type->intersect(&desc, &beam, &found)) continue; /* beside an edge, by rounding */
            type->surface(&desc, &beam, &found, &seen);
            if (fabs((double)found.t - height) > 1e-3 * height)
                continue; /* so that is not the point */
            met++;
            assert_true(dvec3_length(dvec3_sub(s.p, seen.p)) < 2e-6 * scale);
            if (dvec3_dot(s.n, seen.n) < 0.999) continue; /* at a tip or a corner */
            if (type->parametrise) {
                type->parametrise(&desc, &s);
                type->parametrise(&desc, &seen);
            }
            double across = fabs(s.u - seen.u);
            if (edge) continue; /* on a seam, or a corner, where they may differ */
            assert_true(fabs(s.v - seen.v) < 1e-3 || fabs(s.v - seen.v) > 1 - 1e-3);
            double ring = dvec3_length(s.dpdu),
                   around = 1e-3 * scale / double_max(ring, 1e-9 * scale);
            assert_true(across < 1e-3 + around || across > 1 - 1e-3 - around);
        }
        if (met < 5900) fail_msg("%s: only %ld of 6000 points were met", type->info.name, met);
    }
}

static void the_middle_of_the_square_is_the_middle(void **state) {
    (void)state;
    any_desc desc;
    surface s;
    const primitive_type *type = primitive_find("disk");
    example(type, false, 1, &desc);
    type->sample_area(&desc, 0, 0.5, 0.5, &s);
    assert_true(s.p.x == 0.5 && s.p.y == 1 && s.p.z == 0);
    type = primitive_find("quad");
    example(type, false, 1, &desc);
    type->sample_area(&desc, 0, 0.5, 0.5, &s);
    assert_true(s.p.x == 1.5 && s.p.y == 0.75 && s.p.z == 0.5);
    assert_null(primitive_find("plane")->area);
}

static void a_triangle_is_drawn_evenly(void **state) {
    (void)state;
    const vec3 corners[] = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3, 5}};
    const uint32_t indices[] = {0, 1, 3, 0, 1, 2, 1, 1, 2};
    mesh_desc mesh = {
        .positions = corners, .positions_count = 4, .indices = indices, .indices_count = 9};
    const primitive_type *type = primitive_find("mesh");
    assert_true(fabs(type->area(&mesh, 1) - 3) < 1e-12 && type->area(&mesh, 2) == 0);
    assert_true(fabs(type->area(&mesh, 0) - sqrt(34.0)) < 1e-12);
    double counts[16] = {0}, square = 0;
    random_state = 5;
    enum { POINTS = 64000 };
    for (int n = 0; n < POINTS; n++) {
        double u = uniform(), v = uniform();
        surface s;
        type->sample_area(&mesh, 1, u, v, &s);
        double x = s.p.x / 2,
               y = s.p.y / 3; /* 4 x 4 cells, folded: the half square has 16 halves */
        assert_true(x >= 0 && y >= 0 && x + y < 1 + 1e-12 && s.n.z == 1);
        int column = (int)(4 * x), row = (int)(4 * y);
        bool upper = 4 * x - column + 4 * y - row > 1;
        if (upper) { /* the same triangle, seen from the opposite corner */
            column = 3 - column;
            row = 3 - row;
        }
        counts[4 * row + column]++;
    }
    for (int i = 0; i < 16; i++) {
        double expected = POINTS / 16.0, off = counts[i] - expected;
        square += off * off / expected;
    }
    assert_true(square < 15 + 5 * sqrt(30.0));
}

/* ---- by solid angle ---- */

/* The density over the directions that meet the shape is 1 in all: drawn by area, each point weighs
 * area cos / distance^2 where it is the first to be seen. And the mean point is the same by both. */
static void check_density(const primitive_type *type, const void *desc, dvec3 from, ball around) {
    enum { POINTS = 20000 };
    double sum[5] = {0}, squares[5] = {0}, area = type->area(desc, 0);
    for (int n = 0; n < 2 * POINTS; n++) {
        bool toward = n >= POINTS;
        double u = uniform(), v = uniform(), weight = -1, unused;
        surface s;
        if (toward) {
            assert_true(type->sample_toward(desc, from, u, v, &s, &unused));
        } else {
            type->sample_area(desc, 0, u, v, &s);
            dvec3 way = dvec3_sub(s.p, from), d = dvec3_normalize(way);
            double facing = dvec3_dot(s.n, d);
            if (!type->flat && facing > 0) continue; /* the far side: these shapes are convex */
            weight = area * fabs(facing) / dvec3_dot(way, way) * type->pdf_toward(desc, from, d);
        }
        dvec3 f = dvec3_scale(dvec3_sub(s.p, around.center), 1 / around.radius);
        const double terms[5] = {toward ? 0 : weight, weight * f.x, weight * f.y, weight * f.z,
                                 weight * f.x * f.y};
        for (int k = 0; k < 5; k++) {
            sum[k] += terms[k];
            squares[k] += terms[k] * terms[k];
        }
    }
    for (int k = 0; k < 5; k++) {
        double mean = sum[k] / POINTS, expected = k == 0;
        double error = sqrt(squares[k]) / POINTS;
        if (!(fabs(mean - expected) < 5 * error + 1e-6))
            fail_msg("%s: moment %d is %g off, +- %g", type->info.name, k, mean - expected, error);
    }
}

static void check_toward(const primitive_type *type, const void *desc, dvec3 from, double size) {
    double u = uniform(), v = uniform(), pdf = 0;
    surface s;
    bool drawn = type->sample_toward(desc, from, u, v, &s, &pdf);
    dvec3 way = dvec3_sub(s.p, from), d = dvec3_normalize(way);
    if (!drawn) return;
    assert_true(isfinite(pdf) && pdf > 0);
    double again = type->pdf_toward(desc, from, d);
    assert_true(fabs(again - pdf) < 1e-9 * pdf);
    local_ray beam = {vec3_from(from), vec3_from(d), 0, INFINITY};
    hit found;
    double distance = dvec3_length(way);
    if (distance > 100 * size || !type->intersect(desc, &beam, &found)) return; /* floats miss it */
    if (fabs(dvec3_dot(d, s.n)) < 0.01) return;
    assert_true(fabs((double)found.t - distance) < 1e-3 * size); /* nothing is in front of it */
}

static void directions_are_drawn_by_solid_angle(void **state) {
    (void)state;
    random_state = 21;
    int tested = 0, densities = 0;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!type->sample_toward) continue;
        tested++;
        for (int n = 0; n < 60; n++) {
            any_desc desc;
            double scale = scales[n % SCALES];
            example(type, true, scale, &desc);
            ball around = ball_around(type, &desc);
            double far = around.radius * exp2((type->flat ? 6 : 14) * uniform() - 0.005);
            if (type->flat && n % 4 == 0) far *= 0.2; /* near, beside or above it */
            dvec3 from = dvec3_add(around.center, dvec3_scale(direction(), far));
            surface middle;
            type->sample_area(&desc, 0, 0.5, 0.5, &middle);
            dvec3 d = dvec3_normalize(dvec3_sub(middle.p, from));
            if (type->pdf_toward(&desc, from, d) == 0) continue; /* too small: the area is used */
            densities++;
            check_density(type, &desc, from, around);
            for (int k = 0; k < 200; k++) check_toward(type, &desc, from, around.radius);
        }
    }
    assert_true(tested >= 2 && densities > 50 * tested);
}

static void a_sphere_fills_a_cone(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("sphere");
    any_desc desc;
    example(type, false, 1, &desc);
    const dvec3 center = {1, 2, 3};
    double r = (double)0.7f, pdf;
    surface s;
    for (int power = -42; power < 400;
         power += 7) { /* next to the surface, and far beyond floats */
        double distance = power < 0 ? r * (1 + exp2(power)) : r * exp2(power + 1.0);
        dvec3 d = {0.6, 0, -0.8}, from = dvec3_sub(center, dvec3_scale(d, distance));
        if (power < -15) { /* so close that its own points might be meant */
            assert_false(type->sample_toward(&desc, from, 0.5, 0.5, &s, &pdf));
            continue;
        }
        assert_true(type->sample_toward(&desc, from, 0.5, 0.5, &s, &pdf));
        assert_true(dvec3_dot(s.n, d) < -1 + 1e-9); /* the middle: the nearest point */
        dvec3 f = dvec3_sub(center, from);
        long double sine = r / sqrtl((long double)dvec3_dot(f, f));
        long double angle = 2 * (long double)PI * sine * sine / (1 + sqrtl(1 - sine * sine));
        assert_true(fabsl(1 / pdf - angle) < 1e-6L * angle);
    }
    const dvec3 inside = {1.1, 2, 3};
    assert_false(type->sample_toward(&desc, inside, 0.5, 0.5, &s, &pdf));
    assert_true(type->pdf_toward(&desc, inside, (dvec3){1, 0, 0}) == 0);
    assert_false(type->sample_toward(&desc, center, 0.5, 0.5, &s, &pdf));
    assert_true(type->pdf_toward(&desc, center, (dvec3){1, 0, 0}) == 0);
}

/* ---- coordinates, sides, bad values of what is turned ---- */

/* Neighbouring points differ by what the derivatives say. */
static void derivatives_agree_with_neighbours(void **state) {
    (void)state;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const primitive_type *type = primitive_types[i];
        if (!has_examples(type) || !type->parametrise) continue;
        random_state = 61 + i;
        long tested = 0, smooth = 0;
        for (int n = 0; n < 4000; n++) {
            any_desc desc;
            example(type, n & 1, 1, &desc);
            double u = uniform(), v = uniform();
            surface a, b;
            type->sample_area(&desc, 0, u, v, &a);
            type->sample_area(&desc, 0, u + 1e-6, v + 1e-6, &b);
            type->parametrise(&desc, &a);
            type->parametrise(&desc, &b);
            if (dvec3_length(a.dpdu) == 0) continue;
            smooth++;
            dvec3 step = dvec3_sub(b.p, a.p);
            dvec3 said = dvec3_add(dvec3_scale(a.dpdu, b.u - a.u), dvec3_scale(a.dpdv, b.v - a.v));
            if (fabs(b.u - a.u) > 0.1 || fabs(b.v - a.v) > 0.1) continue; /* a seam, another cap */
            if (dvec3_length(step) > 1e-3) continue; /* drawn by trial: one more or one less */
            if (dvec3_dot(a.n, b.n) < 0.9999 || dvec3_length(a.dpdu) < 0.05) continue;
            if (dvec3_length(a.dpdv) > 30)
                continue; /* the surface lies nearly along the lines of equal v */
            tested++;
            double off = dvec3_length(dvec3_sub(step, said)), moved = dvec3_length(step);
            /* The line of equal v through the point may bend as much as 2 pi / 0.05. */
            if (off > 1e-3 * moved + 130 * moved * moved)
                fail_msg("%s: a step of %g is %g off", type->info.name, moved, off);
            assert_true(fabs(dvec3_dot(a.dpdu, a.n)) < 1e-9);
            assert_true(fabs(dvec3_dot(a.dpdv, a.n)) < 1e-9);
        }
        if (smooth && tested < 400) fail_msg("%s: %ld tested", type->info.name, tested);
    }
}

static void lathe_of(any_desc *desc, const vec2 *profile, size_t count) {
    desc_init(&primitive_find("lathe")->info, desc);
    desc->lathe.profile = profile;
    desc->lathe.profile_count = count;
}

static surface look_at(const primitive_type *type, const void *desc, dvec3 from, dvec3 to) {
    local_ray beam = {vec3_from(from), vec3_from(dvec3_sub(to, from)), 0, INFINITY};
    hit found;
    assert_true(type->intersect(desc, &beam, &found));
    surface out;
    type->surface(desc, &beam, &found, &out);
    type->parametrise(desc, &out);
    return out;
}

static void assert_uv(const surface *s, double u, double v) {
    if (fabs(s->u - u) > 1e-6 || fabs(s->v - v) > 1e-6)
        fail_msg("uv is %g %g, not %g %g", s->u, s->v, u, v);
}

static void turned_shapes_have_the_coordinates_of_a_globe(void **state) {
    (void)state;
    const value upright[] = {{"cylinder", "from", 0, 0, 0}, {"cylinder", "to", 0, 2, 0}};
    const primitive_type *type = primitive_find("cylinder");
    any_desc desc;
    desc_init(&type->info, &desc);
    for (int i = 0; i < 2; i++) set(type, &desc, &upright[i], 1);
    surface s = look_at(type, &desc, (dvec3){0, 0.5, 5}, (dvec3){0, 0.5, 0});
    assert_uv(&s, 0.5, 0.25);
    s = look_at(type, &desc, (dvec3){5, 1.5, 0}, (dvec3){0, 1.5, 0});
    assert_uv(&s, 0.75, 0.75);
    s = look_at(type, &desc, (dvec3){0, 5, 0.5}, (dvec3){0, 1, 0.5}); /* the caps */
    assert_uv(&s, 0.5, 0.5);
    assert_true(s.n.y == 1);
    s = look_at(type, &desc, (dvec3){0, -5, 0.25}, (dvec3){0, 1, 0.25});
    assert_uv(&s, 0.5, 0.25);
    assert_true(s.n.y == -1);

    type = primitive_find("torus");
    desc_init(&type->info, &desc);
    s = look_at(type, &desc, (dvec3){0, 0, 5}, (dvec3){0, 0, 0});
    assert_uv(&s, 0.5, 0.5);
    s = look_at(type, &desc, (dvec3){1, 5, 0}, (dvec3){1, 0, 0});
    assert_uv(&s, 0.75, 0.75);

    const vec2 step[] = {{0, 0}, {1, 0}, {1, 2}, {0, 2}}; /* lengths 1, 2, 1 */
    type = primitive_find("lathe");
    lathe_of(&desc, step, 4);
    s = look_at(type, &desc, (dvec3){0, 1, 5}, (dvec3){0, 1, 0});
    assert_uv(&s, 0.5, 0.5);
    s = look_at(type, &desc, (dvec3){0.5, 5, 0}, (dvec3){0.5, 0, 0});
    assert_uv(&s, 0.75, 0.875);
}

static void a_lathe_is_solid_whichever_way_it_is_drawn(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("lathe");
    const vec2 up[] = {{0, 0}, {1, 0}, {1, 2}, {0, 2}}, down[] = {{0, 2}, {1, 2}, {1, 0}, {0, 0}};
    const vec2 ring[] = {{1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 0}};
    any_desc desc;
    for (int i = 0; i < 2; i++) {
        lathe_of(&desc, i ? down : up, 4);
        assert_int_equal(type->side(&desc, (dvec3){0.5, 1, 0.5}), 1);
        assert_int_equal(type->side(&desc, (dvec3){0.9, 1, 0.9}), -1);
        assert_int_equal(type->side(&desc, (dvec3){0, 2.5, 0}), -1);
        surface s = look_at(type, &desc, (dvec3){0, 1, 5}, (dvec3){0, 1, 0});
        assert_true(s.n.z == 1);
        s = look_at(type, &desc, (dvec3){0.5, 5, 0}, (dvec3){0.5, 0, 0});
        assert_true(s.n.y == 1);
    }
    lathe_of(&desc, ring, 5);
    assert_int_equal(type->side(&desc, (dvec3){0, 0.5, 1.5}), 1);
    assert_int_equal(type->side(&desc, (dvec3){0, 0.5, 0.5}), -1);
    assert_int_equal(type->side(&desc, (dvec3){0, 0.5, 2.5}), -1);
    lathe_of(&desc, ring, 4); /* open: encloses nothing */
    assert_int_equal(type->side(&desc, (dvec3){0, 0.5, 1.5}), -1);
    type = primitive_find("torus");
    desc_init(&type->info, &desc);
    assert_int_equal(type->side(&desc, (dvec3){0, 0.2, 1}), 1);
    assert_int_equal(type->side(&desc, (dvec3){0, 0, 0}), -1);
    type = primitive_find("cylinder");
    example(type, false, 1, &desc);
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.25, 0.25}), 1);
    example(type, true, 1, &desc); /* without caps */
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.25, 0.25}), -1);
}

/* A ball of 24 facets is shaded like a ball, poles and all. */
static void a_lathe_is_shaded_smoothly(void **state) {
    (void)state;
    vec2 profile[25];
    for (int i = 0; i <= 24; i++)
        profile[i] = (vec2){i % 24 ? (float)sin(PI * i / 24) : 0, (float)-cos(PI * i / 24)};
    const primitive_type *type = primitive_find("lathe");
    any_desc desc;
    random_state = 8;
    lathe_of(&desc, profile, 25);
    for (int n = 0; n < 2000; n++) {
        dvec3 d = direction();
        surface s = look_at(type, &desc, dvec3_scale(d, 3), (dvec3){0, 0, 0});
        assert_true(dvec3_dot(s.ns, d) > cos(0.4 * PI / 180));
        assert_true(dvec3_dot(s.n, d) > cos(4 * PI / 180));
    }
    const vec2 corner[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}; /* 90 degrees stay a corner */
    lathe_of(&desc, corner, 4);
    surface s = look_at(type, &desc, (dvec3){0, 0.999, 5}, (dvec3){0, 0.999, 0});
    assert_true(s.ns.z == 1);
}

/* Needles, hair-thin rings, nearly flat cones: a ray that leaves does not meet where it left. */
static void extreme_proportions_have_no_self_hits(void **state) {
    (void)state;
    const value extremes[][5] = {
        {{"cylinder", "from", 3, 1, 2},
         {"cylinder", "to", 40, 50, 60},
         {"cylinder", "radius", 0.01f, NAN, 0}},
        {{"cone", "from", 3, 1, 2},
         {"cone", "to", 3.00001f, 1.00001f, 2},
         {"cone", "radius", 1, NAN, 0}},
        {{"cone", "from", 3, 1, 2}, {"cone", "to", 40, 50, 60}, {"cone", "radius", 0.02f, NAN, 0}},
        {{"torus", "center", 3, 1, 2},
         {"torus", "axis", 1, 2, 3},
         {"torus", "minor", 1e-3f, NAN, 0}},
        {{"torus", "center", 3, 1, 2},
         {"torus", "axis", 1, 2, 3},
         {"torus", "minor", 0.9999f, NAN, 0}},
        {{"capsule", "from", 3, 1, 2},
         {"capsule", "to", 40, 50, 60},
         {"capsule", "radius", 0.01f, NAN, 0}},
        {{"capsule", "from", 3, 1, 2},
         {"capsule", "to", 3.00001f, 1, 2},
         {"capsule", "radius", 1, NAN, 0}},
        {{"ellipsoid", "center", 3, 1, 2}, {"ellipsoid", "radii", 30, 0.01f, 20}},
        {{"ellipsoid", "center", 3, 1, 2}, {"ellipsoid", "radii", 0.01f, 30, 0.02f}},
        {{"superellipsoid", "center", 3, 1, 2},
         {"superellipsoid", "radii", 30, 0.1f, 20},
         {"superellipsoid", "e1", 0.1f, NAN, 0},
         {"superellipsoid", "e2", 0.1f, NAN, 0}},
        {{"superellipsoid", "center", 3, 1, 2},
         {"superellipsoid", "radii", 1, 2, 1},
         {"superellipsoid", "e1", 0.015625f, NAN, 0},
         {"superellipsoid", "e2", 0.015625f, NAN, 0}},
    };
    random_state = 77;
    for (size_t i = 0; i < sizeof extremes / sizeof extremes[0]; i++) {
        const primitive_type *type = primitive_find(extremes[i][0].type);
        bool convex = strcmp(type->info.name, "torus") != 0;
        any_desc desc;
        desc_init(&type->info, &desc);
        for (int k = 0; k < 5 && extremes[i][k].type; k++) set(type, &desc, &extremes[i][k], 1);
        long met = 0, wrong = 0;
        for (int n = 0; n < 40000; n++) {
            double u = uniform(), v = uniform(), slope = n & 1 ? exp2(-40 * uniform()) : 1;
            surface s, again;
            type->sample_area(&desc, 0, u, v, &s);
            dvec3 d = direction();
            d = dvec3_sub(d, dvec3_scale(s.n, dvec3_dot(d, s.n) * (1 - slope)));
            local_ray beam = {{0, 0, 0}, vec3_from(d), 0, INFINITY};
            double side = dvec3_dot(s.n, dvec3_from(beam.d));
            if (side == 0) continue;
            beam.o = surface_offset_origin(&s, side);
            hit found;
            if (!type->intersect(&desc, &beam, &found)) continue;
            type->surface(&desc, &beam, &found, &again);
            met++;
            bool leaves = dvec3_dot(again.n, dvec3_from(beam.d)) > 0;
            bool sound = side > 0 ? !convex && !leaves : leaves;
            /* From inside, at a rim or where it is thinner than floats, it may start beyond. */
            wrong += !sound && side < 0;
            if (!sound && side > 0)
                fail_msg("%s %zu met itself: side %g, t %g", type->info.name, i, side,
                         (double)found.t);
        }
        assert_true(met > 15000);
        if (wrong > met / 200)
            fail_msg("%s %zu: %ld of %ld are wrong", type->info.name, i, wrong, met);
    }
}

static void refuse(const primitive_type *type, any_desc *desc, const char *text) {
    snell_status status = desc_check(&type->info, desc, NULL);
    if (!status) status = type->check(desc);
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, text);
}

static void senseless_shapes_are_refused(void **state) {
    (void)state;
    any_desc desc;
    const value bad[] = {{"cylinder", "to", 0, 0, 0},        {"cylinder", "radius", 0, NAN, 0},
                         {"cone", "radius", 0, NAN, 0},      {"cone", "to", 1, 0, 0},
                         {"torus", "minor", 1, NAN, 0},      {"torus", "minor", -1, NAN, 0},
                         {"cone", "radius_to", -1, NAN, 0},  {"torus", "axis", 0, 0, 0},
                         {"capsule", "to", 0, 0, 0},         {"quadric", "max", -1, 2, 2},
                         {"quadric", "square", 0, 0, 0},     {"superellipsoid", "e1", 0, NAN, 0},
                         {"superellipsoid", "e2", 3, NAN, 0}};
    const char *const texts[] = {
        "cylinder: 'from' and 'to' are the same point",
        "cylinder: 'radius' is 0; it must be greater than 0",
        "cone: 'radius' and 'radius_to' are both 0",
        "cone: 'from' and 'to' are the same point",
        "torus: 'minor' is 1; it must be less than 'major', 1",
        "torus: 'minor' is -1; it must be greater than 0",
        "cone: 'radius_to' is -1; it must be at least 0",
        "torus: 'axis' has no length",
        "capsule: 'from' and 'to' are the same point",
        "quadric: 'min' x is -1 and 'max' x is -1",
        "quadric: all of 'square', 'mixed' and 'linear' are 0",
        "superellipsoid: 'e1' is 0; it must be at least 0.015625 and at most 2",
        "superellipsoid: 'e2' is 3; it must be at least 0.015625 and at most 2"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        const primitive_type *type = primitive_find(bad[i].type);
        example(type, false, 1, &desc);
        set(type, &desc, &bad[i], 1);
        refuse(type, &desc, texts[i]);
    }
    static vec2 many[5000];
    many[0].x = 1;
    const vec2 negative[] = {{1, 0}, {-1, 1}}, line[] = {{0, 0}, {0, 1}},
               nan[] = {{1, 0}, {NAN, 1}};
    const primitive_type *type = primitive_find("lathe");
    lathe_of(&desc, NULL, 0);
    refuse(type, &desc, "lathe: 'profile' has 0 points; it must have 2 to 4096");
    lathe_of(&desc, negative, 1);
    refuse(type, &desc, "lathe: 'profile' has 1 points; it must have 2 to 4096");
    lathe_of(&desc, many, 5000);
    refuse(type, &desc, "lathe: 'profile' has 5000 points; it must have 2 to 4096");
    lathe_of(&desc, negative, 2);
    refuse(type, &desc, "lathe: the radius of point 2 of 'profile' is -1; it must be at least 0");
    lathe_of(&desc, line, 2);
    refuse(type, &desc, "lathe: 'profile' sweeps no surface");
    lathe_of(&desc, nan, 2);
    refuse(type, &desc, "lathe: 'profile' 1 is not a finite number");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_agree_with_crossing_lines),
        cmocka_unit_test(examples_have_their_closed_forms),
        cmocka_unit_test(areas_have_their_closed_forms),
        cmocka_unit_test(drawn_points_are_uniform_by_area),
        cmocka_unit_test(drawn_points_lie_on_the_surface),
        cmocka_unit_test(the_middle_of_the_square_is_the_middle),
        cmocka_unit_test(a_triangle_is_drawn_evenly),
        cmocka_unit_test(directions_are_drawn_by_solid_angle),
        cmocka_unit_test(a_sphere_fills_a_cone),
        cmocka_unit_test(derivatives_agree_with_neighbours),
        cmocka_unit_test(turned_shapes_have_the_coordinates_of_a_globe),
        cmocka_unit_test(a_lathe_is_solid_whichever_way_it_is_drawn),
        cmocka_unit_test(a_lathe_is_shaded_smoothly),
        cmocka_unit_test(extreme_proportions_have_no_self_hits),
        cmocka_unit_test(senseless_shapes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
