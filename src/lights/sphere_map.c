#include "lights/sphere_map.h"

#include <stdlib.h>

#include "base/memory.h"
#include "lights/light.h"
#include "maths/functions.h"
#include "sampling/warp.h"

void sphere_map_coordinates(dvec3 d, double *u, double *v) {
    double height = d.y < -1 ? -1 : d.y > 1 ? 1 : d.y;
    double turn = 0.5 + fn_atan2(d.x, -d.z) / (2 * PI);
    *u = turn < 0 || turn >= 1 ? 0 : turn;
    *v = 1 - fn_acos(height) / PI;
}

/* The cosine of the polar angle at the upper edge of a row. */
static double edge_cosine(const sphere_map *map, uint32_t row) {
    return row == 0 ? 1 : row == map->height ? -1 : fn_cos(PI * row / map->height);
}

static double row_solid_angle(const sphere_map *map, uint32_t y) { /* of one cell */
    return (edge_cosine(map, y) - edge_cosine(map, y + 1)) * (2 * PI / map->width);
}

/* What of the sphere each direction stands for in row j of those in a row of cells. */
static double direction_solid_angle(const sphere_grid *g, uint32_t y, uint32_t j) {
    uint32_t rows = g->height * g->detail, row = y * g->detail + j;
    double top = row == 0 ? 1 : fn_cos(PI * row / rows),
           bottom = row + 1 == rows ? -1 : fn_cos(PI * (row + 1) / rows);
    return (top - bottom) * (2 * PI / g->width / g->detail);
}

static void harmonics_at(dvec3 d, double y[9]) {
    y[0] = 0.28209479177387814;
    y[1] = 0.4886025119029199 * d.y;
    y[2] = 0.4886025119029199 * d.z;
    y[3] = 0.4886025119029199 * d.x;
    y[4] = 1.0925484305920792 * d.x * d.y;
    y[5] = 1.0925484305920792 * d.y * d.z;
    y[6] = 0.31539156525252005 * (3 * d.z * d.z - 1);
    y[7] = 1.0925484305920792 * d.x * d.z;
    y[8] = 0.5462742152960396 * (d.x * d.x - d.y * d.y);
}

/* Adds a direction's share of the integrals over the sphere. */
static void add_direction(sphere_map *map, dvec3 d, dvec3 radiance, double solid_angle) {
    double y[9];
    harmonics_at(d, y);
    for (int i = 0; i < 9; i++)
        map->harmonics[i] = dvec3_add(map->harmonics[i], dvec3_scale(radiance, y[i] * solid_angle));
    map->mean = dvec3_add(map->mean, dvec3_scale(radiance, solid_angle / (4 * PI)));
}

/* ---- looking around ---- */

typedef struct survey {
    const sphere_grid *grid;
    sphere_radiance_fn *radiance;
    const void *user;
    double *turns;     /* sine and cosine of the longitude of each column of directions */
    dvec3 *seen;       /* radiance, of some rows: by row, cell, then direction in the cell */
    double *luminance; /* of every cell, the mean */
    uint32_t first_row;
} survey;

/* A row of directions, by its polar angle. */
typedef struct latitude {
    double cosine, sine;
} latitude;

static latitude latitude_of(const sphere_grid *g, uint32_t y, uint32_t j) {
    double v = 1 - (y + (j + 0.5) / g->detail) / g->height, polar = (1 - v) * PI;
    return (latitude){fn_cos(polar), fn_sin(polar)};
}

static dvec3 direction_at(const survey *s, latitude at, uint32_t x, uint32_t i) {
    const double *turn = s->turns + 2 * ((size_t)x * s->grid->detail + i);
    return (dvec3){at.sine * turn[0], at.cosine, -at.sine * turn[1]};
}

