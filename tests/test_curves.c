/* geometry/curves: threads and ribbons against a slow solver that evaluates the splines by their
 * textbook matrices, at many places of each strand, and narrows down what it finds. */
#include "parts_test.h"

typedef struct curves_view { /* begins as curves_desc does */
    size_t struct_size;
    const vec3 *points;
    size_t points_count;
    const float *radii;
    size_t radii_count;
    float radius;
    const uint32_t *starts;
    size_t starts_count;
    int32_t basis, kind;
} curves_view;
enum { CATMULL_ROM, BSPLINE, BEZIER, LINEAR };

/* ---- the splines once more ---- */

typedef struct ball {
    wide c;
    real r;
} ball;

static ball point_of(const curves_view *v, uint32_t first, uint32_t count, int64_t i) {
    if (i < 0 || i >= count) {
        ball a = point_of(v, first, count, i < 0 ? 0 : count - 1),
             b = point_of(v, first, count, i < 0 ? 1 : count - 2);
        return (ball){wide_sub(wide_scale(a.c, 2), b.c), fmaxl(2 * a.r - b.r, 0)};
    }
    size_t at = first + (size_t)i;
    return (ball){wide_from(v->points[at]), v->radii_count ? v->radii[at] : v->radius};
}

/* The strand at g: from 0 to its number of segments. */
static ball ball_at(const curves_view *v, uint32_t first, uint32_t count, real g) {
    int64_t segments = v->basis == BEZIER ? (count - 1) / 3 : count - 1, j = (int64_t)g;
    if (j >= segments) j = segments - 1;
    real t = g - (real)j, s = 1 - t, w[4] = {0, s, t, 0};
    int64_t base = v->basis == BEZIER ? 3 * j : j - 1;
    if (v->basis == CATMULL_ROM) {
        w[0] = (-t + 2 * t * t - t * t * t) / 2;
        w[1] = (2 - 5 * t * t + 3 * t * t * t) / 2;
        w[2] = (t + 4 * t * t - 3 * t * t * t) / 2;
        w[3] = (-t * t + t * t * t) / 2;
    } else if (v->basis == BSPLINE) {
        w[0] = s * s * s / 6;
        w[1] = (4 - 6 * t * t + 3 * t * t * t) / 6;
        w[2] = (1 + 3 * t + 3 * t * t - 3 * t * t * t) / 6;
        w[3] = t * t * t / 6;
    } else if (v->basis == BEZIER) {
        w[0] = s * s * s;
        w[1] = 3 * s * s * t;
        w[2] = 3 * s * t * t;
        w[3] = t * t * t;
    }
    ball sum = {{0, 0, 0}, 0}, k[4];
    for (int i = 0; i < 4; i++) {
        if (w[i] == 0 && v->basis != CATMULL_ROM) continue;
        k[i] = point_of(v, first, count, base + i);
        sum.c = wide_add(sum.c, wide_scale(k[i].c, w[i]));
        sum.r += w[i] * k[i].r;
    }
    if (v->basis == CATMULL_ROM) { /* the radii's Bezier form is kept from falling below 0 */
        real rises = fmaxl(k[1].r + (k[2].r - k[0].r) / 6, 0);
        real falls = fmaxl(k[2].r - (k[3].r - k[1].r) / 6, 0);
        sum.r = s * s * s * k[1].r + 3 * s * t * (s * rises + t * falls) + t * t * t * k[2].r;
    }
    return sum;
}

typedef struct path { /* one strand, as a ray sees it */
    const curves_view *v;
    uint32_t first, count;
    real segments;
    wide o, d; /* d unit */
} path;

static uint32_t path_count(const curves_view *v) {
    return v->starts_count ? (uint32_t)v->starts_count : 1;
}

static path path_at(const curves_view *v, uint32_t i, wide o, wide d) {
    uint32_t first = v->starts_count ? v->starts[i] : 0;
    uint32_t end = (uint32_t)(i + 1 < v->starts_count ? v->starts[i + 1] : v->points_count);
    uint32_t count = end - first;
    return (path){v, first, count, v->basis == BEZIER ? (count - 1) / 3 : count - 1, o, d};
}

typedef struct seen {
    real h, z, r;
} seen;

static seen look(const path *p, real g) {
    ball b = ball_at(p->v, p->first, p->count, g);
    wide f = wide_sub(b.c, p->o);
    real z = wide_dot(f, p->d);
    wide across = wide_sub(f, wide_scale(p->d, z));
    return (seen){b.r * b.r - wide_dot(across, across), z, b.r};
}

/* What is made least: 0: -h, -1: where the ball is entered, 1: minus where it is left; 2: distance
 * from o, 3: h. */
