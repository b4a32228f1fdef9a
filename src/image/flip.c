/* The two-dimensional filters of the paper are products of one-dimensional ones (those of the
 * blue-yellow channel: sums of two products), so rows are filtered first, then columns. Tiles of
 * the picture are worked on one by one, each with the rows and columns around it that the filters
 * reach; beyond its edge the picture goes on as it is there. */
#include "image/flip.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "maths/functions.h"
#include "maths/vec.h"

/* Table 1 and sections 3 and 4 of the paper. */
static const double Q_C = 0.7, P_C = 0.4, P_T = 0.95, FEATURE_WIDTH = 0.082;

enum { TILE_WIDTH = 256, TILE_HEIGHT = 64, EXPOSURES_MAX = 32 };

/* What a row is filtered to: luminance and the two chrominances as contrast sensitivity asks, and
 * first derivative, second derivative and mean of the luminance. */
enum plane { LUMINANCE, RED_GREEN, BLUE_YELLOW, BLUE_YELLOW_WIDE, EDGE, POINT, SMOOTH, PLANES };
enum { COLOR_PLANES = EDGE };

typedef struct kernel {
    int reach;      /* pixels to each side */
    float *weights; /* 2 * reach + 1 */
} kernel;

typedef struct flip_job {
    const flip_picture *pictures; /* two */
    const flip_options *options;
    float *map;
    kernel kernels[PLANES];
    int reach; /* the largest */
    double color_max;
    double exposures[EXPOSURES_MAX]; /* factors; only for HDR */
    uint32_t exposure_count;
    uint32_t tiles_x, tiles_y;
    float **scratch; /* one for each worker */
    atomic_size_t done;
    atomic_bool stop, no_memory;
} flip_job;

/* ---- colours: CIE 1976 with D65 ---- */

static const double white[3] = {0.950428545, 1, 1.088900371};

/* Divided by white. */
static dvec3 xyz_from_rgb(dvec3 c) {
    const double a = 24577794, b = 12288897, d = 73733382;
    return (dvec3){(10135552 * c.x + 8788810 * c.y + 4435075 * c.z) / (a * white[0]),
                   (2613072 * c.x + 8788810 * c.y + 887015 * c.z) / b,
                   (1425312 * c.x + 8788810 * c.y + 70074185 * c.z) / (d * white[2])};
}

static dvec3 rgb_from_xyz(dvec3 c) {
    double x = c.x * white[0], y = c.y, z = c.z * white[2];
    return (dvec3){clamp01(3.241003275 * x - 1.537398934 * y - 0.498615861 * z),
                   clamp01(-0.969224334 * x + 1.875930071 * y + 0.041554224 * z),
                   clamp01(0.055639423 * x - 0.204011202 * y + 1.057148933 * z)};
}

