/* One picture: scene, settings and seed decide every bit. Threads, instruction set, wave size, the
 * tree's leaves and the order of its children change nothing. The hashes are left in
 * TEST_BINARY_DIR/hashes.txt, where builds by several compilers can be compared. */
#include <dirent.h>
#include <string.h>

#include "api/api.h"
#include "render/render.h"
#include "render_test.h"

enum { WIDTH = 64, HEIGHT = 48 };

/* A sanitizer looks for other faults and is slow: it gets each scene once per number of threads. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = true };
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
enum { SANITIZED = true };
#else
enum { SANITIZED = false };
#endif
#else
enum { SANITIZED = false };
#endif

static FILE *hashes;

static int open_hashes(void **state) {
    (void)state;
    hashes = fopen(TEST_BINARY_DIR "/hashes.txt", "w");
    return hashes ? 0 : -1;
}

static int close_hashes(void **state) {
    (void)state;
    return fclose(hashes);
}

/* ---- a scene with everything that this version has ---- */

/* Turned about y by multiples of the angle of a 3-4-5 triangle: compilers and C libraries may differ
 * about sines, and the scene must not. */
static snell_transform turned(int turns, double sx, double sy, double sz, snell_vec3 to) {
    double c = 1, s = 0;
    for (int i = 0; i < turns; i++) {
        double next = 0.8 * c - 0.6 * s;
        s = 0.6 * c + 0.8 * s;
        c = next;
    }
    return (snell_transform){{{(float)(c * sx), 0, (float)(s * sz), to.x},
                              {0, (float)sy, 0, to.y},
                              {(float)(-s * sx), 0, (float)(c * sz), to.z}}};
}

/* Three numbers in a fixed order, which arguments of one call would not have. */
static snell_vec3 random_vec3(uint64_t *state) {
    double x = uniform(state), y = uniform(state), z = uniform(state);
    return v3(x, y, z);
}

static void put(rig *r, snell_shape_id shape, snell_material_id m, snell_transform at) {
    MUST(snell_scene_add_instance(r->scene, shape, m, &at, NULL));
}

/* A bumpy sheet with smooth normals, uv and colours. */
static snell_shape_id add_sheet(rig *r, const snell_material_id *materials) {
    enum { SIDE = 9, COUNT = SIDE * SIDE, CELLS = (SIDE - 1) * (SIDE - 1) };
    static snell_vec3 positions[COUNT], normals[COUNT], colors[COUNT];
    static snell_vec2 uvs[COUNT];
    static unsigned char alphas[COUNT];
    static uint32_t indices[CELLS * 6], slots[CELLS * 2];
    uint64_t random = 11;
    for (uint32_t i = 0; i < COUNT; i++) {
        double u = (i % SIDE) / (SIDE - 1.0), v = (i / SIDE) / (SIDE - 1.0);
        positions[i] = v3(u - 0.5, 0.1 * uniform(&random), v - 0.5);
        snell_vec3 slope = random_vec3(&random);
        normals[i] = v3(0.25 * (double)slope.x, 1, 0.25 * (double)slope.z);
        colors[i] = random_vec3(&random);
        uvs[i] = (snell_vec2){(float)u, (float)v};
        alphas[i] = (unsigned char)(i % 4 ? 255 : 128);
    }
    for (uint32_t i = 0; i < CELLS; i++) {
        uint32_t a = i / (SIDE - 1) * SIDE + i % (SIDE - 1);
        const uint32_t corners[6] = {a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1};
        memcpy(indices + (size_t)6 * i, corners, sizeof corners);
        slots[2 * i] = slots[2 * i + 1] = i % 3 == 0;
    }
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = positions;
    desc.normals = normals;
    desc.colors = colors;
    desc.uvs = uvs;
    desc.alphas = alphas;
    desc.positions_count = desc.normals_count = desc.colors_count = COUNT;
    desc.uvs_count = desc.alphas_count = COUNT;
    desc.indices = indices;
    desc.indices_count = CELLS * 6;
    desc.material_slots = slots;
    desc.material_slots_count = CELLS * 2;
    desc.materials = materials;
    desc.materials_count = 2;
    MUST(snell_scene_add_mesh(r->scene, &desc, &id));
    return id;
}

