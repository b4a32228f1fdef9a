#include "materials/bsdf.h"

#include <assert.h>

#include "maths/functions.h"

void bsdf_add(bsdf *b, const lobe_type *type, dvec3 weight, double parameter) {
    /* A lobe that does nothing costs time; but what lets nothing pass still reflects. */
    if (!(dvec3_largest(weight) > 0) && type->class != LOBE_INTERFACE) return;
    assert(b->lobe_count < LOBES_MAX);
    b->lobes[b->lobe_count++] = (lobe){type, weight, {parameter}};
}

dvec3 bsdf_evaluate(const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi) {
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *l = &b->lobes[i];
        if (l->type->evaluate) sum = dvec3_add(sum, l->type->evaluate(l, n, wo, wi));
    }
    return sum;
}

bool bsdf_is_lit(const bsdf *b) {
    for (int i = 0; i < b->lobe_count; i++)
        if (b->lobes[i].type->evaluate) return true;
    return false;
}

dvec3 bsdf_passing(const bsdf *b) {
    for (int i = 0; i < b->lobe_count; i++)
        if (b->lobes[i].type->class == LOBE_INTERFACE) return b->lobes[i].weight;
    return (dvec3){1, 1, 1};
}

static dvec3 evaluate_lambert(const lobe *l, dvec3 n, dvec3 wo, dvec3 wi) {
    (void)n, (void)wo, (void)wi;
    return dvec3_scale(l->weight, 1 / PI);
}

static dvec3 evaluate_blinn_phong(const lobe *l, dvec3 n, dvec3 wo, dvec3 wi) {
    dvec3 h = dvec3_normalize(dvec3_add(wo, wi)); /* h = bisector(v, l) */
    double cosine = dvec3_dot(n, h);
    return cosine > 0 ? dvec3_scale(l->weight, fn_pow(cosine, l->exponent)) : (dvec3){0, 0, 0};
}

const lobe_type lobe_lambert = {LOBE_DIFFUSE, evaluate_lambert};
const lobe_type lobe_blinn_phong = {LOBE_DIFFUSE, evaluate_blinn_phong};
const lobe_type lobe_mirror = {LOBE_MIRROR, NULL};
const lobe_type lobe_interface = {LOBE_INTERFACE, NULL};

dvec3 reflect_direction(dvec3 wo, dvec3 n) {
    return dvec3_sub(dvec3_scale(n, 2 * dvec3_dot(n, wo)), wo);
}

bool refract_direction(dvec3 wo, dvec3 n, double eta, dvec3 *wi) {
    double cos1 = dvec3_dot(n, wo), k = 1 - eta * eta * (1 - cos1 * cos1);
    if (!(k > 0)) return false;
    *wi = dvec3_sub(dvec3_scale(n, eta * cos1 - sqrt(k)), dvec3_scale(wo, eta));
    return true;
}

double fresnel_dielectric(double cos1, double ior1, double ior2) {
    double eta = ior1 / ior2, k = 1 - eta * eta * (1 - cos1 * cos1);
    if (!(k > 0)) return 1;
    double cos2 = sqrt(k);
    double s = (ior1 * cos1 - ior2 * cos2) / (ior1 * cos1 + ior2 * cos2);
    double p = (ior2 * cos1 - ior1 * cos2) / (ior2 * cos1 + ior1 * cos2);
    return (s * s + p * p) / 2;
}
