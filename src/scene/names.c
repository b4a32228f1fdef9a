#include "scene/names.h"

#include <stdio.h>

static const scene_name nobody = {{"", "", 0}, 0};

static scene_name name_of(const object_list *list, size_t index) {
    const object *o = &list->items[index];
    return (scene_name){{o->type->name, o->name, o->line}, (uint32_t)index + 1};
}

/* The number-th of the lights that are shapes, or that are none. */
static scene_name find_light(const description *d, bool shapes, uint32_t number) {
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    for (size_t i = 0; i < lights->count; i++) {
        bool is_shape = ((const light_type *)lights->items[i].type)->shape != NULL;
        if (is_shape == shapes && number-- == 0) return name_of(lights, i);
    }
    return nobody;
}

scene_name scene_name_part(const scene *s, const description *d, const scene_instance *part) {
    uint32_t id = s->instance_ids[part - s->instances];
    if (id == NO_ID) /* the body of a light */
        return find_light(d, true, part->material - s->material_count - 1);
    const instance *drawn = &d->instances[id];
    scene_name name = name_of(&d->objects[CATEGORY_SHAPE], drawn->shape);
    if (drawn->name[0]) name.info.name = drawn->name;
    if (drawn->line) name.info.line = drawn->line;
    return name;
}

scene_name scene_name_light(const scene *s, const description *d, uint32_t number) {
    (void)s;
    return find_light(d, false, number);
}

scene_name scene_name_material(const scene *s, const description *d, uint32_t number) {
    return number < s->material_count ? name_of(&d->objects[CATEGORY_MATERIAL], number) : nobody;
}

void scene_label(scene_name name, const char *nameless, char *out, size_t size) {
    const snell_object_info *info = &name.info;
    if (info->name[0])
        snprintf(out, size, "%s", info->name);
    else if (info->line)
        snprintf(out, size, "%s:%u", info->type, info->line);
    else if (name.number)
        snprintf(out, size, "%s #%u", info->type, name.number);
    else
        snprintf(out, size, "%s", nameless);
}
