/* pbrt's curves. Those that follow each other are gathered, since hair has a million of them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

typedef struct strand {
    vec3 *points; /* owned */
    size_t count;
    const char *basis, *kind;
    double first,
        step; /* how far along the curve, 0 to 1, the first point is; from one to the next */
    double width0, width1;
} strand;

static double radius_at(const strand *c, size_t i) {
    double at = c->first + c->step * (double)i;
    return double_max((c->width0 + at * (c->width1 - c->width0)) / 2, 0);
}

/* ---- gathering ---- */

void pbrt_strands_free(pbrt_strands *strands) {
    free(strands->points);
    free(strands->radii);
    free(strands->starts);
}

static void list_params(const pbrt_strands *g, snell_param out[5]) {
    const snell_param list[5] = {
        {"points", SNELL_PARAM_ARRAY, {.array = {g->points, g->point_count}}},
        {"radii", SNELL_PARAM_ARRAY, {.array = {g->radii, g->point_count}}},
        {"basis", SNELL_PARAM_STRING, {.s = g->basis}},
        {"kind", SNELL_PARAM_STRING, {.s = g->kind}},
        {"starts", SNELL_PARAM_ARRAY, {.array = {g->starts, g->start_count}}}};
    memcpy(out, list, sizeof list);
}

snell_status pbrt_flush_strands(pbrt *p) {
    pbrt_strands *g = &p->strands;
    if (p->status || g->start_count == 0) return p->status;
    snell_param params[5];
    transform still = transform_identity();
    object_source source = {NULL, g->place.file, g->place.line};
    uint32_t shape, made;
    list_params(g, params);
    snell_status status =
        description_add(p->d, CATEGORY_SHAPE, "curves", params, 5, source, &shape);
    if (!status) status = description_add_instance(p->d, shape, g->material, &still, source, &made);
    g->point_count = g->start_count = 0;
    return status ? pbrt_blame(p, g->place, status) : pbrt_add_part(p, g->place, made);
}

/* Into the world, where its width grows as volumes do. */
static snell_status gather(pbrt *p, const pbrt_drawn *s, const strand *c, uint32_t material) {
    pbrt_strands *g = &p->strands;
    source_place place = s->params->place;
    bool same = g->start_count && g->material == material && g->point_count < 1u << 24 &&
                strcmp(g->basis, c->basis) == 0 && strcmp(g->kind, c->kind) == 0;
    if (!same && pbrt_flush_strands(p)) return p->status;
    if (!same) g->material = material, g->basis = c->basis, g->kind = c->kind, g->place = place;
    dtransform to_world = pbrt_to_world(p, 0);
    double scale = fn_cbrt(fabs(pbrt_determinant(&to_world)));
    if (!ARRAY_GROW(g->points, g->point_count, g->point_capacity, c->count) ||
        !ARRAY_GROW(g->radii, g->point_count, g->radius_capacity, c->count) ||
        !ARRAY_GROW(g->starts, g->start_count, g->start_capacity, 1))
        return pbrt_blame(p, place, error_no_memory());
    g->starts[g->start_count++] = (uint32_t)g->point_count;
    for (size_t i = 0; i < c->count; i++) {
        g->points[g->point_count] = vec3_from(pbrt_point(&to_world, dvec3_from(c->points[i])));
        g->radii[g->point_count++] = (float)(scale * radius_at(c, i));
    }
    return SNELL_OK;
}

/* One that moves is a shape of its own. */
static snell_status add_alone(pbrt *p, const pbrt_drawn *s, const strand *c) {
    static uint32_t none[1] = {0};
    pbrt_strands g = {.points = c->points, .point_count = c->count, .basis = c->basis};
    g.kind = c->kind, g.starts = none, g.start_count = 1;
    g.radii = memory_resize(NULL, c->count, sizeof *g.radii);
    if (g.radii == NULL) return pbrt_blame(p, s->params->place, error_no_memory());
    for (size_t i = 0; i < c->count; i++) g.radii[i] = (float)radius_at(c, i);
    snell_param params[5];
    dtransform local = dtransform_identity();
    list_params(&g, params);
    pbrt_add_shape(p, s, "curves", params, 5, 0, &local);
    free(g.radii);
    return p->status;
}

/* ---- control points ---- */

