/* The material model of glTF 2.0: metallic-roughness (specification, appendix B) with
 * KHR_materials_ior, _specular, _transmission, _volume, _dispersion, _clearcoat, _sheen, _anisotropy,
 * _iridescence and, as `emission`, _emissive_strength.
 *
 *     dielectric = F GGX + (1 - F) (mix(diffuse, refracted, transmission))
 *     metal      = F_base GGX
 *     surface    = clearcoat over sheen over mix(dielectric, metal, metallic)
 *
 * Both parts' GGX is one lobe, Schlick's F from mix(f0, base_color) to mix(specular, 1). Where the
 * appendix weighs the layers below by 1 - F(v.h), at grazing angles twice what arrives may leave;
 * here they get what the layer above leaves by its albedo (microfacet.h, lobe_under; coats of
 * bsdf.h), as the appendix allows. The clearcoat reflects and leaves light by a normal of its own. A
 * metal has what its facets scatter more than once. What transmits has Fresnel's formulas instead of
 * Schlick's fit, and neither specular factors nor grain nor a film. Below facets with a grain lies
 * what those of the smaller roughness leave, and below a film what Schlick's fit that is nowhere less
 * than its reflectance leaves: a little is lost, nothing gained. */
#include "materials/microfacet.h"
#include "materials/material.h"
#include "maths/functions.h"

#define PRINCIPLED_FIELDS(F, T)                                                                    \
    MATERIAL_FIELDS(F, T)                                                                          \
    F(T, base_color, INPUT, DEFAULT(0.8f, 0.8f, 0.8f), NOT_NEGATIVE, "",                           \
      "of the diffuse part, of a metal, of what passes")                                           \
    F(T, metallic, SCALAR, DEFAULT(0), RANGE(0, 1), "", "0 is a dielectric, 1 a metal")            \
    F(T, roughness, SCALAR, DEFAULT(0.5f), RANGE(0, 1), "",                                        \
      "0 is a mirror; alpha of GGX is its square")                                                 \
    F(T, ior, FLOAT, DEFAULT(1.5f), RANGE(1, 10), "", "index of refraction of the dielectric")     \
    F(T, specular, SCALAR, DEFAULT(1), RANGE(0, 1), "", "strength of the dielectric's reflection") \
    F(T, specular_color, INPUT, DEFAULT(1, 1, 1), NOT_NEGATIVE, "",                                \
      "multiplies the dielectric's reflection at normal incidence")                                \
    F(T, transmission, SCALAR, DEFAULT(0), RANGE(0, 1), "",                                        \
      "how much of what enters the dielectric passes")                                             \
    F(T, thickness, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                                          \
      "0: thin walls that light crosses straight; above: a closed shape is full of it")            \
    F(T, attenuation_color, COLOR, DEFAULT(1, 1, 1), RANGE(1e-6, 1), "",                           \
      "what is left of white light after attenuation_distance")                                    \
    F(T, attenuation_distance, FLOAT, DEFAULT(0), NOT_NEGATIVE, "m",                               \
      "0: attenuation_color is not used")                                                          \
    F(T, priority, INT, DEFAULT(0), RANGE(-1000, 1000), "",                                        \
      "where solids overlap the higher one is present")                                            \
    F(T, clearcoat, SCALAR, DEFAULT(0), RANGE(0, 1), "", "strength of a coat of varnish")          \
    F(T, clearcoat_roughness, SCALAR, DEFAULT(0), RANGE(0, 1), "", "of the coat")                  \
    F(T, clearcoat_normal_map, TEXTURE, NO_DEFAULT, ANY, "",                                       \
      "as normal_map, of the coat; without it the coat is smooth: normal_map and bump are "        \
      "beneath")                                                                                   \
    F(T, clearcoat_normal_scale, SCALAR, DEFAULT(1), ANY, "",                                      \
      "multiplies the slope of clearcoat_normal_map")                                              \
    F(T, sheen_color, INPUT, DEFAULT(0, 0, 0), NOT_NEGATIVE, "", "of velvet's fibres; 0: none")    \
    F(T, sheen_roughness, SCALAR, DEFAULT(0), RANGE(0, 1), "",                                     \
      "of the fibres; below 0.26 it counts as that")                                               \
    F(T, anisotropy, SCALAR, DEFAULT(0), RANGE(0, 1), "",                                          \
      "how much rougher it is along its grain: 1 is brushed metal")                                \
    F(T, anisotropy_rotation, FLOAT, DEFAULT(0), ANY, "rad",                                       \
      "of the grain, counter-clockwise from where u grows")                                        \
    F(T, anisotropy_map, TEXTURE, NO_DEFAULT, ANY, "",                                             \
      "the grain's direction as a colour, linear: red along u, green along v, as in a normal map") \
    F(T, iridescence, SCALAR, DEFAULT(0), RANGE(0, 1), "", "strength of a thin film's colours")    \
    F(T, iridescence_ior, FLOAT, DEFAULT(1.3f), RANGE(1, 10), "", "of the film")                   \
    F(T, iridescence_thickness, SCALAR, DEFAULT(400), NOT_NEGATIVE, "nm", "of the film")           \
    F(T, dispersion, FLOAT, DEFAULT(0), RANGE(0, 100), "",                                         \
      "20 / Abbe number of what transmits with a thickness: how far colours part")
