/* A torus: a circle of radius `minor` swept around a circle of radius `major` about the axis. Texture
 * coordinates, seen from outside with the axis up: u around the axis as on a sphere (for the axis +Y,
 * 0.5 faces +Z), v around the tube, upwards on the outside: 0.5 at the outer equator, the seam on the
 * inner one. */
#include "base/error.h"
#include "geometry/surface.h"
#include "maths/functions.h"

#define TORUS_FIELDS(F, T)                                                                         \
    F(T, center, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the centre")                                   \
    F(T, axis, VEC3, DEFAULT(0, 1, 0), DIRECTION, "", "the direction that the ring lies around")   \
    F(T, major, FLOAT, DEFAULT(1), POSITIVE, "m", "from the centre to the middle of the tube")     \
    F(T, minor, FLOAT, DEFAULT(0.25f), POSITIVE, "m", "the tube's radius, less than 'major'")
DESCRIBE(torus, TORUS_FIELDS)

static snell_status check(const void *desc) {
    const torus_desc *torus = desc;
    if (torus->minor < torus->major) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT,
                     "a torus without a hole would meet itself; make the tube thinner",
                     "torus: 'minor' is %g; it must be less than 'major', %g", (double)torus->minor,
                     (double)torus->major);
}

/* Half the size along a coordinate is major sqrt(1 - axis_i^2) + minor; wider as for a disk. */
static bounds3 bounds(const void *desc) {
    const torus_desc *torus = desc;
    dvec3 c = dvec3_from(torus->center), n = dvec3_normalize(dvec3_from(torus->axis));
    double major = torus->major, minor = torus->minor;
    dvec3 half = {major * sqrt(n.y * n.y + n.z * n.z), major * sqrt(n.x * n.x + n.z * n.z),
                  major * sqrt(n.x * n.x + n.y * n.y)};
    double wider = 4 * FLOAT_EPSILON *
                   (major + minor + double_max(double_max(fabs(c.x), fabs(c.y)), fabs(c.z)));
    half = dvec3_add(half, (dvec3){minor + wider, minor + wider, minor + wider});
    return bounds3_outward(dvec3_sub(c, half), dvec3_add(c, half));
}

/* An orthonormal right-handed frame with the axis as y. */
typedef struct axes {
    dvec3 x, y, z;
} axes;

static axes axes_of(const torus_desc *torus) {
    axes made;
    dvec3 across;
    made.y = dvec3_normalize(dvec3_from(torus->axis));
    dvec3_frame(made.y, &made.x, &across);
    made.z = dvec3_negate(across);
    return made;
}

static dvec3 to_axes(const axes *a, dvec3 v) {
    return (dvec3){dvec3_dot(v, a->x), dvec3_dot(v, a->y), dvec3_dot(v, a->z)};
}

static dvec3 from_axes(const axes *a, dvec3 v) {
    return dvec3_add(dvec3_scale(a->x, v.x),
                     dvec3_add(dvec3_scale(a->y, v.y), dvec3_scale(a->z, v.z)));
}

/* ---- roots ----
 * In the torus' frame, in units of its outer radius, the ray's d made unit and its origin moved to
 * where it is nearest to the centre, so that dot(o, d) = 0. Then with s = |p|^2 = t^2 + |o|^2
 *     F(t) = (s - R^2 - r^2)^2 + 4 R^2 (y^2 - r^2)
 * has the sign of the distance from the tube and no cubic term. Roots of F' split the ray into
 * stretches with one root of F at most. Which of them have one, and where, is decided by the distance
 * itself, sqrt((rho - R)^2 + y^2) - r: it does not cancel as a quartic's coefficients do. */
typedef struct problem {
    dvec3 o, d;
    double major, minor;
} problem;

static double distance_at(const problem *p, double t, double *slope) {
    double x = p->o.x + t * p->d.x, y = p->o.y + t * p->d.y, z = p->o.z + t * p->d.z;
    double rho = sqrt(x * x + z * z), out = rho - p->major, tube = sqrt(out * out + y * y);
    double outward = rho > 0 ? (x * p->d.x + z * p->d.z) / rho : 0;
    *slope = tube > 0 ? (out * outward + y * p->d.y) / tube : 0;
    return tube - p->minor;
}

/* F' / 4 = t^3 + linear t + constant. */
typedef struct cubic {
    double linear, constant;
} cubic;

static double cubic_at(const cubic *c, double t, double *slope) {
    *slope = 3 * t * t + c->linear;
    return t * (t * t + c->linear) + c->constant;
}

#define STEPS_MAX 100

/* The root between low and high, where the values' signs differ: Newton's method, or halving where
 * that would leave the bracket or not shrink it by half. */
