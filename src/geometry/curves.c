/* Strands of hair, grass or wire: very many curves in one shape. Each strand is cut into segments,
 * polynomials of degree 1 or 3 in s, and those of degree 3 into pieces with boxes of their own.
 *
 * A round curve is what a ball sweeps whose centre c(s) and radius r(s) run along it, ends and all;
 * what lies inside the segment before or after is left out, so that a strand is one closed surface, at
 * kinks too, as long as it is thinner than it bends. A ribbon is flat and turns about the curve to face
 * each ray: it has every point that is at most r(s) from c(s) across both the ray and the curve.
 *
 * Texture coordinates: u along the strand, by segments, 0 to 1; v around it, from a direction that is
 * the same all along the strand, or across the ribbon. */
#include "base/error.h"
#include "geometry/bernstein.h"
#include "geometry/surface.h"
#include "maths/functions.h"

#define CURVES_FIELDS(F, T)                                                                        \
    F(T, points, VEC3S, NO_DEFAULT, REQUIRED, "m", "of all strands, one after the other")          \
    F(T, radii, FLOATS, NO_DEFAULT, NOT_NEGATIVE, "m", "one per point, instead of 'radius'")       \
    F(T, radius, FLOAT, DEFAULT(0.01f), POSITIVE, "m", "half the thickness of all strands")        \
    F(T, starts, UINTS, NO_DEFAULT, ANY, "",                                                       \
      "number, from 0, of the first point of each strand; none: one strand")                       \
    F(T, basis, CHOICE, DEFAULT(0), CHOICES("catmull_rom|bspline|bezier|linear"), "",              \
      "through the points, smoothly near them, by control points, straight")                       \
    F(T, kind, CHOICE, DEFAULT(0), CHOICES("round|ribbon"), "",                                    \
      "a round thread, or a flat one that faces each sight")
DESCRIBE(curves, CURVES_FIELDS)

enum { CATMULL_ROM, BSPLINE, BEZIER, LINEAR };
enum { ROUND, RIBBON };
/* Pieces of a segment of degree 3. More: tighter boxes, but more of them. */
enum { PIECES = 4, POINTS_MAX = 1 << 26 };

/* ---- strands, segments and pieces ----
 * Piece k of the segment number j of the strand that begins at point i is the shape's part
 * PIECES (i + j) + k: what has no segment has an empty box. */

typedef struct strand {
    size_t first, count; /* points */
} strand;

static size_t strand_count(const curves_desc *curves) {
    return curves->starts_count ? curves->starts_count : 1;
}

static strand strand_at(const curves_desc *curves, size_t index) {
    size_t last = curves->points_count;
    if (curves->starts_count == 0) return (strand){0, last};
    if (index + 1 < curves->starts_count) last = curves->starts[index + 1];
    return (strand){curves->starts[index], last - curves->starts[index]};
}

/* The strand of a point. Strands tend to be equally long: the guess is mostly right. */
static strand strand_of(const curves_desc *curves, size_t point) {
    size_t low = 0, high = strand_count(curves), at;
    at = (size_t)((double)point / (double)curves->points_count * (double)high);
    for (;;) {
        if (at >= high) at = high - 1;
        strand s = strand_at(curves, at);
        if (point < s.first)
            high = at;
        else if (point >= s.first + s.count)
            low = at + 1;
        else
            return s;
        at = low + (high - low) / 2;
    }
}

static size_t segment_count(const curves_desc *curves, size_t points) {
    return curves->basis == BEZIER ? (points - 1) / 3 : points - 1;
}

static uint32_t pieces_of(const curves_desc *curves) {
    return curves->basis == LINEAR ? 1 : PIECES;
}

typedef struct control {
    dvec3 p;
    double r;
} control;

/* A piece: its segment, of degree 1 or 3 in Bernstein form, from `low` to `high`. */
typedef struct piece {
    control at[4];
    int degree;
    double low, high;
    bool begins, ends; /* the strand does, at s = 0 or 1 of the piece */
    size_t segment, segments;
    dvec3 across; /* where v is 0.5: as far as it is at right angles to the curve */
} piece;

static control control_at(const curves_desc *curves, size_t point) {
    double r = curves->radii_count ? (double)curves->radii[point] : (double)curves->radius;
    return (control){dvec3_from(curves->points[point]), r};
}

static control blend(control a, double wa, control b, double wb) {
    return (control){dvec3_add(dvec3_scale(a.p, wa), dvec3_scale(b.p, wb)), a.r * wa + b.r * wb};
}

