/* Animations, read back by readers of their own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <png.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "image/movie.h"
#include "image/srgb.h"
#include "importers/image_decode.h"

enum { WIDTH = 21, HEIGHT = 13, FRAMES = 5 };

static float frame[WIDTH * HEIGHT * 4];

/* Something that moves, with every frame another. */
static image_pixels make_frame(uint32_t channels, int number) {
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        float *p = frame + (size_t)i * channels;
        int x = i % WIDTH, y = i / WIDTH;
        float alpha = channels == 4 && (x + number) % 3 == 0 ? 0.5f : 1;
        p[0] = alpha * (float)((x + number) % WIDTH) / WIDTH;
        p[1] = alpha * (float)y / HEIGHT;
        p[2] = alpha * (float)number / FRAMES;
        if (channels == 4) p[3] = alpha;
    }
    return (image_pixels){frame, WIDTH, HEIGHT, channels};
}

static uint8_t *shown_frame(uint32_t channels, int number) {
    image_pixels pixels = make_frame(channels, number);
    image_options options = {.map = tonemaps[0]};
    uint8_t *rows = malloc((size_t)WIDTH * HEIGHT * channels);
    assert_non_null(rows);
    for (uint32_t y = 0; y < HEIGHT; y++)
        image_row_8bit(&pixels, &options, y, channels, rows + (size_t)y * WIDTH * channels);
    return rows;
}

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

static bytes read_file(const char *path) {
    bytes b = {NULL, 0};
    FILE *from = fopen(path, "rb");
    assert_non_null(from);
    fseek(from, 0, SEEK_END);
    b.size = (size_t)ftell(from);
    rewind(from);
    b.data = malloc(b.size + 1);
    assert_non_null(b.data);
    assert_int_equal(fread(b.data, 1, b.size, from), b.size);
    fclose(from);
    return b;
}

static movie *begin(const char *path, double fps, const image_options *options) {
    const movie_format *format;
    movie *m;
    assert_int_equal(movie_format_find(NULL, path, &format), SNELL_OK);
    movie_sink sink = {.path = path};
    assert_int_equal(movie_create(format, &sink, fps, options, &m), SNELL_OK);
    return m;
}

static bytes make(const char *path, uint32_t channels, int frames, double fps, const char *tag,
                  uint32_t quality) {
    image_options options = {.tag = tag, .quality = quality};
    movie *m = begin(path, fps, &options);
    for (int i = 0; i < frames; i++) {
        image_pixels pixels = make_frame(channels, i);
        assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
        assert_int_equal(access(path, F_OK), -1); /* nobody sees it before its end */
    }
    assert_int_equal(movie_finish(m, NULL), SNELL_OK);
    bytes b = read_file(path);
    unlink(path);
    return b;
}

