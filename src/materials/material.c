#include "materials/material.h"

#include "maths/functions.h"

#define MATERIAL(name) extern const material_type material_##name;
#include "materials/materials.def"
#undef MATERIAL
const material_type *const material_types[] = {
#define MATERIAL(name) &material_##name,
#include "materials/materials.def"
#undef MATERIAL
};
const uint32_t material_type_count = sizeof material_types / sizeof material_types[0];

dvec3 medium_attenuation(dvec3 color, double distance) {
    if (!(distance > 0)) return (dvec3){0, 0, 0};
    double scale = -1 / distance;
    return (dvec3){fn_log(color.x) * scale, fn_log(color.y) * scale, fn_log(color.z) * scale};
}

/* KHR_materials_dispersion: the first two terms of Cauchy's equation, n = A + B / wavelength^2, with A
 * and B from the index at Fraunhofer's d line and the Abbe number, 523655 nm^2 / wavelength^2 being 1
 * apart between his F and C lines. Not below 1. */
static double ior_at(double ior, double dispersion, double wavelength_nm) {
    double part = 523655 / (wavelength_nm * wavelength_nm) - 1.5168;
    return double_max(ior + (ior - 1) * dispersion / 20 * part, 1);
}

medium medium_make(double ior, double dispersion, dvec3 absorption, int32_t priority) {
    /* The dominant wavelengths of Rec. 709's primaries under D65. */
    static const double wavelengths_nm[] = {611.4, 549.1, 464.2};
    medium m = {ior, absorption, priority, {ior, ior, ior}};
    for (int i = 0; i < 3 && dispersion > 0; i++)
        m.ior_by_color[i] = ior_at(ior, dispersion, wavelengths_nm[i]);
    return m;
}

double material_alpha(const material *m, const material_point *point) {
    const material_common *common = m->desc;
    double alpha = input_scalar(&common->alpha, point->textures, &point->at) * point->alpha;
    if (m->type->opacity) alpha *= m->type->opacity(m->desc, point);
    if (common->alpha_cutoff > 0) return alpha < (double)common->alpha_cutoff ? 0 : 1;
    return clamp01(alpha);
}

dvec3 material_emission(const material *m, const material_point *point) {
    const material_common *common = m->desc;
    if (!point->outside && !common->emit_two_sided) return (dvec3){0, 0, 0};
    dvec3 sum = input_color(&common->emission, point->textures, &point->at);
    if (m->type->emission) sum = dvec3_add(sum, m->type->emission(m->desc, point));
    return sum;
}

void material_evaluate(const material *m, const material_point *point, bsdf *out) {
    const material_common *common = m->desc;
    out->lobe_count = out->coat_count = 0;
    out->ior1 = out->ior2 = 1;
    out->disperses = false;
    out->coat.own = point->coat.own;
    if (out->coat.own) out->coat = point->coat;
    out->alpha = m->opaque_alpha && point->alpha == 1 ? 1 : material_alpha(m, point);
    out->ambient = dvec3_from(common->ambient);
    out->emission = m->shines ? material_emission(m, point) : (dvec3){0, 0, 0};
    m->type->fill(m->desc, point, out);
}

double material_albedo(const material *m, const texture *textures, const material *materials,
                       double cosine) {
    enum { SAMPLES = 1024 };
    const dvec3 n = {0, 0, 1}, wo = {sqrt(1 - cosine * cosine), 0, cosine};
    const material_point point = {.at = {.has_uv = true, .n = n},
                                  .tint = {1, 1, 1},
                                  .alpha = 1,
                                  .outside = true,
                                  .textures = textures,
                                  .materials = materials};
    bsdf b;
    material_evaluate(m, &point, &b);
    dvec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        bsdf_direction drawn;
        if (bsdf_sample(&b, n, wo, sample_point(1, i).x, sample_point(2, i), &drawn))
            sum = dvec3_add(sum, drawn.weight);
    }
    return dvec3_largest(sum) / SAMPLES;
}
