#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "exporters/exporter.h"
#include "exporters/lua_export.h"
#include "image/tonemap.h"
#include "materials/material.h"
#include "scene/settings.h"

/* ---- settings ---- */

static int find_setting(const description *d, const type_info *type) {
    const object_list *list = &d->objects[CATEGORY_SETTING];
    for (size_t i = 0; i < list->count; i++)
        if (list->items[i].type == type) return (int)i;
    return -1;
}

/* A model is toned by `neutral` unless it says something else. */
static void put_render(lua_export *e) {
    int index = find_setting(e->d, &setting_render);
    const render_desc *said = index < 0 ? NULL : e->d->objects[CATEGORY_SETTING].items[index].desc;
    bool toned = e->d->is_model && (said == NULL || said->tonemap == 0);
    if (index < 0 && !toned) return;
    put(e, "render {");
    if (index >= 0) put_fields(e, CATEGORY_SETTING, (uint32_t)index, NULL);
    if (toned) put(e, " tonemap = \"neutral\"");
    put_end(e);
    put(e, "\n");
}

static void put_setting(lua_export *e, const type_info *type) {
    int index = find_setting(e->d, type);
    if (index < 0) return;
    put(e, "%s {", type->name);
    put_fields(e, CATEGORY_SETTING, (uint32_t)index, NULL);
    put_end(e);
    put(e, "\n");
}

/* The one frame that there is. */
static void put_animation(lua_export *e) {
    int index = find_setting(e->d, &setting_animation);
    if (index < 0) return;
    const animation_desc *clock = e->d->objects[CATEGORY_SETTING].items[index].desc;
    put(e, "animation { fps = ");
    put_float(e, clock->fps);
    put(e, ", first = %d, last = %d }", clock->frame, clock->frame);
    put(e, clock->first < clock->last ? " -- one frame of %d to %d\n" : "\n", clock->first,
        clock->last);
}

/* The studio lights models and scene programs by different rules (api/studio.c): what it would add to the
 * model only is said, or refused. */
static void put_model_background(lua_export *e) {
    const description *d = e->d;
    if (!d->is_model) return;
    bool background = find_setting(d, &setting_background) >= 0, shines = false;
    bool lit = d->objects[CATEGORY_LIGHT].count > 0 || find_setting(d, &setting_ambient) >= 0;
    const object_list *materials = &d->objects[CATEGORY_MATERIAL];
    for (size_t i = 0; i < materials->count; i++)
        shines |= material_emits((const material_type *)materials->items[i].type,
                                 materials->items[i].desc);
    if (lit && !background) {
        const snell_vec3 colors[2] = {STUDIO_BOTTOM, STUDIO_TOP};
        put(e, "background { color = ");
        put_floats(e, &colors[0].x, 3);
        put(e, ", top = ");
        put_floats(e, &colors[1].x, 3);
        put(e, " } -- of the studio\n");
    }
    if (!lit && (shines || background))
        e->status =
            error_set(SNELL_ERR_UNSUPPORTED,
                      "compile it (.snell), or write scene.lua with model { file = .. } and lights",
                      "a model without lights that %s: a model is lit by the studio then, a scene "
                      "program is not",
                      shines ? "shines itself" : "has a background");
}

/* ---- objects ---- */

static void put_called(lua_export *e, category which, uint32_t index) {
    const char *name = e->d->objects[which].items[index].name;
    if (name[0] == '\0') return;
    put(e, " name = ");
    put_string(e, name);
    put(e, ",");
}

static void put_texture(lua_export *e, uint32_t index) {
    const object *o = &e->d->objects[CATEGORY_TEXTURE].items[index];
    put_name(e, "t", CATEGORY_TEXTURE, index);
    put(e, " = texture.%s {", o->type->name);
    if (strcmp(o->type->name, "image") == 0) {
        char beside[512] = "";
        write_image(e, index, beside, sizeof beside);
        put(e, " file = ");
        put_string(e, beside);
        put(e, ",");
    }
    put_fields(e, CATEGORY_TEXTURE, index,
               strcmp(o->type->name, "image") == 0 ? "width|height|format|pixels" : NULL);
    put_called(e, CATEGORY_TEXTURE, index);
    put_end(e);
    put(e, "\n");
}

static void put_material(lua_export *e, uint32_t index) {
    put_name(e, "m", CATEGORY_MATERIAL, index);
    put(e, " = material.%s {", e->d->objects[CATEGORY_MATERIAL].items[index].type->name);
    put_fields(e, CATEGORY_MATERIAL, index, NULL);
    put_called(e, CATEGORY_MATERIAL, index);
    put_end(e);
    put(e, "\n");
}

static void put_camera(lua_export *e, uint32_t index) {
    const char *kind = e->d->objects[CATEGORY_CAMERA].items[index].type->name;
    put(e, "camera {");
    if (strcmp(kind, "perspective") != 0) put(e, " kind = \"%s\",", kind);
    put_fields(e, CATEGORY_CAMERA, index, NULL);
    put_called(e, CATEGORY_CAMERA, index);
    put_end(e);
    put(e, "\n");
}

static void put_light(lua_export *e, uint32_t index) {
    put(e, "light.%s {", e->d->objects[CATEGORY_LIGHT].items[index].type->name);
    put_fields(e, CATEGORY_LIGHT, index, NULL);
    put_called(e, CATEGORY_LIGHT, index);
    put_end(e);
    put(e, "\n");
}

static void put_all(lua_export *e, category which, const char *table,
                    void (*put_one)(lua_export *e, uint32_t index)) {
    size_t count = e->d->objects[which].count;
    if (count == 0) return;
    put(e, "\n%s", table);
    for (uint32_t i = 0; i < count && !e->status; i++) put_one(e, i);
}

static void put_scene(lua_export *e) {
    put(e,
        "-- Written by snell %s; the picture is the same as that of the %s file it was made of.\n",
        SNELL_VERSION_STRING, e->d->format[0] ? e->d->format : "scene's");
    put_render(e);
    put_animation(e);
    put_setting(e, &setting_background);
    put_setting(e, &setting_ambient);
    put_model_background(e);
    put_all(e, CATEGORY_TEXTURE, "local t = {}\n", put_texture);
    put_all(e, CATEGORY_MATERIAL, "local m = {}\n", put_material);
    put_all(e, CATEGORY_CAMERA, "", put_camera);
    put_all(e, CATEGORY_LIGHT, "", put_light);
    put(e, "\n");
    put_shapes(e);
}

snell_status lua_write(const description *d, const char *path) {
    lua_export e = {.d = d, .path = path};
    put_scene(&e);
    if (!e.status) e.status = file_write_atomic(path, e.text, e.size);
    part_lists_free(&e.lists);
    free(e.uses);
    free(e.made);
    free(e.filled);
    free(e.text);
    return e.status;
}
