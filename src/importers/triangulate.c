#include "importers/triangulate.h"

#include <stdlib.h>

#include "base/memory.h"

typedef struct flat {
    double x, y;
} flat;

/* Twice the signed area of a triangle. */
static double turn(flat a, flat b, flat c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/* Newell's normal, not unit. */
static dvec3 normal_of(const vec3 *p, uint32_t count) {
    dvec3 n = {0, 0, 0};
    for (uint32_t i = 0; i < count; i++) {
        dvec3 a = dvec3_from(p[i]), b = dvec3_from(p[(i + 1) % count]);
        n.x += (a.y - b.y) * (a.z + b.z);
        n.y += (a.z - b.z) * (a.x + b.x);
        n.z += (a.x - b.x) * (a.y + b.y);
    }
    return n;
}

/* Along the axis that the normal is nearest to, counter-clockwise. */
static flat flatten(vec3 p, dvec3 n) {
    double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    flat out = {(double)p.x, (double)p.y};
    double sign = n.z;
    if (x >= y && x >= z)
        out = (flat){(double)p.y, (double)p.z}, sign = n.x;
    else if (y >= z)
        out = (flat){(double)p.z, (double)p.x}, sign = n.y;
    if (sign < 0) out.x = -out.x;
    return out;
}

/* A hole joined to its outline by an edge there and back has corners at the same place. */
static bool same(flat a, flat b) { return a.x == b.x && a.y == b.y; }

/* The corners that are not cut off yet, in boxes within boxes: runs of `order`, which follows a Morton curve, halved
 * until they are short. */
enum { RUN = 16 };
typedef struct box {
    flat low, high;
    uint32_t left; /* corners not cut off */
} box;

typedef struct outline {
    const flat *p;
    uint32_t *before, *next; /* corner, around what is left */
    uint32_t *order, *place; /* place: where in order a corner is */
    bool *cut;
    box *boxes; /* box k holds 2 k + 1 and 2 k + 2 */
    uint32_t count;
    uint64_t
        work; /* what may still be looked at: hostile polygons would take the cube of their corners */
} outline;

typedef struct spot {
    uint64_t code;
    uint32_t corner;
} spot;

static uint64_t spread(uint64_t x) {
    x = (x | x << 16) & 0x0000ffff0000ffff;
    x = (x | x << 8) & 0x00ff00ff00ff00ff;
    x = (x | x << 4) & 0x0f0f0f0f0f0f0f0f;
    x = (x | x << 2) & 0x3333333333333333;
    return (x | x << 1) & 0x5555555555555555;
}

/* 0 .. 2^32 - 1 from low to high. */
static uint64_t cell(double x, double low, double high) {
    return x > low ? (uint64_t)((x - low) / (high - low) * 0xffffffff) : 0;
}

static int by_code(const void *a, const void *b) {
    const spot *x = a, *y = b;
    if (x->code != y->code) return x->code < y->code ? -1 : 1;
    return (x->corner > y->corner) - (x->corner < y->corner);
}

static bool sort_corners(outline *o) {
    flat low = o->p[0], high = o->p[0];
    spot *spots = memory_resize(NULL, o->count, sizeof *spots);
    if (spots == NULL) return false;
    for (uint32_t i = 0; i < o->count; i++) {
        flat q = o->p[i];
        low = (flat){q.x < low.x ? q.x : low.x, q.y < low.y ? q.y : low.y};
        high = (flat){q.x > high.x ? q.x : high.x, q.y > high.y ? q.y : high.y};
    }
    for (uint32_t i = 0; i < o->count; i++)
        spots[i] = (spot){spread(cell(o->p[i].x, low.x, high.x)) |
                              spread(cell(o->p[i].y, low.y, high.y)) << 1,
                          i};
    if (o->count > RUN) qsort(spots, o->count, sizeof *spots, by_code);
    for (uint32_t i = 0; i < o->count; i++) {
        o->order[i] = spots[i].corner;
        o->place[spots[i].corner] = i;
    }
    free(spots);
    return true;
}

static void make_boxes(outline *o, uint32_t k, uint32_t begin, uint32_t end) {
    box b = {o->p[o->order[begin]], o->p[o->order[begin]], end - begin};
    for (uint32_t i = begin; i < end; i++) {
        flat q = o->p[o->order[i]];
        b.low = (flat){q.x < b.low.x ? q.x : b.low.x, q.y < b.low.y ? q.y : b.low.y};
        b.high = (flat){q.x > b.high.x ? q.x : b.high.x, q.y > b.high.y ? q.y : b.high.y};
    }
    o->boxes[k] = b;
    if (end - begin <= RUN) return;
    uint32_t middle = begin + (end - begin) / 2;
    make_boxes(o, 2 * k + 1, begin, middle);
    make_boxes(o, 2 * k + 2, middle, end);
}

/* Is all of the box on the right of the edge? As `turn` rounds: at the corner where it is largest. */
static bool is_right(flat a, flat b, const box *of) {
    flat most = {b.y > a.y ? of->low.x : of->high.x, b.x > a.x ? of->high.y : of->low.y};
    return turn(a, b, most) < 0;
}

/* Does the triangle hold a corner of the run, other than its own? */
static bool holds(outline *o, const flat t[3], uint32_t k, uint32_t begin, uint32_t end) {
    const box *b = &o->boxes[k];
    if (b->left == 0 || o->work == 0) return false;
    o->work--;
    if (is_right(t[0], t[1], b) || is_right(t[1], t[2], b) || is_right(t[2], t[0], b)) return false;
    if (end - begin > RUN) {
        uint32_t middle = begin + (end - begin) / 2;
        return holds(o, t, 2 * k + 1, begin, middle) || holds(o, t, 2 * k + 2, middle, end);
    }
    for (uint32_t i = begin; i < end; i++) {
        flat q = o->p[o->order[i]];
        if (o->cut[o->order[i]] || same(q, t[0]) || same(q, t[1]) || same(q, t[2])) continue;
        if (turn(t[0], t[1], q) >= 0 && turn(t[1], t[2], q) >= 0 && turn(t[2], t[0], q) >= 0)
            return true;
    }
    return false;
}

static bool is_ear(outline *o, uint32_t i) {
    const flat t[3] = {o->p[o->before[i]], o->p[i], o->p[o->next[i]]};
    return turn(t[0], t[1], t[2]) > 0 && !holds(o, t, 0, 0, o->count);
}

static void cut_corner(outline *o, uint32_t i) {
    o->next[o->before[i]] = o->next[i];
    o->before[o->next[i]] = o->before[i];
    o->cut[i] = true;
    uint32_t begin = 0, end = o->count, k = 0;
    for (;;) {
        o->boxes[k].left--;
        if (end - begin <= RUN) return;
        uint32_t middle = begin + (end - begin) / 2;
        bool second = o->place[i] >= middle;
        k = 2 * k + 1 + second;
        if (second)
            begin = middle;
        else
            end = middle;
    }
}

static size_t cut_ears(outline *o, uint32_t *indices) {
    size_t used = 0;
    uint32_t i = 0, tried = 0;
    uint64_t looks = 20 * (uint64_t)o->count;
    for (uint32_t left = o->count; left >= 3;) {
        /* Where nothing is an ear the polygon is not simple: any corner does. */
        if (left > 3 && tried < left && looks > 0 && o->work > 0 && !is_ear(o, i)) {
            looks--;
            i = o->next[i];
            tried++;
            continue;
        }
        indices[used++] = o->before[i];
        indices[used++] = i;
        indices[used++] = o->next[i];
        cut_corner(o, i);
        left--;
        i = o->next[i];
        tried = 0;
    }
    return used;
}

static size_t cut_outline(const flat *p, uint32_t count, uint32_t *indices) {
    size_t box_count = 1, used = 0;
    for (uint32_t run = count; run > RUN; run -= run / 2) box_count = 2 * box_count + 1;
    uint32_t *links = memory_resize(NULL, 4 * (size_t)count, sizeof *links);
    outline o = {.p = p,
                 .cut = memory_zeroed(count, sizeof *o.cut),
                 .boxes = memory_resize(NULL, box_count, sizeof *o.boxes),
                 .count = count,
                 .work = 1000 * (uint64_t)count};
    if (links && o.cut && o.boxes) {
        o.before = links, o.next = links + count;
        o.order = links + 2 * (size_t)count, o.place = links + 3 * (size_t)count;
        for (uint32_t i = 0; i < count; i++) {
            o.before[i] = i ? i - 1 : count - 1;
            o.next[i] = i + 1 < count ? i + 1 : 0;
        }
        if (sort_corners(&o)) {
            make_boxes(&o, 0, 0, count);
            used = cut_ears(&o, indices);
        }
    }
    free(links);
    free(o.cut);
    free(o.boxes);
    return used;
}

/* All corners turn left, and the outline goes up once and down once: a star turns round more often. */
static bool is_convex(const flat *p, uint32_t count) {
    uint32_t turns = 0;
    int upward = -1, first = -1;
    for (uint32_t i = 0; i < count; i++) {
        flat a = p[i], b = p[(i + 1) % count];
        if (turn(a, b, p[(i + 2) % count]) < 0) return false;
        if (same(a, b)) continue;
        int up = b.y > a.y || (b.y == a.y && b.x > a.x);
        turns += upward >= 0 && up != upward;
        if (first < 0) first = up;
        upward = up;
    }
    return turns + (upward != first) <= 2;
}

static size_t fan(uint32_t count, uint32_t *indices) {
    size_t used = 0;
    for (uint32_t i = 1; i + 1 < count; i++) {
        indices[used++] = 0;
        indices[used++] = i;
        indices[used++] = i + 1;
    }
    return used;
}

size_t triangulate(const vec3 *corners, uint32_t count, uint32_t *indices) {
    if (count <= 3) return fan(count, indices);
    dvec3 n = normal_of(corners, count);
    flat *p = memory_resize(NULL, count, sizeof *p);
    size_t used = 0;
    if (p) {
        for (uint32_t i = 0; i < count; i++) p[i] = flatten(corners[i], n);
        used = is_convex(p, count) ? fan(count, indices) : cut_outline(p, count, indices);
    }
    free(p);
    return used ? used : fan(count, indices); /* without memory */
}
