/* What every shape implements. One file per shape; one line in shapes.def.
 *
 * The hit rule (ARCHITECTURE.md): a primitive is hit if its own test says so and the ray passes the
 * primitive's own box by the slab formula that nodes use; then t = max(t, box entry). The kernels
 * do the second half; `intersect` is the first half. */
#ifndef SNELL_GEOMETRY_PRIMITIVE_H
#define SNELL_GEOMETRY_PRIMITIVE_H

#include "base/field.h"
#include "geometry/ray.h"

/* A ray in the shape's own space. Hits lie in t_min < t < t_max, tested on the rounded float t. */
typedef struct local_ray {
    vec3 o, d;
    float t_min, t_max;
} local_ray;

/* The ray in the space of to_local: computed in double and rounded once, the same in the kernels
 * and in shading. */
static inline local_ray local_ray_make(const ray *r, const transform *to_local, bool identity) {
    local_ray beam = {r->o, r->d, r->t_min, r->t_max};
    if (identity) return beam;
    beam.o = vec3_from(transform_point(to_local, dvec3_from(r->o)));
    beam.d = vec3_from(transform_vector(to_local, dvec3_from(r->d)));
    return beam;
}

/* A point on a surface, in the shape's own space (the scene brings it to the world). */
typedef struct surface {
    dvec3 p;      /* re-projected: on the surface as exactly as double allows */
    double error; /* bound on the distance, along n, between the true surface and what `intersect`
                     and the kernel see of it for a ray starting near p, besides the rounding of the
                     ray's own origin */
    double curvature;       /* the largest, 1/m, where the surface bends away from n; 0 when flat.
                         Always that in the shape's own space */
    dvec3 n;                /* geometric normal, unit, outward (counter-clockwise front) */
    dvec3 ns;               /* shading normal, unit, in n's hemisphere */
    double u, v;            /* texture coordinates */
    dvec3 dpdu, dpdv;       /* of p by u, v; 0 where the shape has no smooth coordinates */
    dvec3 tint;             /* vertex colour, linear; 1 without */
    double alpha;           /* vertex alpha; 1 without */
    uint32_t material_slot; /* material index of the triangle; 0 */
} surface;

/* Where the whole line of a ray crosses a closed shape's surface; u, v and primitive as `intersect`
 * sets them in a hit. t may be negative or infinite: a half-space begins or ends there. */
typedef struct surface_crossing {
    double t;
    float u, v;
    uint32_t primitive;
} surface_crossing;

/* A stretch of the line that lies inside. */
typedef struct span {
    surface_crossing enter, leave;
} span;

