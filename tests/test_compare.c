/* Pictures read into films, and compared: against numbers computed by hand, and against chance. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <jansson.h>
#include <png.h>
#include <sys/wait.h>
#include <unistd.h>

#if SNELL_HAS_OPENEXR
#include <OpenEXR/openexr.h>
#endif
#if SNELL_HAS_JPEG
#include <turbojpeg.h>
#endif

#include "api/api.h"
#include "image/codec.h"
#include "image/compare.h"
#include "image/magma.h"
#include "image/srgb.h"
#include "importers/picture.h"
#include "maths/functions.h"
#include "statistics.h"

static char folder[] = "/tmp/snell-test-compare-XXXXXX";
static snell_context *context;
static int warnings;
static char last_warning[256];

static void keep_warning(void *user, const snell_message *m) {
    (void)user;
    if (m->severity < SNELL_WARNING) return;
    warnings++;
    snprintf(last_warning, sizeof last_warning, "%s", m->text);
}

static int set_up(void **state) {
    (void)state;
    snell_context_desc desc = SNELL_INIT(context_desc);
    desc.log = keep_warning;
    desc.thread_count = 2;
    return mkdtemp(folder) && snell_context_create(&desc, &context) == SNELL_OK ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    char command[300];
    snell_context_destroy(context);
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static const char *path_of(const char *name) {
    static char path[300];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static void write_file(const char *name, const void *data, size_t size) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static snell_film *new_film(void) {
    snell_film *f = NULL;
    assert_int_equal(snell_film_create(context, &f), SNELL_OK);
    return f;
}

/* A film of these values; NULL: black. */
static snell_film *film_of(uint32_t width, uint32_t height, uint32_t channels,
                           const float *values) {
    snell_film *f = new_film();
    assert_int_equal(film_resize(&f->film, width, height, channels), SNELL_OK);
    if (values) memcpy(f->film.pixels, values, sizeof(float) * width * height * channels);
    return f;
}

static snell_status read_layer(snell_film *f, const char *name, const char *layer) {
    snell_film_read_desc desc = SNELL_INIT(film_read_desc);
    desc.layer = layer;
    return snell_film_read(f, path_of(name), &desc);
}

static snell_film *read_film(const char *name, const char *layer) {
    snell_film *f = new_film();
    snell_status status = read_layer(f, name, layer);
    if (status) fail_msg("%s %s: %s", name, layer ? layer : "", snell_last_error()->text);
    return f;
}

static void encode_file(const char *name, const char *format, const image_pixels *pixels,
                        const image_options *options) {
    const image_codec *codec;
    void *data;
    size_t size;
    assert_int_equal(image_codec_find(format, &codec), SNELL_OK);
    assert_int_equal(image_encode(codec, pixels, options, &data, &size), SNELL_OK);
    write_file(name, data, size);
    free(data);
}

static uint64_t random_state = 1;
static uint64_t random_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
static double random_double(void) { return ((double)(random_bits() >> 11) + 0.5) * 0x1p-53; }

/* ---- reading ---- */

enum { WIDTH = 23, HEIGHT = 11, PIXELS = WIDTH * HEIGHT };
static float values[PIXELS * 4];

static image_pixels make_values(uint32_t channels) {
    for (size_t i = 0; i < PIXELS; i++) {
        float alpha = channels == 4 ? (float)(i % 5) / 4 : 1;
        for (uint32_t c = 0; c < 3; c++)
            values[i * channels + c] = (float)(random_double() * 1.3) * alpha;
        if (channels == 4) values[i * 4 + 3] = alpha;
    }
    return (image_pixels){values, WIDTH, HEIGHT, channels};
}

static void linear_files_keep_every_bit(void **state) {
    (void)state;
    static const char *const formats[] = {"pfm", "exr"};
    for (int i = 0; i < 1 + SNELL_HAS_OPENEXR; i++)
        for (uint32_t channels = 3; channels <= 4; channels++) {
            image_pixels pixels = make_values(channels);
            values[7] = -3.5f, values[8] = INFINITY, values[40] = NAN, values[50] = 1e-42f;
            encode_file("picture", formats[i], &pixels, NULL);
            warnings = 0;
            snell_film *f = read_film("picture", NULL);
            uint32_t width, height, got_channels;
            const float *got = snell_film_pixels(f, &width, &height, &got_channels);
            assert_true(width == WIDTH && height == HEIGHT);
            assert_int_equal(got_channels, i == 0 ? 3 : channels); /* PFM has no alpha */
            if (got_channels == channels)
                assert_memory_equal(got, values, sizeof(float) * PIXELS * channels);
            assert_int_equal(f->film.encoded_bits, 0);
            assert_int_equal(warnings, 1);
            char wanted[100];
            size_t first = 8 / channels;
            snprintf(wanted, sizeof wanted, "2 pixels are NaN or infinite, the first at %zu,0",
                     first);
            assert_string_equal(last_warning, wanted);
            snell_film_destroy(f);
        }
}

/* Read and written again, a file for screens has the same bytes. */
static void screen_files_keep_every_byte(void **state) {
    (void)state;
    static const char *const formats[] = {"png", "ppm"};
    for (int i = 0; i < 2; i++)
        for (uint32_t channels = 3; channels <= 4; channels++) {
            image_pixels pixels = make_values(channels);
            encode_file("picture", formats[i], &pixels, NULL);
            snell_film *f = read_film("picture", NULL);
            assert_int_equal(f->film.encoded_bits, 8);
            void *data;
            size_t size;
            assert_int_equal(snell_film_encode(f, formats[i], NULL, &data, &size), SNELL_OK);
            FILE *file = fopen(path_of("picture"), "rb");
            assert_non_null(file);
            unsigned char *bytes = malloc(size + 1);
            assert_non_null(bytes);
            assert_int_equal(fread(bytes, 1, size + 1, file), size);
            assert_memory_equal(bytes, data, size);
            fclose(file);
            free(bytes);
            snell_free(data);
            snell_film_destroy(f);
        }
}

static bool near(float a, double b, double tolerance) { return fabs((double)a - b) <= tolerance; }

static void write_png(const char *name, int color, int bits, const uint8_t *bytes) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    assert_non_null(info);
    if (setjmp(png_jmpbuf(png))) fail_msg("libpng");
    png_init_io(png, file);
    png_set_IHDR(png, info, 2, 1, bits, color, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_write_row(png, bytes);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(file), 0);
}

