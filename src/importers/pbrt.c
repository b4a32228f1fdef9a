/* pbrt-v4 scene files: the directives, and the graphics state that they change. */
#include "importers/pbrt.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* ---- the stack of states ---- */

static snell_status push(pbrt *p, bool is_object) {
    if (!ARRAY_GROW(p->pushed, p->pushed_count, p->pushed_capacity, 1))
        return pbrt_blame(p, p->place, error_no_memory());
    p->pushed[p->pushed_count++] = (pbrt_pushed){p->state, is_object, p->place};
    return SNELL_OK;
}

static snell_status pop(pbrt *p, bool is_object, const char *directive, const char *begin) {
    if (p->pushed_count == 0)
        return pbrt_fail(p, p->place, NULL, "'%s' without a '%s'", directive, begin);
    const pbrt_pushed *top = &p->pushed[--p->pushed_count];
    if (top->is_object != is_object)
        return pbrt_fail(p, p->place, NULL, "'%s', but the last to begin was '%s' in line %u",
                         directive, top->is_object ? "ObjectBegin" : "AttributeBegin",
                         (unsigned)top->place.line);
    p->state = top->state;
    return SNELL_OK;
}

static snell_status do_attribute_begin(pbrt *p) { return push(p, false); }
static snell_status do_attribute_end(pbrt *p) {
    return pop(p, false, "AttributeEnd", "AttributeBegin");
}

/* Transforms alone: an older form that pbrt-v4 reads as attributes. */
static snell_status do_transform_begin(pbrt *p) {
    pbrt_warn(p, p->place,
              "TransformBegin and TransformEnd are old: read as AttributeBegin and "
              "AttributeEnd");
    return push(p, false);
}
static snell_status do_transform_end(pbrt *p) {
    return pop(p, false, "TransformEnd", "TransformBegin");
}

static snell_status do_attribute(pbrt *p) {
    static const char *const targets[] = {[ATTRIBUTE_SHAPE] = "shape",
                                          [ATTRIBUTE_LIGHT] = "light",
                                          [ATTRIBUTE_MATERIAL] = "material",
                                          [ATTRIBUTE_MEDIUM] = "medium",
                                          [ATTRIBUTE_TEXTURE] = "texture"};
    pbrt_params params;
    pbrt_need_params(p, "Attribute", &params);
    int target = 0;
    while (target < ATTRIBUTE_KINDS && strcmp(params.type, targets[target]) != 0) target++;
    if (!p->status && target == ATTRIBUTE_KINDS)
        pbrt_fail(p, params.place, "it is shape, light, material, medium or texture",
                  "no attributes of '%.40s'", params.type);
    if (p->status) {
        pbrt_params_free(&params);
        return p->status;
    }
    /* Both lists are last one first. */
    pbrt_param *last = NULL;
    for (pbrt_param *param = params.own; param; param = param->next) {
        param->is_attribute = true;
        param->kept = p->kept;
        p->kept = last = param;
    }
    if (last == NULL) return SNELL_OK;
    last->next = p->state.attributes[target];
    p->state.attributes[target] = params.own;
    return SNELL_OK;
}

/* ---- objects ---- */

static snell_status do_object_begin(pbrt *p) {
    source_place place = p->place;
    if (pbrt_need_string(p, "ObjectBegin")) return p->status;
    if (p->in_object) return pbrt_fail(p, place, NULL, "an object cannot begin within another");
    if (json_object_get(p->objects, p->word))
        return pbrt_fail(p, p->place, "give it another name", "a second object '%.60s'", p->word);
    free(p->object_name);
    p->object_name = memory_copy_string(p->word);
    if (p->object_name == NULL) return pbrt_blame(p, place, error_no_memory());
    p->place = place;
    if (pbrt_flush_strands(p)) return p->status;
    p->in_object = true;
    p->part_count = 0;
    return push(p, true);
}

