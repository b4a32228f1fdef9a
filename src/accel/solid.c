#include "accel/solid.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/surface.h"

/* Faces of two parts are one if their planes are no farther apart than this times the size of the
 * numbers that they were computed from: a few roundings of floats, in which places and transforms
 * are given. */
#define COINCIDE 0x1p-21
/* So near, as a part of their place, two faces may be one: then that is looked at. */
#define NEAR 0x1p-10
/* And their normals are parallel, to a thousandth. */
#define PARALLEL (1 - 0x1p-21)

/* ---- faces ---- */

uint64_t solid_face_count(const primitive_type *type, const void *desc) {
    /* Of a mesh each triangle has two sides: where the line enters the mesh and where it leaves. */
    return type == &primitive_mesh ? 2 * (uint64_t)mesh_triangle_count(desc) : 1;
}

const solid_part *solid_find_part(const solid_shape *s, uint32_t face) {
    uint32_t low = 0, high = s->part_count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low + 1) / 2;
        if (s->parts[middle].first_face <= face)
            low = middle;
        else
            high = middle - 1;
    }
    return &s->parts[low];
}

static local_ray to_part(const solid_part *part, const local_ray *beam) {
    if (part->identity) return *beam;
    return (local_ray){vec3_from(transform_point(&part->to_local, dvec3_from(beam->o))),
                       vec3_from(transform_vector(&part->to_local, dvec3_from(beam->d))),
                       beam->t_min, beam->t_max};
}

/* The part's surface in the solid's space, n outward of the solid. `leaving`: the part, where that
 * tells a mesh's inside from its outside. */
static void part_surface(const solid_shape *s, const solid_part *part, const local_ray *beam,
                         const hit *found, bool leaving, surface *out) {
    local_ray local = to_part(part, beam);
    part->type->surface(part->desc, &local, found, out);
    if (s->textured && part->type->parametrise) part->type->parametrise(part->desc, out);
    bool inward = part->mesh && (dvec3_dot(out->n, dvec3_from(local.d)) > 0) != leaving;
    if (inward != part->subtracted) {
        out->n = dvec3_negate(out->n);
        out->ns = dvec3_negate(out->ns);
    }
    out->material_slot += part->first_slot;
    if (part->identity) return;
    /* f(L p) = 0 has the second derivative L^T H L and the gradient L^T g. */
    double square = 0, length = dvec3_length(transform_normal(&part->to_local, out->n));
    for (int i = 0; i < 9; i++) {
        double x = (double)part->to_local.m[i / 3][i % 3];
        square += x * x;
    }
    surface_to_world(out, &part->to_solid, &part->to_local);
    if (s->textured) surface_tangents_to_world(out, &part->to_solid);
    if (length > 0) out->curvature *= square / length;
}

/* ---- the ends of stretches ---- */

/* One end of a part's stretch. */
typedef struct solid_event {
    double t;
    float u, v;
    uint32_t primitive; /* of the part: the triangle, or 0 */
    uint16_t part;
    bool enter;
    bool joined; /* the same face as the one before */
} solid_event;

enum { EVENTS_MAX = 2 * SOLID_SPANS_MAX };
_Static_assert(SOLID_PARTS_MAX < UINT16_MAX, "parts are numbered in 16 bits");

/* Where the line meets the solid, in ascending order. */
typedef struct solid_line {
    solid_event events[EVENTS_MAX];
    span spans[SOLID_SPANS_MAX];                            /* of one part */
    uint32_t counts[SOLID_PARTS_MAX];                       /* of each node: children inside */
    bool inside[SOLID_PARTS_MAX], changed[SOLID_PARTS_MAX]; /* of each part */
    int event_count;
} solid_line;

/* A line ready to be held against boxes. */
typedef struct box_line {
    double o[3], d[3], inv[3]; /* inv: 1/d */
    double size;               /* of o */
} box_line;

static box_line make_box_line(const local_ray *beam) {
    box_line line = {.o = {(double)beam->o.x, (double)beam->o.y, (double)beam->o.z},
                     .d = {(double)beam->d.x, (double)beam->d.y, (double)beam->d.z}};
    for (int i = 0; i < 3; i++) {
        line.inv[i] = 1 / line.d[i];
        line.size += fabs(line.o[i]);
    }
    return line;
}

