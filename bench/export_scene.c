/* Writes a scene for the programs that bench/renders measures beside snell, so that all draw one
 * picture: the same places, camera, lights and shares of matte, mirror and glass. What has no
 * counterpart there is an error.
 *
 *     export_scene SCENE.lua FOLDER
 *
 * FOLDER, which exists, gets scene.pov for POV-Ray; scene.dat for Tachyon, where it can draw the
 * scene; and scene.json for bench/render_cycles.py and bench/render_mitsuba.py, with a mesh-N.ply
 * for each mesh, N from 0. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "api/api.h"
#include "geometry/mesh.h"

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
static const object *texture_of(const description *d, const snell_input *in) {
    if (in->texture.index1 == 0) return NULL;
    const object *t = &d->objects[CATEGORY_TEXTURE].items[in->texture.index1 - 1];
    if (strcmp(t->type->name, "checker") != 0) die("only the texture checker is exported");
    return t;
}
static dvec3 plain_input(const object *o, const char *name, field_kind kind) {
    const snell_input *in = field_at(o, name, kind);
    if (in->texture.index1) die("a texture there is not exported");
    return dvec3_from(in->value);
}
static const object *part_of(const description *d, const object *o, const char *name) {
    const snell_material_id *part = field_at(o, name, FIELD_MATERIAL);
    return &d->objects[CATEGORY_MATERIAL].items[part->index1 - 1];
}

/* ---- what all are told ---- */

typedef struct look {
    dvec3 color, other;   /* of the matte part; other: of a board's second squares */
    double square;        /* m, their side; 0: one colour */
    double matte, mirror; /* shares; mirrors are white */
    double ior;           /* of glass, whose shares are Fresnel's; else 0 */
} look;

static bool is(const object *o, const char *type) { return strcmp(o->type->name, type) == 0; }
static bool white(dvec3 c) { return c.x == 1 && c.y == 1 && c.z == 1; }

static look look_of(const description *d, uint32_t number) {
    if (number == NO_MATERIAL) die("a shape without a material is not exported");
    const object *o = &d->objects[CATEGORY_MATERIAL].items[number];
    look l = {.matte = 1};
    if (is(o, "dielectric")) {
        l.matte = 0;
        l.ior = number_of(o, "ior");
        return l;
    }
    if (is(o, "mirror")) {
        l.mirror = 1;
    } else if (is(o, "mix")) {
        l.mirror = plain_input(o, "weight", FIELD_SCALAR).x;
        if (!is(part_of(d, o, "b"), "mirror")) die("only mixes with a mirror as b are exported");
        o = part_of(d, o, "a");
    } else if (is(o, "partial_mirror")) {
        l.mirror = plain_input(o, "specularity", FIELD_SCALAR).x;
    }
    if (!is(o, "lambert") && !is(o, "partial_mirror") && !is(o, "mirror"))
        die("only lambert, mirror, partial_mirror, mix and dielectric are exported");
    if (!is(o, "lambert") && !white(plain_input(o, "color", FIELD_INPUT)))
        die("mirrors have the colour 1 here");
    l.matte = 1 - l.mirror;
    const snell_input *color = field_at(o, "color", FIELD_INPUT);
    const object *board = texture_of(d, color);
    l.color = l.other = dvec3_from(color->value);
    if (board) {
        l.color = dvec3_mul(l.color, color_of(board, "color_a"));
        l.other = dvec3_mul(l.other, color_of(board, "color_b"));
        l.square = number_of(board, "size");
    }
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
    if (!is(c, "perspective")) die("only perspective cameras are exported");
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
    const object *o = &d->objects[CATEGORY_SHAPE].items[at->shape];
    transform identity = transform_identity();
    if (at->owner != NO_GROUP || at->key_count || object_is_group(o))
        die("groups and motion are not exported");
    if (!is(o, "mesh") && memcmp(&at->to_world, &identity, sizeof identity) != 0)
        die("only meshes are exported with a transform");
    return o;
}

