/* geometry: every registered shape against slow solvers in long double, the reference values, and
 * the promise that a ray cannot meet the surface it leaves. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/error.h"
#include "geometry/mesh.h"
#include "geometry/surface.h"
#include "maths/functions.h"
#include "reference.h"
#include "shape_subjects.h"

/* ---- the comparison ---- */

typedef union any_desc {
    char room[512];
    sphere_like sphere;
    plane_like plane;
    box_like box;
    disk_like disk;
    quad_like quad;
    cylinder_like cylinder;
    cone_like cone;
    torus_like torus;
    lathe_like lathe;
} any_desc;

/* One shape at one scale and place. */
typedef struct setting {
    const primitive_type *type;
    const subject *subject;
    any_desc desc;
    const void *shape; /* what rays are traced against: desc, or what was prepared from it */
    dvec3 at;
    double size;
    bool placed; /* by a transform: rays are made in the world */
    transform to_world, to_local;
    double far; /* from the world's origin, in the shape's own lengths */
    long hits, misses, unclear, exits,
        instanced; /* counted, so that a test that tests nothing fails */
} setting;

/* There is one setting at a time. */
static struct {
    const primitive_type *type;
    void *prepared;
} last_prepared;

static void release_prepared(void) {
    if (last_prepared.prepared) last_prepared.type->release(last_prepared.prepared);
    last_prepared.prepared = NULL;
}

/* Somewhere so far from the origin, at times on an axis, where two coordinates are much more exact than
 * the third one. */
static dvec3 place(double distance) {
    dvec3 way = direction();
    if (random_bits() % 4 == 0) {
        int axis = (int)(random_bits() % 3);
        way = (dvec3){axis == 0, axis == 1, axis == 2};
    }
    return dvec3_from(vec3_from(dvec3_scale(way, distance)));
}

/* Turned, as large as `scale` makes it, and moved. */
static void setting_place(setting *s, double scale, dvec3 at) {
    dvec3 z = direction(), x, y;
    dvec3_frame(z, &x, &y);
    x = dvec3_scale(x, random_bits() & 1 ? scale : -scale); /* mirrored, too */
    y = dvec3_scale(y, scale);
    z = dvec3_scale(z, scale);
    s->to_world = (transform){{{(float)x.x, (float)y.x, (float)z.x, (float)at.x},
                               {(float)x.y, (float)y.y, (float)z.y, (float)at.y},
                               {(float)x.z, (float)y.z, (float)z.z, (float)at.z}}};
    s->placed = true;
    s->far = dvec3_length(at) / scale;
    assert_true(transform_inverse(&s->to_world, &s->to_local));
}

/* The shape of the size and at the place that are set. */
static void setting_finish(setting *s) {
    desc_init(&s->type->info, &s->desc);
    s->subject->make(&s->desc, s->at, s->size);
    assert_int_equal(desc_check(&s->type->info, &s->desc, NULL), SNELL_OK);
    if (s->type->check) assert_int_equal(s->type->check(&s->desc), SNELL_OK);
    s->shape = &s->desc;
    release_prepared();
    if (s->type->prepare == NULL) return;
    last_prepared.type = s->type;
    s->shape = last_prepared.prepared = s->type->prepare(&s->desc);
    assert_non_null(s->shape);
}

static void setting_make(setting *s, double size, double offset) {
    const subject *made = s->subject;
    s->size = made->fixed_size > 0 ? made->fixed_size : size;
    s->placed = false;
    s->at = place(size * offset);
    if (made->upright) s->at.x = s->at.z = 0;
    if (made->centered) {
        double own = offset < made->own_offset ? offset : made->own_offset;
        if (offset > own || s->size != size) setting_place(s, size / s->size, s->at);
        s->at = place(s->size * own);
    }
    setting_finish(s);
}

static bool clearly(real a, real b, real slack) {
    return fabsl(a - b) > slack + 0x1p-22L * fabsl(b);
}

/* Holds intersect against the slow solver; true if there is a hit. */
static bool compare(setting *s, const local_ray *beam, hit *found) {
    root roots[ROOTS];
    int count = s->subject->solve(s->shape, wide(beam->o), wide(beam->d), roots);
    const root *nearest = NULL;
    bool unclear = false;
    for (int i = 0; i < count; i++) {
        const root *r = &roots[i];
        if (r->margin < -1e-9L) continue;
        bool near_end = !clearly(r->t, beam->t_min, r->slack) ||
                        (beam->t_max < INFINITY && !clearly(r->t, beam->t_max, r->slack));
        if (r->margin < 1e-9L || near_end) unclear = true;
        if (r->t > beam->t_min && r->t < beam->t_max && (!nearest || r->t < nearest->t))
            nearest = r;
    }
    *found = (hit){.t = INFINITY, .u = NAN, .v = NAN};
    bool is_hit = s->type->intersect(s->shape, beam, found);
    if (is_hit) assert_true(found->t > beam->t_min && found->t < beam->t_max);
    if (unclear) {
        s->unclear++;
        return is_hit;
    }
    if (is_hit != (nearest != NULL))
        fail_msg("%s: hit %d, expected %d; size %g", s->type->info.name, is_hit, nearest != NULL,
                 s->size);
    s->hits += is_hit;
    s->misses += !is_hit;
    if (is_hit && fabsl(found->t - nearest->t) > nearest->slack + 0x1p-24L * fabsl(nearest->t))
        fail_msg("%s: t %.9g, expected %.12Lg; size %g", s->type->info.name, (double)found->t,
                 nearest->t, s->size);
    return is_hit;
}

static bool at_edge(const setting *s, const surface *at);

/* The normal is the distance's gradient, by differences; not within a step of where faces meet. */
static void check_normal(const setting *s, const surface *at) {
    real step = 1e-6L * s->size, change[3];
    const vec axes[3] = {{step, 0, 0}, {0, step, 0}, {0, 0, step}};
    if (at_edge(s, at)) return;
    for (int i = 0; i < 3; i++)
        change[i] = s->subject->distance(s->shape, plus(wide_d(at->p), axes[i])) -
                    s->subject->distance(s->shape, minus(wide_d(at->p), axes[i]));
    vec gradient = times((vec){change[0], change[1], change[2]}, 1 / (2 * step));
    real off = length(minus(gradient, wide_d(at->n)));
    if (!(off < 1e-4L + 4 * step * (real)at->curvature))
        fail_msg("%s: the normal is %Lg off, curvature %g, size %g", s->type->info.name, off,
                 at->curvature, s->size);
}

static void check_coordinates(const setting *s, const surface *at) {
    surface on = *at;
    if (s->type->parametrise) s->type->parametrise(s->shape, &on);
    assert_true(isfinite(on.u) && isfinite(on.v));
    assert_true(s->type->unbounded || (on.u >= 0 && on.u <= 1 && on.v >= 0 && on.v <= 1));
    const dvec3 ways[2] = {on.dpdu, on.dpdv};
    for (int i = 0; i < 2; i++) {
        double size = dvec3_length(ways[i]);
        assert_true(isfinite(size) && fabs(dvec3_dot(ways[i], on.n)) <= 1e-6 * size);
    }
}

