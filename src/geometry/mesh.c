/* A triangle mesh. Its triangles are tested by the kernels of the acceleration structure; here is
 * what a mesh may be, and what a point on it looks like. */
#include "geometry/mesh.h"

#include "base/error.h"
#include "geometry/surface.h"
#include "sampling/warp.h"

DESCRIBE_TABLE(mesh, MESH_FIELDS)

static snell_status check_per_vertex(const mesh_desc *mesh, const char *name, size_t count) {
    size_t vertices = mesh_vertex_count(mesh);
    if (count == 0 || count == vertices) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give one per vertex, or none",
                     "mesh: '%s' has %zu entries for %zu positions", name, count, vertices);
}

static snell_status check_keys(const mesh_desc *mesh) {
    size_t keys = mesh->key_times_count;
    if (keys == 0) return SNELL_OK;
    if (keys == 1)
        return error_set(SNELL_ERR_ARGUMENT, "leave out the key's time if nothing deforms",
                         "mesh: it deforms between two keys or more, not at one");
    if (keys > MESH_KEYS_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "give those around the time of the shutter",
                         "mesh: %zu keys, more than %d", keys, MESH_KEYS_MAX);
    for (size_t i = 1; i < keys; i++)
        if (!(mesh->key_times[i] > mesh->key_times[i - 1]))
            return error_set(SNELL_ERR_ARGUMENT, "put the keys in the order of their times",
                             "mesh: key %zu, at %.6g s, is not later than the one before", i + 1,
                             (double)mesh->key_times[i]);
    if (mesh->positions_count % keys != 0)
        return error_set(SNELL_ERR_ARGUMENT, "give all vertices at each key",
                         "mesh: %zu positions are not as many at each of %zu keys",
                         mesh->positions_count, keys);
    if (mesh->normals_count != 0 && mesh->normals_count != mesh->positions_count)
        return error_set(SNELL_ERR_ARGUMENT, "give one for each vertex at each key, or none",
                         "mesh: %zu normals for %zu positions", mesh->normals_count,
                         mesh->positions_count);
    return SNELL_OK;
}

static snell_status check_slots(const mesh_desc *mesh) {
    size_t triangles = mesh_triangle_count(mesh);
    if (mesh->material_slots_count == 0) return SNELL_OK;
    if (mesh->material_slots_count != triangles)
        return error_set(SNELL_ERR_ARGUMENT, "give one per triangle, or none",
                         "mesh: 'material_slots' has %zu entries for %zu triangles",
                         mesh->material_slots_count, triangles);
    for (size_t i = 0; i < triangles; i++)
        if (mesh->material_slots[i] >= mesh->materials_count)
            return error_set(SNELL_ERR_ARGUMENT, "slots count from 0",
                             "mesh: triangle %zu has material slot %u, but there are %zu materials",
                             i, mesh->material_slots[i], mesh->materials_count);
    return SNELL_OK;
}

static snell_status check(const void *desc) {
    const mesh_desc *mesh = desc;
    if (mesh->indices_count % 3 != 0)
        return error_set(SNELL_ERR_ARGUMENT, "every triangle takes three indices",
                         "mesh: %zu indices are not a multiple of three", mesh->indices_count);
    if (mesh_triangle_count(mesh) >= NO_ID)
        return error_set(SNELL_ERR_ARGUMENT, "split it into several meshes",
                         "mesh: %zu triangles are too many", mesh_triangle_count(mesh));
    snell_status status = check_keys(mesh);
    if (status) return status;
    size_t vertices = mesh_vertex_count(mesh);
    for (size_t i = 0; i < mesh->indices_count; i++)
        if (mesh->indices[i] >= vertices)
            return error_set(
                SNELL_ERR_ARGUMENT, "indices count from 0",
                "mesh: index %u of triangle %zu is out of range: there are %zu positions",
                mesh->indices[i], i / 3, vertices);
    if (mesh->key_times_count == 0) status = check_per_vertex(mesh, "normals", mesh->normals_count);
    if (!status) status = check_per_vertex(mesh, "uvs", mesh->uvs_count);
    if (!status) status = check_per_vertex(mesh, "colors", mesh->colors_count);
    if (!status) status = check_per_vertex(mesh, "alphas", mesh->alphas_count);
    if (!status) status = check_per_vertex(mesh, "uvs2", mesh->uvs2_count);
    if (!status && mesh->tangents_count && mesh->tangents_count != 4 * vertices)
        status = error_set(SNELL_ERR_ARGUMENT, "give four numbers per vertex, or none",
                           "mesh: 'tangents' has %zu entries for %zu positions",
                           mesh->tangents_count, vertices);
    for (size_t i = 0; !status && i < mesh->colors_count; i++) {
        vec3 c = mesh->colors[i];
        if (c.x < 0 || c.y < 0 || c.z < 0)
            status = error_set(SNELL_ERR_ARGUMENT, "colours are 0 or more",
                               "mesh: the colour of vertex %zu is negative", i);
    }
    return status ? status : check_slots(mesh);
}

