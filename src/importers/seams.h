/* Texture coordinates by corner: vertices that lie on a seam become several. */
#ifndef SNELL_IMPORTERS_SEAMS_H
#define SNELL_IMPORTERS_SEAMS_H

#include "importers/surfaces.h"

typedef struct seams { /* all owned; begin with zeros */
    size_t vertex_count, count, uv_capacity, next_capacity, source_capacity;
    snell_vec2 *uvs; /* count of them */
    uint32_t *
        next; /* another of the same vertex, from 1; of vertices, 0 where none has been given yet */
    uint32_t *source; /* of what was added after vertex_count: its vertex */
} seams;
void seams_free(seams *s);

/* The number, of now or new, of the vertex (< vertex_count, the same in each call) with these coordinates;
 * UINT32_MAX when out of memory. */
uint32_t seams_find(seams *s, size_t vertex_count, uint32_t vertex, snell_vec2 uv);
/* Adds the new vertices to `out`, and all the coordinates. false: out of memory. */
bool seams_apply(seams *s, surfaces *out);

#endif
