#include "image/compare.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/flip.h"
#include "image/magma.h"
#include "image/srgb.h"
#include "maths/functions.h"

/* ---- pixels as they are compared ---- */

typedef struct view {
    const film *film;
    bool as_shown, eight_bits;
    const tonemap *map;
    white_balance white;
    double scale;
} view;

typedef struct pixel {
    double linear[3], alpha; /* over black */
    double value[4];         /* what is compared: the same, or sRGB values; and alpha */
    bool finite;
} pixel;

/* The way of image_row_8bit, which exposes and maps colours without their alpha; and back again, to
 * the same floats, as such a file is read. */
static void put_on_screen(const view *v, pixel *p) {
    double alpha = clamp01(p->alpha), scale = alpha > 0 ? v->scale / alpha : 0;
    dvec3 color = {p->linear[0], p->linear[1], p->linear[2]};
    color = tonemap_apply(v->map, scale, white_balance_apply(&v->white, color));
    const double mapped[3] = {color.x, color.y, color.z};
    if (v->eight_bits) alpha = floor(255 * alpha + 0.5) / 255;
    for (int c = 0; c < 3; c++) {
        double shown =
            v->eight_bits ? (double)srgb_table()[tonemap_quantize(mapped[c])] : clamp01(mapped[c]);
        p->linear[c] = (double)(float)(shown * alpha);
    }
    p->alpha = (double)(float)alpha;
}

static double screen_value(const view *v, double linear) {
    return v->eight_bits ? tonemap_quantize(linear) / 255.0 : srgb_encode(linear);
}

static pixel pixel_at(const view *v, size_t index) {
    const film *f = v->film;
    const float *from = f->pixels + index * f->channels;
    pixel p = {.alpha = f->channels == 4 ? (double)from[3] : 1, .finite = true};
    for (int c = 0; c < 3; c++) p.linear[c] = (double)from[c];
    p.finite = isfinite(p.linear[0]) && isfinite(p.linear[1]) && isfinite(p.linear[2]) &&
               isfinite(p.alpha);
    if (v->as_shown && f->encoded_bits == 0) put_on_screen(v, &p);
    for (int c = 0; c < 3; c++)
        p.value[c] = v->as_shown ? screen_value(v, p.linear[c]) : p.linear[c];
    p.value[3] = p.alpha;
    return p;
}

/* ---- Student's distribution ---- */

/* The probability of more than |t|: finite sums (Abramowitz and Stegun 26.7.3, 26.7.4). */
static double student_tail(double t, uint32_t freedom) {
    if (freedom == 0) return fn_erfc(t / sqrt(2));
    double angle = fn_atan(t / sqrt(freedom)), c = fn_cos(angle), s = fn_sin(angle);
    bool odd = freedom % 2;
    double term = odd ? c : 1, sum = freedom > 1 ? term : 0;
    for (uint32_t k = odd ? 3 : 2; k < freedom; k += 2) {
        term *= c * c * (k - 1) / k;
        sum += term;
    }
    return 1 - (odd ? 2 / PI * (angle + s * sum) : s * sum);
}

double student_quantile(double p, uint32_t freedom) {
    double low = 0, high = 1;
    while (student_tail(high, freedom) > p && high < 1e12) high *= 2;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        *(student_tail(middle, freedom) > p ? &low : &high) = middle;
    }
    return high;
}

/* ---- one row, then all ---- */

enum { FREEDOM_MAX = 200 }; /* from there on the normal distribution will do */

typedef struct row_sums {
    double squares, relative, alpha_squares, alpha_relative, difference_max, z_max;
    uint64_t differing, not_finite, z_values, z_beyond, z_rejected;
    uint32_t difference_x, z_x;
    bool transparent;
} row_sums;

typedef struct compare_job {
    view views[2];
    const compare_options *options;
    row_sums *rows;
    double z_limits[FREEDOM_MAX + 1], z_rejects[FREEDOM_MAX + 1]; /* by degrees of freedom */
    atomic_bool stop;
} compare_job;

/* The limits of the z-test; a picture of so many values is to be found wrong by chance once in 100
 * times. Two estimates together have from one to two times the degrees of freedom of one. */
static void make_limits(compare_job *j, double values) {
    uint32_t count = j->options->variance_count;
    uint32_t first = count ? count - 1 : 0,
             last = 2 * first < FREEDOM_MAX ? 2 * first : FREEDOM_MAX;
    double level = 1 - fn_exp(fn_log(0.99) / values);
    for (uint32_t n = 0; n <= last; n = n == 0 && first > 0 ? first : n + 1) {
        j->z_limits[n] = student_quantile(0.05, n);
        j->z_rejects[n] = student_quantile(level, n);
    }
}

