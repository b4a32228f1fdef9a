/* image: tone maps against closed forms, files read back by other readers, atomic writing, and
 * heads of files from anybody. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <dirent.h>
#include <png.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#if SNELL_HAS_OPENEXR
#include <OpenEXR/openexr.h>
#endif

#include "base/file.h"
#include "image/srgb.h"
#include "image/white_balance.h"
#include "image/write.h"
#include "importers/image_decode.h"
#include "maths/functions.h"
#include "reference.h"

/* ---- tone maps ---- */

static const tonemap *map_of(const char *name) {
    const tonemap *map = NULL;
    assert_int_equal(tonemap_find(name, &map), SNELL_OK);
    assert_string_equal(map->name, name);
    return map;
}

static void assert_color(dvec3 got, double x, double y, double z) {
    if (fabs(got.x - x) > 1e-12 || fabs(got.y - y) > 1e-12 || fabs(got.z - z) > 1e-12)
        fail_msg("got %.15g %.15g %.15g", got.x, got.y, got.z);
}

static void tone_maps_have_their_closed_forms(void **state) {
    (void)state;
    const tonemap *clip = map_of("clip"), *reinhard = map_of("reinhard"),
                  *neutral = map_of("neutral");
    assert_color(tonemap_apply(clip, 1, (dvec3){0.2, 3, 0.5}), 0.2, 3, 0.5);
    assert_color(tonemap_apply(reinhard, 1, (dvec3){1, 1, 1}), 0.5, 0.5, 0.5);
    assert_color(tonemap_apply(reinhard, 4, (dvec3){0.75, 0.75, 0.75}), 0.75, 0.75, 0.75);
    double l = 0.2126 * 2 + 0.7152 * 1; /* colours keep their ratios */
    assert_color(tonemap_apply(reinhard, 1, (dvec3){2, 1, 0}), 2 / (1 + l), 1 / (1 + l), 0);

    /* Khronos PBR Neutral by hand. Below the shoulder: minus 0.04 (Fresnel's share). */
    assert_color(tonemap_apply(neutral, 1, (dvec3){0.5, 0.3, 0.1}), 0.46, 0.26, 0.06);
    assert_color(tonemap_apply(neutral, 1, (dvec3){0.04, 0.04, 0.04}), 0.01, 0.01, 0.01);
    assert_color(tonemap_apply(neutral, 1, (dvec3){0, 0, 0}), 0, 0, 0);
    double white = 1 - 0.0576 / 0.44;
    assert_color(tonemap_apply(neutral, 1, (dvec3){1, 1, 1}), white, white, white);
    /* (2, 0.5, 0.1) - 0.04 has the peak 1.96, which becomes 1 - 0.0576 / 1.44 = 0.96; a share of
     * 1 - 1 / (0.15 * (1.96 - 0.96) + 1) goes to white. */
    double g = 0.15 / 1.15, y = 0.46 * 0.96 / 1.96, z = 0.06 * 0.96 / 1.96;
    assert_color(tonemap_apply(neutral, 1, (dvec3){2, 0.5, 0.1}), 0.96, y + (0.96 - y) * g,
                 z + (0.96 - z) * g);
}

/* From the published matrices and curves, computed by another program. */
static void aces_and_agx_are_as_published(void **state) {
    (void)state;
    static const double rows[][9] = {
        {0.18, 0.18, 0.18, 0.1055912472289305, 0.1055912472289306, 0.1055901913164582,
         0.2144674307072033, 0.2145326686205483, 0.2145367282681327},
        {1, 1, 1, 0.6191154269408089, 0.619115426940809, 0.6191092357865396, 0.5899769805800973,
         0.5902071552748706, 0.5902214793576204},
        {2, 0.5, 0.1, 0.9014992612365916, 0.4186894461189823, 0.1050007907608971,
         0.8072893428652526, 0.4496241175389312, 0.2106904847341662},
        {0, 0, 0, 0, 0, 0, 0, 0, 0},
        {0.01, 0.02, 0.3, -0.006304805714461823, 0.003079965080773346, 0.184741304843155,
         0.02556354140954338, 0.03777028410893291, 0.3439873036656204},
        {50, 0, 0, 1.071726962634631, 0.8945675710647307, 0.7091353346897415, 1.048593382851805,
         0.7427299976416524, 0.7430063141725249}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const double *r = rows[i];
        dvec3 color = {r[0], r[1], r[2]};
        assert_color(tonemap_apply(map_of("aces"), 1, color), r[3], r[4], r[5]);
        assert_color(tonemap_apply(map_of("agx"), 1, color), r[6], r[7], r[8]);
    }
}

/* ---- white balance ---- */

static dvec3 balanced(const char *white, dvec3 color) {
    white_balance balance;
    assert_int_equal(white_balance_parse(white, &balance), SNELL_OK);
    return white_balance_apply(&balance, color);
}