/* Point i of the strand; the one before the first and the one after the last are reflections, so that
 * both kinds of splines go from the first point to the last one. */
static control neighbour(const curves_desc *curves, const strand *s, size_t i, int step) {
    size_t at = s->first + i;
    if (step < 0 ? i > 0 : i + 1 < s->count) return control_at(curves, step < 0 ? at - 1 : at + 1);
    size_t other = step < 0 ? at + 1 : at - 1;
    control c = blend(control_at(curves, at), 2, control_at(curves, other), -1);
    c.r = double_max(c.r, 0);
    return c;
}

/* The axis that is most at right angles to the strand's chord. */
static dvec3 across_of(const curves_desc *curves, const strand *s) {
    dvec3 from = dvec3_from(curves->points[s->first]);
    dvec3 d = dvec3_sub(dvec3_from(curves->points[s->first + s->count - 1]), from);
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    if (x <= y && x <= z) return (dvec3){1, 0, 0};
    return z <= y ? (dvec3){0, 0, 1} : (dvec3){0, 1, 0};
}

static void set_controls(const curves_desc *curves, const strand *s, size_t j, piece *out) {
    size_t at = s->first + (curves->basis == BEZIER ? 3 * j : j);
    control a = control_at(curves, at), b = control_at(curves, at + 1);
    out->degree = curves->basis == LINEAR ? 1 : 3;
    out->at[0] = a;
    out->at[out->degree] = b;
    if (curves->basis == LINEAR) return;
    if (curves->basis == BEZIER) {
        for (size_t i = 0; i < 4; i++) out->at[i] = control_at(curves, at + i);
        return;
    }
    control before = neighbour(curves, s, j, -1), after = neighbour(curves, s, j + 1, 1);
    if (curves->basis == CATMULL_ROM) {
        out->at[1] = blend(a, 1, blend(b, 1, before, -1), 1.0 / 6);
        out->at[2] = blend(b, 1, blend(after, 1, a, -1), -1.0 / 6);
        for (int i = 1; i < 3; i++) out->at[i].r = double_max(out->at[i].r, 0);
        return;
    }
    control near_a = blend(a, 2.0 / 3, b, 1.0 / 3), near_b = blend(b, 2.0 / 3, a, 1.0 / 3);
    out->at[0] = blend(blend(before, 1.0 / 3, a, 2.0 / 3), 0.5, near_a, 0.5);
    out->at[1] = near_a;
    out->at[2] = near_b;
    out->at[3] = blend(near_b, 0.5, blend(b, 2.0 / 3, after, 1.0 / 3), 0.5);
}

/* False: there is no such piece. */
static bool piece_at(const curves_desc *curves, uint32_t part, piece *out) {
    uint32_t pieces = pieces_of(curves), k = part % pieces;
    strand s = strand_of(curves, part / pieces);
    size_t j = part / pieces - s.first;
    out->segments = segment_count(curves, s.count);
    if (j >= out->segments) return false;
    out->segment = j;
    out->low = (double)k / pieces;
    out->high = (double)(k + 1) / pieces;
    out->begins = j == 0 && k == 0;
    out->ends = j + 1 == out->segments && k + 1 == pieces;
    out->across = across_of(curves, &s);
    set_controls(curves, &s, j, out);
    return true;
}

/* One coordinate of the controls, or the radius, over the piece alone. */
enum { X, Y, Z, RADIUS };
static void coefficients(const piece *c, int which, double *out) {
    for (int i = 0; i <= c->degree; i++) {
        const control *at = &c->at[i];
        out[i] = which == X ? at->p.x : which == Y ? at->p.y : which == Z ? at->p.z : at->r;
    }
    bernstein_restrict(out, c->degree, c->low, c->high);
}

/* Centre and radius at s of the piece, and how they change with the segment's own parameter. */
typedef struct place {
    dvec3 c, slope;
    double r, r_slope;
} place;

static place place_at(const piece *c, double s) {
    double v[4], x[4], slope[4], at = c->low + (c->high - c->low) * s;
    for (int which = X; which <= RADIUS; which++) {
        for (int i = 0; i <= c->degree; i++) {
            const control *k = &c->at[i];
            x[i] = which == X ? k->p.x : which == Y ? k->p.y : which == Z ? k->p.z : k->r;
        }
        v[which] = bernstein_value(x, c->degree, at, &slope[which]);
    }
    return (place){{v[X], v[Y], v[Z]}, {slope[X], slope[Y], slope[Z]}, v[RADIUS], slope[RADIUS]};
}