bounds3 mesh_triangle_bounds(const mesh_desc *mesh, size_t triangle) {
    const uint32_t *index = mesh->indices + 3 * triangle;
    size_t keys = mesh_key_count(mesh), vertices = mesh_vertex_count(mesh);
    bounds3 box = bounds3_empty();
    for (size_t k = 0; k < keys; k++)
        for (int i = 0; i < 3; i++)
            box = bounds3_add_point(box, mesh->positions[k * vertices + index[i]]);
    return box;
}

static bounds3 primitive_bounds(const void *desc, uint32_t primitive) {
    return mesh_triangle_bounds(desc, primitive);
}

static bounds3 bounds(const void *desc) {
    const mesh_desc *mesh = desc;
    size_t keys = mesh_key_count(mesh), vertices = mesh_vertex_count(mesh);
    bounds3 box = bounds3_empty();
    for (size_t k = 0; k < keys; k++)
        for (size_t i = 0; i < mesh->indices_count; i++)
            box = bounds3_add_point(box, mesh->positions[k * vertices + mesh->indices[i]]);
    return box;
}

static uint32_t primitive_count(const void *desc) { return (uint32_t)mesh_triangle_count(desc); }

static dvec3 blend(const snell_vec3 *values, const uint32_t *index, const double weight[3]) {
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < 3; i++)
        sum = dvec3_add(sum, dvec3_scale(dvec3_from(values[index[i]]), weight[i]));
    return sum;
}

mesh_corners mesh_corners_of(const mesh_desc *mesh, uint32_t triangle) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    mesh_corners at;
    for (int i = 0; i < 3; i++) {
        at.vertex[i] = dvec3_from(mesh->positions[index[i]]);
        if (mesh->normals_count) at.normal[i] = dvec3_from(mesh->normals[index[i]]);
    }
    return at;
}

/* The vertex normals, each made unit first, blended; the geometric normal where they say nothing.
 */
static dvec3 shading_normal(const mesh_desc *mesh, const mesh_corners *at, const double weight[3],
                            dvec3 n) {
    if (mesh->normals_count == 0) return n;
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        dvec3 vertex = dvec3_normalize(at->normal[i]);
        if (!(dvec3_dot(vertex, vertex) > 0)) vertex = n;
        sum = dvec3_add(sum, dvec3_scale(vertex, weight[i]));
    }
    if (!(dvec3_length(sum) > 1e-6)) return n; /* they cancel */
    sum = dvec3_normalize(sum);
    double cosine = dvec3_dot(sum, n);
    if (cosine < 0) return dvec3_negate(sum); /* the file winds its triangles the other way */
    return cosine > 0 ? sum : n;
}

void mesh_hit_weights(const hit *found, double weight[3]) {
    double u = clamp01(found->u), v = clamp01(found->v);
    if (u + v > 1) {
        double sum = u + v;
        u /= sum;
        v /= sum;
    }
    weight[0] = double_max(1 - u - v, 0);
    weight[1] = u;
    weight[2] = v;
}

/* The kernel's float test (Woop, Benthin, Wald 2013) subtracts the origin from the vertices (one
 * rounding of a difference no larger than the triangle, for an origin near it), shears (three more)
 * and multiplies (three): what it sees is the triangle with vertices moved by under 16 roundings of
 * its extent. Vertices are floats, so their magnitude matters only through the origin's rounding;
 * two roundings of it are kept for a kernel that stores edges relative to a common point. The
 * neighbour in the same surface is the one that matters: the triangle itself is excluded by id. To
 * that test a ray within 32 roundings (2e-6) of the tangent plane sees a neighbour edge-on; no
 * offset bounds its t. */