static void check_surface(const setting *s, const surface *at) {
    const double numbers[] = {at->p.x, at->p.y,   at->p.z,   at->n.x,   at->n.y,
                              at->n.z, at->ns.x,  at->ns.y,  at->ns.z,  at->u,
                              at->v,   at->error, at->alpha, at->tint.x};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        assert_true(isfinite(numbers[i]));
    assert_true(at->error >= 0 && fabs(dvec3_length(at->n) - 1) < 1e-14);
    assert_true(dvec3_dot(at->n, at->ns) > 0);
    check_coordinates(s, at);
    check_normal(s, at);
    /* The point is on the surface as exactly as its own error says, which is next to nothing. */
    double magnitude = fabs(at->p.x) + fabs(at->p.y) + fabs(at->p.z);
    double exact = 1e-13 * (4 * magnitude + 100 * s->size), ulp = 0x1p-23 * magnitude;
    if (s->subject->blur) exact += (double)s->subject->blur(s->shape, wide_d(at->p));
    real distance = fabsl(s->subject->distance(s->shape, wide_d(at->p)));
    assert_true(distance <= at->error && distance <= exact);
    assert_true(at->error <= exact + ulp * ulp * at->curvature);
    bounds3 box = s->type->bounds(s->shape);
    assert_true(at->p.x >= (double)box.min.x && at->p.x <= (double)box.max.x);
    assert_true(at->p.y >= (double)box.min.y && at->p.y <= (double)box.max.y);
    assert_true(at->p.z >= (double)box.min.z && at->p.z <= (double)box.max.z);
}

/* A ray that leaves: its origin is on the side it goes to, and it does not meet where it came from.
 * `shape_ray` is the ray as the shape sees it. */
static void check_leaving(setting *s, const surface *at, const local_ray *shape_ray, double side) {
    real distance = s->subject->distance(s->shape, wide(shape_ray->o));
    real along = dot(minus(wide(shape_ray->o), wide_d(at->p)), wide_d(at->n)) * side;
    /* Near an edge of a box the origin may lie on the other face: not outside of it, though. */
    if (!(along > 0 && (side > 0 ? distance > 0 : distance <= 0)))
        fail_msg("%s: the next origin is %Lg from the surface, side %g", s->type->info.name,
                 distance, side);
    hit again;
    bool is_hit = compare(s, shape_ray, &again);
    if (s->type->flat || (side > 0 && !s->subject->winding)) {
        assert_false(is_hit); /* flat or convex: nothing to meet on that side */
        return;
    }
    if (!is_hit) return;
    surface exit;
    s->type->surface(s->shape, shape_ray, &again, &exit);
    /* It leaves, or enters, by another point. */
    assert_true(dvec3_dot(exit.n, dvec3_from(shape_ray->d)) * (side > 0 ? -1 : 1) > 0);
    s->exits++;
}

/* Where two faces of a turned shape meet, the origin that is rounded to floats, which moves it along
 * the face too, may lie beyond the other face. */
static bool at_joint(const setting *s, const surface *at) {
    if (s->subject->edge == NULL) return false;
    real far = length(wide_d(s->at)) + 200 * s->size;
    if (s->placed) far += (real)s->far;
    return s->subject->edge(s->shape, wide_d(at->p)) < 0x1p-20L * far;
}

static void check_no_self_hit(setting *s, const surface *at) {
    if (at_joint(s, at)) return;
    for (int i = 0; i < 2; i++) {
        dvec3 d = direction();
        if (i == 1) { /* along the surface, up to 1e-7 out of it */
            double out = dvec3_dot(d, at->n);
            d = dvec3_sub(d, dvec3_scale(at->n, out * (1 - 1e-7)));
        }
        local_ray next = {{0, 0, 0}, vec3_from(d), 0, INFINITY};
        double side = dvec3_dot(at->n, dvec3_from(next.d));
        if (side == 0) continue;
        next.o = surface_offset_origin(at, side);
        check_leaving(s, at, &next, side);
    }
}

static transform random_transform(double size) {
    dvec3 z = direction(), x, y;
    dvec3_frame(z, &x, &y);
    double a = between(0.1, 3), b = between(0.1, 3), c = between(-3, -0.1);
    dvec3 move = dvec3_scale(direction(), size * 100);
    return (transform){{{(float)(a * x.x), (float)(b * y.x), (float)(c * z.x), (float)move.x},
                        {(float)(a * x.y), (float)(b * y.y), (float)(c * z.y), (float)move.y},
                        {(float)(a * x.z), (float)(b * y.z), (float)(c * z.z), (float)move.z}}};
}

/* Within a few float roundings of the box's edge, where "inside" is not a matter of one face: in an
 * instance the origin is rounded along the face too. */
static bool at_edge(const setting *s, const surface *at) {
    if (s->subject->edge) return at_joint(s, at);
    if (strcmp(s->type->info.name, "box") != 0) return false;
    surface other = *at;
    double near = 0x1p-20 * (dvec3_length(s->at) + 200 * s->size);
    for (int i = 0; i < 4; i++) { /* stepping along the face leaves it */
        dvec3 t, b;
        dvec3_frame(at->n, &t, &b);
        dvec3 step = dvec3_scale(i & 1 ? t : b, i & 2 ? near : -near);
        other.p = dvec3_add(at->p, step);
        if (s->subject->distance(s->shape, wide_d(other.p)) > 0) return true;
    }
    return false;
}

/* The same in an instance: the origin is found in the world and brought back in float. */
static void check_no_self_hit_in_instance(setting *s, const surface *at) {
    if (at_edge(s, at)) return;
    transform to_world = s->placed ? s->to_world : random_transform(s->size), to_local;
    assert_true(transform_inverse(&to_world, &to_local));
    surface world = *at;
    surface_to_world(&world, &to_world, &to_local);
    double norm = 0;
    for (int i = 0; i < 9; i++)
        norm += (double)to_local.m[i / 3][i % 3] * (double)to_local.m[i / 3][i % 3];
    if (!s->placed && dvec3_length(world.p) * sqrt(norm) > 16384 * s->size)
        return; /* too far for floats */
    s->instanced++;
    assert_true(fabs(dvec3_length(world.n) - 1) < 1e-14 && isfinite(world.error));
    vec3 d = vec3_from(direction());
    double side = dvec3_dot(world.n, dvec3_from(d));
    if (fabs(side) < 1e-5) return; /* rounding d in the instance may change its side */
    vec3 o = surface_offset_origin(&world, side);
    local_ray next = {vec3_from(transform_point(&to_local, dvec3_from(o))),
                      vec3_from(transform_vector(&to_local, dvec3_from(d))), 0, INFINITY};
    check_leaving(s, at, &next, side);
}

/* ---- kinds of rays ---- */