/* ---- rays ---- */

/* A ray with its origin where it is nearest to the piece and d made unit; t of the ray is
 * (t here + shift) / speed. x, y, d: a frame. */
typedef struct line {
    dvec3 o, d, x, y;
    double shift, speed;
} line;

static bool line_make(const piece *c, const local_ray *beam, line *out) {
    out->d = dvec3_from(beam->d);
    out->speed = dvec3_length(out->d);
    if (!(out->speed > 0)) return false;
    out->d = dvec3_scale(out->d, 1 / out->speed);
    dvec3 o = dvec3_from(beam->o), middle = dvec3_add(c->at[0].p, c->at[c->degree].p);
    out->shift = dvec3_dot(dvec3_sub(dvec3_scale(middle, 0.5), o), out->d);
    out->o = dvec3_add(o, dvec3_scale(out->d, out->shift));
    dvec3_frame(out->d, &out->x, &out->y);
    return true;
}

/* The piece as the ray sees it: across it x and y, along it z. */
typedef struct view {
    int degree;
    double x[4], y[4], z[4], r[4];
} view;

static view view_of(const piece *c, const line *sight) {
    view v = {.degree = c->degree};
    for (int i = 0; i <= c->degree; i++) {
        dvec3 p = dvec3_sub(c->at[i].p, sight->o);
        v.x[i] = dvec3_dot(p, sight->x);
        v.y[i] = dvec3_dot(p, sight->y);
        v.z[i] = dvec3_dot(p, sight->d);
        v.r[i] = c->at[i].r;
    }
    double *all[] = {v.x, v.y, v.z, v.r};
    for (int i = 0; i < 4; i++) bernstein_restrict(all[i], c->degree, c->low, c->high);
    return v;
}

/* Cheap: is the ray outside the box, across it, of all that the piece may reach? */
static bool passes_by(const view *v) {
    double low_x = INFINITY, low_y = INFINITY, high_x = -INFINITY, high_y = -INFINITY;
    for (int i = 0; i <= v->degree; i++) {
        double r = fabs(v->r[i]);
        low_x = double_min(low_x, v->x[i] - r);
        low_y = double_min(low_y, v->y[i] - r);
        high_x = double_max(high_x, v->x[i] + r);
        high_y = double_max(high_y, v->y[i] + r);
    }
    return low_x > 0 || low_y > 0 || high_x < 0 || high_y < 0;
}

/* A place where the ray meets the surface; t as in `line`. */
typedef struct crossing {
    double t, s;
} crossing;
enum { CROSSINGS_MAX = 8 };

static void insert(crossing *list, int *count, crossing c) {
    if (*count == CROSSINGS_MAX) return;
    int i = (*count)++;
    for (; i > 0 && list[i - 1].t > c.t; i--) list[i] = list[i - 1];
    list[i] = c;
}

/* Splines have none, but for radii that would fall below 0. */
static bool may_have_kinks(const curves_desc *curves) {
    return curves->basis == BEZIER || curves->basis == LINEAR ||
           (curves->basis == CATMULL_ROM && curves->radii_count > 0);
}

/* Do the segments meet at s = 1 of `a`, 0 of `b` in a kink, of the curve or of its radius? */
static bool is_kink(const piece *a, const piece *b) {
    const control *in = &a->at[a->degree - 1], *joint = &b->at[0], *out = &b->at[1];
    dvec3 before = dvec3_sub(joint->p, in->p), after = dvec3_sub(out->p, joint->p);
    dvec3 turn = dvec3_sub(after, before);
    double swell = out->r - joint->r - (joint->r - in->r), small = 0x1p-40;
    return dvec3_dot(turn, turn) + swell * swell >
           small * (dvec3_dot(before, before) + dvec3_dot(after, after));
}

/* What `solve` is off by, at right angles to the surface, for a ray that starts near it: h is a
 * difference of squares of what the piece's controls are away from the ray, and off by a few roundings
 * of them; so is x^2 + y^2 from r^2, and the distance by that over 2 r, or its root at a tip. */
static double rounding_at(const piece *c, dvec3 p, double r) {
    double size = 0, far = fabs(p.x) + fabs(p.y) + fabs(p.z);
    for (int i = 0; i <= c->degree; i++)
        size = double_max(size, dvec3_length(dvec3_sub(c->at[i].p, p)) + fabs(c->at[i].r));
    double square = 64 * DOUBLE_EPSILON * size * size;
    return 32 * DOUBLE_EPSILON * (size + far) + double_min(square / r, sqrt(square));
}

