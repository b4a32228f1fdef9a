#include "geometry/deforming.h"

#include <stdlib.h>

#include "base/memory.h"
#include "sampling/warp.h"

/* ---- keys and times ---- */

/* The keys in use: the last that is not after `open`, to the first that is not before `close`. */
static void find_range(const mesh_desc *mesh, double open, double close, size_t *first,
                       size_t *last) {
    size_t end = mesh->key_times_count - 1;
    *first = 0;
    *last = end;
    while (*first < end && (double)mesh->key_times[*first + 1] <= open) ++*first;
    while (*last > *first && (double)mesh->key_times[*last - 1] >= close) --*last;
}

uint32_t deforming_count_keys(const mesh_desc *mesh, double open, double close) {
    size_t first, last;
    find_range(mesh, open, close, &first, &last);
    return (uint32_t)(last - first + 1);
}

deforming_mesh *deforming_create(const mesh_desc *mesh, double open, double close) {
    size_t first, last, vertices = mesh_vertex_count(mesh);
    deforming_mesh *m = memory_zeroed(1, sizeof *m);
    if (m == NULL) return NULL;
    find_range(mesh, open, close, &first, &last);
    m->mesh = *mesh;
    m->mesh.positions += first * vertices;
    m->mesh.positions_count = vertices;
    if (m->mesh.normals_count) m->mesh.normals += first * vertices;
    m->times = mesh->key_times + first;
    m->key_count = (uint32_t)(last - first + 1);
    return m;
}

deforming_mesh deforming_whole(const deforming_mesh *m) {
    deforming_mesh whole = *m;
    size_t before = (size_t)(m->times - m->mesh.key_times) * m->mesh.positions_count;
    whole.mesh.positions -= before;
    if (m->mesh.normals_count) whole.mesh.normals -= before;
    whole.times = m->mesh.key_times;
    whole.key_count = (uint32_t)m->mesh.key_times_count;
    return whole;
}

deforming_time deforming_find(const deforming_mesh *m, float time) {
    uint32_t low = 0, high = m->key_count - 1; /* the last key that is not after the time, or 0 */
    while (low < high) {
        uint32_t middle = low + (high - low + 1) / 2;
        if (m->times[middle] <= time)
            low = middle;
        else
            high = middle - 1;
    }
    if (low + 1 == m->key_count || !(time > m->times[low]))
        return (deforming_time){low, low, {1, 0}};
    double from = (double)m->times[low], length = (double)m->times[low + 1] - from,
           s = ((double)time - from) / length;
    return (deforming_time){low, low + 1, {(float)(1 - s), (float)s}};
}

/* ---- one triangle ---- */

static vec3 mix(vec3 a, vec3 b, const float weight[2]) {
    return (vec3){deforming_mix(a.x, b.x, weight), deforming_mix(a.y, b.y, weight),
                  deforming_mix(a.z, b.z, weight)};
}

/* Normals turn from one unit vector to the other; where they are opposite there is none between. */
static dvec3 mix_normals(vec3 a, vec3 b, const float weight[2]) {
    dvec3 from = dvec3_normalize(dvec3_from(a)), to = dvec3_normalize(dvec3_from(b));
    return dvec3_add(dvec3_scale(from, (double)weight[0]), dvec3_scale(to, (double)weight[1]));
}

static mesh_corners corners_at(const deforming_mesh *m, uint32_t triangle,
                               const deforming_time *when) {
    const uint32_t *index = m->mesh.indices + 3 * (size_t)triangle;
    const vec3 *from = deforming_positions(m, when->key), *to = deforming_positions(m, when->next);
    mesh_corners at;
    for (int i = 0; i < 3; i++)
        at.vertex[i] = dvec3_from(mix(from[index[i]], to[index[i]], when->weight));
    if (m->mesh.normals_count == 0) return at;
    from = m->mesh.normals + (size_t)when->key * m->mesh.positions_count;
    to = m->mesh.normals + (size_t)when->next * m->mesh.positions_count;
    for (int i = 0; i < 3; i++)
        at.normal[i] = mix_normals(from[index[i]], to[index[i]], when->weight);
    return at;
}