static local_ray ray_between(dvec3 from, dvec3 to) {
    vec3 o = vec3_from(from);
    dvec3 d = dvec3_scale(dvec3_normalize(dvec3_sub(to, dvec3_from(o))), between(0.3, 3));
    return (local_ray){o, vec3_from(d), 0, INFINITY};
}

/* last: a surface point met before. */
static local_ray own_ray(const setting *s, int kind, const surface *last) {
    dvec3 target = in_ball(s->at, s->size * 0.6);
    double far = s->size * exp2(between(0, 14));
    switch (kind) {
    case 0: return ray_between(dvec3_add(s->at, dvec3_scale(direction(), far)), target);
    case 1: return ray_between(in_ball(s->at, 0.3 * s->size), target);
    case 2: { /* along an axis */
        local_ray beam = ray_between(in_ball(s->at, 2 * s->size), target);
        float step = random_bits() & 1 ? 1.0f : -1.0f;
        int axis = (int)(random_bits() % 3);
        beam.d = (vec3){axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
        return beam;
    }
    case 3: { /* grazes: through a point of the surface, along a tangent or nearly so */
        dvec3 t, b;
        dvec3_frame(last->n, &t, &b);
        double angle = between(0, 2 * PI);
        dvec3 d = dvec3_add(dvec3_scale(t, cos(angle)), dvec3_scale(b, sin(angle)));
        double out = exp2(-between(1, 50));
        d = dvec3_add(d, dvec3_scale(last->n, random_bits() & 1 ? out : -out));
        return ray_between(dvec3_sub(last->p, dvec3_scale(d, far)), last->p);
    }
    case 4: return ray_between(last->p, target); /* starts on the surface, as near as floats are */
    default: {                                   /* with a range */
        local_ray beam = ray_between(in_ball(s->at, 2 * s->size), target);
        beam.t_min = (float)(s->size * between(0, 2));
        beam.t_max = beam.t_min + (float)(s->size * between(0, 2));
        return beam;
    }
    }
}

/* Of a placed shape: a ray of floats in the world, as the shape sees it. */
static local_ray random_ray(const setting *s, int kind, const surface *last) {
    local_ray own = own_ray(s, kind, last);
    if (!s->placed) return own;
    vec3 o = vec3_from(transform_point(&s->to_world, dvec3_from(own.o)));
    vec3 d = vec3_from(transform_vector(&s->to_world, dvec3_from(own.d)));
    ray beam = ray_make(o, d, own.t_min, own.t_max);
    return local_ray_make(&beam, &s->to_local, false);
}

#if defined(__SANITIZE_ADDRESS__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

static int ray_count(void) {
    if (SANITIZED) return 5000;
    return getenv("SNELL_FULL") ? 1000000 : 50000;
}

/* SNELL_SHAPE=NAME: that one alone. */
static bool is_asked_for(const char *shape) {
    const char *only = getenv("SNELL_SHAPE");
    return only == NULL || strcmp(only, shape) == 0;
}

static void every_shape_agrees_with_a_slow_solver(void **state) {
    (void)state;
    const double sizes[] = {1e-3, 1, 1e3, 1e6}, offsets[] = {0, 1, 128, 16384};
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        if (s.type->intersect == NULL) continue; /* test_solids.c */
        if (s.type->primitive_count) continue;   /* test_curves.c and its like, test_accel.c */
        if (!is_asked_for(s.type->info.name)) continue;
        s.subject = subject_of(s.type);
        random_state = 12345 + i;
        clock_t start = clock();
        surface last = {0};
        bool met = false;
        for (int n = 0; n < ray_count(); n++) {
            int place = n / 50 % 16;
            if (n % 50 == 0) {
                setting_make(&s, sizes[place % 4], offsets[place / 4]);
                met = false;
            }
            local_ray beam = random_ray(&s, met ? n % 6 : 0, &last);
            hit found;
            if (!compare(&s, &beam, &found)) continue;
            s.type->surface(s.shape, &beam, &found, &last);
            met = true;
            check_surface(&s, &last);
            check_no_self_hit(&s, &last);
            check_no_self_hit_in_instance(&s, &last);
        }
        printf(
            "%s: %ld hits, %ld misses, %ld too close to call, %ld exits, %ld instanced; %.1f s\n",
            s.type->info.name, s.hits, s.misses, s.unclear, s.exits, s.instanced,
            (double)(clock() - start) / CLOCKS_PER_SEC);
        long rays = ray_count();
        assert_true(s.instanced > rays / 10 && s.hits > rays / 10 && s.misses > rays / 5);
        assert_true(s.unclear < rays * 6 / 10);
        if (!s.type->flat) assert_true(s.exits > rays / 10);
    }
}

/* ---- the stretches of a line inside ---- */

enum { SPANS = 16 };

static bool in_spans(const span *spans, int count, double t) {
    for (int i = 0; i < count; i++)
        if (t > spans[i].enter.t && t < spans[i].leave.t) return true;
    return false;
}

/* Points of the line, between and about the crossings, are inside by all three or by none. */
static long check_membership(const setting *s, const local_ray *beam, const span *spans,
                             int count) {
    long inside = 0;
    dvec3 d = dvec3_from(beam->d), o = dvec3_from(beam->o);
    double reach = s->size / dvec3_length(d);
    double middle = dvec3_dot(dvec3_sub(s->at, o), d) / dvec3_dot(d, d);
    for (int k = 0; k < 8; k++) {
        double t = middle + reach * between(-1, 1);
        if (k & 1 && count) { /* close to a crossing */
            const span *one = &spans[random_bits() % (uint64_t)count];
            double near = k & 2 ? one->enter.t : one->leave.t;
            if (isfinite(near)) t = near + reach * exp2(-between(1, 20)) * (k & 4 ? 1 : -1);
        }
        dvec3 p = dvec3_add(o, dvec3_scale(d, t));
        real distance = s->subject->distance(s->shape, wide_d(p));
        real magnitude = length(wide_d(p)) + length(wide_d(o)) + s->size;
        if (fabsl(distance) < 1e-12L * magnitude) continue;
        bool listed = in_spans(spans, count, t);
        if ((distance < 0) != listed || (s->type->side(s->shape, p) > 0) != listed)
            fail_msg("%s: by its spans t %g is %s, the distance is %Lg", s->type->info.name, t,
                     listed ? "inside" : "outside", distance);
        inside += listed;
    }
    return inside;
}

