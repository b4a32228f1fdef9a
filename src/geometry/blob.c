/* Metaballs: each point adds strength (1 - r^2 / radius^2)^3 within its radius (the cubic in r^2 of
 * Wyvill, McPheeters, Wyvill, Data Structure for Soft Objects, The Visual Computer 2, 1986, with
 * their middle term left out: smooth to the second derivative at its rim). Solid where the sum is
 * above the threshold. A negative strength takes away.
 *
 * Along a ray each point's part is a polynomial of degree 6 between where the ray enters and leaves
 * its ball. Between such places the sum is one polynomial, here in Bernstein's basis, where the signs
 * of the coefficients bound the number of roots (Descartes), and which is halved until they tell it
 * (Lane, Riesenfeld, Bounds on a Polynomial, BIT 21, 1981). A tree of boxes finds the balls. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "geometry/bernstein.h"
#include "geometry/level_set.h"

#define BLOB_FIELDS(F, T)                                                                          \
    F(T, points, VEC3S, NO_DEFAULT, REQUIRED, "m", "the middles of the balls that melt together")  \
    F(T, radius, FLOAT, DEFAULT(1), POSITIVE, "m", "how far each point reaches")                   \
    F(T, strength, FLOAT, DEFAULT(1), ANY, "",                                                     \
      "of each point, at its middle; less than 0: a dent")                                         \
    F(T, sizes, VEC2S, NO_DEFAULT, ANY, "", "{radius, strength} of each point, instead")           \
    F(T, threshold, FLOAT, DEFAULT(0.5f), POSITIVE, "", "solid where the sum is above this")
DESCRIBE(blob, BLOB_FIELDS)

enum { POINTS_MAX = 1 << 20, DEGREE = 6, LEAF_MAX = 4, STACK_MAX = 64 };

typedef struct component {
    dvec3 center;                        /* relative to the middle */
    double radius, strength, per_square; /* 1 / radius^2 */
} component;

/* The children of the inner node i are i + 1 and `second`. */
typedef struct box_node {
    dvec3 low, high;
    uint32_t second; /* 0: a leaf */
    uint32_t first, count;
} box_node;

/* What rays are traced against: begins with the description. */
typedef struct prepared {
    blob_desc desc;
    dvec3 middle;
    double size, threshold;
    component *components; /* in the order of the tree's leaves */
    box_node *nodes;
    uint32_t count, node_count;
} prepared;

static dvec3 middle(const void *shape) { return ((const prepared *)shape)->middle; }
static double size(const void *shape) { return ((const prepared *)shape)->size; }

static double radius_of(const blob_desc *blob, size_t i) {
    return blob->sizes_count ? blob->sizes[i].x : blob->radius;
}
static double strength_of(const blob_desc *blob, size_t i) {
    return blob->sizes_count ? blob->sizes[i].y : blob->strength;
}

/* ---- the description ---- */

static snell_status check(const void *desc) {
    const blob_desc *blob = desc;
    size_t count = blob->points_count, sizes = blob->sizes_count;
    if (count == 0 || count > POINTS_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "write points = {{0, 0, 0}, {1, 0, 0}, ...}",
                         "blob: 'points' has %zu points; it must have 1 to %d", count, POINTS_MAX);
    if (sizes && sizes != count)
        return error_set(SNELL_ERR_ARGUMENT, "give {radius, strength} for every point, or for none",
                         "blob: 'sizes' has %zu entries for %zu points", sizes, count);
    for (size_t i = 0; i < sizes; i++)
        if (!(blob->sizes[i].x > 0))
            return error_set(SNELL_ERR_ARGUMENT, "sizes are {radius, strength}",
                             "blob: the radius of point %zu is %g; it must be greater than 0",
                             i + 1, (double)blob->sizes[i].x);
    return SNELL_OK;
}

static void add_ball(dvec3 *low, dvec3 *high, dvec3 c, double r) {
    *low = (dvec3){double_min(low->x, c.x - r), double_min(low->y, c.y - r),
                   double_min(low->z, c.z - r)};
    *high = (dvec3){double_max(high->x, c.x + r), double_max(high->y, c.y + r),
                    double_max(high->z, c.z + r)};
}

