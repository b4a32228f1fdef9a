/* Materials, apart from geometry: one file per scattering model; one line in materials.def. */
#ifndef SNELL_MATERIALS_MATERIAL_H
#define SNELL_MATERIALS_MATERIAL_H

#include "materials/bsdf.h"
#include "textures/texture.h"

/* Fields that every material has, first in its table. */
#define MATERIAL_FIELDS(F, T)                                                                      \
    F(T, emission, INPUT, DEFAULT(0, 0, 0), NOT_NEGATIVE, "W/(m^2 sr)",                            \
      "radiance that it sends out")                                                                \
    F(T, emit_two_sided, BOOL, DEFAULT(0), ANY, "", "emit from the inside too")                    \
    F(T, ambient, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "",                                       \
      "k_a: how much of the scene's ambient light it shows")                                       \
    F(T, alpha, SCALAR, DEFAULT(1), RANGE(0, 1), "",                                               \
      "opacity: 0 lets rays pass as if nothing were there")                                        \
    F(T, alpha_cutoff, FLOAT, DEFAULT(0), RANGE(0, 2), "", "above 0: alpha below it is 0, else 1") \
    F(T, shadow, CHOICE, DEFAULT(0), CHOICES("filter|opaque|none"), "",                            \
      "filter: glass and alpha let light through; in path for points and directions alone")        \
    F(T, normal_map, TEXTURE, NO_DEFAULT, ANY, "",                                                 \
      "tangent-space normals as colours, linear: red along u, green along v, blue out")            \
    F(T, normal_scale, SCALAR, DEFAULT(1), ANY, "", "multiplies the slope of normal_map")          \
    F(T, bump, SCALAR, DEFAULT(0), ANY, "m", "a height whose slopes bend the shading normal")      \
    F(T, bump_scale, FLOAT, DEFAULT(1), ANY, "", "multiplies bump")

enum { SHADOW_FILTER, SHADOW_OPAQUE, SHADOW_NONE };

typedef struct material_common {
    size_t struct_size;
    MATERIAL_FIELDS(FIELD_MEMBER, material_common)
} material_common;

/* What a dielectric's inside does to light; NULL-able pointer elsewhere. */
typedef struct medium {
    double ior;
    dvec3 absorption;       /* a of exp(-a d), per metre */
    int32_t priority;       /* where solids overlap the higher one is present */
    double ior_by_color[3]; /* of red, green and blue light; without dispersion all `ior` */
} medium;

/* A medium whose `ior` is that at 587.6 nm, with the Abbe number 20 / dispersion; 0: colours do not
 * part. */
medium medium_make(double ior, double dispersion, dvec3 absorption, int32_t priority);
static inline bool medium_disperses(const medium *m) {
    return m->ior_by_color[0] != m->ior_by_color[2];
}

/* a of exp(-a d) that leaves `color` of white light after `distance`: -ln(color) / distance; 0 where
 * the distance is 0. */
dvec3 medium_attenuation(dvec3 color, double distance);

typedef struct material material;

/* Everything that a material may look at. */
typedef struct material_point {
    texture_point at;
    dvec3 tint;   /* vertex colour */
    double alpha; /* vertex alpha */
    bool outside; /* wo is on the side of the outward normal */
    /* Of materials that look along the surface: where u grows and, turned by a right angle, v; unit, in
     * the surface. 0: unknown. */
    dvec3 tangent, bitangent;
    coat_normal coat;
    const texture *textures;
    const material *materials; /* the frozen scene's: for materials made of others */
} material_point;

/* Normals as colours, and what multiplies their slope. */
typedef struct normal_detail {
    snell_texture_id map;
    snell_input scale;
} normal_detail;

typedef struct material_type {
    type_info info;
    snell_status (*check)(const void *desc); /* beyond the table; NULL: nothing */
    /* Adds this model's lobes for this point. out->ambient is k_a; a model that only traces sets it
     * to 0. */
    void (*fill)(const void *desc, const material_point *point, bsdf *out);
    /* Radiance beside the common `emission`, for materials that shine by other fields. Both NULL:
     * none. shines: might it anywhere? `materials` are the frozen ones before it. */
    dvec3 (*emission)(const void *desc, const material_point *point);
    bool (*shines)(const void *desc, const material *materials);
    /* The medium inside closed shapes of this material; NULL: it does not bound one. */
    medium (*inside)(const void *desc);
    /* Whether light may go straight through it, being thin (lobe_thin, lobe_rough_thin); NULL: no. */
    bool (*is_thin)(const void *desc);
    /* Whether it looks different along different directions of the surface; NULL: no. */
    bool (*is_grained)(const void *desc);
    /* Whether it has a clear coat, and the normals of that: what bends the surface's does not bend it;
     * NULL: no. */
    bool (*coat)(const void *desc, normal_detail *out);
    /* Whether this one bounds its medium; NULL: it always does, where there is `inside`. */
    bool (*bounds)(const void *desc);
    /* How much of it is there, 0 .. 1, beside the common `alpha`; NULL: all. */
    double (*opacity)(const void *desc, const material_point *point);
    bool may_gain; /* a classic formula that may reflect more than it receives */
} material_type;

static inline bool material_bounds_medium(const material_type *type, const void *desc) {
    return type->inside && (type->bounds == NULL || type->bounds(desc));
}
/* Those that it is made of do not count. */
static inline bool material_emits(const material_type *type, const void *desc) {
    return vec3_largest(((const material_common *)desc)->emission.value) > 0 ||
           (type->shines && type->shines(desc, NULL));
}

extern const material_type *const material_types[];
extern const uint32_t material_type_count;

/* A frozen material. */
struct material {
    const material_type *type;
    const void *desc;  /* begins with material_common */
    bool opaque_alpha; /* alpha is 1 everywhere: shadow rays need not look */
    bool textured;     /* looks at u, v or the point */
    bool thin;         /* light may go straight through it or a part of it */
    bool shines;       /* has emission somewhere */
    bool bends;        /* has normal maps or bump: the shading normals are not the shape's */
    bool coated;       /* has a clear coat, which does not bend with the surface */
    bool grained;      /* looks along the surface: material_point.tangent is wanted */
};

/* Stops every shadow ray. What goes on straight through it all the same, in `path`, finds what no
 * sample of a light could. */
static inline bool material_casts_full_shadow(const material *m) {
    return ((const material_common *)m->desc)->shadow == SHADOW_OPAQUE;
}

/* The whole bsdf: common fields and lobes. */
void material_evaluate(const material *m, const material_point *point, bsdf *out);
/* The radiance that it sends out at the point; 0 from the inside, unless emit_two_sided. */
dvec3 material_emission(const material *m, const material_point *point);
/* The fraction of light that it sends back or on when seen at this cosine from outside, its largest
 * colour, estimated with 1024 fixed samples at the texture coordinates (0, 0). */
double material_albedo(const material *m, const texture *textures, const material *materials,
                       double cosine);
/* The opacity alone, for rays that pass through. */
double material_alpha(const material *m, const material_point *point);

#endif
