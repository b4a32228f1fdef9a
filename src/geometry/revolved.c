#include "geometry/revolved.h"

#include "maths/functions.h"

/* ---- the line and its pieces ---- */

static profile_point point_at(const revolved *shape, size_t i) {
    if (shape->profile == NULL) return shape->own[i];
    return (profile_point){shape->profile[i].x, shape->profile[i].y - shape->base};
}

static size_t piece_count(const revolved *shape) { return shape->count - 1; }

typedef struct piece {
    profile_point a, b;
    double length;           /* 0: a point, or on the axis; it sweeps no surface */
    double along_r, along_y; /* the unit vector from a to b */
    double slack; /* m; a hit so far beyond an end counts, so that none falls between two pieces */
} piece;

static piece piece_at(const revolved *shape, size_t i) {
    piece made = {.a = point_at(shape, i), .b = point_at(shape, i + 1)};
    double r = made.b.r - made.a.r, y = made.b.y - made.a.y;
    if (made.a.r > 0 || made.b.r > 0) made.length = sqrt(r * r + y * y);
    if (made.length > 0) {
        made.along_r = r / made.length;
        made.along_y = y / made.length;
    }
    made.slack = 0x1p-44 * (made.a.r + made.b.r + fabs(made.a.y) + fabs(made.b.y));
    return made;
}

static double piece_area(const piece *p) { return PI * (p->a.r + p->b.r) * p->length; }

/* +1: normals are to the right of the line, which runs upwards; -1: to its left. */
static double orientation(const revolved *shape) {
    if (shape->profile == NULL) return 1;
    double swept = 0;
    for (size_t i = 0; i < piece_count(shape); i++) {
        profile_point a = point_at(shape, i), b = point_at(shape, i + 1);
        swept += (a.r + b.r) * (b.y - a.y);
    }
    return swept < 0 ? -1 : 1;
}

revolved revolved_frustum(vec3 from, vec3 to, double radius, double radius_to, bool capped) {
    revolved made = {.origin = dvec3_from(from), .capped = capped, .closed = capped};
    dvec3 axis = dvec3_sub(dvec3_from(to), made.origin), across;
    double height = dvec3_length(axis);
    made.y = dvec3_normalize(axis);
    dvec3_frame(made.y, &made.x, &across);
    made.z = dvec3_negate(across);
    if (capped) made.own[made.count++] = (profile_point){0, 0};
    made.own[made.count++] = (profile_point){radius, 0};
    made.own[made.count++] = (profile_point){radius_to, height};
    if (capped) made.own[made.count++] = (profile_point){0, height};
    return made;
}

static dvec3 to_frame(const revolved *shape, dvec3 v) {
    return (dvec3){dvec3_dot(v, shape->x), dvec3_dot(v, shape->y), dvec3_dot(v, shape->z)};
}

static dvec3 from_frame(const revolved *shape, dvec3 v) {
    return dvec3_add(dvec3_scale(shape->x, v.x),
                     dvec3_add(dvec3_scale(shape->y, v.y), dvec3_scale(shape->z, v.z)));
}

/* Every point sweeps a circle, whose half size along a coordinate is r sqrt(1 - axis_i^2). The box
 * is wider by a few float roundings: a ray that meets a rim must not miss the box. */
bounds3 revolved_bounds(const revolved *shape) {
    dvec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    dvec3 n = shape->y;
    dvec3 reach = {sqrt(n.y * n.y + n.z * n.z), sqrt(n.x * n.x + n.z * n.z),
                   sqrt(n.x * n.x + n.y * n.y)};
    for (size_t i = 0; i < shape->count; i++) {
        profile_point at = point_at(shape, i);
        dvec3 center = dvec3_add(shape->origin, dvec3_scale(n, at.y));
        dvec3 half = dvec3_scale(reach, at.r);
        dvec3 least = dvec3_sub(center, half), most = dvec3_add(center, half);
        low = (dvec3){double_min(low.x, least.x), double_min(low.y, least.y),
                      double_min(low.z, least.z)};
        high = (dvec3){double_max(high.x, most.x), double_max(high.y, most.y),
                       double_max(high.z, most.z)};
    }
    double largest = double_max(dvec3_largest(high), dvec3_largest(dvec3_negate(low)));
    double wider = 4 * FLOAT_EPSILON * (largest + dvec3_largest(dvec3_sub(high, low)));
    dvec3 margin = {wider, wider, wider};
    return bounds3_outward(dvec3_sub(low, margin), dvec3_add(high, margin));
}