/* May the line pass the box? Widened beyond all rounding. */
static bool may_meet(const bounds3 *box, const box_line *line) {
    const double low[3] = {(double)box->min.x, (double)box->min.y, (double)box->min.z},
                 high[3] = {(double)box->max.x, (double)box->max.y, (double)box->max.z};
    double size = line->size, near = -INFINITY, far = INFINITY;
    for (int i = 0; i < 3; i++) size += fabs(low[i]) + fabs(high[i]);
    for (int i = 0; i < 3; i++) {
        double from = low[i] - 0x1p-20 * size - line->o[i],
               to = high[i] + 0x1p-20 * size - line->o[i];
        if (line->d[i] == 0 && (from > 0 || to < 0)) return false;
        if (!isfinite(line->inv[i])) continue;
        double a = from * line->inv[i], b = to * line->inv[i];
        near = double_max(double_min(a, b), near);
        far = double_min(double_max(a, b), far);
    }
    return near <= far;
}

static int part_spans(const solid_part *part, const local_ray *beam, span *out, int capacity) {
    dvec3 o = dvec3_from(beam->o), d = dvec3_from(beam->d);
    if (part->mesh && part->identity) return solid_mesh_spans(part->mesh, o, d, out, capacity);
    if (part->mesh)
        return solid_mesh_spans(part->mesh, transform_point(&part->to_local, o),
                                transform_vector(&part->to_local, d), out, capacity);
    local_ray local = to_part(part, beam);
    return part->type->spans(part->desc, &local, out, capacity);
}

static bool comes_before(const solid_event *a, const solid_event *b) {
    return a->t != b->t ? a->t < b->t : a->part < b->part;
}

/* Events of one part come in order, so this has little to do. */
static void add_event(solid_line *line, solid_event event) {
    int place = line->event_count++;
    for (; place > 0 && comes_before(&event, &line->events[place - 1]); place--)
        line->events[place] = line->events[place - 1];
    line->events[place] = event;
}

/* False: there are too many. */
static bool find_events(const solid_shape *s, const local_ray *beam, solid_line *line) {
    const box_line boxes = make_box_line(beam);
    line->event_count = 0;
    for (uint32_t i = 0; i < s->part_count; i++) {
        const solid_part *part = &s->parts[i];
        if (part->bounded && !may_meet(&part->bounds, &boxes)) continue;
        int room = (EVENTS_MAX - line->event_count) / 2;
        int count = part_spans(part, beam, line->spans, room);
        if (count > room) return false;
        for (int k = 0; k < count; k++) {
            const surface_crossing *ends[2] = {&line->spans[k].enter, &line->spans[k].leave};
            for (int end = 0; end < 2; end++)
                add_event(line, (solid_event){.t = ends[end]->t,
                                              .u = ends[end]->u,
                                              .v = ends[end]->v,
                                              .primitive = ends[end]->primitive,
                                              .part = (uint16_t)i,
                                              .enter = end == 0});
        }
    }
    return true;
}

static hit event_hit(const solid_event *e) {
    return (hit){.t = (float)e->t, .u = e->u, .v = e->v, .primitive = e->primitive};
}

static double size_of(dvec3 p) { return fabs(p.x) + fabs(p.y) + fabs(p.z); }

/* What was rounded on the way to a part's surface near p: p itself, and its place in the part. */
static double rounded_size(const solid_part *part, dvec3 p) {
    if (part->identity) return size_of(p);
    const transform *m = &part->to_solid;
    return size_of(p) +
           2 * (fabs((double)m->m[0][3]) + fabs((double)m->m[1][3]) + fabs((double)m->m[2][3]));
}

static bool is_near(const local_ray *beam, const solid_event *a, const solid_event *b) {
    dvec3 o = dvec3_from(beam->o), d = dvec3_from(beam->d);
    double step = size_of(d), apart = (b->t - a->t) * step;
    return a->part != b->part && isfinite(a->t) && isfinite(b->t) &&
           apart <= NEAR * (size_of(o) + fabs(a->t) * step);
}

/* Do the two lie in one plane? */
static bool coincide(const solid_shape *s, const local_ray *beam, const solid_event *a,
                     const solid_event *b) {
    const solid_part *parts[2] = {&s->parts[a->part], &s->parts[b->part]};
    hit hits[2] = {event_hit(a), event_hit(b)};
    surface faces[2];
    part_surface(s, parts[0], beam, &hits[0], !a->enter, &faces[0]);
    part_surface(s, parts[1], beam, &hits[1], !b->enter, &faces[1]);
    double cosine = dvec3_dot(faces[0].n, faces[1].n);
    if (!(fabs(cosine) >= PARALLEL)) return false;
    double size = rounded_size(parts[0], faces[0].p) + rounded_size(parts[1], faces[1].p);
    double apart = fabs(dvec3_dot(faces[0].n, dvec3_sub(faces[1].p, faces[0].p)));
    return apart <= COINCIDE * size;
}

/* Other faces may cross the line between two that are one: so many of them are looked past. */
enum { JOIN_REACH = 8 };

/* The event, from number `begin` on, of a face that is one with that of the event before; or -1. A
 * part's own events stay in order. */