static real measure(const path *p, real g, int what) {
    if (what == 2) {
        ball b = ball_at(p->v, p->first, p->count, g);
        return wide_length(wide_sub(b.c, p->o)) - b.r;
    }
    seen s = look(p, g);
    if (what == 0 || what == 3) return what ? s.h : -s.h;
    if (s.h < 0) return INFINITY;
    return what < 0 ? s.z - sqrtl(s.h) : -s.z - sqrtl(s.h);
}

static real narrow(const path *p, real low, real high, int what) {
    const real golden = 0.61803398874989484820L;
    real a = high - golden * (high - low), b = low + golden * (high - low);
    real fa = measure(p, a, what), fb = measure(p, b, what);
    for (int i = 0; i < 70; i++) {
        if (fa < fb) {
            high = b, b = a, fb = fa;
            a = high - golden * (high - low), fa = measure(p, a, what);
        } else {
            low = a, a = b, fa = fb;
            b = low + golden * (high - low), fb = measure(p, b, what);
        }
    }
    return (low + high) / 2;
}

enum { STEPS = 40 };

/* The least over low..high: around each place of a grid where it is least of three. */
static real least(const path *p, real low, real high, int what, int steps, real *where) {
    static real values[STEPS * 16];
    real step = (high - low) / steps, best = INFINITY;
    *where = low;
    for (int i = 0; i <= steps; i++) values[i] = measure(p, low + step * i, what);
    for (int i = 0; i <= steps; i++) {
        if (values[i] < best) best = values[i], *where = low + step * i;
        if (values[i] > values[i ? i - 1 : i] || values[i] > values[i < steps ? i + 1 : i])
            continue;
        real near =
            narrow(p, low + step * (i ? i - 1 : i), low + step * (i < steps ? i + 1 : i), what);
        real value = measure(p, near, what);
        if (value < best) best = value, *where = near;
    }
    return best;
}

static real edge_of(const path *p, real out, real in) {
    for (int i = 0; i < 80; i++) {
        real middle = (out + in) / 2;
        if (look(p, middle).h < 0)
            out = middle;
        else
            in = middle;
    }
    return in;
}

/* Adds the stretch that goes on from g = low to where h < 0 again. */
static int add_stretch(const path *p, real low, real high, real size, root *roots) {
    real enter = INFINITY, leave = -INFINITY, deepest = -INFINITY, r = 0, where;
    for (real from = low, to; from < high; from = to) { /* there may be a kink at a joint */
        to = fminl(floorl(from) + 1, high);
        enter = fminl(enter, least(p, from, to, -1, STEPS, &where));
        leave = fmaxl(leave, -least(p, from, to, 1, STEPS, &where));
        real depth = -least(p, from, to, 0, STEPS, &where);
        if (depth > deepest) deepest = depth, r = look(p, where).r;
    }
    real slack = 1e-12L * size * size / sqrtl(deepest > 0 ? deepest : 1e-300L);
    root made = {enter, deepest / (r * r), slack};
    roots[0] = made;
    made.t = leave;
    roots[1] = made;
    return 2;
}

/* Places where to look at h, and how many roots nobody can tell. */
typedef struct samples {
    real at[STEPS * 128];
    int count, unclear;
} samples;

/* Adds low, and where between it and high h is least or largest. Where both may be, near 0, each half by
 * itself. Where h is next to 0 there nobody can tell: a root says so. */
static void sample(const path *p, real low, real high, int depth, samples *s, root *roots) {
    const real inset = 1e-7L;
    seen first = look(p, low), last = look(p, high);
    bool rises = look(p, low + inset).h > first.h, falls = look(p, high - inset).h > last.h;
    real close = fminl(fabsl(first.h), fabsl(last.h)) / (first.r * first.r);
    if (rises != falls && depth > 0 && close < 0.1L) {
        sample(p, low, (low + high) / 2, depth - 1, s, roots);
        sample(p, (low + high) / 2, high, depth - 1, s, roots);
        return;
    }
    s->at[s->count++] = low;
    if (rises != falls) return;
    real where = s->at[s->count++] = narrow(p, low, high, rises ? 0 : 3);
    seen extreme = look(p, where);
    if (fabsl(extreme.h) < 1e-7L * extreme.r * extreme.r)
        roots[s->unclear++] = (root){extreme.z, 0, extreme.r};
}