/* Of degree two as of degree three: exact. */
static void raise_degree(const double *from, bool spline, size_t segments, vec3 *out) {
    for (size_t i = 0; i < segments; i++) {
        dvec3 c[3];
        const double *at = from + 3 * (spline ? i : 2 * i);
        for (int k = 0; k < 3; k++) c[k] = (dvec3){at[3 * k], at[3 * k + 1], at[3 * k + 2]};
        if (spline) { /* a uniform quadratic B-spline begins and ends between its points */
            c[0] = dvec3_scale(dvec3_add(c[0], c[1]), 0.5);
            c[2] = dvec3_scale(dvec3_add(c[1], c[2]), 0.5);
        }
        vec3 *to = out + 3 * i;
        to[0] = vec3_from(c[0]);
        to[1] = vec3_from(dvec3_add(dvec3_scale(c[0], 1.0 / 3), dvec3_scale(c[1], 2.0 / 3)));
        to[2] = vec3_from(dvec3_add(dvec3_scale(c[1], 2.0 / 3), dvec3_scale(c[2], 1.0 / 3)));
        to[3] = vec3_from(c[2]);
    }
}

static snell_status make_points(pbrt *p, const pbrt_drawn *s, const double *from, size_t count,
                                size_t degree, bool spline, strand *out) {
    size_t segments = spline ? count - degree : (count - 1) / degree;
    bool raised = degree == 2, stays_spline = spline && !raised;
    out->count = raised ? 3 * segments + 1 : count;
    out->basis = stays_spline ? "bspline" : "bezier";
    out->step = 1 / (double)(stays_spline ? segments : 3 * segments);
    out->first = stays_spline ? -out->step : 0;
    if (pbrt_spend(p, s->params->place, (uint64_t)out->count * 48)) return p->status;
    out->points = memory_resize(NULL, out->count, sizeof *out->points);
    if (out->points == NULL) return pbrt_blame(p, s->params->place, error_no_memory());
    if (raised) raise_degree(from, spline, segments, out->points);
    for (size_t i = 0; !raised && i < count; i++)
        out->points[i] = (vec3){(float)from[3 * i], (float)from[3 * i + 1], (float)from[3 * i + 2]};
    return SNELL_OK;
}

static snell_status check_points(pbrt *p, const pbrt_drawn *s, const char *basis, int degree,
                                 size_t count) {
    bool spline = strcmp(basis, "bspline") == 0;
    if ((degree != 2 && degree != 3) || (!spline && strcmp(basis, "bezier") != 0))
        return pbrt_fail(p, s->params->place, "the basis is bezier or bspline, the degree 2 or 3",
                         "a curve of basis '%.40s' and degree %d", basis, degree);
    size_t d = (size_t)degree;
    if (count < d + 1 || (!spline && (count - 1) % d))
        return pbrt_fail(p, s->params->place, NULL, "%zu points are no '%s' curve of degree %d: %s",
                         count, basis, degree,
                         spline ? "at least one more than the degree"
                                : "the first, and as many more as its degree for each piece");
    return SNELL_OK;
}

snell_status pbrt_curve(pbrt *p, const pbrt_drawn *s) {
    size_t count, normals;
    const double *points = pbrt_numbers(p, s->params, "P", 3, &count);
    int degree = pbrt_int(p, s->params, "degree", 3);
    const char *basis = pbrt_string(p, s->params, "basis", "bezier"),
               *type = pbrt_string(p, s->params, "type", "flat");
    double width = pbrt_float(p, s->params, "width", 1);
    strand c = {.width0 = pbrt_float(p, s->params, "width0", width),
                .width1 = pbrt_float(p, s->params, "width1", width)};
    pbrt_numbers(p, s->params, "N", 3, &normals);
    pbrt_ignore(s->params, "splitdepth");
    if (p->status || check_points(p, s, basis, degree, count)) return p->status;
    if (strcmp(type, "ribbon") == 0)
        pbrt_warn(p, s->params->place,
                  "ribbons that turn by normals are not supported: they face each sight");
    c.kind = strcmp(type, "cylinder") == 0 ? "round" : "ribbon";
    uint32_t material;
    if (make_points(p, s, points, count, (size_t)degree, strcmp(basis, "bspline") == 0, &c) ||
        pbrt_is_animated(p) || pbrt_material_of(p, s, 0, &material)) {
        if (!p->status) add_alone(p, s, &c);
    } else {
        gather(p, s, &c, material);
    }
    free(c.points);
    return p->status;
}