/* Is p deeper in the ball that sweeps the whole segment than rounding? */
static bool is_inside(const piece *c, dvec3 p) {
    int n = c->degree;
    double value[4] = {0}, square[7], f[7] = {0}, slope[6], places[8] = {0, 1};
    bool any = false;
    for (int which = X; which <= RADIUS; which++) {
        for (int i = 0; i <= n; i++) {
            dvec3 to = dvec3_sub(c->at[i].p, p);
            value[i] = which == X ? to.x : which == Y ? to.y : which == Z ? to.z : c->at[i].r;
        }
        bernstein_multiply(value, n, value, n, square);
        for (int i = 0; i <= 2 * n; i++) f[i] += which == RADIUS ? -square[i] : square[i];
    }
    for (int i = 0; i <= 2 * n; i++) any |= f[i] < 0;
    if (!any) return false;
    bernstein_derivative(f, 2 * n, slope);
    int count = 2 + bernstein_roots(slope, 2 * n - 1, places + 2, 6);
    for (int i = 0; i < count; i++) {
        double r = bernstein_value(value, n, places[i], NULL); /* the radii came last */
        if (bernstein_value(f, 2 * n, places[i], NULL) < -2 * r * rounding_at(c, p, r)) return true;
    }
    return false;
}

/* Does a neighbour hide the point p, at s of the piece? Beyond a kink it may have p inside. At a joint
 * it hides p if its own way from there leads towards p; where neither reaches beyond p, both have it:
 * a seam, rather than a gap. */
static bool is_covered(const curves_desc *curves, uint32_t part, const piece *c, double s,
                       dvec3 p) {
    piece next;
    uint32_t pieces = pieces_of(curves);
    if (curves->kind == ROUND && may_have_kinks(curves)) {
        if (c->segment > 0 && piece_at(curves, part - pieces, &next) && is_kink(&next, c) &&
            is_inside(&next, p))
            return true;
        if (c->segment + 1 < c->segments && piece_at(curves, part + pieces, &next) &&
            is_kink(c, &next) && is_inside(&next, p))
            return true;
        if (curves->basis == LINEAR) return false;
    }
    if (s != 0 && s != 1) return false;
    if (s == 0 ? c->begins : c->ends) return false;
    if (!piece_at(curves, s == 0 ? part - 1 : part + 1, &next)) return false;
    place joint = place_at(&next, 1 - s);
    double swell = curves->kind == ROUND ? joint.r * joint.r_slope : 0;
    double towards = dvec3_dot(dvec3_sub(p, joint.c), joint.slope) + swell;
    return (s == 0 ? -towards : towards) > 0x1p-30 * joint.r * dvec3_length(joint.slope);
}

static dvec3 point_on(const line *sight, double t) {
    return dvec3_add(sight->o, dvec3_scale(sight->d, t));
}

static void add_crossing(const curves_desc *curves, uint32_t part, const piece *c,
                         const line *sight, crossing at, crossing *list, int *count) {
    if (!is_covered(curves, part, c, at.s, point_on(sight, at.t))) insert(list, count, at);
}

/* ---- round ----
 * The ball of s meets the ray where z(s) -+ sqrt(h(s)), h = r^2 - x^2 - y^2, if h(s) >= 0. Over an
 * interval of s with h >= 0 these stretches make up one stretch of the ray, from the least of z -
 * sqrt(h) to the largest of z + sqrt(h). Both are at an end of the interval or where (2 z' sqrt(h) -+
 * h') = 0: at roots of q = 4 z'^2 h - h'^2, a polynomial. */

typedef struct sweep {
    int degree;      /* of h */
    double h[7], *z; /* z: of the view */
    double sign;     /* -1: where the ray enters, 1: where it leaves */
} sweep;

static double reach(const sweep *w, double s) {
    double h = bernstein_value(w->h, w->degree, s, NULL);
    return bernstein_value(w->z, w->degree / 2, s, NULL) + w->sign * sqrt(double_max(h, 0));
}

