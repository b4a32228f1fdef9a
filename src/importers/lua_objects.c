/* The vocabulary that the registries give: a global for each shape and setting, camera, and the
 * members of material, light and texture. A new type appears here by itself. The few forms that the
 * language writes more briefly are at the end. */
#include "importers/lua_scene.h"

#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "cameras/camera.h"
#include "geometry/solid.h"
#include "lights/sky.h"
#include "maths/functions.h"
#include "scene/settings.h"

enum { FIELDS_MAX = 64, EXTRAS_MAX = 8 };

/* ---- the general form ---- */

typedef struct construction {
    const char *label;
    const char *extras[EXTRAS_MAX]; /* names that the table may have besides the type's fields */
    uint32_t extra_count;
    lua_Integer positional;
    snell_param params[FIELDS_MAX];
    uint32_t count;
} construction;

static void check_names(lua_State *L, const type_info *type, const construction *c) {
    const char *names[FIELDS_MAX + EXTRAS_MAX];
    size_t count = 0;
    for (uint32_t i = 0; i < type->field_count && i < FIELDS_MAX; i++)
        names[count++] = type->fields[i].name;
    for (uint32_t i = 0; i < c->extra_count; i++) names[count++] = c->extras[i];
    values_check_keys(L, c->label, names, count, c->positional);
}

static void append_param(lua_State *L, construction *c, snell_param param) {
    if (c->count >= FIELDS_MAX)
        scene_fail(L, SNELL_ERR_INTERNAL, NULL, "%s: too many fields", c->label);
    c->params[c->count++] = param;
}

/* Reads the table at index 1; what the parameters point to stays on the stack. */
static void read_fields(lua_State *L, const type_info *type, construction *c) {
    check_names(L, type, c);
    if (!lua_checkstack(L, 3 * FIELDS_MAX)) scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    for (uint32_t i = 0; i < type->field_count; i++) {
        lua_pushstring(L, type->fields[i].name);
        if (lua_rawget(L, 1) == LUA_TNIL) {
            lua_pop(L, 1);
            continue;
        }
        snell_param param;
        values_read_field(L, type, &type->fields[i], c->label, &param);
        append_param(L, c, param);
    }
}

/* Adds the object and returns its number. */
static uint32_t add_object(lua_State *L, const type_info *type, const construction *c,
                           const char *name) {
    uint32_t index, line;
    object_source source = {.name = name};
    source.line = line = scene_line(L, &source.file);
    (void)line;
    sandbox_charge(L, 20);
    if (description_add(scene_of(L)->d, type->category, type->name, c->params, c->count, source,
                        &index))
        scene_fail_last(L, type->name, c->label);
    return index;
}

/* The name field of the table; an error if the category has it already. */
static const char *read_name(lua_State *L, const char *label) {
    return values_get_string(L, label, "name");
}

node objects_read_common(lua_State *L, const char *label, const char **name) {
    *name = read_name(L, label);
    return (node){.shape = NO_SHAPE,
                  .material = values_get_material(L, label),
                  .line = scene_line(L, NULL),
                  .placed = values_get_placement(L, label),
                  .motion = motion_read(L, label),
                  .name = (char *)(uintptr_t)*name};
}

static int push_shape(lua_State *L, const type_info *type, construction *c) {
    const char *name;
    node made = objects_read_common(L, c->label, &name);
    made.shape = add_object(L, type, c, name);
    nodes_add_shape(L, &made);
    return 1;
}

static void allow(construction *c, const char *name) { c->extras[c->extra_count++] = name; }

/* ---- shapes, materials, lights, textures ---- */

static int make_shape(lua_State *L) {
    const type_info *type = lua_touserdata(L, lua_upvalueindex(1));
    construction c = {.label = type->name};
    values_need_table(L, type->name);
    if (strcmp(type->name, "mesh") == 0) {
        lua_pushliteral(L, "file");
        if (lua_rawget(L, 1) != LUA_TNIL) return files_mesh(L);
        lua_pop(L, 1);
        mesh_keys_expand(L);
        allow(&c, "file");
        allow(&c, "keys");
    }
    if (strcmp(type->name, "heightfield") == 0) heights_expand(L);
    allow(&c, "material");
    allow(&c, "transform");
    allow(&c, "motion");
    allow(&c, "name");
    read_fields(L, type, &c);
    return push_shape(L, type, &c);
}

