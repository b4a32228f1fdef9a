/* From a record of tests/reference/cases.json to a scene. */
#ifndef SNELL_TESTS_REFERENCE_SCENE_H
#define SNELL_TESTS_REFERENCE_SCENE_H

#include "reference.h"
#include "render_test.h"

static const double PI_ = 3.14159265358979323846;

static inline json_t *get(const json_t *object, const char *name) {
    return json_object_get(object, name);
}
static inline double number(const json_t *object, const char *name) {
    return json_number_value(get(object, name));
}
static inline bool is(const json_t *object, const char *name, const char *word) {
    const char *found = json_string_value(get(object, name));
    return found && strcmp(found, word) == 0;
}

/* A colour may be one number. */
static inline snell_vec3 color_of(const json_t *value) {
    if (!json_is_array(value)) return grey(json_number_value(value));
    return v3(reference_number(value, 0), reference_number(value, 1), reference_number(value, 2));
}

static inline snell_material_id add_material(rig *r, const json_t *m) {
    if (is(m, "type", "lambert")) return add_lambert(r, color_of(get(m, "R")));
    assert_true(is(m, "type", "glazed"));
    snell_glazed_desc desc = SNELL_INIT(glazed_desc);
    snell_material_id id;
    desc.base = add_lambert(r, grey(0)); /* its k_a is 1: it shows the ambient light */
    desc.reflectance = flat(grey(number(m, "mirror")));
    MUST(snell_scene_set_ambient(r->scene, grey(number(m, "added_radiance"))));
    MUST(snell_scene_add_glazed(r->scene, &desc, &id));
    return id;
}

static inline void add_triangle(rig *r, const json_t *verts, snell_material_id m) {
    static const uint32_t corners[3] = {0, 1, 2};
    snell_vec3 positions[3];
    for (size_t i = 0; i < 3; i++) positions[i] = color_of(json_array_get(verts, i));
    place(r, add_mesh(r, positions, 3, corners, 3), m);
}

/* false: this version has no such shape. */
static inline bool add_shape(rig *r, const json_t *shape, snell_material_id m) {
    if (is(shape, "type", "plane"))
        add_plane(r, color_of(get(shape, "point")), color_of(get(shape, "normal")), m);
    else if (is(shape, "type", "sphere"))
        add_sphere(r, color_of(get(shape, "center")), number(shape, "radius"), m);
    else if (is(shape, "type", "box"))
        add_box(r, color_of(get(shape, "min")), color_of(get(shape, "max")), m);
    else if (is(shape, "type", "triangle"))
        add_triangle(r, get(shape, "verts"), m);
    else
        return false;
    return true;
}

static inline void add_lights(rig *r, const json_t *lights) {
    size_t index;
    json_t *l;
    json_array_foreach(lights, index, l) {
        if (is(l, "type", "point"))
            add_point(r, color_of(get(l, "position")), color_of(get(l, "intensity")));
        else
            add_sun(r, color_of(get(l, "direction")), color_of(get(l, "irradiance_normal")));
    }
}

/* Geometry whose materials stand in the record, lights, ambient. */
static inline void build(rig *r, const json_t *scene) {
    size_t index;
    json_t *shape;
    json_array_foreach(get(scene, "geometry"), index, shape) {
        const char *name = json_string_value(get(shape, "material"));
        const json_t *m = get(get(scene, "materials"), name);
        assert_true(add_shape(r, shape, m ? add_material(r, m) : add_mirror(r, grey(1))));
    }
    add_lights(r, get(scene, "lights"));
    if (get(scene, "ambient"))
        MUST(snell_scene_set_ambient(r->scene,
                                     color_of(get(get(scene, "ambient"), "added_radiance"))));
    MUST(snell_scene_commit(r->scene, NULL, NULL));
}

/* A slab is a box so wide that no ray meets its sides, between two glowing planes: the eye's side,
 * beyond z = high, and the far one. */
static inline void build_slab(rig *r, const json_t *slab, snell_vec3 absorption, double front,
                              double back) {
    const json_t *z = get(slab, "z");
    add_box(r, v3(-1e4, -1e4, reference_number(z, 0)), v3(1e4, 1e4, reference_number(z, 1)),
            add_glass(r, number(slab, "ior"), absorption, 0));
    add_plane(r, v3(0, 0, 64), v3(0, 0, -1), add_glow(r, grey(front)));
    add_plane(r, v3(0, 0, -64), v3(0, 0, 1), add_glow(r, grey(back)));
    MUST(snell_scene_commit(r->scene, NULL, NULL));
}

static inline snell_vec3 slab_hit(const json_t *slab) {
    return v3(0, 0, reference_number(get(slab, "z"), 1));
}
static inline snell_vec3 slab_eye(const json_t *slab, double degrees) {
    double angle = degrees * PI_ / 180;
    return v3(-4 * sin(angle), 0, (double)slab_hit(slab).z + 4 * cos(angle));
}

/* A glass ball in the sky of the record. */
static inline void build_sphere_tree(rig *r, const json_t *scene) {
    const json_t *sphere = json_array_get(get(scene, "geometry"), 0);
    snell_material_id glass =
        add_glass(r, number(sphere, "ior"), grey(number(sphere, "sigma_a")), 0);
    assert_true(add_shape(r, sphere, glass));
    if (is(scene, "environment", "0.5(1+w.y)")) {
        MUST(snell_scene_set_background_gradient(r->scene, grey(0), grey(1)));
    } else { /* 1 where w.x < 0, else 0.25 */
        assert_true(is(scene, "environment", "1 if w.x<0 else 0.25"));
        add_plane(r, v3(-99, 0, 0), v3(1, 0, 0), add_glow(r, grey(1)));
        add_plane(r, v3(99, 0, 0), v3(-1, 0, 0), add_glow(r, grey(0.25)));
    }
    MUST(snell_scene_commit(r->scene, NULL, NULL));
}

/* The point on the record's ray that is so many of its directions from its origin. */
static inline snell_vec3 along_record(const json_t *ray, double distance) {
    const json_t *o = get(ray, "o"), *d = get(ray, "d");
    return v3(reference_number(o, 0) + distance * reference_number(d, 0),
              reference_number(o, 1) + distance * reference_number(d, 1),
              reference_number(o, 2) + distance * reference_number(d, 2));
}

#endif
