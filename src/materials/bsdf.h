/* What a surface does to light at one point: a short list of lobes that a material fills in once
 * per hit.
 *
 * wo and wi are unit vectors that point away from the surface: wo to where the ray came from, wi to
 * where light comes from. Normals here are on wo's side. */
#ifndef SNELL_MATERIALS_BSDF_H
#define SNELL_MATERIALS_BSDF_H

#include "maths/vec.h"

typedef enum lobe_class {
    LOBE_DIFFUSE,  /* Lambert and the Phong family: lit by sampling lights, except in path */
    LOBE_MIRROR,   /* delta: one reflected ray */
    LOBE_INTERFACE /* delta: reflected and refracted rays by Snell and Fresnel; needs the ray's
                      media */
} lobe_class;

typedef struct lobe lobe;
typedef struct lobe_type {
    lobe_class class;
    /* The BRDF, 1/sr, without the cosine; NULL for delta lobes. Both directions are on n's side. */
    dvec3 (*evaluate)(const lobe *l, dvec3 n, dvec3 wo, dvec3 wi);
} lobe_type;

struct lobe {
    const lobe_type *type;
    dvec3 weight; /* reflectance R, k_s, or the weight of the traced ray; of an interface that
                        of the refracted ray alone: what it reflects is Fresnel's */
    union {       /* the one parameter, by type */
        double exponent; /* Phong family */
        double ior;      /* Fresnel lobes; 0: the weight alone */
    };
};

enum { LOBES_MAX = 6 };

typedef struct bsdf {
    lobe lobes[LOBES_MAX];
    int lobe_count;
    dvec3 emission; /* radiance leaving towards wo */
    dvec3 ambient;  /* k_a */
    double alpha;   /* 1: all there; 0: a ray passes as if nothing were there */
} bsdf;

/* Lobes beyond LOBES_MAX would be a fault in a material. */
void bsdf_add(bsdf *b, const lobe_type *type, dvec3 weight, double parameter);
/* The sum of all lobes that are not delta. */
dvec3 bsdf_evaluate(const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi);
bool bsdf_is_lit(const bsdf *b); /* has a lobe that is not delta */
/* The colour of light that crosses an interface, beside Fresnel's factor; 1 where there is none. */
dvec3 bsdf_passing(const bsdf *b);

extern const lobe_type lobe_lambert;     /* R / pi */
extern const lobe_type lobe_blinn_phong; /* k_s (n.h)^p */
extern const lobe_type lobe_mirror;      /* weight; times Fresnel where ior > 0 */
extern const lobe_type lobe_interface;   /* a boundary between media */

/* v + 2 ((n.v) n - v): the mirror direction of v about n (Cornell "Ray tracing: shading"). */
dvec3 reflect_direction(dvec3 wo, dvec3 n);
/* Snell's law. eta: ior on wo's side / ior beyond. false: total internal reflection. Bikker,
 * "Whitted": T = eta D + N (eta cos1 - sqrt(k)), k = 1 - eta^2 (1 - cos1^2). */
bool refract_direction(dvec3 wo, dvec3 n, double eta, dvec3 *wi);
/* Fresnel's formulas for unpolarised light at a smooth dielectric boundary: the reflected fraction.
 * cos1 >= 0 on the side of ior1. 1 at total internal reflection. */
double fresnel_dielectric(double cos1, double ior1, double ior2);

#endif
