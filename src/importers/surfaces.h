/* What the readers of triangles (PLY, STL, OBJ) share: a mesh in the making, the normals that a file
 * leaves out, and where a text says something. */
#ifndef SNELL_IMPORTERS_SURFACES_H
#define SNELL_IMPORTERS_SURFACES_H

#include "importers/names.h"

/* Three indices a triangle; normals, uvs, colors: NULL or one per vertex; slots: NULL or one per triangle, an index into
 * materials. All owned; begin with zeros. */
typedef struct surfaces {
    snell_vec3 *positions, *normals, *colors;
    snell_vec2 *uvs;
    uint32_t *indices, *slots;
    snell_material_id *materials;
    size_t vertex_count, index_count, material_count;
} surfaces;
void surfaces_free(surfaces *s);

/* Polygons on their way to triangles: the corners of one with n lie at the beginning of the 3 (n - 2) indices
 * that it will need. All owned; begin with zeros. */
typedef struct polygon {
    size_t first; /* index */
    uint32_t corners;
} polygon;
typedef struct polygons {
    uint32_t *indices;
    polygon *list; /* those of more than three corners */
    size_t index_count, index_capacity, count, capacity;
} polygons;
/* Room for the corners of one more, at least three; NULL when out of memory, or of indices of 32 bits. */
uint32_t *polygons_add(polygons *p, uint32_t corners);
/* Cuts them into triangles; indices are in range of the positions. Indices of triangles that were there stay where they
 * are. false: out of memory. */
bool polygons_cut(polygons *p, const snell_vec3 *positions);

/* Of a triangle: 0 is flat, others are smooth among equals. */
enum { SURFACES_FLAT = 0, SURFACES_BY_ANGLE = 1 };

/* Normals for the vertices that have none (`lacks`; NULL: all of them): the mean of those of the triangles at
 * that place, wherever they meet at less than 60 degrees and are of one smoothing group (`groups`, one per triangle;
 * NULL: SURFACES_BY_ANGLE everywhere). A vertex with several such means becomes several. Positions are finite. */
snell_status surfaces_smooth(surfaces *s, const uint8_t *lacks, const uint32_t *groups);

/* As a mesh and an instance of it, with the material (NO_MATERIAL: grey, or slots) and the rotation by which `up`
 * becomes +Y; takes the arrays, also on failure. name: may be NULL; line: where it begins, or 0. */
snell_status surfaces_add(surfaces *s, description *d, name_set *names, const char *name,
                          uint32_t material, const char *up, object_source where);

/* A grey Lambert material, as files without materials are drawn; made once: *material is NO_MATERIAL before. */
snell_status surfaces_plain(description *d, const char *path, float color, uint32_t *material);

/* The line and column, from 1, of a place in a text. Lines end with \n, \r\n or \r. */
source_place text_place(const char *path, const char *text, const char *at);

#endif