static int solve_round(const path *p, real size, root *roots) {
    static samples s;
    s.count = s.unclear = 0;
    int steps = STEPS * (int)p->segments;
    for (int i = 0; i < steps; i++)
        sample(p, p->segments * i / steps, p->segments * (i + 1) / steps, 3, &s, roots);
    s.at[s.count++] = p->segments;
    const real *at = s.at;
    int count = s.unclear, first = count;
    real begin = -1;
    for (int i = 0; i <= s.count; i++) {
        real h = i == s.count ? -1 : look(p, at[i]).h;
        if (h >= 0 && begin < 0) begin = i == 0 ? 0 : edge_of(p, at[i - 1], at[i]);
        if (h < 0 && begin >= 0) {
            real end = i == s.count ? p->segments : edge_of(p, at[i], at[i - 1]);
            count += add_stretch(p, begin, end, size, roots + count);
            begin = -1;
        }
    }
    /* On the inner side of a kink the stretches of both segments overlap: one solid, one stretch. */
    for (int i = first; i < count; i += 2)
        for (int k = first; k < count; k += 2) {
            if (k == i || roots[k].t > roots[i + 1].t || roots[i].t > roots[k + 1].t) continue;
            if (roots[k].t < roots[i].t) roots[i] = roots[k];
            if (roots[k + 1].t > roots[i + 1].t) roots[i + 1] = roots[k + 1];
            roots[k] = roots[count - 2];
            roots[k + 1] = roots[count - 1];
            count -= 2;
            i = first - 2; /* anew */
            break;
        }
    return count;
}

/* Across the ray, the curve's direction against the way to it. */
static real turn_at(const path *p, real g) {
    const real step = 1e-7L;
    real low = g - step > 0 ? g - step : 0, high = g + step < p->segments ? g + step : p->segments;
    seen a = look(p, low), b = look(p, high);
    return (b.r * b.r - b.h) - (a.r * a.r - a.h);
}

static root ribbon_root(const path *p, real g, real size) {
    seen s = look(p, g);
    return (root){s.z, s.h / (s.r * s.r), 1e-5L * size};
}

/* Each segment by itself, for there may be kinks; at a joint that is nearer to the ray than what is
 * on both sides of it there is half a disk. */
static int solve_ribbon(const path *p, real size, root *roots) {
    int count = 0, segments = (int)p->segments;
    const real step = 1.0L / STEPS, inset = 1e-6L;
    for (int j = 0; j < segments; j++) {
        real low = j + inset, before = turn_at(p, low);
        if (j > 0 && turn_at(p, j - inset) < 0 && before > 0)
            roots[count++] = ribbon_root(p, j, size);
        for (int i = 1; i <= STEPS; i++) {
            real at = i == STEPS ? j + 1 - inset : j + step * i, now = turn_at(p, at), a = low,
                 b = at;
            for (int k = 0; k < 60 && (before < 0) != (now < 0); k++) {
                real middle = (a + b) / 2;
                if ((turn_at(p, middle) < 0) == (before < 0))
                    a = middle;
                else
                    b = middle;
            }
            if ((before < 0) != (now < 0)) roots[count++] = ribbon_root(p, a, size);
            low = at;
            before = now;
        }
    }
    /* The ends are cut: near them nobody can tell. */
    for (int end = 0; end < 2; end++) {
        root at = ribbon_root(p, end ? p->segments : 0, size);
        real r = look(p, end ? p->segments : 0).r;
        if (at.margin > -0.1L &&
            fabsl(turn_at(p, end ? p->segments : 0)) < 1e-6L * 2e-7L * r * size) {
            at.margin = 0;
            roots[count++] = at;
        }
    }
    return count;
}

static int solve(const void *desc, wide o, wide d, root *roots) {
    const curves_view *v = desc;
    int count = 0;
    real speed = wide_length(d);
    d = wide_scale(d, 1 / speed);
    wide first = wide_from(v->points[0]), f = wide_sub(first, o);
    real shift = wide_dot(f, d), size = 0;
    for (size_t i = 0; i < v->points_count; i++)
        size = fmaxl(size, wide_length(wide_sub(wide_from(v->points[i]), first)));
    o = wide_add(o, wide_scale(d, shift));
    for (uint32_t i = 0; i < path_count(v); i++) {
        path p = path_at(v, i, o, d);
        count +=
            v->kind ? solve_ribbon(&p, size, roots + count) : solve_round(&p, size, roots + count);
    }
    for (int i = 0; i < count; i++) {
        roots[i].t = (roots[i].t + shift) / speed;
        roots[i].slack /= speed;
    }
    return count;
}

static real depth_in(const curves_view *v, uint32_t strand, wide p) {
    path at = path_at(v, strand, p, (wide){0, 0, 0});
    real where, nearest = INFINITY;
    for (int j = 0; j < (int)at.segments; j++) /* there may be a kink at a joint */
        nearest = fminl(nearest, least(&at, j, j + 1, 2, STEPS, &where));
    return nearest;
}

/* From the nearest strand's surface; p may be inside another strand. */
static real distance(const void *desc, wide p) {
    real nearest = INFINITY;
    for (uint32_t i = 0; i < path_count(desc); i++) {
        real depth = depth_in(desc, i, p);
        if (fabsl(depth) < fabsl(nearest)) nearest = depth;
    }
    return nearest;
}

