/* snell explain, in parts: explain.c finds out what is asked and asks the library; the others draw
 * what it answers. Each prints to standard output. */
#ifndef SNELL_CLI_EXPLAIN_H
#define SNELL_CLI_EXPLAIN_H

#include <jansson.h>
#include <snell/snell.h>

#include "stage.h"

enum { LEVELS_DEFAULT = 6, LEVELS_ALL = 1000000 };

typedef struct explained {
    const options *options;
    stage *stage;
    const char *file; /* as typed: a scene, or a picture */
    uint32_t x, y, levels;
    const json_t *tag;      /* the picture's; NULL: a scene was given */
    uint32_t samples_given; /* the pixel's, with a noise; 0: the render's */
    bool has_sample;        /* only the rays of this one are there */
    uint32_t sample;        /* that is drawn */
    const snell_explained_sample *samples;
    const snell_explained_ray *rays;
    const snell_explained_light *lights;
    uint32_t sample_count, channels;
    size_t ray_count;
    const float *pixel;
} explained;

int explain_text(const explained *e);
int explain_dot(const explained *e);
int explain_svg(const explained *e, const char *view);
/* With the pixel, the samples and every ray that is shown. */
json_t *explain_json(const explained *e);

/* "name", sphere:12, or sphere where neither is known; as text that is safe to print. `out` has room
 * for EXPLAIN_LABEL bytes. */
enum { EXPLAIN_LABEL = 160 };
const char *explain_label(const snell_object_info *info, char *out);
/* One number, or three where they differ. */
enum { EXPLAIN_COLOR = 64 };
const char *explain_color(const double color[3], char *out);
const char *explain_kind(snell_ray_kind kind);
const char *explain_source(snell_light_source source);
/* Degrees between a direction and a normal, 0 to 90. */
double explain_angle(snell_vec3 direction, snell_vec3 normal);
/* The surface that the ray leaves: of its parent, or of what that walked on from; NULL: the camera. */
const snell_explained_ray *explain_origin(const explained *e, const snell_explained_ray *ray);
/* Is the ray to be shown? */
bool explain_shows(const explained *e, const snell_explained_ray *ray);

#endif
