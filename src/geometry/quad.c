/* A parallelogram: corner + a u + b v with a, b in [0,1], which are its texture coordinates. It
 * faces cross(u, v). */
#include "base/error.h"
#include "geometry/surface.h"
#include "maths/functions.h"

#define QUAD_FIELDS(F, T)                                                                          \
    F(T, corner, VEC3, NO_DEFAULT, REQUIRED, "m", "one corner")                                    \
    F(T, u, VEC3, NO_DEFAULT, REQUIRED, "m", "from the corner along one side")                     \
    F(T, v, VEC3, NO_DEFAULT, REQUIRED, "m",                                                       \
      "from the corner along the other side; the quad faces cross(u, v)")
DESCRIBE(quad, QUAD_FIELDS)

static snell_status check(const void *desc) {
    const quad_desc *quad = desc;
    dvec3 u = dvec3_from(quad->u), v = dvec3_from(quad->v), n = dvec3_cross(u, v);
    /* Products of floats are exact in double, a difference of two is not: ask for more than that.
     */
    if (dvec3_length(n) > 0x1p-40 * dvec3_length(u) * dvec3_length(v)) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "'u' and 'v' are two sides that meet in the corner",
                     "quad: 'u' and 'v' span no area");
}

static bounds3 bounds(const void *desc) {
    const quad_desc *quad = desc;
    dvec3 corner = dvec3_from(quad->corner), u = dvec3_from(quad->u), v = dvec3_from(quad->v);
    dvec3 low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 4; i++) {
        dvec3 p = corner;
        if (i & 1) p = dvec3_add(p, u);
        if (i & 2) p = dvec3_add(p, v);
        low = (dvec3){double_min(low.x, p.x), double_min(low.y, p.y), double_min(low.z, p.z)};
        high = (dvec3){double_max(high.x, p.x), double_max(high.y, p.y), double_max(high.z, p.z)};
    }
    /* Wider by a few float roundings: where two quads meet at an edge, a ray that meets one of them
     * must not miss its thin box. */
    double largest = double_max(dvec3_largest(high), dvec3_largest(dvec3_negate(low)));
    double wider = 4 * FLOAT_EPSILON * (largest + dvec3_largest(dvec3_sub(high, low)));
    dvec3 margin = {wider, wider, wider};
    return bounds3_outward(dvec3_sub(low, margin), dvec3_add(high, margin));
}

/* t and the two coordinates of the point where the ray meets the plane. */
static bool solve(const quad_desc *quad, const local_ray *beam, double *t, double *a, double *b) {
    dvec3 u = dvec3_from(quad->u), v = dvec3_from(quad->v), n = dvec3_cross(u, v);
    dvec3 d = dvec3_from(beam->d), f = dvec3_sub(dvec3_from(beam->o), dvec3_from(quad->corner));
    double slope = dvec3_dot(n, d), square = dvec3_dot(n, n);
    *t = -dvec3_dot(n, f) / slope;
    dvec3 w = dvec3_add(f, dvec3_scale(d, *t));
    *a = dvec3_dot(dvec3_cross(w, v), n) / square;
    *b = dvec3_dot(dvec3_cross(u, w), n) / square;
    return slope != 0;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t, a, b;
    if (!solve(desc, beam, &t, &a, &b) || !(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return false;
    found->u = (float)a;
    found->v = (float)b;
    return surface_accept(beam, t, &found->t);
}

static surface surface_at(const quad_desc *quad, double a, double b) {
    dvec3 corner = dvec3_from(quad->corner), u = dvec3_from(quad->u), v = dvec3_from(quad->v);
    dvec3 n = dvec3_cross(u, v);
    dvec3 p = dvec3_add(corner, dvec3_add(dvec3_scale(u, a), dvec3_scale(v, b)));
    /* A thin parallelogram's normal is less exact by the ratio of its sides' product to its area.
     */
    double sides = dvec3_length(u) * dvec3_length(v), area = dvec3_length(n);
    double size = fabs(corner.x) + fabs(corner.y) + fabs(corner.z) + 2 * dvec3_length(u) +
                  2 * dvec3_length(v);
    surface made = surface_make(p, dvec3_normalize(n), 16 * DOUBLE_EPSILON * size * (sides / area));
    made.u = a;
    made.v = b;
    made.dpdu = u;
    made.dpdv = v;
    return made;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const quad_desc *quad = desc;
    double t, a, b;
    if (!solve(quad, beam, &t, &a, &b)) {
        a = found->u;
        b = found->v;
    }
    *out = surface_at(quad, clamp01(a), clamp01(b));
}

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    const quad_desc *quad = desc;
    return dvec3_length(dvec3_cross(dvec3_from(quad->u), dvec3_from(quad->v)));
}

static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    *out = surface_at(desc, u, v);
}