/* ---- rays ---- */

/* A ray in the frame. Its origin is moved along it to where it is nearest to the middle of the axis,
 * so that a far origin does not drown the shape: t of the ray is t here + shift. */
typedef struct axis_ray {
    dvec3 o, d;
    double square, shift, middle; /* square: of d's length; middle: height of the axis' middle */
    double climb, nearest;        /* 1 / d.y; where it is nearest to the axis */
} axis_ray;

static bool axis_ray_make(const revolved *shape, const local_ray *beam, axis_ray *out) {
    out->o = to_frame(shape, dvec3_sub(dvec3_from(beam->o), shape->origin));
    out->d = to_frame(shape, dvec3_from(beam->d));
    out->square = dvec3_dot(out->d, out->d);
    if (!(out->square > 0)) return false;
    out->middle = (point_at(shape, 0).y + point_at(shape, shape->count - 1).y) / 2;
    dvec3 f = dvec3_sub((dvec3){0, out->middle, 0}, out->o);
    out->shift = dvec3_dot(f, out->d) / out->square;
    out->o = dvec3_add(out->o, dvec3_scale(out->d, out->shift));
    double flat = out->d.x * out->d.x + out->d.z * out->d.z;
    out->climb = 1 / out->d.y;
    out->nearest = flat > 0 ? -(out->o.x * out->d.x + out->o.z * out->d.z) / flat : 0;
    return true;
}

static dvec3 axis_ray_at(const axis_ray *line, double t) {
    return dvec3_add(line->o, dvec3_scale(line->d, t));
}

static bool is_beyond(const axis_ray *line, double t, double radius) {
    dvec3 p = axis_ray_at(line, t);
    return p.x * p.x + p.z * p.z > radius * radius;
}

/* Cheap and safe: does the ray, while it is at a piece's height, stay farther from the axis than both
 * its ends, or nearer? Its squared distance from the axis has one minimum and no maximum between. */
static bool passes_by(const axis_ray *line, profile_point a, profile_point b) {
    double r = double_max(a.r, b.r), low = double_min(a.y, b.y), high = double_max(a.y, b.y);
    double slack = 0x1p-36 * (r + fabs(low) + fabs(high));
    low -= slack;
    high += slack;
    if (line->d.y == 0) {
        if (line->o.y < low || line->o.y > high) return true;
        return is_beyond(line, line->nearest, r + slack);
    }
    double one = (low - line->o.y) * line->climb, other = (high - line->o.y) * line->climb;
    double enter = double_min(one, other), leave = double_max(one, other);
    if (is_beyond(line, double_min(double_max(line->nearest, enter), leave), r + slack))
        return true;
    double inner = double_min(a.r, b.r) - slack;
    if (!(inner > 0)) return false;
    dvec3 p = axis_ray_at(line, enter), q = axis_ray_at(line, leave);
    return p.x * p.x + p.z * p.z < inner * inner && q.x * q.x + q.z * q.z < inner * inner;
}

/* Is a point of the piece's cone, or plane, on the piece? The mirrored half of the cone, where the
 * radius would be negative, is not. */
static bool is_on_piece(const piece *s, dvec3 p) {
    double along, radius = sqrt(p.x * p.x + p.z * p.z);
    if (fabs(s->along_y) >= fabs(s->along_r))
        along = (p.y - s->a.y) / s->along_y;
    else
        along = (radius - s->a.r) / s->along_r;
    double w = s->along_y * s->a.r + s->along_r * (p.y - s->a.y);
    if (s->along_y < 0) w = -w;
    if (s->along_y != 0 && !(w >= -s->slack)) return false;
    return along >= -s->slack && along <= s->length + s->slack;
}

/* Up to two places of the piece, in the ray's shifted t. With (c, s) = (along_y, along_r) the cone is
 * c^2 rho^2 = w^2, w = c r_a + s (y - y_a); c rho - w is the distance from it. The origin is moved
 * once more, to the vertex of the quadratic: there its linear term vanishes, and the constant one,
 * (c rho - w)(c rho + w), says how far the ray is from being tangent without cancelling. */