/* Newton's method on the slope of `reach`, as long as that gets farther. */
static crossing polish(const sweep *w, double s, double t, double low, double high) {
    int n = w->degree / 2;
    double dz[3], dh[6];
    bernstein_derivative(w->z, n, dz);
    bernstein_derivative(w->h, w->degree, dh);
    for (int i = 0; i < 3; i++) {
        double bend = 0, curl;
        double slope = n > 1 ? bernstein_value(dz, n - 1, s, &bend) : dz[0];
        double fall = bernstein_value(dh, w->degree - 1, s, &curl);
        double h = bernstein_value(w->h, w->degree, s, NULL);
        if (!(h > 0)) break;
        double root = sqrt(h), value = 2 * slope * root + w->sign * fall;
        double next = s - value / (2 * bend * root + slope * fall / root + w->sign * curl);
        if (!(next > low && next < high)) break;
        double there = reach(w, next);
        if (!(w->sign * (there - t) >= 0)) break;
        s = next;
        t = there;
    }
    return (crossing){t, s};
}

/* The end of the stretch over low..high, among the places in s. */
static crossing extreme(const sweep *w, const double *places, int count, double low, double high) {
    crossing best = {reach(w, low), low}, other = {reach(w, high), high};
    if (w->sign * (other.t - best.t) > 0) best = other;
    for (int i = 0; i < count; i++) {
        if (!(places[i] > low && places[i] < high)) continue;
        double t = reach(w, places[i]);
        if (w->sign * (t - best.t) > 0) best = (crossing){t, places[i]};
    }
    if (best.s == low || best.s == high) return best;
    return polish(w, best.s, best.t, low, high);
}

/* Where the ray may turn from deeper to shallower, or back. */
static int find_places(const sweep *w, double *places) {
    int n = w->degree / 2, count;
    double dz[3], dh[6], slopes[5], falls[11], q[11];
    bernstein_derivative(w->z, n, dz);
    bernstein_derivative(w->h, w->degree, dh);
    bernstein_multiply(dz, n - 1, dz, n - 1, slopes);
    bernstein_multiply(slopes, 2 * n - 2, w->h, w->degree, q);
    bernstein_multiply(dh, w->degree - 1, dh, w->degree - 1, falls);
    for (int i = 0; i <= 4 * n - 2; i++) q[i] = 4 * q[i] - falls[i];
    count = bernstein_roots(q, 4 * n - 2, places, 12);
    /* Where z' is 0 too, q has a double root: the one of h' stands for it. */
    return count + bernstein_roots(dh, w->degree - 1, places + count, 6);
}

typedef struct stretch {
    crossing enter, leave;
} stretch;

static void add_stretch(stretch *list, int *count, stretch s) {
    for (int i = 0; i < *count; i++) {
        if (s.enter.t > list[i].leave.t || s.leave.t < list[i].enter.t) continue;
        if (list[i].enter.t < s.enter.t) s.enter = list[i].enter;
        if (list[i].leave.t > s.leave.t) s.leave = list[i].leave;
        list[i--] = list[--*count];
    }
    list[(*count)++] = s;
}

static int solve_round(const curves_desc *curves, uint32_t part, const piece *c, const line *sight,
                       view *v, crossing list[CROSSINGS_MAX]) {
    sweep w = {.degree = 2 * v->degree, .z = v->z};
    double xx[7], yy[7], ends[16] = {0}, places[18];
    bernstein_multiply(v->r, v->degree, v->r, v->degree, w.h);
    bernstein_multiply(v->x, v->degree, v->x, v->degree, xx);
    bernstein_multiply(v->y, v->degree, v->y, v->degree, yy);
    bool any = false;
    for (int i = 0; i <= w.degree; i++) {
        w.h[i] -= xx[i] + yy[i];
        any |= w.h[i] > 0;
    }
    if (!any) return 0;
    int end_count = 1 + bernstein_roots(w.h, w.degree, ends + 1, 12), stretch_count = 0, count = 0;
    ends[end_count++] = 1;
    int place_count = -1;
    stretch stretches[8];
    for (int i = 0; i + 1 < end_count; i++) {
        double low = ends[i], high = ends[i + 1];
        if (!(bernstein_value(w.h, w.degree, (low + high) / 2, NULL) > 0)) continue;
        if (place_count < 0) place_count = find_places(&w, places);
        stretch s;
        w.sign = -1;
        s.enter = extreme(&w, places, place_count, low, high);
        w.sign = 1;
        s.leave = extreme(&w, places, place_count, low, high);
        if (stretch_count < 8) add_stretch(stretches, &stretch_count, s);
    }
    for (int i = 0; i < stretch_count; i++) {
        add_crossing(curves, part, c, sight, stretches[i].enter, list, &count);
        add_crossing(curves, part, c, sight, stretches[i].leave, list, &count);
    }
    return count;
}

