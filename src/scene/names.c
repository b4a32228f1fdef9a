#include "scene/names.h"

#include <stdio.h>

static snell_object_info info_of(const object *o) {
    return (snell_object_info){o->type->name, o->name, o->line};
}

static const snell_object_info nobody = {"", "", 0};

/* The number-th of the lights that are shapes, or that are none. */
static snell_object_info find_light(const description *d, bool shapes, uint32_t number) {
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    for (size_t i = 0; i < lights->count; i++) {
        bool is_shape = ((const light_type *)lights->items[i].type)->shape != NULL;
        if (is_shape == shapes && number-- == 0) return info_of(&lights->items[i]);
    }
    return nobody;
}

snell_object_info scene_part_info(const scene *s, const description *d,
                                  const scene_instance *part) {
    uint32_t id = s->instance_ids[part - s->instances];
    if (id == NO_ID) /* the body of a light */
        return find_light(d, true, part->material - s->material_count - 1);
    const instance *drawn = &d->instances[id];
    snell_object_info info = info_of(&d->objects[CATEGORY_SHAPE].items[drawn->shape]);
    if (drawn->name[0]) info.name = drawn->name;
    if (drawn->line) info.line = drawn->line;
    return info;
}

snell_object_info scene_light_info(const scene *s, const description *d, uint32_t number) {
    (void)s;
    return find_light(d, false, number);
}

snell_object_info scene_material_info(const scene *s, const description *d, uint32_t number) {
    if (number >= s->material_count) return nobody;
    return info_of(&d->objects[CATEGORY_MATERIAL].items[number]);
}

void scene_label(snell_object_info info, const char *nameless, char *out, size_t size) {
    if (info.name[0])
        snprintf(out, size, "%s", info.name);
    else if (info.type[0] && info.line)
        snprintf(out, size, "%s:%u", info.type, info.line);
    else
        snprintf(out, size, "%s", info.type[0] ? info.type : nameless);
}
