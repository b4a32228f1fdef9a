#include "render/notes.h"

#include "scene/settings.h"

static void note_ambient(const scene *s, const log_sink *log) {
    if (!(dvec3_largest(s->ambient) > 0)) return;
    log_write(log, SNELL_WARNING, (source_place){0},
              "light.environment is light from everywhere that things can shade",
              "path ignores ambient light: it finds what ambient stands for");
}

static bool is_used(const scene *s, uint32_t index) {
    for (uint32_t i = 0; i < s->part_count; i++)
        for (uint32_t k = 0; k < instance_slot_count(&s->instances[i]); k++)
            if (instance_slot(&s->instances[i], k) == index) return true;
    return false;
}

/* A tenth of a percent is what an estimate of 1024 samples may be off for what gains nothing. */
static void note_gain(const description *d, const scene *s, const log_sink *log) {
    for (uint32_t i = 0; i < s->material_count; i++) {
        const material *m = &s->materials[i];
        if (!m->type->may_gain || !is_used(s, i)) continue;
        double largest = 0;
        for (int k = 1; k <= 3; k++)
            largest = double_max(largest, material_albedo(m, s->textures, s->materials, k / 3.0));
        if (!(largest > 1.01)) continue;
        const object *o = &d->objects[CATEGORY_MATERIAL].items[i];
        char label[128];
        description_object_label(d, CATEGORY_MATERIAL, i, label, sizeof label);
        log_write(log, SNELL_WARNING, (source_place){o->file, o->line, 0},
                  "lower its colour or its specular part",
                  "%s gives back %.2f of the light that it gets: path adds it up", label, largest);
    }
}

static bool some_shines(const scene *s, const scene_instance *at) {
    for (uint32_t i = 0; i < instance_slot_count(at); i++)
        if (s->materials[instance_slot(at, i)].shines) return true;
    return false;
}

/* Planes have no end, and what has no area and is there in part is not sampled (scene/seen.h). */
static void note_unsampled_emitters(const scene *s, const log_sink *log) {
    for (uint32_t i = 0; i < s->part_count; i++) {
        const scene_instance *at = &s->instances[i];
        if (at->shines || at->group != NO_ID || !some_shines(s, at)) continue;
        log_write(log, SNELL_WARNING, (source_place){0}, "use a quad or a disk, or path",
                  "a %s that shines lights only what mirrors it: it %s", at->type->info.name,
                  at->type->unbounded ? "has no end" : "has no area and is there in part");
        return;
    }
}

void render_notes(const description *d, const scene *s, const integrator *policy,
                  const log_sink *log) {
    if (!policy->one_branch) {
        note_unsampled_emitters(s, log);
        return;
    }
    note_ambient(s, log);
    note_gain(d, s, log);
}
