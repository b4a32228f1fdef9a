/* The values of render's options, checked before any work is done. */
#ifndef SNELL_CLI_VALUES_H
#define SNELL_CLI_VALUES_H

#include <snell/snell.h>

#include "options.h"

enum { IMAGE_SIDE_MAX = 65536, SAMPLES_MAX = 1 << 20, DEPTH_MAX = 1000 };

typedef struct render_values {
    /* --size: width and height; 0 keeps the shape; or percent. */
    uint32_t width, height;
    double percent; /* 0: not given */
    bool has_crop;
    uint32_t crop_x, crop_y, crop_width, crop_height;
    bool has_exposure;
    float exposure;
    bool transparent, has_background;
    snell_vec3 background;
    bool has_view;
    float view[2]; /* azimuth, elevation in radians */
    float fov;     /* radians; 0: not given */
    bool has_ground;
    snell_vec3 ground;
    bool light_none;
    snell_integrator integrator; /* 0: not given */
    uint32_t samples;            /* 0: not given */
    bool has_max_depth, has_min_weight, has_seed;
    uint32_t max_depth;
    float min_weight;
    uint64_t seed;
} render_values;

int values_read(const options *o, render_values *out); /* exit code */
const char *integrator_name(snell_integrator integrator);

#endif
