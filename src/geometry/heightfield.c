/* A terrain: a grid of posts with a height each. Every cell is two triangles that meet along the
 * diagonal from its corner of least x and z to that of most.
 *
 * It keeps to 4 bytes a post, and some 50 for each cell's share of the tree: a mesh of the same
 * triangles takes three times as much. Both triangles of a cell are tested in double by the edge
 * functions of Woop, Benthin and Wald (Watertight Ray/Triangle Intersection, JCGT 2(1), 2013): the two
 * sides of an edge compute the same number but for its sign, so nothing falls between them. Texture
 * coordinates: u along x and v against z, 0 to 1: a picture whose first row lies at the least z. */
#include "base/error.h"
#include "geometry/surface.h"
#include "sampling/warp.h"

#define HEIGHTFIELD_FIELDS(F, T)                                                                   \
    F(T, heights, FLOATS, NO_DEFAULT, REQUIRED, "",                                                \
      "rows of posts, from the least z on; 0 is min's y, 1 is max's")                              \
    F(T, columns, INT, NO_DEFAULT, REQUIRED_RANGE(2, 65536), "", "posts in a row, along x")        \
    F(T, rows, INT, NO_DEFAULT, REQUIRED_RANGE(2, 65536), "", "rows, along z")                     \
    F(T, min, VEC3, DEFAULT(0, 0, 0), ANY, "m", "the corner of the first post")                    \
    F(T, max, VEC3, DEFAULT(1, 1, 1), ANY, "m", "the corner of the last post")                     \
    F(T, smooth, BOOL, DEFAULT(1), ANY, "", "blend the shading normals over the cells")
DESCRIBE(heightfield, HEIGHTFIELD_FIELDS)

#define CELLS_MAX ((size_t)1 << 28)

static snell_status check(const void *desc) {
    const heightfield_desc *terrain = desc;
    size_t columns = (size_t)terrain->columns, rows = (size_t)terrain->rows;
    if (terrain->heights_count != columns * rows)
        return error_set(SNELL_ERR_ARGUMENT, "one height per post",
                         "heightfield: 'heights' has %zu entries for %zu x %zu posts",
                         terrain->heights_count, columns, rows);
    if (columns * rows > CELLS_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "split it into several shapes",
                         "heightfield: %zu x %zu posts are too many", columns, rows);
    if (!(terrain->min.x < terrain->max.x && terrain->min.z < terrain->max.z))
        return error_set(SNELL_ERR_ARGUMENT, "x and z of 'min' must be less than those of 'max'",
                         "heightfield: the size is %g x %g",
                         (double)terrain->max.x - (double)terrain->min.x,
                         (double)terrain->max.z - (double)terrain->min.z);
    return SNELL_OK;
}

static dvec3 post_at(const heightfield_desc *terrain, size_t column, size_t row) {
    dvec3 low = dvec3_from(terrain->min), high = dvec3_from(terrain->max);
    double height = (double)terrain->heights[row * (size_t)terrain->columns + column];
    double across = (double)column / (terrain->columns - 1),
           along = (double)row / (terrain->rows - 1);
    return (dvec3){low.x + (high.x - low.x) * across, low.y + (high.y - low.y) * height,
                   low.z + (high.z - low.z) * along};
}

/* Posts 0 and 3 are the ends of the diagonal, 1 is across x from 0, 2 across z. */
typedef struct cell {
    size_t column, row;
    dvec3 post[4];
} cell;
/* Counter-clockwise from above. */
static const int corners[2][3] = {{0, 3, 1}, {0, 2, 3}};

static cell cell_at(const heightfield_desc *terrain, uint32_t part) {
    size_t width = (size_t)terrain->columns - 1;
    cell c = {.column = part % width, .row = part / width};
    for (size_t i = 0; i < 4; i++) c.post[i] = post_at(terrain, c.column + i % 2, c.row + i / 2);
    return c;
}

static uint32_t primitive_count(const void *desc) {
    const heightfield_desc *terrain = desc;
    return ((uint32_t)terrain->columns - 1) * ((uint32_t)terrain->rows - 1);
}

/* Wider by a few float roundings: a ray that meets the edge of a flat cell must not miss the box. */
static bounds3 box_of(dvec3 low, dvec3 high) {
    dvec3 size = {double_max(fabs(low.x), fabs(high.x)), double_max(fabs(low.y), fabs(high.y)),
                  double_max(fabs(low.z), fabs(high.z))};
    double wider = 4 * FLOAT_EPSILON * dvec3_largest(size);
    dvec3 margin = {wider, wider, wider};
    return bounds3_outward(dvec3_sub(low, margin), dvec3_add(high, margin));
}

static bounds3 primitive_bounds(const void *desc, uint32_t part) {
    cell c = cell_at(desc, part);
    dvec3 low = c.post[0], high = c.post[3];
    for (int i = 0; i < 4; i++) {
        low.y = double_min(low.y, c.post[i].y);
        high.y = double_max(high.y, c.post[i].y);
    }
    return box_of(low, high);
}