static double luminance(dvec3 c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

static void d65_and_greys_change_nothing(void **state) {
    (void)state;
    static const char *const whites[] = {"",        "6504",  "6504.000",      "#fff",
                                         "#808080", "1,1,1", "0.25,0.25,0.25"};
    const dvec3 color = {0.1, 0.7, 12};
    for (size_t i = 0; i < sizeof whites / sizeof whites[0]; i++) {
        dvec3 c = balanced(whites[i], color);
        assert_true(c.x == color.x && c.y == color.y && c.z == color.z);
    }
    white_balance balance;
    assert_int_equal(white_balance_parse(NULL, &balance), SNELL_OK);
    assert_false(balance.on);
}

/* What was said to be white is, and as bright as it was. */
static void the_light_turns_white(void **state) {
    (void)state;
    static const char *const whites[] = {"1,0.6,0.25", "0.2,0.4,3", "#ffd9b0", "#00f", "0,1,0"};
    static const dvec3 colors[] = {
        {1, 0.6, 0.25}, {0.2, 0.4, 3}, {1, 0.693871737, 0.434153636}, {0, 0, 1}, {0, 1, 0}};
    for (size_t i = 0; i < sizeof whites / sizeof whites[0]; i++) {
        dvec3 c = balanced(whites[i], colors[i]);
        double l = luminance(colors[i]);
        assert_true(fabs(c.x - l) < 1e-6 && fabs(c.y - l) < 1e-6 && fabs(c.z - l) < 1e-6);
    }
}

/* Bradford's matrices from illuminant A (2856 K) to D65, and from D50 (5003 K), as B. Lindbloom tabulates
 * them for XYZ. */
static void bradford_is_as_tabulated(void **state) {
    (void)state;
    static const struct {
        const char *kelvin;
        dvec3 white;
        double m[3][3];
    } rows[] = {{"2856",
                 {1.09850, 1, 0.35585},
                 {{0.8446965, -0.1179225, 0.3948108},
                  {-0.1366303, 1.1041226, 0.1291718},
                  {0.0798489, -0.1348999, 3.1924009}}},
                {"5003",
                 {0.96422, 1, 0.82521},
                 {{0.9555766, -0.0230393, 0.0631636},
                  {-0.0282895, 1.0099416, 0.0210077},
                  {0.0122982, -0.0204830, 1.3299098}}}};
    static const double rgb_of_xyz[3][3] = {{3.2406255, -1.5372080, -0.4986286},
                                            {-0.9689307, 1.8757561, 0.0415175},
                                            {0.0557101, -0.2040211, 1.0569959}};
    static const double xyz[][3] = {{0.4, 0.3, 0.1}, {0.2, 0.3, 0.5}, {0.5, 0.5, 0.3}};
    for (size_t i = 0; i < 2; i++) {
        double x, y;
        white_balance_locus(atof(rows[i].kelvin), &x, &y);
        assert_true(fabs(x / y - rows[i].white.x) < 0.002 &&
                    fabs((1 - x - y) / y - rows[i].white.z) < 0.002);
        for (size_t k = 0; k < 3; k++) {
            double before[3], after[3], adapted[3];
            for (int r = 0; r < 3; r++) {
                const double *a = rgb_of_xyz[r], *b = rows[i].m[r], *p = xyz[k];
                before[r] = a[0] * p[0] + a[1] * p[1] + a[2] * p[2];
                adapted[r] = b[0] * p[0] + b[1] * p[1] + b[2] * p[2];
            }
            dvec3 got = balanced(rows[i].kelvin, (dvec3){before[0], before[1], before[2]});
            for (int r = 0; r < 3; r++) {
                const double *a = rgb_of_xyz[r];
                after[r] = a[0] * adapted[0] + a[1] * adapted[1] + a[2] * adapted[2];
            }
            assert_true(fabs(got.x - after[0]) < 0.01 && fabs(got.y - after[1]) < 0.01 &&
                        fabs(got.z - after[2]) < 0.01);
        }
    }
}

/* Warmer light is redder, without a step anywhere; cooler than D65 looks bluer. */
static void the_locus_has_no_steps(void **state) {
    (void)state;
    double x_before = 1, y_before;
    white_balance_locus(1000, &x_before, &y_before);
    for (int t = 1010; t <= 25000; t += 10) {
        double x, y;
        white_balance_locus(t, &x, &y);
        assert_true(x < x_before && x_before - x < 0.002 && fabs(y - y_before) < 0.002);
        x_before = x, y_before = y;
    }
    dvec3 grey = {0.5, 0.5, 0.5}, lamp = balanced("3200", grey), shade = balanced("9000", grey);
    assert_true(lamp.z > 0.6 && lamp.x < 0.45 && shade.x > 0.52 && shade.z < 0.45);
}

static void what_is_no_light_is_refused(void **state) {
    (void)state;
    static const char *const wrong[] = {"999",    "25001",   "0",   "0,0,0", "#000",  "warm",
                                        "1,2",    "1,2,3,4", "-5",  "1e4",   "3200K", "1,,2",
                                        "#12345", ".",       "inf", "1,1,1 "};
    white_balance balance;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        if (white_balance_parse(wrong[i], &balance) != SNELL_ERR_ARGUMENT || balance.on)
            fail_msg("'%s' is taken for a light", wrong[i]);
}

static void every_tone_map_is_finite_and_grows(void **state) {
    (void)state;
    const double odd[] = {NAN, INFINITY, -INFINITY, -1, 0, 1e-300, 1e300, 0.5};
    for (size_t m = 0; tonemaps[m]; m++) {
        for (size_t i = 0; i < 512; i++) {
            dvec3 c =
                tonemap_apply(tonemaps[m], 1, (dvec3){odd[i % 8], odd[i / 8 % 8], odd[i / 64]});
            assert_true(isfinite(c.x) && isfinite(c.y) && isfinite(c.z));
        }
        double before = -1;
        for (int i = 0; i < 4000; i++) {
            double x = 0.005 * i, after = tonemap_apply(tonemaps[m], 1, (dvec3){x, x, x}).x;
            bool lifts = strcmp(tonemaps[m]->name, "agx") == 0; /* at most half a stop */
            /* agx ends at 16.3, where its matrices, which are rounded, leave 3e-6 */
            assert_true(after > before || (lifts && x > 16.2 && after > before - 1e-5));
            assert_true(after <= (lifts ? 1.45 * x + 0.003 : x + 1e-15));
            assert_true(after <= 1 || strcmp(tonemaps[m]->name, "clip") == 0);
            before = after;
        }
    }
    const tonemap *map;
    assert_int_equal(tonemap_find("neutrl", &map), SNELL_ERR_ARGUMENT);
    assert_string_equal(error_last()->hint, "did you mean 'neutral'?");
    assert_int_equal(tonemap_find(NULL, &map), SNELL_OK);
    assert_string_equal(map->name, "clip");
    assert_true(tonemap_exposure(0) == 1 && fabs(tonemap_exposure(3) - 8) < 1e-14);
}

static void check_oetf(const reference_case *c) {
    if (strcmp(c->name, "srgb_oetf") != 0) return;
    size_t i;
    json_t *row;
    json_array_foreach(c->expected, i, row) {
        double linear = reference_number(row, 0);
        assert_true(reference_agrees(c, srgb_encode(linear), reference_number(row, 1)));
        assert_int_equal(tonemap_quantize(linear), (int)reference_number(row, 2));
    }
    assert_true(json_array_size(c->expected) == 10);
}

static void eight_bits_are_the_nearest(void **state) {
    (void)state;
    assert_int_equal(reference_each("J.output", check_oetf), 1);
    for (int i = -1000; i < 1010000; i++) {
        double linear = i * 1e-6 + 1e-9, exact = 255 * srgb_encode(linear < 0 ? 0 : linear);
        if (exact > 255) exact = 255;
        if (fabs(exact - tonemap_quantize(linear)) > 0.5 + 1e-9)
            fail_msg("%g gives %d, not %g", linear, tonemap_quantize(linear), exact);
    }
    assert_int_equal(tonemap_quantize(NAN), 0);
    assert_int_equal(tonemap_quantize(INFINITY), 255);
    for (int i = 0; i < 256; i++) assert_int_equal(tonemap_quantize((double)srgb_table()[i]), i);
}

/* ---- a test picture ---- */

enum { WIDTH = 37, HEIGHT = 35 };
static float picture[WIDTH * HEIGHT * 4];

static image_pixels make_picture(uint32_t channels) {
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
        double x = (double)(i % WIDTH) / WIDTH, y = (double)(i / WIDTH) / HEIGHT;
        double alpha = channels == 4 ? (i % 7 == 0 ? 0 : y) : 1;
        float *p = picture + i * channels;
        p[0] = (float)(alpha * x * 1.5);
        p[1] = (float)(alpha * y * 0.3);
        p[2] = (float)(alpha * fabs(x - y));
        if (channels == 4) p[3] = (float)alpha;
    }
    return (image_pixels){picture, WIDTH, HEIGHT, channels};
}

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

