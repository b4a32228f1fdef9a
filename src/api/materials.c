/* A material by itself: the BRDF view. */
#include "api/api.h"

/* The material's lobes where it is seen from wo; n is on wo's side. */
typedef struct view {
    bsdf b;
    dvec3 n, wo;
} view;

static snell_status bad(const char *what) {
    return error_set(SNELL_ERR_ARGUMENT, "a direction is finite and not zero", "%s", what);
}

static bool is_direction(snell_vec3 v) {
    double length = dvec3_length(dvec3_from(v));
    return length > 0 && isfinite(length);
}

/* Checks what the caller gave and looks at the material; on SNELL_OK the scene is being read. */
static snell_status begin_view(const snell_scene *s, snell_material_id id, const snell_vec2 *uv,
                               snell_vec3 wo, const void *in, const void *out, size_t count,
                               view *v) {
    if (count > 0 && (in == NULL || out == NULL))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an array is NULL");
    if (!is_direction(wo)) return bad("wo is no direction");
    if (uv && !(isfinite(uv->x) && isfinite(uv->y)))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "uv is not finite");
    snell_status status = scene_begin_read(s);
    if (status) return status;
    const scene *frozen = s->frozen;
    if (id.index1 < 1 || id.index1 > frozen->material_count || id.generation != 0) {
        scene_end_read(s);
        return error_set(SNELL_ERR_ARGUMENT, "add it before the commit",
                         "there is no such material");
    }
    material_point point = {.tint = {1, 1, 1},
                            .alpha = 1,
                            .outside = !(wo.z < 0),
                            .textures = frozen->textures,
                            .materials = frozen->materials};
    point.at.has_uv = true;
    point.at.n = (dvec3){0, 0, 1};
    if (uv) point.at.u = (double)uv->x, point.at.v = (double)uv->y;
    unsigned saved = floatenv_enter();
    material_evaluate(&frozen->materials[id.index1 - 1], &point, &v->b);
    v->wo = dvec3_normalize(dvec3_from(wo));
    floatenv_leave(saved);
    v->n = (dvec3){0, 0, point.outside ? 1 : -1};
    return SNELL_OK;
}

static bool all_directions(const snell_vec3 *wi, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!is_direction(wi[i])) return false;
    return true;
}

snell_status snell_material_eval(const snell_scene *s, snell_material_id id, const snell_vec2 *uv,
                                 snell_vec3 wo, const snell_vec3 *wi, snell_vec3 *f, size_t count) {
    view v;
    snell_status status = begin_view(s, id, uv, wo, wi, f, count, &v);
    if (status) return status;
    unsigned saved = floatenv_enter();
    bool good = all_directions(wi, count);
    for (size_t i = 0; i < count && good; i++)
        f[i] = vec3_from(
            bsdf_evaluate(&v.b, LOBES_LIT, v.n, v.wo, dvec3_normalize(dvec3_from(wi[i]))));
    floatenv_leave(saved);
    scene_end_read(s);
    return good ? SNELL_OK : bad("wi is no direction");
}

snell_status snell_material_pdf(const snell_scene *s, snell_material_id id, const snell_vec2 *uv,
                                snell_vec3 wo, const snell_vec3 *wi, float *pdf, size_t count) {
    view v;
    snell_status status = begin_view(s, id, uv, wo, wi, pdf, count, &v);
    if (status) return status;
    unsigned saved = floatenv_enter();
    bool good = all_directions(wi, count);
    for (size_t i = 0; i < count && good; i++)
        pdf[i] = v.b.lobe_count
                     ? (float)bsdf_pdf(&v.b, v.n, v.wo, dvec3_normalize(dvec3_from(wi[i])))
                     : 0;
    floatenv_leave(saved);
    scene_end_read(s);
    return good ? SNELL_OK : bad("wi is no direction");
}

static bool in_unit_cube(snell_vec3 u) {
    return u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1 && u.z >= 0 && u.z < 1;
}

snell_status snell_material_sample(const snell_scene *s, snell_material_id id, const snell_vec2 *uv,
                                   snell_vec3 wo, const snell_vec3 *u, snell_scattering *out,
                                   size_t count) {
    view v;
    snell_status status = begin_view(s, id, uv, wo, u, out, count, &v);
    if (status) return status;
    unsigned saved = floatenv_enter();
    bool good = true;
    for (size_t i = 0; i < count && good; i++) good = in_unit_cube(u[i]);
    for (size_t i = 0; i < count && good; i++) {
        bsdf_direction d;
        sample2 u2 = {(double)u[i].y, (double)u[i].z};
        bool found = bsdf_sample(&v.b, v.n, v.wo, (double)u[i].x, u2, &d);
        out[i] = (snell_scattering){.found = found};
        if (!found) continue;
        out[i] = (snell_scattering){vec3_from(d.wi), vec3_from(d.weight), (float)d.pdf, true,
                                    d.transmitted};
    }
    floatenv_leave(saved);
    scene_end_read(s);
    if (good) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, NULL, "a random number is outside [0, 1)");
}