/* A vertex of a mesh where it is drawn; false: it has no normals, and *n is not set. */
static bool vertex_of(const mesh_desc *mesh, const instance *at, size_t i, dvec3 *p, dvec3 *n) {
    transform inverse;
    if (!transform_inverse(&at->to_world, &inverse)) die("a mesh is flattened");
    if (mesh->material_slots_count || mesh->key_times_count)
        die("a mesh has one material and one key here");
    *p = transform_point(&at->to_world, dvec3_from(mesh->positions[i]));
    if (mesh->normals_count == 0) return false;
    *n = dvec3_normalize(transform_normal(&inverse, dvec3_from(mesh->normals[i])));
    return true;
}

static bool is_point(const object *o) { return is(o, "point"); }

static dvec3 light_of(const object *o, dvec3 *position) {
    if (!is_point(o)) die("only point lights are exported for POV-Ray and Tachyon");
    *position = vector_of(o, "position");
    dvec3 intensity = color_of(o, "intensity");
    return dvec3_scale(intensity, 1 / 3.14159265358979); /* their matte surfaces lack 1 / pi */
}

/* ---- POV-Ray ---- */

static void pov_mesh(FILE *f, const mesh_desc *mesh, const instance *at) {
    dvec3 p, n;
    fprintf(f, "mesh2{vertex_vectors{%zu", mesh->positions_count);
    for (size_t i = 0; i < mesh->positions_count; i++) {
        vertex_of(mesh, at, i, &p, &n);
        fprintf(f, ",<%.7g,%.7g,%.7g>", p.x, p.y, p.z);
    }
    if (mesh->normals_count) fprintf(f, "}\nnormal_vectors{%zu", mesh->normals_count);
    for (size_t i = 0; i < mesh->normals_count; i++) {
        vertex_of(mesh, at, i, &p, &n);
        fprintf(f, ",<%.5g,%.5g,%.5g>", n.x, n.y, n.z);
    }
    fprintf(f, "}\nface_indices{%zu", mesh_triangle_count(mesh));
    for (size_t i = 0; i < mesh->indices_count; i += 3)
        fprintf(f, ",<%u,%u,%u>", mesh->indices[i], mesh->indices[i + 1], mesh->indices[i + 2]);
    fprintf(f, "} ");
}

/* Its checker's planes are moved out of the floor's, as snell's are. */
static void pov_shape(FILE *f, const object *o, const instance *at, const look *l) {
    dvec3 n = {0, 0, 0};
    if (is(o, "mesh")) {
        pov_mesh(f, o->desc, at);
    } else if (is(o, "sphere")) {
        dvec3 c = vector_of(o, "center");
        fprintf(f, "sphere{<%.9g,%.9g,%.9g>,%.9g ", c.x, c.y, c.z, number_of(o, "radius"));
    } else if (is(o, "plane")) {
        n = vector_of(o, "normal");
        fprintf(f, "plane{<%.9g,%.9g,%.9g>,%.9g ", n.x, n.y, n.z,
                dvec3_dot(n, vector_of(o, "point")));
    } else
        die("only spheres, planes and meshes are exported");
    n = dvec3_scale(n, 1e-4 * l->square);
    fprintf(f, "texture{M%u translate <%.9g,%.9g,%.9g>}", at->material, n.x, n.y, n.z);
    if (l->ior > 0) fprintf(f, " interior{ior %.9g}", l->ior);
    fprintf(f, "}\n");
}

static void pov_look(FILE *f, const look *l, size_t number) {
    dvec3 a = l->color, b = l->other;
    fprintf(f, "#declare M%zu=texture{pigment{", number);
    if (l->ior > 0)
        fprintf(f, "color rgbt 1} finish{diffuse 0 reflection{0,1 fresnel on} conserve_energy}");
    else if (l->square > 0)
        fprintf(f,
                "checker color rgb <%.9g,%.9g,%.9g> color rgb <%.9g,%.9g,%.9g> scale %.9g} "
                "finish{diffuse %.9g",
                a.x, a.y, a.z, b.x, b.y, b.z, l->square, l->matte);
    else
        fprintf(f, "color rgb <%.9g,%.9g,%.9g>} finish{diffuse %.9g", a.x, a.y, a.z, l->matte);
    if (l->mirror > 0) fprintf(f, " reflection %.9g", l->mirror);
    fprintf(f, "%s}\n", l->ior > 0 ? "" : "}");
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
        pov_look(f, &l, i);
    }
    for (size_t i = 0; i < d->instance_count; i++) {
        look l = look_of(d, d->instances[i].material);
        pov_shape(f, drawn_shape(d, i), &d->instances[i], &l);
    }
}