static void every_depth_and_kind_is_read(void **state) {
    (void)state;
    const uint8_t wide[] = {0x12, 0x34, 0xff, 0xff, 0,    0,    0x80, 0,
                            0,    1,    0x80, 0,    0xff, 0xff, 0x40, 0};
    write_png("wide.png", PNG_COLOR_TYPE_RGB_ALPHA, 16, wide);
    snell_film *f = read_film("wide.png", NULL);
    assert_true(f->film.encoded_bits == 16 && f->film.channels == 4);
    double alpha = 0x8000 / 65535.0;
    assert_true(near(f->film.pixels[0], srgb_decode(0x1234 / 65535.0) * alpha, 1e-7));
    assert_true(near(f->film.pixels[1], alpha, 1e-7) && near(f->film.pixels[3], alpha, 1e-7));
    assert_true(near(f->film.pixels[4], srgb_decode(1 / 65535.0) * 0.25, 1e-4));
    snell_film_destroy(f);

    write_png("grey.png", PNG_COLOR_TYPE_GRAY, 8, (const uint8_t[]){10, 200});
    f = read_film("grey.png", NULL);
    assert_true(f->film.channels == 3 && f->film.encoded_bits == 8);
    for (int c = 0; c < 3; c++) assert_true(f->film.pixels[3 + c] == srgb_table()[200]);
    snell_film_destroy(f);

    const char ppm[] = "P6 # a comment\n1 2\n1000\n\x03\xe8\0\0\x01\xf4\0\x01\0\x02\0\x03";
    write_file("wide.ppm", ppm, sizeof ppm - 1);
    f = read_film("wide.ppm", NULL);
    assert_true(f->film.encoded_bits == 16 && f->film.height == 2 && f->film.pixels[0] == 1);
    assert_true(near(f->film.pixels[2], srgb_decode(0.5), 1e-5) && f->film.pixels[1] == 0);
    snell_film_destroy(f);

    const char pgm[] = "P5\n2 1\n15\n\x0f\x05";
    write_file("grey.pgm", pgm, sizeof pgm - 1);
    f = read_film("grey.pgm", NULL);
    assert_true(f->film.encoded_bits == 8 && f->film.pixels[0] == 1);
    assert_true(f->film.pixels[4] == srgb_table()[85]);
    snell_film_destroy(f);

    const char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x83";
    write_file("sky.hdr", hdr, sizeof hdr - 1);
    f = read_film("sky.hdr", NULL);
    assert_true(f->film.encoded_bits == 0 && f->film.channels == 3);
    assert_true(f->film.pixels[0] == 4 && f->film.pixels[1] == 2 && f->film.pixels[2] == 1);
    snell_film_destroy(f);
#if SNELL_HAS_JPEG
    enum { SIDE_OF_JPEG = 64 };
    static uint8_t grey[SIDE_OF_JPEG * SIDE_OF_JPEG * 3];
    memset(grey, 77, sizeof grey);
    unsigned char *jpeg = NULL;
    unsigned long size = 0;
    tjhandle tj = tjInitCompress();
    for (int noise = 0; noise < 2; noise++) {
        for (size_t i = 0; noise && i < sizeof grey; i++) grey[i] = (uint8_t)random_bits();
        assert_int_equal(tjCompress2(tj, grey, SIDE_OF_JPEG, 0, SIDE_OF_JPEG, TJPF_RGB, &jpeg,
                                     &size, TJSAMP_444, 90, 0),
                         0);
        warnings = 0;
        write_file("grey.jpg", jpeg, noise ? size / 2 : size);
        f = read_film("grey.jpg", NULL);
        assert_true(f->film.width == SIDE_OF_JPEG && f->film.encoded_bits == 8);
        if (!noise) assert_true(f->film.pixels[5] == srgb_table()[77]);
        assert_int_equal(warnings, noise);
        if (noise) assert_non_null(strstr(last_warning, "damaged"));
        snell_film_destroy(f);
    }
    tjDestroy(tj);
    tjFree(jpeg);
#endif
}

/* ---- layers of OpenEXR files ---- */

#if SNELL_HAS_OPENEXR

typedef struct exr_part {
    const char *name; /* NULL: none */
    const char *channels[12];
    exr_pixel_type_t type; /* of all */
} exr_part;

/* Channel c of part p holds 100 p + c + x / 8 at column x. */
static float exr_value(int part, int channel, int x) {
    return (float)(100 * part + channel) + (float)x / 8;
}

static void write_part_head(exr_context_t file, const exr_part *part, int parts) {
    int index;
    assert_int_equal(exr_add_part(file, part->name, EXR_STORAGE_SCANLINE, &index), 0);
    assert_int_equal(exr_initialize_required_attr_simple(file, index, 4, 3, EXR_COMPRESSION_ZIPS),
                     0);
    if (parts > 1) assert_int_equal(exr_set_version(file, index, 1), 0);
    for (int c = 0; part->channels[c]; c++)
        assert_int_equal(exr_add_channel(file, index, part->channels[c], part->type,
                                         EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
                         0);
}

static void write_part_rows(exr_context_t file, int index, const exr_part *part,
                            float (*value)(int part, int channel, int x)) {
    static float rows[16][4];
    static uint32_t numbers[16][4];
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    for (int y = 0; y < 3; y++) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_write_scanline_chunk_info(file, index, y, &chunk), 0);
        assert_int_equal(y ? exr_encoding_update(file, index, &chunk, &pipeline)
                           : exr_encoding_initialize(file, index, &chunk, &pipeline),
                         0);
        for (int c = 0; c < pipeline.channel_count; c++) {
            exr_coding_channel_info_t *channel = &pipeline.channels[c];
            int k = 0;
            while (strcmp(part->channels[k], channel->channel_name) != 0) k++;
            for (int x = 0; x < 4; x++) {
                rows[c][x] = value(index, k, x);
                numbers[c][x] = (uint32_t)rows[c][x];
            }
            bool whole = part->type == EXR_PIXEL_UINT;
            channel->encode_from_ptr = whole ? (uint8_t *)numbers[c] : (uint8_t *)rows[c];
            channel->user_bytes_per_element = 4;
            channel->user_data_type = whole ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
            channel->user_pixel_stride = 4;
            channel->user_line_stride = 16;
        }
        if (y == 0)
            assert_int_equal(exr_encoding_choose_default_routines(file, index, &pipeline), 0);
        assert_int_equal(exr_encoding_run(file, index, &pipeline), 0);
    }
    exr_encoding_destroy(file, &pipeline);
}

