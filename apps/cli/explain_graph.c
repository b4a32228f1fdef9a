/* The tree of rays for other programs: JSON, and a graph for Graphviz. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "explain.h"
#include "report.h"
#include "text.h"

/* ---- JSON ---- */

static json_t *json_numbers(const double *values, int count) {
    json_t *list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, json_real(values[i]));
    return list;
}

static json_t *json_vector(snell_vec3 v) {
    const double values[3] = {(double)v.x, (double)v.y, (double)v.z};
    return json_numbers(values, 3);
}

/* JSON has no infinity: null is one. */
static json_t *json_distance(double distance) {
    return isfinite(distance) ? json_real(distance) : json_null();
}

static json_t *json_object_of(const snell_object_info *info) {
    if (info->type[0] == '\0') return json_null();
    json_t *object = json_object();
    json_object_set_new(object, "type", report_text(info->type));
    json_object_set_new(object, "name", report_text(info->name));
    json_object_set_new(object, "line", json_integer(info->line));
    return object;
}

static void set_real(json_t *object, const char *key, double value) {
    json_object_set_new(object, key, json_real(value));
}

static json_t *json_light(const explained *e, const snell_explained_light *l) {
    json_t *object = json_object();
    json_object_set_new(object, "source", json_string(explain_source(l->source)));
    if (l->source != SNELL_SOURCE_COVERAGE)
        json_object_set_new(object, "incoming", json_numbers(l->incoming, 3));
    if (l->source == SNELL_SOURCE_LIGHT || l->source == SNELL_SOURCE_SKY)
        json_object_set_new(object, "light", json_object_of(&l->light));
    if (l->source == SNELL_SOURCE_LIGHT) {
        json_object_set_new(object, "direction", json_vector(l->direction));
        json_object_set_new(object, "distance", json_distance(l->distance));
        set_real(object, "choice", l->choice);
        set_real(object, "pdf", l->pdf);
        set_real(object, "cosine", l->cosine);
        json_object_set_new(object, "bsdf", json_numbers(l->bsdf, 3));
        json_object_set_new(object, "tested", json_boolean(l->tested));
        json_object_set_new(object, "visibility", json_numbers(l->visibility, 3));
        json_object_set_new(object, "blocker", json_object_of(&l->blocker));
        set_real(object, "blocker_distance", l->blocker_distance);
    }
    set_real(object, "weight", l->weight);
    json_object_set_new(object, "contribution", json_numbers(l->contribution, (int)e->channels));
    return object;
}

static json_t *json_hit(const snell_explained_ray *r) {
    json_t *object = json_object();
    json_object_set_new(object, "shape", json_object_of(&r->shape));
    json_object_set_new(object, "material", json_object_of(&r->material));
    json_object_set_new(object, "primitive", json_integer(r->hit.primitive));
    json_object_set_new(object, "position", json_vector(r->position));
    json_object_set_new(object, "normal", json_vector(r->normal));
    json_object_set_new(object, "inside", json_boolean(r->inside));
    set_real(object, "alpha", r->alpha);
    set_real(object, "cosine", r->cosine);
    set_real(object, "ior_from", r->ior_from);
    set_real(object, "ior_to", r->ior_to);
    json_object_set_new(object, "fresnel", json_numbers(r->fresnel, 3));
    return object;
}

static json_t *json_ray(const explained *e, const snell_explained_ray *r) {
    static const char *const ends[] = {"", "hit", "passed", "left", "too_deep", "too_faint"};
    json_t *object = json_object(), *lights = json_array();
    bool root = r->parent == UINT32_MAX;
    json_object_set_new(object, "index", json_integer(r - e->rays));
    json_object_set_new(object, "parent", root ? json_null() : json_integer(r->parent));
    json_object_set_new(object, "ray_count", json_integer(r->ray_count));
    json_object_set_new(object, "sample", json_integer(r->sample));
    json_object_set_new(object, "depth", json_integer(r->depth));
    json_object_set_new(object, "kind", json_string(explain_kind(r->kind)));
    json_object_set_new(object, "end", json_string(ends[r->end]));
    json_object_set_new(object, "origin", json_vector(r->origin));
    json_object_set_new(object, "direction", json_vector(r->direction));
    set_real(object, "time", (double)r->time);
    set_real(object, "pdf", r->pdf);
    json_object_set_new(object, "weight", json_numbers(r->weight, 3));
    json_object_set_new(object, "distance", json_distance(r->distance));
    json_object_set_new(object, "transmittance", json_numbers(r->transmittance, 3));
    json_object_set_new(object, "throughput", json_vector(r->throughput));
    json_object_set_new(object, "radiance", json_numbers(r->radiance, (int)e->channels));
    bool met = r->end == SNELL_RAY_HIT || r->end == SNELL_RAY_PASSED;
    json_object_set_new(object, "hit", met ? json_hit(r) : json_null());
    for (uint32_t i = 0; i < r->light_count; i++)
        json_array_append_new(lights, json_light(e, &e->lights[r->first_light + i]));
    json_object_set_new(object, "lights", lights);
    return object;
}

static json_t *json_samples(const explained *e) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < e->sample_count; i++) {
        json_t *object = json_object();
        json_object_set_new(object, "radiance",
                            json_numbers(e->samples[i].radiance, (int)e->channels));
        json_object_set_new(object, "first_ray", json_integer(e->samples[i].first_ray));
        json_object_set_new(object, "ray_count", json_integer(e->samples[i].ray_count));
        json_array_append_new(list, object);
    }
    return list;
}