static snell_status do_object_end(pbrt *p) {
    if (!p->in_object) return pbrt_fail(p, p->place, NULL, "'ObjectEnd' without an 'ObjectBegin'");
    source_place place = p->pushed_count ? p->pushed[p->pushed_count - 1].place : p->place;
    if (pop(p, true, "ObjectEnd", "ObjectBegin") || pbrt_flush_strands(p)) return p->status;
    p->in_object = false;
    uint32_t group = 0;
    if (p->part_count) {
        char name[NAME_MAX_SIZE];
        if (pbrt_blame(p, place,
                       names_make_unique(&p->names, CATEGORY_SHAPE, p->object_name, name)))
            return p->status;
        object_source source = {name[0] ? name : NULL, place.file, place.line};
        if (pbrt_blame(p, place,
                       description_add_group(p->d, p->parts, p->part_count, source, &group)))
            return p->status;
        group++;
    }
    if (json_object_set_new_nocheck(p->objects, p->object_name, json_integer(group)))
        return pbrt_blame(p, place, error_no_memory());
    return SNELL_OK;
}

/* The object's own world is flipped too, so its place is flipped before and after. */
static transform instance_place(const pbrt *p, int which) {
    dtransform to_world = pbrt_to_world(p, which);
    for (int r = 0; r < 3; r++) to_world.m[r][0] *= p->flip;
    return dtransform_round(&to_world);
}

static snell_status do_object_instance(pbrt *p) {
    source_place place = p->place;
    if (pbrt_need_string(p, "ObjectInstance")) return p->status;
    if (p->in_object)
        return pbrt_fail(p, place, NULL, "an object cannot have an instance of another in it");
    json_t *found = json_object_get(p->objects, p->word);
    if (found == NULL)
        return pbrt_fail(p, p->place, "it is made by ObjectBegin, before it is used",
                         "no object is called '%.60s'", p->word);
    uint32_t group = (uint32_t)json_integer_value(found), made;
    if (group == 0) return SNELL_OK;
    transform at = instance_place(p, 0);
    object_source source = {NULL, place.file, place.line};
    snell_status status =
        description_add_instance(p->d, group - 1, NO_MATERIAL, &at, source, &made);
    if (!status && pbrt_is_animated(p) && p->times[0] < p->times[1]) {
        motion_key keys[2] = {{(float)p->times[0], at}, {(float)p->times[1], instance_place(p, 1)}};
        p->moving = true;
        status = description_set_motion(p->d, made, keys, 2);
    }
    return pbrt_blame(p, place, status);
}

/* ---- what is made in the world ---- */

/* Reads the parameters, with the attributes of that kind, and lets `make` use them. */
static snell_status with_params(pbrt *p, const char *directive, int attributes,
                                snell_status (*make)(pbrt *p, const pbrt_params *params)) {
    pbrt_params params;
    pbrt_need_params(p, directive, &params);
    if (attributes >= 0) params.attributes = p->state.attributes[attributes];
    if (!p->status) make(p, &params);
    if (!p->status) pbrt_check_unused(p, &params);
    pbrt_params_free(&params);
    return p->status;
}

static snell_status do_shape(pbrt *p) {
    return with_params(p, "Shape", ATTRIBUTE_SHAPE, pbrt_shape);
}
static snell_status do_light_source(pbrt *p) {
    return with_params(p, "LightSource", ATTRIBUTE_LIGHT, pbrt_light);
}

static snell_status make_area_light(pbrt *p, const pbrt_params *params) {
    return pbrt_area_light_of(p, params, &p->state.area);
}
static snell_status do_area_light_source(pbrt *p) {
    return with_params(p, "AreaLightSource", ATTRIBUTE_LIGHT, make_area_light);
}

static snell_status make_material(pbrt *p, const pbrt_params *params) {
    return pbrt_material_add(p, NULL, params, &p->state.material);
}
static snell_status do_material(pbrt *p) {
    return with_params(p, "Material", ATTRIBUTE_MATERIAL, make_material);
}

/* A directive that begins with a name of the file's own, which the caller frees. */
static char *read_name(pbrt *p, const char *directive) {
    if (pbrt_need_string(p, directive)) return NULL;
    char *name = memory_copy_string(p->word);
    if (name == NULL) pbrt_blame(p, p->place, error_no_memory());
    return name;
}

static snell_status begin_named(pbrt *p, const char *directive, int attributes, char **name,
                                pbrt_params *params) {
    source_place place = p->place;
    *params = (pbrt_params){
        .place = place, .space = p->state.space, .attributes = p->state.attributes[attributes]};
    snprintf(params->what, sizeof params->what, "%s", directive);
    *name = read_name(p, directive);
    return p->status;
}