/* Points that take away add nothing. */
static bounds3 bounds(const void *desc) {
    const blob_desc *blob = desc;
    dvec3 low = {INFINITY, INFINITY, INFINITY}, high = dvec3_negate(low);
    for (size_t i = 0; i < blob->points_count; i++)
        if (strength_of(blob, i) > 0)
            add_ball(&low, &high, dvec3_from(blob->points[i]), radius_of(blob, i));
    return low.x <= high.x ? bounds3_outward(low, high) : bounds3_empty();
}

/* ---- preparing ---- */

typedef struct sort_key {
    double place;
    uint32_t index;
} sort_key;

static int compare_keys(const void *a, const void *b) {
    const sort_key *one = a, *other = b;
    if (one->place != other->place) return one->place < other->place ? -1 : 1;
    return one->index < other->index ? -1 : one->index > other->index;
}

typedef struct tree_build {
    prepared *blob;
    component *scratch;
    sort_key *keys;
} tree_build;

static double coordinate(dvec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* Splits at the median of the longest side. The balls' order decides nothing but the order of sums. */
static uint32_t build(tree_build *b, uint32_t first, uint32_t count) {
    prepared *blob = b->blob;
    uint32_t index = blob->node_count++;
    box_node node = {.low = {INFINITY, INFINITY, INFINITY},
                     .high = {-INFINITY, -INFINITY, -INFINITY},
                     .first = first,
                     .count = count};
    component *here = blob->components + first;
    for (uint32_t i = 0; i < count; i++)
        add_ball(&node.low, &node.high, here[i].center, here[i].radius);
    if (count > LEAF_MAX) {
        dvec3 side = dvec3_sub(node.high, node.low);
        int axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
        for (uint32_t i = 0; i < count; i++)
            b->keys[i] = (sort_key){coordinate(here[i].center, axis), i};
        qsort(b->keys, count, sizeof *b->keys, compare_keys);
        memcpy(b->scratch, here, count * sizeof *here);
        for (uint32_t i = 0; i < count; i++) here[i] = b->scratch[b->keys[i].index];
        build(b, first, count / 2);
        node.second = build(b, first + count / 2, count - count / 2);
    }
    blob->nodes[index] = node;
    return index;
}

static void release(void *shape) {
    prepared *blob = shape;
    if (blob == NULL) return;
    free(blob->components);
    free(blob->nodes);
    free(blob);
}

static size_t prepared_size(const void *desc) {
    const tree_build *b = NULL; /* what is only needed while it is made counts too */
    size_t each = sizeof(component) + 2 * sizeof(box_node) + sizeof *b->scratch + sizeof *b->keys;
    return sizeof(prepared) + ((const blob_desc *)desc)->points_count * each;
}

static void *prepare(const void *desc) {
    const blob_desc *from = desc;
    size_t count = from->points_count;
    prepared *blob = memory_zeroed(1, sizeof *blob);
    if (blob == NULL) return NULL;
    blob->desc = *from;
    blob->threshold = from->threshold;
    blob->count = (uint32_t)count;
    blob->components = memory_resize(NULL, count, sizeof *blob->components);
    blob->nodes = memory_resize(NULL, 2 * count, sizeof *blob->nodes);
    tree_build b = {blob, memory_resize(NULL, count, sizeof *b.scratch),
                    memory_resize(NULL, count, sizeof *b.keys)};
    bool sound = blob->components && blob->nodes && b.scratch && b.keys;
    if (sound) {
        dvec3 low = {INFINITY, INFINITY, INFINITY}, high = dvec3_negate(low);
        for (size_t i = 0; i < count; i++)
            add_ball(&low, &high, dvec3_from(from->points[i]), radius_of(from, i));
        dvec3 half = dvec3_scale(dvec3_sub(high, low), 0.5);
        blob->middle = dvec3_add(low, half);
        blob->size = dvec3_length(half);
        for (size_t i = 0; i < count; i++) {
            double r = radius_of(from, i), strength = strength_of(from, i);
            dvec3 center = dvec3_sub(dvec3_from(from->points[i]), blob->middle);
            blob->components[i] = (component){center, r, strength, 1 / (r * r)};
        }
        build(&b, 0, blob->count);
    }
    free(b.scratch);
    free(b.keys);
    if (sound) return blob;
    release(blob);
    return NULL;
}

/* ---- points ---- */

/* Threshold minus the sum, its gradient, and the sum of what the rounding of each part may be. */
static double field_at(const prepared *blob, dvec3 p, dvec3 *gradient, double *noise) {
    uint32_t stack[STACK_MAX], top = 0;
    double sum = 0;
    dvec3 g = {0, 0, 0};
    *noise = blob->threshold * 0x1p-50;
    stack[top++] = 0;
    while (top > 0) {
        uint32_t index = stack[--top];
        const box_node *node = &blob->nodes[index];
        if (p.x < node->low.x || p.x > node->high.x || p.y < node->low.y || p.y > node->high.y ||
            p.z < node->low.z || p.z > node->high.z)
            continue;
        if (node->second) {
            stack[top++] = node->second;
            stack[top++] = index + 1;
            continue;
        }
        for (uint32_t i = node->first; i < node->first + node->count; i++) {
            const component *c = &blob->components[i];
            dvec3 r = dvec3_sub(p, c->center);
            double left = 1 - dvec3_dot(r, r) * c->per_square;
            if (!(left > 0)) continue;
            double slope = -6 * c->strength * left * left * c->per_square;
            sum += c->strength * left * left * left;
            g = dvec3_add(g, dvec3_scale(r, slope));
            *noise +=
                fabs(c->strength) * (0x1p-48 + 0x1p-47 * left * left * blob->size / c->radius);
        }
    }
    *gradient = dvec3_negate(g);
    return blob->threshold - sum;
}

static double gradient_at(const void *shape, dvec3 p, dvec3 *gradient) {
    double noise;
    return field_at(shape, p, gradient, &noise);
}

static double noise_at(const void *shape, dvec3 p) {
    double noise;
    dvec3 gradient;
    field_at(shape, p, &gradient, &noise);
    return noise;
}

/* ---- polynomials in Bernstein's basis ---- */

typedef struct polynomial {
    double b[DEGREE + 1];
} polynomial;

/* Adds -strength (1 - r^2 / radius^2)^3 over [low, high]; in the ball's own s, from where the line is
 * nearest to its centre, with its distance there squared. The quadratic's three coefficients are its
 * polar form at (low, low), (low, high), (high, high); their products are weighted by binomials. */
static void add_component(const component *c, double nearest2, double low, double high,
                          polynomial *to) {
    double rest = 1 - nearest2 * c->per_square, scale = c->per_square;
    double q0 = rest - low * low * scale, q1 = rest - low * high * scale,
           q2 = rest - high * high * scale;
    double s[5] = {q0 * q0, q0 * q1, (q0 * q2 + 2 * q1 * q1) / 3, q1 * q2, q2 * q2};
    const double cube[DEGREE + 1] = {s[0] * q0,
                                     (4 * s[1] * q0 + 2 * s[0] * q1) / 6,
                                     (6 * s[2] * q0 + 8 * s[1] * q1 + s[0] * q2) / 15,
                                     (4 * s[3] * q0 + 12 * s[2] * q1 + 4 * s[1] * q2) / 20,
                                     (s[4] * q0 + 8 * s[3] * q1 + 6 * s[2] * q2) / 15,
                                     (2 * s[4] * q1 + 4 * s[3] * q2) / 6,
                                     s[4] * q2};
    for (int i = 0; i <= DEGREE; i++) to->b[i] -= c->strength * cube[i];
}

static double polynomial_value(const void *shape, const level_line *line, double s, double *slope) {
    (void)line;
    return bernstein_value(((const polynomial *)shape)->b, DEGREE, s, slope);
}

static int sign_changes(const polynomial *p) {
    int changes = 0;
    for (int i = 1; i <= DEGREE; i++) changes += (p->b[i] < 0) != (p->b[i - 1] < 0);
    return changes;
}

/* ---- along a ray ---- */

enum { BALLS_MAX = 96 }; /* whose rims one stretch may cross; it is halved until they fit */

/* A ball that the stretch enters or leaves. */
typedef struct met_ball {
    const component *component;
    double nearest, nearest2, enter, leave;
} met_ball;

typedef struct stretch {
    double low, high;
    polynomial whole; /* threshold, less the balls that hold all of it */
    met_ball balls[BALLS_MAX];
    int count;
} stretch;

static bool meets_box(const level_line *line, const box_node *node, double low, double high) {
    const double o[3] = {line->o.x, line->o.y, line->o.z}, d[3] = {line->d.x, line->d.y, line->d.z};
    const double lows[3] = {node->low.x, node->low.y, node->low.z};
    const double highs[3] = {node->high.x, node->high.y, node->high.z};
    double slack = 0x1p-45 * (1 + fabs(low) + fabs(high));
    for (int i = 0; i < 3; i++) {
        if (d[i] == 0) {
            if (o[i] < lows[i] || o[i] > highs[i]) return false;
            continue;
        }
        double one = (lows[i] - o[i]) / d[i], other = (highs[i] - o[i]) / d[i];
        low = double_max(low, double_min(one, other));
        high = double_min(high, double_max(one, other));
    }
    return low <= high + slack;
}

/* false: too many. A ball's rim is where its part and two derivatives are 0, so where exactly it is
 * found hardly matters. */
static bool gather_ball(const level_line *line, const component *c, stretch *to) {
    double nearest = dvec3_dot(c->center, line->d);
    dvec3 off = dvec3_sub(level_line_at(line, nearest), c->center);
    double nearest2 = dvec3_dot(off, off), left = c->radius * c->radius - nearest2;
    if (!(left > 0) || c->strength == 0) return true;
    double half = sqrt(left), enter = nearest - half, leave = nearest + half;
    if (leave <= to->low || enter >= to->high) return true;
    if (enter <= to->low && leave >= to->high) {
        add_component(c, nearest2, to->low - nearest, to->high - nearest, &to->whole);
        return true;
    }
    if (to->count == BALLS_MAX) return false;
    to->balls[to->count++] = (met_ball){c, nearest, nearest2, enter, leave};
    return true;
}

static bool gather(const prepared *blob, const level_line *line, double low, double high,
                   stretch *to) {
    uint32_t stack[STACK_MAX], top = 0;
    to->low = low;
    to->high = high;
    to->count = 0;
    for (int i = 0; i <= DEGREE; i++) to->whole.b[i] = blob->threshold;
    stack[top++] = 0;
    while (top > 0) {
        uint32_t index = stack[--top];
        const box_node *node = &blob->nodes[index];
        if (!meets_box(line, node, low, high)) continue;
        if (node->second) {
            stack[top++] = node->second;
            stack[top++] = index + 1;
            continue;
        }
        for (uint32_t i = 0; i < node->count; i++)
            if (!gather_ball(line, &blob->components[node->first + i], to)) return false;
    }
    return true;
}

/* What the walk along a line carries from one polynomial to the next, whatever part of it is asked for
 * (see level_stretch): the side, so that the crossings
 * enter and leave in turns whatever the rounding where two polynomials meet. */
typedef struct walker {
    level_visit *visit;
    void *user;
    double from, to;
    bool started, inside;
} walker;

/* The sign changes of p over [low, high], by halving. */
static bool walk_polynomial(walker *w, const polynomial *p, double low, double high) {
    enum { DEPTH_MAX = 40 };
    polynomial parts[DEPTH_MAX];
    double ends[DEPTH_MAX], start = low;
    int count = 1;
    parts[0] = *p;
    ends[0] = high;
    while (count > 0) {
        polynomial *here = &parts[count - 1];
        double end = ends[count - 1], middle = (start + end) / 2;
        if (sign_changes(here) > 1 && count < DEPTH_MAX && middle > start && middle < end) {
            parts[count] = *here;
            bernstein_restrict(parts[count].b, DEGREE, 0, 0.5);
            bernstein_restrict(here->b, DEGREE, 0.5, 1);
            ends[count++] = middle;
            continue;
        }
        if (!w->started) w->inside = here->b[0] < 0;
        w->started = true;
        bool next = here->b[DEGREE] < 0;
        if (next != w->inside) {
            double part = level_refine(polynomial_value, here, NULL, 0, 1, w->inside);
            double s = start + part * (end - start);
            w->inside = next;
            if (s >= w->from && s <= w->to && !w->visit(w->user, s, next, 0)) return false;
        }
        start = end;
        count--;
    }
    return true;
}

static int compare_doubles(const void *a, const void *b) {
    double one = *(const double *)a, other = *(const double *)b;
    return one < other ? -1 : one > other;
}

/* The part of `whole` between two places of the stretch. */
static polynomial restrict_to(const stretch *s, double low, double high) {
    polynomial piece = s->whole;
    double width = s->high - s->low;
    if (low > s->low || high < s->high)
        bernstein_restrict(piece.b, DEGREE, (low - s->low) / width, (high - s->low) / width);
    return piece;
}

static bool walk_stretch(walker *w, const stretch *s) {
    double places[2 * BALLS_MAX + 2] = {s->low, s->high};
    size_t count = 2;
    for (int i = 0; i < s->count; i++) {
        const met_ball *ball = &s->balls[i];
        if (ball->enter > s->low) places[count++] = ball->enter;
        if (ball->leave < s->high) places[count++] = ball->leave;
    }
    qsort(places, count, sizeof *places, compare_doubles);
    for (size_t k = 0; k + 1 < count; k++) {
        double low = places[k], high = places[k + 1];
        if (!(low < high) || high <= w->from) continue;
        if (low >= w->to) return false;
        polynomial piece = restrict_to(s, low, high);
        for (int i = 0; i < s->count; i++) {
            const met_ball *ball = &s->balls[i];
            if (ball->enter <= low && ball->leave >= high)
                add_component(ball->component, ball->nearest2, low - ball->nearest,
                              high - ball->nearest, &piece);
        }
        if (!walk_polynomial(w, &piece, low, high)) return false;
    }
    return true;
}

static void walk(const void *shape, const level_line *line, double from, double to,
                 level_visit *visit, void *user) {
    enum { DEPTH_MAX = 48 };
    const prepared *blob = shape;
    double low, high, ends[DEPTH_MAX];
    if (!level_line_clip(line, blob->size, &low, &high)) return;
    if (!(low < to && high > from)) return;
    walker w = {.visit = visit, .user = user, .from = from, .to = to};
    stretch here;
    int count = 1;
    ends[0] = high;
    while (count > 0) {
        double end = ends[count - 1], middle = (low + end) / 2;
        bool fits = gather(blob, line, low, end, &here);
        if (!fits && count < DEPTH_MAX && middle > low && middle < end) {
            ends[count++] = middle;
            continue;
        }
        /* Hundreds of rims within a rounding of one place: what of them did not fit is left out of this
         * stretch, which has no length to speak of. */
        if (!walk_stretch(&w, &here)) return;
        low = end;
        count--;
    }
}

static const level_shape kind = {middle, size, walk, gradient_at, noise_at};

static bool intersect(const void *shape, const local_ray *beam, hit *found) {
    return level_intersect(&kind, shape, beam, found);
}

static int spans(const void *shape, const local_ray *beam, span *out, int capacity) {
    return level_spans(&kind, shape, beam, out, capacity);
}

static void fill_surface(const void *shape, const local_ray *beam, const hit *found, surface *out) {
    level_surface(&kind, shape, beam, found, out);
}

static void parametrise(const void *shape, surface *s) { level_parametrise(middle(shape), s); }

static int side(const void *shape, dvec3 p) {
    const prepared *blob = shape;
    dvec3 unused;
    return gradient_at(blob, dvec3_sub(p, blob->middle), &unused) < 0 ? 1 : -1;
}

extern const primitive_type primitive_blob;
const primitive_type primitive_blob = {
    .info = TYPE_INFO(CATEGORY_SHAPE, blob, "blob", "balls that melt together (metaballs)"),
    .check = check,
    .bounds = bounds,
    .prepare = prepare,
    .prepared_size = prepared_size,
    .release = release,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
};