static void write_exr_of(const char *name, const exr_part *parts, int count,
                         float (*value)(int part, int channel, int x)) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    assert_int_equal(exr_start_write(&file, path_of(name), EXR_WRITE_FILE_DIRECTLY, &setup), 0);
    for (int i = 0; i < count; i++) write_part_head(file, &parts[i], count);
    assert_int_equal(exr_write_header(file), 0);
    for (int i = 0; i < count; i++) write_part_rows(file, i, &parts[i], value);
    assert_int_equal(exr_finish(&file), 0);
}

static void write_exr(const char *name, const exr_part *parts, int count) {
    write_exr_of(name, parts, count, exr_value);
}

/* The layer's first pixels are of these channels of the part; -1: the value 0. */
static void check_layer(const char *name, const char *layer, int part, int red, int green,
                        int blue) {
    int of[] = {red, green, blue};
    snell_film *f = read_film(name, layer);
    assert_true(f->film.width == 4 && f->film.height == 3 && f->film.encoded_bits == 0);
    for (int x = 0; x < 4; x++)
        for (int c = 0; c < 3; c++) {
            float wanted = of[c] < 0 ? 0 : exr_value(part, of[c], x);
            float got = f->film.pixels[x * (int)f->film.channels + c];
            if (got != wanted)
                fail_msg("%s %s: %g at %d, channel %d, not %g", name, layer ? layer : "",
                         (double)got, x, c, (double)wanted);
        }
    snell_film_destroy(f);
}

static void check_layers(const char *name, const char *const *wanted) {
    snell_film *f = read_film(name, NULL);
    uint32_t i = 0;
    for (; wanted[i]; i++) assert_string_equal(snell_film_layer(f, i), wanted[i]);
    assert_null(snell_film_layer(f, i));
    assert_null(snell_film_layer(f, UINT32_MAX));
    snell_film_destroy(f);
}

static void layers_are_found_by_name(void **state) {
    (void)state;
    const exr_part one = {.channels = {"R", "G", "B", "Z", "variance.R", "variance.G", "variance.B",
                                       "depth.Z", "N.X", "N.Y", "N.Z"},
                          .type = EXR_PIXEL_FLOAT};
    write_exr("one.exr", &one, 1);
    check_layer("one.exr", NULL, 0, 0, 1, 2);
    check_layer("one.exr", "", 0, 0, 1, 2);
    check_layer("one.exr", "variance", 0, 4, 5, 6);
    check_layer("one.exr", "depth", 0, 7, 7, 7);
    check_layer("one.exr", "depth.Z", 0, 7, 7, 7);
    check_layer("one.exr", "N", 0, 8, 9, 10);
    check_layer("one.exr", "N.Y", 0, 9, 9, 9);
    check_layer("one.exr", "Z", 0, 3, 3, 3);
    /* one that is not wanted, beside two of 16 bits */
    const exr_part three = {.channels = {"R", "G", "Z"}, .type = EXR_PIXEL_HALF};
    write_exr("three.exr", &three, 1);
    check_layer("three.exr", NULL, 0, 0, 1, -1);
    check_layers("one.exr", (const char *const[]){"N", "Z", "depth", "variance", NULL});

    const exr_part many[] = {
        {"beauty", {"R", "G", "B", "A"}, EXR_PIXEL_HALF},
        {"variance", {"R", "G", "B"}, EXR_PIXEL_FLOAT},
        {"uv", {"U", "V"}, EXR_PIXEL_FLOAT},
        {"ids", {"object.id", "light.key.R", "light.key.G", "light.key.B"}, EXR_PIXEL_UINT}};
    write_exr("many.exr", many, 4);
    check_layer("many.exr", NULL, 0, 0, 1, 2);
    check_layer("many.exr", "beauty", 0, 0, 1, 2);
    check_layer("many.exr", "variance", 1, 0, 1, 2);
    check_layer("many.exr", "uv", 2, 0, 1, -1);
    check_layers("many.exr", (const char *const[]){"beauty", "variance", "uv", "ids", "light.key",
                                                   "object", NULL});
    snell_film *f = read_film("many.exr", "object");
    assert_true(f->film.pixels[0] == 300 && f->film.pixels[3 * 3 + 2] == 300);
    snell_film_destroy(f);
    f = read_film("many.exr", "beauty");
    assert_true(f->film.channels == 4 && f->film.pixels[3] == 3);
    snell_film_destroy(f);
}

static void missing_layers_are_named(void **state) {
    (void)state;
    const exr_part deep = {
        .channels = {"View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Depth.Z"},
        .type = EXR_PIXEL_FLOAT};
    write_exr("deep.exr", &deep, 1);
    snell_film *f = film_of(1, 1, 3, NULL);
    assert_int_equal(read_layer(f, "deep.exr", NULL), SNELL_ERR_SYNTAX);
    assert_string_equal(snell_last_error()->hint, "its layers: View.Combined, View.Depth");
    assert_int_equal(read_layer(f, "deep.exr", "View.Dept"), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->text, "there is no layer 'View.Dept'");
    assert_string_equal(snell_last_error()->hint, "did you mean 'View.Depth'?");
    check_layer("deep.exr", "View.Combined", 0, 0, 1, 2);
    image_pixels pixels = make_values(3);
    encode_file("plain.png", "png", &pixels, NULL);
    encode_file("plain.exr", "exr", &pixels, NULL);
    assert_int_equal(read_layer(f, "plain.png", "variance"), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->hint, "only OpenEXR files do");
    assert_int_equal(read_layer(f, "plain.exr", "variance"), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->hint, "it has no layers");
    assert_true(f->film.width == 1); /* as before */
    snell_film_destroy(f);
}

/* ---- tiles ---- */

enum { TILED_WIDTH = 11, TILED_HEIGHT = 7, TILE_WIDTH = 4, TILE_HEIGHT = 3 };

/* Of level 0; other levels are all -1. */
static float tiled_value(int channel, int x, int y) { return (float)(100 * channel + 10 * y + x); }

static void write_tile(exr_context_t file, int x, int y, int level) {
    static float pixels[3][TILE_WIDTH * TILE_HEIGHT];
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    assert_int_equal(exr_write_tile_chunk_info(file, 0, x, y, level, level, &chunk), 0);
    assert_int_equal(exr_encoding_initialize(file, 0, &chunk, &pipeline), 0);
    for (int c = 0; c < 3; c++) {
        exr_coding_channel_info_t *channel = &pipeline.channels[c]; /* B, G, R */
        for (int i = 0; i < chunk.width * chunk.height; i++)
            pixels[c][i] = level ? -1
                                 : tiled_value(2 - c, x * TILE_WIDTH + i % chunk.width,
                                               y * TILE_HEIGHT + i / chunk.width);
        channel->encode_from_ptr = (uint8_t *)pixels[c];
        channel->user_bytes_per_element = 4;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4;
        channel->user_line_stride = 4 * chunk.width;
    }
    assert_int_equal(exr_encoding_choose_default_routines(file, 0, &pipeline), 0);
    assert_int_equal(exr_encoding_run(file, 0, &pipeline), 0);
    exr_encoding_destroy(file, &pipeline);
}

