/* The values of render's options, checked before any work is done. */
#ifndef SNELL_CLI_VALUES_H
#define SNELL_CLI_VALUES_H

#include <snell/snell.h>

#include "options.h"

enum { IMAGE_SIDE_MAX = 65536, SAMPLES_MAX = 1 << 20, DEPTH_MAX = 1000 };

enum { WHITE_TEXT_MAX = 128 };

typedef struct render_values {
    /* --size: width and height; 0 keeps the shape; or percent. */
    uint32_t width, height;
    double percent; /* 0: not given */
    bool has_crop;
    uint32_t crop_x, crop_y, crop_width, crop_height;
    bool has_exposure;
    float exposure;
    bool has_white_balance;
    char white_balance[WHITE_TEXT_MAX]; /* as snell_image_desc's */
    uint32_t bits, quality;             /* 0: not given */
    bool transparent, has_background;
    snell_vec3 background;
    bool has_view;
    float view[2]; /* azimuth, elevation in radians */
    float fov;     /* radians; 0: not given */
    bool has_ground;
    snell_vec3 ground;
    bool light_none, light_sky;
    const char *light_image;     /* NULL: none */
    snell_integrator integrator; /* 0: not given */
    uint32_t samples;            /* 0: not given */
    float noise;                 /* 0: not given */
    double time_limit;           /* seconds; 0: not given */
    bool has_max_depth, has_min_weight, has_seed;
    uint32_t max_depth;
    float min_weight;
    uint64_t seed;
    bool has_filter;
    snell_filter filter;
    float filter_radius;              /* 0: not given */
    uint32_t frame_first, frame_last; /* 0: not given; of --frame both are the same */
    bool many_frames;                 /* --frames, or all of --turntable */
    uint32_t turntable;               /* frames of one turn; 0: not given */
    double fps;                       /* 0: not given */
    bool all_cameras;                 /* --camera all */
    const char *aov;                  /* NULL: not given; "": none */
} render_values;

enum { FRAME_MAX = 1000000, TURNTABLE_MAX = 100000 };

/* The frames that --frame or --frames asks for; 0 and 0 for none. */
int values_read_frames(const options *o, uint32_t *first, uint32_t *last);
int values_read(const options *o, render_values *out); /* exit code */
/* What --bits and --quality ask for; 0 where they are not given. */
int values_read_encoding(const options *o, uint32_t *bits, uint32_t *quality);
/* A colour of --white-balance, which may be a name, as the library takes it; temperatures as they are. False:
 * it is neither. */
bool values_white(const char *text, char out[WHITE_TEXT_MAX]);
/* *given: whether the option was. */
int values_read_white(const options *o, char out[WHITE_TEXT_MAX], bool *given);
/* An option's number, if it was given: exit code, an error names option and range. */
int values_read_decimal(const options *o, option_id id, const char *name, double min, double max,
                        double *out);
int values_read_whole(const options *o, option_id id, const char *name, uint64_t min, uint64_t max,
                      uint64_t *out);
const char *integrator_name(snell_integrator integrator);

#endif
