/* A scene of the kernel benchmark under snell's acceleration structure. */
#ifndef SNELL_BENCH_KERNEL_SUBJECT_H
#define SNELL_BENCH_KERNEL_SUBJECT_H

#include "accel/accel.h"
#include "geometry/deforming.h"
#include "scenes.h"

typedef struct subject {
    bench_scene scene;
    bounds3 bounds; /* at the first key */
    double size;    /* their diagonal */
    mesh_desc mesh;
    vec3 *keys; /* of a mesh that deforms: positions at both */
    deforming_mesh *deforming;
    void *sphere_descs;
    accel_geometry *geometries;
    accel_instance *instances;
    accel *accel;
} subject;

/* deforming: the mesh has a second key, at which it is stretched, and twisted about y by up to a
 * radian. */
void subject_make(subject *s, const char *name, double detail, bool deforming);
/* Builds, or builds anew; seconds by the clock, on every processor. leaf_size 0: chosen. */
double subject_build(subject *s, uint32_t leaf_size, accel_quality quality);
void subject_free(subject *s);

size_t subject_count(const subject *s); /* triangles or spheres */
static inline uint32_t subject_keys(const subject *s) { return s->deforming ? 2 : 1; }
const vec3 *subject_positions(const subject *s, uint32_t key);
/* The corners of a triangle. */
void subject_corners(const subject *s, uint32_t triangle, float time, dvec3 out[3]);
dvec3 subject_normal(const subject *s, const hit *h, dvec3 p, float time); /* unit, either side */

#endif
