/* A blend of two materials: (1 - weight) a + weight b, their alpha and emission included. */
#include "materials/material.h"

#define MIX_FIELDS(F, T)                                                                           \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, a, MATERIAL, NO_DEFAULT, REQUIRED, "", "one material; neither may be made of others")     \
    F(T, b, MATERIAL, NO_DEFAULT, REQUIRED, "", "the other; neither may bound a medium")           \
    F(T, weight, SCALAR, DEFAULT(0.5f), RANGE(0, 1), "", "how much of it is b")
DESCRIBE(mix, MIX_FIELDS)

static double weight_of(const mix_desc *m, const material_point *point) {
    return clamp01(input_scalar(&m->weight, point->textures, &point->at));
}

static void add_part(const material *part, const material_point *point, double share, bsdf *out) {
    bsdf own = {.ambient = dvec3_from(((const material_common *)part->desc)->ambient)};
    own.ior1 = own.ior2 = 1;
    part->type->fill(part->desc, point, &own);
    for (int i = 0; i < own.lobe_count; i++) {
        lobe l = own.lobes[i];
        l.weight = dvec3_scale(l.weight, share);
        l.reflected = dvec3_scale(l.reflected, share);
        l.share *= share; /* of negative ones the sign is what counts */
        l.coats <<= out->coat_count;
        if (share > 0) out->lobes[out->lobe_count++] = l;
    }
    for (int i = 0; i < own.coat_count; i++) out->coats[out->coat_count++] = own.coats[i];
    out->ambient = dvec3_add(out->ambient, dvec3_scale(own.ambient, share));
}

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const mix_desc *m = desc;
    double weight = weight_of(m, point);
    dvec3 ambient = out->ambient;
    out->ambient = (dvec3){0, 0, 0};
    add_part(&point->materials[m->a.index1 - 1], point, 1 - weight, out);
    add_part(&point->materials[m->b.index1 - 1], point, weight, out);
    out->ambient = dvec3_mul(out->ambient, ambient);
}

static double opacity(const void *desc, const material_point *point) {
    const mix_desc *m = desc;
    double weight = weight_of(m, point);
    material_point own = *point;
    own.alpha = 1; /* the vertices' counts once, for the whole */
    return (1 - weight) * material_alpha(&point->materials[m->a.index1 - 1], &own) +
           weight * material_alpha(&point->materials[m->b.index1 - 1], &own);
}

static dvec3 emission(const void *desc, const material_point *point) {
    const mix_desc *m = desc;
    double weight = weight_of(m, point);
    dvec3 a = material_emission(&point->materials[m->a.index1 - 1], point),
          b = material_emission(&point->materials[m->b.index1 - 1], point);
    return dvec3_add(dvec3_scale(a, 1 - weight), dvec3_scale(b, weight));
}

static bool shines(const void *desc, const material *materials) {
    const mix_desc *m = desc;
    if (materials == NULL) return false;
    const material *a = &materials[m->a.index1 - 1], *b = &materials[m->b.index1 - 1];
    return material_emits(a->type, a->desc) || material_emits(b->type, b->desc);
}

const material_type material_mix = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, mix, "mix", "a blend of two materials"),
    .fill = fill,
    .emission = emission,
    .shines = shines,
    .opacity = opacity,
    .may_gain = true, /* if one of them may */
};
