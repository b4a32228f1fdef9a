/* What the things of a frozen scene are called in its description. */
#ifndef SNELL_SCENE_NAMES_H
#define SNELL_SCENE_NAMES_H

#include "scene/scene.h"

/* Type, name and line, the strings being the description's; and the number among its kind, from 1. All
 * empty and 0 for what no description has. */
typedef struct scene_name {
    snell_object_info info;
    uint32_t number;
} scene_name;

/* Of a shape by what draws it (scene_find_part): an instance's own name and line say more than those of
 * what it draws. */
scene_name scene_name_part(const scene *s, const description *d, const scene_instance *part);
/* Of a registry light and of a material, by their numbers in the frozen scene. */
scene_name scene_name_light(const scene *s, const description *d, uint32_t number);
scene_name scene_name_material(const scene *s, const description *d, uint32_t number);

/* The name, else type and line as in "sphere:12", else "sphere #3", else `nameless`. */
void scene_label(scene_name name, const char *nameless, char *out, size_t size);

#endif
