/* Writes a model as it would be lit by default, for POV-Ray and Tachyon, so that they can make a like picture: the same
 * triangles, smooth normals, camera, lights and size; every material one grey, no textures.
 *
 *     export_peers MODEL OUT.pov OUT.dat OUT_AA.dat */
#include <stdio.h>
#include <stdlib.h>

#include "api/api.h"
#include "geometry/mesh.h"

enum { WIDTH = 800, HEIGHT = 600 };

static void check(snell_status status) {
    if (status == SNELL_OK) return;
    fprintf(stderr, "export_peers: %s\n", snell_last_error()->text);
    exit(1);
}

typedef struct corner {
    dvec3 p, n;
} corner;

static void read_triangle(const mesh_desc *mesh, const instance *at, const transform *inverse,
                          size_t triangle, corner out[3]) {
    for (int i = 0; i < 3; i++) {
        uint32_t v = mesh->indices[3 * triangle + (size_t)i];
        out[i].p = transform_point(&at->to_world, dvec3_from(mesh->positions[v]));
    }
    dvec3 flat = dvec3_cross(dvec3_sub(out[1].p, out[0].p), dvec3_sub(out[2].p, out[0].p));
    for (int i = 0; i < 3; i++) {
        uint32_t v = mesh->indices[3 * triangle + (size_t)i];
        dvec3 n = flat;
        if (mesh->normals_count) n = transform_normal(inverse, dvec3_from(mesh->normals[v]));
        out[i].n = dvec3_normalize(n);
    }
}

typedef void triangle_fn(FILE *file, const corner c[3]);

static void each_triangle(const description *d, FILE *file, triangle_fn *write) {
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *at = &d->instances[i];
        const object *shape = &d->objects[CATEGORY_SHAPE].items[at->shape];
        transform inverse;
        if (((const primitive_type *)shape->type)->intersect != NULL ||
            !transform_inverse(&at->to_world, &inverse))
            continue;
        const mesh_desc *mesh = shape->desc;
        for (size_t t = 0; t < mesh_triangle_count(mesh); t++) {
            corner c[3];
            read_triangle(mesh, at, &inverse, t, c);
            write(file, c);
        }
    }
}

static void pov_triangle(FILE *f, const corner c[3]) {
    fprintf(f, "smooth_triangle{");
    for (int i = 0; i < 3; i++)
        fprintf(f, "%s<%.7g,%.7g,%.7g>,<%.5g,%.5g,%.5g>", i ? "," : "", c[i].p.x, c[i].p.y,
                c[i].p.z, c[i].n.x, c[i].n.y, c[i].n.z);
    fprintf(f, "}\n");
}

/* Tachyon is left-handed: x is mirrored, and corners change their order, or all would be seen from
 * behind. */
static void tachyon_triangle(FILE *f, const corner c[3]) {
    fprintf(f, "STRI");
    for (int i = 0; i < 3; i++) {
        dvec3 p = c[2 - i].p;
        fprintf(f, " V%d %.7g %.7g %.7g", i, -p.x, p.y, p.z);
    }
    for (int i = 0; i < 3; i++) {
        dvec3 n = c[2 - i].n;
        fprintf(f, " N%d %.5g %.5g %.5g", i, -n.x, n.y, n.z);
    }
    fprintf(f, " T\n");
}

typedef struct light_values {
    vec3 direction;
    double irradiance;
} light_values;

/* The rig's two directional lights; the shadowless fill is ambient light in the peers. */
static int read_lights(const description *d, light_values out[2]) {
    int count = 0;
    const object_list *lights = &d->objects[CATEGORY_LIGHT];
    for (size_t i = 0; i < lights->count && count < 2; i++) {
        light_sample sample;
        const light_type *type = (const light_type *)lights->items[i].type;
        const light l = {.type = type, .desc = lights->items[i].desc};
        const dvec3 origin = {0, 0, 0};
        if (type->casts_shadow && type->sample && !type->prepare &&
            type->sample(&l, origin, origin, (sample2){0.5, 0.5}, &sample) && sample.infinite)
            out[count++] = (light_values){vec3_from(dvec3_negate(sample.to_light)), sample.light.x};
    }
    return count;
}