/* ---- examples ---- */

enum { BASES = 4, STRANDS = 3, POINTS = 7 };

static float made_radii[STRANDS * POINTS];

/* Gentle bends: thinner everywhere than they bend. */
static void make(void *desc, rng *r, dvec3 at, double size, int variant) {
    static vec3 points[STRANDS * POINTS];
    static uint32_t starts[STRANDS];
    float *radii = made_radii;
    curves_view *v = desc;
    for (uint32_t i = 0; i < STRANDS; i++) {
        dvec3 p = dvec3_add(
            at,
            dvec3_scale((dvec3){rng_unit(r) - 0.5, rng_unit(r) - 0.5, rng_unit(r) - 0.5}, size));
        dvec3 d = any_direction();
        starts[i] = i * POINTS;
        for (uint32_t k = 0; k < POINTS; k++) {
            points[i * POINTS + k] = vec3_from(p);
            radii[i * POINTS + k] = (float)(size * 0.01 * (2 + rng_unit(r)));
            d = dvec3_normalize(dvec3_add(d, dvec3_scale(any_direction(), 0.35)));
            p = dvec3_add(p, dvec3_scale(d, 0.25 * size));
        }
        if (variant % BASES == BEZIER) { /* joints without a kink */
            uint32_t joint = i * POINTS + 3;
            points[joint] = vec3_scale(vec3_add(points[joint - 1], points[joint + 1]), 0.5f);
        }
    }
    *v = (curves_view){v->struct_size,       points,         COUNT_OF(points), radii,
                       COUNT_OF(made_radii), 0.01f,          starts,           STRANDS,
                       variant % BASES,      variant / BASES};
}

static const subject threads = {"curves", BASES, make, solve, distance};

static void make_ribbons(void *desc, rng *r, dvec3 at, double size, int variant) {
    make(desc, r, at, size, variant + BASES);
}
static const subject ribbons = {"curves", BASES, make_ribbons, solve, NULL};

static long rays_of(void) { return test_full() ? 1000000 : SANITIZED ? 4000 : 20000; }

static const double sizes[] = {1e-3, 1, 1e3, 1e6}, offsets[] = {0, 1, 128, 16384};

static uint32_t strand_of(const curves_view *v, const hit *found) {
    return found->primitive / (v->basis == LINEAR ? 1 : 4) / POINTS;
}

/* A ray that leaves a strand starts on the side to which it goes, and does not meet the surface there.
 * Another strand may be nearer than floats are fine: the ray may start in that one. */
static void check_leaving(setting *s, const hit *left, const surface *at) {
    const curves_view *v = (const void *)&s->desc;
    for (int i = 0; i < 2; i++) {
        dvec3 d = any_direction();
        if (i == 1) d = dvec3_sub(d, dvec3_scale(at->n, dvec3_dot(d, at->n) * (1 - 1e-6)));
        ray next = ray_make((vec3){0, 0, 0}, vec3_from(d), 0, INFINITY);
        double side = dvec3_dot(at->n, dvec3_from(next.d));
        if (side == 0) continue;
        next.o = surface_offset_origin(at, side);
        real away = depth_in(v, strand_of(v, left), wide_from(next.o));
        /* Where a thread is no thicker than some roundings of its points they carry it out again. */
        real coarse =
            0x1p-23L * (fabsl((real)at->p.x) + fabsl((real)at->p.y) + fabsl((real)at->p.z));
        if (!(side > 0 ? away > 0 : away < 0) && !(side < 0 && coarse > 1e-4L * s->size))
            fail_msg("the next origin is %Lg from the surface, side %g", away, side);
        hit found;
        if (!setting_compare(s, &next, &found)) continue;
        surface again;
        setting_surface(s, &next, &found, &again);
        s->again++;
    }
}

static void threads_agree_with_a_slow_solver(void **state) {
    (void)state;
    setting s = {.of = &threads, .type = primitive_find("curves")};
    shared_rng()->state = 4711;
    surface last = {.n = {0, 1, 0}};
    bool met = false;
    for (long n = 0; n < rays_of(); n++) {
        if (n % 25 == 0) {
            long place = n / 25;
            setting_make(&s, sizes[place % 4], offsets[place / 4 % 4], (int)(place / 16 % BASES));
            met = false;
        }
        ray r = setting_ray(&s, met ? (int)(n % 5) : (int)(n % 3), &last);
        hit found;
        if (!setting_compare(&s, &r, &found)) continue;
        setting_surface(&s, &r, &found, &last);
        met = true;
        check_leaving(&s, &found, &last);
    }
    printf("threads: %ld hits, %ld misses, %ld too close to call, %ld met again\n", s.hits,
           s.misses, s.unclear, s.again);
    assert_true(s.hits > rays_of() / 4 && s.misses > rays_of() / 8);
    setting_release(&s);
}