json_t *explain_json(const explained *e) {
    const snell_render_desc *d = &e->stage->desc;
    json_t *root = json_object(), *rays = json_array(), *pixel = json_array();
    json_object_set_new(root, "schema", json_integer(1));
    json_object_set_new(root, "file", report_text(e->file));
    json_object_set_new(root, "x", json_integer(e->x));
    json_object_set_new(root, "y", json_integer(e->y));
    json_object_set_new(root, "width", json_integer(d->width));
    json_object_set_new(root, "height", json_integer(d->height));
    json_object_set_new(root, "integrator", json_string(integrator_name(d->integrator)));
    json_object_set_new(root, "samples", json_integer(e->sample_count));
    json_object_set_new(root, "max_depth", json_integer(d->max_depth));
    char weight[32];
    text_format_float(d->min_weight, weight);
    set_real(root, "min_weight", strtod(weight, NULL));
    json_object_set_new(root, "seed", json_integer((json_int_t)d->seed));
    for (uint32_t c = 0; c < e->channels; c++)
        json_array_append_new(pixel, json_real((double)e->pixel[c]));
    json_object_set_new(root, "pixel", pixel);
    json_object_set_new(root, "typical_sample", json_integer(e->sample));
    json_object_set_new(root, "sample_list", json_samples(e));
    for (size_t i = 0; i < e->ray_count; i++)
        if (explain_shows(e, &e->rays[i])) json_array_append_new(rays, json_ray(e, &e->rays[i]));
    json_object_set_new(root, "rays", rays);
    return root;
}

/* ---- Graphviz ---- */

/* As a string of its language stands in quotes. */
static void print_quoted(const char *text) {
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') putchar('\\');
        putchar(*c);
    }
}

static void print_node_name(const explained *e, const snell_explained_ray *r) {
    char label[EXPLAIN_LABEL];
    switch (r->end) {
    case SNELL_RAY_HIT:
    case SNELL_RAY_PASSED: print_quoted(explain_label(&r->shape, label)); break;
    case SNELL_RAY_LEFT: {
        const snell_explained_light *l = &e->lights[r->first_light];
        bool named = r->light_count > 0 && l->light.type[0] != '\0';
        print_quoted(named ? explain_label(&l->light, label) : "the sky");
        break;
    }
    case SNELL_RAY_TOO_DEEP: fputs("too deep", stdout); break;
    case SNELL_RAY_TOO_FAINT: fputs("too faint", stdout); break;
    }
}

static void print_node(const explained *e, const snell_explained_ray *r) {
    bool met = r->end == SNELL_RAY_HIT || r->end == SNELL_RAY_PASSED;
    printf("  r%td [label=\"", r - e->rays);
    print_node_name(e, r);
    if (met) printf("\\n%.4g m", r->distance);
    if (met && r->ior_from != r->ior_to) printf(", ior %.4g → %.4g", r->ior_from, r->ior_to);
    if (r->end <= SNELL_RAY_LEFT)
        printf("\\n%.3g %.3g %.3g", r->radiance[0], r->radiance[1], r->radiance[2]);
    printf("\"%s];\n", met ? "" : ", shape=plaintext");
}

static void print_edge(const explained *e, const snell_explained_ray *r) {
    static const char *const colors[] = {"", "black", "darkcyan", "blue", "purple"};
    char weight[EXPLAIN_COLOR];
    const snell_explained_ray *from = explain_origin(e, r);
    if (r->parent == UINT32_MAX)
        fputs("  camera", stdout);
    else
        printf("  r%" PRIu32, r->parent);
    printf(" -> r%td [color=%s, label=\"", r - e->rays, colors[r->kind]);
    if (r->parent != UINT32_MAX)
        printf("%s\\n%s", explain_kind(r->kind), explain_color(r->weight, weight));
    if (from != NULL && r->kind != SNELL_RAY_CONTINUED)
        printf("\\n%.4g°", explain_angle(r->direction, from->normal));
    puts("\"];");
}

static void print_light_edge(const explained *e, const snell_explained_ray *r, uint32_t index) {
    char label[EXPLAIN_LABEL];
    const snell_explained_light *l = &e->lights[index];
    if (l->source != SNELL_SOURCE_LIGHT || !(l->tested || l->contribution[0] > 0)) return;
    bool dark = l->visibility[0] == 0 && l->visibility[1] == 0 && l->visibility[2] == 0;
    printf("  l%" PRIu32 " [label=\"", index);
    print_quoted(explain_label(&l->light, label));
    printf("\", shape=ellipse, color=%s];\n", dark ? "gray" : "orange");
    printf("  l%" PRIu32 " -> r%td [style=dashed, color=%s, label=\"", index, r - e->rays,
           dark ? "gray" : "orange");
    if (dark && l->blocker.type[0] != '\0') {
        fputs("behind ", stdout);
        print_quoted(explain_label(&l->blocker, label));
    } else if (!dark) {
        printf("%.3g %.3g %.3g", l->contribution[0], l->contribution[1], l->contribution[2]);
    }
    puts("\"];");
}

int explain_dot(const explained *e) {
    const snell_explained_sample *s = &e->samples[e->sample];
    printf("digraph rays {\n  node [shape=box, fontname=\"sans-serif\", fontsize=10];\n"
           "  edge [fontname=\"sans-serif\", fontsize=9];\n"
           "  camera [label=\"camera\\npixel %" PRIu32 ",%" PRIu32 ", sample %" PRIu32
           "\", shape=plaintext];\n",
           e->x, e->y, e->sample);
    for (uint32_t i = s->first_ray; i < s->first_ray + s->ray_count; i++) {
        const snell_explained_ray *r = &e->rays[i];
        if (!explain_shows(e, r)) continue;
        print_node(e, r);
        print_edge(e, r);
        for (uint32_t k = 0; k < r->light_count; k++) print_light_edge(e, r, r->first_light + k);
    }
    puts("}");
    return EXIT_DONE;
}
