#include "importers/seams.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { CHAIN_MAX = 64 }; /* then a vertex is made twice, which does no harm */

void seams_free(seams *s) {
    free(s->uvs);
    free(s->next);
    free(s->source);
    *s = (seams){0};
}

static bool begin(seams *s, size_t vertex_count) {
    s->uvs = memory_zeroed(vertex_count, sizeof *s->uvs);
    s->next = memory_zeroed(vertex_count, sizeof *s->next);
    s->vertex_count = s->count = s->uv_capacity = s->next_capacity = vertex_count;
    return s->uvs && s->next;
}

uint32_t seams_find(seams *s, size_t vertex_count, uint32_t vertex, snell_vec2 uv) {
    if (s->next == NULL && !begin(s, vertex_count)) return UINT32_MAX;
    if (s->next[vertex] == 0) { /* from now on it points to itself at least */
        s->next[vertex] = vertex + 1;
        s->uvs[vertex] = uv;
        return vertex;
    }
    uint32_t at = vertex;
    for (int steps = 0; steps < CHAIN_MAX; steps++) {
        if (s->uvs[at].x == uv.x && s->uvs[at].y == uv.y) return at;
        at = s->next[at] - 1;
        if (at == vertex) break;
    }
    size_t added = s->count - s->vertex_count;
    if (s->count >= UINT32_MAX - 1 || !ARRAY_GROW(s->uvs, s->count, s->uv_capacity, 1) ||
        !ARRAY_GROW(s->next, s->count, s->next_capacity, 1) ||
        !ARRAY_GROW(s->source, added, s->source_capacity, 1))
        return UINT32_MAX;
    s->uvs[s->count] = uv;
    s->next[s->count] = s->next[vertex];
    s->source[added] = vertex;
    s->next[vertex] = (uint32_t)s->count + 1;
    return (uint32_t)s->count++;
}

static bool extend(snell_vec3 **values, const seams *s) {
    if (*values == NULL) return true;
    snell_vec3 *grown = memory_resize(*values, s->count, sizeof *grown);
    if (grown == NULL) return false;
    *values = grown;
    for (size_t i = s->vertex_count; i < s->count; i++)
        grown[i] = grown[s->source[i - s->vertex_count]];
    return true;
}

bool seams_apply(seams *s, surfaces *out) {
    if (s->next == NULL) return true;
    if (!extend(&out->positions, s) || !extend(&out->normals, s) || !extend(&out->colors, s))
        return false;
    free(out->uvs);
    out->uvs = s->uvs;
    s->uvs = NULL;
    out->vertex_count = s->count;
    return true;
}