/* The vec3 or float field of an object that was added. */
static const void *value_of(const object *o, const char *field_name) {
    return (const char *)o->desc + type_find_field(o->type, field_name)->offset;
}

/* light.environment { sky = { sun, turbidity, .. } }: a light.sky and, as a light of its own, its
 * sun. */
static void make_sky(lua_State *L) {
    const type_info *type = type_find(CATEGORY_LIGHT, "sky");
    static const char *const alone[] = {"sky", "name"};
    int at = lua_gettop(L);
    values_check_keys(L, "light.environment", alone, 2, 0);
    const char *name = read_name(L, "light.environment");
    lua_pushvalue(L, at);
    if (!lua_istable(L, -1))
        scene_fail(L, SNELL_ERR_SYNTAX, "sky = { sun = {1,1,0}, turbidity = 3 }",
                   "light.environment: 'sky' must be a table");
    lua_replace(L, 1);
    construction c = {.label = "sky"};
    read_fields(L, type, &c);
    uint32_t index = add_object(L, type, &c, name);
    const object *sky = &scene_of(L)->d->objects[CATEGORY_LIGHT].items[index];
    vec3 sun = *(const vec3 *)value_of(sky, "sun");
    double turbidity = (double)*(const float *)value_of(sky, "turbidity"),
           scale = (double)*(const float *)value_of(sky, "scale");
    dvec3 irradiance = dvec3_scale(sky_sun_irradiance((double)sun.y, turbidity), scale);
    construction disk = {.label = "sky"};
    append_param(L, &disk,
                 (snell_param){.name = "direction",
                               .kind = SNELL_PARAM_VEC3,
                               .value.v = vec3_scale(sun, -1)});
    append_param(L, &disk,
                 (snell_param){.name = "irradiance",
                               .kind = SNELL_PARAM_VEC3,
                               .value.v = vec3_from(irradiance)});
    append_param(L, &disk,
                 (snell_param){.name = "angle", .kind = SNELL_PARAM_FLOAT, .value.f = SUN_ANGLE});
    add_object(L, type_find(CATEGORY_LIGHT, "directional"), &disk, NULL);
}

/* light.environment { file = "sky.exr" }: `radiance` is then what the picture is multiplied by. */
static void add_environment_file(lua_State *L, construction *c) {
    lua_pushliteral(L, "file");
    if (lua_rawget(L, 1) == LUA_TNIL) {
        lua_pop(L, 1);
        return;
    }
    snell_input radiance = {{1, 1, 1}, {files_environment(L), 0}};
    snell_param *given = NULL;
    for (uint32_t i = 0; i < c->count; i++)
        if (strcmp(c->params[i].name, "radiance") == 0) given = &c->params[i];
    if (given && (given->kind == SNELL_PARAM_TEXTURE || given->kind == SNELL_PARAM_INPUT))
        scene_fail(L, SNELL_ERR_SYNTAX, "with a file, 'radiance' is a number or a colour",
                   "light.environment: both 'file' and a texture");
    if (given && given->kind == SNELL_PARAM_VEC3) radiance.value = given->value.v;
    if (given && given->kind == SNELL_PARAM_FLOAT)
        radiance.value = vec3_scale(radiance.value, (float)given->value.f);
    const snell_param param = {
        .name = "radiance", .kind = SNELL_PARAM_INPUT, .value.input = radiance};
    if (given)
        *given = param;
    else
        append_param(L, c, param);
}

static int make_light(lua_State *L) {
    const type_info *type = lua_touserdata(L, lua_upvalueindex(1));
    construction c = {.label = lua_tostring(L, lua_upvalueindex(2))};
    values_need_table(L, c.label);
    bool environment = strcmp(type->name, "environment") == 0;
    if (environment) {
        values_refuse_both(L, c.label, "sky", "file");
        values_refuse_both(L, c.label, "sky", "radiance");
        lua_pushliteral(L, "sky");
        if (lua_rawget(L, 1) != LUA_TNIL) {
            make_sky(L);
            return 0;
        }
        lua_pop(L, 1);
        allow(&c, "file");
        allow(&c, "sky");
    }
    allow(&c, "name");
    read_fields(L, type, &c);
    if (environment) add_environment_file(L, &c);
    add_object(L, type, &c, read_name(L, c.label));
    return 0;
}