static bytes encode(const char *format, const image_pixels *pixels, const image_options *options) {
    const image_codec *codec;
    void *data, *again;
    size_t size, size_again;
    assert_int_equal(image_codec_find(format, &codec), SNELL_OK);
    assert_int_equal(image_encode(codec, pixels, options, &data, &size), SNELL_OK);
    assert_int_equal(image_encode(codec, pixels, options, &again, &size_again), SNELL_OK);
    assert_int_equal(size, size_again); /* the same bytes every time */
    assert_memory_equal(data, again, size);
    free(again);
    return (bytes){data, size};
}

static uint8_t expected_8bit(const image_pixels *pixels, size_t pixel, uint32_t channel,
                             double scale) {
    const float *p = pixels->data + pixel * pixels->channels;
    double alpha = pixels->channels == 4 ? (double)p[3] : 1;
    if (channel == 3) return (uint8_t)(255 * alpha + 0.5);
    double linear = alpha > 0 ? (double)p[channel] * (scale / alpha) : 0;
    double encoded = 255 * srgb_encode(linear > 1 ? 1 : linear);
    return (uint8_t)(encoded + 0.5);
}

static void png_reads_back(void **state) {
    (void)state;
    for (uint32_t channels = 3; channels <= 4; channels++) {
        image_pixels pixels = make_picture(channels);
        image_options options = {.exposure = -1};
        bytes file = encode("png", &pixels, &options);
        png_image reader = {.version = PNG_IMAGE_VERSION};
        assert_true(png_image_begin_read_from_memory(&reader, file.data, file.size));
        assert_true(reader.width == WIDTH && reader.height == HEIGHT);
        assert_int_equal(reader.format, channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
        assert_false(reader.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB);
        uint8_t *got = malloc(PNG_IMAGE_SIZE(reader));
        assert_non_null(got);
        assert_true(png_image_finish_read(&reader, NULL, got, 0, NULL));
        for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++)
            for (uint32_t c = 0; c < channels; c++)
                assert_int_equal(got[i * channels + c], expected_8bit(&pixels, i, c, 0.5));
        free(got);
        free(file.data);
    }
}