/* ---- ribbons ----
 * The curve's plane across the ray at z(s) holds the ray's point if x x' + y y' = 0. Beyond a joint,
 * where that is nowhere, there is half a disk. */
static int solve_ribbon(const curves_desc *curves, uint32_t part, const piece *c, const line *sight,
                        const view *v, crossing list[CROSSINGS_MAX]) {
    int n = v->degree, count = 0;
    double dx[3], dy[3], across[6], other[6], places[8];
    bernstein_derivative(v->x, n, dx);
    bernstein_derivative(v->y, n, dy);
    bernstein_multiply(v->x, n, dx, n - 1, across);
    bernstein_multiply(v->y, n, dy, n - 1, other);
    for (int i = 0; i < 2 * n; i++) across[i] += other[i];
    int place_count = bernstein_roots(across, 2 * n - 1, places, 6);
    double slack = 0x1p-40 * fabs(v->r[0] * (fabs(dx[0]) + fabs(dy[0])));
    if (across[0] >= (c->begins ? -slack : 0)) places[place_count++] = 0;
    if (across[2 * n - 1] <= (c->ends ? slack : 0)) places[place_count++] = 1;
    for (int i = 0; i < place_count; i++) {
        double s = places[i], x = bernstein_value(v->x, n, s, NULL),
               y = bernstein_value(v->y, n, s, NULL), r = bernstein_value(v->r, n, s, NULL);
        if (x * x + y * y > r * r) continue;
        bool beyond = (s == 0 && c->begins && across[0] > slack) ||
                      (s == 1 && c->ends && across[2 * n - 1] < -slack);
        if (beyond) continue;
        crossing at = {bernstein_value(v->z, n, s, NULL), s};
        add_crossing(curves, part, c, sight, at, list, &count);
    }
    return count;
}

/* In ascending order. */
static int solve(const curves_desc *curves, uint32_t part, const piece *c, const line *sight,
                 crossing list[CROSSINGS_MAX]) {
    view v = view_of(c, sight);
    if (passes_by(&v)) return 0;
    if (curves->kind == RIBBON) return solve_ribbon(curves, part, c, sight, &v, list);
    return solve_round(curves, part, c, sight, &v, list);
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    piece c;
    line sight;
    crossing list[CROSSINGS_MAX];
    if (!piece_at(desc, found->primitive, &c) || !line_make(&c, beam, &sight)) return false;
    int count = solve(desc, found->primitive, &c, &sight, list);
    for (int i = 0; i < count; i++) {
        if (!surface_accept(beam, (list[i].t + sight.shift) / sight.speed, &found->t)) continue;
        found->u = (float)list[i].s;
        found->v = 0;
        return true;
    }
    return false;
}

/* ---- points ---- */

/* Along the curve, across it where v is 0.5, and across both. */
typedef struct axes {
    dvec3 along, x, y;
} axes;

static axes axes_at(const piece *c, const place *at) {
    axes a = {.along = dvec3_normalize(at->slope)};
    if (!(dvec3_dot(a.along, a.along) > 0)) {
        dvec3 chord = dvec3_sub(c->at[c->degree].p, c->at[0].p);
        a.along = dvec3_normalize(chord);
        if (!(dvec3_dot(chord, chord) > 0))
            a.along = (dvec3){c->across.y, c->across.z, c->across.x};
    }
    a.x = dvec3_sub(c->across, dvec3_scale(a.along, dvec3_dot(a.along, c->across)));
    if (dvec3_length(a.x) > 0x1p-30)
        a.x = dvec3_normalize(a.x);
    else
        dvec3_frame(a.along, &a.x, &a.y);
    a.y = dvec3_cross(a.along, a.x);
    return a;
}

/* The point of the swept surface at s, at the angle with this cosine and sine. */
static dvec3 swept_point(const piece *c, double s, double cosine, double sine) {
    place at = place_at(c, s);
    axes a = axes_at(c, &at);
    double speed = dvec3_length(at.slope), lean = speed > 0 ? -at.r_slope / speed : 0;
    double flat = sqrt(double_max(1 - lean * lean, 0));
    dvec3 n = dvec3_add(dvec3_scale(a.along, lean),
                        dvec3_add(dvec3_scale(a.x, flat * cosine), dvec3_scale(a.y, flat * sine)));
    return dvec3_add(at.c, dvec3_scale(n, at.r));
}