static int solve_piece(const piece *s, const axis_ray *line, double t[2]) {
    if (!(s->length > 0)) return 0;
    dvec3 o = line->o, d = line->d;
    if (s->along_y == 0) {
        t[0] = (s->a.y - o.y) / d.y;
        return d.y != 0 && is_on_piece(s, axis_ray_at(line, t[0]));
    }
    double c = s->along_y, slope = s->along_r * d.y;
    double w = c * s->a.r + s->along_r * (o.y - s->a.y);
    double a = c * c * (d.x * d.x + d.z * d.z) - slope * slope;
    double b = c * c * (o.x * d.x + o.z * d.z) - w * slope, vertex = 0;
    double reach =
        4 * (s->a.r + s->b.r + fabs(s->a.y - line->middle) + fabs(s->b.y - line->middle));
    if (a != 0 && b * b * line->square <= reach * reach * a * a) {
        vertex = -b / a; /* if it is farther away no ray is tangent within reach */
        o = axis_ray_at(line, vertex);
        w = c * s->a.r + s->along_r * (o.y - s->a.y);
        b = c * c * (o.x * d.x + o.z * d.z) - w * slope;
    }
    double radius = sqrt(o.x * o.x + o.z * o.z);
    double constant = (c * radius - w) * (c * radius + w), discriminant = b * b - a * constant;
    if (!(discriminant >= 0)) return 0;
    double q = b > 0 ? -(b + sqrt(discriminant)) : sqrt(discriminant) - b;
    double root[2] = {q / a, constant / q};
    int count = 0;
    for (int i = 0; i < 2; i++) {
        if (i == 0 ? a == 0 : q == 0) continue;
        double at = vertex + root[i];
        if (is_on_piece(s, axis_ray_at(line, at))) t[count++] = at;
    }
    return count;
}

bool revolved_intersect(const revolved *shape, const local_ray *beam, hit *found) {
    axis_ray line;
    if (!axis_ray_make(shape, beam, &line)) return false;
    bool any = false;
    for (size_t i = 0; i < piece_count(shape); i++) {
        if (passes_by(&line, point_at(shape, i), point_at(shape, i + 1))) continue;
        piece s = piece_at(shape, i);
        double t[2];
        int count = solve_piece(&s, &line, t);
        for (int k = 0; k < count; k++) {
            float rounded;
            if (!surface_accept(beam, line.shift + t[k], &rounded)) continue;
            if (any && !(rounded < found->t)) continue;
            any = true;
            *found = (hit){.t = rounded,
                           .u = (float)i,
                           .v = 0,
                           .primitive = found->primitive,
                           .instance = found->instance};
        }
    }
    return any;
}

/* ---- inside ---- */

/* Even and odd crossings of the half-plane's line from the point away from the axis. p is in the
 * frame. */
static bool is_inside(const revolved *shape, dvec3 p) {
    double radius = sqrt(p.x * p.x + p.z * p.z);
    bool inside = false;
    for (size_t i = 0; i < piece_count(shape); i++) {
        profile_point a = point_at(shape, i), b = point_at(shape, i + 1);
        if ((a.y > p.y) == (b.y > p.y)) continue;
        if (radius < a.r + (p.y - a.y) / (b.y - a.y) * (b.r - a.r)) inside = !inside;
    }
    return inside;
}

int revolved_side(const revolved *shape, dvec3 p) {
    if (!shape->closed) return -1;
    return is_inside(shape, to_frame(shape, dvec3_sub(p, shape->origin))) ? 1 : -1;
}

enum { CROSSINGS = 16 };

/* The first CROSSINGS crossings beyond `after`, in the line's t, in ascending order. */
static int crossings_after(const revolved *shape, const axis_ray *line, double after,
                           surface_crossing out[CROSSINGS]) {
    int count = 0;
    for (size_t i = 0; i < piece_count(shape); i++) {
        if (passes_by(line, point_at(shape, i), point_at(shape, i + 1))) continue;
        piece s = piece_at(shape, i);
        double t[2];
        int roots = solve_piece(&s, line, t);
        for (int k = 0; k < roots; k++) {
            int place = count;
            if (!(t[k] > after)) continue;
            while (place > 0 && t[k] < out[place - 1].t) place--;
            if (place == CROSSINGS) continue;
            if (count < CROSSINGS) count++;
            for (int m = count - 1; m > place; m--) out[m] = out[m - 1];
            out[place] = (surface_crossing){.t = t[k], .u = (float)i};
        }
    }
    return count;
}