static void make_close(void *desc, rng *r, dvec3 at, double size, int variant) {
    (void)r, (void)at, (void)size;
    static const vec3 points[] = {
        {0x1.221864p+12f, 0x1.7e0fb4p+13f, 0x1.346c98p+13f},
        {0x1.221a9p+12f, 0x1.7e1132p+13f, 0x1.346d5ep+13f},
        {0x1.221bc4p+12f, 0x1.7e12f4p+13f, 0x1.346e1ep+13f},
        {0x1.221c34p+12f, 0x1.7e14eep+13f, 0x1.346e4ep+13f},
        {0x1.221b92p+12f, 0x1.7e16e4p+13f, 0x1.346e9p+13f},
        {0x1.221b2ap+12f, 0x1.7e18dcp+13f, 0x1.346e46p+13f},
        {0x1.221ab6p+12f, 0x1.7e1ad8p+13f, 0x1.346e34p+13f},
        {0x1.221ddp+12f, 0x1.7e1212p+13f, 0x1.346ce4p+13f},
        {0x1.221adcp+12f, 0x1.7e11fp+13f, 0x1.346e3cp+13f},
        {0x1.2217e6p+12f, 0x1.7e112ap+13f, 0x1.346f56p+13f},
        {0x1.22157cp+12f, 0x1.7e1024p+13f, 0x1.34708ep+13f},
        {0x1.221344p+12f, 0x1.7e0ea4p+13f, 0x1.347148p+13f},
        {0x1.221034p+12f, 0x1.7e0dacp+13f, 0x1.347222p+13f},
        {0x1.220cap+12f, 0x1.7e0ce4p+13f, 0x1.34729p+13f},
    };
    static const float radii[] = {0x1.bf43e8p-6f, 0x1.80ec3ap-6f, 0x1.8387ap-6f,  0x1.d4c512p-6f,
                                  0x1.74ace2p-6f, 0x1.7f4474p-6f, 0x1.e60e6p-6f,  0x1.a6db78p-6f,
                                  0x1.cd71a6p-6f, 0x1.489ddcp-6f, 0x1.7b896ep-6f, 0x1.6d7f5ep-6f,
                                  0x1.507816p-6f, 0x1.4953d8p-6f};
    static const uint32_t starts[] = {0, POINTS};
    curves_view *v = desc;
    *v = (curves_view){v->struct_size, points, COUNT_OF(points), radii,   COUNT_OF(radii),
                       0.01f,          starts, COUNT_OF(starts), variant, 0};
}

/* Where floats are 1 mm apart and the next thread is a quarter of that away, the origin leaves its own. */
static void next_to_another_thread_the_origin_leaves_its_own(void **state) {
    (void)state;
    static const subject close = {"curves", 1, make_close, solve, distance};
    setting s = {.of = &close, .type = primitive_find("curves")};
    setting_make_at(&s, 1, (dvec3){0, 0, 0}, BSPLINE);
    ray r = ray_make((vec3){-0x1.0a5174p+12f, 0x1.131c2ep+13f, 0x1.5efa64p+12f},
                     (vec3){0x1.3590e8p+0f, 0x1.dc0ee6p-2f, 0x1.27d84ep-1f}, 0, INFINITY);
    hit found;
    surface at;
    assert_true(setting_compare(&s, &r, &found));
    setting_surface(&s, &r, &found, &at);
    const curves_view *v = (const void *)&s.desc;
    vec3 o = surface_offset_origin(&at, 1);
    assert_true(depth_in(v, 0, wide_from_d(at.p)) > 0);
    assert_true(depth_in(v, 0, wide_from(o)) < 0);
    assert_true(depth_in(v, 1, wide_from(o)) >= at.error);
    for (int i = 0; i < 10; i++) check_leaving(&s, &found, &at);
    setting_release(&s);
}