static uint32_t big(const uint8_t *p) {
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/* ---- APNG ---- */

static void add(bytes *b, const void *data, size_t size) {
    b->data = realloc(b->data, b->size + size);
    assert_non_null(b->data);
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void add_chunk(bytes *b, const char *type, const uint8_t *data, size_t size) {
    uint8_t number[4] = {(uint8_t)(size >> 24), (uint8_t)(size >> 16), (uint8_t)(size >> 8),
                         (uint8_t)size};
    add(b, number, 4);
    size_t start = b->size;
    add(b, type, 4);
    if (size) add(b, data, size);
    uint32_t check = (uint32_t)crc32(0, b->data + start, (unsigned)(b->size - start));
    for (int i = 0; i < 4; i++) number[i] = (uint8_t)(check >> (24 - 8 * i));
    add(b, number, 4);
}

/* One frame as a PNG of its own, decoded by libpng. */
static void check_png(const uint8_t *header, bytes *data, uint32_t channels, int number) {
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    bytes file = {NULL, 0};
    add(&file, signature, 8);
    add_chunk(&file, "IHDR", header, 13);
    add_chunk(&file, "IDAT", data->data, data->size);
    add_chunk(&file, "IEND", NULL, 0);
    decoded_image got;
    assert_int_equal(image_decode(file.data, file.size, IMAGE_SIZE_MAX, &got), SNELL_OK);
    uint8_t *wanted = shown_frame(channels, number);
    assert_true(got.width == WIDTH && got.height == HEIGHT && got.channels == channels);
    assert_memory_equal(got.pixels, wanted, (size_t)WIDTH * HEIGHT * channels);
    free(wanted);
    image_free(&got);
    free(file.data);
    free(data->data);
    *data = (bytes){NULL, 0};
}

static void check_apng(const bytes *b, uint32_t channels, int frames, uint32_t delay[2]) {
    uint32_t sequence = 0, counted = 0;
    int found = 0;
    bytes data = {NULL, 0};
    const uint8_t *header = NULL;
    bool ended = false;
    for (size_t at = 8; at < b->size; at += 12 + big(b->data + at)) {
        uint32_t length = big(b->data + at);
        const uint8_t *type = b->data + at + 4, *p = type + 4;
        assert_true(at + 12 + length <= b->size);
        assert_int_equal(crc32(0, type, length + 4), big(p + length));
        if (memcmp(type, "IHDR", 4) == 0) header = p;
        if (memcmp(type, "acTL", 4) == 0) {
            counted = big(p);
            assert_int_equal(big(p + 4), 0); /* for ever */
        }
        if (memcmp(type, "fcTL", 4) == 0) {
            if (found++ > 0) check_png(header, &data, channels, found - 2);
            assert_int_equal(big(p), sequence++);
            assert_true(big(p + 4) == WIDTH && big(p + 8) == HEIGHT);
            assert_true(big(p + 12) == 0 && big(p + 16) == 0);
            assert_int_equal(p[20] << 8 | p[21], delay[0]);
            assert_int_equal(p[22] << 8 | p[23], delay[1]);
        }
        if (memcmp(type, "IDAT", 4) == 0) {
            assert_int_equal(found, 1);
            add(&data, p, length);
        }
        if (memcmp(type, "fdAT", 4) == 0) {
            assert_true(found > 1);
            assert_int_equal(big(p), sequence++);
            add(&data, p + 4, length - 4);
        }
        if (memcmp(type, "IEND", 4) == 0) ended = true;
    }
    check_png(header, &data, channels, found - 1);
    assert_true(ended && found == frames && counted == (uint32_t)frames);
}

static void apng_holds_its_frames(void **state) {
    (void)state;
    for (uint32_t channels = 3; channels <= 4; channels++)
        for (int frames = 1; frames <= FRAMES; frames += FRAMES - 1) {
            bytes b = make("a.apng", channels, frames, 24, "{\"a\": 1}", 0);
            check_apng(&b, channels, frames, (uint32_t[2]){1, 24});
            image_info info;
            assert_int_equal(image_parse_info(b.data, b.size, &info), SNELL_OK);
            assert_int_equal(info.frames, frames);
            assert_string_equal(info.tag, "{\"a\": 1}");
            image_info_free(&info);
            free(b.data);
        }
    bytes b = make("a.apng", 3, 2, 23.976, NULL, 0);
    check_apng(&b, 3, 2, (uint32_t[2]){1001, 24000});
    free(b.data);
    b = make("a.apng", 3, 2, 12.5, NULL, 0);
    check_apng(&b, 3, 2, (uint32_t[2]){2, 25});
    free(b.data);
}

/* ---- WebP ---- */

#if SNELL_HAS_WEBP
#include <webp/decode.h>

static uint32_t little(const uint8_t *p, int bytes_of) {
    uint32_t value = 0;
    for (int i = bytes_of; i > 0; i--) value = value << 8 | p[i - 1];
    return value;
}

static void check_webp(const bytes *b, uint32_t channels, int frames) {
    int found = 0;
    uint32_t total = 0;
    assert_memory_equal(b->data, "RIFF", 4);
    assert_int_equal(little(b->data + 4, 4), b->size - 8);
    for (size_t at = 12; at < b->size;) {
        uint32_t length = little(b->data + at + 4, 4);
        const uint8_t *p = b->data + at + 8;
        assert_true(at + 8 + length <= b->size);
        if (memcmp(b->data + at, "VP8X", 4) == 0) {
            assert_int_equal(p[0] & 0x10 ? 4 : 3, channels);
            assert_true(p[0] & 2);
            assert_true(little(p + 4, 3) + 1 == WIDTH && little(p + 7, 3) + 1 == HEIGHT);
        } else if (memcmp(b->data + at, "ANMF", 4) == 0) {
            assert_true(little(p, 3) == 0 && little(p + 6, 3) + 1 == WIDTH);
            total += little(p + 12, 3);
            /* the frame's chunks are a file of their own without an extended head */
            bytes file = {NULL, 0};
            add(&file, "RIFF\0\0\0\0WEBP", 12);
            add(&file, p + 16, length - 16);
            for (int i = 0; i < 4; i++) file.data[4 + i] = (uint8_t)((file.size - 8) >> 8 * i);
            int width, height;
            uint8_t *got = channels == 4 ? WebPDecodeRGBA(file.data, file.size, &width, &height)
                                         : WebPDecodeRGB(file.data, file.size, &width, &height),
                    *wanted = shown_frame(channels, found++);
            assert_non_null(got);
            for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * channels; i++)
                assert_int_equal(got[i], wanted[i]); /* quality 100 loses nothing */
            free(wanted);
            WebPFree(got);
            free(file.data);
        }
        at += 8 + length + length % 2;
    }
    assert_int_equal(found, frames);
    assert_int_equal(total, (1000 * frames + 12) / 24); /* no drift */
}

static void webp_holds_its_frames(void **state) {
    (void)state;
    for (uint32_t channels = 3; channels <= 4; channels++) {
        bytes b = make("a.webp", channels, FRAMES, 24, "<it's & \"all\">", 100);
        check_webp(&b, channels, FRAMES);
        image_info info;
        assert_int_equal(image_parse_info(b.data, b.size, &info), SNELL_OK);
        assert_true(info.frames == FRAMES && info.channels == channels && info.width == WIDTH);
        assert_string_equal(info.tag, "<it's & \"all\">");
        image_info_free(&info);
        free(b.data);
    }
}

static void webp_loses_little(void **state) {
    (void)state;
    image_pixels pixels = make_frame(3, 1);
    uint8_t *wanted = shown_frame(3, 1);
    double errors[2];
    static const uint32_t qualities[] = {30, 95};
    for (int q = 0; q < 2; q++) {
        const image_codec *codec;
        void *data;
        size_t size;
        int width, height;
        assert_int_equal(image_codec_find("webp", &codec), SNELL_OK);
        image_options options = {.quality = qualities[q]};
        assert_int_equal(image_encode(codec, &pixels, &options, &data, &size), SNELL_OK);
        uint8_t *got = WebPDecodeRGB(data, size, &width, &height);
        assert_true(got && width == WIDTH && height == HEIGHT);
        errors[q] = 0;
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
            errors[q] += (got[i] - wanted[i]) * (got[i] - wanted[i]);
        errors[q] = sqrt(errors[q] / (WIDTH * HEIGHT * 3));
        WebPFree(got);
        free(data);
    }
    assert_true(errors[1] < errors[0] && errors[1] < 25);
    free(wanted);
}
#endif

#if SNELL_HAS_JPEG
static void jpeg_loses_little(void **state) {
    (void)state;
    uint8_t *wanted = shown_frame(3, 1);
    static const uint32_t qualities[] = {20, 75, 100};
    double before = 1e9;
    size_t size_before = 0;
    for (int q = 0; q < 3; q++) {
        const image_codec *codec;
        void *data;
        size_t size;
        image_pixels pixels = make_frame(3, 1);
        assert_int_equal(image_codec_find("jpg", &codec), SNELL_OK);
        image_options options = {.quality = qualities[q]};
        assert_int_equal(image_encode(codec, &pixels, &options, &data, &size), SNELL_OK);
        decoded_image got;
        assert_int_equal(image_decode(data, size, IMAGE_SIZE_MAX, &got), SNELL_OK);
        assert_true(got.width == WIDTH && got.height == HEIGHT && got.channels == 3);
        double error = 0;
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
            error += (got.pixels[i] - wanted[i]) * (got.pixels[i] - wanted[i]);
        error = sqrt(error / (WIDTH * HEIGHT * 3));
        assert_true(error < before && size > size_before);
        before = error, size_before = size;
        image_free(&got);
        free(data);
    }
    assert_true(before < 1);
    free(wanted);
}
#endif

/* ---- Y4M ---- */

/* Back to R'G'B' by the inverse matrix of BT.709, as a player does. One chroma sample stands for side^2 pixels. */
static void check_y4m_frame(const uint8_t *planes, const uint8_t *wanted, int side) {
    const int row = (WIDTH + side - 1) / side, rows = (HEIGHT + side - 1) / side;
    const uint8_t *blue = planes + WIDTH * HEIGHT, *red = blue + row * rows;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            /* the chroma that the pixels have in common */
            double mean[3] = {0, 0, 0};
            for (int i = 0; i < side * side; i++) {
                int px = x / side * side + i % side, py = y / side * side + i / side;
                if (px >= WIDTH) px = WIDTH - 1;
                if (py >= HEIGHT) py = HEIGHT - 1;
                for (int c = 0; c < 3; c++)
                    mean[c] += wanted[3 * (py * WIDTH + px) + c] / (double)(side * side);
            }
            const uint8_t *w = wanted + 3 * (size_t)(y * WIDTH + x);
            double luma = 0.2126 * w[0] + 0.7152 * w[1] + 0.0722 * w[2];
            double mean_luma = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
            int half = y / side * row + x / side;
            double got_luma = (planes[y * WIDTH + x] - 16) * 255.0 / 219;
            double r = (red[half] - 128) * 255.0 / 224 * 1.5748,
                   b = (blue[half] - 128) * 255.0 / 224 * 1.8556;
            assert_true(fabs(got_luma - luma) < 0.6);
            assert_true(fabs(r - (mean[0] - mean_luma)) < 1 &&
                        fabs(b - (mean[2] - mean_luma)) < 1.2);
            assert_true(planes[y * WIDTH + x] >= 16 && planes[y * WIDTH + x] <= 235);
        }
}