static void fill_turns(survey *s) {
    const sphere_grid *g = s->grid;
    for (uint32_t x = 0; x < g->width; x++)
        for (uint32_t i = 0; i < g->detail; i++) {
            double u = (x + (i + 0.5) / g->detail) / g->width, turn = (u - 0.5) * (2 * PI);
            double *out = s->turns + 2 * ((size_t)x * g->detail + i);
            out[0] = fn_sin(turn);
            out[1] = fn_cos(turn);
        }
}

static size_t row_size(const sphere_grid *g) { /* in directions */
    return (size_t)g->width * g->detail * g->detail;
}

static void look_at_row(void *data, size_t index, uint32_t worker) {
    (void)worker;
    const survey *s = data;
    const sphere_grid *g = s->grid;
    uint32_t y = s->first_row + (uint32_t)index;
    double share = 1.0 / ((double)g->detail * g->detail);
    for (uint32_t j = 0; j < g->detail; j++) {
        latitude at = latitude_of(g, y, j);
        for (uint32_t x = 0; x < g->width; x++) {
            dvec3 *out = s->seen + index * row_size(g) + ((size_t)x * g->detail + j) * g->detail;
            double *sum = &s->luminance[(size_t)y * g->width + x];
            for (uint32_t i = 0; i < g->detail; i++) {
                out[i] = s->radiance(s->user, direction_at(s, at, x, i));
                *sum += LUMINANCE(out[i]) * share;
            }
        }
    }
}

/* Always in the same order, so that sums do not depend on the threads. */
static void add_row(const survey *s, size_t index, sphere_map *map) {
    const sphere_grid *g = s->grid;
    uint32_t y = s->first_row + (uint32_t)index;
    const dvec3 *seen = s->seen + index * row_size(g);
    for (uint32_t x = 0; x < g->width; x++)
        for (uint32_t j = 0; j < g->detail; j++) {
            latitude at = latitude_of(g, y, j);
            double share = direction_solid_angle(g, y, j);
            for (uint32_t i = 0; i < g->detail; i++, seen++) {
                add_direction(map, direction_at(s, at, x, i), *seen, share);
                map->brightest = double_max(map->brightest, dvec3_largest(*seen));
            }
        }
}

static snell_status look_around(survey *s, thread_pool *pool, sphere_map *map) {
    enum { DIRECTIONS_AT_ONCE = 1 << 20 };
    const sphere_grid *g = s->grid;
    size_t rows = DIRECTIONS_AT_ONCE / row_size(g) + 1, columns = (size_t)g->width * g->detail;
    if (rows > g->height) rows = g->height;
    s->turns = memory_resize(NULL, 2 * columns, sizeof *s->turns);
    s->seen = memory_resize(NULL, rows * row_size(g), sizeof *s->seen);
    bool ready = s->turns && s->seen;
    if (ready) fill_turns(s);
    for (uint32_t y = 0; y < g->height && ready; y += (uint32_t)rows) {
        size_t count = g->height - y < rows ? g->height - y : rows;
        s->first_row = y;
        thread_pool_run(pool, count, look_at_row, s);
        for (size_t i = 0; i < count; i++) add_row(s, i, map);
    }
    free(s->turns);
    free(s->seen);
    return ready ? SNELL_OK : error_no_memory();
}

/* ---- the distribution ---- */

/* A cell is drawn at least so often, by the brightest of those that touch it: what is bright may reach
 * into it between the directions that were looked at. */
static const double SPILL = 1.0 / 16;

static double brightest_near(const sphere_map *map, const double *luminance, uint32_t x,
                             uint32_t y) {
    double brightest = 0;
    for (uint32_t j = y > 0 ? y - 1 : 0; j <= y + 1 && j < map->height; j++)
        for (uint32_t i = 0; i < 3; i++) {
            uint32_t column = (x + map->width - 1 + i) % map->width;
            brightest = double_max(brightest, luminance[(size_t)j * map->width + column]);
        }
    return brightest;
}

