/* What a surface does to light at one point: a short list of lobes that a material fills in once
 * per hit.
 *
 * wo and wi are unit vectors that point away from the surface: wo to where the ray came from, wi to
 * where light comes from. The normal n here is the shading normal on wo's side, so dot(n, wo) >= 0;
 * wi is on the other side only for lobes that transmit. */
#ifndef SNELL_MATERIALS_BSDF_H
#define SNELL_MATERIALS_BSDF_H

#include "materials/fresnel.h"
#include "sampling/sampling.h"

typedef enum lobe_class {
    LOBE_DIFFUSE,  /* Lambert and the Phong family */
    LOBE_GLOSSY,   /* microfacets */
    LOBE_MIRROR,   /* delta: one reflected ray */
    LOBE_INTERFACE /* delta: reflected and refracted rays by Snell and Fresnel */
} lobe_class;

/* Which lobes an integrator traces and which it lights: the table in ARCHITECTURE.md. */
typedef unsigned lobe_set;
#define LOBE_BIT(class) (1u << (class))
enum {
    LOBES_DIFFUSE = LOBE_BIT(LOBE_DIFFUSE),
    LOBES_LIT = LOBE_BIT(LOBE_DIFFUSE) | LOBE_BIT(LOBE_GLOSSY), /* all that are not delta */
    LOBES_NOT_MIRRORED = 1u << 16 /* with these: but those that whitted traces instead */
};

typedef struct lobe lobe;
typedef struct bsdf bsdf;

typedef struct lobe_type {
    lobe_class class;
    bool transmits; /* wi may lie beyond the surface */
    bool thin;      /* of those that transmit: what is beyond is the same medium, so that light goes
                       straight on, and its index is that of lobe.fresnel */
    bool matte; /* looks about the same from everywhere: what light from everywhere falls on where
                       nothing is sampled */
    /* The BSDF, 1/sr, without the cosine. Both NULL for delta lobes. */
    dvec3 (*evaluate)(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi);
    /* The density of `sample`, per solid angle of wi. */
    double (*pdf)(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi);
    /* Draws wi from about evaluate times the cosine; u in [0,1)^2. false: nothing is reflected into
     * the direction drawn (it counts as a sample all the same). */
    bool (*sample)(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo, sample2 u, dvec3 *wi);
} lobe_type;

struct lobe {
    const lobe_type *type;
    dvec3 weight; /* reflectance R, k_s, or the weight of the traced ray; of a smooth interface that
                     of the refracted ray alone: what it reflects is Fresnel's */
    union {       /* the one parameter, by type */
        double exponent; /* Phong family */
        double alpha;    /* microfacets: Beckmann's m, or GGX's alpha = roughness^2 */
    };
    fresnel fresnel; /* of mirrors and microfacets; FRESNEL_NONE: the weight alone */
    /* In whitted, a glossy lobe also sends a mirror ray of weight * Fresnel * mirror_share; at 1 it
     * is a mirror and not lit by sampling lights. */
    double mirror_share;
    /* How much of the light from wo it sends on, roughly (0 .. 1): `path` chooses among lobes by it.
     * Negative: bsdf_add's own guess from weight and Fresnel. */
    double share;
    union {
        dvec3 reflected;    /* of interfaces: multiplies what they reflect; 1 */
        double alpha_along; /* of lobe_grained: GGX's alpha along the bsdf's tangent */
    };
    unsigned coats; /* bit i: the bsdf's coat i lies over it */
    bool tilted;    /* the coat's normal stands in place of n; not of lobes that transmit */
};

/* What lies over other lobes keeps light from them: its own directional albedo E, in part. */
typedef struct coating {
    bool sheen; /* of fibres; else a dielectric of reflectance f0, GGX */
    double amount, alpha, f0;
} coating;

/* A clear coat keeps its own normal where the surface under it has another. */
typedef struct coat_normal {
    bool own;      /* else it has the surface's, and the rest is not set */
    dvec3 n, side; /* that normal; the geometric one; unit, both on wo's side */
} coat_normal;

enum { LOBES_MAX = 12, COATS_MAX = 4 };

struct bsdf {
    lobe lobes[LOBES_MAX];
    int lobe_count;
    coating coats[COATS_MAX];
    int coat_count;
    coat_normal coat;  /* of coats that are no sheen, and of lobes that are tilted */
    dvec3 emission;    /* radiance leaving towards wo */
    dvec3 ambient;     /* k_a */
    double alpha;      /* 1: all there; 0: a ray passes as if nothing were there */
    dvec3 tangent;     /* of lobe_grained: its grain, of any length; not set without one */
    double ior1, ior2; /* on wo's side and beyond; the wave sets them from the ray's media */
    /* The ray's red, green and blue light would take three ways beyond, by these indices in place of
     * those; not set without. */
    bool disperses;
    const double *ior1_by_color, *ior2_by_color; /* each three: red, green, blue */
};