static snell_status do_make_named_material(pbrt *p) {
    char *name;
    pbrt_params params;
    size_t index = 0;
    source_place place = p->place;
    if (!begin_named(p, "MakeNamedMaterial", ATTRIBUTE_MATERIAL, &name, &params)) {
        if (json_object_get(p->named_materials, name))
            pbrt_fail(p, p->place, "give it another name", "a second material '%.60s'", name);
        pbrt_read_params(p, &params);
        const char *type = pbrt_string(p, &params, "type", NULL);
        if (!p->status && type == NULL)
            pbrt_fail(p, place, "such as \"string type\" \"diffuse\"",
                      "the material '%.60s' needs a type", name);
        if (!p->status) snprintf(params.type, sizeof params.type, "%s", type);
        if (!p->status) snprintf(params.what, sizeof params.what, "Material \"%.40s\"", type);
        if (!p->status) pbrt_material_add(p, name, &params, &index);
        if (!p->status) pbrt_check_unused(p, &params);
        if (!p->status &&
            json_object_set_new_nocheck(p->named_materials, name, json_integer((json_int_t)index)))
            pbrt_blame(p, place, error_no_memory());
    }
    pbrt_params_free(&params);
    free(name);
    return p->status;
}

static snell_status do_named_material(pbrt *p) {
    if (pbrt_need_string(p, "NamedMaterial")) return p->status;
    json_t *found = json_object_get(p->named_materials, p->word);
    if (found == NULL)
        return pbrt_fail(p, p->place, "it is made by MakeNamedMaterial, before it is used",
                         "no material is called '%.60s'", p->word);
    p->state.material = (size_t)json_integer_value(found);
    return SNELL_OK;
}

static snell_status read_texture(pbrt *p, const char *name, pbrt_params *params) {
    if (pbrt_need_string(p, "Texture")) return p->status;
    bool is_float = strcmp(p->word, "float") == 0;
    if (!is_float && strcmp(p->word, "spectrum") != 0)
        return pbrt_fail(p, p->place, NULL,
                         "the values of a texture are \"float\" or \"spectrum\", not '%.40s'",
                         p->word);
    if (pbrt_need_string(p, "Texture")) return p->status;
    snprintf(params->type, sizeof params->type, "%s", p->word);
    snprintf(params->what, sizeof params->what, "Texture \"%.40s\"", p->word);
    if (pbrt_read_params(p, params)) return p->status;
    if (pbrt_texture_add(p, name, is_float, params)) return p->status;
    return pbrt_check_unused(p, params);
}

static snell_status do_texture(pbrt *p) {
    char *name;
    pbrt_params params;
    if (!begin_named(p, "Texture", ATTRIBUTE_TEXTURE, &name, &params))
        read_texture(p, name, &params);
    pbrt_params_free(&params);
    free(name);
    return p->status;
}

/* Of media only the absorption is kept, for what is made of glass. */
static snell_status add_medium(pbrt *p, const char *name, const pbrt_params *params) {
    static const double none[3] = {0, 0, 0};
    double absorbed[3], scattered[3];
    bool absorbs, given, scatters = false;
    const char *type = pbrt_string(p, params, "type", "homogeneous");
    pbrt_color(p, params, "sigma_a", PBRT_COEFFICIENT, none, absorbed, &absorbs);
    pbrt_color(p, params, "sigma_s", PBRT_COEFFICIENT, none, scattered, &given);
    double scale = pbrt_float(p, params, "scale", 1);
    for (int i = 0; i < 3; i++) {
        scatters |= scattered[i] > 0;
        absorbed[i] = double_min(double_max(absorbed[i] * scale, 0), 1e6);
    }
    if (!p->status && (strcmp(type, "homogeneous") != 0 || scatters || !absorbs))
        pbrt_warn(p, params->place,
                  "media that scatter light are not supported: what they absorb counts in glass");
    for (pbrt_param *param = params->own; param; param = param->next) param->used = true;
    if (!p->status &&
        (!ARRAY_GROW(p->medium_list, p->medium_count, p->medium_capacity, 1) ||
         json_object_set_new_nocheck(p->media, name, json_integer((json_int_t)p->medium_count))))
        return pbrt_blame(p, params->place, error_no_memory());
    if (!p->status)
        p->medium_list[p->medium_count++] =
            (vec3){(float)absorbed[0], (float)absorbed[1], (float)absorbed[2]};
    return p->status;
}