/* weights: room for a row and for a column. */
static void fill_distributions(sphere_map *map, const double *luminance, bool spills,
                               double *weights) {
    double *rows = weights + map->width;
    for (uint32_t y = 0; y < map->height; y++) {
        double *cells = map->cells + (size_t)y * (map->width + 1), sum = 0;
        for (uint32_t x = 0; x < map->width; x++) {
            double l = luminance[(size_t)y * map->width + x];
            if (spills) l = double_max(l, SPILL * brightest_near(map, luminance, x, y));
            sum += weights[x] = l;
        }
        distribution1_fill(weights, map->width, cells);
        rows[y] = sum * row_solid_angle(map, y);
    }
    map->black = !distribution1_fill(rows, map->height, map->rows);
}

snell_status sphere_map_build(const sphere_grid *grid, thread_pool *pool,
                              sphere_radiance_fn *radiance, const void *user, sphere_map *out) {
    size_t width = grid->width, height = grid->height;
    *out = (sphere_map){.width = grid->width, .height = grid->height};
    double *luminance = memory_zeroed(width * height, sizeof *luminance);
    double *weights = memory_resize(NULL, width + height, sizeof *weights);
    out->rows = memory_resize(NULL, height + 1, sizeof *out->rows);
    out->cells = memory_resize(NULL, height * (width + 1), sizeof *out->cells);
    snell_status status = SNELL_OK;
    if (!luminance || !weights || !out->rows || !out->cells) status = error_no_memory();
    survey s = {grid, radiance, user, NULL, NULL, luminance, 0};
    if (!status) status = look_around(&s, pool, out);
    if (!status) fill_distributions(out, luminance, grid->spills, weights);
    if (status) sphere_map_free(out);
    free(luminance);
    free(weights);
    return status;
}

void sphere_map_free(sphere_map *map) {
    free(map->rows);
    free(map->cells);
    *map = (sphere_map){0};
}

/* Within a cell directions are uniform in longitude and in the cosine of the polar angle, that is
 * in solid angle. */
static double cell_pdf(const sphere_map *map, uint32_t x, uint32_t y) {
    const double *cells = map->cells + (size_t)y * (map->width + 1);
    double chance = (map->rows[y + 1] - map->rows[y]) * (cells[x + 1] - cells[x]);
    return chance / row_solid_angle(map, y);
}

bool sphere_map_sample(const sphere_map *map, sample2 u, dvec3 *d, double *pdf) {
    if (map->black) return false;
    double across, down;
    uint32_t y = distribution1_find(map->rows, map->height, u.y, &down);
    const double *cells = map->cells + (size_t)y * (map->width + 1);
    uint32_t x = distribution1_find(cells, map->width, u.x, &across);
    double top = edge_cosine(map, y), bottom = edge_cosine(map, y + 1);
    double cosine = top + (bottom - top) * down, sine = sqrt(double_max(0, 1 - cosine * cosine));
    double turn = ((x + across) / map->width - 0.5) * (2 * PI);
    *d = (dvec3){sine * fn_sin(turn), cosine, -sine * fn_cos(turn)};
    *pdf = cell_pdf(map, x, y);
    return *pdf > 0;
}

double sphere_map_pdf(const sphere_map *map, dvec3 d) {
    if (map->black) return 0;
    double u, v;
    sphere_map_coordinates(d, &u, &v);
    uint32_t x = (uint32_t)(u * map->width), y = (uint32_t)((1 - v) * map->height);
    if (x >= map->width) x = map->width - 1;
    if (y >= map->height) y = map->height - 1;
    return cell_pdf(map, x, y);
}

dvec3 sphere_map_irradiance(const sphere_map *map, dvec3 n) {
    static const double of_order[9] = {PI,     2 * PI / 3, 2 * PI / 3, 2 * PI / 3, PI / 4,
                                       PI / 4, PI / 4,     PI / 4,     PI / 4};
    double y[9];
    harmonics_at(n, y);
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < 9; i++)
        sum = dvec3_add(sum, dvec3_scale(map->harmonics[i], of_order[i] * y[i]));
    return (dvec3){double_max(sum.x, 0), double_max(sum.y, 0), double_max(sum.z, 0)};
}