/* Every crossing of a line that is nowhere nearly tangent is a hit of it, and every hit a crossing. */
static void check_crossings(const setting *s, const local_ray *beam, const span *spans, int count) {
    root roots[ROOTS];
    int solved = s->subject->solve(s->shape, wide(beam->o), wide(beam->d), roots);
    for (int i = 0; i < solved; i++)
        if (fabsl(roots[i].margin) < 1e-8L) return;
    local_ray line = *beam;
    hit found = {0};
    int used = 0, ends = 0;
    for (int i = 0; i < count; i++) ends += isfinite(spans[i].enter.t) + isfinite(spans[i].leave.t);
    for (line.t_min = -INFINITY; s->type->intersect(s->shape, &line, &found);
         line.t_min = found.t) {
        int matches = 0;
        for (int i = 0; i < 2 * count; i++) {
            const surface_crossing *c = i & 1 ? &spans[i / 2].leave : &spans[i / 2].enter;
            if ((float)c->t != found.t) continue;
            used++; /* maybe with another's, of the other face at a corner */
            matches += c->u == found.u && c->v == found.v && c->primitive == found.primitive;
        }
        if (matches == 0)
            fail_msg("%s: the hit at %.9g is no crossing; size %g", s->type->info.name,
                     (double)found.t, s->size);
    }
    if (used < ends) fail_msg("%s: %d crossings, %d are hits", s->type->info.name, ends, used);
}

static void check_span_order(const setting *s, const local_ray *beam, const span *spans,
                             int count) {
    span few[SPANS];
    double last = -INFINITY;
    for (int i = 0; i < count; i++) {
        assert_true(i == 0 || spans[i].enter.t > last);
        assert_true(spans[i].enter.t < spans[i].leave.t);
        last = spans[i].leave.t;
    }
    for (int capacity = 0; capacity < count; capacity++)
        assert_int_equal(s->type->spans(s->shape, beam, few, capacity), capacity + 1);
}

static void spans_agree_with_sides_and_hits(void **state) {
    (void)state;
    const double sizes[] = {1e-3, 1, 1e3, 1e6}, offsets[] = {0, 1, 128, 16384};
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        assert_true((s.type->side == NULL) == (s.type->spans == NULL));
        if (s.type->spans == NULL) continue;
        s.subject = subject_of(s.type);
        random_state = 777 + i;
        long inside = 0, met = 0, open = 0, tested = 0;
        surface last = {0};
        for (int n = 0; n < 20000; n++) {
            int place = n / 20 % 16;
            if (n % 20 == 0) setting_make(&s, sizes[place % 4], offsets[place / 4]);
            local_ray beam = random_ray(&s, n % 3, &last);
            span spans[SPANS];
            int count = s.type->spans(s.shape, &beam, spans, SPANS);
            if (count == -1) {
                assert_int_equal(s.type->side(s.shape, s.at), -1);
                open++;
                continue;
            }
            assert_true(count >= 0 && count <= SPANS);
            tested++;
            met += count > 0;
            check_span_order(&s, &beam, spans, count);
            inside += check_membership(&s, &beam, spans, count);
            check_crossings(&s, &beam, spans, count);
        }
        printf("%s: %ld lines, %ld met it, %ld points inside, %ld were open\n", s.type->info.name,
               tested, met, inside, open);
        assert_true(tested > 3000 && met > tested / 4 && inside > tested / 2);
        local_ray still = {{0, 0, 0}, {0, 0, 0}, 0, INFINITY};
        span none[SPANS];
        assert_true(s.type->unbounded || s.type->spans(s.shape, &still, none, SPANS) <= 0);
    }
}

/* Two rays side by side: the normal turns by what `bend`, or the curvature, says; for shapes that bend
 * the same in all directions, and those that have a bend of their own. */
static void bend_says_how_normals_turn(void **state) {
    (void)state;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        bool round = strcmp(s.type->info.name, "sphere") == 0;
        if (s.type->intersect == NULL || !(s.type->bend || s.type->flat || round)) continue;
        if (s.type->intersect == NULL) continue; /* test_solids.c */
        if (s.type->primitive_count) continue;   /* test_curves.c and its like, test_accel.c */
        s.subject = subject_of(s.type);
        random_state = 4321 + i;
        long tested = 0, wrong = 0;
        for (int n = 0; n < 4000; n++) {
            setting_make(&s, 1, 0);
            local_ray beam = random_ray(&s, 0, NULL);
            hit one, two;
            surface first, second;
            if (!s.type->intersect(s.shape, &beam, &one)) continue;
            s.type->surface(s.shape, &beam, &one, &first);
            if (at_edge(&s, &first) || first.curvature > 100) continue;
            dvec3 o = dvec3_add(first.p, dvec3_scale(first.n, 1e-2)), x, y;
            dvec3_frame(first.n, &x, &y);
            double angle = between(0, 2 * PI);
            dvec3 step =
                dvec3_add(dvec3_scale(x, cos(angle) * 1e-4), dvec3_scale(y, sin(angle) * 1e-4));
            beam.d = vec3_from(dvec3_negate(first.n));
            beam.o = vec3_from(o);
            if (!s.type->intersect(s.shape, &beam, &one)) continue;
            s.type->surface(s.shape, &beam, &one, &first);
            beam.o = vec3_from(dvec3_add(o, step));
            if (!s.type->intersect(s.shape, &beam, &two)) continue;
            s.type->surface(s.shape, &beam, &two, &second);
            dvec3 dp = dvec3_sub(second.p, first.p), turn = dvec3_sub(second.ns, first.ns);
            if (dvec3_length(dp) > 1e-3) continue; /* another face */
            dvec3 said =
                s.type->bend ? s.type->bend(s.shape, &one, dp) : dvec3_scale(dp, first.curvature);
            double off = dvec3_length(dvec3_sub(said, turn)), size = dvec3_length(dp);
            tested++;
            wrong += off > 0.02 * (first.curvature + 0.5) * size;
        }
        printf("%s: %ld normals, %ld turn otherwise\n", s.type->info.name, tested, wrong);
        assert_true(tested > 300 && wrong * 100 <= tested);
    }
}

/* Every number of every shape: what its range does not allow, and what is no number. */
static void odd_numbers_are_refused(void **state) {
    (void)state;
    long refused = 0;
    const float odd[] = {NAN, INFINITY, -INFINITY, -1, 0};
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        const type_info *info = &primitive_types[i]->info;
        setting s = {.type = primitive_types[i]};
        if (s.type->intersect == NULL || s.type->primitive_count) continue;
        s.subject = subject_of(s.type);
        setting_make(&s, 1, 1);
        for (uint32_t k = 0; k < info->field_count; k++) {
            const field *f = &info->fields[k];
            int parts = f->kind == FIELD_FLOAT ? 1 : f->kind == FIELD_VEC3 ? 3 : 0;
            for (int part = 0; part < parts; part++)
                for (int n = 0; n < 5; n++) {
                    any_desc desc = s.desc;
                    memcpy(desc.room + f->offset + (size_t)part * sizeof(float), &odd[n],
                           sizeof(float));
                    bool allowed = isfinite(odd[n]) && (double)odd[n] >= f->min &&
                                   !((double)odd[n] == f->min && f->flags & FIELD_OPEN_MIN);
                    if (allowed && f->flags & FIELD_UNIT_LENGTH) continue; /* 0, 0, 0? */
                    snell_status status = desc_check(info, &desc, NULL);
                    assert_int_equal(status == SNELL_OK, allowed);
                    if (allowed) continue;
                    refused++;
                    assert_non_null(strstr(error_last()->text, f->name));
                    assert_memory_equal(error_last()->text, info->name, strlen(info->name));
                }
        }
    }
    assert_true(refused > 150);
}

