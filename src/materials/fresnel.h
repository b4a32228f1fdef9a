/* How much of the light a smooth boundary reflects. */
#ifndef SNELL_MATERIALS_FRESNEL_H
#define SNELL_MATERIALS_FRESNEL_H

#include "maths/vec.h"

typedef enum fresnel_kind {
    FRESNEL_NONE,       /* 1 */
    FRESNEL_DIELECTRIC, /* Fresnel's formulas: a.x is the index beyond, relative to wo's side */
    FRESNEL_CONDUCTOR,  /* with a complex index: a = eta, b = k */
    FRESNEL_SCHLICK,    /* a + (b - a) (1 - cos)^5: a at normal incidence, b at grazing */
    FRESNEL_FILM        /* a film of index b.x and b.y nanometres on a base of reflectance a */
} fresnel_kind;

typedef struct fresnel {
    fresnel_kind kind;
    dvec3 a, b;
} fresnel;

/* The reflected fraction, per colour; cosine >= 0 of the angle to the (facet's) normal. */
dvec3 fresnel_evaluate(const fresnel *f, double cosine);
/* A relative index under 1 is a boundary to a rarer medium: total internal reflection. */
static inline fresnel fresnel_of_ior(double ior) {
    return (fresnel){FRESNEL_DIELECTRIC, {ior, ior, ior}, {0, 0, 0}};
}

/* Fresnel's formulas for unpolarised light at a smooth dielectric boundary: the reflected fraction.
 * cos1 >= 0 on the side of ior1. 1 at total internal reflection. (Cornell CS4620, "Fresnel's
 * formulas".) */
double fresnel_dielectric(double cos1, double ior1, double ior2);
/* What a thin film on a base of reflectance f0 (at normal incidence, from vacuum) reflects, per colour:
 * its waves interfere (Belcour and Barla, A Practical Extension to Microfacet Theory for the Modeling
 * of Varying Iridescence, 2017, as KHR_materials_iridescence has it). thickness in nanometres. */
dvec3 fresnel_film(double cosine, double ior, double thickness, dvec3 f0);
/* The f0 of a Schlick reflectance, with 1 at grazing, that is nowhere less than the film's. */
double fresnel_film_bound(double ior, double thickness, dvec3 f0);
/* The reflectance at normal incidence from vacuum: ((ior - 1) / (ior + 1))^2. */
static inline double fresnel_f0(double ior) {
    double root = (ior - 1) / (ior + 1);
    return root * root;
}
/* The same for a conductor of complex index eta + i k, seen from vacuum. k = 0 is a dielectric. */
double fresnel_conductor(double cosine, double eta, double k);

#endif