/* A curtain that waves: no two of its vertices go the same way. Its keys lie in and about the time that
 * the shutter is open. */
static snell_shape_id add_curtain(rig *r) {
    enum { SIDE = 7, COUNT = SIDE * SIDE, CELLS = (SIDE - 1) * (SIDE - 1), KEYS = 4 };
    static const float times[KEYS] = {-0.01f, 0.004f, 0.015f, 0.5f};
    static snell_vec3 positions[KEYS * COUNT], normals[KEYS * COUNT];
    static snell_vec2 uvs[COUNT];
    static uint32_t indices[CELLS * 6];
    uint64_t random = 23;
    for (uint32_t i = 0; i < KEYS * COUNT; i++) {
        double u = (i % COUNT % SIDE) / (SIDE - 1.0), v = (i % COUNT / SIDE) / (SIDE - 1.0);
        snell_vec3 by = random_vec3(&random), slope = random_vec3(&random);
        positions[i] = v3(1.4 * u + 0.2 * (double)by.x, 1.2 * v + 0.2 * (double)by.y,
                          0.5 * (double)by.z + 0.1 * (i / COUNT));
        normals[i] = v3(0.5 * (double)slope.x - 0.25, 0.5 * (double)slope.y - 0.25, 1);
        uvs[i % COUNT] = (snell_vec2){(float)u, (float)v};
    }
    for (uint32_t i = 0; i < CELLS; i++) {
        uint32_t a = i / (SIDE - 1) * SIDE + i % (SIDE - 1);
        const uint32_t corners[6] = {a, a + 1, a + SIDE, a + 1, a + SIDE + 1, a + SIDE};
        memcpy(indices + (size_t)6 * i, corners, sizeof corners);
    }
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_shape_id id;
    desc.positions = positions;
    desc.normals = normals;
    desc.positions_count = desc.normals_count = KEYS * COUNT;
    desc.uvs = uvs;
    desc.uvs_count = COUNT;
    desc.indices = indices;
    desc.indices_count = CELLS * 6;
    desc.key_times = times;
    desc.key_times_count = KEYS;
    MUST(snell_scene_add_mesh(r->scene, &desc, &id));
    return id;
}

/* An octahedron: closed, so that glass and the mirrored instances of it have an inside. */
static snell_shape_id add_gem(rig *r) {
    static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                     2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    const snell_vec3 corners[] = {v3(1, 0, 0),  v3(-1, 0, 0), v3(0, 1, 0),
                                  v3(0, -1, 0), v3(0, 0, 1),  v3(0, 0, -1)};
    return add_mesh(r, corners, 6, faces, 24);
}

static snell_input add_picture(rig *r, double scale) {
    unsigned char pixels[8 * 8 * 4];
    uint64_t random = 5;
    for (size_t i = 0; i < sizeof pixels; i++) pixels[i] = (unsigned char)(256 * uniform(&random));
    snell_image_texture_desc desc = SNELL_INIT(image_texture_desc);
    snell_input input = {grey(scale), {0, 0}};
    desc.width = desc.height = 8;
    desc.pixels = pixels;
    desc.pixels_count = sizeof pixels;
    desc.uv_scale = (snell_vec2){3, 2};
    desc.uv_rotation = 0.3f;
    MUST(snell_scene_add_image_texture(r->scene, &desc, &input.texture));
    return input;
}

/* Heights of noise, and colours that blend over the point in three projections. */
static snell_input add_bumps(rig *r) {
    snell_noise_texture_desc noise = SNELL_INIT(noise_texture_desc);
    snell_input input = {grey(0.1), {0, 0}};
    noise.size = 0.3f;
    noise.kind = 1;
    MUST(snell_scene_add_noise_texture(r->scene, &noise, &input.texture));
    return input;
}