static void odd_rays_give_no_nan_and_no_hit(void **state) {
    (void)state;
    const float odd[] = {0, -0.0f, NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-45f, 1, -1};
    const int count = sizeof odd / sizeof odd[0];
    random_state = 99;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        if (s.type->intersect == NULL) continue; /* test_solids.c */
        if (s.type->primitive_count) continue;   /* test_curves.c and its like, test_accel.c */
        s.subject = subject_of(s.type);
        setting_make(&s, 1, 1);
        for (int n = 0; n < 20000; n++) {
            float x[6];
            for (int k = 0; k < 6; k++) x[k] = odd[random_bits() % (uint64_t)count];
            local_ray beam = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, 0, INFINITY};
            hit found;
            if (s.type->intersect(s.shape, &beam, &found)) {
                assert_true(found.t > 0 && found.t < INFINITY);
                surface at;
                s.type->surface(s.shape, &beam, &found, &at);
            }
        }
        local_ray still = {{0, 0, 0}, {0, 0, 0}, 0, INFINITY};
        hit found;
        assert_false(s.type->intersect(s.shape, &still, &found));
    }
}

/* ---- reference values ---- */

static vec3 json_vec3(const json_t *array) {
    return (vec3){(float)reference_number(array, 0), (float)reference_number(array, 1),
                  (float)reference_number(array, 2)};
}

static int references_used;

static void check_reference(const reference_case *c) {
    json_t *shape = json_array_get(json_object_get(c->scene, "geometry"), 0);
    json_t *line = json_object_get(c->scene, "ray");
    const primitive_type *type = primitive_find(json_string_value(json_object_get(shape, "type")));
    if (type == NULL) return; /* triangles are tested by the kernels */
    any_desc desc;
    desc_init(&type->info, &desc);
    const char *key;
    json_t *value;
    json_object_foreach(shape, key, value) {
        if (strcmp(key, "type") == 0) continue;
        snell_param param = {.name = key, .kind = SNELL_PARAM_VEC3, .value.v = json_vec3(value)};
        if (strcmp(key, "R") == 0) param.name = "major";
        if (strcmp(key, "r") == 0) param.name = "minor";
        if (json_is_string(value)) { /* the torus' axis */
            assert_string_equal(json_string_value(value), "z");
            param.value.v = (vec3){0, 0, 1};
        }
        if (json_is_number(value)) {
            param.kind = SNELL_PARAM_FLOAT;
            param.value.f = json_number_value(value);
        }
        assert_int_equal(desc_set(&type->info, &desc, &param), SNELL_OK);
    }
    local_ray beam = {json_vec3(json_object_get(line, "o")), json_vec3(json_object_get(line, "d")),
                      0, INFINITY};
    size_t count = json_array_size(c->expected);
    for (size_t i = 0; i < count; i++) {
        hit found;
        assert_true(type->intersect(&desc, &beam, &found));
        assert_true(reference_agrees(c, (double)found.t, reference_number(c->expected, i)));
        beam.t_min = found.t; /* the next root */
    }
    hit found;
    assert_false(type->intersect(&desc, &beam, &found));
    references_used++;
}

static void reference_intersections(void **state) {
    (void)state;
    assert_true(reference_each("L.intersections", check_reference) == 8);
    assert_int_equal(references_used, 7); /* three spheres, a box, three tori */
}

/* ---- texture coordinates and frames ---- */

static surface look_at(const primitive_type *type, const void *desc, dvec3 from, dvec3 to) {
    local_ray beam = {vec3_from(from), vec3_from(dvec3_sub(to, from)), 0, INFINITY};
    hit found;
    assert_true(type->intersect(desc, &beam, &found));
    surface out;
    type->surface(desc, &beam, &found, &out);
    if (type->parametrise) type->parametrise(desc, &out);
    return out;
}

static void assert_uv(const surface *s, double u, double v) {
    if (fabs(s->u - u) > 1e-6 || fabs(s->v - v) > 1e-6)
        fail_msg("uv is %g %g, not %g %g", s->u, s->v, u, v);
}

static void texture_coordinates_lie_as_documented(void **state) {
    (void)state;
    const dvec3 middle = {0, 0, 0};
    const primitive_type *type = primitive_find("sphere");
    any_desc desc;
    desc_init(&type->info, &desc);
    surface s = look_at(type, &desc, (dvec3){0, 0, 5}, middle);
    assert_uv(&s, 0.5, 0.5);
    s = look_at(type, &desc, (dvec3){5, 0, 0}, middle); /* right of +Z, seen from outside */
    assert_uv(&s, 0.75, 0.5);
    s = look_at(type, &desc, (dvec3){0, 5, 5}, middle);
    assert_uv(&s, 0.5, 0.75);

    type = primitive_find("plane");
    desc_init(&type->info, &desc);
    s = look_at(type, &desc, (dvec3){3, 5, -2}, (dvec3){3, 0, -2});
    assert_uv(&s, 3, 2);

    type = primitive_find("disk");
    desc_init(&type->info, &desc);
    s = look_at(type, &desc, (dvec3){0.5, 5, 0}, (dvec3){0.5, 0, 0});
    assert_uv(&s, 0, 0.5);
    s = look_at(type, &desc, (dvec3){0, 5, -0.25}, (dvec3){0, 0, -0.25});
    assert_uv(&s, 0.25, 0.25);

    type = primitive_find("quad");
    desc_init(&type->info, &desc);
    desc.quad.u = (vec3){2, 0, 0};
    desc.quad.v = (vec3){0, 4, 0};
    s = look_at(type, &desc, (dvec3){0.5, 1, 3}, (dvec3){0.5, 1, 0});
    assert_uv(&s, 0.25, 0.25);
    assert_true(s.n.z == 1);

    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.min = (vec3){-1, -1, -1};
    desc.box.max = (vec3){1, 1, 1};
    /* A point right of and above the middle of each face, as seen from outside with +Y up. */
    const dvec3 outward[6] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    const dvec3 up[6] = {{0, 1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 1, 0}, {0, 1, 0}};
    for (int i = 0; i < 6; i++) {
        dvec3 right = dvec3_cross(up[i], outward[i]);
        dvec3 at = dvec3_add(dvec3_scale(right, 0.5), dvec3_scale(up[i], 0.2));
        s = look_at(type, &desc, dvec3_add(at, dvec3_scale(outward[i], 3)), at);
        assert_true(dvec3_dot(s.n, outward[i]) == 1);
        assert_uv(&s, 0.75, 0.6);
    }
}