static snell_status do_make_named_medium(pbrt *p) {
    char *name;
    pbrt_params params;
    if (!begin_named(p, "MakeNamedMedium", ATTRIBUTE_MEDIUM, &name, &params) &&
        !pbrt_read_params(p, &params))
        add_medium(p, name, &params);
    pbrt_params_free(&params);
    free(name);
    return p->status;
}

static snell_status do_medium_interface(pbrt *p) {
    if (pbrt_need_string(p, "MediumInterface")) return p->status;
    json_t *inside = json_object_get(p->media, p->word);
    if (inside == NULL && p->word[0])
        pbrt_warn(p, p->place, "no medium is called '%.60s': ignored", p->word);
    p->state.absorption = inside ? p->medium_list[json_integer_value(inside)] : (vec3){0, 0, 0};
    if (pbrt_next(p)) return p->status;
    if (p->kind != PBRT_STRING) p->held = true;
    return SNELL_OK;
}

static snell_status do_reverse_orientation(pbrt *p) {
    p->state.reverse = !p->state.reverse;
    return SNELL_OK;
}

/* ---- what stands before the world ---- */

static snell_status keep_params(pbrt *p, const char *directive, pbrt_params *where) {
    pbrt_params_free(where);
    return pbrt_need_params(p, directive, where);
}

static snell_status do_camera(pbrt *p) {
    source_place place = p->place;
    if (keep_params(p, "Camera", &p->camera)) return p->status;
    dtransform named[2];
    for (int i = 0; i < 2; i++)
        if (!pbrt_inverse(&p->state.ctm[i], &named[i]))
            return pbrt_fail(p, place, NULL, "the camera's transform cannot be undone");
    memcpy(p->from_camera, named, sizeof named);
    return pbrt_name_system(p, "camera", named);
}
static snell_status do_film(pbrt *p) { return keep_params(p, "Film", &p->film); }
static snell_status do_sampler(pbrt *p) { return keep_params(p, "Sampler", &p->sampler); }
static snell_status do_integrator(pbrt *p) { return keep_params(p, "Integrator", &p->integrator); }
static snell_status do_pixel_filter(pbrt *p) { return keep_params(p, "PixelFilter", &p->filter); }

static snell_status do_accelerator(pbrt *p) {
    pbrt_params params;
    pbrt_need_params(p, "Accelerator", &params); /* snell's own is as good */
    pbrt_params_free(&params);
    return p->status;
}

static snell_status do_color_space(pbrt *p) {
    static const char *const names[] = {"srgb", "dci-p3", "rec2020", "aces2065-1"};
    if (pbrt_need_string(p, "ColorSpace")) return p->status;
    for (int i = 0; i < 4; i++)
        if (strcmp(p->word, names[i]) == 0) {
            p->state.space = (pbrt_color_space)i;
            return SNELL_OK;
        }
    return pbrt_fail(p, p->place, "it is srgb, dci-p3, rec2020 or aces2065-1",
                     "unknown colour space '%.40s'", p->word);
}

/* Options are how pbrt computes, not what a picture shows. */
static snell_status do_option(pbrt *p) {
    if (pbrt_need_string(p, "Option") || pbrt_next(p)) return p->status;
    if (p->kind != PBRT_OPEN) return SNELL_OK;
    while (!pbrt_next(p) && p->kind != PBRT_CLOSE)
        if (p->kind == PBRT_END) return pbrt_fail(p, p->place, NULL, "'Option' does not end");
    return p->status;
}

static snell_status do_world_begin(pbrt *p) {
    if (pbrt_begin_world(p)) return p->status;
    p->in_world = true;
    p->state.ctm[0] = p->state.ctm[1] = dtransform_identity();
    p->state.active = 3;
    return pbrt_name_system(p, "world", p->state.ctm);
}

/* ---- files in files ---- */

static snell_status read_directives(pbrt *p);

static snell_status do_include(pbrt *p) {
    if (pbrt_need_string(p, "Include")) return p->status;
    char *name = memory_copy_string(p->word);
    if (name == NULL) return pbrt_blame(p, p->place, error_no_memory());
    pbrt_with_file(p, name, p->place, read_directives);
    free(name);
    return p->status;
}

/* What an imported file does to the state ends with it. */
static snell_status do_import(pbrt *p) {
    pbrt_state before = p->state;
    size_t pushed = p->pushed_count;
    if (do_include(p)) return p->status;
    if (p->pushed_count != pushed)
        return pbrt_fail(p, p->place, NULL,
                         "'AttributeBegin' and 'AttributeEnd' of the imported file do not match");
    p->state = before;
    return SNELL_OK;
}