static snell_input add_fade(rig *r) {
    snell_gradient_texture_desc fade = SNELL_INIT(gradient_texture_desc);
    snell_input input = {grey(1), {0, 0}};
    fade.color_a = v3(0.9, 0.5, 0.3);
    fade.map = 5; /* spherical */
    MUST(snell_scene_add_gradient_texture(r->scene, &fade, &input.texture));
    return input;
}

/* A block less a ball and a turned gem, with faces of three materials; and half of it again, in
 * glass. */
static void build_solids(rig *r, snell_shape_id gem, snell_material_id painted) {
    snell_box_desc box = SNELL_INIT(box_desc);
    snell_sphere_desc ball = SNELL_INIT(sphere_desc);
    snell_plane_desc plane = SNELL_INIT(plane_desc);
    snell_solid_desc desc = SNELL_INIT(solid_desc);
    snell_shape_id shapes[3] = {{0, 0}, {0, 0}, gem}, cut[2], half;
    const snell_transform places[3] = {turned(1, 1, 1, 1, v3(0, 0, 0)),
                                       turned(0, 1, -1.25, 1, v3(0.3, 0.4, 0.3)),
                                       turned(2, 0.3, 0.3, -0.5, v3(-0.2, 0, 0.4))};
    const snell_material_id materials[3] = {painted, {0, 0}, add_mirror(r, v3(0.9, 0.8, 0.7))};
    box.min = v3(-0.4, -0.4, -0.4);
    box.max = v3(0.4, 0.4, 0.4);
    ball.radius = 0.3f;
    plane.normal = v3(0.6, 0, 0.8);
    MUST(snell_scene_add_box(r->scene, &box, &shapes[0]));
    MUST(snell_scene_add_sphere(r->scene, &ball, &shapes[1]));
    MUST(snell_scene_add_plane(r->scene, &plane, &cut[1]));
    desc.operation = SNELL_SOLID_OPERATION_DIFFERENCE;
    desc.shapes = shapes;
    desc.transforms = places;
    desc.materials = materials;
    desc.shapes_count = desc.transforms_count = desc.materials_count = 3;
    MUST(snell_scene_add_solid(r->scene, &desc, &cut[0]));
    put(r, cut[0], add_lambert(r, v3(0.9, 0.6, 0.1)), turned(1, 1, 1, 1, v3(0.8, 0.5, 1.2)));
    desc = SNELL_INIT(solid_desc);
    desc.operation = SNELL_SOLID_OPERATION_INTERSECTION;
    desc.shapes = cut;
    desc.shapes_count = 2;
    MUST(snell_scene_add_solid(r->scene, &desc, &half));
    put(r, half, add_glass(r, 1.5, v3(0.3, 0.1, 0.1), 0), turned(3, 1, -1, 1, v3(-0.4, 1.7, 1)));
}

static void build_shapes(rig *r, snell_material_id shiny, snell_material_id painted) {
    snell_disk_desc disk = SNELL_INIT(disk_desc);
    snell_quad_desc quad = SNELL_INIT(quad_desc);
    snell_shape_id id;
    snell_material_id glass = add_glass(r, 1.5, v3(0.5, 0.1, 0.3), 1);
    snell_material_id water = add_glass(r, 1.333, v3(0.2, 0.1, 0), 0);
    disk.center = v3(-2.5, 1, -2);
    disk.normal = v3(1, 0.2, 1);
    disk.inner_radius = 0.3f;
    MUST(snell_scene_add_disk(r->scene, &disk, &id));
    place(r, id, add_mirror(r, v3(0.9, 0.8, 0.7)));
    quad.corner = v3(1, 0.5, 1.5);
    quad.u = v3(1, 0, 0.3);
    quad.v = v3(0, 1, 0);
    MUST(snell_scene_add_quad(r->scene, &quad, &id));
    place(r, id, add_card(r, v3(0.2, 0.8, 0.2), 0.4));
    place(r, id, add_card(r, v3(0.8, 0.2, 0.2), 0.3)); /* in the same place */
    add_sphere(r, v3(0, 0.8, 0), 0.8, glass);
    add_sphere(r, v3(0, 0.8, 0), 0.6, water); /* wholly in the glass: not there */
    add_box(r, v3(-2, 0, 0.5), v3(-1, 0.6, 1.3), water);
    add_box(r, v3(-1.2, -0.1, 0.6), v3(-0.8, 0.8, 1.2), glass);
    add_sphere(r, v3(1.8, 0.5, -1), 0.5, shiny);
    snell_shape_id curtain = add_curtain(r);
    put(r, curtain, painted, turned(1, 1, 1, 1, v3(-2.2, 0.5, 0.2)));
    put(r, curtain, glass, turned(3, 0.8, 1, -1, v3(1.8, 1, 0.4)));
    const snell_material_id both[2] = {painted, glass};
    snell_shape_id sheet = add_sheet(r, both), gem = add_gem(r);
    build_solids(r, gem, painted);
    for (int i = 0; i < 6; i++) {
        snell_vec3 at = v3(i - 2.5, 0.9 + 0.1 * i, -1.5 - 0.2 * i);
        put(r, sheet, painted, turned(i, i % 2 ? -1 : 1, 1, 1.5, at));
        put(r, gem, i % 3 ? shiny : glass,
            turned(i + 1, 0.3, i % 2 ? 0.4 : -0.4, 0.3, v3(i - 2.5, 2, -1)));
    }
}

