/* KHR_draco_mesh_compression by libdraco, which is C++: draco.cpp is the only file of the project that
 * is. Runs only in the sandboxed helper. */
#ifndef SNELL_IMPORTERS_DRACO_H
#define SNELL_IMPORTERS_DRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A decoded triangle mesh. */
typedef struct draco_mesh draco_mesh;

#if SNELL_HAS_DRACO

/* NULL and *out, to be closed; else what is wrong, valid until the next call. */
const char *draco_open(const void *data, size_t size, draco_mesh **out);
void draco_close(draco_mesh *m); /* NULL: nothing */
size_t draco_point_count(const draco_mesh *m);
size_t draco_index_count(const draco_mesh *m); /* three per triangle */
void draco_read_indices(const draco_mesh *m, uint32_t *out);
/* The attribute with the unique id, `components` per point; normalized: whole numbers become -1..1.
 * false: there is none, or it has other components or kinds of numbers. */
bool draco_read_floats(const draco_mesh *m, uint32_t id, unsigned components, bool normalized,
                       float *out);
bool draco_read_uints(const draco_mesh *m, uint32_t id, unsigned components, uint32_t *out);

#else /* nothing is ever opened */

static inline const char *draco_open(const void *data, size_t size, draco_mesh **out) {
    (void)data, (void)size, (void)out;
    return "this build cannot read it";
}
static inline void draco_close(draco_mesh *m) { (void)m; }
static inline size_t draco_point_count(const draco_mesh *m) { return (void)m, 0; }
static inline size_t draco_index_count(const draco_mesh *m) { return (void)m, 0; }
static inline void draco_read_indices(const draco_mesh *m, uint32_t *out) { (void)m, (void)out; }
static inline bool draco_read_floats(const draco_mesh *m, uint32_t id, unsigned components,
                                     bool normalized, float *out) {
    return (void)m, (void)id, (void)components, (void)normalized, (void)out, false;
}
static inline bool draco_read_uints(const draco_mesh *m, uint32_t id, unsigned components,
                                    uint32_t *out) {
    return (void)m, (void)id, (void)components, (void)out, false;
}

#endif

#ifdef __cplusplus
}
#endif
#endif