static float float_at(const uint8_t *p) {
    uint32_t bits = (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | p[0];
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void pfm_and_ppm_read_back(void **state) {
    (void)state;
    image_pixels pixels = make_picture(4);
    bytes file = encode("pfm", &pixels, NULL);
    const char head[] = "PF\n37 35\n-1.0\n";
    assert_memory_equal(file.data, head, sizeof head - 1);
    assert_int_equal(file.size, sizeof head - 1 + WIDTH * HEIGHT * 12);
    for (size_t y = 0; y < HEIGHT; y++) /* bottom row first */
        for (size_t x = 0; x < WIDTH * 3; x++) {
            float got = float_at(file.data + sizeof head - 1 + (y * WIDTH * 3 + x) * 4);
            assert_true(got == picture[((HEIGHT - 1 - y) * WIDTH + x / 3) * 4 + x % 3]);
        }
    free(file.data);

    pixels = make_picture(3);
    file = encode("ppm", &pixels, NULL);
    const char ppm_head[] = "P6\n37 35\n255\n";
    assert_memory_equal(file.data, ppm_head, sizeof ppm_head - 1);
    assert_int_equal(file.size, sizeof ppm_head - 1 + WIDTH * HEIGHT * 3);
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * 3; i++)
        assert_int_equal(file.data[sizeof ppm_head - 1 + i],
                         expected_8bit(&pixels, i / 3, (uint32_t)(i % 3), 1));
    free(file.data);
}

#if SNELL_HAS_OPENEXR
static int64_t read_bytes(exr_const_context_t context, void *user, void *to, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t report) {
    (void)context;
    (void)report;
    const bytes *file = user;
    if (offset > file->size) return -1;
    if (size > file->size - offset) size = file->size - offset;
    memcpy(to, file->data + offset, size);
    return (int64_t)size;
}
static int64_t size_of_bytes(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const bytes *)user)->size;
}

/* All pixels by OpenEXR's own decoder, interleaved as the picture is. */
static void decode_exr(const bytes *file, uint32_t channels, float *got) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.user_data = (void *)(uintptr_t)file;
    setup.read_fn = read_bytes;
    setup.size_fn = size_of_bytes;
    exr_context_t exr;
    assert_int_equal(exr_start_read(&exr, "memory", &setup), EXR_ERR_SUCCESS);
    exr_compression_t compression;
    assert_int_equal(exr_get_compression(exr, 0, &compression), EXR_ERR_SUCCESS);
    assert_int_equal(compression, EXR_COMPRESSION_ZIP);
    int32_t step;
    assert_int_equal(exr_get_scanlines_per_chunk(exr, 0, &step), EXR_ERR_SUCCESS);
    for (int y = 0; y < HEIGHT; y += step) {
        exr_chunk_info_t chunk;
        exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
        assert_int_equal(exr_read_scanline_chunk_info(exr, 0, y, &chunk), EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_initialize(exr, 0, &chunk, &pipeline), EXR_ERR_SUCCESS);
        assert_int_equal(pipeline.channel_count, channels);
        for (int c = 0; c < pipeline.channel_count; c++) {
            size_t place = strcspn("RGBA", pipeline.channels[c].channel_name);
            assert_true(place < channels);
            pipeline.channels[c].decode_to_ptr =
                (uint8_t *)(got + (size_t)y * WIDTH * channels + place);
            pipeline.channels[c].user_bytes_per_element = 4;
            pipeline.channels[c].user_data_type = EXR_PIXEL_FLOAT;
            pipeline.channels[c].user_pixel_stride = (int32_t)(4 * channels);
            pipeline.channels[c].user_line_stride = (int32_t)(4 * channels * WIDTH);
        }
        assert_int_equal(exr_decoding_choose_default_routines(exr, 0, &pipeline), EXR_ERR_SUCCESS);
        assert_int_equal(exr_decoding_run(exr, 0, &pipeline), EXR_ERR_SUCCESS);
        exr_decoding_destroy(exr, &pipeline);
    }
    exr_finish(&exr);
}

static void exr_reads_back(void **state) {
    (void)state;
    static float got[WIDTH * HEIGHT * 4];
    for (uint32_t channels = 3; channels <= 4; channels++) {
        image_pixels pixels = make_picture(channels);
        image_options options = {.exposure = 5, .tag = "made by a test"}; /* no effect on EXR */
        bytes file = encode("exr", &pixels, &options);
        memset(got, 0xff, sizeof got);
        decode_exr(&file, channels, got);
        assert_memory_equal(got, picture, sizeof(float) * WIDTH * HEIGHT * channels);
        free(file.data);
    }
}
#else
static void exr_reads_back(void **state) {
    (void)state;
    const image_codec *codec;
    void *data;
    size_t size;
    image_pixels pixels = make_picture(3);
    assert_int_equal(image_codec_find("exr", &codec), SNELL_OK);
    assert_int_equal(image_encode(codec, &pixels, NULL, &data, &size), SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(error_last()->hint, "-DSNELL_OPENEXR=ON"));
}
#endif

static bool can_encode(const image_codec *codec) { return codec->encode != NULL; }

static void heads_and_tags_read_back(void **state) {
    (void)state;
    const char *const tags[] = {"", "scene duck.glb -s 800x600", "two\nlines",
                                "\xc3\xa9t\xc3\xa9 100 %", "{\"a\": [1, 2]}"};
    for (size_t f = 0; image_codecs[f]; f++) {
        if (!can_encode(image_codecs[f])) continue;
        for (size_t i = 0; i < sizeof tags / sizeof tags[0]; i++)
            for (uint32_t channels = 3; channels <= 4; channels++) {
                image_pixels pixels = make_picture(channels);
                image_options options = {.tag = tags[i]};
                bytes file = encode(image_codecs[f]->name, &pixels, &options);
                image_info info;
                assert_int_equal(image_parse_info(file.data, file.size, &info), SNELL_OK);
                assert_string_equal(info.format, image_codecs[f]->name);
                assert_true(info.width == WIDTH && info.height == HEIGHT);
                bool floats = strcmp(info.format, "exr") == 0 || strcmp(info.format, "pfm") == 0;
                bool alpha = strcmp(info.format, "exr") == 0 || strcmp(info.format, "png") == 0 ||
                             strcmp(info.format, "webp") == 0;
                assert_int_equal(info.frames, 0);
                assert_int_equal(info.bits, floats ? 32 : 8);
                assert_int_equal(info.channels, alpha ? channels : 3);
                assert_string_equal(info.tag, image_codecs[f]->has_tag ? tags[i] : "");
                image_info_free(&info);
                free(file.data);
            }
    }
}

