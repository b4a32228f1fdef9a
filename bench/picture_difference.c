/* How far two pictures of one size are apart: the mean difference of their linear values, 0 to 1, pixel
 * by pixel and after averaging blocks of pixels, in which edges that fall on other sides of a sample
 * even out.
 *
 *     picture_difference [--block N] [--linear] A.ppm [--linear] B.ppm
 *
 * PPM files (P6, 8 bits); --linear: the next one's bytes are linear, not sRGB. Prints "PIXELS BLOCKS". */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"

typedef struct picture {
    const char *path;
    bool linear;
    uint32_t width, height;
    double *values; /* three per pixel */
} picture;

static void die(const char *path, const char *what) {
    fprintf(stderr, "picture_difference: %s: %s\n", path, what);
    exit(2);
}

static int next_byte(FILE *f) { /* comments run from '#' to the end of the line */
    int c = getc(f);
    if (c == '#')
        while (c != '\n' && c != EOF) c = getc(f);
    return c;
}

static uint32_t read_header(FILE *f, const char *path) {
    int c;
    do c = next_byte(f);
    while (c == ' ' || c == '\n' || c == '\r' || c == '\t');
    uint32_t value = 0;
    for (; c >= '0' && c <= '9' && value <= 65536; c = getc(f))
        value = 10 * value + (uint32_t)(c - '0');
    if (value == 0 || value > 65536) die(path, "its header is not that of a PPM file");
    return value;
}

static double linear_from_srgb(double v) {
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void read_picture(picture *p) {
    FILE *f = fopen(p->path, "rb");
    if (f == NULL) die(p->path, "cannot be read");
    if (getc(f) != 'P' || getc(f) != '6') die(p->path, "is not a PPM file (P6)");
    p->width = read_header(f, p->path);
    p->height = read_header(f, p->path);
    if (read_header(f, p->path) != 255) die(p->path, "has not 8 bits");
    size_t count = 3 * (size_t)p->width * p->height;
    p->values = malloc(count * sizeof *p->values);
    unsigned char *bytes = malloc(count);
    if (p->values == NULL || bytes == NULL) die(p->path, "out of memory");
    if (fread(bytes, 1, count, f) != count) die(p->path, "is cut off");
    for (size_t i = 0; i < count; i++)
        p->values[i] = p->linear ? bytes[i] / 255.0 : linear_from_srgb(bytes[i] / 255.0);
    free(bytes);
    fclose(f);
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
                        size_t at = 3 * ((size_t)j * a->width + i) + c;
                        difference += a->values[at] - b->values[at];
                        n++;
                    }
                sum += fabs(difference); /* weighted by its pixels */
                count += n;
            }
    return sum / count;
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
        fprintf(stderr,
                "usage: picture_difference [--block N] [--linear] A.ppm [--linear] B.ppm\n");
        return 2;
    }
    read_picture(&pictures[0]);
    read_picture(&pictures[1]);
    if (pictures[0].width != pictures[1].width || pictures[0].height != pictures[1].height)
        die(pictures[1].path, "has another size");
    printf("%.5f %.5f\n", mean_difference(&pictures[0], &pictures[1], 1),
           mean_difference(&pictures[0], &pictures[1], (uint32_t)block));
    free(pictures[0].values);
    free(pictures[1].values);
    return 0;
}
