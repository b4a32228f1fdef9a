#include "geometry/closure.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* The finalizer of SplitMix64 (Steele, Lea, Flood 2014). */
static uint64_t scramble(uint64_t x) {
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* A power of two, at least twice the count: open addressing stays short. */
static size_t table_size(size_t count) {
    size_t size = 16;
    while (size < 2 * count) size *= 2;
    return size;
}

static uint64_t hash_position(vec3 p) {
    const float values[3] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f}; /* -0 is 0 */
    uint32_t bits[3];
    memcpy(bits, values, sizeof bits);
    return scramble(scramble((uint64_t)bits[0] << 32 | bits[1]) ^ bits[2]);
}

static bool same_place(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* For every vertex the first one at its place, in `first`. */
static bool weld(const mesh_desc *mesh, uint32_t *first) {
    size_t size = table_size(mesh->positions_count), mask = size - 1;
    uint32_t *slots = memory_zeroed(size, sizeof *slots);
    if (slots == NULL) return false;
    for (size_t i = 0; i < mesh->positions_count; i++) {
        vec3 p = mesh->positions[i];
        size_t at = (size_t)hash_position(p) & mask;
        while (slots[at] && !same_place(mesh->positions[slots[at] - 1], p)) at = (at + 1) & mask;
        if (slots[at] == 0) slots[at] = (uint32_t)i + 1;
        first[i] = slots[at] - 1;
    }
    free(slots);
    return true;
}

/* low < high are vertices; forward: triangles that run from low to high; unused: all 0. */
typedef struct edge_slot {
    uint32_t low, high, forward, backward;
} edge_slot;

static void count_edge(edge_slot *slots, size_t mask, uint32_t from, uint32_t to) {
    uint32_t low = from < to ? from : to, high = from < to ? to : from;
    size_t at = (size_t)scramble((uint64_t)low << 32 | high) & mask;
    while (slots[at].high && (slots[at].low != low || slots[at].high != high)) at = (at + 1) & mask;
    slots[at].low = low;
    slots[at].high = high; /* never 0: low is less */
    if (from == low)
        slots[at].forward++;
    else
        slots[at].backward++;
}

static mesh_closure judge(const mesh_desc *mesh, const edge_slot *slots, size_t size,
                          vec3 edge[2]) {
    mesh_closure found = MESH_ORIENTED;
    for (size_t i = 0; i < size; i++) {
        if (slots[i].forward == slots[i].backward) continue;
        found = MESH_PAIRED;
        if ((slots[i].forward + slots[i].backward) % 2 == 0) continue;
        edge[0] = mesh->positions[slots[i].low];
        edge[1] = mesh->positions[slots[i].high];
        return MESH_OPEN;
    }
    return found;
}

snell_status mesh_find_closure(const mesh_desc *mesh, mesh_closure *out, vec3 edge[2]) {
    size_t size = table_size(mesh->indices_count);
    uint32_t *first = memory_resize(NULL, mesh->positions_count + 1, sizeof *first);
    edge_slot *slots = memory_zeroed(size, sizeof *slots);
    bool ok = first && slots && weld(mesh, first);
    for (size_t i = 0; ok && i + 2 < mesh->indices_count; i += 3)
        for (size_t k = 0; k < 3; k++) {
            uint32_t from = first[mesh->indices[i + k]], to = first[mesh->indices[i + (k + 1) % 3]];
            if (from != to) count_edge(slots, size - 1, from, to);
        }
    if (ok) *out = judge(mesh, slots, size, edge);
    free(first);
    free(slots);
    return ok ? SNELL_OK : error_no_memory();
}