static void closed_shapes_and_half_spaces_have_sides(void **state) {
    (void)state;
    any_desc desc;
    const primitive_type *type = primitive_find("sphere");
    desc_init(&type->info, &desc);
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0, 0}), 1);
    assert_int_equal(type->side(&desc, (dvec3){1.5, 0, 0}), -1);
    type = primitive_find("plane");
    desc_init(&type->info, &desc);
    assert_int_equal(type->side(&desc, (dvec3){7, -1, 0}), 1);
    assert_int_equal(type->side(&desc, (dvec3){7, 1, 0}), -1);
    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.max = (vec3){1, 1, 1};
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.5, 0.5}), 1);
    assert_int_equal(type->side(&desc, (dvec3){0.5, 0.5, 1.5}), -1);
    assert_null(primitive_find("quad")->side);
    assert_null(primitive_find("ball"));
}

static void senseless_shapes_are_refused(void **state) {
    (void)state;
    any_desc desc;
    const primitive_type *type = primitive_find("disk");
    desc_init(&type->info, &desc);
    desc.disk.inner_radius = 1;
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text,
                        "disk: 'inner_radius' is 1; it must be less than 'radius', 1");
    type = primitive_find("box");
    desc_init(&type->info, &desc);
    desc.box.min = (vec3){0, 2, 0};
    desc.box.max = (vec3){1, 1, 1};
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "box: 'min' y is 2 and 'max' y is 1");
    type = primitive_find("quad");
    desc_init(&type->info, &desc);
    desc.quad.u = (vec3){0.1f, 0.2f, 0.3f};
    desc.quad.v = (vec3){0.2f, 0.4f, 0.6f};
    assert_int_equal(type->check(&desc), SNELL_ERR_ARGUMENT);
}

/* ---- meshes ---- */

static const vec3 corners[] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {2, 2, 0}};
static const uint32_t two_triangles[] = {0, 1, 2, 1, 3, 2};

static mesh_desc square(void) {
    return (mesh_desc){
        .positions = corners, .positions_count = 4, .indices = two_triangles, .indices_count = 6};
}

static void a_mesh_is_checked(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("mesh");
    mesh_desc mesh = square();
    assert_int_equal(type->check(&mesh), SNELL_OK);
    bounds3 box = type->bounds(&mesh);
    assert_true(box.min.x == 0 && box.max.x == 2 && box.max.y == 2 && box.max.z == 0);
    mesh.positions_count = 3;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text,
                        "mesh: index 3 of triangle 1 is out of range: there are 3 positions");
    mesh = square();
    mesh.indices_count = 5;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh = square();
    mesh.normals = corners;
    mesh.normals_count = 3;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->text, "mesh: 'normals' has 3 entries for 4 positions");
    mesh = square();
    const uint32_t slots[] = {0, 1};
    const snell_material_id materials[2] = {{1, 0}, {2, 0}};
    mesh.material_slots = slots;
    mesh.material_slots_count = 2;
    mesh.materials = materials;
    mesh.materials_count = 1;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh.materials_count = 2;
    assert_int_equal(type->check(&mesh), SNELL_OK);
    mesh.material_slots_count = 1;
    assert_int_equal(type->check(&mesh), SNELL_ERR_ARGUMENT);
    mesh = (mesh_desc){.struct_size = sizeof mesh}; /* empty */
    assert_int_equal(type->check(&mesh), SNELL_OK);
    assert_true(bounds3_is_empty(type->bounds(&mesh)));
}

static void a_point_on_a_mesh_is_blended(void **state) {
    (void)state;
    const primitive_type *type = primitive_find("mesh");
    mesh_desc mesh = square();
    const vec3 normals[] = {{0, 0, 2}, {1, 0, 0}, {0, 0, 5}, {0, 0, 0}};
    const vec2 uvs[] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const vec3 colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    const uint8_t alphas[] = {255, 0, 255, 255};
    const uint32_t slots[] = {7, 3};
    local_ray beam = {{0.5f, 0.5f, 1}, {0, 0, -1}, 0, INFINITY};
    hit found = {.t = 1, .u = 0.25f, .v = 0.25f};
    surface s;
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.p.x == 0.5 && s.p.y == 0.5 && s.p.z == 0 && s.n.z == 1 && s.ns.z == 1);
    assert_uv(&s, 0.25, 0.25); /* barycentrics */
    assert_true(s.tint.x == 1 && s.alpha == 1 && s.material_slot == 0);

    mesh.normals = normals;
    mesh.uvs = uvs;
    mesh.colors = colors;
    mesh.alphas = alphas;
    mesh.material_slots = slots;
    mesh.normals_count = mesh.uvs_count = mesh.colors_count = mesh.alphas_count = 4;
    mesh.material_slots_count = 2;
    type->surface(&mesh, &beam, &found, &s);
    double length_ns = sqrt(0.75 * 0.75 + 0.25 * 0.25);
    assert_true(fabs(s.ns.x - 0.25 / length_ns) < 1e-12 && fabs(s.ns.z - 0.75 / length_ns) < 1e-12);
    assert_uv(&s, 0.25, 0.25);
    assert_true(s.tint.x == 0.5 && s.tint.y == 0.25 && s.tint.z == 0.25 && s.alpha == 0.75);
    assert_int_equal(s.material_slot, 7);
    found = (hit){.t = 1, .u = 1, .v = 0, .primitive = 1}; /* at a vertex without a normal */
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.ns.z == 1 && s.p.x == 2 && s.p.y == 2 && s.material_slot == 3);
    assert_uv(&s, 1, 1);
    found = (hit){.t = 1, .u = 0.7f, .v = 0.7f}; /* rounding: never outside the triangle */
    type->surface(&mesh, &beam, &found, &s);
    assert_true(fabs(s.p.x - 1) < 1e-12 && fabs(s.p.y - 1) < 1e-12);

    const uint32_t degenerate[] = {0, 0, 1};
    mesh.indices = degenerate;
    mesh.indices_count = 3;
    found = (hit){.t = 1};
    type->surface(&mesh, &beam, &found, &s);
    assert_true(s.n.z == 1 && isfinite(s.ns.x)); /* faces the ray */
}

/* The float test that the kernels use (Woop, Benthin, Wald 2013), without its double case. */
static bool float_triangle(const vec3 v[3], const local_ray *beam, float *t) {
    float d[3] = {beam->d.x, beam->d.y, beam->d.z};
    int kz = fabsf(d[0]) > fabsf(d[1]) ? (fabsf(d[0]) > fabsf(d[2]) ? 0 : 2)
                                       : (fabsf(d[1]) > fabsf(d[2]) ? 1 : 2);
    int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
    float sx = d[kx] / d[kz], sy = d[ky] / d[kz], sz = 1 / d[kz], x[3], y[3], z[3];
    for (int i = 0; i < 3; i++) {
        float a[3] = {v[i].x - beam->o.x, v[i].y - beam->o.y, v[i].z - beam->o.z};
        x[i] = a[kx] - sx * a[kz];
        y[i] = a[ky] - sy * a[kz];
        z[i] = sz * a[kz];
    }
    float e0 = x[2] * y[1] - y[2] * x[1], e1 = x[0] * y[2] - y[0] * x[2],
          e2 = x[1] * y[0] - y[1] * x[0];
    if ((e0 < 0 || e1 < 0 || e2 < 0) && (e0 > 0 || e1 > 0 || e2 > 0)) return false;
    float det = e0 + e1 + e2;
    if (det == 0) return false;
    *t = (e0 * z[0] + e1 * z[1] + e2 * z[2]) / det;
    return *t > 0;
}

