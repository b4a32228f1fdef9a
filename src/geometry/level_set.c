#include "geometry/level_set.h"

bool level_line_make(const local_ray *beam, dvec3 middle, level_line *out) {
    dvec3 d = dvec3_from(beam->d), o = dvec3_sub(dvec3_from(beam->o), middle);
    double speed = dvec3_length(d);
    if (!(speed > 0)) return false;
    d = dvec3_scale(d, 1 / speed);
    double shift = -dvec3_dot(o, d);
    *out = (level_line){dvec3_add(o, dvec3_scale(d, shift)), d, shift, speed};
    return isfinite(shift + speed) && isfinite(dvec3_dot(out->o, out->d));
}

bool level_line_clip(const level_line *line, double radius, double *low, double *high) {
    double left = radius * radius - dvec3_dot(line->o, line->o);
    if (!(left > 0)) return false;
    *high = sqrt(left);
    *low = -*high;
    return true;
}

/* ---- roots ---- */

double level_refine(double (*value)(const void *shape, const level_line *line, double s,
                                    double *slope),
                    const void *shape, const level_line *line, double low, double high,
                    bool low_is_inside) {
    enum { STEPS_MAX = 100 };
    double s = (low + high) / 2, before = high - low, close = 0x1p-53 * (fabs(low) + fabs(high));
    for (int i = 0; i < STEPS_MAX; i++) {
        double slope, y = value(shape, line, s, &slope);
        if (y == 0) return s;
        if ((y < 0) == low_is_inside)
            low = s;
        else
            high = s;
        double step = y / slope, next = s - step;
        if (!(next > low && next < high) || !(2 * fabs(step) < before)) {
            next = (low + high) / 2;
            step = (high - low) / 2;
        }
        if (next == s || !(fabs(step) > close)) return next;
        before = fabs(step);
        s = next;
    }
    return s;
}

/* The stretches that are still to do lie on a stack, each by its far end. */
bool level_isolate(const level_function *f, const void *shape, const level_line *line,
                   level_stretch where, double resolution, bool *inside, level_visit *visit,
                   void *user) {
    enum { DEPTH_MAX = 64 };
    double ends[DEPTH_MAX] = {where.high}, low = where.low, slope;
    int count = 1, looks = 0;
    bool started = false, next;
    while (count > 0 && low < where.to) {
        double end = ends[count - 1], middle = (low + end) / 2;
        bool divisible = count < DEPTH_MAX && middle > low && middle < end;
        level_range range;
        f->range(shape, line, low, end, &range);
        bool monotone = range.defined && (range.slope.low > 0 || range.slope.high < 0);
        if (range.value.low >= 0) {
            next = false;
        } else if (range.value.high < 0 && range.defined) {
            next = true;
        } else if (monotone || end - low <= resolution || !divisible) {
            next = f->value(shape, line, end, &slope) < 0;
        } else if (!started && middle <= where.from) {
            low = middle; /* the first half is of no interest */
            continue;
        } else {
            ends[count++] = middle;
            if (++looks == LEVEL_LOOKS_MAX)
                resolution = double_max(resolution, (where.high - where.low) / LEVEL_PARTS_MIN);
            continue;
        }
        if (!started) *inside = f->value(shape, line, low, &slope) < 0;
        started = true;
        if (next != *inside) {
            double s = level_refine(f->value, shape, line, low, end, *inside);
            *inside = next;
            if (s >= where.from && s <= where.to && !visit(user, s, next, 0)) return false;
        }
        low = end;
        count--;
    }
    return true;
}

/* ---- hits and spans ---- */

static surface_crossing crossing_at(const level_line *line, double s, int part) {
    double t = (s + line->shift) / line->speed;
    return (surface_crossing){t, (float)(t - (double)(float)t), (float)part, 0};
}

typedef struct first_hit {
    const level_line *line;
    const local_ray *beam;
    hit *found;
    bool met;
} first_hit;

static bool visit_first(void *user, double s, bool enters, int part) {
    (void)enters;
    first_hit *first = user;
    surface_crossing at = crossing_at(first->line, s, part);
    if (!surface_accept(first->beam, at.t, &first->found->t)) return true;
    first->found->u = at.u;
    first->found->v = at.v;
    first->met = true;
    return false;
}

bool level_intersect(const level_shape *kind, const void *shape, const local_ray *beam,
                     hit *found) {
    level_line line;
    if (!level_line_make(beam, kind->middle(shape), &line)) return false;
    first_hit first = {&line, beam, found, false};
    double from = (double)beam->t_min * line.speed - line.shift;
    double to = (double)beam->t_max * line.speed - line.shift;
    /* What lies beyond t_max may still round to less. */
    to += 0x1p-23 * fabs(to);
    if (from < to) kind->walk(shape, &line, from, to, visit_first, &first);
    return first.met;
}