/* 0 red, 1 green, 2 blue: the bsdf for that alone, and the factor that leaves that alone. */
static inline void bsdf_take_color(bsdf *b, int color) {
    b->ior1 = b->ior1_by_color[color];
    b->ior2 = b->ior2_by_color[color];
    b->disperses = false;
}
static inline dvec3 color_alone(int color) { return (dvec3){color == 0, color == 1, color == 2}; }

/* Adds a lobe and returns it, for the fields that the type needs beside these; NULL for a lobe that
 * would do nothing. Lobes beyond LOBES_MAX would be a fault in a material. */
lobe *bsdf_add(bsdf *b, const lobe_type *type, dvec3 weight, double parameter);

/* The normal that a lobe has where the surface has n. */
static inline dvec3 lobe_normal(const lobe *l, const bsdf *b, dvec3 n) {
    return l->tilted ? b->coat.n : n;
}

/* The sum of the lobes of `set` that are not delta. Where a coat has its own normal, a lobe counts only
 * for a wi that is on the same side of its normal and of the geometric one, and that of the coat is
 * multiplied by the cosine with its normal over that with n, which callers multiply by. */
dvec3 bsdf_evaluate(const bsdf *b, lobe_set set, dvec3 n, dvec3 wo, dvec3 wi);
bool bsdf_is_lit(const bsdf *b, lobe_set set); /* has a lobe of the set that is not delta */
/* Whether bsdf_evaluate is the same *f for every wi above, and 0 for those below. */
bool bsdf_is_even(const bsdf *b, lobe_set set, dvec3 *f);
/* The colour of light that crosses an interface, beside Fresnel's factor; 1 where there is none. */
dvec3 bsdf_passing(const bsdf *b);

/* What of the light from wo goes straight on through thin panes: 1 - F of their colour. smooth: of
 * those alone that do not scatter it. */
dvec3 bsdf_straight(const bsdf *b, dvec3 n, dvec3 wo, bool smooth);

/* One direction for all lobes: one of them is chosen by its share and drawn from; the densities of
 * all that are not delta count. `bsdf_pdf` is the density that bsdf_sample draws with, per solid
 * angle, its delta lobes left out. */
typedef struct bsdf_direction {
    dvec3 wi;
    dvec3 weight; /* f |cos| / pdf */
    double pdf;   /* per solid angle; 0: a delta lobe */
    bool transmitted;
} bsdf_direction;
double bsdf_pdf(const bsdf *b, dvec3 n, dvec3 wo, dvec3 wi);
/* choice in [0,1) chooses the lobe. false: the path ends here. */
bool bsdf_sample(const bsdf *b, dvec3 n, dvec3 wo, double choice, sample2 u, bsdf_direction *out);

/* What coats leave of light that comes from one direction and goes to the other, by the cosines of
 * both with n, or with the coat's own normal: the less of the two, which is reciprocal and never more
 * than the coat lets through (KHR_materials_sheen, "Albedo scaling"). bsdf_evaluate and bsdf_sample
 * include it. */
double lobe_passing(const lobe *l, const bsdf *b, dvec3 wo, dvec3 wi, double cos_o, double cos_i);
/* The weight of the mirror ray of a mirror or, sharpened, of a glossy lobe: weight * Fresnel, less
 * what its coats keep. */
dvec3 lobe_mirrored(const lobe *l, const bsdf *b, dvec3 n, dvec3 wo);

/* The colour of what the surface sends back or on of light that comes from wo, each component
 * at most 1: the sum of its lobes' weights, where it has them times Fresnel's factor and what coats let
 * pass. Of rough and of Phong lobes an estimate, of Lambert exactly R. */
dvec3 bsdf_albedo(const bsdf *b, dvec3 n, dvec3 wo);

/* Fresnel's fraction that a smooth one, or a pane, reflects at this cosine; of lobes that transmit. */
static inline double interface_reflected(const lobe *l, const bsdf *b, double cosine) {
    return l->type->thin ? fresnel_evaluate(&l->fresnel, cosine).x
                         : fresnel_dielectric(cosine, b->ior1, b->ior2);
}

extern const lobe_type lobe_lambert;     /* R / pi */
extern const lobe_type lobe_phong;       /* k_s (r.v)^p */
extern const lobe_type lobe_blinn_phong; /* k_s (n.h)^p */
extern const lobe_type lobe_mirror;      /* weight times Fresnel */
extern const lobe_type lobe_interface;   /* a smooth boundary between media */
extern const lobe_type lobe_thin;        /* a smooth pane without thickness: straight on */

/* v + 2 ((n.v) n - v): the mirror direction of v about n (Cornell "Ray tracing: shading"). */
dvec3 reflect_direction(dvec3 wo, dvec3 n);
/* Snell's law. eta: ior on wo's side / ior beyond. false: total internal reflection. Bikker,
 * "Whitted": T = eta D + N (eta cos1 - sqrt(k)), k = 1 - eta^2 (1 - cos1^2). */
bool refract_direction(dvec3 wo, dvec3 n, double eta, dvec3 *wi);

#endif