/* Its corner is not at 0, 0. */
static void write_tiles(const char *name, exr_pixel_type_t type, exr_compression_t compression,
                        exr_tile_level_mode_t mode) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    int index, levels = 1;
    exr_attr_box2i_t window;
    window.min.x = -2, window.max.x = TILED_WIDTH - 3;
    window.min.y = 5, window.max.y = TILED_HEIGHT + 4;
    const exr_attr_v2f_t middle = {.x = 0, .y = 0};
    assert_int_equal(exr_start_write(&file, path_of(name), EXR_WRITE_FILE_DIRECTLY, &setup), 0);
    assert_int_equal(exr_add_part(file, NULL, EXR_STORAGE_TILED, &index), 0);
    assert_int_equal(exr_initialize_required_attr(file, 0, &window, &window, 1, &middle, 1,
                                                  EXR_LINEORDER_INCREASING_Y, compression),
                     0);
    assert_int_equal(
        exr_set_tile_descriptor(file, 0, TILE_WIDTH, TILE_HEIGHT, mode, EXR_TILE_ROUND_DOWN), 0);
    for (int c = 0; c < 3; c++)
        assert_int_equal(
            exr_add_channel(file, 0, &"B\0G\0R"[2 * c], type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
            0);
    assert_int_equal(exr_write_header(file), 0);
    if (mode == EXR_TILE_MIPMAP_LEVELS)
        assert_int_equal(exr_get_tile_levels(file, 0, &levels, NULL), 0);
    for (int level = 0; level < levels; level++) {
        int width = TILED_WIDTH >> level, height = TILED_HEIGHT >> level;
        if (width < 1) width = 1;
        if (height < 1) height = 1;
        for (int y = 0; y * TILE_HEIGHT < height; y++)
            for (int x = 0; x * TILE_WIDTH < width; x++) write_tile(file, x, y, level);
    }
    assert_int_equal(exr_finish(&file), 0);
}

/* Not compressed: OpenEXRCore 3.1 writes some small tiles wrong that are. test_cli_compare.sh reads others. */
static void tiles_are_read(void **state) {
    (void)state;
    for (int i = 0; i < 4; i++) {
        write_tiles("tiled.exr", i % 2 ? EXR_PIXEL_FLOAT : EXR_PIXEL_HALF, EXR_COMPRESSION_NONE,
                    i / 2 ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL);
        snell_film *f = read_film("tiled.exr", NULL);
        assert_true(f->film.width == TILED_WIDTH && f->film.height == TILED_HEIGHT);
        for (int k = 0; k < TILED_WIDTH * TILED_HEIGHT * 3; k++) {
            int x = k / 3 % TILED_WIDTH, y = k / 3 / TILED_WIDTH;
            float wanted = tiled_value(k % 3, x, y);
            if (f->film.pixels[k] != wanted)
                fail_msg("file %d: %g at %d,%d, channel %d, not %g", i, (double)f->film.pixels[k],
                         x, y, k % 3, (double)wanted);
        }
        snell_film_destroy(f);
    }
}

/* Bytes that were changed: an error or a picture, and no end but that. */
static void broken_tiles_are_survived(void **state) {
    (void)state;
    static uint8_t whole[1 << 14], bad[sizeof whole];
    write_tiles("tiled.exr", EXR_PIXEL_HALF, EXR_COMPRESSION_ZIP, EXR_TILE_MIPMAP_LEVELS);
    FILE *from = fopen(path_of("tiled.exr"), "rb");
    assert_non_null(from);
    size_t size = fread(whole, 1, sizeof whole, from), refused = 0;
    fclose(from);
    assert_true(size > 300 && size < sizeof whole);
    snell_film *f = new_film();
    for (size_t at = 4; at < size; at += 13) {
        memcpy(bad, whole, size);
        bad[at] ^= 0xff;
        write_file("bad.exr", bad, at % 2 ? size : at);
        refused += read_layer(f, "bad.exr", NULL) != SNELL_OK;
    }
    assert_true(refused > 10);
    /* the tile's size: more than there can be memory for, and none */
    static const char attribute[] = "tiles\0tiledesc\0\11\0\0";
    uint8_t *tile = memmem(whole, size, attribute, sizeof attribute);
    assert_non_null(tile);
    for (int value = 0; value < 256; value += 127) {
        memset(tile + sizeof attribute, value, 8);
        write_file("bad.exr", whole, size);
        assert_int_equal(read_layer(f, "bad.exr", NULL), SNELL_ERR_SYNTAX);
    }
    snell_film_destroy(f);
}

static void deep_pixels_are_refused(void **state) {
    (void)state;
    static uint8_t whole[1 << 14];
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    int index;
    assert_int_equal(exr_start_write(&file, path_of("deep.exr"), EXR_WRITE_FILE_DIRECTLY, &setup),
                     0);
    assert_int_equal(exr_add_part(file, "deep", EXR_STORAGE_DEEP_SCANLINE, &index), 0);
    assert_int_equal(exr_initialize_required_attr_simple(file, 0, 4, 1, EXR_COMPRESSION_ZIPS), 0);
    assert_int_equal(exr_set_version(file, 0, 1), 0);
    assert_int_equal(
        exr_add_channel(file, 0, "R", EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), 0);
    assert_int_equal(exr_write_header(file), 0);
    memset(whole, 0, sizeof whole);
    assert_int_equal(exr_write_deep_scanline_chunk(file, 0, 0, whole, 16, 16, whole, 16), 0);
    assert_int_equal(exr_finish(&file), 0);
    snell_film *f = new_film();
    assert_int_equal(read_layer(f, "deep.exr", NULL), SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(snell_last_error()->text, "deep pixels"));
    snell_film_destroy(f);
}