/* ---- Tachyon: left-handed, so x is mirrored, and corners change order ---- */

static void tachyon_mesh(FILE *f, const mesh_desc *mesh, const instance *at) {
    for (size_t t = 0; t < mesh->indices_count; t += 3) {
        dvec3 p[3], n[3];
        bool smooth = false;
        for (size_t i = 0; i < 3; i++)
            smooth = vertex_of(mesh, at, mesh->indices[t + 2 - i], &p[i], &n[i]);
        fprintf(f, smooth ? "STRI" : "TRI");
        for (int i = 0; i < 3; i++) fprintf(f, " V%d %.7g %.7g %.7g", i, -p[i].x, p[i].y, p[i].z);
        for (int i = 0; i < 3 && smooth; i++)
            fprintf(f, " N%d %.5g %.5g %.5g", i, -n[i].x, n[i].y, n[i].z);
        fprintf(f, " M%u\n", at->material);
    }
}

static void tachyon_shape(FILE *f, const object *o, const instance *at) {
    if (is(o, "mesh")) {
        tachyon_mesh(f, o->desc, at);
    } else if (is(o, "sphere")) {
        dvec3 c = vector_of(o, "center");
        fprintf(f, "SPHERE CENTER %.9g %.9g %.9g RAD %.9g M%u\n", -c.x, c.y, c.z,
                number_of(o, "radius"), at->material);
    } else if (is(o, "plane")) {
        dvec3 p = vector_of(o, "point"), n = vector_of(o, "normal");
        fprintf(f, "PLANE CENTER %.9g %.9g %.9g NORMAL %.9g %.9g %.9g M%u\n", -p.x, p.y, p.z, -n.x,
                n.y, n.z, at->material);
    } else
        die("only spheres, planes and meshes are exported");
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
        look_of(d, d->instances[i].material);
        tachyon_shape(f, drawn_shape(d, i), &d->instances[i]);
    }
    fprintf(f, "END_SCENE\n");
}

/* It refracts nothing, and has neither boards nor lamps with an area. */
static bool tachyon_can(const description *d) {
    for (size_t i = 0; i < d->objects[CATEGORY_MATERIAL].count; i++) {
        look l = look_of(d, (uint32_t)i);
        if (l.ior > 0 || l.square > 0) return false;
    }
    return true;
}

/* ---- Cycles and Mitsuba: JSON and PLY ---- */

static void json_vector(FILE *f, const char *name, dvec3 v) {
    fprintf(f, "\"%s\": [%.9g, %.9g, %.9g], ", name, v.x, v.y, v.z);
}

static void json_light(FILE *f, const object *o) {
    if (is_point(o)) {
        json_vector(f, "position", vector_of(o, "position"));
        json_vector(f, "intensity", color_of(o, "intensity"));
    } else if (is(o, "quad") && number_of(o, "width") == 0) {
        json_vector(f, "corner", vector_of(o, "corner"));
        json_vector(f, "u", vector_of(o, "u"));
        json_vector(f, "v", vector_of(o, "v"));
        json_vector(f, "radiance", color_of(o, "radiance"));
    } else
        die("only point lights and quads by a corner are exported");
}

static void write_ply(FILE *f, const mesh_desc *mesh, const instance *at) {
    fprintf(f,
            "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\n"
            "property float y\nproperty float z\n%selement face %zu\n"
            "property list uchar int vertex_indices\nend_header\n",
            mesh->positions_count,
            mesh->normals_count ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
            mesh_triangle_count(mesh));
    for (size_t i = 0; i < mesh->positions_count; i++) {
        dvec3 p, n;
        bool smooth = vertex_of(mesh, at, i, &p, &n);
        vec3 row[2] = {vec3_from(p), smooth ? vec3_from(n) : vec3_from(p)};
        fwrite(row, sizeof *row, smooth ? 2 : 1, f);
    }
    for (size_t i = 0; i < mesh->indices_count; i += 3) {
        putc(3, f);
        fwrite(&mesh->indices[i], sizeof *mesh->indices, 3, f);
    }
}