/* How far the curve's own bend is from straight, 1/m. */
static double bend_of(const piece *c, double s) {
    const double step = 0x1p-12;
    dvec3 before = place_at(c, s - step).slope, after = place_at(c, s + step).slope,
          slope = place_at(c, s).slope;
    double speed = dvec3_length(slope), turn = 2 * step * (c->high - c->low);
    dvec3 change = dvec3_scale(dvec3_sub(after, before), 1 / turn);
    double bend = dvec3_length(dvec3_cross(slope, change)) / (speed * speed * speed);
    return bend <= 0x1p100 ? bend : 0;
}

static void fill_round(const piece *c, double s, dvec3 p, surface *out) {
    place at = place_at(c, s);
    axes a = axes_at(c, &at);
    dvec3 n = dvec3_normalize(dvec3_sub(p, at.c));
    if (!(dvec3_dot(n, n) > 0)) n = a.x;
    double r = double_max(at.r, 0x1p-149), curvature = 1 / r;
    p = dvec3_add(at.c, dvec3_scale(n, at.r));
    double error = rounding_at(c, p, r) + surface_shift_error(p, curvature + 2 * bend_of(c, s));
    *out = surface_make(p, n, error);
    out->curvature = curvature;
    double x = dvec3_dot(n, a.x), y = dvec3_dot(n, a.y), flat = sqrt(x * x + y * y);
    out->v = flat > 0 ? 0.5 + fn_atan2(y, x) / (2 * PI) : 0.5;
    double lean = dvec3_dot(n, at.slope) + at.r_slope;
    bool cap = (s == 0 || s == 1) && fabs(lean) > 0x1p-20 * dvec3_length(at.slope);
    if (!(flat > 0) || cap) return;
    x /= flat;
    y /= flat;
    const double step = 0x1p-17;
    dvec3 ahead = swept_point(c, s + step, x, y), behind = swept_point(c, s - step, x, y);
    double run = 2 * step * (c->high - c->low) / (double)c->segments;
    out->dpdu = dvec3_scale(dvec3_sub(ahead, behind), 1 / run);
    dvec3 around = dvec3_sub(dvec3_scale(a.y, x), dvec3_scale(a.x, y));
    out->dpdv = dvec3_scale(around, 2 * PI * at.r * flat);
}

/* Another ray sees the ribbon turned about the curve: nowhere farther away than r, so a ray that
 * starts farther away than that along n does not meet it on its way out. */
static void fill_ribbon(const piece *c, const line *sight, double s, dvec3 p, surface *out) {
    place at = place_at(c, s);
    axes a = axes_at(c, &at);
    dvec3 across = dvec3_normalize(dvec3_cross(a.along, dvec3_negate(sight->d)));
    if (!(dvec3_dot(across, across) > 0)) across = a.x; /* end on */
    across = dvec3_negate(across);
    dvec3 n = dvec3_normalize(dvec3_cross(a.along, across));
    double offset = dvec3_dot(dvec3_sub(p, at.c), across), r = double_max(at.r, 0x1p-149);
    offset = double_max(double_min(offset, at.r), -at.r);
    p = dvec3_add(at.c, dvec3_scale(across, offset));
    double turned = r * (1 + 0x1p-10 + r * bend_of(c, s));
    *out = surface_make(p, n, turned + rounding_at(c, p, r));
    out->v = clamp01(0.5 + offset / (2 * r));
    out->dpdu = dvec3_scale(at.slope, (double)c->segments);
    out->dpdv = dvec3_scale(across, 2 * at.r);
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const curves_desc *curves = desc;
    piece c = {0};
    line sight = {0};
    crossing list[CROSSINGS_MAX], at = {0, (double)found->u};
    if (!piece_at(curves, found->primitive, &c) || !line_make(&c, beam, &sight)) {
        *out = surface_make((dvec3){0, 0, 0}, (dvec3){0, 1, 0}, 0);
        return;
    }
    double wanted = (double)found->t * sight.speed - sight.shift;
    int count = solve(curves, found->primitive, &c, &sight, list);
    at.t = wanted;
    for (int i = 0; i < count; i++)
        if (i == 0 || fabs(list[i].t - wanted) < fabs(at.t - wanted)) at = list[i];
    dvec3 p = point_on(&sight, at.t);
    if (curves->kind == RIBBON)
        fill_ribbon(&c, &sight, at.s, p, out);
    else
        fill_round(&c, at.s, p, out);
    double along = c.low + (c.high - c.low) * at.s;
    out->u = clamp01(((double)c.segment + along) / (double)c.segments);
}