static void sixteen_bits_are_the_nearest(void **state) {
    (void)state;
    for (uint32_t channels = 3; channels <= 4; channels++) {
        image_pixels pixels = make_picture(channels);
        image_options options = {.bits = 16, .exposure = 1};
        bytes file = encode("png", &pixels, &options);
        image_info info;
        assert_int_equal(image_parse_info(file.data, file.size, &info), SNELL_OK);
        assert_int_equal(info.bits, 16);
        image_info_free(&info);
        decoded_image got;
        assert_int_equal(image_decode_wide(file.data, file.size, IMAGE_SIZE_MAX, &got), SNELL_OK);
        assert_true(got.wide && got.channels == channels && got.width == WIDTH);
        for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * channels; i++) {
            const float *p = pixels.data + i / channels * channels;
            double alpha = channels == 4 ? (double)p[3] : 1, wanted = alpha;
            if (i % channels < 3)
                wanted = srgb_encode(clamp01(alpha > 0 ? 2 * (double)p[i % channels] / alpha : 0));
            double value = got.pixels[2 * i] << 8 | got.pixels[2 * i + 1];
            if (fabs(value - 65535 * wanted) > 0.5 + 1e-6)
                fail_msg("%zu: %g, not %.9g", i, value, 65535 * wanted);
        }
        image_free(&got);
        free(file.data);
    }
}

#if SNELL_HAS_OPENEXR
/* To the nearest half, by OpenEXR's own conversion back. */
static void halves_are_the_nearest(void **state) {
    (void)state;
    static float got[WIDTH * HEIGHT * 3], wanted[WIDTH * HEIGHT * 3];
    static const float odd[] = {0,      -0.0f,   1,        -1,         65504,    65505,     1e30f,
                                -1e30f, 6.1e-5f, 5.96e-8f, 2.98e-8f,   2.99e-8f, 1e-9f,     -3e-6f,
                                0.1f,   2049,    2051,     1.0004882f, INFINITY, -INFINITY, NAN};
    enum { COUNT = WIDTH * HEIGHT * 3, ODD = sizeof odd / sizeof odd[0] };
    for (int i = 0; i < COUNT; i++)
        wanted[i] = i < ODD ? odd[i] : (float)(fn_exp(0.01 * (i - 1500)) * (i % 2 ? 1 : -1));
    image_pixels pixels = {wanted, WIDTH, HEIGHT, 3};
    bytes file = encode("exr", &pixels, &(image_options){.bits = 16});
    decode_exr(&file, 3, got);
    for (int i = 0; i < COUNT; i++) {
        double w = (double)wanted[i], size = fabs(w);
        if (isnan(w)) {
            assert_true(isnan(got[i]));
            continue;
        }
        if (isfinite(w) && size > 65504) w = w > 0 ? 65504 : -65504;
        double step = size < 0x1p-14 ? 0x1p-24 : exp2(floor(log2(size)) - 10);
        bool same = isinf(w) ? (double)got[i] == w : fabs((double)got[i] - w) <= step / 2;
        if (!same) fail_msg("%.9g became %.9g", w, (double)got[i]);
    }
    assert_true((double)got[15] == 2048 && (double)got[16] == 2052); /* ties go to even */
    image_info info;
    assert_int_equal(image_parse_info(file.data, file.size, &info), SNELL_OK);
    assert_int_equal(info.bits, 16);
    image_info_free(&info);
    free(file.data);
}
#endif

static void what_a_format_has_not_is_refused(void **state) {
    (void)state;
    image_pixels pixels = make_picture(3);
    static const struct {
        const char *format;
        uint32_t bits, quality;
    } wrong[] = {{"png", 32, 0}, {"exr", 8, 0},  {"ppm", 16, 0},
                 {"png", 0, 50}, {"jpg", 16, 0}, {"jpg", 0, 101}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        const image_codec *codec;
        void *data;
        size_t size;
        assert_int_equal(image_codec_find(wrong[i].format, &codec), SNELL_OK);
        if (!can_encode(codec)) continue;
        image_options options = {.bits = wrong[i].bits, .quality = wrong[i].quality};
        assert_int_equal(image_encode(codec, &pixels, &options, &data, &size), SNELL_ERR_ARGUMENT);
    }
}

