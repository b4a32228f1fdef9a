/* Writes a scene of spheres, planes and point lights for POV-Ray and Tachyon, so that they draw the
 * same picture: same places, same camera, matte and mirror shares, light that falls off with the
 * square of the distance. What has no counterpart there is an error.
 *
 *     export_scene SCENE.lua OUT.pov OUT.dat */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"

static void die(const char *what) {
    fprintf(stderr, "export_scene: %s\n", what);
    exit(1);
}

static void check(snell_status status) {
    if (status) die(snell_last_error()->text);
}

/* ---- fields of descriptions, by name ---- */

static const void *field_at(const object *o, const char *name, field_kind kind) {
    const field *f = type_find_field(o->type, name);
    if (f == NULL || f->kind != kind) {
        fprintf(stderr, "export_scene: %s has no such %s\n", o->type->name, name);
        exit(1);
    }
    return (const char *)o->desc + f->offset;
}

static dvec3 vector_of(const object *o, const char *name) {
    return dvec3_from(*(const vec3 *)field_at(o, name, FIELD_VEC3));
}
static double number_of(const object *o, const char *name) {
    return (double)*(const float *)field_at(o, name, FIELD_FLOAT);
}
static dvec3 color_of(const object *o, const char *name) {
    return dvec3_from(*(const vec3 *)field_at(o, name, FIELD_COLOR));
}
static int whole_of(const object *o, const char *name) {
    return *(const int32_t *)field_at(o, name, FIELD_INT);
}
static dvec3 plain_input(const object *o, const char *name, field_kind kind) {
    const snell_input *in = field_at(o, name, kind);
    if (in->texture.index1) die("textures are not exported");
    return dvec3_from(in->value);
}

/* ---- what both are told ---- */

typedef struct look {
    dvec3 color;
    double matte, mirror; /* shares */
} look;

static look look_of(const description *d, uint32_t number) {
    if (number == NO_MATERIAL) die("a shape without a material is not exported");
    const object *o = &d->objects[CATEGORY_MATERIAL].items[number];
    if (strcmp(o->type->name, "lambert") == 0)
        return (look){plain_input(o, "color", FIELD_INPUT), 1, 0};
    if (strcmp(o->type->name, "partial_mirror") != 0)
        die("only lambert and partial_mirror are exported");
    look l = {plain_input(o, "color", FIELD_INPUT), 0, 0};
    l.mirror = plain_input(o, "specularity", FIELD_SCALAR).x;
    l.matte = 1 - l.mirror;
    if (l.color.x != 1 || l.color.y != 1 || l.color.z != 1) die("mirrors have the colour 1 here");
    return l;
}

typedef struct view {
    dvec3 from, forward, right, up;
    double half_height; /* tangent of half the field of view */
    int width, height, depth;
} view;

static view view_of(const description *d) {
    const object_list *cameras = &d->objects[CATEGORY_CAMERA];
    const object *settings = description_setting(d, "render");
    if (cameras->count != 1 || settings == NULL) die("one camera and render{} are needed");
    const object *c = &cameras->items[0];
    if (strcmp(c->type->name, "perspective") != 0) die("only perspective cameras are exported");
    view v = {.from = vector_of(c, "from")};
    v.forward = dvec3_normalize(dvec3_sub(vector_of(c, "at"), v.from));
    v.right = dvec3_normalize(dvec3_cross(v.forward, vector_of(c, "up")));
    v.up = dvec3_cross(v.right, v.forward);
    v.half_height = tan(number_of(c, "fov") / 2);
    v.width = whole_of(settings, "width");
    v.height = whole_of(settings, "height");
    v.depth = whole_of(settings, "max_depth");
    if (v.width <= 0 || v.height <= 0 || v.depth < 0) die("render{} needs size and max_depth");
    return v;
}

static const object *drawn_shape(const description *d, size_t i) {
    const instance *at = &d->instances[i];
    transform identity = transform_identity();
    if (memcmp(&at->to_world, &identity, sizeof identity) != 0 || at->owner != NO_GROUP ||
        at->key_count)
        die("transforms, groups and motion are not exported");
    return &d->objects[CATEGORY_SHAPE].items[at->shape];
}

