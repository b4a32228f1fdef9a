#include "scene/settings.h"

DESCRIBE_TABLE(render, RENDER_FIELDS)
DESCRIBE_TABLE(background, BACKGROUND_FIELDS)
DESCRIBE_TABLE(ambient, AMBIENT_FIELDS)
DESCRIBE_TABLE(animation, ANIMATION_FIELDS)

const type_info setting_render =
    TYPE_INFO(CATEGORY_SETTING, render, "render", "how the picture is made");
const type_info setting_background =
    TYPE_INFO(CATEGORY_SETTING, background, "background", "what a ray that leaves sees");
const type_info setting_ambient =
    TYPE_INFO(CATEGORY_SETTING, ambient, "ambient", "light that is everywhere (the lecture's L_a)");
const type_info setting_animation =
    TYPE_INFO(CATEGORY_SETTING, animation, "animation", "the clock of what changes with time");