static void what_cannot_be_written_is_refused(void **state) {
    (void)state;
    image_pixels pixels = make_picture(3);
    assert_int_equal(image_write("picture.bmp", &pixels, NULL), SNELL_ERR_UNSUPPORTED);
    assert_string_equal(error_last()->text, "cannot write '.bmp' files");
    assert_string_equal(error_last()->file, "picture.bmp");
    assert_int_equal(image_write("folder.d/picture", &pixels, NULL), SNELL_ERR_UNSUPPORTED);
    pixels.data = NULL;
    assert_int_equal(image_write("picture.png", &pixels, NULL), SNELL_ERR_STATE);
    const image_codec *codec;
    assert_int_equal(image_codec_for_path("A.PNG", &codec), SNELL_OK);
    assert_string_equal(codec->name, "png");
    char *tag = malloc(IMAGE_TAG_MAX + 2);
    assert_non_null(tag);
    memset(tag, 'x', IMAGE_TAG_MAX + 1);
    tag[IMAGE_TAG_MAX + 1] = '\0';
    pixels = make_picture(3);
    image_options options = {.tag = tag};
    assert_int_equal(image_write("picture.png", &pixels, &options), SNELL_ERR_ARGUMENT);
    tag[IMAGE_TAG_MAX] = '\0'; /* the longest is found again in the head */
    bytes file = encode("png", &pixels, &options);
    image_info info;
    assert_true(file.size > IMAGE_TAG_MAX);
    size_t head = file.size < IMAGE_HEAD_MAX ? file.size : IMAGE_HEAD_MAX;
    assert_int_equal(image_parse_info(file.data, head, &info), SNELL_OK);
    assert_int_equal(strlen(info.tag), IMAGE_TAG_MAX);
    image_info_free(&info);
    free(file.data);
    free(tag);
}

/* ---- heads from anybody ---- */

static uint64_t random_state = 1;
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* Parses a copy of exactly this size, so that the address sanitizer sees a byte too far. */
static bool parse_copy(const uint8_t *data, size_t size) {
    uint8_t *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    if (size) memcpy(copy, data, size);
    image_info info;
    snell_status status = image_parse_info(copy, size, &info);
    if (status == SNELL_OK) {
        assert_true(info.width > 0 && info.height > 0 && info.channels > 0 && info.bits > 0);
        assert_true(strlen(info.tag) <= size);
        image_info_free(&info);
    } else {
        assert_true(status == SNELL_ERR_SYNTAX || status == SNELL_ERR_UNSUPPORTED);
    }
    free(copy);
    return status == SNELL_OK;
}

static size_t mutate(uint8_t *data, size_t size) {
    static const uint8_t odd[] = {0, 1, 0x7f, 0x80, 0xff, '\n', '#', ' ', '9'};
    uint64_t changes = 1 + random_bits() % 4;
    for (uint64_t i = 0; i < changes; i++) {
        size_t at = random_bits() % size, count = 1 + random_bits() % 4;
        switch (random_bits() % 4) {
        case 0: data[at] = (uint8_t)random_bits(); break;
        case 1: data[at] ^= (uint8_t)(1 << random_bits() % 8); break;
        case 2:
            for (size_t k = 0; k < count && at + k < size; k++)
                data[at + k] = odd[random_bits() % sizeof odd];
            break;
        default: memmove(data + at, data + at / 2, size - at); break;
        }
    }
    return random_bits() % 4 ? size : 1 + random_bits() % size;
}

static void broken_heads_are_errors(void **state) {
    (void)state;
    int good = 0, bad = 0;
    for (size_t f = 0; image_codecs[f]; f++) {
        if (!can_encode(image_codecs[f])) continue;
        image_pixels pixels = make_picture(4);
        image_options options = {.tag = "a tag\nof two lines"};
        bytes file = encode(image_codecs[f]->name, &pixels, &options);
        size_t head = file.size < 600 ? file.size : 600;
        assert_false(parse_copy(file.data, 0));
        for (size_t size = 1; size <= head; size++) /* truncated */
            if (parse_copy(file.data, size) && size < 12)
                fail_msg("%s: %zu bytes were enough", image_codecs[f]->name, size);
        uint8_t mutant[600];
        for (int i = 0; i < 20000; i++) {
            memcpy(mutant, file.data, head);
            /* mostly within the first bytes, where the head is */
            size_t reach = i % 2 ? head : 100;
            size_t size = mutate(mutant, reach);
            if (size == reach) size = head;
            if (parse_copy(mutant, size))
                good++;
            else
                bad++;
        }
        free(file.data);
    }
    printf("mutants: %d still make sense, %d do not\n", good, bad);
    assert_true(good > 1000 && bad > 1000);

    image_info info;
    const char text[] = "this is no picture at all";
    assert_int_equal(image_parse_info((const uint8_t *)text, sizeof text, &info),
                     SNELL_ERR_UNSUPPORTED);
    const char huge[] = "P6 99999999999999999999 1 255\n";
    assert_int_equal(image_parse_info((const uint8_t *)huge, sizeof huge, &info), SNELL_ERR_SYNTAX);
    const char comments[] =
        "P6#one\n#two\n 3 # snell: not at a place that snell writes\n 4 65535\n";
    assert_int_equal(image_parse_info((const uint8_t *)comments, sizeof comments, &info), SNELL_OK);
    assert_true(info.width == 3 && info.height == 4 && info.bits == 16);
    image_info_free(&info);
}

/* ---- atomic writing ---- */

static char folder[256];

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "%s/image_test_XXXXXX", TEST_BINARY_DIR);
    return mkdtemp(folder) ? 0 : -1;
}

static void path_in(char *out, size_t size, const char *name) {
    snprintf(out, size, "%s/%s", folder, name);
}

/* How many entries the folder has; removes all that are no folder, if asked to. */
static int entries(bool remove_them) {
    DIR *d = opendir(folder);
    assert_non_null(d);
    int count = 0;
    for (struct dirent *e; (e = readdir(d)) != NULL;) {
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0) continue;
        count++;
        if (remove_them) unlinkat(dirfd(d), e->d_name, 0);
    }
    closedir(d);
    return count;
}

static int remove_folder(void **state) {
    (void)state;
    entries(true);
    return rmdir(folder);
}

static void assert_content(const char *path, const char *expected) {
    void *data;
    size_t size;
    assert_int_equal(file_read_start(path, 1 << 20, &data, &size), SNELL_OK);
    assert_int_equal(size, strlen(expected));
    assert_memory_equal(data, expected, size);
    free(data);
}