static double test_error(const dvec3 vertex[3]) {
    double extent = 0, magnitude = 0;
    for (int i = 0; i < 3; i++) {
        dvec3 edge = dvec3_sub(vertex[(i + 1) % 3], vertex[i]), p = vertex[i];
        dvec3 size = {fabs(edge.x), fabs(edge.y), fabs(edge.z)};
        extent = double_max(extent, dvec3_largest(size));
        magnitude = double_max(magnitude, dvec3_largest((dvec3){fabs(p.x), fabs(p.y), fabs(p.z)}));
    }
    return FLOAT_EPSILON * (16 * extent + 2 * magnitude);
}

/* u, v at the point, and how the point moves with them: p = p0 + a ab + b ac and uv = uv0 + a duv1 +
 * b duv2, solved for dp/du and dp/dv, which stay as they are where there is no solution. */
static void find_uv(const snell_vec2 *uvs, const uint32_t *index, const double weight[3], dvec3 ab,
                    dvec3 ac, double uv[2], dvec3 *dpdu, dvec3 *dpdv) {
    double u[3], v[3];
    uv[0] = uv[1] = 0;
    for (int i = 0; i < 3; i++) {
        u[i] = (double)uvs[index[i]].x;
        v[i] = (double)uvs[index[i]].y;
        uv[0] += weight[i] * u[i];
        uv[1] += weight[i] * v[i];
    }
    double u1 = u[1] - u[0], u2 = u[2] - u[0], v1 = v[1] - v[0], v2 = v[2] - v[0];
    double area = u1 * v2 - u2 * v1;
    if (!(fabs(area) > 0x1p-40 * (fabs(u1 * v2) + fabs(u2 * v1)))) return;
    *dpdu = dvec3_scale(dvec3_sub(dvec3_scale(ab, v2), dvec3_scale(ac, v1)), 1 / area);
    *dpdv = dvec3_scale(dvec3_sub(dvec3_scale(ac, u1), dvec3_scale(ab, u2)), 1 / area);
}

static void set_uv(const mesh_desc *mesh, const uint32_t *index, const double weight[3], dvec3 ab,
                   dvec3 ac, surface *out) {
    double uv[2];
    find_uv(mesh->uvs, index, weight, ab, ac, uv, &out->dpdu, &out->dpdv);
    out->u = uv[0];
    out->v = uv[1];
}

bool mesh_point_weights(const mesh_corners *at, dvec3 p, double weight[3]) {
    dvec3 ab = dvec3_sub(at->vertex[1], at->vertex[0]),
          ac = dvec3_sub(at->vertex[2], at->vertex[0]), ap = dvec3_sub(p, at->vertex[0]),
          n = dvec3_cross(ab, ac);
    double square = dvec3_dot(n, n);
    if (!(square > 0)) return false;
    weight[1] = dvec3_dot(dvec3_cross(ap, ac), n) / square;
    weight[2] = dvec3_dot(dvec3_cross(ab, ap), n) / square;
    weight[0] = 1 - weight[1] - weight[2];
    return true;
}

void mesh_second_uv(const mesh_desc *mesh, uint32_t triangle, const mesh_corners *at,
                    const double weight[3], double uv[2], dvec3 *dpdu, dvec3 *dpdv) {
    *dpdu = *dpdv = (dvec3){0, 0, 0};
    find_uv(mesh->uvs2, mesh->indices + 3 * (size_t)triangle, weight,
            dvec3_sub(at->vertex[1], at->vertex[0]), dvec3_sub(at->vertex[2], at->vertex[0]), uv,
            dpdu, dpdv);
}

dvec3 mesh_tangent(const mesh_desc *mesh, uint32_t triangle, const double weight[3], double *sign) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const float *t = mesh->tangents + 4 * (size_t)index[i];
        dvec3 one = {(double)t[0], (double)t[1], (double)t[2]};
        sum = dvec3_add(sum, dvec3_scale(one, weight[i]));
    }
    *sign = mesh->tangents[4 * (size_t)index[0] + 3] < 0 ? -1 : 1;
    return sum;
}

/* The blended normal's change: dN = db (n1 - n0) + dc (n2 - n0) before it is made unit, where dp =
 * db ab + dc ac. */