static double refine(double (*value)(const void *data, double t, double *slope), const void *data,
                     double low, double high, bool low_is_positive) {
    double t = (low + high) / 2, before = high - low;
    for (int i = 0; i < STEPS_MAX; i++) {
        double slope, y = value(data, t, &slope);
        if (y == 0) return t;
        if ((y > 0) == low_is_positive)
            low = t;
        else
            high = t;
        double step = y / slope, next = t - step;
        if (!(next > low && next < high) || !(2 * fabs(step) < before)) {
            next = (low + high) / 2;
            step = (high - low) / 2;
        }
        if (next == t || fabs(step) < 0x1p-56) return next;
        before = fabs(step);
        t = next;
    }
    return t;
}

static double value_of_distance(const void *data, double t, double *slope) {
    return distance_at(data, t, slope);
}

static double value_of_cubic(const void *data, double t, double *slope) {
    return cubic_at(data, t, slope);
}

/* low, the places between low and high where F' may change its sign, high. */
static int split(const cubic *c, double low, double high, double at[8]) {
    double ends[4] = {low}, slope;
    int count = 1, used = 0;
    if (c->linear < 0) {
        double extreme = sqrt(-c->linear / 3);
        if (-extreme > low && -extreme < high) ends[count++] = -extreme;
        if (extreme > low && extreme < high) ends[count++] = extreme;
    }
    ends[count++] = high;
    for (int i = 0; i < count; i++) {
        at[used++] = ends[i]; /* one split too many does no harm */
        if (i + 1 == count) break;
        bool positive = cubic_at(c, ends[i], &slope) > 0;
        if (positive == (cubic_at(c, ends[i + 1], &slope) > 0)) continue;
        at[used++] = refine(value_of_cubic, c, ends[i], ends[i + 1], positive);
    }
    return used;
}

/* The stretch of the ray inside the torus' outer sphere and between the planes that hold it. */
static bool clip(const problem *p, double *low, double *high) {
    double left = (1 + 0x1p-40) - dvec3_dot(p->o, p->o), height = p->minor + 0x1p-40;
    if (!(left >= 0)) return false;
    *high = sqrt(left);
    *low = -*high;
    if (p->d.y == 0) return fabs(p->o.y) <= height;
    double one = (-height - p->o.y) / p->d.y, other = (height - p->o.y) / p->d.y;
    *low = double_max(*low, double_min(one, other));
    *high = double_min(*high, double_max(one, other));
    return *low < *high;
}

/* Up to four roots in ascending order, in the ray's own t. */
static int solve(const torus_desc *torus, const local_ray *beam, double t[4]) {
    axes frame = axes_of(torus);
    dvec3 o = dvec3_sub(dvec3_from(beam->o), dvec3_from(torus->center)), d = dvec3_from(beam->d);
    double speed = dvec3_length(d), size = (double)torus->major + (double)torus->minor;
    if (!(speed > 0)) return 0;
    d = dvec3_scale(d, 1 / speed);
    double shift = -dvec3_dot(o, d);
    o = dvec3_add(o, dvec3_scale(d, shift));
    problem p = {dvec3_scale(to_axes(&frame, o), 1 / size), to_axes(&frame, d), torus->major / size,
                 torus->minor / size};
    double low, high, at[8], unused;
    if (!clip(&p, &low, &high)) return 0;
    double beta = dvec3_dot(p.o, p.o) - p.major * p.major - p.minor * p.minor;
    cubic derivative = {beta + 2 * p.major * p.major * p.d.y * p.d.y,
                        2 * p.major * p.major * p.o.y * p.d.y};
    int splits = split(&derivative, low, high, at), count = 0;
    bool positive = distance_at(&p, at[0], &unused) > 0;
    for (int i = 0; i + 1 < splits && count < 4; i++) {
        bool next = distance_at(&p, at[i + 1], &unused) > 0;
        if (next != positive) {
            double root = refine(value_of_distance, &p, at[i], at[i + 1], positive);
            t[count++] = (shift + root * size) / speed;
        }
        positive = next;
    }
    return count;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    double t[4];
    int count = solve(desc, beam, t);
    found->u = found->v = 0;
    for (int i = 0; i < count; i++)
        if (surface_accept(beam, t[i], &found->t)) return true;
    return false;
}

/* The distance is positive at both ends of what `solve` looks at, so its roots come in pairs. */
static int spans(const void *desc, const local_ray *beam, span *out, int capacity) {
    double t[4];
    int roots = solve(desc, beam, t), count = 0;
    for (int i = 0; i + 1 < roots; i += 2)
        count = surface_add_span(out, count, capacity, (surface_crossing){.t = t[i]},
                                 (surface_crossing){.t = t[i + 1]});
    return count;
}