/* On a flat floor of triangles a ray that leaves one must not meet its neighbours: their planes
 * agree only up to the rounding of their vertices, and the kernels test in float. To that test a
 * ray within 32 roundings of the tangent plane sees the floor edge-on, and its t may be anything.
 */
static void a_ray_that_leaves_a_floor_meets_no_neighbour(void **state) {
    (void)state;
    enum { SIDE = 4, COUNT = SIDE * SIDE };
    const primitive_type *type = primitive_find("mesh");
    uint32_t indices[6 * (SIDE - 1) * (SIDE - 1)];
    size_t used = 0;
    for (uint32_t i = 0; i + 1 < SIDE; i++)
        for (uint32_t j = 0; j + 1 < SIDE; j++) {
            uint32_t a = i * SIDE + j,
                     cell[6] = {a, a + 1, a + SIDE, a + 1, a + SIDE + 1, a + SIDE};
            memcpy(indices + used, cell, sizeof cell);
            used += 6;
        }
    random_state = 7;
    long tested = 0, near_hits = 0, edge_on = 0;
    for (int n = 0; n < 8000; n++) {
        double size = exp2(between(-10, 20)), far = size * exp2(between(-4, 14));
        dvec3 at = dvec3_scale(direction(), far), x, y, z = direction();
        if (n % 4 == 0) z = (dvec3){0, 1, 0};
        dvec3_frame(z, &x, &y);
        vec3 positions[COUNT];
        for (int i = 0; i < COUNT; i++) {
            double a = size * (i / SIDE + between(-0.3, 0.3));
            double b = size * (i % SIDE + between(-0.3, 0.3));
            dvec3 offset = dvec3_add(dvec3_scale(x, a), dvec3_scale(y, b));
            positions[i] = vec3_from(dvec3_add(at, offset));
        }
        mesh_desc mesh = {.positions = positions,
                          .positions_count = COUNT,
                          .indices = indices,
                          .indices_count = used};
        hit found = {.t = 1, .primitive = (uint32_t)(random_bits() % (used / 3))};
        found.u = (float)exp2(-between(1, 24)); /* also near an edge */
        found.v = (float)exp2(-between(1, 24));
        local_ray first = {{0, 0, 0}, vec3_from(dvec3_negate(z)), 0, INFINITY};
        surface s;
        type->surface(&mesh, &first, &found, &s);
        for (int k = 0; k < 16; k++) {
            dvec3 d = direction();
            double slope = exp2(-between(0, 26)); /* also nearly along the floor */
            if (k & 1) d = dvec3_sub(d, dvec3_scale(s.n, dvec3_dot(d, s.n) * (1 - slope)));
            local_ray next = {{0, 0, 0}, vec3_from(d), 0, INFINITY};
            double side = dvec3_dot(s.n, dvec3_from(next.d));
            next.o = surface_offset_origin(&s, side);
            for (size_t i = 0; i < used / 3; i++) {
                if (i == found.primitive) continue;
                vec3 v[3];
                for (int c = 0; c < 3; c++) v[c] = positions[indices[3 * i + (size_t)c]];
                vec normal = cross(minus(wide(v[1]), wide(v[0])), minus(wide(v[2]), wide(v[0])));
                real height = dot(normal, minus(wide(next.o), wide(v[0]))) * side;
                float t;
                bool is_hit = float_triangle(v, &next, &t);
                tested++;
                /* A rounded floor has real dents: below the neighbour's plane a hit is true. */
                if (is_hit && height <= 0) near_hits++;
                if (!(is_hit && height > 0 && dot(normal, wide(next.d)) * side > 0)) continue;
                if (fabs(side) <= 32 * FLOAT_EPSILON * dvec3_length(dvec3_from(next.d)))
                    edge_on++;
                else
                    fail_msg("met a neighbour at t %g, size %g", (double)t, size);
            }
        }
    }
    printf("floor: %ld tests, %ld true hits of dents, %ld edge-on\n", tested, near_hits, edge_on);
    assert_true(tested > 500000 && edge_on < 100);
}

/* Where a shape is far from 0: in its own space, in the world, or in its own although it is near in the
 * world. */
enum { FAR_ITSELF, FAR_IN_WORLD, FAR_IN_INSTANCE, WAYS_TO_BE_FAR };

/* Along the axis on which it is far. */
static double normal_along(const setting *s, int how, const surface *at) {
    surface world = *at;
    if (how == FAR_IN_WORLD) surface_to_world(&world, &s->to_world, &s->to_local);
    return s->subject->upright && how != FAR_IN_WORLD ? world.n.y : world.n.x;
}

static void setting_make_far(setting *s, int how) {
    s->size = s->subject->fixed_size > 0 ? s->subject->fixed_size : 1;
    double far = 16384 * s->size;
    dvec3 away = {s->subject->upright ? 0 : far, s->subject->upright ? far : 0, 0};
    s->at = how == FAR_IN_WORLD ? (dvec3){0, 0, 0} : away;
    s->placed = how != FAR_ITSELF;
    if (how == FAR_IN_WORLD) setting_place(s, 1, (dvec3){far, 0, 0});
    if (how == FAR_IN_INSTANCE) {
        setting_place(s, 1, (dvec3){0, 0, 0});
        dvec3 back = transform_point(&s->to_world, away);
        s->to_world.m[0][3] = (float)-back.x;
        s->to_world.m[1][3] = (float)-back.y;
        s->to_world.m[2][3] = (float)-back.z;
        assert_true(transform_inverse(&s->to_world, &s->to_local));
    }
    setting_finish(s);
}

static bool meet(const setting *s, dvec3 way, dvec3 target, surface *at) {
    local_ray beam = ray_between(dvec3_sub(target, dvec3_scale(way, 3 * s->size)), target);
    hit found;
    if (!s->type->intersect(s->shape, &beam, &found)) return false;
    s->type->surface(s->shape, &beam, &found, at);
    return true;
}

/* A place between two that two rays meet: some way to the one where that changes its sign, for there p
 * itself may be a float. */
static bool meet_where_normal_turns(const setting *s, int how, surface *at) {
    dvec3 way = direction(), low = in_ball(s->at, 0.5 * s->size),
          high = in_ball(s->at, 0.5 * s->size);
    if (!meet(s, way, low, at)) return false;
    bool low_sign = normal_along(s, how, at) > 0;
    if (!meet(s, way, high, at) || (normal_along(s, how, at) > 0) == low_sign) return false;
    for (int i = 4 + (int)(random_bits() % 12); i > 0; i--) {
        dvec3 middle = dvec3_scale(dvec3_add(low, high), 0.5);
        if (!meet(s, way, middle, at)) return false;
        *((normal_along(s, how, at) > 0) == low_sign ? &low : &high) = middle;
    }
    return at->curvature > 0;
}

