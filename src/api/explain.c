/* The rays behind one pixel. */
#include "render/explain.h"

#include "api/api.h"
#include "render/adaptive.h"

static snell_status check_pixel(const snell_explain_desc *p, const render_options *o) {
    if (p->struct_size != sizeof *p)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_explain: the description has another version's size");
    if (p->x >= o->crop_width || p->y >= o->crop_height)
        return error_set(SNELL_ERR_ARGUMENT, "they count from the top left, from 0",
                         "the pixel %u,%u is outside the picture of %u x %u pixels", p->x, p->y,
                         o->crop_width, o->crop_height);
    if (o->noise > 0 && (p->samples < NOISE_SCRAMBLES || p->samples % NOISE_SCRAMBLES))
        return error_set(SNELL_ERR_ARGUMENT, "snell_film_samples tells, after snell_render",
                         "with a noise, the number of the pixel's samples must be given: not %u",
                         p->samples);
    uint32_t samples = p->samples ? p->samples : o->samples;
    if (samples > o->samples)
        return error_set(SNELL_ERR_ARGUMENT, NULL,
                         "a pixel has no more samples than the render: "
                         "%u, not %u",
                         o->samples, samples);
    if (o->noise <= 0 && samples != o->samples)
        return error_set(SNELL_ERR_ARGUMENT, "leave it 0",
                         "without a noise every pixel has the render's %u samples", o->samples);
    if (p->sample_count > 0 && (uint64_t)p->first_sample + p->sample_count > samples)
        return error_set(SNELL_ERR_ARGUMENT, "they count from 0",
                         "there is no sample %u: the pixel has %u",
                         p->first_sample + p->sample_count - 1, samples);
    return SNELL_OK;
}

static snell_status explain(const snell_scene *s, const snell_render_desc *desc,
                            const snell_explain_desc *pixel, snell_explanation **out) {
    prepared_render prepared;
    snell_status status = prepare_render(s, desc, &prepared);
    if (status) return status;
    status = check_pixel(pixel, &prepared.options);
    if (!status) status = explain_pixel(&prepared.options, s->description, pixel, out);
    prepared_render_free(&prepared);
    return status;
}

snell_status snell_explain(const snell_scene *s, const snell_render_desc *desc,
                           const snell_explain_desc *pixel, snell_explanation **out) {
    if (desc == NULL || pixel == NULL || out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_explain: an argument is NULL");
    snell_status status = scene_begin_read(s);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = explain(s, desc, pixel, out);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

void snell_explanation_destroy(snell_explanation *e) { explanation_destroy(e); }

const float *snell_explanation_pixel(const snell_explanation *e, uint32_t *channels) {
    if (e == NULL) return NULL;
    if (channels) *channels = e->channels;
    return e->pixel;
}

const snell_explained_sample *snell_explanation_samples(const snell_explanation *e,
                                                        uint32_t *count) {
    if (count) *count = e ? e->sample_count : 0;
    return e ? e->samples : NULL;
}

const snell_explained_ray *snell_explanation_rays(const snell_explanation *e, size_t *count) {
    if (count) *count = e ? e->ray_count : 0;
    return e ? e->rays : NULL;
}

const snell_explained_light *snell_explanation_lights(const snell_explanation *e, size_t *count) {
    if (count) *count = e ? e->light_count : 0;
    return e ? e->lights : NULL;
}