static bool collect(void *user, const void *data, size_t size) {
    add(user, data, size);
    return true;
}

static bool refuse(void *user, const void *data, size_t size) {
    (void)user, (void)data, (void)size;
    return false;
}

static void check_y4m_stream(uint32_t chroma, const char *head, int side) {
    const size_t head_size = strlen(head), chroma_row = (size_t)(WIDTH + side - 1) / (size_t)side,
                 size =
                     WIDTH * HEIGHT + 2 * chroma_row * ((size_t)(HEIGHT + side - 1) / (size_t)side);
    const movie_format *format;
    bytes b = {NULL, 0};
    movie_sink sink = {.write = collect, .user = &b};
    image_options options = {.chroma = chroma};
    movie *m;
    assert_int_equal(movie_format_find("y4m", NULL, &format), SNELL_OK);
    assert_int_equal(movie_create(format, &sink, 23.976, &options, &m), SNELL_OK);
    for (int i = 0; i < FRAMES; i++) {
        image_pixels pixels = make_frame(3, i);
        assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
        assert_int_equal(b.size, head_size + (size_t)(i + 1) * (6 + size));
    }
    assert_int_equal(movie_finish(m, NULL), SNELL_OK);
    assert_memory_equal(b.data, head, head_size);
    for (int i = 0; i < FRAMES; i++) {
        const uint8_t *at = b.data + head_size + (size_t)i * (6 + size);
        uint8_t *wanted = shown_frame(3, i);
        assert_memory_equal(at, "FRAME\n", 6);
        check_y4m_frame(at + 6, wanted, side);
        free(wanted);
    }
    free(b.data);
}

