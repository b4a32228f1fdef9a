/* What the things of a frozen scene are called in its description. */
#ifndef SNELL_SCENE_NAMES_H
#define SNELL_SCENE_NAMES_H

#include "scene/scene.h"

/* Type, name and line. Of a shape by what draws it (scene_find_part): an instance's own name and line
 * say more than those of what it draws. Strings are the description's. */
snell_object_info scene_part_info(const scene *s, const description *d, const scene_instance *part);
/* Of a registry light by its number in s->lights. */
snell_object_info scene_light_info(const scene *s, const description *d, uint32_t number);
/* By its number in s->materials; type "" for those that no description has. */
snell_object_info scene_material_info(const scene *s, const description *d, uint32_t number);

/* The name, else type and line as in "sphere:12", else the type alone, else `nameless`. */
void scene_label(snell_object_info info, const char *nameless, char *out, size_t size);

#endif
