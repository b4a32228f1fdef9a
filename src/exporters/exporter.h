/* What snell_scene_save writes, by extension. Compiled scenes are scene/compiled.h's. */
#ifndef SNELL_EXPORTERS_EXPORTER_H
#define SNELL_EXPORTERS_EXPORTER_H

#include "scene/description.h"

/* The scene as a program in the scene language, with the same picture to the bit. Meshes and images go to
 * files in the folder NAME.files beside PATH/NAME.lua, whose names hold a hash of their content, so that those of
 * an older NAME.lua stay as they are; NAME.lua is written last. One frame of an animation.
 * SNELL_ERR_UNSUPPORTED: the scene has something that the language cannot say; the error names it. */
snell_status lua_write(const description *d, const char *path);

#endif