static void y4m_is_a_stream(void **state) {
    (void)state;
#define HEAD "YUV4MPEG2 W21 H13 F24000:1001 Ip A1:1 "
    check_y4m_stream(0, HEAD "C420jpeg XYSCSS=420JPEG XCOLORRANGE=LIMITED\n", 2);
    check_y4m_stream(420, HEAD "C420jpeg XYSCSS=420JPEG XCOLORRANGE=LIMITED\n", 2);
    check_y4m_stream(444, HEAD "C444 XYSCSS=444 XCOLORRANGE=LIMITED\n", 1);
}

static void y4m_goes_into_files_and_may_fail(void **state) {
    (void)state;
    const movie_format *format, *other;
    bytes b = {NULL, 0};
    movie_sink sink = {.write = collect, .user = &b};
    image_options options = {.chroma = 422};
    movie *m;
    assert_int_equal(movie_format_find("y4m", NULL, &format), SNELL_OK);
    assert_int_equal(movie_format_find("apng", NULL, &other), SNELL_OK);
    assert_int_equal(movie_create(format, &sink, 24, &options, &m), SNELL_ERR_ARGUMENT);
    options.chroma = 444;
    sink.path = "a.apng";
    assert_int_equal(movie_create(other, &sink, 24, &options, &m), SNELL_ERR_ARGUMENT);
    options.chroma = 0;
    sink.path = NULL;
    assert_int_equal(movie_create(format, &sink, 23.976, &options, &m), SNELL_OK);
    for (int i = 0; i < FRAMES; i++) {
        image_pixels pixels = make_frame(3, i);
        assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
    }
    assert_int_equal(movie_finish(m, NULL), SNELL_OK);
    bytes file = make("a.y4m", 3, FRAMES, 23.976, NULL, 0);
    assert_int_equal(file.size, b.size);
    assert_memory_equal(file.data, b.data, b.size);
    free(file.data);
    free(b.data);
    sink.write = refuse;
    assert_int_equal(movie_create(format, &sink, 24, &options, &m), SNELL_OK);
    image_pixels pixels = make_frame(3, 0);
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_ERR_IO);
    movie_abandon(m);
}