static void what_openexr_cannot_do_is_said(void **state) {
    (void)state;
    image_pixels pixels = make_values(3);
    memset(values, 0, sizeof values); /* what does not compress is stored as it is */
    const image_codec *codec;
    void *data;
    size_t size;
    assert_int_equal(image_codec_find("exr", &codec), SNELL_OK);
    assert_int_equal(image_encode(codec, &pixels, NULL, &data, &size), SNELL_OK);
    static const char attribute[] = "compression\0compression\0\1\0\0";
    uint8_t *at = memmem(data, size, attribute, sizeof attribute);
    assert_non_null(at);
    at[sizeof attribute] = EXR_COMPRESSION_DWAA;
    write_file("dwa.exr", data, size);
    free(data);
    snell_film *f = new_film();
    assert_int_equal(read_layer(f, "dwa.exr", NULL), SNELL_ERR_UNSUPPORTED);
    assert_non_null(strstr(snell_last_error()->hint, "ZIP"));
    write_tiles("b44.exr", EXR_PIXEL_FLOAT, EXR_COMPRESSION_B44, EXR_TILE_ONE_LEVEL);
    assert_int_equal(read_layer(f, "b44.exr", NULL), SNELL_ERR_UNSUPPORTED);
    snell_film_destroy(f);
}

#endif

/* ---- files from anybody ---- */