/* ---- directives ---- */

enum { ANYWHERE, BEFORE_WORLD, IN_WORLD };
static const struct {
    const char *name;
    int where;
    snell_status (*read)(pbrt *p);
} directives[] = {
    {"Accelerator", BEFORE_WORLD, do_accelerator},
    {"ActiveTransform", ANYWHERE, pbrt_do_active_transform},
    {"AreaLightSource", IN_WORLD, do_area_light_source},
    {"Attribute", ANYWHERE, do_attribute},
    {"AttributeBegin", IN_WORLD, do_attribute_begin},
    {"AttributeEnd", IN_WORLD, do_attribute_end},
    {"Camera", BEFORE_WORLD, do_camera},
    {"ColorSpace", ANYWHERE, do_color_space},
    {"ConcatTransform", ANYWHERE, pbrt_do_concat_transform},
    {"CoordSysTransform", ANYWHERE, pbrt_do_coord_sys_transform},
    {"CoordinateSystem", ANYWHERE, pbrt_do_coordinate_system},
    {"Film", BEFORE_WORLD, do_film},
    {"Identity", ANYWHERE, pbrt_do_identity},
    {"Import", IN_WORLD, do_import},
    {"Include", ANYWHERE, do_include},
    {"Integrator", BEFORE_WORLD, do_integrator},
    {"LightSource", IN_WORLD, do_light_source},
    {"LookAt", ANYWHERE, pbrt_do_look_at},
    {"MakeNamedMaterial", IN_WORLD, do_make_named_material},
    {"MakeNamedMedium", ANYWHERE, do_make_named_medium},
    {"Material", IN_WORLD, do_material},
    {"MediumInterface", ANYWHERE, do_medium_interface},
    {"NamedMaterial", IN_WORLD, do_named_material},
    {"ObjectBegin", IN_WORLD, do_object_begin},
    {"ObjectEnd", IN_WORLD, do_object_end},
    {"ObjectInstance", IN_WORLD, do_object_instance},
    {"Option", BEFORE_WORLD, do_option},
    {"PixelFilter", BEFORE_WORLD, do_pixel_filter},
    {"ReverseOrientation", IN_WORLD, do_reverse_orientation},
    {"Rotate", ANYWHERE, pbrt_do_rotate},
    {"Sampler", BEFORE_WORLD, do_sampler},
    {"Scale", ANYWHERE, pbrt_do_scale},
    {"Shape", IN_WORLD, do_shape},
    {"Texture", IN_WORLD, do_texture},
    {"Transform", ANYWHERE, pbrt_do_transform},
    {"TransformBegin", IN_WORLD, do_transform_begin},
    {"TransformEnd", IN_WORLD, do_transform_end},
    {"TransformTimes", BEFORE_WORLD, pbrt_do_transform_times},
    {"Translate", ANYWHERE, pbrt_do_translate},
    {"WorldBegin", BEFORE_WORLD, do_world_begin},
};
enum { DIRECTIVE_COUNT = sizeof directives / sizeof directives[0] };

static snell_status unknown_directive(pbrt *p) {
    const char *names[DIRECTIVE_COUNT];
    char hint[80];
    if (strcmp(p->word, "WorldEnd") == 0)
        return pbrt_warn(p, p->place, "WorldEnd is of an older pbrt: ignored");
    for (size_t i = 0; i < DIRECTIVE_COUNT; i++) names[i] = directives[i].name;
    const char *like = closest_word(p->word, names, DIRECTIVE_COUNT);
    snprintf(hint, sizeof hint, "did you mean '%s'?", like ? like : "");
    return pbrt_fail(p, p->place, like ? hint : NULL, "unknown directive '%.40s'", p->word);
}

static snell_status read_directive(pbrt *p) {
    if (p->kind != PBRT_WORD)
        return pbrt_fail(p, p->place, NULL, "a directive such as Shape begins here, not '%.40s'",
                         p->word);
    for (size_t i = 0; i < DIRECTIVE_COUNT; i++) {
        if (strcmp(directives[i].name, p->word) != 0) continue;
        int where = directives[i].where;
        if (where == BEFORE_WORLD && p->in_world)
            return pbrt_fail(p, p->place, NULL, "'%s' stands before WorldBegin", p->word);
        if (where == IN_WORLD && !p->in_world)
            return pbrt_fail(p, p->place, NULL, "'%s' stands after WorldBegin", p->word);
        return directives[i].read(p);
    }
    return unknown_directive(p);
}