static void black_and_white_are_16_and_235(void **state) {
    (void)state;
    static const float colors[3][3] = {{0, 0, 0}, {1, 1, 1}, {1, 0, 0}};
    static const uint8_t wanted[3][3] = {{16, 128, 128}, {235, 128, 128}, {63, 102, 240}};
    for (int k = 0; k < 3; k++) {
        bytes b = {NULL, 0};
        movie_sink sink = {.write = collect, .user = &b};
        const movie_format *format;
        image_options options = {.tag = NULL};
        movie *m;
        assert_int_equal(movie_format_find("y4m", NULL, &format), SNELL_OK);
        assert_int_equal(movie_create(format, &sink, 24, &options, &m), SNELL_OK);
        image_pixels pixels = {colors[k], 1, 1, 3};
        assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
        assert_int_equal(movie_finish(m, NULL), SNELL_OK);
        assert_memory_equal(b.data + b.size - 3, wanted[k], 3);
        free(b.data);
    }
}

/* ---- ends ---- */

static void what_is_done_goes_elsewhere(void **state) {
    (void)state;
    FILE *old = fopen("old.apng", "w");
    fputs("old", old);
    fclose(old);
    image_options options = {.tag = NULL};
    movie *m = begin("old.apng", 24, &options);
    image_pixels pixels = make_frame(3, 0);
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
    assert_int_equal(movie_finish(m, "old.partial.apng"), SNELL_OK);
    bytes b = read_file("old.partial.apng");
    check_apng(&b, 3, 1, (uint32_t[2]){1, 24});
    free(b.data);
    b = read_file("old.apng");
    assert_int_equal(b.size, 3);
    free(b.data);
    m = begin("old.apng", 24, &options);
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
    movie_abandon(m); /* leaves the old one too */
    m = begin("old.apng", 24, &options);
    assert_int_equal(movie_finish(m, NULL), SNELL_ERR_STATE);
    b = read_file("old.apng");
    assert_int_equal(b.size, 3);
    free(b.data);
    m = begin("old.apng", 24, &options);
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
    assert_int_equal(movie_finish(m, NULL), SNELL_OK);
    b = read_file("old.apng");
    check_apng(&b, 3, 1, (uint32_t[2]){1, 24});
    free(b.data);
    unlink("old.apng");
    unlink("old.partial.apng");
}