/* Walls that give back more than they get make a picture that only looks wrong. */
static void warn_of_bright(lua_State *L, const type_info *type, const char *label, uint32_t index) {
    description *d = scene_of(L)->d;
    const object *made = &d->objects[CATEGORY_MATERIAL].items[index];
    for (uint32_t i = 0; i < type->field_count; i++) {
        const field *f = &type->fields[i];
        if (f->kind != FIELD_INPUT || choice_find("color|reflectance", f->name) < 0) continue;
        const snell_input *input =
            (const void *)((const char *)made->desc + f->offset); /* aligned: a member */
        if (input->texture.index1 || !(vec3_largest(input->value) > 1)) continue;
        if (description_add_message(
                d, SNELL_WARNING, made->file, made->line, "0 to 1; what glows has 'emission'",
                "%s: '%s' is above 1: more light leaves than arrives", label, f->name))
            scene_fail_last(L, NULL, NULL);
    }
}

/* Normals are data: decoded as colours they lean the wrong way. */
static void warn_of_coded_normals(lua_State *L, const type_info *type, const char *label,
                                  const char *name, uint32_t index) {
    description *d = scene_of(L)->d;
    const object *made = &d->objects[CATEGORY_MATERIAL].items[index];
    const field *f = type_find_field(type, name);
    if (f == NULL) return;
    uint32_t index1 =
        ((const snell_texture_id *)(const void *)((const char *)made->desc + f->offset))->index1;
    if (index1 == 0) return;
    const object *map = &d->objects[CATEGORY_TEXTURE].items[index1 - 1];
    const field *encoding = type_find_field(map->type, "encoding");
    if (encoding == NULL) return;
    int32_t coded = *(const int32_t *)(const void *)((const char *)map->desc + encoding->offset);
    char word[16];
    choice_word(encoding->choices, coded, word, sizeof word);
    if (strcmp(word, "srgb") == 0 &&
        description_add_message(d, SNELL_WARNING, made->file, made->line,
                                "texture.image { file = .., encoding = \"linear\" }",
                                "%s: the image of '%s' is read as sRGB colours", label, name))
        scene_fail_last(L, NULL, NULL);
}

static int make_material(lua_State *L) {
    const type_info *type = lua_touserdata(L, lua_upvalueindex(1));
    construction c = {.label = lua_tostring(L, lua_upvalueindex(2))};
    values_need_table(L, c.label);
    allow(&c, "name");
    read_fields(L, type, &c);
    uint32_t index = add_object(L, type, &c, read_name(L, c.label));
    warn_of_bright(L, type, c.label, index);
    warn_of_coded_normals(L, type, c.label, "normal_map", index);
    warn_of_coded_normals(L, type, c.label, "clearcoat_normal_map", index);
    handle_push(L, HANDLE_MATERIAL, index);
    return 1;
}

/* texture.checker { a, b, size = 1 }: its two colours may come first, without a name. */
static void read_checker_colors(lua_State *L, const type_info *type, construction *c) {
    static const char *const names[] = {"color_a", "color_b"};
    for (int i = 0; i < 2; i++) {
        if (lua_rawgeti(L, 1, i + 1) == LUA_TNIL) {
            lua_pop(L, 1);
            continue;
        }
        const field *f = type_find_field(type, names[i]);
        if (f == NULL) scene_fail(L, SNELL_ERR_INTERNAL, NULL, "%s: no %s", c->label, names[i]);
        snell_param param;
        values_read_field(L, type, f, c->label, &param);
        append_param(L, c, param); /* given by name too: description_add says so */
    }
}

static int make_texture(lua_State *L) {
    const type_info *type = lua_touserdata(L, lua_upvalueindex(1));
    construction c = {.label = lua_tostring(L, lua_upvalueindex(2))};
    values_need_table(L, c.label);
    if (strcmp(type->name, "image") == 0) return files_image(L, type);
    allow(&c, "name");
    if (strcmp(type->name, "checker") == 0) c.positional = 2;
    read_fields(L, type, &c);
    if (c.positional) read_checker_colors(L, type, &c);
    handle_push(L, HANDLE_TEXTURE, add_object(L, type, &c, read_name(L, c.label)));
    return 1;
}

static int make_setting(lua_State *L) {
    const type_info *type = lua_touserdata(L, lua_upvalueindex(1));
    construction c = {.label = type->name};
    values_need_table(L, type->name);
    const object *first = description_setting(scene_of(L)->d, type->name);
    if (first) {
        char hint[96];
        snprintf(hint, sizeof hint, "put everything into the one on line %u", first->line);
        scene_fail(L, SNELL_ERR_SYNTAX, hint, "%s: given a second time", type->name);
    }
    read_fields(L, type, &c);
    add_object(L, type, &c, NULL);
    return 0;
}