/* The degrees of freedom of a sum of two variances, rounded down (Welch, Biometrika 34, 1947). */
static uint32_t degrees_of_freedom(uint32_t count, double a, double b) {
    if (count == 0 || count > FREEDOM_MAX) return 0;
    double n = (count - 1) * ((a + b) * (a + b) / (a * a + b * b));
    return n < count - 1 ? count - 1 : n > FREEDOM_MAX ? FREEDOM_MAX : (uint32_t)n;
}

static double variance_at(const film *f, size_t index, int c) {
    return f ? (double)f->pixels[index * f->channels + (size_t)c] : 0;
}

static void test_pixel(const compare_job *j, size_t index, uint32_t x, const pixel p[2],
                       row_sums *s) {
    bool rejected = false;
    for (int c = 0; c < 3; c++) {
        double a = p[0].value[c], b = p[1].value[c], difference = fabs(b - a);
        double va = variance_at(j->options->variances[0], index, c),
               vb = variance_at(j->options->variances[1], index, c);
        if (!(va >= 0 && vb >= 0 && va + vb < INFINITY)) continue;
        /* What rounding to floats explains is no difference. */
        if (va + vb == 0 && difference <= 0x1p-22 * (fabs(a) > fabs(b) ? fabs(a) : fabs(b)))
            continue;
        double z = va + vb > 0 ? difference / sqrt(va + vb) : INFINITY;
        uint32_t n = va + vb > 0 ? degrees_of_freedom(j->options->variance_count, va, vb) : 0;
        s->z_values++;
        s->z_beyond += z > j->z_limits[n];
        rejected |= z > j->z_rejects[n];
        if (z > s->z_max) s->z_max = z, s->z_x = x;
    }
    s->z_rejected += rejected;
}

static void add_pixel(const pixel p[2], uint32_t x, row_sums *s) {
    bool differs = false;
    for (int c = 0; c < 4; c++) {
        double a = p[0].value[c], d = p[1].value[c] - a, square = d * d;
        *(c < 3 ? &s->squares : &s->alpha_squares) += square;
        *(c < 3 ? &s->relative : &s->alpha_relative) += square / (a * a + 0.01);
        if (d != 0) differs = true;
        if (fabs(d) > s->difference_max) s->difference_max = fabs(d), s->difference_x = x;
    }
    s->differing += differs;
    if (p[0].alpha != 1 || p[1].alpha != 1) s->transparent = true;
}

/* Pixels that are no numbers are equal if they are the same bits. */
static bool same_bits(const compare_job *j, size_t index) {
    const film *a = j->views[0].film, *b = j->views[1].film;
    return a->channels == b->channels &&
           memcmp(a->pixels + index * a->channels, b->pixels + index * b->channels,
                  a->channels * sizeof(float)) == 0;
}

static void sum_row(void *data, size_t y, uint32_t worker) {
    compare_job *j = data;
    const compare_options *o = j->options;
    uint32_t width = j->views[0].film->width;
    row_sums *s = &j->rows[y];
    if (worker == 0 && o->progress && !atomic_load(&j->stop) && !o->progress(o->user, 0))
        atomic_store(&j->stop, true);
    if (atomic_load(&j->stop)) return;
    for (uint32_t x = 0; x < width; x++) {
        size_t index = y * width + x;
        const pixel p[2] = {pixel_at(&j->views[0], index), pixel_at(&j->views[1], index)};
        if (!p[0].finite || !p[1].finite) {
            s->not_finite++;
            s->differing += !same_bits(j, index);
            continue;
        }
        add_pixel(p, x, s);
        if (o->variances[0] || o->variances[1]) test_pixel(j, index, x, p, s);
    }
}

static void sum_all(const compare_job *j, snell_comparison *out) {
    uint32_t height = j->views[0].film->height;
    row_sums all = {0};
    for (uint32_t y = 0; y < height; y++) {
        const row_sums *s = &j->rows[y];
        all.squares += s->squares, all.relative += s->relative;
        all.alpha_squares += s->alpha_squares, all.alpha_relative += s->alpha_relative;
        all.transparent |= s->transparent;
        out->differing += s->differing, out->not_finite += s->not_finite;
        out->z_values += s->z_values, out->z_beyond += s->z_beyond;
        out->z_rejected += s->z_rejected;
        if (s->difference_max > out->difference_max)
            out->difference_max = s->difference_max, out->difference_x = s->difference_x,
            out->difference_y = y;
        if (s->z_max > out->z_max) out->z_max = s->z_max, out->z_x = s->z_x, out->z_y = y;
    }
    if (all.transparent) all.squares += all.alpha_squares, all.relative += all.alpha_relative;
    double values =
        ((double)out->width * out->height - (double)out->not_finite) * (all.transparent ? 4 : 3);
    if (values > 0) {
        out->rmse = sqrt(all.squares / values);
        out->rel_mse = all.relative / values;
    }
    out->psnr = out->rmse > 0 ? -20 * fn_log(out->rmse) / fn_log(10) : INFINITY;
}

/* ---- FLIP and the picture of errors ---- */

typedef struct flip_side {
    const compare_job *job;
    int side;
} flip_side;