static bounds3 bounds(const void *desc) {
    const heightfield_desc *terrain = desc;
    size_t columns = (size_t)terrain->columns, last = (size_t)terrain->rows - 1;
    dvec3 low = post_at(terrain, 0, 0), high = post_at(terrain, columns - 1, last);
    double least = (double)terrain->heights[0], most = least;
    for (size_t i = 1; i < terrain->heights_count; i++) {
        least = double_min(least, (double)terrain->heights[i]);
        most = double_max(most, (double)terrain->heights[i]);
    }
    double base = (double)terrain->min.y, size = (double)terrain->max.y - base;
    low.y = double_min(base + size * least, base + size * most);
    high.y = double_max(base + size * least, base + size * most);
    return box_of(low, high);
}

/* ---- rays ---- */

/* A ray along the axis of its largest |d|, which is z here; x, y: how it leans. */
typedef struct shear {
    int x_axis, y_axis, z_axis;
    double x, y, z;
} shear;

static double axis_of(dvec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static shear shear_of(dvec3 d) {
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    int k = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    shear s = {.x_axis = (k + 1) % 3, .y_axis = (k + 2) % 3, .z_axis = k};
    s.z = 1 / axis_of(d, k);
    s.x = axis_of(d, s.x_axis) * s.z;
    s.y = axis_of(d, s.y_axis) * s.z;
    return s;
}

/* Where the ray's line meets one of a cell's triangles: t, and the weights of its corners. */
typedef struct meeting {
    double t, weight[3];
    int triangle;
} meeting;

/* How many triangles are met, in ascending order of t. */
static int solve(const cell *c, const local_ray *beam, meeting list[2]) {
    dvec3 o = dvec3_from(beam->o), at[4];
    shear s = shear_of(dvec3_from(beam->d));
    for (int i = 0; i < 4; i++) { /* the same numbers for a post in every cell that has it */
        dvec3 f = dvec3_sub(c->post[i], o);
        double z = axis_of(f, s.z_axis);
        at[i] = (dvec3){axis_of(f, s.x_axis) - s.x * z, axis_of(f, s.y_axis) - s.y * z, s.z * z};
    }
    int count = 0;
    for (int k = 0; k < 2; k++) {
        double w[3];
        for (int i = 0; i < 3; i++) {
            dvec3 a = at[corners[k][(i + 1) % 3]], b = at[corners[k][(i + 2) % 3]];
            w[i] = a.x * b.y - a.y * b.x;
        }
        if ((w[0] < 0 || w[1] < 0 || w[2] < 0) && (w[0] > 0 || w[1] > 0 || w[2] > 0)) continue;
        double sum = w[0] + w[1] + w[2];
        if (!(sum != 0)) continue; /* seen edge-on: its neighbours are met */
        meeting m = {.triangle = k};
        for (int i = 0; i < 3; i++) {
            m.weight[i] = w[i] / sum;
            m.t += m.weight[i] * at[corners[k][i]].z;
        }
        list[count++] = m;
    }
    if (count == 2 && list[1].t < list[0].t) {
        meeting swap = list[0];
        list[0] = list[1];
        list[1] = swap;
    }
    return count;
}

static bool intersect(const void *desc, const local_ray *beam, hit *found) {
    cell c = cell_at(desc, found->primitive);
    meeting list[2];
    int count = solve(&c, beam, list);
    for (int i = 0; i < count; i++) {
        if (!surface_accept(beam, list[i].t, &found->t)) continue;
        const double *w = list[i].weight; /* u, v: across the cell, for `bend` */
        found->u = (float)(list[i].triangle ? w[2] : w[1] + w[2]);
        found->v = (float)(list[i].triangle ? w[1] + w[2] : w[1]);
        return true;
    }
    return false;
}

/* ---- points ---- */

/* By the slopes to the posts on both sides; not unit. */
static dvec3 post_normal(const heightfield_desc *terrain, size_t column, size_t row) {
    size_t last_column = (size_t)terrain->columns - 1, last_row = (size_t)terrain->rows - 1;
    dvec3 west = post_at(terrain, column ? column - 1 : 0, row);
    dvec3 east = post_at(terrain, column < last_column ? column + 1 : column, row);
    dvec3 north = post_at(terrain, column, row ? row - 1 : 0);
    dvec3 south = post_at(terrain, column, row < last_row ? row + 1 : row);
    return (dvec3){-(east.y - west.y) / (east.x - west.x), 1,
                   -(south.y - north.y) / (south.z - north.z)};
}

static dvec3 corner_normal(const heightfield_desc *terrain, const cell *c, int corner) {
    size_t i = (size_t)corner;
    return dvec3_normalize(post_normal(terrain, c->column + i % 2, c->row + i / 2));
}

static void make_point(const heightfield_desc *terrain, const cell *c, const meeting *at,
                       surface *out) {
    dvec3 corner[3], p = {0, 0, 0}, ns = {0, 0, 0};
    double largest = 0;
    for (int i = 0; i < 3; i++) {
        corner[i] = c->post[corners[at->triangle][i]];
        p = dvec3_add(p, dvec3_scale(corner[i], at->weight[i]));
        dvec3 size = {fabs(corner[i].x), fabs(corner[i].y), fabs(corner[i].z)};
        largest = double_max(largest, dvec3_largest(size));
    }
    dvec3 n = dvec3_cross(dvec3_sub(corner[1], corner[0]), dvec3_sub(corner[2], corner[0]));
    n = dvec3_normalize(n);
    *out = surface_make(p, n, 64 * DOUBLE_EPSILON * largest);
    double width = (double)terrain->max.x - (double)terrain->min.x;
    double depth = (double)terrain->max.z - (double)terrain->min.z;
    out->u = clamp01((p.x - (double)terrain->min.x) / width);
    out->v = clamp01(((double)terrain->max.z - p.z) / depth);
    out->dpdu = (dvec3){width, -width * n.x / n.y, 0};
    out->dpdv = (dvec3){0, depth * n.z / n.y, -depth};
    if (!terrain->smooth) return;
    for (int i = 0; i < 3; i++) {
        dvec3 normal = corner_normal(terrain, c, corners[at->triangle][i]);
        ns = dvec3_add(ns, dvec3_scale(normal, at->weight[i]));
    }
    ns = dvec3_normalize(ns);
    if (dvec3_dot(ns, n) > 0) out->ns = ns;
}

/* The blended normal's change, before it is made unit, is a sum of the corners' normals. */
static dvec3 bend(const void *desc, const hit *found, dvec3 dp) {
    const heightfield_desc *terrain = desc;
    if (!terrain->smooth) return (dvec3){0, 0, 0};
    cell c = cell_at(terrain, found->primitive);
    double x = clamp01((double)found->u), z = clamp01((double)found->v);
    double dx = dp.x / (c.post[1].x - c.post[0].x), dz = dp.z / (c.post[2].z - c.post[0].z);
    int k = x < z;
    const double weight[3] = {1 - (k ? z : x), k ? z - x : z, k ? x : x - z};
    const double step[3] = {-(k ? dz : dx), k ? dz - dx : dz, k ? dx : dx - dz};
    dvec3 sum = {0, 0, 0}, change = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        dvec3 normal = corner_normal(terrain, &c, corners[k][i]);
        sum = dvec3_add(sum, dvec3_scale(normal, weight[i]));
        change = dvec3_add(change, dvec3_scale(normal, step[i]));
    }
    double length = dvec3_length(sum); /* normals point up: they do not cancel */
    sum = dvec3_scale(sum, 1 / length);
    change = dvec3_sub(change, dvec3_scale(sum, dvec3_dot(sum, change)));
    return dvec3_scale(change, 1 / length);
}