static void what_makes_no_animation_is_refused(void **state) {
    (void)state;
    const movie_format *format;
    image_options options = {.tag = NULL};
    movie *m;
    assert_int_equal(movie_format_find(NULL, "x.png", &format), SNELL_ERR_UNSUPPORTED);
    assert_int_equal(movie_format_find("gif", NULL, &format), SNELL_ERR_UNSUPPORTED);
    assert_int_equal(movie_format_find(NULL, "X.APNG", &format), SNELL_OK);
    movie_sink pipe_sink = {.write = refuse}, nowhere = {.path = "no/such/folder.apng"},
               sink = {.path = "a.apng"};
    assert_int_equal(movie_create(format, &pipe_sink, 24, &options, &m), SNELL_ERR_ARGUMENT);
    assert_int_equal(movie_create(format, &nowhere, 24, &options, &m), SNELL_ERR_IO);
    assert_int_equal(movie_create(format, &sink, 0, &options, &m), SNELL_ERR_ARGUMENT);
    assert_int_equal(movie_create(format, &sink, (double)NAN, &options, &m), SNELL_ERR_ARGUMENT);
    options.quality = 50;
    assert_int_equal(movie_create(format, &sink, 24, &options, &m), SNELL_ERR_ARGUMENT);
    options.quality = 0;
    m = begin("a.apng", 24, &options);
    image_pixels pixels = make_frame(3, 0);
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_OK);
    pixels.width--;
    assert_int_equal(movie_add(m, &pixels, &options), SNELL_ERR_ARGUMENT);
    assert_int_equal(movie_finish(m, NULL), SNELL_OK); /* with the frames before */
    unlink("a.apng");
}

/* ---- the library's own face ---- */

#define MUST(call) assert_int_equal(call, SNELL_OK)

static void the_library_makes_animations(void **state) {
    (void)state;
    snell_context *context;
    snell_scene *scene;
    snell_film *made;
    snell_camera_id id;
    MUST(snell_context_create(NULL, &context));
    MUST(snell_scene_create(context, &scene));
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    MUST(snell_scene_add_perspective_camera(scene, &camera, &id));
    MUST(snell_scene_set_background(scene, (snell_vec3){0.2f, 0.4f, 0.8f}, 1));
    MUST(snell_scene_commit(scene, NULL, NULL));
    snell_render_desc render = {.struct_size = sizeof render};
    MUST(snell_scene_settings(scene, 0, &render));
    render.width = WIDTH;
    render.height = HEIGHT;
    render.samples = 1;
    MUST(snell_film_create(context, &made));

    snell_movie *m = NULL;
    snell_movie_desc desc = SNELL_INIT(movie_desc);
    snell_image_desc image = SNELL_INIT(image_desc);
    image.tag = "a tag";
    image.white_balance = "3200";
    desc.image = &image;
    assert_int_equal(snell_movie_create(NULL, &desc, &m), SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_movie_create("a.png", &desc, &m), SNELL_ERR_UNSUPPORTED);
    MUST(snell_movie_create("a.apng", &desc, &m));
    assert_int_equal(snell_movie_add(m, made, &image), SNELL_ERR_STATE); /* nothing is rendered */
    MUST(snell_render(scene, &render, made));
    MUST(snell_movie_add(m, made, &image));
    MUST(snell_movie_add(m, made, NULL));
    image.white_balance = "x";
    assert_int_equal(snell_movie_add(m, made, &image), SNELL_ERR_ARGUMENT);
    MUST(snell_movie_finish(m, NULL));
    snell_picture_info info = {.struct_size = sizeof info};
    MUST(snell_picture_read_info("a.apng", &info));
    assert_true(info.frames == 2 && info.width == WIDTH);
    assert_string_equal(info.tag, "a tag");
    snell_free(info.tag);
    snell_free(info.layers);
    unlink("a.apng");

    bytes b = {NULL, 0};
    desc.image = NULL;
    desc.format = "y4m";
    desc.write = collect;
    desc.user = &b;
    MUST(snell_movie_create(NULL, &desc, &m));
    MUST(snell_movie_add(m, made, NULL));
    MUST(snell_movie_finish(m, NULL));
    assert_memory_equal(b.data, "YUV4MPEG2 W21 H13 F24:1 ", 24);
    free(b.data);
    MUST(snell_movie_create(NULL, &desc, &m));
    snell_movie_destroy(m);
    snell_movie_destroy(NULL);
    snell_film_destroy(made);
    snell_scene_destroy(scene);
    snell_context_destroy(context);
}

