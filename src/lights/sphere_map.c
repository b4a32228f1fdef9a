#include "lights/sphere_map.h"

#include <stdlib.h>

#include "base/memory.h"
#include "lights/light.h"
#include "maths/functions.h"

dvec3 sphere_map_direction(double u, double v) {
    double polar = (1 - v) * PI, turn = (u - 0.5) * (2 * PI), s = fn_sin(polar);
    return (dvec3){s * fn_sin(turn), fn_cos(polar), -s * fn_cos(turn)};
}

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

/* The mean luminance of a cell. */
static double look_at_cell(sphere_map *map, uint32_t x, uint32_t y, uint32_t detail,
                           double solid_angle, sphere_radiance_fn *radiance, const void *user) {
    double sum = 0, share = 1.0 / ((double)detail * detail);
    for (uint32_t j = 0; j < detail; j++)
        for (uint32_t i = 0; i < detail; i++) {
            double u = (x + (i + 0.5) / detail) / map->width,
                   v = 1 - (y + (j + 0.5) / detail) / map->height;
            dvec3 d = sphere_map_direction(u, v), l = radiance(user, d);
            add_direction(map, d, l, solid_angle * share);
            sum += LUMINANCE(l) * share;
        }
    return sum;
}

/* From sums to a distribution function that ends in 1, or stays 0. */
static void normalise(double *cdf, size_t count) {
    if (!(cdf[count] > 0)) return;
    for (size_t i = 0; i < count; i++) cdf[i] /= cdf[count];
    cdf[count] = 1;
}

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

static double row_solid_angle(const sphere_map *map, uint32_t y) { /* of one cell */
    return (edge_cosine(map, y) - edge_cosine(map, y + 1)) * (2 * PI / map->width);
}

static void fill_distributions(sphere_map *map, const double *luminance, bool spills) {
    for (uint32_t y = 0; y < map->height; y++) {
        double *cells = map->cells + (size_t)y * (map->width + 1);
        for (uint32_t x = 0; x < map->width; x++) {
            double l = luminance[(size_t)y * map->width + x];
            if (spills) l = double_max(l, SPILL * brightest_near(map, luminance, x, y));
            cells[x + 1] = cells[x] + l;
        }
        map->rows[y + 1] = map->rows[y] + cells[map->width] * row_solid_angle(map, y);
        normalise(cells, map->width);
    }
    normalise(map->rows, map->height);
}

snell_status sphere_map_build(uint32_t width, uint32_t height, uint32_t detail, bool spills,
                              sphere_radiance_fn *radiance, const void *user, sphere_map *out) {
    *out = (sphere_map){.width = width, .height = height};
    double *luminance = memory_resize(NULL, (size_t)width * height, sizeof *luminance);
    out->rows = memory_zeroed((size_t)height + 1, sizeof *out->rows);
    out->cells = memory_zeroed((size_t)height * (width + 1), sizeof *out->cells);
    if (!luminance || !out->rows || !out->cells) {
        free(luminance);
        sphere_map_free(out);
        return error_no_memory();
    }
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            luminance[(size_t)y * width + x] =
                look_at_cell(out, x, y, detail, row_solid_angle(out, y), radiance, user);
    fill_distributions(out, luminance, spills);
    free(luminance);
    return SNELL_OK;
}

void sphere_map_free(sphere_map *map) {
    free(map->rows);
    free(map->cells);
    *map = (sphere_map){0};
}

/* The interval of the distribution function that u lies in, and where in it, in [0,1). */
static uint32_t find_interval(const double *cdf, uint32_t count, double u, double *within) {
    uint32_t low = 0, high = count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (cdf[middle] <= u)
            low = middle;
        else
            high = middle;
    }
    double width = cdf[low + 1] - cdf[low];
    *within = width > 0 ? (u - cdf[low]) / width : 0.5;
    return low;
}

/* Within a cell directions are uniform in longitude and in the cosine of the polar angle, that is
 * in solid angle. */
static double cell_pdf(const sphere_map *map, uint32_t x, uint32_t y) {
    const double *cells = map->cells + (size_t)y * (map->width + 1);
    double chance = (map->rows[y + 1] - map->rows[y]) * (cells[x + 1] - cells[x]);
    return chance / row_solid_angle(map, y);
}

bool sphere_map_sample(const sphere_map *map, sample2 u, dvec3 *d, double *pdf) {
    if (!(map->rows[map->height] > 0)) return false;
    double across, down;
    uint32_t y = find_interval(map->rows, map->height, u.y, &down);
    uint32_t x = find_interval(map->cells + (size_t)y * (map->width + 1), map->width, u.x, &across);
    double top = edge_cosine(map, y), bottom = edge_cosine(map, y + 1);
    double cosine = top + (bottom - top) * down, sine = sqrt(double_max(0, 1 - cosine * cosine));
    double turn = ((x + across) / map->width - 0.5) * (2 * PI);
    *d = (dvec3){sine * fn_sin(turn), cosine, -sine * fn_cos(turn)};
    *pdf = cell_pdf(map, x, y);
    return *pdf > 0;
}

double sphere_map_pdf(const sphere_map *map, dvec3 d) {
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