static void build_everything(rig *r) {
    snell_checker_texture_desc checker = SNELL_INIT(checker_texture_desc);
    snell_lambert_desc floor = SNELL_INIT(lambert_desc), painted = SNELL_INIT(lambert_desc);
    snell_blinn_phong_desc phong = SNELL_INIT(blinn_phong_desc);
    snell_glazed_desc glazed = SNELL_INIT(glazed_desc);
    snell_partial_mirror_desc partial = SNELL_INIT(partial_mirror_desc);
    snell_headlight_light_desc head = SNELL_INIT(headlight_light_desc);
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    snell_material_id floor_id, paint_id, phong_id, glaze_id, partial_id;
    floor.color.value = grey(1);
    MUST(snell_scene_add_checker_texture(r->scene, &checker, &floor.color.texture));
    MUST(snell_scene_add_lambert(r->scene, &floor, &floor_id));
    painted.color = add_picture(r, 1);
    painted.alpha = add_picture(r, 1);
    painted.emission = flat(v3(0.02, 0, 0.05));
    painted.normal_map = add_picture(r, 1).texture;
    MUST(snell_scene_add_lambert(r->scene, &painted, &paint_id));
    phong.specular = add_picture(r, 0.5);
    MUST(snell_scene_add_blinn_phong(r->scene, &phong, &phong_id));
    glazed.base = phong_id;
    glazed.ior = 1.5f;
    glazed.bump = add_bumps(r);
    MUST(snell_scene_add_glazed(r->scene, &glazed, &glaze_id));
    partial.color = add_fade(r);
    MUST(snell_scene_add_partial_mirror(r->scene, &partial, &partial_id));
    add_plane(r, v3(0, 0, 0), v3(0, 1, 0), floor_id);
    add_plane(r, v3(0, 0, -6), v3(0, 0.1, 1), partial_id);
    build_shapes(r, glaze_id, paint_id);
    add_point(r, v3(3, 5, 3), v3(30, 25, 20));
    add_point(r, v3(0.1, 0.9, 0.1), v3(1, 2, 3)); /* in the glass */
    add_sun(r, v3(-1, -2, -0.5), v3(0.5, 0.6, 0.7));
    head.intensity = grey(2);
    MUST(snell_scene_add_headlight_light(r->scene, &head, NULL));
    MUST(snell_scene_set_ambient(r->scene, v3(0.05, 0.04, 0.03)));
    MUST(snell_scene_set_background_gradient(r->scene, v3(0.3, 0.2, 0.1), v3(0.2, 0.4, 0.9)));
    camera.from = v3(0.5, 2, 6);
    camera.at = v3(0, 0.8, 0);
    MUST(snell_scene_add_perspective_camera(r->scene, &camera, NULL));
}