DESCRIBE(principled, PRINCIPLED_FIELDS)

static const double COAT_F0 = 0.04; /* an ior of 1.5 */

static bool has_volume(const principled_desc *m) {
    return m->transmission.value.x > 0 && m->thickness > 0;
}

/* The inputs at a point. */
typedef struct look {
    dvec3 base, f0, metal_f0; /* f0: of the dielectric */
    double f90, metallic, roughness, transmission;
    double grain, film, film_ior, film_thickness; /* film: how much of it there is */
} look;

static double scalar(const snell_input *input, const material_point *point) {
    return clamp01(input_scalar(input, point->textures, &point->at));
}

static dvec3 mix(dvec3 a, dvec3 b, double part) {
    return dvec3_add(dvec3_scale(a, 1 - part), dvec3_scale(b, part));
}

static dvec3 clamp_color(dvec3 c) { return (dvec3){clamp01(c.x), clamp01(c.y), clamp01(c.z)}; }

static look look_at(const principled_desc *m, const material_point *point) {
    look k = {.metallic = scalar(&m->metallic, point),
              .roughness = scalar(&m->roughness, point),
              .f90 = scalar(&m->specular, point)};
    k.base = dvec3_mul(input_color(&m->base_color, point->textures, &point->at), point->tint);
    k.metal_f0 = clamp_color(k.base);
    k.transmission = scalar(&m->transmission, point);
    dvec3 tint = input_color(&m->specular_color, point->textures, &point->at);
    k.f0 = dvec3_scale(clamp_color(dvec3_scale(tint, fresnel_f0((double)m->ior))), k.f90);
    k.grain = scalar(&m->anisotropy, point);
    k.film = scalar(&m->iridescence, point);
    k.film_ior = (double)m->iridescence_ior;
    if (k.film > 0)
        k.film_thickness =
            double_max(0, input_scalar(&m->iridescence_thickness, point->textures, &point->at));
    return k;
}

/* The grain's direction, turned by the map and by the material's own angle. */
static dvec3 grain_direction(const principled_desc *m, const material_point *point) {
    double x = 1, y = 0;
    if (m->anisotropy_map.index1) {
        dvec3 c = texture_look_up(m->anisotropy_map, point->textures, &point->at).color;
        x = 2 * c.x - 1, y = 2 * c.y - 1;
    }
    double c = fn_cos((double)m->anisotropy_rotation), s = fn_sin((double)m->anisotropy_rotation);
    return dvec3_add(dvec3_scale(point->tangent, c * x - s * y),
                     dvec3_scale(point->bitangent, s * x + c * y));
}

static fresnel schlick(dvec3 f0, double f90) {
    return (fresnel){FRESNEL_SCHLICK, f0, {f90, f90, f90}};
}

/* Varnish and velvet; their lobes, and what they leave to those below. */
static void add_coats(const principled_desc *m, const material_point *point, bsdf *out) {
    double clearcoat = scalar(&m->clearcoat, point);
    if (clearcoat > 0) {
        double roughness = scalar(&m->clearcoat_roughness, point), gloss = 1 - roughness;
        lobe *l = bsdf_add_ggx(out, (dvec3){clearcoat, clearcoat, clearcoat}, roughness,
                               schlick((dvec3){COAT_F0, COAT_F0, COAT_F0}, 1), gloss * gloss);
        l->tilted = point->coat.own;
        out->coats[out->coat_count++] = (coating){false, clearcoat, roughness * roughness, COAT_F0};
    }
    dvec3 sheen = clamp_color(input_color(&m->sheen_color, point->textures, &point->at));
    double roughness = scalar(&m->sheen_roughness, point);
    double alpha = double_max(roughness * roughness, SHEEN_ALPHA_MIN);
    lobe *l = bsdf_add(out, &lobe_sheen, sheen, alpha);
    if (l == NULL) return;
    l->coats = clearcoat > 0;
    l->share = dvec3_largest(sheen) * 0.3; /* about its mean albedo */
    out->coats[out->coat_count++] = (coating){true, dvec3_largest(sheen), alpha, 0};
}