/* Only across the curve. */
static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    const curves_desc *curves = desc;
    piece c;
    if (curves->kind == RIBBON || !piece_at(curves, found->primitive, &c)) return (dvec3){0, 0, 0};
    place at = place_at(&c, (double)found->u);
    dvec3 along = dvec3_normalize(at.slope);
    dp = dvec3_sub(dp, dvec3_scale(along, dvec3_dot(along, dp)));
    return dvec3_scale(dp, 1 / double_max(at.r, 0x1p-149));
}

/* ---- boxes ---- */

static uint32_t primitive_count(const void *desc) {
    const curves_desc *curves = desc;
    return (uint32_t)curves->points_count * pieces_of(curves);
}

/* Of the balls around the controls: the curve and its radius are means of theirs. Wider by a few float
 * roundings, as for a sphere. */
static bounds3 primitive_bounds(const void *desc, uint32_t part) {
    piece c;
    double value[4][4], low[3], high[3], largest = 0;
    if (!piece_at(desc, part, &c)) return bounds3_empty();
    for (int which = X; which <= RADIUS; which++) coefficients(&c, which, value[which]);
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
        for (int i = 0; i <= c.degree; i++) {
            double r = fabs(value[RADIUS][i]);
            low[axis] = double_min(low[axis], value[axis][i] - r);
            high[axis] = double_max(high[axis], value[axis][i] + r);
        }
        largest = double_max(largest, double_max(fabs(low[axis]), fabs(high[axis])));
    }
    double wider = 4 * FLOAT_EPSILON * largest;
    return bounds3_outward((dvec3){low[X] - wider, low[Y] - wider, low[Z] - wider},
                           (dvec3){high[X] + wider, high[Y] + wider, high[Z] + wider});
}

static bounds3 bounds(const void *desc) {
    bounds3 box = bounds3_empty();
    uint32_t count = primitive_count(desc);
    for (uint32_t i = 0; i < count; i++) box = bounds3_union(box, primitive_bounds(desc, i));
    return box;
}

/* ---- what is refused ---- */

static snell_status check_strand(const curves_desc *curves, size_t index) {
    strand s = strand_at(curves, index);
    if (curves->basis == BEZIER && (s.count < 4 || s.count % 3 != 1))
        return error_set(SNELL_ERR_ARGUMENT, "4 points, and 3 for each further segment",
                         "curves: strand %zu has %zu points, which is no chain of Bezier curves",
                         index + 1, s.count);
    if (s.count < 2)
        return error_set(SNELL_ERR_ARGUMENT, "a strand is a line; use a sphere for a dot",
                         "curves: strand %zu has one point", index + 1);
    for (size_t i = 0; i < s.count; i++)
        if (curves->radii_count == 0 || curves->radii[s.first + i] > 0) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "radii are metres",
                     "curves: all radii of strand %zu are 0", index + 1);
}

static snell_status check(const void *desc) {
    const curves_desc *curves = desc;
    size_t points = curves->points_count;
    if (points == 0 || points > POINTS_MAX)
        return error_set(SNELL_ERR_ARGUMENT, points ? "split them into several shapes" : NULL,
                         "curves: 'points' has %zu entries; it must have 2 to %d", points,
                         POINTS_MAX);
    if (curves->radii_count && curves->radii_count != points)
        return error_set(SNELL_ERR_ARGUMENT, "give one per point, or none",
                         "curves: 'radii' has %zu entries for %zu points", curves->radii_count,
                         points);
    for (size_t i = 0; i < curves->starts_count; i++)
        if (i == 0 ? curves->starts[0] != 0
                   : curves->starts[i] <= curves->starts[i - 1] || curves->starts[i] >= points)
            return error_set(SNELL_ERR_ARGUMENT,
                             "the first is 0, each further one larger than the one before",
                             "curves: entry %zu of 'starts' is %u, with %zu points", i + 1,
                             curves->starts[i], points);
    snell_status status = SNELL_OK;
    for (size_t i = 0; !status && i < strand_count(curves); i++) status = check_strand(curves, i);
    return status;
}

extern const primitive_type primitive_curves;
const primitive_type primitive_curves = {
    .info = TYPE_INFO(CATEGORY_SHAPE, curves, "curves", "strands: hair, fur, grass, wire"),
    .check = check,
    .bounds = bounds,
    .primitive_count = primitive_count,
    .primitive_bounds = primitive_bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .bend = bend,
};