static meeting nearest_meeting(const cell *c, const local_ray *beam, const hit *found) {
    meeting list[2], best = {.weight = {1, 0, 0}};
    int count = solve(c, beam, list);
    for (int i = 0; i < count; i++)
        if (i == 0 || fabs(list[i].t - (double)found->t) < fabs(best.t - (double)found->t))
            best = list[i];
    return best;
}

static void fill_surface(const void *desc, const local_ray *beam, const hit *found, surface *out) {
    cell c = cell_at(desc, found->primitive);
    meeting at = nearest_meeting(&c, beam, found);
    make_point(desc, &c, &at, out);
}

/* ---- sampling ---- */

static double triangle_area(const cell *c, int k) {
    dvec3 a = c->post[corners[k][0]], b = c->post[corners[k][1]], e = c->post[corners[k][2]];
    return dvec3_length(dvec3_cross(dvec3_sub(b, a), dvec3_sub(e, a))) / 2;
}

static double area(const void *desc, uint32_t part) {
    cell c = cell_at(desc, part);
    return triangle_area(&c, 0) + triangle_area(&c, 1);
}

static void sample_area(const void *desc, uint32_t part, double u, double v, surface *out) {
    cell c = cell_at(desc, part);
    double first = triangle_area(&c, 0), share = first / (first + triangle_area(&c, 1));
    meeting at = {.triangle = u >= share};
    u = at.triangle ? (u - share) / (1 - share) : u / share;
    sample2 place = warp_triangle((sample2){clamp01(u), v});
    at.weight[0] = 1 - place.x - place.y;
    at.weight[1] = place.x;
    at.weight[2] = place.y;
    make_point(desc, &c, &at, out);
}

extern const primitive_type primitive_heightfield;
const primitive_type primitive_heightfield = {
    .info = TYPE_INFO(CATEGORY_SHAPE, heightfield, "heightfield", "a terrain over a grid of posts"),
    .check = check,
    .bounds = bounds,
    .primitive_count = primitive_count,
    .primitive_bounds = primitive_bounds,
    .intersect = intersect,
    .surface = fill_surface,
    .area = area,
    .sample_area = sample_area,
    .bend = bend,
};