/* The same, half of it in motion, turning and stretching, through a lens that moves too. */
static void set_in_motion(rig *r) {
    const description *d = r->scene->description;
    snell_motion_key keys[3];
    for (uint32_t i = 0; i < d->instance_count; i += 2) {
        for (int k = 0; k < 3; k++) {
            snell_vec3 to = v3(0.05 * k, 0.02 * k * k, -0.03 * k);
            snell_transform step = turned(k % 2, 1 + 0.1 * k, 1, 1, to);
            keys[k] = (snell_motion_key){0.01f * (float)k,
                                         transform_multiply(&step, &d->instances[i].to_world)};
        }
        MUST(snell_scene_set_instance_motion(r->scene, (snell_instance_id){i + 1, 0}, keys, 3));
    }
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    for (int k = 0; k < 2; k++)
        keys[k] = (snell_motion_key){0.02f * (float)k, turned(0, 1, 1, 1, v3(0.1 * k, 0, 0))};
    camera.from = v3(0.5, 2, 6);
    camera.at = v3(0, 0.8, 0);
    camera.lens_radius = 0.05f;
    camera.blades = 5;
    camera.motion = keys;
    camera.motion_count = 2;
    MUST(snell_scene_add_perspective_camera(r->scene, &camera, NULL));
}

/* Groups in groups: mirrored, sheared, some in one material, with glass. A scene of its own: groups
 * are slow to shade. */
static void build_groups(rig *r) {
    snell_shape_id gem = add_gem(r);
    snell_material_id painted = add_lambert(r, v3(0.7, 0.4, 0.2));
    snell_material_id glass = add_glass(r, 1.5, v3(0.5, 0.1, 0.3), 1);
    snell_instance_id parts[4];
    snell_shape_id group;
    parts[0] = place(r, gem, painted);
    parts[1] = add_sphere(r, v3(1.5, 0, 0), 0.6, (snell_material_id){0, 0});
    parts[3] = place(r, add_curtain(r), painted);
    parts[2] = add_box(r, v3(-0.4, -2, -0.4), v3(0.4, -1.1, 0.4), add_glow(r, v3(0.3, 0.2, 0.1)));
    MUST(snell_scene_add_group(r->scene, parts, 4, "gems", &group));
    for (int level = 0; level < 3; level++) {
        for (int i = 0; i < 2; i++) {
            snell_transform at = turned(i + level, i % 2 ? -0.5 : 0.45, 0.5, 0.4,
                                        v3(1.5 - i, 0.3 * level, 0.5 * i - 0.7));
            at.m[0][1] = 0.1f * (float)(i - level);
            MUST(snell_scene_add_instance(
                r->scene, group, level == 0 && i == 1 ? painted : (snell_material_id){0, 0}, &at,
                &parts[i]));
        }
        parts[2] = add_sphere(r, v3(0.6 * level, 0.5, 0), 0.2, level == 2 ? glass : painted);
        MUST(snell_scene_add_group(r->scene, parts, 3, NULL, &group));
    }
    put(r, group, (snell_material_id){0, 0}, turned(1, 1.5, 1.4, -1.6, v3(0, 1, 0.5)));
    put(r, group, add_mirror(r, v3(0.8, 0.8, 0.9)), turned(2, 1, 1, 1, v3(0.5, 0.5, -1.5)));
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    camera.from = v3(0.5, 2, 6);
    camera.at = v3(0, 0.8, 0);
    MUST(snell_scene_add_perspective_camera(r->scene, &camera, NULL));
}

/* ---- a scene that shines everywhere, for the integrators that draw lights ---- */

