/* Shapes of the caller's own, by functions: snell_scene_add_user_shape. */
#ifndef SNELL_GEOMETRY_USER_H
#define SNELL_GEOMETRY_USER_H

#include "geometry/primitive.h"

typedef struct user_desc {
    size_t struct_size;
    snell_user_shape_desc given;
    bounds3 all; /* of every part */
} user_desc;

/* In no registry: it has no fields. */
extern const primitive_type shape_user;

/* Checks what can be checked, and asks for all boxes once. */
snell_status user_desc_make(const snell_user_shape_desc *given, user_desc *out);

#endif