static deforming_time at_key(uint32_t key) { return (deforming_time){key, key, {1, 0}}; }

static deforming_time time_of(const deforming_mesh *m) { return m->posed ? m->now : at_key(0); }

mesh_corners deforming_corners(const deforming_mesh *m, uint32_t triangle) {
    deforming_time when = time_of(m);
    return corners_at(m, triangle, &when);
}

/* ---- what a shape implements ---- */

static uint32_t primitive_count(const void *shape) {
    return (uint32_t)mesh_triangle_count(&((const deforming_mesh *)shape)->mesh);
}

static bounds3 triangle_bounds_at(const deforming_mesh *m, uint32_t triangle,
                                  const deforming_time *when) {
    const uint32_t *index = m->mesh.indices + 3 * (size_t)triangle;
    const vec3 *from = deforming_positions(m, when->key), *to = deforming_positions(m, when->next);
    bounds3 box = bounds3_empty();
    for (int i = 0; i < 3; i++)
        box = bounds3_add_point(box, mix(from[index[i]], to[index[i]], when->weight));
    return box;
}

static bounds3 primitive_bounds(const void *shape, uint32_t triangle) {
    const deforming_mesh *m = shape;
    if (m->posed) return triangle_bounds_at(m, triangle, &m->now);
    bounds3 box = bounds3_empty();
    for (uint32_t k = 0; k < m->key_count; k++) {
        deforming_time when = at_key(k);
        box = bounds3_union(box, triangle_bounds_at(m, triangle, &when));
    }
    return box;
}

static bounds3 bounds(const void *shape) {
    bounds3 box = bounds3_empty();
    for (uint32_t i = 0; i < primitive_count(shape); i++)
        box = bounds3_union(box, primitive_bounds(shape, i));
    return box;
}

static void fill_surface(const void *shape, const local_ray *beam, const hit *found, surface *out) {
    const deforming_mesh *m = shape;
    double weight[3];
    mesh_corners at = deforming_corners(m, found->primitive);
    mesh_hit_weights(found, weight);
    mesh_surface(&m->mesh, found->primitive, &at, weight, dvec3_negate(dvec3_from(beam->d)), out);
}

static dvec3 bend(const void *shape, const hit *found, dvec3 dp) {
    const deforming_mesh *m = shape;
    mesh_corners at = deforming_corners(m, found->primitive);
    return mesh_bend(&m->mesh, &at, found, dp);
}

static double area(const void *shape, uint32_t triangle) {
    const deforming_mesh *m = shape;
    double largest = 0;
    uint32_t end = m->posed ? 1 : m->key_count;
    for (uint32_t k = 0; k < end; k++) {
        deforming_time when = m->posed ? m->now : at_key(k);
        mesh_corners at = corners_at(m, triangle, &when);
        largest = double_max(largest, mesh_corners_area(&at));
    }
    return largest;
}

static void sample_area(const void *shape, uint32_t triangle, double u, double v, surface *out) {
    const deforming_mesh *m = shape;
    sample2 on = warp_triangle((sample2){u, v});
    double weight[3] = {1 - on.x - on.y, on.x, on.y};
    mesh_corners at = deforming_corners(m, triangle);
    mesh_surface(&m->mesh, triangle, &at, weight, (dvec3){0, 1, 0}, out);
}

const primitive_type primitive_deforming = {
    .info = {.category = CATEGORY_SHAPE, .name = "mesh", .help = "triangles that deform"},
    .flat = true,
    .bounds = bounds,
    .release = free,
    .primitive_count = primitive_count,
    .primitive_bounds = primitive_bounds,
    .surface = fill_surface,
    .area = area,
    .sample_area = sample_area,
    .bend = bend,
};