static void ribbons_agree_with_a_slow_solver(void **state) {
    (void)state;
    setting s = {.of = &ribbons, .type = primitive_find("curves")};
    shared_rng()->state = 815;
    surface last = {.n = {0, 1, 0}};
    bool met = false;
    long left = 0;
    for (long n = 0; n < rays_of(); n++) {
        if (n % 25 == 0) {
            long place = n / 25;
            setting_make(&s, sizes[place % 4], offsets[place / 4 % 4], (int)(place / 16 % BASES));
            met = false;
        }
        ray r = setting_ray(&s, met && n % 5 == 4 ? 4 : (int)(n % 3), &last);
        hit found;
        if (!setting_compare(&s, &r, &found)) continue;
        setting_surface(&s, &r, &found, &last);
        met = true;
        assert_true(dvec3_dot(last.n, dvec3_from(r.d)) <= 0);
        /* On its way out no ray meets the ribbon that turns towards it. */
        dvec3 d = any_direction();
        double side = dvec3_dot(last.n, d);
        ray next = ray_make(surface_offset_origin(&last, side), vec3_from(d), 0, INFINITY);
        hit again;
        if (!setting_compare(&s, &next, &again)) continue;
        surface there;
        setting_surface(&s, &next, &again, &there);
        left++;
        double apart = dvec3_length(dvec3_sub(there.p, last.p));
        if (!(apart > 0.02 * s.size)) {
            /* Another strand's? Then u and v tell. */
            assert_true(fabs(there.u - last.u) > 1e-3 || fabs(there.v - last.v) > 1e-3);
        }
    }
    printf("ribbons: %ld hits, %ld misses, %ld too close to call, %ld met again\n", s.hits,
           s.misses, s.unclear, left);
    assert_true(s.hits > rays_of() / 10 && s.misses > rays_of() / 4);
    setting_release(&s);
}

/* Guards against an origin that is rounded so far along a thread that this bends away under it: where the
 * normal is nearly at right angles to the axis along which the thread is far. */
static void beside_a_far_thread_the_origin_stays_on_its_side(void **state) {
    (void)state;
    setting s = {.of = &threads, .type = primitive_find("curves")};
    shared_rng()->state = 12;
    long met = 0, rays = SANITIZED ? 200 : 1000;
    for (long n = 0; n < rays; n++) {
        if (n % 20 == 0) setting_make_at(&s, 1, (dvec3){4096, 0, 0}, (int)(n / 20 % BASES));
        const curves_view *v = (const void *)&s.desc;
        uint32_t strand = rng_below(shared_rng(), STRANDS);
        double g = between(0.01, s.variant == BEZIER ? 1.99 : 5.99);
        ball at = ball_at(v, strand * POINTS, POINTS, g),
             next = ball_at(v, strand * POINTS, POINTS, g + 0.001);
        wide along = wide_sub(next.c, at.c);
        dvec3 across = dvec3_normalize((dvec3){0, -(double)along.z, (double)along.y});
        if (n & 1) across = dvec3_negate(across);
        across.x = exp2(between(-14, -4)) * (n & 2 ? 1 : -1);
        dvec3 middle = {(double)at.c.x, (double)at.c.y, (double)at.c.z};
        dvec3 to = dvec3_add(middle, dvec3_scale(across, (double)at.r));
        ray r = ray_between(dvec3_add(to, across), to);
        hit found;
        surface on;
        accel_trace(s.tree, SNELL_ISA_AUTO, &r, &found, 1, NULL);
        if (found.instance == NO_ID) continue;
        setting_surface(&s, &r, &found, &on);
        met++;
        uint32_t parts = s.type->primitive_count(&s.desc) / STRANDS;
        for (int side = -1; side <= 1; side += 2) {
            wide o = wide_from(surface_offset_origin(&on, side));
            real away = depth_in(v, found.primitive / parts, o);
            if (!(side * away > 0)) fail_msg("the next origin is %Lg away, side %d", away, side);
        }
    }
    assert_true(met > rays * 9 / 10);
    setting_release(&s);
}

/* No segment shows what another one of its strand has inside: at kinks, also of the radius, they
 * overlap, and a ray that finds both at the same float would take the wrong one. */
static void strands_have_no_faces_inside(void **state) {
    (void)state;
    setting s = {.of = &threads, .type = primitive_find("curves")};
    shared_rng()->state = 1961;
    long met = 0;
    for (long n = 0; n < rays_of() / 10; n++) {
        if (n % 10 == 0) setting_make(&s, 1, 0, (int)(n / 10 % BASES));
        const curves_view *v = (const void *)&s.desc;
        if (n % 10 == 0) /* a waist that a Catmull-Rom spline would make thinner than nothing */
            for (size_t i = 0; i < v->radii_count; i += POINTS)
                made_radii[i + 2] *= 3, made_radii[i + 3] *= 0.2f;
        uint32_t strand = rng_below(shared_rng(), STRANDS);
        real waist = s.variant == BEZIER ? 1 : 3, at = waist + between(-0.03, 0.03);
        ball by = ball_at(v, strand * POINTS, POINTS, n % 3 ? at : between(0, 2 * (double)waist));
        dvec3 to = {(double)by.c.x, (double)by.c.y, (double)by.c.z};
        to = dvec3_add(to, dvec3_scale(any_direction(), (double)by.r));
        ray r = ray_between(dvec3_add(to, dvec3_scale(any_direction(), 2)), to);
        uint32_t parts = s.type->primitive_count(&s.desc);
        for (uint32_t part = 0; part < parts; part++) {
            local_ray beam = {r.o, r.d, 0, INFINITY};
            hit found = {.primitive = part};
            while (s.type->intersect(&s.desc, &beam, &found)) {
                surface on;
                s.type->surface(&s.desc, &beam, &found, &on);
                real depth = depth_in(v, part / (parts / STRANDS), wide_from_d(on.p));
                if (depth < -1e-11L)
                    fail_msg("curves %d: part %u has a face %Lg inside", s.variant, part, -depth);
                met++;
                beam.t_min = found.t;
            }
        }
    }
    assert_true(met > rays_of() / 5);
    setting_release(&s);
}