/* Thousands of triangles of one mesh, every one a light, some by a texture, some half there. */
static void build_swarm(rig *r) {
    enum { COUNT = 2000 };
    static snell_vec3 positions[3 * COUNT];
    static snell_vec2 uvs[3 * COUNT];
    static uint32_t indices[3 * COUNT];
    snell_lambert_desc shining = SNELL_INIT(lambert_desc);
    snell_mesh_desc desc = SNELL_INIT(mesh_desc);
    snell_material_id m;
    snell_shape_id id;
    uint64_t random = 17;
    for (uint32_t i = 0; i < 3 * COUNT; i++) {
        snell_vec3 by = random_vec3(&random), at = random_vec3(&random);
        snell_vec3 first = i % 3 ? positions[i - i % 3] : v3(0, 0, 0);
        positions[i] =
            i % 3 ? v3((double)first.x + 0.1 * (double)by.x, (double)first.y + 0.1 * (double)by.y,
                       (double)first.z + 0.1 * (double)by.z)
                  : v3(8 * (double)at.x - 4, 0.2 + 3 * (double)at.y, 8 * (double)at.z - 5);
        uvs[i] = (snell_vec2){by.x, by.y};
        indices[i] = i;
    }
    desc.positions = positions;
    desc.positions_count = desc.uvs_count = desc.indices_count = (size_t)(3 * COUNT);
    desc.uvs = uvs;
    desc.indices = indices;
    shining.emission = add_picture(r, 20);
    shining.alpha = add_picture(r, 1);
    shining.emit_two_sided = true;
    MUST(snell_scene_add_lambert(r->scene, &shining, &m));
    MUST(snell_scene_add_mesh(r->scene, &desc, &id));
    place(r, id, m);
    put(r, id, m, turned(1, -0.3, 0.2, 0.4, v3(0.2, 0.4, 0.3)));
}

/* Every type of light, near and far, seen and unseen. */
static void build_lights(rig *r) {
    snell_spot_light_desc spot = SNELL_INIT(spot_light_desc);
    snell_directional_light_desc sun = SNELL_INIT(directional_light_desc);
    snell_quad_light_desc quad = SNELL_INIT(quad_light_desc);
    snell_disk_light_desc disk = SNELL_INIT(disk_light_desc);
    snell_sphere_light_desc sphere = SNELL_INIT(sphere_light_desc);
    snell_environment_light_desc around = SNELL_INIT(environment_light_desc);
    snell_sky_light_desc sky = SNELL_INIT(sky_light_desc);
    spot.position = v3(-2, 3, 1);
    spot.at = v3(0, 0.5, 0);
    spot.intensity = v3(5, 6, 7);
    MUST(snell_scene_add_spot_light(r->scene, &spot, NULL));
    sun.direction = v3(0.3, -1, 0.2);
    sun.angle = 0.02f;
    MUST(snell_scene_add_directional_light(r->scene, &sun, NULL));
    quad.center = v3(1, 2.5, 1);
    quad.at = v3(0, 0, 0);
    quad.width = 0.7f;
    quad.visible = false;
    MUST(snell_scene_add_quad_light(r->scene, &quad, NULL));
    disk.center = v3(-1, 2.2, -1);
    disk.normal = v3(0.2, -1, 0.1);
    MUST(snell_scene_add_disk_light(r->scene, &disk, NULL));
    sphere.center = v3(0, 0.8, 0); /* in the glass */
    sphere.radius = 0.2f;
    MUST(snell_scene_add_sphere_light(r->scene, &sphere, NULL));
    around.radiance = add_picture(r, 1);
    around.rotate = 0.4f;
    MUST(snell_scene_add_environment_light(r->scene, &around, NULL));
    sky.sun = v3(0.4, 0.5, 0.3);
    sky.scale = 0.01f;
    MUST(snell_scene_add_sky_light(r->scene, &sky, NULL));
}

static bool add_all_lights; /* to the scene above */
static bool in_motion;
static bool of_groups;
static bool load_file; /* which scene is built: this file, or the one above */
static const char *scene_path;

static void build(rig *r) {
    if (load_file)
        MUST(snell_scene_load(r->scene, scene_path, NULL));
    else if (of_groups)
        build_groups(r);
    else
        build_everything(r);
    if (in_motion) set_in_motion(r);
    if (add_all_lights && !load_file) {
        build_lights(r);
        build_swarm(r);
    }
    const char *added;
    MUST(snell_scene_add_studio(r->scene, NULL, &added));
    MUST(snell_scene_commit(r->scene, NULL, NULL));
}

/* ---- the same picture, made otherwise ---- */