static FILE *create(const char *folder, const char *name) {
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        die("the folder's name is too long");
    FILE *f = fopen(path, "wb");
    if (f == NULL) die("a file cannot be written");
    return f;
}
static void finish(FILE *f) {
    if (ferror(f) | fclose(f)) die("a file cannot be written");
}

static void json_shape(FILE *f, const object *o, const instance *at, const char *folder,
                       int *meshes) {
    if (is(o, "mesh")) {
        char name[32];
        snprintf(name, sizeof name, "mesh-%d.ply", (*meshes)++);
        FILE *ply = create(folder, name);
        write_ply(ply, o->desc, at);
        finish(ply);
        fprintf(f, "\"mesh\": \"%s\", ", name);
    } else if (is(o, "sphere")) {
        json_vector(f, "center", vector_of(o, "center"));
        fprintf(f, "\"radius\": %.9g, ", number_of(o, "radius"));
    } else if (is(o, "plane")) {
        json_vector(f, "point", vector_of(o, "point"));
        json_vector(f, "normal", vector_of(o, "normal"));
    }
    fprintf(f, "\"material\": %u}", at->material);
}

static void write_json(FILE *f, const description *d, const char *folder) {
    view v = view_of(d);
    const object *camera = &d->objects[CATEGORY_CAMERA].items[0];
    const object *background = description_setting(d, "background");
    fprintf(f, "{\"width\": %d, \"height\": %d, \"depth\": %d, \"fov\": %.9g, ", v.width, v.height,
            v.depth, 2 * atan(v.half_height) * 180 / 3.14159265358979);
    json_vector(f, "from", v.from);
    json_vector(f, "at", vector_of(camera, "at"));
    json_vector(f, "up", vector_of(camera, "up"));
    json_vector(f, "background", background ? color_of(background, "color") : (dvec3){0, 0, 0});
    const char *between = "\"lights\": [\n{";
    for (size_t i = 0; i < d->objects[CATEGORY_LIGHT].count; i++, between = ",\n{") {
        fprintf(f, "%s", between);
        json_light(f, &d->objects[CATEGORY_LIGHT].items[i]);
        fprintf(f, "\"number\": %zu}", i);
    }
    between = "],\n\"materials\": [\n{";
    for (size_t i = 0; i < d->objects[CATEGORY_MATERIAL].count; i++, between = ",\n{") {
        look l = look_of(d, (uint32_t)i);
        fprintf(f, "%s", between);
        json_vector(f, "color", l.color);
        json_vector(f, "other", l.other);
        fprintf(f, "\"square\": %.9g, \"matte\": %.9g, \"mirror\": %.9g, \"ior\": %.9g}", l.square,
                l.matte, l.mirror, l.ior);
    }
    between = "],\n\"shapes\": [\n{";
    int meshes = 0;
    for (size_t i = 0; i < d->instance_count; i++, between = ",\n{") {
        fprintf(f, "%s", between);
        json_shape(f, drawn_shape(d, i), &d->instances[i], folder, &meshes);
    }
    fprintf(f, "]}\n");
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: export_scene SCENE.lua FOLDER\n");
        return 2;
    }
    snell_context *context;
    snell_scene *s;
    check(snell_context_create(NULL, &context));
    check(snell_scene_create(context, &s));
    check(snell_scene_load(s, argv[1], NULL));
    const description *d = s->description;
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    bool points = true; /* a scene of lamps with an area is for path tracers alone */
    for (size_t i = 0; i < lights->count; i++) points = points && is_point(&lights->items[i]);
    FILE *f = create(argv[2], "scene.json");
    write_json(f, d, argv[2]);
    finish(f);
    if (points) {
        write_pov(f = create(argv[2], "scene.pov"), d);
        finish(f);
    }
    if (points && tachyon_can(d)) {
        write_tachyon(f = create(argv[2], "scene.dat"), d);
        finish(f);
    }
    snell_scene_destroy(s);
    snell_context_destroy(context);
    return 0;
}