static void add_facets(const look *k, double weight, fresnel f, bsdf *out) {
    double gloss = 1 - k->roughness;
    dvec3 all = {weight, weight, weight};
    if (k->grain > 0)
        bsdf_add_grained(out, all, k->roughness, k->grain, f, gloss * gloss);
    else
        bsdf_add_ggx(out, all, k->roughness, f, gloss * gloss);
}

static fresnel film_on(const look *k, dvec3 f0) {
    return (fresnel){FRESNEL_FILM, f0, {k->film_ior, k->film_thickness, 0}};
}

static void add_base(const look *k, bsdf *out) {
    double f0 = dvec3_largest(k->f0), f90 = k->f90;
    if (k->film > 0) {
        double bound = fresnel_film_bound(k->film_ior, k->film_thickness, k->f0);
        f0 += (bound - f0) * k->film;
        f90 += (1 - f90) * k->film;
    }
    dvec3 diffuse = dvec3_scale(k->base, (1 - k->metallic) * (1 - k->transmission));
    bsdf_add_under(out, diffuse, k->roughness, f0, f90);
    add_facets(
        k, 1 - k->film,
        schlick(mix(k->f0, k->metal_f0, k->metallic), k->f90 * (1 - k->metallic) + k->metallic),
        out);
    add_facets(k, k->film * (1 - k->metallic), film_on(k, k->f0), out);
    add_facets(k, k->film * k->metallic, film_on(k, k->metal_f0), out);
}

/* The interface reflects for the whole surface; a metal adds what it reflects beyond that. */
static void add_transmitting(const principled_desc *m, const look *k, double passing, bool outside,
                             bsdf *out) {
    double f0 = fresnel_f0((double)m->ior), gloss = 1 - k->roughness;
    dvec3 passed = dvec3_scale(k->metal_f0, passing);
    if (m->thickness > 0)
        bsdf_add_interface(out, passed, k->roughness);
    else
        bsdf_add_thin(out, passed, k->roughness, (double)m->ior);
    if (!outside && m->thickness > 0) return; /* inside there is nothing but the boundary */
    dvec3 diffuse = dvec3_scale(k->base, (1 - k->metallic) * (1 - k->transmission));
    bsdf_add_under(out, diffuse, k->roughness, f0, 1);
    dvec3 more = clamp_color(dvec3_sub(k->metal_f0, (dvec3){f0, f0, f0}));
    if (k->metallic > 0)
        bsdf_add_ggx(out, (dvec3){k->metallic, k->metallic, k->metallic}, k->roughness,
                     schlick(more, 0), gloss * gloss);
}

static void fill(const void *desc, const material_point *point, bsdf *out) {
    const principled_desc *m = desc;
    look k = look_at(m, point);
    double passing = k.transmission * (1 - k.metallic);
    if (k.grain > 0) out->tangent = grain_direction(m, point);
    if (has_volume(m)) *(point->outside ? &out->ior2 : &out->ior1) = (double)m->ior;
    out->ambient = dvec3_scale(out->ambient, (1 - k.metallic) * (1 - k.transmission));
    if (point->outside || !has_volume(m)) add_coats(m, point, out);
    int first = out->lobe_count;
    if (passing > 0)
        add_transmitting(m, &k, passing, point->outside, out);
    else
        add_base(&k, out);
    if (point->outside || !has_volume(m)) {
        dvec3 metal = {k.metallic, k.metallic, k.metallic};
        bsdf_add_multiple(out, metal, k.roughness, k.metal_f0);
    }
    for (int i = first; i < out->lobe_count; i++) out->lobes[i].coats = (1u << out->coat_count) - 1;
}

static medium inside(const void *desc) {
    const principled_desc *m = desc;
    return medium_make(
        (double)m->ior, (double)m->dispersion,
        medium_attenuation(dvec3_from(m->attenuation_color), (double)m->attenuation_distance),
        m->priority);
}

static bool bounds(const void *desc) { return has_volume(desc); }
static bool is_thin(const void *desc) {
    const principled_desc *m = desc;
    return m->transmission.value.x > 0 && !(m->thickness > 0);
}

static bool is_grained(const void *desc) {
    return ((const principled_desc *)desc)->anisotropy.value.x > 0;
}

static bool coat(const void *desc, normal_detail *out) {
    const principled_desc *m = desc;
    *out = (normal_detail){m->clearcoat_normal_map, m->clearcoat_normal_scale};
    return m->clearcoat.value.x > 0;
}

const material_type material_principled = {
    .info = TYPE_INFO(CATEGORY_MATERIAL, principled, "principled",
                      "the glTF 2.0 model: metal, plastic, glass, varnish, velvet"),
    .fill = fill,
    .inside = inside,
    .bounds = bounds,
    .is_thin = is_thin,
    .is_grained = is_grained,
    .coat = coat,
};