static void formats_are_listed(void **state) {
    (void)state;
    snell_picture_format_info f = {.struct_size = sizeof f};
    uint32_t count = 0, movies = 0, streams = 0;
    for (; snell_picture_format(count, &f); count++) {
        assert_true(f.picture || f.animation);
        assert_true(f.extension[0] == '.' && f.help[0] && f.bits[0] > 0);
        movies += f.animation;
        streams += f.stream;
        assert_int_equal(f.alpha, strstr(f.help, "with alpha") != NULL);
        for (uint32_t i = 0; i < count; i++) {
            snell_picture_format_info other = {.struct_size = sizeof other};
            assert_true(snell_picture_format(i, &other));
            assert_string_not_equal(f.extension, other.extension);
        }
    }
    assert_true(count == 8 && movies == 3 && streams == 1);
    f.struct_size = 1;
    assert_false(snell_picture_format(0, &f));
}

static void a_view_turns(void **state) {
    (void)state;
    snell_view view = SNELL_INIT(view), framed = SNELL_INIT(view);
    view.from = (snell_vec3){1, 3, 5};
    view.at = (snell_vec3){1, 3, 1};
    MUST(snell_view_turn(&view, (snell_vec3){1, 0, 1}, 1.57079637f)); /* from +Z to +X */
    assert_true(fabs((double)view.from.x - 5) < 1e-5 && (double)view.from.y == 3 &&
                fabs((double)view.from.z - 1) < 1e-5);
    assert_true((double)view.up.y == 1);
    /* the way azimuth grows */
    snell_bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
    view = framed;
    MUST(snell_view_frame(&framed, &bounds, 0.9f, 0.2f, 1));
    MUST(snell_view_frame(&view, &bounds, 0.4f, 0.2f, 1));
    MUST(snell_view_turn(&view, (snell_vec3){0, 0, 0}, 0.5f));
    assert_true(fabs((double)(view.from.x - framed.from.x)) < 1e-5 &&
                fabs((double)(view.from.z - framed.from.z)) < 1e-5);
    assert_int_equal(snell_view_turn(&view, (snell_vec3){0, 0, 0}, (float)INFINITY),
                     SNELL_ERR_ARGUMENT);
    assert_int_equal(snell_view_turn(NULL, (snell_vec3){0, 0, 0}, 1), SNELL_ERR_ARGUMENT);
}

static char folder[] = "/tmp/snell-movies-XXXXXX";
static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) == NULL || chdir(folder) != 0;
}
static int remove_folder(void **state) {
    (void)state;
    return chdir("/") != 0 || rmdir(folder) != 0; /* nothing is left behind */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(apng_holds_its_frames),
#if SNELL_HAS_WEBP
        cmocka_unit_test(webp_holds_its_frames),
        cmocka_unit_test(webp_loses_little),
#endif
#if SNELL_HAS_JPEG
        cmocka_unit_test(jpeg_loses_little),
#endif
        cmocka_unit_test(y4m_is_a_stream),
        cmocka_unit_test(y4m_goes_into_files_and_may_fail),
        cmocka_unit_test(black_and_white_are_16_and_235),
        cmocka_unit_test(what_is_done_goes_elsewhere),
        cmocka_unit_test(what_makes_no_animation_is_refused),
        cmocka_unit_test(the_library_makes_animations),
        cmocka_unit_test(formats_are_listed),
        cmocka_unit_test(a_view_turns),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
