/* geometry/heightfield: against a slow solver that goes through all triangles; no leaks; area. */
#include "parts_test.h"

typedef struct heightfield_view { /* begins as heightfield_desc does */
    size_t struct_size;
    const float *heights;
    size_t heights_count;
    int32_t columns, rows;
    vec3 min, max;
    bool smooth;
} heightfield_view;

static wide post(const heightfield_view *v, int column, int row) {
    real x = (real)column / (v->columns - 1), z = (real)row / (v->rows - 1);
    real y = v->heights[row * v->columns + column];
    return (wide){v->min.x + ((real)v->max.x - v->min.x) * x,
                  v->min.y + ((real)v->max.y - v->min.y) * y,
                  v->min.z + ((real)v->max.z - v->min.z) * z};
}

static void corners_of(const heightfield_view *v, int triangle, wide out[3]) {
    int cell = triangle / 2, column = cell % (v->columns - 1), row = cell / (v->columns - 1);
    out[0] = post(v, column, row);
    out[1] = triangle & 1 ? post(v, column, row + 1) : post(v, column + 1, row + 1);
    out[2] = triangle & 1 ? post(v, column + 1, row + 1) : post(v, column + 1, row);
}

static int triangle_count(const heightfield_view *v) {
    return 2 * (v->columns - 1) * (v->rows - 1);
}

/* By the plane, and the areas around the point. What lies on an edge of two triangles is no hit or
 * miss of one of them, but of both: only the rim is uncertain, and what is seen edge-on. */
static int solve(const void *desc, wide o, wide d, root *roots) {
    const heightfield_view *v = desc;
    int count = 0;
    for (int i = 0; i < triangle_count(v); i++) {
        wide c[3];
        corners_of(v, i, c);
        wide n = wide_cross(wide_sub(c[1], c[0]), wide_sub(c[2], c[0]));
        real slope = wide_dot(n, d), area = wide_length(n), speed = wide_length(d);
        n = wide_scale(n, 1 / area);
        slope /= area;
        real size = wide_length(wide_sub(c[1], c[0])) + wide_length(wide_sub(c[2], c[0]));
        real t = wide_dot(n, wide_sub(c[0], o)) / slope;
        if (!(fabsl(slope) > 1e-12L * speed)) { /* edge-on: uncertain if the ray is that near */
            if (fabsl(wide_dot(n, wide_sub(c[0], o))) < 1e-6L * size)
                roots[count++] =
                    (root){wide_dot(wide_sub(c[0], o), d) / (speed * speed), 0, size / speed};
            continue;
        }
        wide p = wide_add(o, wide_scale(d, t));
        real least = 1;
        for (int k = 0; k < 3; k++) {
            wide a = wide_sub(c[(k + 1) % 3], p), b = wide_sub(c[(k + 2) % 3], p);
            real w = wide_dot(wide_cross(a, b), n) / area;
            least = w < least ? w : least;
        }
        /* Whose an edge is, and where a ray from afar meets what it grazes, is a matter of rounding. */
        real room = 1e-8L + 1e-15L * wide_length(wide_sub(c[0], o)) * speed / (fabsl(slope) * size);
        root made = {t, fabsl(least) < room ? 0 : least, 1e-12L * size / fabsl(slope)};
        if (least > -room && count < ROOTS_MAX) roots[count++] = made;
    }
    return count;
}

static real distance(const void *desc, wide p) {
    const heightfield_view *v = desc;
    real nearest = INFINITY;
    for (int i = 0; i < triangle_count(v); i++) {
        wide c[3];
        corners_of(v, i, c);
        wide n = wide_cross(wide_sub(c[1], c[0]), wide_sub(c[2], c[0]));
        n = wide_scale(n, 1 / wide_length(n));
        real away = wide_dot(wide_sub(p, c[0]), n);
        real low_x = fminl(fminl(c[0].x, c[1].x), c[2].x),
             high_x = fmaxl(fmaxl(c[0].x, c[1].x), c[2].x);
        real low_z = fminl(fminl(c[0].z, c[1].z), c[2].z),
             high_z = fmaxl(fmaxl(c[0].z, c[1].z), c[2].z);
        real slack = 1e-9L * (high_x - low_x + high_z - low_z);
        if (p.x < low_x - slack || p.x > high_x + slack || p.z < low_z - slack ||
            p.z > high_z + slack)
            continue;
        if (fabsl(away) < fabsl(nearest)) nearest = away;
    }
    return nearest;
}

enum { COLUMNS = 9, ROWS = 7 };