static dvec3 light_of(const object *o, dvec3 *position) {
    if (strcmp(o->type->name, "point") != 0) die("only point lights are exported");
    *position = vector_of(o, "position");
    dvec3 intensity = color_of(o, "intensity");
    return dvec3_scale(intensity, 1 / 3.14159265358979); /* their matte surfaces lack 1 / pi */
}

/* ---- POV-Ray ---- */

static void pov_shape(FILE *f, const object *o) {
    if (strcmp(o->type->name, "sphere") == 0) {
        dvec3 c = vector_of(o, "center");
        fprintf(f, "sphere{<%.9g,%.9g,%.9g>,%.9g ", c.x, c.y, c.z, number_of(o, "radius"));
    } else if (strcmp(o->type->name, "plane") == 0) {
        dvec3 n = vector_of(o, "normal");
        fprintf(f, "plane{<%.9g,%.9g,%.9g>,%.9g ", n.x, n.y, n.z,
                dvec3_dot(n, vector_of(o, "point")));
    } else
        die("only spheres and planes are exported");
}

/* Light falls off as 2 / (1 + (d / near)^2). */
static void pov_lights(FILE *f, const description *d) {
    const double near = 1e-3;
    for (size_t i = 0; i < d->objects[CATEGORY_LIGHT].count; i++) {
        dvec3 p, c = light_of(&d->objects[CATEGORY_LIGHT].items[i], &p);
        c = dvec3_scale(c, 0.5 / (near * near));
        fprintf(f,
                "light_source{<%.9g,%.9g,%.9g> color rgb <%.9g,%.9g,%.9g> fade_distance %g "
                "fade_power 2}\n",
                p.x, p.y, p.z, c.x, c.y, c.z, near);
    }
}

/* Its trace level of the camera's ray is 1. */
static void write_pov(FILE *f, const description *d) {
    view v = view_of(d);
    dvec3 sky = color_of(description_setting(d, "background"), "color");
    dvec3 right = dvec3_scale(v.right, 2 * v.half_height * v.width / v.height),
          up = dvec3_scale(v.up, 2 * v.half_height);
    fprintf(f,
            "#version 3.7;\nglobal_settings{assumed_gamma 1.0 max_trace_level %d}\n"
            "#default{finish{ambient 0}}\nbackground{color rgb <%.9g,%.9g,%.9g>}\n",
            v.depth + 1, sky.x, sky.y, sky.z);
    fprintf(f,
            "camera{perspective location <%.9g,%.9g,%.9g> direction <%.9g,%.9g,%.9g> right "
            "<%.9g,%.9g,%.9g> up <%.9g,%.9g,%.9g>}\n",
            v.from.x, v.from.y, v.from.z, v.forward.x, v.forward.y, v.forward.z, right.x, right.y,
            right.z, up.x, up.y, up.z);
    pov_lights(f, d);
    for (size_t i = 0; i < d->objects[CATEGORY_MATERIAL].count; i++) {
        look l = look_of(d, (uint32_t)i);
        fprintf(f, "#declare M%zu=texture{pigment{color rgb <%.9g,%.9g,%.9g>} finish{diffuse %.9g",
                i, l.color.x, l.color.y, l.color.z, l.matte);
        if (l.mirror > 0) fprintf(f, " reflection %.9g", l.mirror);
        fprintf(f, "}}\n");
    }
    for (size_t i = 0; i < d->instance_count; i++) {
        pov_shape(f, drawn_shape(d, i));
        look_of(d, d->instances[i].material);
        fprintf(f, "texture{M%u}}\n", d->instances[i].material);
    }
}

/* ---- Tachyon: left-handed, so x is mirrored ---- */

