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

static bool is_ear(const flat *p, const uint32_t *ring, uint32_t left, uint32_t i) {
    uint32_t a = ring[(i + left - 1) % left], b = ring[i], c = ring[(i + 1) % left];
    if (!(turn(p[a], p[b], p[c]) > 0)) return false;
    for (uint32_t k = 0; k < left; k++) {
        uint32_t q = ring[k];
        if (same(p[q], p[a]) || same(p[q], p[b]) || same(p[q], p[c])) continue;
        if (turn(p[a], p[b], p[q]) >= 0 && turn(p[b], p[c], p[q]) >= 0 &&
            turn(p[c], p[a], p[q]) >= 0)
            return false;
    }
    return true;
}

static size_t cut_ears(const flat *p, uint32_t *ring, uint32_t count, uint32_t *indices) {
    size_t used = 0;
    uint32_t i = 0, tried = 0;
    uint64_t looks = 20 * (uint64_t)count; /* hostile polygons would take the cube of it */
    for (uint32_t left = count; left >= 3;) {
        /* Where nothing is an ear the polygon is not simple: any corner does. */
        if (left > 3 && tried < left && looks > 0 && !is_ear(p, ring, left, i)) {
            looks--;
            i = (i + 1) % left;
            tried++;
            continue;
        }
        indices[used++] = ring[(i + left - 1) % left];
        indices[used++] = ring[i];
        indices[used++] = ring[(i + 1) % left];
        for (uint32_t k = i + 1; k < left; k++) ring[k - 1] = ring[k];
        left--;
        i = i % left;
        tried = 0;
    }
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
    uint32_t *ring = memory_resize(NULL, count, sizeof *ring);
    size_t used = 0;
    if (p && ring) {
        for (uint32_t i = 0; i < count; i++) {
            p[i] = flatten(corners[i], n);
            ring[i] = i;
        }
        used = is_convex(p, count) ? fan(count, indices) : cut_ears(p, ring, count, indices);
    }
    free(p);
    free(ring);
    return used ? used : fan(count, indices); /* without memory */
}