static void make(void *desc, rng *r, dvec3 at, double size, int variant) {
    static float heights[COLUMNS * ROWS];
    static const float roughness[] = {1, 0.02f, 20, 0};
    heightfield_view *v = desc;
    for (size_t i = 0; i < COUNT_OF(heights); i++)
        heights[i] = roughness[variant] * (float)(rng_unit(r) - 0.5);
    *v = (heightfield_view){.struct_size = v->struct_size,
                            .heights = heights,
                            .heights_count = COUNT_OF(heights),
                            .columns = COLUMNS,
                            .rows = ROWS,
                            .min = vec3_from(at),
                            .max = vec3_from(dvec3_add(at, (dvec3){2 * size, size, size})),
                            .smooth = variant & 1};
}

static const subject terrain = {"heightfield", 4, make, solve, distance};

static void a_terrain_agrees_with_a_slow_solver(void **state) {
    (void)state;
    const double sizes[] = {1e-3, 1, 1e3, 1e6}, offsets[] = {0, 1, 128, 16384};
    long rays = test_full() ? 1000000 : 20000, left = 0;
    setting s = {.of = &terrain, .type = primitive_find("heightfield")};
    shared_rng()->state = 12;
    surface last = {.n = {0, 1, 0}};
    bool met = false;
    for (long n = 0; n < rays; n++) {
        if (n % 25 == 0) {
            long place = n / 25;
            setting_make(&s, sizes[place % 4], offsets[place / 4 % 4], (int)(place / 16 % 4));
            met = false;
        }
        ray r = setting_ray(&s, met ? (int)(n % 5) : 0, &last);
        hit found;
        if (!setting_compare(&s, &r, &found)) continue;
        setting_surface(&s, &r, &found, &last);
        met = true;
        assert_true(last.n.y > 0 &&
                    fabs(dvec3_dot(last.dpdu, last.n)) < 1e-9 * dvec3_length(last.dpdu));
        assert_true(dvec3_dot(dvec3_cross(last.dpdu, last.dpdv), last.n) > 0);
        for (int i = 0; i < 2; i++) {
            dvec3 d = any_direction();
            if (i == 1) d = dvec3_sub(d, dvec3_scale(last.n, dvec3_dot(d, last.n) * (1 - 1e-6)));
            ray next = ray_make((vec3){0, 0, 0}, vec3_from(d), 0, INFINITY);
            double side = dvec3_dot(last.n, dvec3_from(next.d));
            if (side == 0) continue;
            next.o = surface_offset_origin(&last, side);
            hit again;
            if (!setting_compare(&s, &next, &again)) continue;
            left++;
        }
    }
    printf("terrain: %ld hits, %ld misses, %ld too close to call, %ld met again\n", s.hits,
           s.misses, s.unclear, left);
    assert_true(s.hits > rays / 4 && s.misses > rays / 20 && s.unclear < rays / 4);
    setting_release(&s);
}

/* Rays at posts, edges and diagonals, and anywhere inside the rim: none falls through. */
static void a_terrain_has_no_holes(void **state) {
    (void)state;
    setting s = {.of = &terrain, .type = primitive_find("heightfield")};
    shared_rng()->state = 5;
    const snell_isa isas[] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2, SNELL_ISA_AVX512};
    long rays = test_full() ? 1000000 : 60000, lost = 0;
    for (long n = 0; n < rays; n++) {
        if (n % 200 == 0) setting_make(&s, 1, n / 200 % 2 ? 1000 : 0, (int)(n / 400 % 4));
        const heightfield_view *v = (const void *)&s.desc;
        int column = 1 + (int)rng_below(shared_rng(), COLUMNS - 2),
            row = 1 + (int)rng_below(shared_rng(), ROWS - 2);
        wide a = post(v, column, row), b = a;
        if (n % 4 == 1) b = post(v, column - 1, row);
        if (n % 4 == 2) b = post(v, column, row - 1);
        if (n % 4 == 3) b = post(v, column - 1, row - 1);
        real f = between(0, 1);
        wide p = wide_add(wide_scale(a, f), wide_scale(b, 1 - f));
        dvec3 to = {(double)p.x, (double)p.y, (double)p.z};
        dvec3 from = dvec3_add(to, (dvec3){between(-0.02, 0.02), 30, between(-0.02, 0.02)});
        ray r = ray_between(from, to);
        if (n % 8 == 0) r.d = (vec3){0, -1, 0}, r.o.x = (float)to.x, r.o.z = (float)to.z;
        for (size_t i = 0; i < COUNT_OF(isas); i++) {
            hit found;
            if (!accel_has_isa(isas[i])) continue;
            accel_trace(s.tree, isas[i], &r, &found, 1, NULL);
            lost += found.instance == NO_ID;
        }
    }
    assert_int_equal(lost, 0);
    setting_release(&s);
}

