/* How far two pictures of one size are apart: the mean difference of their linear values, 0 to 1, pixel
 * by pixel and after averaging blocks of pixels, in which edges that fall on other sides of a sample
 * even out; and the noise of one picture, where the two differ by chance alone: the root of the mean
 * square of their pixels' difference, over the root of 2.
 *
 *     picture_difference [--block N] [--linear] A [--linear] B
 *
 * Files of 8 bits; --linear: the next one's bytes are linear, not sRGB. Prints "PIXELS BLOCKS NOISE". */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <snell/snell.h>

#include "image/srgb.h"
#include "measure.h"

typedef struct picture {
    const char *path;
    bool linear;
    snell_film *film;
    uint32_t width, height, channels;
    const float *pixels;
} picture;

static void die(const char *path, const char *what) {
    fprintf(stderr, "picture_difference: %s: %s\n", path, what);
    exit(2);
}

static void read_picture(snell_context *context, picture *p) {
    if (snell_film_create(context, &p->film) || snell_film_read(p->film, p->path, NULL))
        die(p->path, snell_last_error()->text);
    p->pixels = snell_film_pixels(p->film, &p->width, &p->height, &p->channels);
}

static double value_at(const picture *p, uint32_t x, uint32_t y, uint32_t c) {
    double v = (double)p->pixels[((size_t)y * p->width + x) * p->channels + c];
    return p->linear ? srgb_encode(v) : v;
}

/* Over the three channels of the blocks, those at the right and lower edge smaller. */
static double mean_difference(const picture *a, const picture *b, uint32_t block) {
    double sum = 0, count = 0;
    for (uint32_t y = 0; y < a->height; y += block)
        for (uint32_t x = 0; x < a->width; x += block)
            for (uint32_t c = 0; c < 3; c++) {
                double difference = 0, n = 0;
                for (uint32_t j = y; j < y + block && j < a->height; j++)
                    for (uint32_t i = x; i < x + block && i < a->width; i++) {
                        difference += value_at(a, i, j, c) - value_at(b, i, j, c);
                        n++;
                    }
                sum += fabs(difference); /* weighted by its pixels */
                count += n;
            }
    return sum / count;
}

static double noise(const picture *a, const picture *b) {
    double sum = 0, count = 3.0 * a->width * a->height;
    for (uint32_t y = 0; y < a->height; y++)
        for (uint32_t x = 0; x < a->width; x++)
            for (uint32_t c = 0; c < 3; c++) {
                double difference = value_at(a, x, y, c) - value_at(b, x, y, c);
                sum += difference * difference;
            }
    return sqrt(sum / count / 2);
}

int main(int argc, char **argv) {
    picture pictures[2] = {{.path = NULL}, {.path = NULL}};
    uint64_t block = 16;
    int count = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--block") == 0) {
            if (!read_number(argv[++i], 1, 65536, &block)) die("--block", "takes 1 to 65536");
        } else if (strcmp(argv[i], "--linear") == 0 && count < 2)
            pictures[count].linear = true;
        else if (count < 2)
            pictures[count++].path = argv[i];
        else
            count = 3;
    }
    if (count != 2) {
        fprintf(stderr, "usage: picture_difference [--block N] [--linear] A [--linear] B\n");
        return 2;
    }
    snell_context *context;
    if (snell_context_create(NULL, &context)) die("", snell_last_error()->text);
    for (int i = 0; i < 2; i++) read_picture(context, &pictures[i]);
    if (pictures[0].width != pictures[1].width || pictures[0].height != pictures[1].height)
        die(pictures[1].path, "has another size");
    printf("%.5f %.5f %.5f\n", mean_difference(&pictures[0], &pictures[1], 1),
           mean_difference(&pictures[0], &pictures[1], (uint32_t)block),
           noise(&pictures[0], &pictures[1]));
    for (int i = 0; i < 2; i++) snell_film_destroy(pictures[i].film);
    snell_context_destroy(context);
    return 0;
}