static void a_file_is_replaced(void **state) {
    (void)state;
    char path[512];
    path_in(path, sizeof path, "a.txt");
    assert_int_equal(file_write_atomic(path, "first", 5), SNELL_OK);
    assert_content(path, "first");
    struct stat about;
    mode_t mask = umask(0);
    umask(mask);
    assert_int_equal(stat(path, &about), 0);
    assert_int_equal(about.st_mode & 0777, 0666 & ~mask);
    assert_int_equal(chmod(path, 0640), 0);
    assert_int_equal(file_write_atomic(path, "second", 6), SNELL_OK);
    assert_content(path, "second");
    assert_int_equal(stat(path, &about), 0);
    assert_int_equal(about.st_mode & 0777, 0640);
    assert_int_equal(file_write_atomic(path, NULL, 0), SNELL_OK);
    assert_content(path, "");
    assert_int_equal(entries(true), 1); /* and no temporary file */
}

static void links_are_written_through(void **state) {
    (void)state;
    char target[512], link[512], dangling[512], later[512], loop[512];
    path_in(target, sizeof target, "target");
    path_in(link, sizeof link, "link");
    path_in(dangling, sizeof dangling, "dangling");
    path_in(later, sizeof later, "later");
    path_in(loop, sizeof loop, "loop");
    assert_int_equal(file_write_atomic(target, "old", 3), SNELL_OK);
    assert_int_equal(symlink("target", link), 0);
    assert_int_equal(symlink(later, dangling), 0);
    assert_int_equal(symlink("loop", loop), 0);
    assert_int_equal(file_write_atomic(link, "new", 3), SNELL_OK);
    assert_content(target, "new");
    assert_int_equal(file_write_atomic(dangling, "made", 4), SNELL_OK);
    assert_content(later, "made");
    struct stat about;
    assert_true(lstat(link, &about) == 0 && S_ISLNK(about.st_mode));
    assert_true(lstat(dangling, &about) == 0 && S_ISLNK(about.st_mode));
    assert_int_equal(file_write_atomic(loop, "x", 1), SNELL_ERR_IO);
    assert_int_equal(entries(true), 5);
}

static void devices_and_pipes_are_written_directly(void **state) {
    (void)state;
    assert_int_equal(file_write_atomic("/dev/null", "x", 1), SNELL_OK);
    struct stat about;
    assert_true(stat("/dev/null", &about) == 0 && S_ISCHR(about.st_mode));
    if (stat("/dev/full", &about) == 0 && S_ISCHR(about.st_mode)) {
        assert_int_equal(file_write_atomic("/dev/full", "x", 1), SNELL_ERR_IO);
        assert_string_equal(error_last()->text, "cannot write: no space left");
    }
    char path[512];
    path_in(path, sizeof path, "pipe");
    assert_int_equal(mkfifo(path, 0600), 0);
    pid_t child = fork();
    if (child == 0) {
        char got[8] = "";
        int file = open(path, O_RDONLY);
        ssize_t size = file < 0 ? -1 : read(file, got, sizeof got);
        _exit(size == 5 && memcmp(got, "hello", 5) == 0 ? 0 : 1);
    }
    assert_int_equal(file_write_atomic(path, "hello", 5), SNELL_OK);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    void *data;
    size_t size;
    assert_int_equal(file_read_start(path, 10, &data, &size), SNELL_ERR_IO); /* and does not wait */
    assert_int_equal(entries(true), 1);
}

/* Runs `test` in a process of its own: 0 passed, 77 could not be tried here. */
static int in_child(int (*test)(void)) {
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) _exit(test());
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static char kept[512];
static char big[1 << 20];

static int write_over_the_limit(void) {
    struct rlimit limit = {1000, 1000};
    signal(SIGXFSZ, SIG_IGN);
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 77;
    if (file_write_atomic(kept, big, sizeof big) != SNELL_ERR_IO) return 1;
    return strstr(error_last()->text, "larger than is allowed") ? 0 : 2;
}

static int write_to_a_full_disk(void) {
    char here[512];
    if (unshare(CLONE_NEWNS) != 0 || mount(NULL, "/", NULL, MS_REC | MS_PRIVATE, NULL) != 0 ||
        mount("tmpfs", folder, "tmpfs", 0, "size=65536") != 0)
        return 77;
    path_in(here, sizeof here, "kept");
    if (file_write_atomic(here, "old", 3) != SNELL_OK) return 1;
    if (file_write_atomic(here, big, sizeof big) != SNELL_ERR_IO) return 2;
    if (strcmp(error_last()->text, "cannot write: no space left") != 0) return 3;
    if (strcmp(error_last()->file, here) != 0 || error_last()->hint[0] == '\0') return 4;
    if (entries(false) != 1) return 5;
    void *data;
    size_t size;
    if (file_read_start(here, 100, &data, &size) != SNELL_OK || size != 3) return 6;
    return memcmp(data, "old", 3) == 0 ? 0 : 7;
}

static int write_where_it_is_forbidden(void) {
    if (getuid() == 0 && setresuid(65534, 65534, 65534) != 0) return 77;
    if (file_write_atomic(kept, "new", 3) != SNELL_ERR_IO) return 1;
    return strcmp(error_last()->text, "cannot write: permission denied") == 0 ? 0 : 2;
}