typedef struct primitive_type {
    type_info info;
    bool flat;      /* a ray that leaves it cannot meet it again */
    bool unbounded; /* has no box (planes): tested for every ray */
    /* Beyond what the table can say; NULL: nothing. Reports with error_set. */
    snell_status (*check)(const void *desc);
    /* Why no ray can ever meet a checked shape, as in "the mesh 'a' has no triangles", where that is
     * cheap to prove; NULL: it may be met. Gets the description itself. NULL for most. */
    const char *(*nothing)(const void *desc);
    bounds3 (*bounds)(const void *desc); /* contains every point that intersect may return */
    /* What is worked out once for all rays: a copy of the description that more follows after, which
     * borrows the description's strings and arrays. All functions below get it in the description's
     * place. Of a checked description, so NULL means out of memory. NULL: they get the description. */
    void *(*prepare)(const void *desc);
    void (*release)(void *prepared);
    /* Bytes that `prepare` takes at most; not NULL with it. */
    size_t (*prepared_size)(const void *desc);
    /* Shapes of very many parts, each with a box of its own by which rays find it: how many; they are
     * numbered from 0. primitive_bounds may be empty: there is nothing. NULL: one part. */
    uint32_t (*primitive_count)(const void *desc);
    bounds3 (*primitive_bounds)(const void *desc, uint32_t primitive);
    /* The nearest hit with ray->t_min < t < ray->t_max of the part number hit->primitive (0 where
     * there is one): sets t, u, v; and, of one part, primitive where several faces are told apart.
     * NULL for meshes, whose triangles the kernels test themselves. */
    bool (*intersect)(const void *desc, const local_ray *ray, hit *hit);
    /* Fills *out for a hit of this ray. */
    void (*surface)(const void *desc, const local_ray *ray, const hit *hit, surface *out);
    /* Sets u, v and dpdu, dpdv of a surface in the shape's own space, where that is work that only textures need;
     * NULL: `surface` sets them. */
    void (*parametrise)(const void *desc, surface *s);
    /* How ns changes when the point moves by the small dp, in the shape's own space. NULL:
     * curvature * dp, which is exact for spheres. */
    dvec3 (*bend)(const void *desc, const hit *hit, dvec3 dp);
    /* +1 inside, -1 outside: for closed shapes and half-spaces, to find the media around a point.
     * NULL: encloses nothing or a mesh. */
    int (*side)(const void *desc, dvec3 p);
    /* The stretches of the line o + t d, -infinity < t < infinity, that lie inside, in ascending order
     * and apart from one another; t_min and t_max of the ray do not count. Returns how many there
     * are; more than `capacity`: capacity + 1; -1, whatever the line: this one is open (a tube, a
     * lathe whose ends are off the axis) and cannot be part of a solid. Agrees with `intersect` and
     * `side`; where the line only touches the shape there may be a stretch or none. For closed
     * shapes and half-spaces, which solids are made of; NULL: no shape of this type can be. */
    int (*spans)(const void *desc, const local_ray *beam, span *out, int capacity);
    /* Sampling by area, for shapes that shine; in the shape's own space.
     * area: of one part (a triangle of a mesh), or of the whole surface where there is one, m^2. NULL:
     * not known; then a light of this shape is found by rays (scene/seen.h).
     * sample_area: (u, v) in [0,1)^2 to a point, uniform by area: fills *out as `surface` does;
     * (.5, .5) is the centre where the shape has one on its surface. */
    double (*area)(const void *desc, uint32_t primitive);
    void (*sample_area)(const void *desc, uint32_t primitive, double u, double v, surface *out);
    /* Optional, better: sampling by the solid angle that the shape subtends at `from` (own space).
     * NULL, or false: use the area.
     * sample_toward: the point that is seen from `from` in a direction drawn uniformly over that
     * solid angle, pdf per sr; (.5, .5) is the middle of it: a sphere's centre, but not always a
     * quad's. No occlusion by the shape itself: it is the first of its points that way.
     * pdf_toward: the density for a direction d (unit) that hits the shape; 0: use the area. Both
     * agree on when that is. */
    bool (*sample_toward)(const void *desc, dvec3 from, double u, double v, surface *out,
                          double *pdf_solid_angle);
    double (*pdf_toward)(const void *desc, dvec3 from, dvec3 d);
} primitive_type;

static inline uint32_t primitive_count_of(const primitive_type *type, const void *desc) {
    return type->primitive_count ? type->primitive_count(desc) : 1;
}

static inline bounds3 primitive_bounds_of(const primitive_type *type, const void *desc,
                                          uint32_t primitive) {
    return type->primitive_count ? type->primitive_bounds(desc, primitive) : type->bounds(desc);
}

/* What a shape's type made of its description (primitive_type.prepare). */
typedef struct prepared_shape {
    const primitive_type *type;
    void *made; /* NULL: nothing, the description serves */
} prepared_shape;

/* The registry: every type of shapes.def, in its order. */
extern const primitive_type *const primitive_types[];
extern const uint32_t primitive_type_count;
const primitive_type *primitive_find(const char *name); /* NULL: none of that name */

extern const primitive_type primitive_mesh; /* the one whose hits the kernels find */

#endif