/* A rectangle seen from a point: Urena, Fajardo, King, An Area-Preserving Parametrization for Spherical
 * Rectangles, EGSR 2013. x and y are its sides' directions, z points to its plane's far side. */
typedef struct seen {
    dvec3 x, y;
    double x0, x1, y0, y1; /* the corners, from the point's foot on the plane */
    double z0;             /* minus the distance to the plane */
    double b0, b1, k;
    double angle; /* the solid angle, sr */
} seen;

/* Below this the angles' sum has lost too many digits; the area is as good for something so small.
 */
#define SOLID_ANGLE_MIN 1e-4

/* The angle between two neighbouring sides' planes is the arc cosine of minus the product of their
 * normals' z. False: no rectangle, edge-on, or too small. */
static bool see(const quad_desc *quad, dvec3 from, seen *out) {
    dvec3 u = dvec3_from(quad->u), v = dvec3_from(quad->v);
    double width = dvec3_length(u), height = dvec3_length(v);
    if (!(fabs(dvec3_dot(u, v)) <= 1e-6 * width * height)) return false;
    out->x = dvec3_scale(u, 1 / width);
    out->y = dvec3_scale(v, 1 / height);
    dvec3 f = dvec3_sub(dvec3_from(quad->corner), from), n = dvec3_cross(out->x, out->y);
    double z = -fabs(dvec3_dot(f, n)), size = width + height + dvec3_length(f);
    out->x0 = dvec3_dot(f, out->x);
    out->x1 = out->x0 + width;
    out->y0 = dvec3_dot(f, out->y);
    out->y1 = out->y0 + height;
    out->z0 = z;
    if (!(z < -1e-6 * size)) return false;
    double n0 = -out->y0 / sqrt(z * z + out->y0 * out->y0);
    double n1 = out->x1 / sqrt(z * z + out->x1 * out->x1);
    double n2 = out->y1 / sqrt(z * z + out->y1 * out->y1);
    double n3 = -out->x0 / sqrt(z * z + out->x0 * out->x0);
    double g2 = fn_acos(-n2 * n3), g3 = fn_acos(-n3 * n0);
    out->b0 = n0;
    out->b1 = n2;
    out->k = 2 * PI - g2 - g3;
    out->angle = fn_acos(-n0 * n1) + fn_acos(-n1 * n2) - out->k;
    return out->angle >= SOLID_ANGLE_MIN;
}

/* u chooses the vertical line that cuts off that share of the angle, v the height on it, where the
 * angle grows with h / sqrt(d^2 + h^2). (The paper's section 4; its formulas (2) to (4).) */
static bool sample_toward(const void *desc, dvec3 from, double u, double v, surface *out,
                          double *pdf_solid_angle) {
    const quad_desc *quad = desc;
    seen s;
    if (!see(quad, from, &s)) return false;
    double a = u * s.angle + s.k, sine = fn_sin(a);
    double f = (fn_cos(a) * s.b0 - s.b1) / sine;
    double c = (f > 0 ? 1 : -1) / sqrt(f * f + s.b0 * s.b0);
    if (!(c >= -1 && c <= 1)) c = c < 0 ? -1 : 1; /* also where the sine is 0 */
    double away = sqrt(double_max(1 - c * c, 1e-30));
    double x = double_min(double_max(-c * s.z0 / away, s.x0), s.x1);
    double square = x * x + s.z0 * s.z0;
    double h0 = s.y0 / sqrt(square + s.y0 * s.y0), h1 = s.y1 / sqrt(square + s.y1 * s.y1);
    double h = h0 + v * (h1 - h0);
    double y = h * h < 1 - 1e-12 ? h * sqrt(square) / sqrt(1 - h * h) : s.y1;
    y = double_min(double_max(y, s.y0), s.y1);
    *out =
        surface_at(quad, clamp01((x - s.x0) / (s.x1 - s.x0)), clamp01((y - s.y0) / (s.y1 - s.y0)));
    *pdf_solid_angle = 1 / s.angle;
    return true;
}

static double pdf_toward(const void *desc, dvec3 from, dvec3 d) {
    (void)d;
    seen s;
    return see(desc, from, &s) ? 1 / s.angle : 0;
}

extern const primitive_type primitive_quad;
const primitive_type primitive_quad = {
    .info = TYPE_INFO(CATEGORY_SHAPE, quad, "quad", "a parallelogram, such as a rectangle"),
    .flat = true,
    .check = check,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .area = area,
    .sample_area = sample_area,
    .sample_toward = sample_toward,
    .pdf_toward = pdf_toward,
};