static int find_joined(const solid_shape *s, const local_ray *beam, const solid_line *line,
                       int begin) {
    const solid_event *e = line->events, *last = &e[begin - 1];
    for (int i = begin; i < line->event_count && i < begin + JOIN_REACH; i++) {
        if (!isfinite(e[i].t) || e[i].part == last->part) return -1;
        bool first = true;
        for (int k = begin; k < i; k++) first &= e[k].part != e[i].part;
        if (!first) continue;
        if (!is_near(beam, last, &e[i])) return -1;
        if (coincide(s, beam, last, &e[i])) return i;
    }
    return -1;
}

/* Faces that are one come to stand one after the other. */
static void join_events(const solid_shape *s, const local_ray *beam, solid_line *line) {
    for (int i = 1; i < line->event_count; i++) {
        int found = find_joined(s, beam, line, i);
        line->events[i].joined = found >= 0;
        if (found <= i) continue;
        solid_event joined = line->events[found];
        for (int k = found; k > i; k--) line->events[k] = line->events[k - 1];
        joined.joined = true;
        line->events[i] = joined;
    }
}

/* ---- the operations ---- */

/* In the count of a difference: the first child is inside. */
#define FIRST_INSIDE 0x80000000u

static bool node_is_inside(const solid_node *node, uint32_t count) {
    if (node->operation == SOLID_UNION) return count > 0;
    if (node->operation == SOLID_INTERSECTION) return count == node->child_count;
    return count == FIRST_INSIDE;
}

/* The part is inside now, or no longer; *whole follows. */
static void change_part(const solid_shape *s, uint32_t *counts, const solid_part *part, bool inside,
                        bool *whole) {
    uint32_t at = part->node;
    bool first = part->first;
    for (;;) {
        const solid_node *node = &s->nodes[at];
        bool before = node_is_inside(node, counts[at]);
        uint32_t step = node->operation == SOLID_DIFFERENCE && first ? FIRST_INSIDE : 1;
        counts[at] = inside ? counts[at] + step : counts[at] - step;
        inside = node_is_inside(node, counts[at]);
        if (inside == before) return;
        if (at == 0) {
            *whole = inside;
            return;
        }
        first = node->first;
        at = node->parent;
    }
}

/* Of the events begin .. end - 1, all at one face, that of the first part by which the solid changed
 * as it did. */
static int face_event(const solid_shape *s, const solid_line *line, int begin, int end,
                      bool entered) {
    int best = begin;
    uint32_t least = UINT32_MAX;
    for (int i = begin; i < end; i++) {
        const solid_event *e = &line->events[i];
        bool now = line->inside[e->part];
        bool same_way = (now != s->parts[e->part].subtracted) == entered;
        if (!line->changed[e->part] || !same_way || e->enter != now || e->part >= least) continue;
        best = i;
        least = e->part;
    }
    return best;
}

/* The solid's own faces along the line: the numbers of their events, entering and leaving in turn.
 * There are at most EVENTS_MAX. -1: too many to tell. */
static int find_faces(const solid_shape *s, const local_ray *beam, solid_line *line, int *faces) {
    if (!find_events(s, beam, line)) return -1;
    join_events(s, beam, line);
    memset(line->counts, 0, s->node_count * sizeof *line->counts);
    memset(line->inside, 0, s->part_count * sizeof *line->inside);
    memset(line->changed, 0, s->part_count * sizeof *line->changed);
    int count = 0;
    bool whole = false;
    for (int begin = 0, end; begin < line->event_count; begin = end) {
        bool before = whole;
        end = begin;
        do {
            const solid_event *e = &line->events[end++];
            line->inside[e->part] = e->enter;
            line->changed[e->part] = !line->changed[e->part];
            change_part(s, line->counts, &s->parts[e->part], e->enter, &whole);
        } while (end < line->event_count && line->events[end].joined);
        if (whole != before) faces[count++] = face_event(s, line, begin, end, whole);
        for (int i = begin; i < end; i++) line->changed[line->events[i].part] = false;
    }
    return count;
}

/* ---- as a shape ---- */

static bounds3 bounds(const void *desc) { return ((const solid_shape *)desc)->bounds; }

static uint32_t event_face(const solid_shape *s, const solid_event *e) {
    const solid_part *part = &s->parts[e->part];
    return part->first_face + (part->mesh ? 2 * e->primitive + !e->enter : 0);
}

static _Thread_local uint64_t spent_lines;

uint64_t solid_take_spent(void) {
    uint64_t count = spent_lines;
    spent_lines = 0;
    return count;
}