/* Where either is no number both are black. */
static void read_for_flip(const void *user, uint32_t x, uint32_t y, uint32_t count, float *rgb) {
    const flip_side *f = user;
    size_t first = (size_t)y * f->job->views[0].film->width + x;
    for (uint32_t i = 0; i < count; i++) {
        pixel p = pixel_at(&f->job->views[f->side], first + i),
              other = pixel_at(&f->job->views[1 - f->side], first + i);
        for (int c = 0; c < 3; c++)
            rgb[3 * i + (uint32_t)c] =
                p.finite && other.finite && p.linear[c] > 0 ? (float)p.linear[c] : 0;
    }
}

static snell_status compute_flip(const compare_job *j, thread_pool *pool, float *map,
                                 snell_comparison *out) {
    const compare_options *o = j->options;
    flip_side sides[2] = {{j, 0}, {j, 1}};
    flip_picture reference = {read_for_flip, &sides[0]}, picture = {read_for_flip, &sides[1]};
    flip_options options = {.width = out->width,
                            .height = out->height,
                            .pixels_per_degree = o->pixels_per_degree,
                            .hdr = out->linear,
                            .progress = o->progress,
                            .user = o->user};
    snell_status status = flip_map(&reference, &picture, &options, pool, map);
    if (status) return status;
    size_t count = (size_t)out->width * out->height;
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += (double)map[i];
    uint64_t finite = count - out->not_finite;
    out->flip = finite ? sum / (double)finite : 0;
    return SNELL_OK;
}

/* On a screen the numbers are to be seen: what is written is what an sRGB file decodes to. What is
 * no number is the largest error. */
static void draw_error(const compare_job *j, size_t index, double flip, bool linear, float *rgb) {
    const compare_options *o = j->options;
    const pixel p[2] = {pixel_at(&j->views[0], index), pixel_at(&j->views[1], index)};
    bool finite = p[0].finite && p[1].finite;
    uint8_t color[3];
    if (!finite) flip = 1;
    magma_color(flip, color);
    for (int c = 0; c < 3; c++) {
        double difference = finite ? fabs(p[1].value[c] - p[0].value[c]) : INFINITY;
        if (o->error_map == SNELL_ERROR_FLIP)
            rgb[c] = o->error_values ? (float)flip : srgb_table()[color[c]];
        else
            rgb[c] = o->error_values || linear ? (float)difference : srgb_to_linear(difference);
    }
}

static snell_status draw_errors(const compare_job *j, const float *map,
                                const snell_comparison *out) {
    film *error = j->options->error;
    if (error == NULL) return SNELL_OK;
    snell_status status = film_resize(error, out->width, out->height, 3);
    if (status) return status;
    for (size_t i = 0; i < (size_t)out->width * out->height; i++)
        draw_error(j, i, (double)map[i], out->linear, error->pixels + 3 * i);
    return SNELL_OK;
}

/* ---- all of it ---- */

static snell_status compare(compare_job *j, thread_pool *pool, float *map, snell_comparison *out) {
    thread_pool_run(pool, out->height, sum_row, j);
    if (atomic_load(&j->stop)) return error_set(SNELL_CANCELLED, NULL, "cancelled");
    sum_all(j, out);
    snell_status status = SNELL_OK;
    if (out->difference_max > 0) status = compute_flip(j, pool, map, out);
    return status ? status : draw_errors(j, map, out);
}

snell_status compare_films(const film *reference, const film *picture,
                           const compare_options *options, thread_pool *pool,
                           snell_comparison *out) {
    bool as_shown = options->as_shown || reference->encoded_bits || picture->encoded_bits;
    bool eight = reference->encoded_bits == 8 || picture->encoded_bits == 8;
    view v = {.as_shown = as_shown,
              .map = options->map,
              .white = options->white,
              .scale = tonemap_exposure(options->exposure)};
    compare_job j = {.views = {v, v}, .options = options};
    compare_options exact = *options; /* the test is of light, not of what screens show */
    if (as_shown) {
        exact.variances[0] = exact.variances[1] = NULL;
        j.options = &exact;
    }
    j.views[0].film = reference, j.views[1].film = picture;
    for (int i = 0; i < 2; i++) /* 16 bits stay what they are */
        j.views[i].eight_bits = eight && j.views[i].film->encoded_bits != 16;
    *out = (snell_comparison){.struct_size = sizeof *out,
                              .width = reference->width,
                              .height = reference->height,
                              .linear = !as_shown};
    size_t count = (size_t)out->width * out->height;
    j.rows = memory_zeroed(out->height, sizeof *j.rows);
    float *map = memory_zeroed(count, sizeof *map);
    if (j.options->variances[0] || j.options->variances[1]) make_limits(&j, 3 * (double)count);
    snell_status status = j.rows && map ? compare(&j, pool, map, out) : error_no_memory();
    free(j.rows);
    free(map);
    return status;
}