static surface_crossing shifted(surface_crossing crossing, double shift) {
    crossing.t += shift;
    return crossing;
}

/* Which of the stretches between crossings are inside is asked of their middles: where two pieces
 * meet there may be one crossing or two. */
int revolved_spans(const revolved *shape, const local_ray *beam, span *out, int capacity) {
    axis_ray line;
    surface_crossing next[CROSSINGS], enter = {0}, last = {.t = -INFINITY};
    int spans = 0, count = CROSSINGS;
    bool inside = false;
    if (!shape->closed) return -1;
    if (!axis_ray_make(shape, beam, &line)) return 0;
    while (count == CROSSINGS) {
        count = crossings_after(shape, &line, last.t, next);
        for (int i = 0; i < count; i++) {
            dvec3 middle = axis_ray_at(&line, (last.t + next[i].t) / 2);
            bool now = last.t > -INFINITY && is_inside(shape, middle);
            if (now && !inside) enter = shifted(last, line.shift);
            if (inside && !now)
                spans = surface_add_span(out, spans, capacity, enter, shifted(last, line.shift));
            inside = now;
            last = next[i];
        }
    }
    if (inside) spans = surface_add_span(out, spans, capacity, enter, shifted(last, line.shift));
    return spans;
}

/* ---- points ---- */

static profile_point piece_normal(const piece *s) {
    return (profile_point){s->along_y, -s->along_r};
}

#define COS_CREASE 0.76604444311897803520 /* of 40 degrees */

/* The normal beyond one end of piece i: of its neighbour, or across the axis of its own mirror image.
 * False: nothing is there. */
static bool normal_beyond(const revolved *shape, size_t i, bool end, profile_point *out) {
    piece s = piece_at(shape, i);
    profile_point n = piece_normal(&s), tip = end ? s.b : s.a;
    *out = (profile_point){-n.r, n.y};
    if (tip.r == 0) return true;
    size_t last = piece_count(shape) - 1, other = end ? i + 1 : i - 1;
    if (i == (end ? last : 0)) {
        profile_point first = point_at(shape, 0), final = point_at(shape, last + 1);
        if (first.r != final.r || first.y != final.y) return false;
        other = end ? 0 : last;
    }
    piece next = piece_at(shape, other);
    *out = piece_normal(&next);
    return next.length > 0;
}

/* The shading normal at one end of piece i: halfway to the one beyond, unless the line has a corner
 * there. */
static profile_point joint_normal(const revolved *shape, size_t i, bool end) {
    piece s = piece_at(shape, i);
    profile_point n = piece_normal(&s), m;
    if (!normal_beyond(shape, i, end, &m) || !(n.r * m.r + n.y * m.y > COS_CREASE)) return n;
    dvec3 half = dvec3_normalize((dvec3){n.r + m.r, n.y + m.y, 0});
    return (profile_point){half.x, half.y};
}

/* The place `along` (0..1) piece i at the angle whose sine and cosine are x and z. */
static void make_point(const revolved *shape, size_t i, double along, double x, double z,
                       surface *out) {
    piece s = piece_at(shape, i);
    double r = s.a.r + (s.b.r - s.a.r) * along, y = s.a.y + (s.b.y - s.a.y) * along;
    double turn = orientation(shape);
    profile_point flat = piece_normal(&s);
    dvec3 n = {turn * flat.r * x, turn * flat.y, turn * flat.r * z};
    dvec3 center = shape->origin;
    dvec3 p = dvec3_add(center, from_frame(shape, (dvec3){r * x, y, r * z}));
    double curvature = fabs(s.along_y) / double_max(r, 0x1p-149);
    double far = fabs(center.x) + fabs(center.y) + fabs(center.z);
    double error = 16 * DOUBLE_EPSILON * far + 4 * s.slack + surface_shift_error(p, curvature);
    *out = surface_make(p, dvec3_normalize(from_frame(shape, n)), error);
    out->curvature = curvature;
    out->u = (double)i;
    out->v = along;
    if (!shape->smooth) return;
    profile_point from = joint_normal(shape, i, false), to = joint_normal(shape, i, true);
    double nr = turn * (from.r + (to.r - from.r) * along);
    double ny = turn * (from.y + (to.y - from.y) * along);
    out->ns = dvec3_normalize(from_frame(shape, (dvec3){nr * x, ny, nr * z}));
}