snell_status solid_error_spent(void) {
    return error_set(SNELL_ERR_UNSUPPORTED, "make it of several solids, or of simpler shapes",
                     "a ray meets more than %d stretches of what a solid is made of",
                     SOLID_SPANS_MAX);
}

/* Two faces that are one to a float, of a sliver or a crack, are none: else a ray that walks on from
 * the first would miss the second. */
static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    const solid_shape *s = desc;
    solid_line line;
    int faces[EVENTS_MAX], count = find_faces(s, beam, &line, faces);
    if (count < 0) spent_lines++;
    for (int i = 0; i < count; i++) {
        const solid_event *e = &line.events[faces[i]];
        if (i + 1 < count && (float)line.events[faces[i + 1]].t == (float)e->t) {
            i++;
            continue;
        }
        if (!surface_accept(beam, e->t, &found->t)) continue;
        found->u = e->u;
        found->v = e->v;
        found->primitive = event_face(s, e);
        return true;
    }
    return false;
}

static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    const solid_shape *s = desc;
    solid_line line;
    int faces[EVENTS_MAX], count = find_faces(s, beam, &line, faces), found = 0;
    if (count < 0) return capacity + 1;
    for (int i = 0; i + 1 < count; i += 2) {
        surface_crossing ends[2];
        for (int k = 0; k < 2; k++) {
            const solid_event *e = &line.events[faces[i + k]];
            ends[k] = (surface_crossing){e->t, e->u, e->v, event_face(s, e)};
        }
        found = surface_add_span(out, found, capacity, ends[0], ends[1]);
    }
    return found;
}

/* The hit as the part itself has it. */
static hit part_hit(const solid_part *part, const hit *found) {
    hit own = *found;
    own.primitive -= part->first_face;
    if (part->mesh) own.primitive /= 2;
    return own;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const solid_shape *s = desc;
    const solid_part *part = solid_find_part(s, found->primitive);
    hit own = part_hit(part, found);
    part_surface(s, part, beam, &own, (found->primitive - part->first_face) & 1, out);
}

/* In the solid's space a change of normal is 1/N (1 - n n^T) L^T times that in the part's; N = |L^T n|
 * is taken as that of a transform that keeps angles, which is enough for how wide a texture is
 * filtered. */
dvec3 solid_bend(const solid_shape *s, const hit *found, double curvature, dvec3 dp) {
    const solid_part *part = solid_find_part(s, found->primitive);
    hit own = part_hit(part, found);
    dvec3 change = dvec3_scale(dp, curvature);
    if (part->type->bend && part->identity) {
        change = part->type->bend(part->desc, &own, dp);
    } else if (part->type->bend) {
        const float *row = part->to_local.m[0];
        double scale = dvec3_length((dvec3){(double)row[0], (double)row[1], (double)row[2]});
        change = part->type->bend(part->desc, &own, transform_vector(&part->to_local, dp));
        change = dvec3_scale(transform_normal(&part->to_local, change), 1 / scale);
    }
    return part->subtracted ? dvec3_negate(change) : change;
}

static bool part_encloses(const solid_part *part, dvec3 p) {
    if (!part->identity) p = transform_point(&part->to_local, p);
    if (part->mesh == NULL && part->type->side) return part->type->side(part->desc, p) > 0;
    /* Along a direction in which nobody builds edges. */
    const dvec3 d = {0.5477225575051661, 0.7745966692414834, 0.31622776601683794};
    local_ray beam = {vec3_from(p), vec3_from(d), 0, INFINITY};
    span found[SOLID_SPANS_MAX];
    int count = part->mesh ? solid_mesh_spans(part->mesh, p, d, found, SOLID_SPANS_MAX)
                           : part->type->spans(part->desc, &beam, found, SOLID_SPANS_MAX);
    for (int i = 0; i < count && i < SOLID_SPANS_MAX; i++)
        if (found[i].enter.t < 0 && found[i].leave.t > 0) return true;
    return false;
}

static int side(const void *desc, dvec3 p) {
    const solid_shape *s = desc;
    uint32_t counts[SOLID_PARTS_MAX];
    bool whole = false;
    memset(counts, 0, s->node_count * sizeof *counts);
    for (uint32_t i = 0; i < s->part_count; i++)
        if (part_encloses(&s->parts[i], p)) change_part(s, counts, &s->parts[i], true, &whole);
    return whole ? 1 : -1;
}

const primitive_type solid_bounded = {
    .info = {.category = CATEGORY_SHAPE, .name = "solid", .help = "closed shapes put together"},
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .side = side,
    .spans = spans,
};

const primitive_type solid_boundless = {
    .info = {.category = CATEGORY_SHAPE, .name = "solid", .help = "closed shapes put together"},
    .unbounded = true,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .side = side,
    .spans = spans,
};