/* L*a*b* and the linear YCxCz differ in what is done to each of X, Y, Z. */
static dvec3 opponent(double x, double y, double z) {
    return (dvec3){116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

static double lab_curve(double t) {
    const double delta = 6.0 / 29;
    return t > delta * delta * delta ? fn_cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
}

/* L*a*b* after Hunt: colours count less where it is dark. */
static dvec3 perceived(dvec3 rgb) {
    dvec3 xyz = xyz_from_rgb(rgb);
    dvec3 lab = opponent(lab_curve(xyz.x), lab_curve(xyz.y), lab_curve(xyz.z));
    return (dvec3){lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z};
}

/* HyAB: city block for luminance, Euclid for colour. */
static double color_distance(dvec3 a, dvec3 b) {
    double y = a.y - b.y, z = a.z - b.z;
    return fabs(a.x - b.x) + sqrt(y * y + z * z);
}

/* Small differences take the range up to P_T. */
static double color_error(const flip_job *j, double distance) {
    double error = distance > 0 ? fn_pow(distance, Q_C) : 0, knee = P_C * j->color_max;
    if (error < knee) return error * P_T / knee;
    return P_T + (error - knee) / (j->color_max - knee) * (1 - P_T);
}

/* ---- filters ---- */

static bool kernel_create(kernel *k, double reach) {
    k->reach = (int)ceil(reach);
    k->weights = memory_zeroed(2 * (size_t)k->reach + 1, sizeof *k->weights);
    return k->weights != NULL;
}

/* The contrast sensitivity's Gaussian in degrees, a sqrt(pi / b) exp(-pi^2 x^2 / b) in two
 * dimensions: its root in each. Returns the sum. */
static double fill_sensitivity(kernel *k, double ppd, double a, double b) {
    double sum = 0;
    for (int i = -k->reach; i <= k->reach; i++) {
        double x = i / ppd, w = sqrt(a * sqrt(PI / b)) * fn_exp(-PI * PI * x * x / b);
        k->weights[i + k->reach] = (float)w;
        sum += w;
    }
    return sum;
}

static void kernel_scale(kernel *k, double factor) {
    for (int i = 0; i <= 2 * k->reach; i++) k->weights[i] = (float)((double)k->weights[i] * factor);
}

static void make_sensitivity(flip_job *j, double ppd) {
    static const double a[] = {1, 1, 34.1, 13.5}, b[] = {0.0047, 0.0053, 0.04, 0.025};
    double sums[COLOR_PLANES];
    for (int p = 0; p < COLOR_PLANES; p++)
        sums[p] = fill_sensitivity(&j->kernels[p], ppd, a[p], b[p]);
    double both = sqrt(sums[2] * sums[2] + sums[3] * sums[3]);
    for (int p = 0; p < COLOR_PLANES; p++)
        kernel_scale(&j->kernels[p], 1 / (p < BLUE_YELLOW ? sums[p] : both));
}

/* Positive and negative weights sum to 1 and -1. */
static void balance(kernel *k) {
    double plus = 0, minus = 0;
    for (int i = 0; i <= 2 * k->reach; i++) {
        double w = (double)k->weights[i];
        if (w > 0)
            plus += w;
        else
            minus -= w;
    }
    for (int i = 0; i <= 2 * k->reach; i++) {
        double w = (double)k->weights[i];
        k->weights[i] = (float)(w / (w > 0 ? plus : minus > 0 ? minus : 1));
    }
}

static void make_features(flip_job *j, double deviation) {
    int reach = j->kernels[EDGE].reach;
    for (int i = -reach; i <= reach; i++) {
        double t = i / deviation, g = fn_exp(-t * t / 2);
        j->kernels[EDGE].weights[i + reach] = (float)(-i * g);
        j->kernels[POINT].weights[i + reach] = (float)((t * t - 1) * g);
        j->kernels[SMOOTH].weights[i + reach] = (float)g;
    }
    for (int p = COLOR_PLANES; p < PLANES; p++) balance(&j->kernels[p]);
}

static bool make_kernels(flip_job *j) {
    double ppd = j->options->pixels_per_degree, deviation = 0.5 * FEATURE_WIDTH * ppd;
    double reach = 3 * sqrt(0.04 / (2 * PI * PI)) * ppd; /* three deviations of the widest */
    for (int p = 0; p < PLANES; p++) {
        if (!kernel_create(&j->kernels[p], p < COLOR_PLANES ? reach : 3 * deviation)) return false;
        if (j->kernels[p].reach > j->reach) j->reach = j->kernels[p].reach;
    }
    make_sensitivity(j, ppd);
    make_features(j, deviation);
    return true;
}

/* ---- exposures of HDR-FLIP ---- */

static double luminance(const float *rgb) {
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

/* The n-th of the sorted values (Hoare's selection); they change places. */
static float select_nth(float *values, size_t count, size_t n) {
    size_t low = 0, high = count - 1;
    while (low < high) {
        float pivot = values[low + (high - low) / 2];
        size_t i = low, k = high;
        for (;; i++, k--) {
            while (values[i] < pivot) i++;
            while (values[k] > pivot) k--;
            if (i >= k) break;
            float swap = values[i];
            values[i] = values[k], values[k] = swap;
        }
        if (n <= k)
            high = k;
        else
            low = k + 1;
    }
    return values[n];
}

/* ACES as Narkowicz fits it, without its own exposure. */
static const double aces[5] = {0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14};

static float tone_mapped(double x) {
    double y = (x * (aces[0] * x + aces[1])) / (x * (aces[2] * x + aces[3]) + aces[4]);
    return (float)clamp01(y);
}

/* What is tone-mapped to 0.85: the larger root of a quadratic. */
static double bright_value(void) {
    const double t = 0.85;
    double a = aces[0] - t * aces[2], b = aces[1] - t * aces[3], c = -t * aces[4];
    double half = -0.5 * b / a;
    return half + sqrt(half * half - c / a);
}

/* The largest luminance of a picture; all of them go to the map. */
static double read_luminances(const flip_job *j, const flip_picture *picture) {
    uint32_t width = j->options->width;
    float rgb[3 * TILE_WIDTH];
    double largest = 0;
    for (uint32_t y = 0; y < j->options->height; y++)
        for (uint32_t x = 0; x < width; x += TILE_WIDTH) {
            uint32_t count = width - x < TILE_WIDTH ? width - x : TILE_WIDTH;
            picture->read(picture->user, x, y, count, rgb);
            for (uint32_t i = 0; i < count; i++) {
                double value = luminance(rgb + 3 * i);
                j->map[(size_t)y * width + x + i] = (float)value;
                if (value > largest) largest = value;
            }
        }
    return largest;
}

/* From where the reference's brightest pixel is bright to where its median is. The paper says
 * nothing of references that are black (then the other picture's range counts) or mostly black
 * (then the median of what is not), nor how many exposures are too many. */
static void choose_exposures(flip_job *j) {
    size_t count = (size_t)j->options->width * j->options->height;
    double largest = read_luminances(j, &j->pictures[0]);
    if (!(largest > 0)) largest = read_luminances(j, &j->pictures[1]);
    double median = (double)select_nth(j->map, count, count / 2);
    if (!(median > 0)) {
        size_t lit = 0;
        for (size_t i = 0; i < count; i++)
            if (j->map[i] > 0) j->map[lit++] = j->map[i];
        median = lit ? (double)select_nth(j->map, lit, lit / 2) : 1;
    }
    if (!(largest > 0)) largest = median;
    const double ln2 = 0.69314718055994530942;
    double bright = bright_value(), first = fn_log(bright / largest) / ln2,
           last = fn_log(bright / median) / ln2, steps = ceil(last - first);
    j->exposure_count = steps < 2 ? 2 : steps > EXPOSURES_MAX ? EXPOSURES_MAX : (uint32_t)steps;
    for (uint32_t i = 0; i < j->exposure_count; i++)
        j->exposures[i] = fn_pow(2, first + (last - first) * i / (j->exposure_count - 1));
}

/* ---- a tile ---- */

/*  scratch of a worker, in floats:
 *    pixels  3 per pixel of one row, as read, then as three rows Y, Cx, Cz
 *    planes  for each picture and plane, the filtered rows of the tile and around it
 *    sums    for each picture and plane (two for SMOOTH), one row */
enum { SUMS = PLANES + 1 };

static size_t row_count(const flip_job *j) { return TILE_HEIGHT + 2 * (size_t)j->reach; }
static size_t wide_count(const flip_job *j) { return TILE_WIDTH + 2 * (size_t)j->reach; }

static float *scratch_pixels(const flip_job *j, uint32_t worker) { return j->scratch[worker]; }
static float *scratch_plane(const flip_job *j, uint32_t worker, int picture, int plane) {
    return j->scratch[worker] + 6 * wide_count(j) +
           (size_t)(picture * PLANES + plane) * row_count(j) * TILE_WIDTH;
}
static float *scratch_sum(const flip_job *j, uint32_t worker, int picture, int sum) {
    return scratch_plane(j, worker, 2, 0) + (size_t)(picture * SUMS + sum) * TILE_WIDTH;
}
static size_t scratch_size(const flip_job *j) {
    return 6 * wide_count(j) + 2 * PLANES * row_count(j) * TILE_WIDTH + 2 * SUMS * TILE_WIDTH;
}

static uint32_t clamp_index(int64_t i, uint32_t count) {
    return i < 0 ? 0 : i >= count ? count - 1 : (uint32_t)i;
}

typedef struct tile {
    uint32_t x, y, width, height, worker;
    double exposure; /* 0: no tone map */
} tile;

/* One row with what is around it, as Y, Cx, Cz one after the other. */
static const float *load_row(const flip_job *j, const tile *t, int picture, uint32_t y) {
    float *rgb = scratch_pixels(j, t->worker), *out = rgb + 3 * wide_count(j);
    size_t reach = (size_t)j->reach, wide = t->width + 2 * reach;
    int64_t left = (int64_t)t->x - j->reach;
    uint32_t first = clamp_index(left, j->options->width),
             last = clamp_index(left + (int64_t)wide - 1, j->options->width),
             count = last - first + 1;
    size_t before = (size_t)(first - left);
    const flip_picture *p = &j->pictures[picture];
    p->read(p->user, first, y, count, rgb + 3 * before);
    for (size_t i = before; i < before + count; i++) {
        float *c = rgb + 3 * i;
        if (t->exposure > 0)
            for (int k = 0; k < 3; k++) c[k] = tone_mapped((double)c[k] * t->exposure);
        dvec3 xyz = xyz_from_rgb((dvec3){(double)c[0], (double)c[1], (double)c[2]});
        dvec3 v = opponent(xyz.x, xyz.y, xyz.z);
        out[i] = (float)v.x, out[wide + i] = (float)v.y, out[2 * wide + i] = (float)v.z;
    }
    for (int k = 0; k < 3; k++) {
        float *row = out + (size_t)k * wide;
        for (size_t i = 0; i < before; i++) row[i] = row[before];
        for (size_t i = before + count; i < wide; i++) row[i] = row[before + count - 1];
    }
    return out;
}

/* out[x] = the weighted sum of the lines, line i beginning at from + i * step. */
static void filter(const kernel *k, const float *from, size_t step, float *out, size_t count) {
    for (size_t x = 0; x < count; x++) out[x] = 0;
    for (int i = 0; i <= 2 * k->reach; i++) {
        const float *line = from + (size_t)i * step;
        float w = k->weights[i];
        for (size_t x = 0; x < count; x++) out[x] += w * line[x];
    }
}

static void filter_rows(const flip_job *j, const tile *t, int picture) {
    static const int source[PLANES] = {0, 1, 2, 2, 0, 0, 0};
    size_t wide = t->width + 2 * (size_t)j->reach;
    for (int r = 0; r < (int)t->height + 2 * j->reach; r++) {
        uint32_t y = clamp_index((int64_t)t->y - j->reach + r, j->options->height);
        const float *pixels = load_row(j, t, picture, y);
        for (int p = 0; p < PLANES; p++) {
            const kernel *k = &j->kernels[p];
            filter(k, pixels + (size_t)source[p] * wide + (j->reach - k->reach), 1,
                   scratch_plane(j, t->worker, picture, p) + (size_t)r * TILE_WIDTH, t->width);
        }
    }
}

/* Row r of the tile: what was filtered along x is filtered along y. Derivatives along x are
 * smoothed along y, and what was smoothed along x gives the two derivatives along y. */
static void filter_columns(const flip_job *j, const tile *t, int picture, uint32_t r) {
    static const struct {
        int plane, kernel;
    } passes[SUMS] = {{LUMINANCE, LUMINANCE},
                      {RED_GREEN, RED_GREEN},
                      {BLUE_YELLOW, BLUE_YELLOW},
                      {BLUE_YELLOW_WIDE, BLUE_YELLOW_WIDE},
                      {EDGE, SMOOTH},
                      {POINT, SMOOTH},
                      {SMOOTH, EDGE},
                      {SMOOTH, POINT}};
    for (int s = 0; s < SUMS; s++) {
        const kernel *k = &j->kernels[passes[s].kernel];
        size_t row = r + (size_t)(j->reach - k->reach);
        filter(k, scratch_plane(j, t->worker, picture, passes[s].plane) + row * TILE_WIDTH,
               TILE_WIDTH, scratch_sum(j, t->worker, picture, s), t->width);
    }
}

typedef struct pixel_features {
    dvec3 color;
    double edge, point;
} pixel_features;

static pixel_features pixel_of(const flip_job *j, const tile *t, int picture, uint32_t x) {
    double v[SUMS];
    for (int s = 0; s < SUMS; s++) v[s] = (double)scratch_sum(j, t->worker, picture, s)[x];
    /* YCxCz back to colours that a screen has */
    double y = (v[LUMINANCE] + 16) / 116;
    dvec3 xyz = {y + v[RED_GREEN] / 500, y, y - (v[BLUE_YELLOW] + v[BLUE_YELLOW_WIDE]) / 200};
    /* the features were filtered from Y, not from (Y + 16) / 116 */
    return (pixel_features){perceived(rgb_from_xyz(xyz)), sqrt(v[4] * v[4] + v[6] * v[6]) / 116,
                            sqrt(v[5] * v[5] + v[7] * v[7]) / 116};
}

static double pixel_error(const flip_job *j, const tile *t, uint32_t x) {
    pixel_features a = pixel_of(j, t, 0, x), b = pixel_of(j, t, 1, x);
    double color = color_error(j, color_distance(a.color, b.color));
    if (!(color > 0)) return 0;
    double edge = fabs(a.edge - b.edge), point = fabs(a.point - b.point);
    double feature = sqrt((edge > point ? edge : point) / sqrt(2));
    return fn_pow(color, 1 - feature);
}

/* The larger of the error and what is in the map. */
static void tile_run(const flip_job *j, const tile *t) {
    for (int picture = 0; picture < 2; picture++) filter_rows(j, t, picture);
    for (uint32_t r = 0; r < t->height; r++) {
        for (int picture = 0; picture < 2; picture++) filter_columns(j, t, picture, r);
        float *out = j->map + (size_t)(t->y + r) * j->options->width + t->x;
        for (uint32_t x = 0; x < t->width; x++) {
            float error = (float)pixel_error(j, t, x);
            if (error > out[x]) out[x] = error;
        }
    }
}

static bool go_on(flip_job *j, uint32_t worker) {
    const flip_options *o = j->options;
    if (atomic_load(&j->stop)) return false;
    double all = (double)j->tiles_x * j->tiles_y;
    if (worker == 0 && o->progress && !o->progress(o->user, (double)atomic_load(&j->done) / all))
        atomic_store(&j->stop, true);
    return !atomic_load(&j->stop);
}

static void run_tile(void *data, size_t index, uint32_t worker) {
    flip_job *j = data;
    const flip_options *o = j->options;
    if (j->scratch[worker] == NULL) {
        j->scratch[worker] = memory_resize(NULL, scratch_size(j), sizeof(float));
        if (j->scratch[worker] == NULL) {
            atomic_store(&j->no_memory, true);
            atomic_store(&j->stop, true);
        }
    }
    tile t = {.x = (uint32_t)(index % j->tiles_x) * TILE_WIDTH,
              .y = (uint32_t)(index / j->tiles_x) * TILE_HEIGHT,
              .worker = worker};
    t.width = o->width - t.x < TILE_WIDTH ? o->width - t.x : TILE_WIDTH;
    t.height = o->height - t.y < TILE_HEIGHT ? o->height - t.y : TILE_HEIGHT;
    for (uint32_t i = 0; i < (o->hdr ? j->exposure_count : 1) && go_on(j, worker); i++) {
        t.exposure = o->hdr ? j->exposures[i] : 0;
        tile_run(j, &t);
    }
    atomic_fetch_add(&j->done, 1);
}

/* ---- all of it ---- */

static snell_status run(flip_job *j, thread_pool *pool) {
    const flip_options *o = j->options;
    j->scratch = memory_zeroed(thread_pool_size(pool), sizeof *j->scratch);
    if (j->scratch == NULL || !make_kernels(j)) return error_no_memory();
    if (o->hdr) choose_exposures(j);
    memset(j->map, 0, (size_t)o->width * o->height * sizeof *j->map);
    thread_pool_run(pool, (size_t)j->tiles_x * j->tiles_y, run_tile, j);
    if (atomic_load(&j->no_memory)) return error_no_memory();
    return atomic_load(&j->stop) ? error_set(SNELL_CANCELLED, NULL, "cancelled") : SNELL_OK;
}

snell_status flip_map(const flip_picture *reference, const flip_picture *test,
                      const flip_options *options, thread_pool *pool, float *map) {
    const flip_picture pictures[2] = {*reference, *test};
    dvec3 green = perceived((dvec3){0, 1, 0}), blue = perceived((dvec3){0, 0, 1});
    flip_job j = {.pictures = pictures,
                  .options = options,
                  .map = map,
                  .color_max = fn_pow(color_distance(green, blue), Q_C),
                  .tiles_x = (options->width + TILE_WIDTH - 1) / TILE_WIDTH,
                  .tiles_y = (options->height + TILE_HEIGHT - 1) / TILE_HEIGHT};
    snell_status status = run(&j, pool);
    for (int p = 0; p < PLANES; p++) free(j.kernels[p].weights);
    for (uint32_t i = 0; j.scratch && i < thread_pool_size(pool); i++) free(j.scratch[i]);
    free(j.scratch);
    return status;
}