typedef struct span_list {
    const level_line *line;
    span *out;
    int count, capacity;
    surface_crossing enter;
} span_list;

static bool visit_span(void *user, double s, bool enters, int part) {
    span_list *list = user;
    surface_crossing at = crossing_at(list->line, s, part);
    if (enters) {
        list->enter = at;
        return true;
    }
    if (!(list->enter.t < at.t)) return true;
    if (list->count < list->capacity) list->out[list->count] = (span){list->enter, at};
    return ++list->count <= list->capacity;
}

int level_spans(const level_shape *kind, const void *shape, const local_ray *beam, span *out,
                int capacity) {
    level_line line;
    if (!level_line_make(beam, kind->middle(shape), &line)) return 0;
    span_list list = {.line = &line, .out = out, .capacity = capacity, .enter.t = -INFINITY};
    kind->walk(shape, &line, -INFINITY, INFINITY, visit_span, &list);
    return list.count;
}

/* ---- surfaces ---- */

dvec3 level_hit_point(const level_line *line, const hit *found) {
    return level_line_at(line, ((double)found->t + (double)found->u) * line->speed - line->shift);
}

/* The larger principal curvature by size: how the unit normal turns over a small step along two
 * tangents, as a symmetric matrix, and its eigenvalue. */
static double curvature_at(const level_shape *kind, const void *shape, dvec3 p, dvec3 n) {
    double h = 0x1p-16 * kind->size(shape);
    dvec3 tangents[2], turn[2];
    dvec3_frame(n, &tangents[0], &tangents[1]);
    for (int i = 0; i < 2; i++) {
        dvec3 step = dvec3_scale(tangents[i], h), ahead, behind;
        kind->gradient(shape, dvec3_add(p, step), &ahead);
        kind->gradient(shape, dvec3_sub(p, step), &behind);
        turn[i] = dvec3_scale(dvec3_sub(dvec3_normalize(ahead), dvec3_normalize(behind)), 0.5 / h);
    }
    double a = dvec3_dot(turn[0], tangents[0]), c = dvec3_dot(turn[1], tangents[1]);
    double b = (dvec3_dot(turn[0], tangents[1]) + dvec3_dot(turn[1], tangents[0])) / 2;
    double largest = fabs(a + c) / 2 + sqrt((a - c) * (a - c) / 4 + b * b);
    return largest < INFINITY ? largest : 0;
}

/* First along the ray, where a kernel may have moved t by a few roundings, then along the gradient. */
static dvec3 project(const level_shape *kind, const void *shape, const level_line *line, dvec3 p,
                     double reach, dvec3 *gradient) {
    enum { STEPS = 3 };
    double y = kind->gradient(shape, p, gradient);
    for (int i = 0; i < 2 * STEPS; i++) {
        double square = dvec3_dot(*gradient, *gradient), slope = dvec3_dot(*gradient, line->d);
        dvec3 step = dvec3_scale(*gradient, -y / square), there;
        if (i < STEPS) step = dvec3_scale(line->d, -y / slope);
        if (!(dvec3_dot(step, step) <= reach * reach)) continue;
        dvec3 moved = dvec3_add(p, step);
        double better = kind->gradient(shape, moved, &there);
        if (!(fabs(better) < fabs(y))) continue;
        p = moved;
        y = better;
        *gradient = there;
    }
    return p;
}

void level_surface(const level_shape *kind, const void *shape, const local_ray *beam,
                   const hit *found, surface *out) {
    level_line line = {.speed = 1};
    dvec3 middle = kind->middle(shape), gradient;
    level_line_make(beam, middle, &line);
    double size = kind->size(shape);
    double reach = 0x1p-20 * (fabs((double)found->t) * line.speed + size);
    dvec3 p = project(kind, shape, &line, level_hit_point(&line, found), reach, &gradient);
    double steep = dvec3_length(gradient);
    dvec3 n = dvec3_normalize(gradient), at = dvec3_add(middle, p);
    if (!(steep > 0 && steep < INFINITY)) n = dvec3_negate(line.d); /* a tip */
    double curvature = curvature_at(kind, shape, p, n);
    double magnitude = fabs(at.x) + fabs(at.y) + fabs(at.z) + size;
    /* Where f is so flat that its own rounding hides the surface, a few floats have to do. */
    double most = 4 * FLOAT_EPSILON * magnitude, error = kind->noise(shape, p) / steep;
    *out = surface_make(at, n,
                        (error < most ? error : most) + 64 * DOUBLE_EPSILON * magnitude +
                            surface_shift_error(at, curvature));
    out->curvature = curvature;
}