static void tachyon_shape(FILE *f, const object *o) {
    if (strcmp(o->type->name, "sphere") == 0) {
        dvec3 c = vector_of(o, "center");
        fprintf(f, "SPHERE CENTER %.9g %.9g %.9g RAD %.9g ", -c.x, c.y, c.z,
                number_of(o, "radius"));
    } else if (strcmp(o->type->name, "plane") == 0) {
        dvec3 p = vector_of(o, "point"), n = vector_of(o, "normal");
        fprintf(f, "PLANE CENTER %.9g %.9g %.9g NORMAL %.9g %.9g %.9g ", -p.x, p.y, p.z, -n.x, n.y,
                n.z);
    } else
        die("only spheres and planes are exported");
}

/* Its rays pass through corners of the pixels: half a pixel to the lower left makes that centres. */
static void turn_half_a_pixel(view *v) {
    double half = v->half_height / v->height;
    dvec3 right = v->right, up = v->up;
    v->forward = dvec3_sub(v->forward, dvec3_scale(dvec3_add(right, up), half));
    v->forward = dvec3_normalize(v->forward);
    v->right = dvec3_normalize(dvec3_cross(v->forward, up));
    v->up = dvec3_cross(v->right, v->forward);
}

static void write_tachyon(FILE *f, const description *d) {
    view v = view_of(d);
    turn_half_a_pixel(&v);
    dvec3 sky = color_of(description_setting(d, "background"), "color");
    fprintf(
        f,
        "BEGIN_SCENE\nRESOLUTION %d %d\nCAMERA PROJECTION PERSPECTIVE ZOOM %.9g ASPECTRATIO 1.0 "
        "ANTIALIASING 0 RAYDEPTH %d\n",
        v.width, v.height, 0.5 / v.half_height, v.depth + 1);
    fprintf(f,
            "CENTER %.9g %.9g %.9g\nVIEWDIR %.9g %.9g %.9g\nUPDIR %.9g %.9g %.9g\nEND_CAMERA\n"
            "BACKGROUND %.9g %.9g %.9g\n",
            -v.from.x, v.from.y, v.from.z, -v.forward.x, v.forward.y, v.forward.z, -v.up.x, v.up.y,
            v.up.z, sky.x, sky.y, sky.z);
    for (size_t i = 0; i < d->objects[CATEGORY_LIGHT].count; i++) {
        dvec3 p, c = light_of(&d->objects[CATEGORY_LIGHT].items[i], &p);
        fprintf(f,
                "LIGHT CENTER %.9g %.9g %.9g RAD 0.001 ATTENUATION CONSTANT 0 LINEAR 0 QUADRATIC 1 "
                "COLOR %.9g %.9g %.9g\n",
                -p.x, p.y, p.z, c.x, c.y, c.z);
    }
    for (size_t i = 0; i < d->objects[CATEGORY_MATERIAL].count; i++) {
        look l = look_of(d, (uint32_t)i);
        fprintf(f,
                "TEXDEF M%zu AMBIENT 0 DIFFUSE %.9g SPECULAR %.9g OPACITY 1 COLOR %.9g %.9g %.9g "
                "TEXFUNC 0\n",
                i, l.matte, l.mirror, l.color.x, l.color.y, l.color.z);
    }
    for (size_t i = 0; i < d->instance_count; i++) {
        tachyon_shape(f, drawn_shape(d, i));
        look_of(d, d->instances[i].material);
        fprintf(f, "M%u\n", d->instances[i].material);
    }
    fprintf(f, "END_SCENE\n");
}

typedef void write_fn(FILE *f, const description *d);

static void write_file(const char *path, const description *d, write_fn *write) {
    FILE *f = fopen(path, "w");
    if (f == NULL) die("a file cannot be written");
    write(f, d);
    if (ferror(f) || fclose(f)) die("a file cannot be written");
}

int main(int argc, char **argv) {
    if (argc != 4) {
        fprintf(stderr, "usage: export_scene SCENE.lua OUT.pov OUT.dat\n");
        return 2;
    }
    snell_context *context;
    snell_scene *s;
    check(snell_context_create(NULL, &context));
    check(snell_scene_create(context, &s));
    check(snell_scene_load(s, argv[1], NULL));
    write_file(argv[2], s->description, write_pov);
    write_file(argv[3], s->description, write_tachyon);
    snell_scene_destroy(s);
    snell_context_destroy(context);
    return 0;
}