/* Neighbouring points differ by what the derivatives say. */
static void coordinates_run_along_and_around(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        setting s = {.of = kind ? &ribbons : &threads, .type = primitive_find("curves")};
        shared_rng()->state = 99;
        long compared = 0;
        for (int n = 0; n < 40000; n++) {
            if (n % 50 == 0) setting_make(&s, 1, 0, n / 50 % BASES);
            ray r = setting_ray(&s, 0, NULL), beside;
            hit a, b;
            surface p, q;
            accel_trace(s.tree, SNELL_ISA_AUTO, &r, &a, 1, NULL);
            if (a.instance == NO_ID) continue;
            setting_surface(&s, &r, &a, &p);
            if (dvec3_dot(p.n, dvec3_from(r.d)) > -0.3 * dvec3_length(dvec3_from(r.d))) continue;
            dvec3 o = dvec3_add(p.p, dvec3_scale(p.n, 0.05));
            r = ray_make(vec3_from(o), vec3_from(dvec3_negate(p.n)), 0, INFINITY);
            beside = r;
            dvec3 step = dvec3_scale(any_direction(), 1e-4);
            beside.o = vec3_from(dvec3_add(o, step));
            accel_trace(s.tree, SNELL_ISA_AUTO, &r, &a, 1, NULL);
            accel_trace(s.tree, SNELL_ISA_AUTO, &beside, &b, 1, NULL);
            if (a.instance == NO_ID || b.instance == NO_ID || a.primitive != b.primitive) continue;
            setting_surface(&s, &r, &a, &p);
            setting_surface(&s, &beside, &b, &q);
            if (fabs(p.v - q.v) > 0.1 || dvec3_length(p.dpdu) == 0 || dvec3_length(q.dpdu) == 0)
                continue;
            dvec3 moved = dvec3_sub(q.p, p.p),
                  said = dvec3_add(dvec3_scale(p.dpdu, q.u - p.u), dvec3_scale(p.dpdv, q.v - p.v));
            double far = dvec3_length(moved);
            if (!(dvec3_length(dvec3_sub(moved, said)) < (kind ? 0.1 : 0.03) * far + 1e-7))
                fail_msg("kind %d: moved by %g, the derivatives are off by %g", kind, far,
                         dvec3_length(dvec3_sub(moved, said)));
            if (kind == 0) assert_true(fabs(dvec3_dot(p.dpdu, p.n)) < 1e-6);
            assert_true(fabs(dvec3_dot(p.dpdv, p.n)) < 1e-9);
            compared++;
        }
        assert_true(compared > 500);
        setting_release(&s);
    }
}

static void straight_threads_are_cylinders_with_round_ends(void **state) {
    (void)state;
    const vec3 points[] = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
    for (int basis = 0; basis < BASES; basis++) {
        if (basis == BEZIER) continue;
        setting s = {.type = primitive_find("curves")};
        curves_view v = {s.type->info.desc_size, points, 3, NULL, 0, 0.25f, NULL, 0, basis, 0};
        local_ray beam = {{0, 1, 5}, {0, 0, -1}, 0, INFINITY};
        surface on;
        float nearest = INFINITY;
        for (uint32_t part = 0; part < s.type->primitive_count(&v); part++) {
            hit found = {.primitive = part};
            if (!s.type->intersect(&v, &beam, &found)) continue;
            nearest = float_min(nearest, found.t);
            s.type->surface(&v, &beam, &found, &on);
            assert_true(on.n.z == 1 && fabs(on.u - 0.5) < 1e-6);
        }
        assert_true(nearest == 4.75f);
        bounds3 box = s.type->bounds(&v);
        assert_true(fabsf(box.max.y - 2.25f) < 1e-5f && fabsf(box.min.y + 0.25f) < 1e-5f);
        assert_true(fabsf(box.max.x - 0.25f) < 1e-5f);
    }
}

static void refuse(const curves_view *v, const char *text) {
    const primitive_type *type = primitive_find("curves");
    curves_view copy = *v;
    snell_status status = desc_check(&type->info, &copy, NULL);
    if (!status) status = type->check(&copy);
    assert_int_equal(status, SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, text);
}

