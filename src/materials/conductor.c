/* Metal: GGX with Fresnel's formulas for a complex index, and what the facets scatter more than
 * once (microfacet.h); a mirror where it is smooth. */
#include "materials/microfacet.h"
#include "materials/material.h"

#include "base/error.h"

/* eta and k at 650, 550 and 450 nm, from the tables at refractiveindex.info (CC0), interpolated
 * linearly: Johnson and Christy 1972 (silver, gold, copper) and 1974 (chromium, iron, nickel,
 * titanium, cobalt, palladium, vanadium), Rakic 1995 (aluminium), Rakic et al. 1998, Lorentz-Drude
 * fit (platinum, tungsten), Inagaki et al. 1981 (mercury). */
#define METALS(M)                                                                                  \
    M(aluminium, 1.558, 1.015, 0.633, 7.712, 6.627, 5.454)                                         \
    M(chromium, 3.107, 3.181, 2.323, 3.331, 3.329, 3.135)                                          \
    M(cobalt, 2.237, 2.052, 1.736, 4.236, 3.824, 3.274)                                            \
    M(copper, 0.238, 1.007, 1.240, 3.626, 2.582, 2.393)                                            \
    M(gold, 0.156, 0.424, 1.383, 3.602, 2.472, 1.915)                                              \
    M(iron, 2.911, 2.950, 2.584, 3.089, 2.932, 2.767)                                              \
    M(mercury, 2.073, 1.552, 1.061, 5.338, 4.651, 3.863)                                           \
    M(nickel, 1.990, 1.921, 1.729, 4.209, 3.616, 2.944)                                            \
    M(palladium, 1.789, 1.641, 1.408, 4.375, 3.845, 3.254)                                         \
    M(platinum, 2.370, 2.091, 1.851, 4.254, 3.704, 3.140)                                          \
    M(silver, 0.052, 0.060, 0.040, 4.409, 3.597, 2.648)                                            \
    M(titanium, 2.741, 2.542, 2.267, 3.814, 3.435, 3.038)                                          \
    M(tungsten, 3.717, 3.456, 3.370, 2.884, 2.757, 2.526)                                          \
    M(vanadium, 3.312, 3.995, 3.587, 3.075, 3.039, 3.462)

static const fresnel metals[] = {
#define METAL(name, er, eg, eb, kr, kg, kb) {FRESNEL_CONDUCTOR, {er, eg, eb}, {kr, kg, kb}},
    METALS(METAL)
#undef METAL
};

#define METAL_WORDS                                                                                \
    "aluminium|chromium|cobalt|copper|gold|iron|mercury|nickel|palladium|platinum|silver|"         \
    "titanium|tungsten|vanadium"

#define CONDUCTOR_FIELDS(F, T)                                                                     \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, metal, CHOICE, DEFAULT(0), CHOICES(METAL_WORDS), "", "whose measured eta and k it has")   \
    F(T, eta, COLOR, DEFAULT(0, 0, 0), RANGE(0, 100), "",                                          \
      "index of refraction for red, green, blue; 0: that of the metal")                            \
    F(T, k, COLOR, DEFAULT(0, 0, 0), RANGE(0, 100), "",                                            \
      "extinction coefficient, where eta is given")                                                \
    F(T, color, INPUT, DEFAULT(1, 1, 1), NOT_NEGATIVE, "", "multiplies what it reflects")          \
    F(T, roughness, SCALAR, DEFAULT(0), RANGE(0, 1), "",                                           \
      "0 is a mirror; alpha of GGX is its square")
DESCRIBE(conductor, CONDUCTOR_FIELDS)

static snell_status check(const void *desc) {
    const conductor_desc *m = desc;
    bool any = m->eta.x > 0 || m->eta.y > 0 || m->eta.z > 0;
    if (any ? m->eta.x > 0 && m->eta.y > 0 && m->eta.z > 0
            : !(m->k.x > 0 || m->k.y > 0 || m->k.z > 0))
        return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "give both for red, green and blue, or name a metal",
                     "conductor: 'k' needs an 'eta' above 0 in every colour");
}

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const conductor_desc *m = desc;
    fresnel f = m->eta.x > 0 ? (fresnel){FRESNEL_CONDUCTOR, dvec3_from(m->eta), dvec3_from(m->k)}
                             : metals[m->metal];
    dvec3 color = dvec3_mul(input_color(&m->color, point->textures, &point->at), point->tint);
    double roughness = clamp01(input_scalar(&m->roughness, point->textures, &point->at));
    out->ambient = (dvec3){0, 0, 0}; /* it shows what it reflects, nothing else */
    bsdf_add_ggx(out, color, roughness, f, 0);
    bsdf_add_multiple(out, color, roughness, fresnel_evaluate(&f, 1));
}

const material_type material_conductor = {
    .info = TYPE_INFO_EITHER(CATEGORY_MATERIAL, conductor, "conductor", "metal, smooth or rough",
                             "metal|eta k"),
    .check = check,
    .fill = fill,
};