static void its_points_are_drawn_by_area(void **state) {
    (void)state;
    enum { POINTS = 20000 };
    setting s = {.of = &terrain, .type = primitive_find("heightfield")};
    shared_rng()->state = 77;
    setting_make(&s, 1, 0, 0);
    const heightfield_view *v = (const void *)&s.desc;
    for (uint32_t part = 0; part < s.type->primitive_count(v); part += 7) {
        wide c[3], center = {0, 0, 0};
        real areas[2];
        for (int k = 0; k < 2; k++) {
            corners_of(v, (int)part * 2 + k, c);
            areas[k] = wide_length(wide_cross(wide_sub(c[1], c[0]), wide_sub(c[2], c[0]))) / 2;
            for (int i = 0; i < 3; i++) center = wide_add(center, wide_scale(c[i], areas[k] / 3));
        }
        real area = areas[0] + areas[1];
        center = wide_scale(center, 1 / area);
        assert_true(fabsl(s.type->area(v, part) - area) < 1e-12L * area);
        dvec3 sum = {0, 0, 0};
        for (int n = 0; n < POINTS; n++) {
            surface on;
            double a = between(0, 1), b = between(0, 1);
            s.type->sample_area(v, part, a, b, &on);
            assert_true(fabsl(distance(v, wide_from_d(on.p))) < 1e-12L);
            sum = dvec3_add(sum, dvec3_scale(on.p, 1.0 / POINTS));
        }
        /* Twice the standard deviation of a uniform point in a cell, over sqrt(n), times 4. */
        real off = wide_length(wide_sub(wide_from_d(sum), center));
        assert_true(off < 4 * 0.4L / sqrtl(POINTS));
    }
    setting_release(&s);
}

static void a_plain_slope_has_the_expected_coordinates(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("heightfield");
    const float heights[] = {0, 1, 2, 0, 1, 2};
    heightfield_view v = {type->info.desc_size, heights, 6, 3, 2, {0, 0, 0}, {2, 1, 1}, true};
    for (uint32_t part = 0; part < 2; part++) {
        local_ray beam = {{0.25f + (float)part, 5, 0.75f}, {0, -1, 0}, 0, INFINITY};
        hit found = {.primitive = part};
        surface on;
        assert_true(type->intersect(&v, &beam, &found));
        assert_true(found.t == 4.75f - (float)part);
        type->surface(&v, &beam, &found, &on);
        assert_true(fabs(on.u - (0.125 + 0.5 * part)) < 1e-15 && fabs(on.v - 0.25) < 1e-15);
        assert_true(fabs(on.n.x + sqrt(0.5)) < 1e-15 && fabs(on.n.y - sqrt(0.5)) < 1e-15);
        assert_true(dvec3_dot(on.ns, on.n) > 1 - 1e-12); /* straight: all posts agree */
        dvec3 change = type->bend(&v, &found, (dvec3){0.01, 0.01, 0.02});
        assert_true(dvec3_length(change) < 1e-12);
    }
}

static void refuse(const heightfield_view *v, const char *text) {
    const primitive_type *type = primitive_find("heightfield");
    heightfield_view copy = *v;
    snell_status status = desc_check(&type->info, &copy, NULL);
    if (!status) status = type->check(&copy);
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, text);
}

static void senseless_terrains_are_refused(void **state) {
    (void)state;
    const float heights[] = {0, 1, 2, NAN};
    heightfield_view v = {primitive_find("heightfield")->info.desc_size,
                          heights,
                          3,
                          2,
                          2,
                          {0, 0, 0},
                          {1, 1, 1},
                          true};
    refuse(&v, "heightfield: 'heights' has 3 entries for 2 x 2 posts");
    v.heights_count = 4;
    refuse(&v, "heightfield: 'heights' 3 is not a finite number");
    const float flat[] = {0, 0, 0, 0};
    v.heights = flat;
    v.columns = 1;
    refuse(&v, "heightfield: 'columns' is 1; it must be at least 2 and at most 65536");
    v.columns = 3, v.heights_count = 3, v.rows = 1;
    refuse(&v, "heightfield: 'rows' is 1; it must be at least 2 and at most 65536");
    v.columns = 2, v.rows = 2, v.heights_count = 4;
    v.max.x = 0;
    refuse(&v, "heightfield: the size is 0 x 1");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plain_slope_has_the_expected_coordinates),
        cmocka_unit_test(a_terrain_agrees_with_a_slow_solver),
        cmocka_unit_test(a_terrain_has_no_holes),
        cmocka_unit_test(its_points_are_drawn_by_area),
        cmocka_unit_test(senseless_terrains_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