static void senseless_curves_are_refused(void **state) {
    (void)state;
    const vec3 points[] = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, {0, 3, 0}, {0, NAN, 0}};
    const float none[] = {0, 0}, bad[] = {1, -1}, nan[] = {1, NAN};
    const uint32_t one[] = {0, 1}, back[] = {0, 2, 2}, beyond[] = {0, 9}, late[] = {1};
    curves_view v = {
        primitive_find("curves")->info.desc_size, points, 0, NULL, 0, 0.1f, NULL, 0, 0, 0};
    refuse(&v, "curves: 'points' has 0 entries; it must have 2 to 67108864");
    v.points_count = 1;
    refuse(&v, "curves: strand 1 has one point");
    v.points_count = 5;
    refuse(&v, "curves: 'points' 4 is not a finite number");
    v.points_count = 3;
    v.starts = one, v.starts_count = 2;
    refuse(&v, "curves: strand 1 has one point");
    v.starts = back, v.starts_count = 3;
    refuse(&v, "curves: entry 3 of 'starts' is 2, with 3 points");
    v.starts = beyond, v.starts_count = 2;
    refuse(&v, "curves: entry 2 of 'starts' is 9, with 3 points");
    v.starts = late, v.starts_count = 1;
    refuse(&v, "curves: entry 1 of 'starts' is 1, with 3 points");
    v.starts = NULL, v.starts_count = 0;
    v.basis = BEZIER;
    refuse(&v, "curves: strand 1 has 3 points, which is no chain of Bezier curves");
    v.basis = LINEAR;
    v.radii = none, v.radii_count = 2;
    refuse(&v, "curves: 'radii' has 2 entries for 3 points");
    v.points_count = 2;
    refuse(&v, "curves: all radii of strand 1 are 0");
    v.radii = bad;
    refuse(&v, "curves: 'radii' 1 is -1; it must be at least 0");
    v.radii = nan;
    refuse(&v, "curves: 'radii' 1 is not a finite number");
    v.radii = NULL, v.radii_count = 0, v.radius = 0;
    refuse(&v, "curves: 'radius' is 0; it must be greater than 0");
}

/* Points that coincide, tips without thickness, curves that lie on themselves: no crash and no NaN. */
static void degenerate_curves_do_no_harm(void **state) {
    (void)state;
    const vec3 same[] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    const vec3 fold[] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}};
    const vec3 line[] = {{0, 0, 0}, {1e-20f, 0, 0}, {1, 0, 0}, {1e6f, 0, 0}};
    const float tips[] = {0, 0.1f, 0.1f, 0}, huge[] = {1e5f, 1e-5f, 1e5f, 0};
    const vec3 *const shapes[] = {same, fold, line};
    shared_rng()->state = 31;
    const primitive_type *type = primitive_find("curves");
    long met = 0;
    for (int n = 0; n < 24; n++) {
        curves_view v = {
            type->info.desc_size, shapes[n % 3], 4, n & 1 ? tips : huge, 4, 0.1f, NULL, 0,
            n / 3 % BASES,        n / 12};
        assert_int_equal(type->check(&v), SNELL_OK);
        for (int k = 0; k < 4000; k++) {
            dvec3 to = {between(-0.2, 1.2), between(-0.2, 0.2), between(-0.2, 0.2)};
            ray r = ray_between(dvec3_scale(any_direction(), exp2(between(-3, 3))), to);
            if (k % 5 == 0) r.d = (vec3){1, 0, 0};
            local_ray beam = {r.o, r.d, 0, INFINITY};
            for (uint32_t part = 0; part < type->primitive_count(&v); part++) {
                hit found = {.primitive = part};
                if (!type->intersect(&v, &beam, &found)) continue;
                surface on;
                type->surface(&v, &beam, &found, &on);
                met++;
                assert_true(isfinite(found.t) && isfinite(on.p.x + on.p.y + on.p.z + on.error));
                assert_true(fabs(dvec3_length(on.n) - 1) < 1e-12);
                assert_true(isfinite(dvec3_length(on.dpdu) + dvec3_length(on.dpdv)));
            }
        }
    }
    assert_true(met > 10000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(straight_threads_are_cylinders_with_round_ends),
        cmocka_unit_test(threads_agree_with_a_slow_solver),
        cmocka_unit_test(next_to_another_thread_the_origin_leaves_its_own),
        cmocka_unit_test(ribbons_agree_with_a_slow_solver),
        cmocka_unit_test(beside_a_far_thread_the_origin_stays_on_its_side),
        cmocka_unit_test(strands_have_no_faces_inside),
        cmocka_unit_test(coordinates_run_along_and_around),
        cmocka_unit_test(senseless_curves_are_refused),
        cmocka_unit_test(degenerate_curves_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