/* Guards against an origin that steps beyond p along n, but is rounded so far along the surface that this
 * bends away under it: n is at right angles to an axis on which p has a large coordinate. */
static void beside_a_far_surface_the_origin_stays_on_its_side(void **state) {
    (void)state;
    const int places = SANITIZED ? 50 : 1000;
    for (uint32_t i = 0; i < primitive_type_count; i++) {
        setting s = {.type = primitive_types[i]};
        if (!s.type->intersect || s.type->primitive_count || s.type->flat) continue;
        if (!is_asked_for(s.type->info.name)) continue;
        s.subject = subject_of(s.type);
        random_state = 11 + i;
        for (int how = 0; how < WAYS_TO_BE_FAR; how++) {
            if (s.subject->centered && how != FAR_IN_WORLD) continue;
            int met = 0;
            for (int n = 0; met < places && n < 200 * places; n++) {
                surface at;
                if (n % 20 == 0) setting_make_far(&s, how);
                if (!meet_where_normal_turns(&s, how, &at)) continue;
                met++;
                if (s.placed)
                    check_no_self_hit_in_instance(&s, &at);
                else
                    check_no_self_hit(&s, &at);
            }
            /* A box has no curvature. */
            assert_true(met == places || strcmp(s.type->info.name, "box") == 0);
        }
    }
}

/* Guard against lengths of the world among those of the shape: in an instance that is 2^18 times as large
 * and as far away, every error is 2^18 times as large. */
static void an_instance_of_another_size_has_errors_of_its_size(void **state) {
    (void)state;
    const float scale = 0x1p18f;
    random_state = 5;
    for (int n = 0; n < 1000; n++) {
        dvec3 far = place(exp2(between(0, 16)));
        surface near = surface_make(direction(), direction(), 1e-14), large;
        near.curvature = exp2(between(-4, 12));
        large = near;
        vec3 move = vec3_from(far);
        transform one = {{{1, 0, 0, move.x}, {0, 1, 0, move.y}, {0, 0, 1, move.z}}}, inverse;
        assert_true(transform_inverse(&one, &inverse));
        surface_to_world(&near, &one, &inverse);
        transform other = {{{scale, 0, 0, move.x * scale},
                            {0, scale, 0, move.y * scale},
                            {0, 0, scale, move.z * scale}}};
        assert_true(transform_inverse(&other, &inverse));
        surface_to_world(&large, &other, &inverse);
        assert_true(fabs(large.error - near.error * (double)scale) < 1e-6 * large.error);
    }
}

/* Guard against fields that are so nearly 0 along a ray that the looks at them run out, and with them what
 * lies behind: a Julia set that the ray leaves by an inflection, and a formula whose bounds are bad. */
static void what_lies_behind_a_flat_place_is_met(void **state) {
    (void)state;
    setting s = {.type = primitive_find("julia")};
    s.subject = subject_of(s.type);
    desc_init(&s.type->info, &s.desc);
    julia_like *julia = (void *)&s.desc;
    julia->c = (vec3){-0.647760212f, 0.33033374f, 0.170542225f};
    julia->c_k = 0.209787786f;
    julia->slice = 0.0655437782f;
    julia->iterations = 4;
    julia->escape = 3;
    void *shape = s.type->prepare(julia);
    assert_non_null(shape);
    local_ray beam = {{0.301944405f, -0.681729674f, 0.391848326f},
                      {0.398916066f, 0.087862961f, -0.213784724f},
                      0,
                      INFINITY};
    hit found;
    assert_true(s.type->intersect(shape, &beam, &found));
    assert_true(fabs((double)found.t - 1.09884531781) < 1e-6);
    s.type->release(shape);

    s.type = primitive_find("implicit");
    desc_init(&s.type->info, &s.desc);
    implicit_like *implicit = (void *)&s.desc;
    implicit->f =
        "min(sin(999*x) - 2*sin(499.5*x)*cos(499.5*x) + 2e-6, length(x - 0.8, y, z) - 0.1)";
    implicit->min = (vec3){-1, -1, -1};
    implicit->max = (vec3){1, 1, 1};
    shape = s.type->prepare(implicit);
    assert_non_null(shape);
    beam = (local_ray){{-3, 0, 0}, {1, 0, 0}, 0, INFINITY};
    assert_true(s.type->intersect(shape, &beam, &found));
    assert_true(fabs((double)found.t - 3.7) < 1e-6);
    s.type->release(shape);
}

static void the_next_origin_is_beyond(void **state) {
    (void)state;
    random_state = 3;
    for (int n = 0; n < 200000; n++) {
        dvec3 place = dvec3_scale(direction(), exp2(between(-20, 30)));
        double error = exp2(between(-60, 10));
        surface s = surface_make(place, direction(), error);
        if (n % 3 == 0) s.n = (dvec3){0, n & 1 ? 1 : -1, 0};
        if (n % 5 == 0) s.error = 0;
        if (n % 7 == 0) s.p = dvec3_from(vec3_from(place)); /* exactly on floats */
        double side = n & 2 ? 1 : -1;
        vec3 o = surface_offset_origin(&s, side);
        vec moved = minus(wide(o), wide_d(s.p));
        real out = dot(moved, wide_d(s.n)) * side;
        assert_true(out > 0 && out >= s.error * (1 - 1e-15));
        real ulp = 0x1p-23L * length(wide_d(s.p)) + 0x1p-149L;
        assert_true(length(moved) <= 2 * s.error + 4 * ulp); /* and not needlessly far */
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_shape_agrees_with_a_slow_solver),
        cmocka_unit_test(spans_agree_with_sides_and_hits),
        cmocka_unit_test(bend_says_how_normals_turn),
        cmocka_unit_test(odd_numbers_are_refused),
        cmocka_unit_test(odd_rays_give_no_nan_and_no_hit),
        cmocka_unit_test(reference_intersections),
        cmocka_unit_test(texture_coordinates_lie_as_documented),
        cmocka_unit_test(closed_shapes_and_half_spaces_have_sides),
        cmocka_unit_test(senseless_shapes_are_refused),
        cmocka_unit_test(a_mesh_is_checked),
        cmocka_unit_test(a_point_on_a_mesh_is_blended),
        cmocka_unit_test(a_ray_that_leaves_a_floor_meets_no_neighbour),
        cmocka_unit_test(beside_a_far_surface_the_origin_stays_on_its_side),
        cmocka_unit_test(an_instance_of_another_size_has_errors_of_its_size),
        cmocka_unit_test(what_lies_behind_a_flat_place_is_met),
        cmocka_unit_test(the_next_origin_is_beyond),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    reference_free();
    release_prepared();
    return failed;
}