dvec3 mesh_bend(const mesh_desc *mesh, const mesh_corners *at, const hit *found, dvec3 dp) {
    const dvec3 *vertex = at->vertex, none = {0, 0, 0};
    dvec3 normal[3];
    if (mesh->normals_count == 0) return none;
    for (int i = 0; i < 3; i++) normal[i] = dvec3_normalize(at->normal[i]);
    dvec3 ab = dvec3_sub(vertex[1], vertex[0]), ac = dvec3_sub(vertex[2], vertex[0]);
    dvec3 n = dvec3_cross(ab, ac);
    double weight[3], square = dvec3_dot(n, n);
    mesh_hit_weights(found, weight);
    dvec3 sum = none;
    for (int i = 0; i < 3; i++) sum = dvec3_add(sum, dvec3_scale(normal[i], weight[i]));
    double length = dvec3_length(sum);
    if (!(square > 0) || !(length > 1e-6)) return none;
    double db = dvec3_dot(dvec3_cross(dp, ac), n) / square,
           dc = dvec3_dot(dvec3_cross(ab, dp), n) / square;
    dvec3 change = dvec3_add(dvec3_scale(dvec3_sub(normal[1], normal[0]), db),
                             dvec3_scale(dvec3_sub(normal[2], normal[0]), dc));
    sum = dvec3_scale(sum, 1 / length);
    change = dvec3_sub(change, dvec3_scale(sum, dvec3_dot(sum, change)));
    /* The file may wind its triangles the other way: then ns is the negated blend. */
    return dvec3_scale(change, dvec3_dot(sum, n) < 0 ? -1 / length : 1 / length);
}

static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    mesh_corners at = mesh_corners_of(desc, found->primitive);
    return mesh_bend(desc, &at, found, dp);
}

void mesh_surface(const mesh_desc *mesh, uint32_t triangle, const mesh_corners *at,
                  const double weight[3], dvec3 away, surface *out) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    const dvec3 *vertex = at->vertex;
    dvec3 ab = dvec3_sub(vertex[1], vertex[0]), ac = dvec3_sub(vertex[2], vertex[0]);
    dvec3 n = dvec3_normalize(dvec3_cross(ab, ac));
    if (!(dvec3_dot(n, n) > 0)) n = dvec3_normalize(away);
    dvec3 p =
        dvec3_add(vertex[0], dvec3_add(dvec3_scale(ab, weight[1]), dvec3_scale(ac, weight[2])));
    *out = surface_make(p, n, test_error(vertex));
    out->ns = shading_normal(mesh, at, weight, n);
    out->u = weight[1];
    out->v = weight[2];
    if (mesh->uvs_count) set_uv(mesh, index, weight, ab, ac, out);
    if (mesh->colors_count) out->tint = blend(mesh->colors, index, weight);
    if (mesh->alphas_count) {
        const uint8_t *alphas = mesh->alphas;
        out->alpha = 0;
        for (int i = 0; i < 3; i++) out->alpha += weight[i] * alphas[index[i]] / 255;
    }
    if (mesh->material_slots_count) out->material_slot = mesh->material_slots[triangle];
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    double weight[3];
    mesh_corners at = mesh_corners_of(desc, found->primitive);
    mesh_hit_weights(found, weight);
    mesh_surface(desc, found->primitive, &at, weight, dvec3_negate(dvec3_from(beam->d)), out);
}

double mesh_corners_area(const mesh_corners *at) {
    dvec3 ab = dvec3_sub(at->vertex[1], at->vertex[0]),
          ac = dvec3_sub(at->vertex[2], at->vertex[0]);
    return dvec3_length(dvec3_cross(ab, ac)) / 2;
}

static double area(const void *desc, uint32_t primitive) {
    mesh_corners at = mesh_corners_of(desc, primitive);
    return mesh_corners_area(&at);
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    sample2 on = warp_triangle((sample2){u, v});
    double weight[3] = {1 - on.x - on.y, on.x, on.y};
    mesh_corners at = mesh_corners_of(desc, primitive);
    mesh_surface(desc, primitive, &at, weight, (dvec3){0, 1, 0}, out);
}

/* Mostly the first triangle says no. One that deforms may have an area at another time. */
static const char *nothing(const void *desc) {
    const mesh_desc *mesh = desc;
    size_t count = mesh_triangle_count(mesh);
    if (count && mesh->key_times_count) return NULL;
    for (size_t i = 0; i < count; i++)
        if (area(desc, (uint32_t)i) > 0) return NULL;
    return count ? "has no triangle with an area" : "has no triangles";
}

const primitive_type primitive_mesh = {
    .info = TYPE_INFO(CATEGORY_SHAPE, mesh, "mesh", "triangles"),
    .flat = true,
    .check = check,
    .nothing = nothing,
    .bounds = bounds,
    .primitive_count = primitive_count,
    .primitive_bounds = primitive_bounds,
    .surface = fill_surface,
    .area = area,
    .sample_area = sample_area,
    .bend = bend,
};