static snell_status read_directives(pbrt *p) {
    while (!pbrt_next(p) && p->kind != PBRT_END) {
        if (read_directive(p)) break;
        if (p->options->progress && p->depth == 1 && p->text->end > p->text->data)
            p->options->progress(p->options->progress_user,
                                 (double)(p->text->at - p->text->data) /
                                     (double)(p->text->end - p->text->data));
    }
    return p->status;
}

static snell_status read_whole(pbrt *p) {
    if (read_directives(p)) return p->status;
    if (!p->in_world)
        return pbrt_fail(p, p->place, "the file may be cut off", "the file has no WorldBegin");
    if (p->pushed_count) {
        const pbrt_pushed *top = &p->pushed[p->pushed_count - 1];
        return pbrt_fail(p, top->place, "the file may be cut off", "this '%s' does not end",
                         top->is_object ? "ObjectBegin" : "AttributeBegin");
    }
    return pbrt_flush_strands(p) ? p->status : pbrt_finish_view(p);
}

/* ---- the importer ---- */

static snell_status prepare(pbrt *p) {
    p->systems = json_object();
    p->float_textures = json_object();
    p->color_textures = json_object();
    p->named_materials = json_object();
    p->media = json_object();
    p->objects = json_object();
    if (!p->systems || !p->float_textures || !p->color_textures || !p->named_materials ||
        !p->media || !p->objects)
        return pbrt_blame(p, (source_place){p->path, 0, 0}, error_no_memory());
    p->state.ctm[0] = p->state.ctm[1] = dtransform_identity();
    p->from_camera[0] = p->from_camera[1] = dtransform_identity();
    p->state.active = 3;
    p->flip = -1;
    pbrt_params none = {.type = "diffuse", .what = "Material \"diffuse\""};
    none.place = (source_place){p->path, 0, 0};
    return pbrt_material_add(p, NULL, &none, &p->state.material);
}

static void free_kept(pbrt *p) {
    while (p->kept) {
        pbrt_param *next = p->kept->kept;
        pbrt_param_free(p->kept);
        p->kept = next;
    }
}

static void clean_up(pbrt *p) {
    pbrt_params *const lists[] = {&p->camera, &p->film, &p->sampler, &p->integrator, &p->filter};
    for (int i = 0; i < 5; i++) pbrt_params_free(lists[i]);
    json_t *const maps[] = {p->systems,         p->float_textures, p->color_textures,
                            p->named_materials, p->media,          p->objects};
    for (int i = 0; i < 6; i++) json_decref(maps[i]);
    for (size_t i = 0; i < p->texture_count; i++) pbrt_texture_free(&p->textures[i]);
    for (size_t i = 0; i < p->material_count; i++) free(p->materials[i].name);
    free_kept(p);
    pbrt_strands_free(&p->strands);
    free(p->word);
    free(p->pushed);
    free(p->system_list);
    free(p->textures);
    free(p->materials);
    free(p->variants);
    free(p->medium_list);
    free(p->object_name);
    free(p->parts);
    for (size_t i = 0; i < p->path_count; i++) free(p->paths[i]);
    free(p->paths);
    names_deinit(&p->names);
}

static snell_status pbrt_import(const char *path, const import_options *options, description *d) {
    pbrt p = {.path = path, .options = options, .d = d, .times = {0, 1}};
    p.budget = (options->memory_max ? options->memory_max : (uint64_t)4 << 30) / 3;
    if (!prepare(&p)) pbrt_with_file(&p, path, (source_place){path, 0, 0}, read_whole);
    clean_up(&p);
    snprintf(d->format, sizeof d->format, "pbrt");
    return p.status;
}

/* By its extension, since its words stand in other files as well. */
static bool pbrt_recognise(const char *extension, const uint8_t *first, size_t size) {
    (void)first, (void)size;
    return strcmp(extension, ".pbrt") == 0;
}

const importer importer_pbrt = {
    .name = "pbrt",
    .extensions = ".pbrt",
    .help = "scenes of pbrt-v4",
    .recognise = pbrt_recognise,
    .read = pbrt_import,
};