static void bad_files_are_refused(void **state) {
    (void)state;
    snell_film *f = film_of(1, 1, 3, NULL);
    static const char *const formats[] = {"pfm", "png", "ppm", "exr"};
    for (int i = 0; i < 3 + SNELL_HAS_OPENEXR; i++) {
        image_pixels pixels = make_values(4);
        const image_codec *codec;
        void *data;
        size_t size;
        assert_int_equal(image_codec_find(formats[i], &codec), SNELL_OK);
        assert_int_equal(image_encode(codec, &pixels, NULL, &data, &size), SNELL_OK);
        for (size_t cut = 4; cut < size; cut += 1 + size / 40) {
            write_file("cut", data, cut);
            snell_status status = read_layer(f, "cut", NULL);
            if (status != SNELL_ERR_SYNTAX && status != SNELL_ERR_UNSUPPORTED)
                fail_msg("%s cut at %zu of %zu: status %d", formats[i], cut, size, (int)status);
            assert_non_null(strstr(snell_last_error()->file, "cut"));
        }
        free(data);
    }
    static const struct {
        const char *content;
        snell_status status;
        const char *text;
    } rows[] = {
        {"hello, this is no picture", SNELL_ERR_UNSUPPORTED, "no picture that snell reads"},
        {"P6 100000 3 255\n", SNELL_ERR_SYNTAX, "100000 x 3 pixels cannot be read"},
        {"P6 65536 65536 255\n", SNELL_ERR_UNSUPPORTED, "too large"},
        {"P6 0 3 255\n", SNELL_ERR_SYNTAX, "head"},
        {"P6 3 3 70000\n", SNELL_ERR_SYNTAX, "head"},
        {"P6 3 3", SNELL_ERR_SYNTAX, "head"},
        {"P6 3 3 255\nabc", SNELL_ERR_SYNTAX, "ends early"},
        {"PF\n65536 65536\n-1.0\n", SNELL_ERR_UNSUPPORTED, "too large"},
        {"PF\n-1 5\n-1.0\n", SNELL_ERR_SYNTAX, "cannot be read"},
        {"#?RADIANCE\n\n-Y 60000 +X 60000\n", SNELL_ERR_UNSUPPORTED, "too large"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        write_file("bad", rows[i].content, strlen(rows[i].content));
        snell_status status = read_layer(f, "bad", NULL);
        if (status != rows[i].status || !strstr(snell_last_error()->text, rows[i].text))
            fail_msg("%s: status %d, %s", rows[i].content, (int)status, snell_last_error()->text);
    }
    write_file("bad", "", 0);
    assert_int_equal(read_layer(f, "bad", NULL), SNELL_ERR_SYNTAX);
    assert_int_equal(read_layer(f, "none", NULL), SNELL_ERR_IO);
    assert_int_equal(read_layer(f, ".", NULL), SNELL_ERR_IO);
    snell_film_read_desc desc = SNELL_INIT(film_read_desc);
    desc.allow_helper = false;
    assert_int_equal(snell_film_read(f, path_of("bad"), &desc), SNELL_ERR_UNSUPPORTED);
    desc.struct_size--;
    assert_int_equal(snell_film_read(f, path_of("bad"), &desc), SNELL_ERR_VERSION);
    assert_int_equal(snell_film_read(NULL, "x", NULL), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_film_read(f, NULL, NULL), SNELL_ERR_ARGUMENT);
    assert_true(f->film.width == 1 && f->film.height == 1); /* as before */
    snell_film_destroy(f);
}

/* What comes back from snell-import is not trusted either. */

typedef struct block {
    uint8_t bytes[2048];
    size_t size;
} block;

static bool append(void *user, const void *data, size_t size) {
    block *b = user;
    assert_true(size <= sizeof b->bytes - b->size);
    memcpy(b->bytes + b->size, data, size);
    b->size += size;
    return true;
}

static bool is_taken(const void *bytes, size_t size) {
    helper_picture taken = {.layers = NULL};
    uint8_t *copy = malloc(size + 1); /* so that the address sanitizer sees a byte too far */
    assert_non_null(copy);
    memcpy(copy, bytes, size);
    snell_status status = picture_take(&taken, copy, size);
    assert_true(status == SNELL_OK || status == SNELL_ERR_SYNTAX || status == SNELL_ERR_MEMORY);
    assert_true((taken.film.pixels != NULL) == (status == SNELL_OK));
    film_free(&taken.film);
    free(taken.layers);
    free(copy);
    return status == SNELL_OK;
}

static void blocks_are_checked_again(void **state) {
    (void)state;
    static char names[] = "normal\0variance";
    static float pixels[5 * 3 * 4];
    picture p = {.header = {.magic = PICTURE_MAGIC, .width = 5, .height = 3, .channels = 4},
                 .layers = {names, sizeof names},
                 .pixels = pixels};
    p.header.names_size = sizeof names;
    block good = {.size = 0};
    assert_int_equal(picture_write(&p, append, &good), SNELL_OK);
    assert_true(is_taken(good.bytes, good.size));
    for (size_t size = 0; size < good.size; size++) assert_false(is_taken(good.bytes, size));
    block longer = good;
    longer.size++;
    assert_false(is_taken(longer.bytes, longer.size));
    int refused = 0;
    for (size_t at = 0; at < sizeof(picture_header); at++)
        for (int bit = 0; bit < 8; bit++) {
            block bad = good;
            bad.bytes[at] ^= (uint8_t)(1 << bit);
            refused += !is_taken(bad.bytes, bad.size);
        }
    assert_true(refused >= 300); /* of 320: but for other bits, and damaged */
    block bad = good;
    bad.bytes[sizeof(picture_header) + sizeof names - 1] = 'x'; /* a name without an end */
    assert_false(is_taken(bad.bytes, bad.size));
}

/* ---- numbers by hand ---- */

static snell_comparison compare(const snell_film *a, const snell_film *b,
                                const snell_compare_desc *desc) {
    snell_comparison out = {.struct_size = sizeof out};
    snell_status status = snell_film_compare(a, b, desc, &out);
    if (status) fail_msg("%s", snell_last_error()->text);
    return out;
}

static bool close_to(double a, double b) { return fabs(a - b) <= 1e-12 * (1 + fabs(b)); }

static void linear_metrics_are_as_defined(void **state) {
    (void)state;
    const float a[] = {0, 0.5f, 2, 1, 1, 1}, b[] = {0, 0.25f, 2.5f, 1, 1, 1};
    snell_film *left = film_of(2, 1, 3, a), *right = film_of(2, 1, 3, b);
    snell_comparison c = compare(left, right, NULL);
    double squares = 0.0625 + 0.25;
    assert_true(c.linear && c.width == 2 && c.height == 1 && c.not_finite == 0);
    assert_int_equal(c.differing, 1);
    assert_true(c.difference_max == 0.5 && c.difference_x == 0 && c.difference_y == 0);
    assert_true(close_to(c.rmse, sqrt(squares / 6)));
    assert_true(close_to(c.psnr, -10 * log10(squares / 6)));
    assert_true(close_to(c.rel_mse, (0.0625 / 0.26 + 0.25 / 4.01) / 6));
    assert_true(c.flip > 0 && c.z_values == 0);
    /* the reference decides what is relative */
    snell_comparison back = compare(right, left, NULL);
    assert_true(close_to(back.rel_mse, (0.0625 / 0.0725 + 0.25 / 6.26) / 6));
    assert_true(back.rmse == c.rmse);
    snell_comparison same = compare(left, left, NULL);
    assert_true(same.differing == 0 && same.rmse == 0 && same.rel_mse == 0 && same.flip == 0);
    assert_true(isinf(same.psnr) && same.difference_max == 0);
    snell_film_destroy(left);
    snell_film_destroy(right);
}

static void alpha_counts_where_there_is_any(void **state) {
    (void)state;
    const float a[] = {0.5f, 0.5f, 0.5f, 1}, b[] = {0.5f, 0.5f, 0.5f}, half[] = {0, 0, 0, 0.5f},
                none[] = {0, 0, 0, 0};
    snell_film *opaque = film_of(1, 1, 4, a), *rgb = film_of(1, 1, 3, b),
               *thin = film_of(1, 1, 4, half), *clear = film_of(1, 1, 4, none);
    assert_int_equal(compare(opaque, rgb, NULL).differing, 0);
    snell_comparison c = compare(thin, clear, NULL);
    assert_true(c.differing == 1 && c.difference_max == 0.5 && close_to(c.rmse, 0.25) &&
                c.flip == 0);
    snell_film_destroy(opaque);
    snell_film_destroy(rgb);
    snell_film_destroy(thin);
    snell_film_destroy(clear);
}

static void numbers_that_are_none_are_left_out(void **state) {
    (void)state;
    const float a[] = {NAN, 0, 0, 1, 1, 1, 0, INFINITY, 0}, b[] = {NAN, 0, 0, 1, 1, 0.5f, 0, 1, 0};
    snell_film *left = film_of(3, 1, 3, a), *right = film_of(3, 1, 3, b);
    snell_comparison c = compare(left, right, NULL);
    assert_int_equal(c.not_finite, 2);
    assert_int_equal(c.differing, 2); /* the NaN is the same in both */
    assert_true(close_to(c.rmse, sqrt(0.25 / 3)) && c.difference_max == 0.5 && c.difference_x == 1);
    assert_true(c.flip > 0 && c.flip <= 1);
    const float all[] = {NAN, NAN, NAN};
    snell_film *nothing = film_of(1, 1, 3, all), *black = film_of(1, 1, 3, NULL);
    c = compare(nothing, black, NULL);
    assert_true(c.not_finite == 1 && c.differing == 1 && c.rmse == 0 && c.flip == 0);
    snell_film_destroy(left);
    snell_film_destroy(right);
    snell_film_destroy(nothing);
    snell_film_destroy(black);
}

/* Of files for screens the bytes are compared. */
static void screens_are_compared_as_shown(void **state) {
    (void)state;
    image_pixels pixels = make_values(3);
    encode_file("a.png", "png", &pixels, NULL);
    snell_film *a = read_film("a.png", NULL), *b = read_film("a.png", NULL);
    b->film.pixels[3 * 5 + 1] = srgb_table()[10];
    a->film.pixels[3 * 5 + 1] = srgb_table()[30];
    snell_comparison c = compare(a, b, NULL);
    assert_true(!c.linear && c.differing == 1 && c.difference_x == 5 && c.difference_y == 0);
    assert_true(close_to(c.difference_max, 20 / 255.0));
    assert_true(close_to(c.rmse, 20 / 255.0 / sqrt(3.0 * PIXELS)));
    /* A linear picture beside one of 8 bits is what would have been written of it. */
    static const char *const maps[] = {"clip", "reinhard", "neutral"};
    for (uint32_t channels = 3; channels <= 4; channels++)
        for (int m = 0; m < 3; m++) {
            pixels = make_values(channels);
            snell_film *linear = film_of(WIDTH, HEIGHT, channels, values), *written = new_film();
            snell_image_desc look = SNELL_INIT(image_desc);
            look.tonemap = maps[m];
            look.exposure = 0.7f;
            look.exposure_set = true;
            assert_int_equal(snell_film_write(linear, path_of("look.png"), &look), SNELL_OK);
            assert_int_equal(read_layer(written, "look.png", NULL), SNELL_OK);
            snell_compare_desc desc = SNELL_INIT(compare_desc);
            desc.tonemap = maps[m];
            desc.exposure = 0.7f;
            assert_int_equal(compare(written, linear, &desc).differing, 0);
            assert_int_equal(compare(linear, written, &desc).differing, 0);
            desc.exposure = 0;
            assert_true(compare(written, linear, &desc).differing > 100);
            snell_film_destroy(linear);
            snell_film_destroy(written);
        }
    /* Two linear ones as shown keep what 8 bits would lose. */
    const float one[] = {0.5f, 3, 0}, other[] = {0.50001f, 2, 0};
    snell_film *left = film_of(1, 1, 3, one), *right = film_of(1, 1, 3, other);
    snell_compare_desc desc = SNELL_INIT(compare_desc);
    desc.as_shown = true;
    c = compare(left, right, &desc);
    double step = srgb_encode((double)0.50001f) - srgb_encode(0.5);
    assert_true(!c.linear && c.differing == 1 && fabs(c.difference_max - step) < 1e-12);
    snell_film_destroy(a);
    snell_film_destroy(b);
    snell_film_destroy(left);
    snell_film_destroy(right);
}

static void errors_are_drawn(void **state) {
    (void)state;
    image_pixels pixels = make_values(3);
    encode_file("a.png", "png", &pixels, NULL);
    snell_film *a = read_film("a.png", NULL), *b = read_film("a.png", NULL), *error = new_film();
    for (int i = 0; i < PIXELS; i++) b->film.pixels[3 * i + 1] = srgb_table()[i % 256];
    snell_compare_desc desc = SNELL_INIT(compare_desc);
    desc.error = error;
    desc.error_map = SNELL_ERROR_DIFFERENCE;
    compare(a, b, &desc);
    for (int i = 0; i < PIXELS; i++) { /* the bytes of the file are the differences of the bytes */
        int was = tonemap_quantize((double)a->film.pixels[3 * i + 1]);
        assert_int_equal(tonemap_quantize((double)error->film.pixels[3 * i + 1]),
                         abs(was - i % 256));
        assert_true(error->film.pixels[3 * i] == 0);
    }
    desc.error_values = true;
    compare(a, b, &desc);
    int was = tonemap_quantize((double)a->film.pixels[1]);
    assert_true(near(error->film.pixels[1], was / 255.0, 1e-7));
    desc.error_map = SNELL_ERROR_FLIP;
    snell_comparison c = compare(a, b, &desc);
    double sum = 0;
    static float flip[PIXELS];
    for (int i = 0; i < PIXELS; i++) sum += (double)(flip[i] = error->film.pixels[3 * i]);
    assert_true(fabs(sum / PIXELS - c.flip) < 1e-6);
    desc.error_values = false;
    compare(a, b, &desc);
    for (int i = 0; i < PIXELS; i++) {
        uint8_t wanted[3];
        magma_color((double)flip[i], wanted);
        for (int k = 0; k < 3; k++)
            assert_int_equal(tonemap_quantize((double)error->film.pixels[3 * i + k]), wanted[k]);
    }
    snell_film_destroy(a);
    snell_film_destroy(b);
    snell_film_destroy(error);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    snell_film *a = film_of(2, 3, 3, NULL), *b = film_of(3, 2, 3, NULL), *empty = new_film();
    snell_comparison out = {.struct_size = sizeof out};
    snell_compare_desc desc = SNELL_INIT(compare_desc);
    assert_int_equal(snell_film_compare(a, b, NULL, &out), SNELL_ERR_ARGUMENT);
    assert_string_equal(snell_last_error()->text,
                        "the picture has 3 x 2 pixels, the reference 2 x 3");
    assert_int_equal(snell_film_compare(a, empty, NULL, &out), SNELL_ERR_STATE);
    assert_int_equal(snell_film_compare(NULL, a, NULL, &out), SNELL_ERR_ARGUMENT);
    desc.error = a;
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    desc = SNELL_INIT(compare_desc);
    desc.reference_variance = b;
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    desc = SNELL_INIT(compare_desc);
    desc.variance_count = 1;
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    desc = SNELL_INIT(compare_desc);
    desc.exposure = NAN;
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    desc = SNELL_INIT(compare_desc);
    desc.pixels_per_degree = 0;
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    desc = SNELL_INIT(compare_desc);
    desc.tonemap = "sepia";
    assert_int_equal(snell_film_compare(a, a, &desc, &out), SNELL_ERR_ARGUMENT);
    out.struct_size = 1;
    assert_int_equal(snell_film_compare(a, a, NULL, &out), SNELL_ERR_VERSION);
    snell_film_destroy(a);
    snell_film_destroy(b);
    snell_film_destroy(empty);
}

/* ---- against chance ---- */

static void quantiles_are_those_of_the_tables(void **state) {
    (void)state;
    /* Two-sided 5 % and 0.1 %. */
    static const struct {
        uint32_t freedom;
        double five, tenth;
    } rows[] = {{1, 12.7062, 636.619},   {2, 4.30265, 31.5991}, {3, 3.18245, 12.9240},
                {4, 2.77645, 8.61030},   {5, 2.57058, 6.86883}, {30, 2.04227, 3.64596},
                {120, 1.97993, 3.37345}, {0, 1.95996, 3.29053}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        assert_true(fabs(student_quantile(0.05, rows[i].freedom) / rows[i].five - 1) < 1e-5);
        assert_true(fabs(student_quantile(0.001, rows[i].freedom) / rows[i].tenth - 1) < 1e-5);
    }
    assert_true(fabs(student_quantile(1e-9, 0) / normal_quantile(5e-10) - 1) < 1e-6);
}

static double normal(void) {
    return sqrt(-2 * log(random_double())) * cos(2 * PI * random_double());
}

enum { SIDE = 128 };

/* Each value is the mean of `count` normal numbers of that deviation around 1 + bias, and its
 * variance estimated from them. */
static void make_noise(int count, double deviation, double bias, snell_film **mean,
                       snell_film **variance) {
    *mean = film_of(SIDE, SIDE, 3, NULL);
    *variance = film_of(SIDE, SIDE, 3, NULL);
    for (size_t i = 0; i < SIDE * SIDE * 3; i++) {
        moments m = {0};
        for (int k = 0; k < count; k++) moments_add(&m, 1 + bias + deviation * normal());
        (*mean)->film.pixels[i] = (float)m.mean;
        (*variance)->film.pixels[i] = (float)(moments_error(&m) * moments_error(&m));
    }
}

static snell_comparison compare_noise(int count, double bias, bool both) {
    snell_film *a, *a_variance, *b, *b_variance;
    make_noise(count, 0.3, 0, &a, &a_variance);
    make_noise(count, both ? 0.3 : 0, bias, &b, &b_variance);
    snell_compare_desc desc = SNELL_INIT(compare_desc);
    desc.reference_variance = a_variance;
    desc.picture_variance = both ? b_variance : NULL;
    desc.variance_count = count > 100 ? 0 : (uint32_t)count;
    snell_comparison c = compare(a, b, &desc);
    snell_film_destroy(a);
    snell_film_destroy(b);
    snell_film_destroy(a_variance);
    snell_film_destroy(b_variance);
    return c;
}

static void chance_is_not_found_guilty(void **state) {
    (void)state;
    static const struct {
        int count;
        bool both;
        double least, most; /* share beyond the 5 % level */
    } rows[] = {{4, false, 0.047, 0.053},
                {4, true, 0.030, 0.053},
                {2, false, 0.047, 0.053},
                {16, true, 0.045, 0.053},
                {150, false, 0.047, 0.055}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        snell_comparison c = compare_noise(rows[i].count, 0, rows[i].both);
        double share = (double)c.z_beyond / (double)c.z_values;
        print_message("of %d, %s: %.4f beyond 5 %%, %d rejected\n", rows[i].count,
                      rows[i].both ? "both" : "one", share, (int)c.z_rejected);
        assert_int_equal(c.z_values, SIDE * SIDE * 3);
        assert_true(share > rows[i].least && share < rows[i].most);
        assert_true(c.z_rejected <= 1);
        /* a bias of one deviation of the means shows in the share */
        c = compare_noise(rows[i].count, 0.3 / sqrt(rows[i].count), rows[i].both);
        double biased = (double)c.z_beyond / (double)c.z_values;
        assert_true(biased > 1.3 * share);
    }
    /* ten deviations are found at every pixel, where the variances are known well */
    snell_comparison c = compare_noise(150, 3 / sqrt(150), false);
    assert_true(c.z_rejected > (uint64_t)(SIDE * SIDE * 0.99) && c.z_max > 10);
}

static void what_has_no_variance_must_be_equal(void **state) {
    (void)state;
    const float a[] = {1, 1, 1, 2, 2, 2}, b[] = {1.0000001f, 1, 1, 2, 2.5f, 2}, none[6] = {0},
                odd[] = {NAN, -1, INFINITY, 1, 1, 1};
    snell_film *left = film_of(2, 1, 3, a), *right = film_of(2, 1, 3, b),
               *zero = film_of(2, 1, 3, none), *strange = film_of(2, 1, 3, odd);
    snell_compare_desc desc = SNELL_INIT(compare_desc);
    desc.picture_variance = zero;
    snell_comparison c = compare(left, right, &desc);
    assert_true(c.z_values == 1 && c.z_beyond == 1 && c.z_rejected == 1);
    assert_true(isinf(c.z_max) && c.z_x == 1 && c.z_y == 0);
    desc.picture_variance = strange; /* variances that are none test nothing */
    c = compare(left, right, &desc);
    assert_true(c.z_values == 3 && c.z_rejected == 0 && c.z_max == 0.5);
    desc.as_shown = true;
    assert_int_equal(compare(left, right, &desc).z_values, 0);
    snell_film_destroy(left);
    snell_film_destroy(right);
    snell_film_destroy(zero);
    snell_film_destroy(strange);
}

/* ---- the command finds the variance in an EXR ---- */

#if SNELL_HAS_OPENEXR

static float noisy_value(int part, int channel, int x) {
    (void)part;
    return channel < 3 ? 1 + 0.02f * (float)x : 0.0001f; /* deviation 0.01 */
}
static float other_value(int part, int channel, int x) {
    return noisy_value(part, channel, x) + (channel < 3 ? 0.01f : 0);
}
static float far_value(int part, int channel, int x) {
    return noisy_value(part, channel, x) + (channel == 1 && x == 2 ? 0.07f : 0);
}

static json_t *run_compare(const char *arguments, int *code) {
    char command[500];
    snprintf(command, sizeof command,
             "cd %s && env -u SNELL_MODELS -u SNELL_FULL " TEST_BINARY_DIR
             "/snell compare --json %s 2>messages",
             folder, arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    json_t *root = json_loadf(pipe, 0, NULL);
    int status = pclose(pipe);
    assert_non_null(root);
    assert_true(WIFEXITED(status));
    *code = WEXITSTATUS(status);
    return root;
}

static json_int_t z_of(const json_t *root, const char *key) {
    return json_integer_value(json_object_get(json_object_get(root, "z_test"), key));
}

static void the_command_tests_against_chance(void **state) {
    (void)state;
    const exr_part layered = {.channels = {"R", "G", "B", "variance.R", "variance.G", "variance.B"},
                              .type = EXR_PIXEL_FLOAT};
    write_exr_of("mean.exr", &layered, 1, noisy_value);
    write_exr_of("other.exr", &layered, 1, other_value);
    write_exr_of("far.exr", &layered, 1, far_value);
    int code;
    json_t *root = run_compare("mean.exr other.exr --max-rejected 0", &code);
    assert_int_equal(code, 0);
    assert_true(z_of(root, "values") == 4 * 3 * 3 && z_of(root, "rejected") == 0);
    double z = json_real_value(json_object_get(json_object_get(root, "z_test"), "max"));
    assert_true(fabs(z - 1 / sqrt(2)) < 1e-4);
    json_decref(root);
    root = run_compare("mean.exr far.exr --max-rejected 2", &code); /* in all three rows */
    assert_int_equal(code, 1);
    assert_int_equal(z_of(root, "rejected"), 3);
    json_decref(root);
    /* four values each say less of their variance: 7 / sqrt(2) deviations could be chance */
    root = run_compare("mean.exr far.exr --max-rejected 0 --variance-count 4", &code);
    assert_int_equal(code, 0);
    assert_int_equal(z_of(root, "beyond"), 3);
    json_decref(root);
    root = run_compare("mean.exr far.exr --layer variance", &code);
    assert_int_equal(code, 0); /* the variances are equal, and have none of their own */
    assert_null(json_object_get(root, "z_test"));
    json_decref(root);
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_files_keep_every_bit),
        cmocka_unit_test(screen_files_keep_every_byte),
        cmocka_unit_test(every_depth_and_kind_is_read),
#if SNELL_HAS_OPENEXR
        cmocka_unit_test(layers_are_found_by_name),
        cmocka_unit_test(missing_layers_are_named),
        cmocka_unit_test(what_openexr_cannot_do_is_said),
        cmocka_unit_test(tiles_are_read),
        cmocka_unit_test(broken_tiles_are_survived),
        cmocka_unit_test(deep_pixels_are_refused),
#endif
        cmocka_unit_test(bad_files_are_refused),
        cmocka_unit_test(blocks_are_checked_again),
        cmocka_unit_test(linear_metrics_are_as_defined),
        cmocka_unit_test(alpha_counts_where_there_is_any),
        cmocka_unit_test(numbers_that_are_none_are_left_out),
        cmocka_unit_test(screens_are_compared_as_shown),
        cmocka_unit_test(errors_are_drawn),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(quantiles_are_those_of_the_tables),
        cmocka_unit_test(chance_is_not_found_guilty),
        cmocka_unit_test(what_has_no_variance_must_be_equal),
#if SNELL_HAS_OPENEXR
        cmocka_unit_test(the_command_tests_against_chance),
#endif
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