/* ---- points ---- */

/* The point at the angle around the axis whose sine and cosine are x and z, and around the tube whose
 * cosine and sine are `out` and `up`. */
static void make_point(const torus_desc *torus, double x, double z, double out, double up,
                       surface *s) {
    axes frame = axes_of(torus);
    dvec3 center = dvec3_from(torus->center);
    double major = torus->major, minor = torus->minor, r = major + minor * out;
    dvec3 p = dvec3_add(center, from_axes(&frame, (dvec3){r * x, minor * up, r * z}));
    double curvature = double_max(1 / minor, fabs(out) / r);
    double size = major + minor + fabs(center.x) + fabs(center.y) + fabs(center.z);
    dvec3 n = dvec3_normalize(from_axes(&frame, (dvec3){out * x, up, out * z}));
    *s = surface_make(p, n, 64 * DOUBLE_EPSILON * size + surface_shift_error(p, curvature));
    s->curvature = curvature;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    const torus_desc *torus = desc;
    double t = found->t, root[4];
    int count = solve(torus, beam, root);
    for (int i = 0; i < count; i++)
        if (i == 0 || fabs(root[i] - found->t) < fabs(t - found->t)) t = root[i];
    axes frame = axes_of(torus);
    dvec3 p = dvec3_add(dvec3_sub(dvec3_from(beam->o), dvec3_from(torus->center)),
                        dvec3_scale(dvec3_from(beam->d), t));
    p = to_axes(&frame, p);
    double rho = sqrt(p.x * p.x + p.z * p.z), away = rho - torus->major;
    double tube = sqrt(away * away + p.y * p.y);
    bool sound = rho > 0 && tube > 0;
    make_point(torus, sound ? p.x / rho : 0, sound ? p.z / rho : 1, sound ? away / tube : 1,
               sound ? p.y / tube : 0, out);
}

static void parametrise(const void *desc, surface *s) {
    const torus_desc *torus = desc;
    axes frame = axes_of(torus);
    dvec3 p = to_axes(&frame, dvec3_sub(s->p, dvec3_from(torus->center)));
    double rho = sqrt(p.x * p.x + p.z * p.z), away = rho - torus->major;
    s->u = 0.5 + fn_atan2(p.x, p.z) / (2 * PI);
    s->v = 0.5 + fn_atan2(p.y, away) / (2 * PI);
    s->dpdu = from_axes(&frame, (dvec3){2 * PI * p.z, 0, -2 * PI * p.x});
    dvec3 along = {-p.y * p.x / rho, away, -p.y * p.z / rho};
    s->dpdv = from_axes(&frame, dvec3_scale(along, 2 * PI));
}

static int side(const void *desc, dvec3 p) {
    const torus_desc *torus = desc;
    axes frame = axes_of(torus);
    dvec3 at = to_axes(&frame, dvec3_sub(p, dvec3_from(torus->center)));
    double away = sqrt(at.x * at.x + at.z * at.z) - torus->major, minor = torus->minor;
    return away * away + at.y * at.y < minor * minor ? 1 : -1;
}

/* ---- sampling ---- */

static double area(const void *desc, uint32_t primitive) {
    (void)primitive;
    const torus_desc *torus = desc;
    return 4 * PI * PI * torus->major * torus->minor;
}

typedef struct tube_share {
    double ratio, turn;
} tube_share;

static double value_of_share(const void *data, double angle, double *slope) {
    const tube_share *share = data;
    *slope = 1 + share->ratio * fn_cos(angle);
    return angle + share->ratio * fn_sin(angle) - share->turn;
}

/* The density around the tube is 1 + (minor / major) cos(angle): its integral is inverted by search.
 */
static void sample_area(const void *desc, uint32_t primitive, double u, double v, surface *out) {
    (void)primitive;
    const torus_desc *torus = desc;
    tube_share share = {(double)torus->minor / (double)torus->major, 2 * PI * (u - 0.5)};
    double tube = refine(value_of_share, &share, -PI, PI, false), around = 2 * PI * (v - 0.5);
    make_point(torus, fn_sin(around), fn_cos(around), fn_cos(tube), fn_sin(tube), out);
}

extern const primitive_type primitive_torus;
const primitive_type primitive_torus = {
    .info = TYPE_INFO(CATEGORY_SHAPE, torus, "torus", "a ring with a round tube"),
    .check = check,
    .bounds = bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .parametrise = parametrise,
    .side = side,
    .spans = spans,
    .area = area,
    .sample_area = sample_area,
};