static snell_render_desc settings(rig *r, snell_integrator policy) {
    snell_render_desc desc;
    MUST(snell_scene_settings(r->scene, policy, &desc));
    desc.width = WIDTH;
    desc.height = HEIGHT;
    desc.samples = full_tests() ? 16 : 2;
    desc.max_depth = 7; /* so much glass would keep whitted busy for minutes */
    desc.min_weight = 0.002f;
    desc.pixel_center = false;
    desc.seed = 5;
    if (in_motion) {
        desc.camera = (snell_camera_id){2, 0};
        desc.filter = SNELL_FILTER_GAUSSIAN;
    }
    return desc;
}

static uint64_t render_hash(rig *r, const snell_render_desc *desc) {
    MUST(snell_render(r->scene, desc, r->film));
    assert_int_equal(stats_of(r).film_overflows, 0);
    return snell_film_hash(r->film);
}

static void same(uint64_t got, uint64_t expected, const char *how, unsigned long long value) {
    if (got == expected) return;
    fprintf(stderr, "%s: another picture with %s %llu\n", load_file ? scene_path : "everything",
            how, value);
    fail();
}

static uint64_t check_threads_and_waves(const char *name, snell_integrator policy) {
    static const uint32_t threads[] = {1, 2, 3, 8}, waves[] = {1, 7, 64, 4096};
    uint64_t expected = 0;
    for (size_t t = 0; t < 4; t++) {
        rig r = rig_make(threads[t], SNELL_ISA_AUTO);
        build(&r);
        snell_render_desc desc = settings(&r, policy);
        uint64_t hash = render_hash(&r, &desc);
        if (t == 0) {
            expected = hash;
            fprintf(hashes, "%s %d %016llx\n", name, (int)policy, (unsigned long long)hash);
        }
        same(hash, expected, "threads", threads[t]);
        for (size_t w = 0; w < 4 && t == 1 && !SANITIZED; w++) {
            desc.wave_size = waves[w];
            same(render_hash(&r, &desc), expected, "waves of", waves[w]);
        }
        rig_free(&r);
    }
    return expected;
}

static void check_isas(snell_integrator policy, uint64_t expected) {
    if (SANITIZED) return;
    for (snell_isa isa = SNELL_ISA_SCALAR; isa <= SNELL_ISA_AVX512; isa++) {
        rig r = rig_make(2, isa);
        if (snell_context_isa(r.context) != isa) {
            printf("NOT TESTED: %s, which this machine or build lacks\n", snell_isa_name(isa));
        } else {
            build(&r);
            snell_render_desc desc = settings(&r, policy);
            same(render_hash(&r, &desc), expected, "instruction set", isa);
        }
        rig_free(&r);
    }
}

/* Trees with other leaves and with children in a random order, by what snell_render does. */
static void check_trees(snell_integrator policy, uint64_t expected) {
    if (SANITIZED) return;
    static const accel_options trees[] = {
        {.leaf_size = 1}, {.leaf_size = 3, .seed = 1}, {.seed = 9}};
    for (size_t i = 0; i < sizeof trees / sizeof trees[0]; i++) {
        rig r = rig_make(2, SNELL_ISA_AUTO);
        build(&r);
        scene_options options = {.accel = trees[i]};
        scene *other;
        MUST(scene_freeze(r.scene->description, &options, r.context->pool, &other));
        scene_destroy(r.scene->frozen);
        r.scene->frozen = other;
        snell_render_desc desc = settings(&r, policy);
        same(render_hash(&r, &desc), expected, "tree", i);
        rig_free(&r);
    }
}