static void an_old_file_survives_every_failure(void **state) {
    (void)state;
    path_in(kept, sizeof kept, "kept");
    assert_int_equal(file_write_atomic(kept, "old", 3), SNELL_OK);
    assert_int_equal(in_child(write_over_the_limit), 0);
    int full = in_child(write_to_a_full_disk);
    if (full == 77) printf("NOT TESTED: a full disk (needs the right to mount)\n");
    assert_true(full == 0 || full == 77);
    assert_int_equal(chmod(folder, 0555), 0);
    int forbidden = in_child(write_where_it_is_forbidden);
    assert_int_equal(chmod(folder, 0700), 0);
    if (forbidden == 77) printf("NOT TESTED: a folder without permission\n");
    assert_true(forbidden == 0 || forbidden == 77);
    assert_content(kept, "old");
    assert_int_equal(entries(false), 1);

    char path[1024];
    path_in(path, sizeof path, "nowhere/a.png");
    assert_int_equal(file_write_atomic(path, "x", 1), SNELL_ERR_IO);
    assert_string_equal(error_last()->text, "cannot write: there is no such folder");
    assert_string_equal(error_last()->file, path);
    path_in(path, sizeof path, "kept/a.png");
    assert_int_equal(file_write_atomic(path, "x", 1), SNELL_ERR_IO);
    assert_int_equal(file_write_atomic(folder, "x", 1), SNELL_ERR_IO);
    assert_string_equal(error_last()->text, "cannot write: it is a folder");
    assert_content(kept, "old");
    assert_int_equal(entries(true), 1);
}

/* A reader never sees a part: it sees all a or all b, at full length. */
static bool reader_failed, writer_done;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void *read_again_and_again(void *argument) {
    (void)argument;
    for (;;) {
        pthread_mutex_lock(&lock);
        bool done = writer_done;
        pthread_mutex_unlock(&lock);
        if (done) return NULL;
        FILE *file = fopen(kept, "rb");
        static char got[100001];
        size_t size = file ? fread(got, 1, sizeof got, file) : 0;
        if (file) fclose(file);
        bool whole = size == 100000;
        for (size_t i = 1; whole && i < size; i++) whole = got[i] == got[0];
        if (whole) continue;
        pthread_mutex_lock(&lock);
        reader_failed = true;
        pthread_mutex_unlock(&lock);
    }
}

static void a_reader_sees_old_or_new(void **state) {
    (void)state;
    static char content[100000];
    path_in(kept, sizeof kept, "kept");
    memset(content, 'a', sizeof content);
    assert_int_equal(file_write_atomic(kept, content, sizeof content), SNELL_OK);
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, read_again_and_again, NULL), 0);
    for (int i = 0; i < 100; i++) {
        memset(content, 'a' + i % 2, sizeof content);
        assert_int_equal(file_write_atomic(kept, content, sizeof content), SNELL_OK);
    }
    pthread_mutex_lock(&lock);
    writer_done = true;
    pthread_mutex_unlock(&lock);
    pthread_join(thread, NULL);
    assert_false(reader_failed);
    assert_int_equal(entries(true), 1);
}

static void pictures_go_to_files(void **state) {
    (void)state;
    char path[512];
    image_pixels pixels = make_picture(3);
    image_options options = {.tag = "a tag", .map = map_of("neutral")};
    path_in(path, sizeof path, "picture.png");
    assert_int_equal(image_write(path, &pixels, &options), SNELL_OK);
    image_info info;
    assert_int_equal(image_read_info(path, &info), SNELL_OK);
    assert_string_equal(info.tag, "a tag");
    assert_true(info.width == WIDTH);
    image_info_free(&info);
    assert_int_equal(truncate(path, 20), 0);
    assert_int_equal(image_read_info(path, &info), SNELL_ERR_SYNTAX);
    assert_string_equal(error_last()->file, path);
    assert_int_equal(entries(true), 1);
    assert_int_equal(image_read_info(path, &info), SNELL_ERR_IO);
    assert_string_equal(error_last()->text, "there is no such file");
    assert_int_equal(image_read_info(folder, &info), SNELL_ERR_IO);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tone_maps_have_their_closed_forms),
        cmocka_unit_test(every_tone_map_is_finite_and_grows),
        cmocka_unit_test(aces_and_agx_are_as_published),
        cmocka_unit_test(d65_and_greys_change_nothing),
        cmocka_unit_test(the_light_turns_white),
        cmocka_unit_test(bradford_is_as_tabulated),
        cmocka_unit_test(the_locus_has_no_steps),
        cmocka_unit_test(what_is_no_light_is_refused),
        cmocka_unit_test(eight_bits_are_the_nearest),
        cmocka_unit_test(png_reads_back),
        cmocka_unit_test(pfm_and_ppm_read_back),
        cmocka_unit_test(exr_reads_back),
        cmocka_unit_test(sixteen_bits_are_the_nearest),
#if SNELL_HAS_OPENEXR
        cmocka_unit_test(halves_are_the_nearest),
#endif
        cmocka_unit_test(heads_and_tags_read_back),
        cmocka_unit_test(what_a_format_has_not_is_refused),
        cmocka_unit_test(what_cannot_be_written_is_refused),
        cmocka_unit_test(broken_heads_are_errors),
        cmocka_unit_test(a_file_is_replaced),
        cmocka_unit_test(links_are_written_through),
        cmocka_unit_test(devices_and_pipes_are_written_directly),
        cmocka_unit_test(an_old_file_survives_every_failure),
        cmocka_unit_test(a_reader_sees_old_or_new),
        cmocka_unit_test(pictures_go_to_files),
    };
    int failed = cmocka_run_group_tests(tests, make_folder, remove_folder);
    reference_free();
    return failed;
}