/* triangle { {..}, {..}, {..} }: a mesh of one. */
static int make_triangle(lua_State *L) {
    static const char *const names[] = {"material", "transform", "name", "motion"};
    static const uint32_t indices[] = {0, 1, 2};
    const type_info *type = type_find(CATEGORY_SHAPE, "mesh");
    construction c = {.label = "triangle"};
    values_need_table(L, c.label);
    values_check_keys(L, c.label, names, 4, 3);
    snell_vec3 corners[3];
    for (int i = 0; i < 3; i++) {
        double v[3];
        if (lua_rawgeti(L, 1, i + 1) == LUA_TNIL)
            scene_fail(L, SNELL_ERR_SYNTAX, "triangle { {0,0,0}, {1,0,0}, {0,1,0} }",
                       "triangle: needs three points");
        values_read_vec3(L, -1, c.label, i == 0 ? "1" : i == 1 ? "2" : "3", v);
        corners[i] = (snell_vec3){(float)v[0], (float)v[1], (float)v[2]};
        lua_pop(L, 1);
    }
    append_param(
        L, &c,
        (snell_param){.name = "positions", .kind = SNELL_PARAM_ARRAY, .value.array = {corners, 3}});
    append_param(
        L, &c,
        (snell_param){.name = "indices", .kind = SNELL_PARAM_ARRAY, .value.array = {indices, 3}});
    return push_shape(L, type, &c);
}

/* ---- cameras ---- */

static const type_info *camera_kind(lua_State *L) {
    const char *kind = values_get_string(L, "camera", "kind");
    if (kind == NULL) kind = "perspective";
    const type_info *type = type_find(CATEGORY_CAMERA, kind);
    if (type) return type;
    const char *names[32];
    size_t count = 0;
    const type_info *each;
    for (uint32_t i = 0; (each = type_at(i)) != NULL; i++)
        if (each->category == CATEGORY_CAMERA && count < 32) names[count++] = each->name;
    scene_fail_unknown(L, "camera", "camera: unknown kind", kind, names, count);
}

/* camera { view = {azimuth, elevation}, of = object }: from is found when the picture is known. */
static bool read_framing(lua_State *L, framing *out) {
    lua_pushliteral(L, "view");
    bool has_view = lua_rawget(L, 1) != LUA_TNIL;
    lua_pushliteral(L, "of");
    bool has_object = lua_rawget(L, 1) != LUA_TNIL;
    if (!has_view && !has_object) return false;
    if (!has_view || !has_object)
        scene_fail(L, SNELL_ERR_SYNTAX, "camera { view = {30, 12}, of = object }",
                   "camera: '%s' is missing", has_view ? "of" : "view");
    static const char *const instead[] = {"from", "at"};
    for (int i = 0; i < 2; i++) {
        lua_pushstring(L, instead[i]);
        if (lua_rawget(L, 1) != LUA_TNIL)
            scene_fail(L, SNELL_ERR_SYNTAX, "give one of the two", "camera: both 'view' and '%s'",
                       instead[i]);
        lua_pop(L, 1);
    }
    uint32_t index;
    if (!handle_get(L, -1, HANDLE_SHAPE, &index))
        scene_fail(L, SNELL_ERR_SYNTAX, NULL, "camera: 'of' must be a shape, a group or a model");
    out->bounds = nodes_bounds(L, index);
    lua_pop(L, 1);
    double angles[2] = {0, 0};
    if (!lua_istable(L, -1) || lua_rawlen(L, -1) != 2)
        scene_fail(L, SNELL_ERR_SYNTAX, "degrees", "camera: 'view' must be {azimuth, elevation}");
    for (int i = 0; i < 2; i++) {
        lua_rawgeti(L, -1, i + 1);
        angles[i] = values_read_number(L, -1, "camera", "view");
        lua_pop(L, 1);
    }
    if (!(angles[1] > -90 && angles[1] < 90))
        scene_fail(L, SNELL_ERR_SYNTAX, NULL,
                   "camera: the elevation is %g degrees; it must be between -90 and 90", angles[1]);
    out->azimuth = angles[0] * (PI / 180);
    out->elevation = angles[1] * (PI / 180);
    lua_pop(L, 1);
    return true;
}