/* The crop lies across blocks, and ends within them. */
static void check_crop(snell_integrator policy) {
    rig r = rig_make(2, SNELL_ISA_AUTO);
    build(&r);
    snell_render_desc desc = settings(&r, policy);
    static float whole[WIDTH * HEIGHT * 3];
    render_hash(&r, &desc);
    memcpy(whole, snell_film_pixels(r.film, NULL, NULL, NULL), sizeof whole);
    desc.crop_x = 21;
    desc.crop_y = 13;
    desc.crop_width = 37;
    desc.crop_height = 30;
    render_hash(&r, &desc);
    uint32_t width, height;
    const float *part = snell_film_pixels(r.film, &width, &height, NULL);
    assert_int_equal(width, desc.crop_width);
    assert_int_equal(height, desc.crop_height);
    for (uint32_t y = 0; y < height; y++)
        assert_memory_equal(part + (size_t)y * width * 3,
                            whole + ((size_t)(y + desc.crop_y) * WIDTH + desc.crop_x) * 3,
                            width * 3 * sizeof(float));
    rig_free(&r);
}

static void check_seed_matters(void) {
    rig r = rig_make(2, SNELL_ISA_AUTO);
    build(&r);
    snell_render_desc desc = settings(&r, SNELL_WHITTED);
    uint64_t before = render_hash(&r, &desc);
    desc.seed++;
    assert_true(render_hash(&r, &desc) != before);
    snell_render_stats stats = stats_of(&r);
    assert_true(stats.rays_reflected && stats.rays_refracted && stats.rays_shadow &&
                stats.rays_continued);
    rig_free(&r);
}

static void everything_is_one_picture(void **state) {
    (void)state;
    load_file = false;
    for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_WHITTED; policy++) {
        uint64_t expected = check_threads_and_waves("everything", policy);
        check_isas(policy, expected);
        check_trees(policy, expected);
        check_crop(policy);
    }
    check_seed_matters();
}

static void everything_in_motion_is_one_picture(void **state) {
    (void)state;
    load_file = false;
    in_motion = true;
    uint64_t expected = check_threads_and_waves("everything in motion", SNELL_WHITTED);
    check_isas(SNELL_WHITTED, expected);
    check_trees(SNELL_WHITTED, expected);
    check_crop(SNELL_WHITTED);
    in_motion = false;
}

static void groups_are_one_picture(void **state) {
    (void)state;
    load_file = false;
    of_groups = true;
    uint64_t still = 0;
    for (int moving = 0; moving < 2; moving++) {
        in_motion = moving;
        uint64_t expected =
            check_threads_and_waves(moving ? "groups in motion" : "groups", SNELL_WHITTED);
        check_isas(SNELL_WHITTED, expected);
        check_trees(SNELL_WHITTED, expected);
        assert_true(expected != still);
        still = expected;
    }
    of_groups = in_motion = false;
}

static void all_light_is_one_picture(void **state) {
    (void)state;
    load_file = false;
    add_all_lights = true;
    for (snell_integrator policy = SNELL_APPEL; policy <= SNELL_PATH; policy++) {
        if (policy < SNELL_COOK && !full_tests()) continue;
        uint64_t expected = check_threads_and_waves("all light", policy);
        check_isas(policy, expected);
        check_trees(policy, expected);
        check_crop(policy);
    }
    add_all_lights = false;
}

static int is_scene(const struct dirent *entry) {
    size_t length = strlen(entry->d_name);
    return length > 4 && strcmp(entry->d_name + length - 4, ".lua") == 0;
}

/* What is shown is also proven. */
static void every_showcase_is_one_picture(void **state) {
    (void)state;
    struct dirent **entries;
    int count = scandir(TEST_SOURCE_DIR "/scenes", &entries, is_scene, alphasort);
    assert_true(count > 0);
    load_file = true;
    for (int i = 0; i < count; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/scenes/%s", TEST_SOURCE_DIR, entries[i]->d_name);
        scene_path = path;
        uint64_t expected = check_threads_and_waves(entries[i]->d_name, SNELL_WHITTED);
        check_isas(SNELL_WHITTED, expected);
        check_trees(SNELL_WHITTED, expected);
        free(entries[i]);
    }
    free(entries);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_one_picture),
        cmocka_unit_test(everything_in_motion_is_one_picture),
        cmocka_unit_test(groups_are_one_picture),
        cmocka_unit_test(all_light_is_one_picture),
        cmocka_unit_test(every_showcase_is_one_picture),
    };
    return cmocka_run_group_tests(tests, open_hashes, close_hashes);
}