static void write_pov(const char *path, const description *d, const perspective_desc *c,
                      const light_values *lights, int count) {
    FILE *f = fopen(path, "w");
    if (f == NULL) exit(1);
    double aspect = (double)WIDTH / HEIGHT, half = tan((double)c->fov / 2);
    fprintf(f, "#version 3.7;\nglobal_settings{assumed_gamma 1.0 max_trace_level "
               "10}\n#default{finish{ambient .2 diffuse .8}}\n");
    fprintf(f,
            "camera{perspective location <%g,%g,%g> right -x*%g up y sky <%g,%g,%g> angle %g "
            "look_at <%g,%g,%g>}\n",
            (double)c->from.x, (double)c->from.y, (double)c->from.z, aspect, (double)c->up.x,
            (double)c->up.y, (double)c->up.z, 2 * atan(half * aspect) * 180 / 3.14159265358979,
            (double)c->at.x, (double)c->at.y, (double)c->at.z);
    fprintf(f, "background{color rgb .4}\n");
    for (int i = 0; i < count; i++) {
        vec3 v = lights[i].direction;
        double far = -1e5;
        fprintf(f, "light_source{<%g,%g,%g> color rgb %g parallel point_at <0,0,0>}\n",
                (double)v.x * far, (double)v.y * far, (double)v.z * far,
                lights[i].irradiance / 3.14159);
    }
    fprintf(f, "mesh{\n");
    each_triangle(d, f, pov_triangle);
    fprintf(f, "texture{pigment{color rgb .8}}}\n");
    if (fclose(f)) exit(1);
}

static void write_tachyon(const char *path, const description *d, const perspective_desc *c,
                          const light_values *lights, int count, int extra_samples) {
    FILE *f = fopen(path, "w");
    if (f == NULL) exit(1);
    dvec3 forward = dvec3_normalize(dvec3_sub(dvec3_from(c->at), dvec3_from(c->from)));
    dvec3 right = dvec3_normalize(dvec3_cross(forward, dvec3_from(c->up))),
          up = dvec3_cross(right, forward);
    fprintf(f,
            "BEGIN_SCENE\nRESOLUTION %d %d\nCAMERA PROJECTION PERSPECTIVE ZOOM %.6f ASPECTRATIO "
            "1.0 ANTIALIASING %d RAYDEPTH 10\n",
            WIDTH, HEIGHT, 0.5 / tan((double)c->fov / 2), extra_samples);
    fprintf(f,
            "CENTER %g %g %g\nVIEWDIR %g %g %g\nUPDIR %g %g %g\nEND_CAMERA\nBACKGROUND .4 .4 .4\n",
            (double)-c->from.x, (double)c->from.y, (double)c->from.z, -forward.x, forward.y,
            forward.z, -up.x, up.y, up.z);
    for (int i = 0; i < count; i++) {
        vec3 v = lights[i].direction;
        double e = lights[i].irradiance / 3.14159;
        fprintf(f, "DIRECTIONAL_LIGHT DIRECTION %g %g %g COLOR %g %g %g\n", (double)-v.x,
                (double)v.y, (double)v.z, e, e, e);
    }
    fprintf(f, "TEXDEF T AMBIENT 0.2 DIFFUSE 0.8 SPECULAR 0 OPACITY 1 COLOR .8 .8 .8 TEXFUNC 0\n");
    each_triangle(d, f, tachyon_triangle);
    fprintf(f, "END_SCENE\n");
    if (fclose(f)) exit(1);
}

int main(int argc, char **argv) {
    if (argc != 5) {
        fprintf(stderr, "usage: export_peers MODEL OUT.pov OUT.dat OUT_AA.dat\n");
        return 2;
    }
    snell_context *context;
    snell_scene *s;
    check(snell_context_create(NULL, &context));
    check(snell_scene_create(context, &s));
    check(snell_scene_load(s, argv[1], NULL));
    check(snell_scene_add_studio(s, NULL, NULL));
    const description *d = s->description;
    const perspective_desc *camera = d->objects[CATEGORY_CAMERA].items[0].desc;
    light_values lights[2];
    int count = read_lights(d, lights);
    write_pov(argv[2], d, camera, lights, count);
    write_tachyon(argv[3], d, camera, lights, count, 0);
    write_tachyon(argv[4], d, camera, lights, count, 15);
    snell_scene_destroy(s);
    snell_context_destroy(context);
    return 0;
}
