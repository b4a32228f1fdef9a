/* One pixel, rendered as render_film does, with a record of it. */
#ifndef SNELL_RENDER_EXPLAIN_H
#define SNELL_RENDER_EXPLAIN_H

#include "render/render.h"

typedef struct snell_explanation {
    snell_explained_ray *rays;
    snell_explained_light *lights;
    size_t ray_count, light_count;
    snell_explained_sample *samples;
    uint32_t sample_count,
        channels; /* number i is number i / s of scramble i % s, of s scrambles */
    float pixel[4];
} explanation;

/* `what` and the settings are checked already; names are borrowed from d. */
snell_status explain_pixel(const render_options *options, const description *d,
                           const snell_explain_desc *what, explanation **out);
void explanation_destroy(explanation *e);

#endif