static int make_camera(lua_State *L) {
    lua_scene *s = scene_of(L);
    construction c = {.label = "camera"};
    values_need_table(L, "camera");
    const type_info *type = camera_kind(L);
    allow(&c, "name");
    allow(&c, "kind");
    allow(&c, "view");
    allow(&c, "of");
    read_fields(L, type, &c);
    framing frame;
    bool framed = read_framing(L, &frame);
    frame.camera = add_object(L, type, &c, read_name(L, "camera"));
    if (framed) {
        if (type != &camera_perspective.info)
            scene_fail(L, SNELL_ERR_UNSUPPORTED, NULL, "camera: 'view' needs a perspective camera");
        if (!ARRAY_GROW(s->framings, s->framing_count, s->framing_capacity, 1))
            scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
        s->framings[s->framing_count++] = frame;
    }
    return 0;
}

/* The bounding sphere touches the edges of the picture's smaller side: at distance r / sin(half).
 */
static void frame_camera(const framing *f, perspective_desc *camera, double aspect) {
    dvec3 low = dvec3_from(f->bounds.min), high = dvec3_from(f->bounds.max);
    dvec3 center = dvec3_scale(dvec3_add(low, high), 0.5);
    double radius = dvec3_length(dvec3_sub(high, low)) / 2;
    double half = (double)camera->fov / 2;
    if (aspect < 1) half = fn_atan(fn_tan(half) * aspect);
    double distance = radius / fn_sin(half), flat = fn_cos(f->elevation);
    dvec3 direction = {flat * fn_sin(f->azimuth), fn_sin(f->elevation), flat * fn_cos(f->azimuth)};
    camera->at = vec3_from(center);
    camera->from = vec3_from(dvec3_add(center, dvec3_scale(direction, distance)));
}

void objects_frame_cameras(lua_State *L) {
    lua_scene *s = scene_of(L);
    double width = DEFAULT_WIDTH, height = DEFAULT_HEIGHT;
    const object *render = description_setting(s->d, "render");
    if (render) {
        const render_desc *said = render->desc;
        if (said->width > 0) width = said->width;
        if (said->height > 0) height = said->height;
    }
    for (size_t i = 0; i < s->framing_count; i++)
        frame_camera(&s->framings[i],
                     s->d->objects[CATEGORY_CAMERA].items[s->framings[i].camera].desc,
                     width / height);
}

/* ---- what there is ---- */

static lua_CFunction maker(category which) {
    switch (which) {
    case CATEGORY_TEXTURE: return make_texture;
    case CATEGORY_MATERIAL: return make_material;
    case CATEGORY_LIGHT: return make_light;
    case CATEGORY_SHAPE: return make_shape;
    case CATEGORY_SETTING: return make_setting;
    default: return NULL; /* cameras are one global with a kind */
    }
}

/* A member of the table on the top for each type of the category. prefix: "material.", or "". */
static void open_category(lua_State *L, category which, const char *prefix) {
    const type_info *type;
    for (uint32_t i = 0; (type = type_at(i)) != NULL; i++) {
        if (type->category != which) continue;
        if (type == &primitive_solid.info) continue; /* union, intersection, difference */
        lua_pushlightuserdata(L, (void *)(uintptr_t)type);
        lua_pushfstring(L, "%s%s", prefix, type->name);
        lua_pushcclosure(L, maker(which), 2);
        lua_setfield(L, -2, type->name);
    }
}

static void open_namespace(lua_State *L, category which, const char *name, const char *prefix) {
    lua_newtable(L);
    open_category(L, which, prefix);
    sandbox_guard(L, name);
    lua_setglobal(L, name);
}

void objects_open(lua_State *L) {
    open_namespace(L, CATEGORY_MATERIAL, "material", "material.");
    open_namespace(L, CATEGORY_TEXTURE, "texture", "texture.");
    open_namespace(L, CATEGORY_LIGHT, "light", "light.");
    lua_pushglobaltable(L);
    open_category(L, CATEGORY_SHAPE, "");
    open_category(L, CATEGORY_SETTING, "");
    lua_pop(L, 1);
    lua_pushcfunction(L, make_triangle);
    lua_setglobal(L, "triangle");
    lua_pushcfunction(L, make_camera);
    lua_setglobal(L, "camera");
}