void revolved_surface(const revolved *shape, const local_ray *beam, const hit *found,
                      surface *out) {
    size_t last = piece_count(shape) - 1;
    size_t i = found->u > 0 ? (size_t)double_min(found->u, (double)last) : 0;
    piece s = piece_at(shape, i);
    axis_ray line = {.shift = 0};
    dvec3 p = {1, 0, 0};
    if (axis_ray_make(shape, beam, &line)) {
        double t = found->t - line.shift, root[2];
        int count = solve_piece(&s, &line, root);
        if (count == 1) t = root[0];
        if (count == 2) t = fabs(root[0] - t) <= fabs(root[1] - t) ? root[0] : root[1];
        p = axis_ray_at(&line, t);
    }
    double radius = sqrt(p.x * p.x + p.z * p.z), along = 0;
    if (s.length > 0) along = ((radius - s.a.r) * s.along_r + (p.y - s.a.y) * s.along_y) / s.length;
    bool turned = radius > 0;
    make_point(shape, i, clamp01(along), turned ? p.x / radius : 0, turned ? p.z / radius : 1, out);
}

/* v at both ends of piece i. */
static void span_of(const revolved *shape, size_t i, double share[2]) {
    share[0] = 0;
    share[1] = 1;
    if (shape->profile == NULL) {
        if (shape->capped && i == 2) share[0] = 1, share[1] = 0;
        return;
    }
    double total = 0;
    for (size_t k = 0; k < piece_count(shape); k++) {
        profile_point a = point_at(shape, k), b = point_at(shape, k + 1);
        double r = b.r - a.r, y = b.y - a.y;
        if (k == i) share[0] = total;
        total += sqrt(r * r + y * y);
        if (k == i) share[1] = total;
    }
    share[0] /= total;
    share[1] /= total;
}

void revolved_parametrise(const revolved *shape, surface *s) {
    size_t i = s->u > 0 ? (size_t)s->u : 0;
    if (i >= piece_count(shape)) i = 0;
    piece at = piece_at(shape, i);
    dvec3 p = to_frame(shape, dvec3_sub(s->p, shape->origin));
    double share[2], radius = sqrt(p.x * p.x + p.z * p.z);
    span_of(shape, i, share);
    double step = share[1] - share[0], x = radius > 0 ? p.x / radius : 0;
    double z = radius > 0 ? p.z / radius : 1;
    s->u = 0.5 + fn_atan2(p.x, p.z) / (2 * PI);
    s->v = clamp01(share[0] + step * s->v);
    s->dpdu = from_frame(shape, (dvec3){2 * PI * p.z, 0, -2 * PI * p.x});
    if (step == 0) return;
    double r = (at.b.r - at.a.r) / step, y = (at.b.y - at.a.y) / step;
    s->dpdv = from_frame(shape, (dvec3){r * x, y, r * z});
}

/* ---- sampling ---- */

double revolved_area(const revolved *shape) {
    double area = 0;
    for (size_t i = 0; i < piece_count(shape); i++) {
        piece s = piece_at(shape, i);
        area += piece_area(&s);
    }
    return area;
}

/* u chooses the piece by area; what is left of it, the place along the piece, where the density
 * grows with the radius: (r_a s + (r_b - r_a) s^2 / 2) / ((r_a + r_b) / 2) = u, solved without
 * cancelling. v is the angle. */
void revolved_sample_area(const revolved *shape, double u, double v, surface *out) {
    double left = u * revolved_area(shape), rest = 0;
    size_t chosen = 0;
    for (size_t i = 0; i < piece_count(shape); i++) {
        piece s = piece_at(shape, i);
        double part = piece_area(&s);
        if (!(part > 0)) continue;
        chosen = i;
        rest = clamp01(left / part);
        if (left < part) break;
        left -= part;
    }
    piece s = piece_at(shape, chosen);
    double a = s.a.r, b = s.b.r, root = sqrt(a * a + rest * (b - a) * (b + a));
    double along = a + root > 0 ? clamp01(rest * (a + b) / (a + root)) : 0;
    make_point(shape, chosen, along, fn_sin(2 * PI * v), fn_cos(2 * PI * v), out);
}
