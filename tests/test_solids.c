/* Solids: what rays meet of random unions, intersections and differences is held against asking, point
 * by point, whether it is inside; faces that coincide; limits and what cannot be. */
#include <string.h>

#include "accel/solid_mesh.h"
#include "api/api.h"
#include "cpu_time.h"
#include "integrators/media.h"
#include "render_test.h"
#include "scene/records.h"

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

static uint64_t state;
static double uniform01(void) { /* splitmix64 */
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}
static double within(double low, double high) { return low + (high - low) * uniform01(); }
static uint32_t below(uint32_t n) { return (uint32_t)(uniform01() * n); }

static dvec3 direction(void) {
    for (;;) {
        dvec3 d = {within(-1, 1), within(-1, 1), within(-1, 1)};
        double length = dvec3_length(d);
        if (length < 1 && length > 0.1) return dvec3_scale(d, 1 / length);
    }
}

static bool full(void) {
    const char *said = getenv("SNELL_FULL");
    return said && said[0] && strcmp(said, "0") != 0;
}

/* ---- transforms ---- */

static snell_transform shifted(double x, double y, double z) {
    return (snell_transform){{{1, 0, 0, (float)x}, {0, 1, 0, (float)y}, {0, 0, 1, (float)z}}};
}

static snell_transform rotation(void) {
    dvec3 n = direction(), t, b;
    dvec3_frame(n, &t, &b);
    return (snell_transform){{{(float)t.x, (float)b.x, (float)n.x, 0},
                              {(float)t.y, (float)b.y, (float)n.y, 0},
                              {(float)t.z, (float)b.z, (float)n.z, 0}}};
}

/* Turned, stretched, sheared, half of them mirrored. */
static snell_transform any_transform(double shift) {
    snell_transform turn = rotation(), skew = transform_identity();
    for (int i = 0; i < 3; i++) skew.m[i][i] = (float)(within(0.6, 1.5) * (below(4) ? 1 : -1));
    skew.m[0][1] = (float)within(-0.4, 0.4);
    skew.m[1][2] = (float)within(-0.4, 0.4);
    snell_transform moved =
        shifted(within(-shift, shift), within(-shift, shift), within(-shift, shift));
    turn = transform_multiply(&turn, &skew);
    return transform_multiply(&moved, &turn);
}

/* ---- solids, once for snell and once for asking points ---- */

typedef enum kind {
    SPHERE,
    BOX,
    CYLINDER,
    CONE,
    TORUS,
    PLANE,
    CAPSULE,
    ELLIPSOID,
    BALL_MESH,  /* an icosphere */
    ANGLE_MESH, /* an L, not convex */
    KIND_COUNT,
    WHOLE
} kind;

enum { CHILDREN_MAX = 4, TREE_MAX = 128 };

typedef struct tree {
    kind kind;
    int operation;
    uint32_t material; /* index of a leaf's own */
    snell_transform to_parent;
    double back[3][4]; /* its inverse */
    int child_count;
    struct tree *children[CHILDREN_MAX];
    snell_shape_id shape;
} tree;

static tree trees[TREE_MAX];
static int tree_count;
static snell_material_id leaf_materials[TREE_MAX];

static void invert(const snell_transform *m, double out[3][4]) {
    double a[3][4];
    for (int i = 0; i < 12; i++) a[i / 4][i % 4] = (double)m->m[i / 4][i % 4];
    double det = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
                 a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
                 a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int r0 = (j + 1) % 3, r1 = (j + 2) % 3, c0 = (i + 1) % 3, c1 = (i + 2) % 3;
            out[i][j] = (a[r0][c0] * a[r1][c1] - a[r0][c1] * a[r1][c0]) / det;
        }
    for (int i = 0; i < 3; i++)
        out[i][3] = -(out[i][0] * a[0][3] + out[i][1] * a[1][3] + out[i][2] * a[2][3]);
}

static dvec3 moved_back(const tree *t, dvec3 p) {
    const double(*m)[4] = t->back;
    return (dvec3){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                   m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                   m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]};
}

static snell_vec3 ball_positions[642];
static uint32_t ball_indices[1280 * 3];
static size_t ball_vertex_count, ball_index_count;

static bool in_ball(dvec3 p) { /* convex: behind every face */
    for (size_t i = 0; i < ball_index_count; i += 3) {
        dvec3 a = dvec3_from(ball_positions[ball_indices[i]]),
              b = dvec3_from(ball_positions[ball_indices[i + 1]]),
              c = dvec3_from(ball_positions[ball_indices[i + 2]]);
        dvec3 n = dvec3_cross(dvec3_sub(b, a), dvec3_sub(c, a));
        if (dvec3_dot(n, dvec3_sub(p, a)) >= 0) return false;
    }
    return true;
}

static bool leaf_contains(kind k, dvec3 p) {
    double ring = sqrt(p.x * p.x + p.z * p.z);
    switch (k) {
    case SPHERE: return dvec3_dot(p, p) < 1;
    case BOX: return fabs(p.x) < 0.75 && fabs(p.y) < 0.5 && fabs(p.z) < 1;
    case CYLINDER: return fabs(p.y) < 0.75 && ring < 0.5;
    case CONE: return p.y > -0.5 && p.y < 1 && ring < 0.5 * (1 - p.y);
    case TORUS: return (ring - 0.75) * (ring - 0.75) + p.y * p.y < 0.0625;
    case PLANE: return p.y < 0.25;
    case CAPSULE: {
        double over = fabs(p.y) - 0.5;
        return ring * ring + (over > 0 ? over * over : 0) < (double)0.45f * (double)0.45f;
    }
    case ELLIPSOID: return p.x * p.x / 0.25 + p.y * p.y + p.z * p.z / 0.5625 < 1;
    case BALL_MESH: return in_ball(p);
    case ANGLE_MESH:
        return p.z > -0.5 && p.z < 0.5 && p.x > -1 && p.y > -1 && p.x < 1 && p.y < 1 &&
               (p.x < 0 || p.y < 0);
    default: return false;
    }
}

/* p in the space of the parent. */
static bool contains(const tree *t, dvec3 p) {
    p = moved_back(t, p);
    if (t->kind != WHOLE) return leaf_contains(t->kind, p);
    for (int i = 0; i < t->child_count; i++) {
        bool in = contains(t->children[i], p);
        if (t->operation == SNELL_SOLID_OPERATION_UNION && in) return true;
        if (t->operation == SNELL_SOLID_OPERATION_INTERSECTION && !in) return false;
        if (t->operation == SNELL_SOLID_OPERATION_DIFFERENCE && in != (i == 0)) return false;
    }
    return t->operation != SNELL_SOLID_OPERATION_UNION;
}

/* Is p on one side of the leaf's surface, and q on the other? In the space of t's parent. */
static bool leaf_parts(const tree *t, uint32_t own, dvec3 p, dvec3 q) {
    p = moved_back(t, p);
    q = moved_back(t, q);
    if (t->kind != WHOLE)
        return t->material == own && leaf_contains(t->kind, p) != leaf_contains(t->kind, q);
    for (int i = 0; i < t->child_count; i++)
        if (leaf_parts(t->children[i], own, p, q)) return true;
    return false;
}

/* An octahedron, each triangle in four, on the sphere, three times. */
static uint32_t ball_middle(uint32_t a, uint32_t b) {
    dvec3 p =
        dvec3_normalize(dvec3_add(dvec3_from(ball_positions[a]), dvec3_from(ball_positions[b])));
    snell_vec3 v = v3(p.x, p.y, p.z);
    for (size_t i = 0; i < ball_vertex_count; i++)
        if (memcmp(&ball_positions[i], &v, sizeof v) == 0) return (uint32_t)i;
    ball_positions[ball_vertex_count] = v;
    return (uint32_t)ball_vertex_count++;
}

static void make_ball(void) {
    static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                     2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    static const snell_vec3 corners[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                         {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    memcpy(ball_positions, corners, sizeof corners);
    memcpy(ball_indices, faces, sizeof faces);
    ball_vertex_count = 6;
    ball_index_count = COUNT_OF(faces);
    for (int level = 0; level < 3; level++) {
        uint32_t finer[COUNT_OF(ball_indices)];
        size_t count = 0;
        for (size_t i = 0; i < ball_index_count; i += 3) {
            uint32_t a = ball_indices[i], b = ball_indices[i + 1], c = ball_indices[i + 2];
            uint32_t ab = ball_middle(a, b), bc = ball_middle(b, c), ca = ball_middle(c, a);
            const uint32_t four[] = {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca};
            memcpy(finer + count, four, sizeof four);
            count += 12;
        }
        memcpy(ball_indices, finer, count * sizeof *finer);
        ball_index_count = count;
    }
}

/* The L of ANGLE_MESH; inside out: wound the wrong way; mixed: half of it is. Every triangle has its
 * own vertices. */
static snell_shape_id add_angle(rig *r, bool inside_out, bool mixed) {
    static const float outline[6][2] = {{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}};
    static const uint32_t cap[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5};
    snell_vec3 corners[12], positions[60];
    uint32_t faces[60], indices[60];
    size_t count = 0;
    for (uint32_t i = 0; i < 12; i++)
        corners[i] = v3((double)outline[i % 6][0], (double)outline[i % 6][1], i < 6 ? -0.5 : 0.5);
    for (size_t i = 0; i < 12; i += 3) {
        const uint32_t two[] = {cap[i],     cap[i + 2],     cap[i + 1],
                                cap[i] + 6, cap[i + 1] + 6, cap[i + 2] + 6};
        memcpy(faces + count, two, sizeof two);
        count += 6;
    }
    for (uint32_t i = 0; i < 6; i++) {
        uint32_t k = (i + 1) % 6;
        const uint32_t two[] = {i, k, k + 6, i, k + 6, i + 6};
        memcpy(faces + count, two, sizeof two);
        count += 6;
    }
    for (uint32_t i = 0; i < count; i++) {
        bool turned = mixed ? i / 3 % 2 : inside_out;
        positions[i] = corners[faces[turned ? i / 3 * 3 + 2 - i % 3 : i]];
        indices[i] = i;
    }
    return add_mesh(r, positions, count, indices, count);
}

static snell_shape_id add_leaf(rig *r, kind k) {
    snell_sphere_desc sphere = SNELL_INIT(sphere_desc);
    snell_box_desc box = SNELL_INIT(box_desc);
    snell_cylinder_desc cylinder = SNELL_INIT(cylinder_desc);
    snell_cone_desc cone = SNELL_INIT(cone_desc);
    snell_torus_desc torus = SNELL_INIT(torus_desc);
    snell_plane_desc plane = SNELL_INIT(plane_desc);
    snell_capsule_desc capsule = SNELL_INIT(capsule_desc);
    snell_ellipsoid_desc ellipsoid = SNELL_INIT(ellipsoid_desc);
    snell_shape_id id = {0, 0};
    switch (k) {
    case SPHERE: MUST(snell_scene_add_sphere(r->scene, &sphere, &id)); break;
    case BOX:
        box.min = v3(-0.75, -0.5, -1);
        box.max = v3(0.75, 0.5, 1);
        MUST(snell_scene_add_box(r->scene, &box, &id));
        break;
    case CYLINDER:
        cylinder.from = v3(0, -0.75, 0);
        cylinder.to = v3(0, 0.75, 0);
        cylinder.radius = 0.5f;
        MUST(snell_scene_add_cylinder(r->scene, &cylinder, &id));
        break;
    case CONE:
        cone.from = v3(0, -0.5, 0);
        cone.to = v3(0, 1, 0);
        cone.radius = 0.75f;
        MUST(snell_scene_add_cone(r->scene, &cone, &id));
        break;
    case TORUS:
        torus.major = 0.75f;
        torus.minor = 0.25f;
        MUST(snell_scene_add_torus(r->scene, &torus, &id));
        break;
    case PLANE:
        plane.point = v3(0, 0.25, 0);
        MUST(snell_scene_add_plane(r->scene, &plane, &id));
        break;
    case CAPSULE:
        capsule.from = v3(0, -0.5, 0);
        capsule.to = v3(0, 0.5, 0);
        capsule.radius = 0.45f; /* not the cylinder's: where they part slowly, slivers are real */
        MUST(snell_scene_add_capsule(r->scene, &capsule, &id));
        break;
    case ELLIPSOID:
        ellipsoid.radii = v3(0.5, 1, 0.75);
        MUST(snell_scene_add_ellipsoid(r->scene, &ellipsoid, &id));
        break;
    case BALL_MESH:
        id = add_mesh(r, ball_positions, ball_vertex_count, ball_indices, ball_index_count);
        break;
    case ANGLE_MESH: id = add_angle(r, below(3) == 0, below(3) == 0); break;
    default: fail();
    }
    return id;
}

static tree *new_tree(void) {
    assert_true(tree_count < TREE_MAX);
    tree *t = &trees[tree_count];
    *t = (tree){.material = (uint32_t)tree_count++};
    return t;
}

static tree *make_tree(rig *r, int depth, bool placed) {
    tree *t = new_tree();
    t->to_parent = placed ? any_transform(0.6) : transform_identity();
    invert(&t->to_parent, t->back);
    if (depth == 0 || (depth < 3 && below(3) == 0)) {
        t->kind = (kind)below(KIND_COUNT);
        t->shape = add_leaf(r, t->kind);
        return t;
    }
    t->kind = WHOLE;
    t->operation = (int)below(3);
    t->child_count = 1 + (int)below(CHILDREN_MAX);
    snell_solid_desc desc = SNELL_INIT(solid_desc);
    snell_shape_id shapes[CHILDREN_MAX];
    snell_transform transforms[CHILDREN_MAX];
    snell_material_id materials[CHILDREN_MAX];
    for (int i = 0; i < t->child_count; i++) {
        tree *child = t->children[i] = make_tree(r, depth - 1, below(4) != 0);
        shapes[i] = child->shape;
        transforms[i] = child->to_parent;
        materials[i] =
            child->kind == WHOLE ? (snell_material_id){0, 0} : leaf_materials[child->material];
    }
    desc.operation = t->operation;
    desc.shapes = shapes;
    desc.transforms = transforms;
    desc.materials = materials;
    desc.shapes_count = desc.transforms_count = desc.materials_count = (size_t)t->child_count;
    MUST(snell_scene_add_solid(r->scene, &desc, &t->shape));
    return t;
}

/* ---- rays against points ---- */

typedef struct tally {
    long rays, hits, points, faces, spawned;
    long edge_faces; /* hits so near an edge that no step across it tells the sides apart */
} tally;

enum { HITS_MAX = 512 };

static dvec3 along(const ray *r, double t) {
    return dvec3_add(dvec3_from(r->o), dvec3_scale(dvec3_from(r->d), t));
}

/* All hits in turn, as shadow rays walk. */
static int walk(const scene *s, ray r, hit *found) {
    int count = 0;
    for (;; count++) {
        assert_true(count < HITS_MAX);
        accel_trace(s->accel, SNELL_ISA_AUTO, &r, &found[count], 1, NULL);
        if (found[count].instance == NO_ID) return count;
        r.after_t = found[count].t;
        r.after_instance = found[count].instance;
        r.after_primitive = found[count].primitive;
    }
}

/* The normal leads out, and the material is that of a leaf whose surface is here. */
static void check_face(const tree *t, const shade_point *p, tally *out) {
    static const double steps[] = {1e-3, 1e-4, 1e-5, 3e-6};
    dvec3 n = p->outside ? p->n : dvec3_negate(p->n);
    bool sides = false, own = false;
    uint32_t leaf = UINT32_MAX;
    for (uint32_t i = 0; i < TREE_MAX; i++)
        if (p->material->desc && p->instance == 0 &&
            leaf_materials[i].index1 - 1 == (uint32_t)(p->material - p->at.materials))
            leaf = i;
    for (size_t i = 0; i < COUNT_OF(steps) && !(sides && own); i++) {
        dvec3 step = dvec3_scale(n, steps[i]), above = dvec3_add(p->p, step),
              under = dvec3_sub(p->p, step);
        sides |= !contains(t, above) && contains(t, under);
        own |= leaf_parts(t, leaf, above, under);
    }
    out->faces++;
    out->edge_faces += !(sides && own);
}

/* inside: where the ray starts. */
static void check_ray(const scene *s, const tree *t, const ray *r, bool inside, tally *out) {
    hit found[HITS_MAX];
    int count = walk(s, *r, found);
    double reach = count ? (double)found[count - 1].t + 1 : 4;
    out->rays++;
    out->hits += count;
    for (int i = 0; i < count; i++) {
        shade_point p;
        scene_shade_point(s, r, &found[i], &p);
        assert_int_equal(p.outside, !(inside ^ (i & 1)));
        assert_true(i == 0 || found[i].t > found[i - 1].t);
        assert_true(isfinite(p.p.x) && p.clearance >= 0 && p.clearance < 1e-3);
        double off = dvec3_length(dvec3_sub(p.p, along(r, (double)found[i].t)));
        /* Where it grazes, a rounding of the ray shifts the hit by the root of it. */
        double slope = fabs(dvec3_dot(p.n, dvec3_normalize(dvec3_from(r->d))));
        assert_true(off * slope < 2e-6 * (1 + (double)found[i].t) && off < 2e-3);
        check_face(t, &p, out);
    }
    for (int i = 0; i < 48; i++) {
        double at = uniform01() * reach, slack = 2e-5 * (1 + at);
        bool in = inside, close = at < slack;
        for (int k = 0; k < count; k++) {
            if ((double)found[k].t < at) in = !in;
            close |= fabs((double)found[k].t - at) < slack;
        }
        if (close) continue;
        out->points++;
        if (contains(t, along(r, at)) != in)
            fail_msg("inside is %d at t = %.9g of a ray with %d hits", !in, at, count);
    }
}

/* From a face to both sides, in any direction. */
static void check_spawned(const scene *s, const tree *t, const ray *r, tally *out) {
    hit h;
    shade_point p;
    accel_trace(s->accel, SNELL_ISA_AUTO, r, &h, 1, NULL);
    if (h.instance == NO_ID) return;
    scene_shade_point(s, r, &h, &p);
    for (int i = 0; i < 2; i++) {
        ray next;
        scene_spawn_ray(&p, direction(), INFINITY, &next);
        bool up = dvec3_dot(p.n, dvec3_from(next.d)) > 0;
        if (fabs(dvec3_dot(p.n, dvec3_from(next.d))) < 1e-3) continue;
        /* Next to an edge the other side may be another face's. */
        bool inside = contains(t, dvec3_from(next.o));
        if (inside != (up == !p.outside)) continue;
        check_ray(s, t, &next, inside, out);
        out->spawned++;
    }
}

static void check_tree(rig *r, int depth, bool placed, int rays, tally *out) {
    rig_clear(r);
    tree_count = 0;
    for (uint32_t i = 0; i < TREE_MAX; i++) leaf_materials[i] = add_lambert(r, grey(i / 200.0));
    tree *t = make_tree(r, depth, placed);
    while (t->kind != WHOLE) t = make_tree(r, depth, placed);
    MUST(snell_scene_add_instance(r->scene, t->shape, (snell_material_id){0, 0}, &t->to_parent,
                                  NULL));
    MUST(snell_scene_commit(r->scene, NULL, NULL));
    const scene *s = r->scene->frozen;
    for (int i = 0; i < rays; i++) {
        dvec3 from = dvec3_scale(direction(), within(0, 6)),
              at = dvec3_scale(direction(), within(0, 1.5));
        ray beam = ray_make(vec3_from(from), vec3_from(dvec3_sub(at, from)), 0, INFINITY);
        bool inside = contains(t, dvec3_from(beam.o));
        assert_int_equal(s->instances[0].type->side(s->instances[0].shape,
                                                    moved_back(t, dvec3_from(beam.o))) > 0,
                         inside);
        check_ray(s, t, &beam, inside, out);
        check_spawned(s, t, &beam, out);
    }
}

static void random_solids_are_what_their_points_say(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    tally sum = {0};
    int rounds = full() ? 3000 : 200;
    make_ball();
    state = 41;
    for (int i = 0; i < rounds; i++) check_tree(&r, 1 + i % 4, i % 3 != 0, 24, &sum);
    printf("%ld rays, %ld of them from faces, %ld hits, %ld points; %ld of %ld faces at edges\n",
           sum.rays, sum.spawned, sum.hits, sum.points, sum.edge_faces, sum.faces);
    assert_true(sum.hits > 6000 && sum.spawned > 1000);
    assert_true(sum.edge_faces * 2000 < sum.faces);
    rig_free(&r);
}

/* ---- faces that coincide ---- */

static snell_shape_id box_shape(rig *r, snell_vec3 min, snell_vec3 max) {
    snell_box_desc box = SNELL_INIT(box_desc);
    snell_shape_id id;
    box.min = min;
    box.max = max;
    MUST(snell_scene_add_box(r->scene, &box, &id));
    return id;
}

static snell_status solid_of(rig *r, int operation, const snell_shape_id *shapes,
                             const snell_transform *transforms, size_t count, snell_shape_id *out) {
    snell_solid_desc desc = SNELL_INIT(solid_desc);
    desc.operation = operation;
    desc.shapes = shapes;
    desc.shapes_count = count;
    desc.transforms = transforms;
    desc.transforms_count = transforms ? count : 0;
    return snell_scene_add_solid(r->scene, &desc, out);
}

/* One solid of two shapes alone in the scene. */
static const scene *pair(rig *r, int operation, snell_shape_id a, snell_shape_id b,
                         const snell_transform *transforms) {
    const snell_shape_id both[2] = {a, b};
    snell_shape_id id;
    MUST(solid_of(r, operation, both, transforms, 2, &id));
    place(r, id, (snell_material_id){0, 0});
    MUST(snell_scene_commit(r->scene, NULL, NULL));
    return r->scene->frozen;
}

static int hits_of(const scene *s, dvec3 from, dvec3 at) {
    hit found[HITS_MAX];
    return walk(s, ray_make(vec3_from(from), vec3_from(dvec3_sub(at, from)), 0, INFINITY), found);
}

/* As it is, moved, or turned and moved: the same boxes, however they were given. */
static void two_boxes(rig *r, int how, snell_shape_id shapes[2], snell_transform transforms[2]) {
    transforms[0] = transforms[1] = transform_identity();
    rig_clear(r);
    shapes[0] = box_shape(r, v3(-1, -0.3, -0.4), v3(0.1, 0.3, 0.4));
    shapes[1] = how == 0 ? box_shape(r, v3(0.1, -0.3, -0.4), v3(1.2, 0.3, 0.4)) : shapes[0];
    if (how >= 1) transforms[1] = shifted(1.1, 0, 0);
    if (how >= 2) {
        snell_transform turn = rotation(), move = shifted(within(-2, 2), 0.3, 0.7);
        turn = transform_multiply(&turn, &move);
        transforms[0] = turn;
        transforms[1] = transform_multiply(&turn, &transforms[1]);
    }
}

/* Through both boxes and the face between them, at any angle; from outside, along x. */
static void line_across(const snell_transform *to, bool grazing, dvec3 *from, dvec3 *at) {
    double half = grazing ? 1e-3 : 0.2;
    dvec3 middle = {0.1, within(-0.2, 0.2), within(-0.3, 0.3)};
    dvec3 aside = {half * within(0.3, 1), within(-0.05, 0.05), within(-0.05, 0.05)};
    if (!grazing) aside = (dvec3){1, within(-0.2, 0.2), within(-0.2, 0.2)};
    if (grazing) aside.y = 1;
    *from = transform_point(to, dvec3_sub(middle, dvec3_scale(aside, 4)));
    *at = transform_point(to, middle);
}

static void touching_boxes_have_no_face_between_them(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    state = 7;
    for (int how = 0; how < 40; how++) {
        snell_shape_id boxes[2];
        snell_transform to[2];
        two_boxes(&r, how, boxes, to);
        const scene *s = pair(&r, SNELL_SOLID_OPERATION_UNION, boxes[0], boxes[1], to);
        for (int i = 0; i < 2000; i++) {
            dvec3 from, at;
            line_across(&to[0], i % 4 == 3, &from, &at);
            assert_int_equal(hits_of(s, from, at), 2);
        }
    }
    rig_free(&r);
}

/* Two faces that are one to a float, and a ball whose surface crosses the line between them. */
static void what_crosses_between_parts_no_faces(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    for (int order = 0; order < 3; order++) {
        rig_clear(&r);
        snell_sphere_desc ball = SNELL_INIT(sphere_desc);
        snell_shape_id shapes[3], id;
        ball.center = v3(1.8f + 0.6e-6f, 1.1, 0.5);
        shapes[order] = box_shape(&r, v3(0, 0, 0), v3(1, 1, 1));
        shapes[(order + 1) % 3] = box_shape(&r, v3(1 + 1.2e-6, 0, 0), v3(3, 1, 1));
        MUST(snell_scene_add_sphere(r.scene, &ball, &shapes[(order + 2) % 3]));
        MUST(solid_of(&r, 0, shapes, NULL, 3, &id));
        place(&r, id, (snell_material_id){0, 0});
        MUST(snell_scene_commit(r.scene, NULL, NULL));
        const scene *s = r.scene->frozen;
        assert_int_equal(hits_of(s, (dvec3){-1, 0.5, 0.5}, (dvec3){0, 0.5, 0.5}), 2);
        assert_int_equal(hits_of(s, (dvec3){4, 0.5, 0.5}, (dvec3){3, 0.5, 0.5}), 2);
    }
    rig_free(&r);
}

/* Unit boxes 2 apart along z, in one mesh: 8 corners and 36 indices each. */
static void row_of_boxes(uint32_t count, snell_vec3 *positions, uint32_t *indices) {
    static const uint32_t faces[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    for (uint32_t k = 0; k < count; k++) {
        for (uint32_t i = 0; i < 8; i++)
            positions[8 * k + i] = v3(i & 1 ? 1 : 0, i & 2 ? 1 : 0, 2.0 * k + (i & 4 ? 1 : 0));
        for (uint32_t i = 0; i < 36; i++) indices[36 * k + i] = 8 * k + faces[i];
    }
}

/* A mesh is looked through for holes once, however often a solid names it. */
static void naming_a_mesh_often_is_not_checking_it_often(void **unused) {
    (void)unused;
    enum { BOXES = 300, TIMES = 400 };
    rig r = rig_make(1, SNELL_ISA_AUTO);
    static snell_vec3 positions[8 * BOXES];
    static uint32_t indices[36 * BOXES];
    row_of_boxes(BOXES, positions, indices);
    snell_shape_id row[TIMES], id, mesh = add_mesh(&r, positions, 8 * BOXES, indices, 36 * BOXES);
    double took[2];
    for (int i = 0; i < TIMES; i++) row[i] = mesh;
    for (int often = 0; often < 2; often++) {
        double before = cpu_seconds();
        for (int i = 0; i < 4; i++) MUST(solid_of(&r, 0, row, NULL, often ? TIMES : 1, &id));
        took[often] = cpu_seconds() - before;
    }
    printf("a mesh named once: %.4f s, %d times: %.4f s\n", took[0] / 4, TIMES, took[1] / 4);
    assert_true(took[1] < 50 * took[0] + 0.01);
    rig_free(&r);
}

static void nothing_is_left_of_a_box_less_itself(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    state = 8;
    for (int how = 0; how < 40; how++) {
        snell_shape_id boxes[2];
        snell_transform to[2];
        two_boxes(&r, how, boxes, to);
        if (how == 0) boxes[1] = boxes[0];
        if (how >= 1) { /* the same place by another way */
            snell_transform there = shifted(-1.1, 0, 0);
            boxes[0] = box_shape(&r, v3(-1, -0.3, -0.4), v3(0.1, 0.3, 0.4));
            boxes[1] = box_shape(&r, v3(0.1, -0.3, -0.4), v3(1.2, 0.3, 0.4));
            to[1] = transform_multiply(&to[0], &there);
        }
        const scene *s = pair(&r, SNELL_SOLID_OPERATION_DIFFERENCE, boxes[0], boxes[1], to);
        int left = 0;
        for (int i = 0; i < 4000; i++) {
            dvec3 at = transform_point(
                &to[0], (dvec3){within(-1, 0.1), within(-0.3, 0.3), within(-0.4, 0.4)});
            left += hits_of(s, dvec3_scale(direction(), 5), at);
        }
        assert_int_equal(left, 0);
    }
    rig_free(&r);
}

/* A hole as deep as the block is high is open at both ends; one less deep has a floor. The face
 * belongs to the first of those that share it. */
static void a_hole_flush_with_the_face_is_open(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    state = 9;
    for (int how = 0; how < 20; how++) {
        rig_clear(&r);
        snell_transform to[2] = {transform_identity(), shifted(0, 0.7, 0)};
        snell_cylinder_desc drill = SNELL_INIT(cylinder_desc);
        snell_shape_id hole;
        drill.from = v3(0, -0.7, 0);
        drill.to = v3(0, how % 2 ? 0.3 : 0.1, 0);
        drill.radius = 0.25f;
        snell_shape_id block = box_shape(&r, v3(-1, 0, -1), v3(1, 1, 1));
        MUST(snell_scene_add_cylinder(r.scene, &drill, &hole));
        if (how > 1) {
            snell_transform turn = rotation();
            to[0] = turn;
            to[1] = transform_multiply(&turn, &to[1]);
        }
        const scene *s = pair(&r, SNELL_SOLID_OPERATION_DIFFERENCE, block, hole, to);
        for (int i = 0; i < 1000; i++) {
            dvec3 d = {within(-0.05, 0.05), 1, within(-0.05, 0.05)},
                  foot = {within(-0.1, 0.1), 0, within(-0.1, 0.1)};
            dvec3 from = transform_point(&to[0], dvec3_sub(foot, dvec3_scale(d, 2)));
            int hits = hits_of(s, from, transform_point(&to[0], foot));
            assert_int_equal(hits, how % 2 ? 0 : 2);
        }
    }
    rig_free(&r);
}

/* Where both tops are at one height the first one's material shows. */
static void the_first_of_two_faces_shows(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    for (int order = 0; order < 2; order++) {
        rig_clear(&r);
        const snell_material_id colors[2] = {add_lambert(&r, grey(0.1)),
                                             add_lambert(&r, grey(0.9))};
        const snell_shape_id boxes[2] = {box_shape(&r, order ? v3(-0.5, -1, -0.5) : v3(-1, -1, -1),
                                                   order ? v3(0.5, 0.5, 0.5) : v3(1, 0.5, 1)),
                                         box_shape(&r, order ? v3(-1, -1, -1) : v3(-0.5, -1, -0.5),
                                                   order ? v3(1, 0.5, 1) : v3(0.5, 0.5, 0.5))};
        snell_solid_desc desc = SNELL_INIT(solid_desc);
        snell_shape_id id;
        desc.shapes = boxes;
        desc.materials = colors;
        desc.shapes_count = desc.materials_count = 2;
        MUST(snell_scene_add_solid(r.scene, &desc, &id));
        place(&r, id, (snell_material_id){0, 0});
        MUST(snell_scene_commit(r.scene, NULL, NULL));
        const scene *s = r.scene->frozen;
        for (int i = 0; i < 200; i++) {
            double x = -0.99 + i * 0.00993, z = 0.3;
            ray down = ray_make((vec3){(float)x, 3, (float)z}, (vec3){0, -1, 0}, 0, INFINITY);
            hit h;
            shade_point p;
            accel_trace(s->accel, SNELL_ISA_AUTO, &down, &h, 1, NULL);
            scene_shade_point(s, &down, &h, &p);
            bool first = order == 0 || fabs(x) < 0.5;
            assert_ptr_equal(p.material, &s->materials[!first]);
            assert_true(h.t == 2.5f && p.n.y == 1);
        }
    }
    rig_free(&r);
}

/* ---- meshes ---- */

/* Along the axes through a grid of vertices, every line meets vertices or edges only, and still each
 * enters once and leaves once. */
static void lines_through_vertices_count_once(void **unused) {
    (void)unused;
    enum { SIDE = 8, FACE = (SIDE + 1) * (SIDE + 1) };
    static snell_vec3 positions[6 * FACE];
    static uint32_t indices[6 * SIDE * SIDE * 6];
    size_t vertices = 0, count = 0;
    for (int face = 0; face < 6; face++) { /* of the cube 0..8, each a sheet of its own */
        int axis = face / 2;
        for (int k = 0; k < FACE; k++) {
            double p[3];
            p[axis] = face % 2 ? SIDE : 0;
            p[(axis + 1) % 3] = k % (SIDE + 1);
            p[(axis + 2) % 3] = k / (SIDE + 1);
            positions[vertices + (size_t)k] = v3(p[0], p[1], p[2]);
        }
        for (uint32_t k = 0; k < SIDE * SIDE; k++) {
            uint32_t a = (uint32_t)vertices + k / SIDE * (SIDE + 1) + k % SIDE, b = a + 1,
                     c = a + SIDE + 1, d = c + 1;
            const uint32_t out[6] = {a, b, d, a, d, c}, in[6] = {a, d, b, a, c, d};
            memcpy(indices + count, face % 2 ? out : in, sizeof out);
            count += 6;
        }
        vertices += FACE;
    }
    rig r = rig_make(1, SNELL_ISA_AUTO);
    snell_shape_id mesh = add_mesh(&r, positions, vertices, indices, count);
    snell_shape_id far = box_shape(&r, v3(100, 100, 100), v3(101, 101, 101));
    const scene *s = pair(&r, SNELL_SOLID_OPERATION_UNION, mesh, far, NULL);
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 15 * 15; k++) {
            double from[3], at[3];
            from[axis] = axis == 1 ? 20 : -3, at[axis] = 4;
            from[(axis + 1) % 3] = at[(axis + 1) % 3] = 0.5 + 0.5 * (k % 15);
            from[(axis + 2) % 3] = at[(axis + 2) % 3] = 0.5 + 0.5 * (double)(k / 15);
            assert_int_equal(
                hits_of(s, (dvec3){from[0], from[1], from[2]}, (dvec3){at[0], at[1], at[2]}), 2);
        }
    for (int i = 0; i < 4000; i++) { /* from vertex to vertex, slantwise: through the inside */
        dvec3 a = {-8, (double)below(25) - 8, (double)below(25) - 8};
        dvec3 b = {8, 1 + below(7), 1 + below(7)};
        int hits = hits_of(s, a, b);
        assert_true(hits == 2 || hits == 0);
    }
    rig_free(&r);
}

/* A tetrahedron of small whole numbers and rays in the planes of its faces: whatever is rounded, no
 * stretch ends outside of the mesh, and they are in order. */
static void stretches_stay_in_the_mesh(void **unused) {
    (void)unused;
    const uint32_t faces[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
    state = 8;
    int ends = 0;
    for (int n = 0; n < (full() ? 200000 : 4000); n++) {
        vec3 p[4], low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
        double scale = n & 1 ? 1 : 0.1;
        for (int i = 0; i < 4; i++) {
            double x[3];
            for (int k = 0; k < 3; k++) x[k] = (below(19) - 9.0) * scale;
            p[i] = vec3_from((dvec3){x[0], x[1], x[2]});
            low = (vec3){float_min(low.x, p[i].x), float_min(low.y, p[i].y),
                         float_min(low.z, p[i].z)};
            high = (vec3){float_max(high.x, p[i].x), float_max(high.y, p[i].y),
                          float_max(high.z, p[i].z)};
        }
        mesh_desc desc = {.struct_size = sizeof desc,
                          .positions = p,
                          .positions_count = 4,
                          .indices = faces,
                          .indices_count = 12};
        solid_mesh *mesh;
        MUST(solid_mesh_create(&desc, NULL, &mesh));
        for (int k = 0; k < 20; k++) {
            const uint32_t *f = faces + 3 * below(4);
            dvec3 a = dvec3_from(p[f[0]]);
            dvec3 u = dvec3_sub(dvec3_from(p[f[1]]), a), v = dvec3_sub(dvec3_from(p[f[2]]), a);
            dvec3 d = dvec3_add(dvec3_scale(u, below(7) - 3.0), dvec3_scale(v, below(7) - 3.0));
            dvec3 o = dvec3_add(dvec3_scale(u, (below(7) - 3.0) / 4),
                                dvec3_scale(v, (below(7) - 3.0) / 4));
            o = dvec3_from(vec3_from(dvec3_sub(dvec3_add(a, o), dvec3_scale(d, below(6)))));
            d = dvec3_from(vec3_from(d));
            if (!(dvec3_dot(d, d) > 0)) continue;
            span out[8];
            int count = solid_mesh_spans(mesh, o, d, out, 8);
            double before = -INFINITY;
            for (int i = 0; i < 2 * count; i++, ends++) {
                double t = i % 2 ? out[i / 2].leave.t : out[i / 2].enter.t;
                dvec3 at = dvec3_add(o, dvec3_scale(d, t));
                double room = 1e-5 * (1 + dvec3_length(o));
                assert_true(t >= before);
                assert_true(at.x >= low.x - room && at.y >= low.y - room && at.z >= low.z - room);
                assert_true(at.x <= high.x + room && at.y <= high.y + room &&
                            at.z <= high.z + room);
                before = t;
            }
        }
        solid_mesh_destroy(mesh);
    }
    assert_true(ends > 10000);
}

/* A mesh without triangles encloses nothing. */
static void nothing_is_a_solid(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    const snell_vec3 corners[] = {v3(0, 0, 0), v3(1, 0, 0), v3(0, 1, 0)};
    snell_shape_id none = add_mesh(&r, corners, 3, NULL, 0);
    snell_shape_id box = box_shape(&r, v3(0, 0, 0), v3(1, 1, 1));
    const scene *s = pair(&r, SNELL_SOLID_OPERATION_UNION, none, box, NULL);
    assert_int_equal(hits_of(s, (dvec3){0.5, 0.5, 5}, (dvec3){0.5, 0.5, -5}), 2);
    rig_free(&r);
}

/* ---- what cannot be ---- */

static void must_fail(snell_status got, snell_status wanted, const char *text) {
    assert_int_equal(got, wanted);
    if (strstr(snell_last_error()->text, text) == NULL)
        fail_msg("\"%s\" does not say \"%s\"", snell_last_error()->text, text);
}

static void open_shapes_are_refused(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    snell_disk_desc disk = SNELL_INIT(disk_desc);
    snell_cylinder_desc tube = SNELL_INIT(cylinder_desc);
    snell_lathe_desc vase = SNELL_INIT(lathe_desc);
    const snell_vec2 line[] = {{0.5f, 0}, {0.5f, 1}};
    snell_shape_id shapes[3], out, mesh[2];
    tube.to = v3(0, 1, 0);
    tube.capped = false;
    vase.profile = line;
    vase.profile_count = 2;
    MUST(snell_scene_add_disk(r.scene, &disk, &shapes[0]));
    MUST(snell_scene_add_cylinder(r.scene, &tube, &shapes[1]));
    MUST(snell_scene_add_lathe(r.scene, &vase, &shapes[2]));
    must_fail(solid_of(&r, 0, &shapes[0], NULL, 1, &out), SNELL_ERR_ARGUMENT,
              "disk: it encloses nothing and cannot be part of a solid");
    must_fail(solid_of(&r, 0, &shapes[1], NULL, 1, &out), SNELL_ERR_ARGUMENT,
              "cylinder: an open cylinder cannot be part of a solid");
    assert_string_equal(snell_last_error()->hint, "set capped = true");
    must_fail(solid_of(&r, 0, &shapes[2], NULL, 1, &out), SNELL_ERR_ARGUMENT,
              "lathe: an open lathe cannot be part of a solid");
    snell_instance_id part = place(&r, shapes[0], (snell_material_id){0, 0});
    MUST(snell_scene_add_group(r.scene, &part, 1, NULL, &out));
    must_fail(solid_of(&r, 0, &out, NULL, 1, &out), SNELL_ERR_ARGUMENT,
              "a group cannot be part of a solid");
    make_ball();
    mesh[0] = add_mesh(&r, ball_positions, ball_vertex_count, ball_indices, ball_index_count);
    mesh[1] = add_mesh(&r, ball_positions, ball_vertex_count, ball_indices, ball_index_count - 3);
    MUST(solid_of(&r, 0, mesh, NULL, 1, &out));
    must_fail(solid_of(&r, 0, mesh, NULL, 2, &out), SNELL_ERR_ARGUMENT,
              "an open mesh cannot be part of a solid: the edge from");
    rig_free(&r);
}

static void wrong_solids_are_refused(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    snell_shape_id box = box_shape(&r, v3(0, 0, 0), v3(1, 1, 1)), out, self;
    const snell_transform flat_one = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}}};
    snell_transform endless = transform_identity();
    endless.m[1][3] = NAN;
    must_fail(solid_of(&r, 1, NULL, NULL, 0, &out), SNELL_ERR_ARGUMENT, "it has no shapes");
    must_fail(solid_of(&r, 3, &box, NULL, 1, &out), SNELL_ERR_ARGUMENT, "'operation' must be one");
    must_fail(solid_of(&r, 0, &box, &flat_one, 1, &out), SNELL_ERR_ARGUMENT,
              "the transform of shape 1 cannot be inverted");
    must_fail(solid_of(&r, 0, &box, &endless, 1, &out), SNELL_ERR_ARGUMENT, "not a finite number");
    self = (snell_shape_id){box.index1 + 1, 0}; /* what it would itself be */
    must_fail(solid_of(&r, 0, &self, NULL, 1, &out), SNELL_ERR_ARGUMENT, "does not exist");
    snell_shape_id row[SOLID_PARTS_MAX + 1];
    for (size_t i = 0; i < COUNT_OF(row); i++) row[i] = box;
    MUST(solid_of(&r, 0, row, NULL, SOLID_PARTS_MAX, &out));
    must_fail(solid_of(&r, 0, row, NULL, COUNT_OF(row), &out), SNELL_ERR_ARGUMENT,
              "more than 1024 shapes");
    row[1] = out;
    must_fail(solid_of(&r, 0, row, NULL, 2, &out), SNELL_ERR_ARGUMENT, "more than 1024 shapes");
    /* Deep: each is the last less a box; and wide: each is the last, twice. */
    row[0] = row[1] = box;
    for (int i = 0; i < SOLID_DEPTH_MAX; i++) MUST(solid_of(&r, 2, row, NULL, 2, &row[0]));
    must_fail(solid_of(&r, 2, row, NULL, 2, &out), SNELL_ERR_ARGUMENT, "more than 256 deep");
    row[0] = row[1] = box;
    for (int i = 0; i < 10; i++) {
        MUST(solid_of(&r, 0, row, NULL, 2, &row[0]));
        row[1] = row[0];
    }
    must_fail(solid_of(&r, 0, row, NULL, 2, &out), SNELL_ERR_ARGUMENT, "more than 1024 shapes");
    place(&r, row[0], (snell_material_id){0, 0});
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    assert_int_equal(hits_of(r.scene->frozen, (dvec3){0.5, 3, 0.4}, (dvec3){0.4, 0.5, 0.5}), 2);
    rig_free(&r);
}

/* A comb of more teeth than a line may meet: an error, not a wrong picture. */
static void too_many_stretches_are_an_error(void **unused) {
    (void)unused;
    enum { TEETH = SOLID_SPANS_MAX + 1 };
    static snell_vec3 positions[8 * TEETH];
    static uint32_t indices[36 * TEETH];
    row_of_boxes(TEETH, positions, indices);
    rig r = rig_make(2, SNELL_ISA_AUTO);
    snell_shape_id near = box_shape(&r, v3(-9, -9, -9), v3(-8, -8, -8));
    for (int more = 0; more < 2; more++) {
        rig_clear(&r);
        near = box_shape(&r, v3(-9, -9, -9), v3(-8, -8, -8));
        snell_shape_id comb =
            add_mesh(&r, positions, 8 * TEETH, indices, 36 * (TEETH - 1 + (size_t)more));
        pair(&r, SNELL_SOLID_OPERATION_UNION, comb, near, NULL);
        snell_render_desc desc = picture(SNELL_APPEL, 8, 8, 0);
        snell_view view = SNELL_INIT(view);
        view.from = v3(0.5, 0.5, -2);
        view.at = v3(0.5, 0.5, 0);
        view.fov = 1e-3f;
        desc.view = &view;
        snell_status status = snell_render(r.scene, &desc, r.film);
        if (!more)
            MUST(status);
        else
            must_fail(status, SNELL_ERR_UNSUPPORTED, "more than 1024 stretches");
    }
    rig_free(&r);
}

/* Queries say so too, of their own rays alone: whoever asks later, or renders another view, is not
 * told of them. The progress of a render may ask. */
static bool ask_of_spent(void *user, const snell_progress *progress) {
    rig *r = user;
    (void)progress;
    snell_ray across = {
        .origin = v3(-5, 0.1, 0.1), .direction = v3(1, 0, 0), .t_max = INFINITY, .mask = 7};
    snell_hit found;
    return snell_scene_intersect(r->scene, &across, &found, 1) == SNELL_ERR_UNSUPPORTED;
}

static void spent_solids_are_the_askers_own(void **unused) {
    (void)unused;
    rig r = rig_make(2, SNELL_ISA_AUTO);
    snell_implicit_desc waves = SNELL_INIT(implicit_desc);
    snell_sphere_desc ball = SNELL_INIT(sphere_desc);
    snell_shape_id shapes[2], solid;
    ball.center = v3(0, 0, -5);
    waves.f = "sin(4000*x)";
    waves.min = v3(-1, -1, -1);
    waves.max = v3(1, 1, 1);
    MUST(snell_scene_add_implicit(r.scene, &waves, &shapes[0]));
    MUST(snell_scene_add_sphere(r.scene, &ball, &shapes[1]));
    MUST(solid_of(&r, 0, shapes, NULL, 2, &solid));
    MUST(snell_scene_add_instance(r.scene, solid, (snell_material_id){0, 0}, NULL, NULL));
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    snell_ray rays[2] = {{.origin = v3(-5, 0.1, 0.1), .direction = v3(1, 0, 0)},
                         {.origin = v3(0, 5, -5), .direction = v3(0, -1, 0)}};
    for (int i = 0; i < 2; i++) rays[i].t_max = INFINITY, rays[i].mask = 7;
    enum { MANY = 5000 };
    static snell_ray many[MANY];
    static snell_hit found[MANY];
    static uint8_t blocked[MANY];
    const char *said = "more than 1024 stretches";
    for (int i = 0; i < MANY; i++) many[i] = rays[i != MANY - 1];
    must_fail(snell_scene_intersect(r.scene, rays, found, 2), SNELL_ERR_UNSUPPORTED, said);
    assert_true(isinf(found[0].t) && found[1].t < 5); /* the others are what they are */
    MUST(snell_scene_intersect(r.scene, rays + 1, found, 1));
    must_fail(snell_scene_occluded(r.scene, rays, blocked, 2), SNELL_ERR_UNSUPPORTED, said);
    MUST(snell_scene_occluded(r.scene, rays + 1, blocked, 1));
    must_fail(snell_scene_intersect_all(r.scene, many, found, MANY), SNELL_ERR_UNSUPPORTED, said);
    MUST(snell_scene_intersect_all(r.scene, many, found, MANY - 1));
    snell_render_desc desc = picture(SNELL_APPEL, 8, 8, 0);
    snell_view away = SNELL_INIT(view), across = SNELL_INIT(view);
    away.from = v3(0, 0, 5);
    away.at = v3(0, 0, 50);
    across.from = v3(-5, 0.1, 0.1);
    across.at = v3(0, 0.1, 0.1);
    across.fov = 1e-3f;
    desc.progress = ask_of_spent;
    desc.user = &r;
    desc.view = &away;
    MUST(snell_render(r.scene, &desc, r.film));
    desc.view = &across;
    must_fail(snell_render(r.scene, &desc, r.film), SNELL_ERR_UNSUPPORTED, said);
    desc.view = &away;
    MUST(snell_render(r.scene, &desc, r.film));
    rig_free(&r);
}

/* ---- bounds ---- */

static int warnings;
static void count_warning(void *user, const snell_message *message) {
    (void)user;
    warnings += message->severity == SNELL_WARNING && strstr(message->text, "is empty") != NULL;
}

static void bounds_are_tight(void **unused) {
    (void)unused;
    snell_context_desc context = SNELL_INIT(context_desc);
    context.log = count_warning;
    rig r = {0};
    MUST(snell_context_create(&context, &r.context));
    MUST(snell_scene_create(r.context, &r.scene));
    snell_bounds b;
    snell_plane_desc plane = SNELL_INIT(plane_desc);
    snell_shape_id shapes[6], id, half;
    plane.point = v3(0, 0.25, 0);
    MUST(snell_scene_add_plane(r.scene, &plane, &half));
    snell_shape_id box = box_shape(&r, v3(-1, -1, -1), v3(1, 1, 1)),
                   other = box_shape(&r, v3(0.5, -3, -3), v3(4, 3, 3));
    /* Half a box; three quarters of one; nothing; a block of six half-spaces. */
    pair(&r, SNELL_SOLID_OPERATION_INTERSECTION, box, half, NULL);
    MUST(snell_scene_bounds(r.scene, &b));
    assert_true(fabs((double)b.max.y - 0.25) < 1e-4 && fabs((double)b.min.y + 1) < 1e-4);
    pair(&r, SNELL_SOLID_OPERATION_DIFFERENCE, box, other, NULL);
    assert_int_equal(warnings, 0);
    snell_transform apart[2] = {transform_identity(), shifted(1, 0, 0)};
    const scene *s = pair(&r, SNELL_SOLID_OPERATION_INTERSECTION, box, other, apart);
    assert_int_equal(warnings, 1);
    assert_true(bounds3_is_empty(s->solids->solids[s->instances[2].shape_index]->bounds));
    rig_clear(&r);
    for (int i = 0; i < 6; i++) {
        double n[3] = {0, 0, 0};
        n[i / 2] = i % 2 ? 1 : -1;
        plane.normal = v3(n[0], n[1], n[2]);
        plane.point = v3(n[0] * 2, n[1] * 2, n[2] * 2);
        MUST(snell_scene_add_plane(r.scene, &plane, &shapes[i]));
    }
    MUST(solid_of(&r, SNELL_SOLID_OPERATION_INTERSECTION, shapes, NULL, 6, &id));
    place(&r, id, (snell_material_id){0, 0});
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    MUST(snell_scene_bounds(r.scene, &b));
    assert_true(fabs((double)b.max.x - 2) < 1e-4 && fabs((double)b.min.z + 2) < 1e-4);
    assert_int_equal(hits_of(r.scene->frozen, (dvec3){5, 6, 7}, (dvec3){0, 0.1, 0.3}), 2);
    rig_free(&r);
}

/* ---- glass ---- */

/* Two touching halves are one block of glass: the same light, from outside and from within, and no
 * medium is lost on the way. */
static void halves_of_glass_are_one(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    for (int inside = 0; inside < 2; inside++) {
        enum { SIDE = 24, VALUES = SIDE * SIDE * 3 };
        float pictures[2][VALUES];
        for (int halves = 0; halves < 2; halves++) {
            rig_clear(&r);
            snell_material_id glass = add_glass(&r, 1.5, v3(0.4, 0.1, 0.2), 0);
            if (halves) {
                snell_shape_id half = box_shape(&r, v3(-1, -1, -1), v3(0, 1, 1)), id;
                const snell_shape_id both[2] = {half, half};
                const snell_transform to[2] = {transform_identity(), shifted(1, 0, 0)};
                MUST(solid_of(&r, SNELL_SOLID_OPERATION_UNION, both, to, 2, &id));
                place(&r, id, glass);
            } else {
                add_box(&r, v3(-1, -1, -1), v3(1, 1, 1), glass);
            }
            add_plane(&r, v3(0, -1.5, 0), v3(0, 1, 0), add_lambert(&r, v3(0.8, 0.7, 0.3)));
            add_point(&r, v3(2, 5, 3), grey(60));
            MUST(snell_scene_set_background(r.scene, v3(0.2, 0.4, 0.9), 1));
            MUST(snell_scene_commit(r.scene, NULL, NULL));
            snell_render_desc desc = picture(SNELL_WHITTED, SIDE, SIDE, 10);
            snell_view view = SNELL_INIT(view);
            view.from = inside ? v3(0.2, 0.3, 0.4) : v3(3, 2.5, 4);
            view.at = inside ? v3(-1, -0.5, 0) : v3(0, 0, 0);
            view.fov = inside ? 1.2f : 0.7f;
            desc.view = &view;
            MUST(snell_render(r.scene, &desc, r.film));
            snell_render_stats stats = {.struct_size = sizeof stats};
            MUST(snell_film_get_stats(r.film, &stats));
            assert_int_equal(stats.media_mismatches, 0);
            memcpy(pictures[halves], snell_film_pixels(r.film, NULL, NULL, NULL),
                   sizeof pictures[halves]);
        }
        double brightest = 0;
        for (int i = 0; i < VALUES; i++) {
            assert_true(fabs((double)pictures[0][i] - (double)pictures[1][i]) < 1e-3);
            brightest = double_max(brightest, (double)pictures[0][i]);
        }
        assert_true(brightest > 0.3);
    }
    rig_free(&r);
}

/* ---- as any shape: moved, several times, by what it is seen through ---- */

static void solids_move_as_a_whole(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    snell_perspective_camera_desc camera = SNELL_INIT(perspective_camera_desc);
    snell_animation clock = SNELL_INIT(animation);
    clock.fps = 1;
    camera.shutter = (snell_vec2){0, 1};
    MUST(snell_scene_add_perspective_camera(r.scene, &camera, NULL));
    MUST(snell_scene_set_animation(r.scene, &clock));
    /* A tube of 1 less 0.5 thick, which moves by 10 in a second. */
    const snell_shape_id boxes[2] = {box_shape(&r, v3(-1, -1, -1), v3(1, 1, 1)),
                                     box_shape(&r, v3(-0.5, -2, -2), v3(0.5, 2, 2))};
    const snell_motion_key keys[2] = {{0, shifted(0, 0, 0)}, {1, shifted(10, 0, 0)}};
    snell_shape_id id;
    snell_instance_id moving;
    MUST(solid_of(&r, SNELL_SOLID_OPERATION_DIFFERENCE, boxes, NULL, 2, &id));
    MUST(snell_scene_add_instance(r.scene, id, (snell_material_id){0, 0}, NULL, &moving));
    MUST(snell_scene_set_instance_motion(r.scene, moving, keys, 2));
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    for (int i = 0; i <= 8; i++) {
        hit found[HITS_MAX];
        ray line = ray_make((vec3){-5, 0, 0}, (vec3){1, 0, 0}, 0, INFINITY);
        line.time = (float)(i / 8.0);
        assert_int_equal(walk(r.scene->frozen, line, found), 4);
        for (int k = 0; k < 4; k++) {
            const double faces[4] = {-1, -0.5, 0.5, 1};
            assert_true(fabs((double)found[k].t - (5 + 10 * i / 8.0 + faces[k])) < 1e-5);
        }
    }
    rig_free(&r);
}

/* ---- between processes ---- */

typedef struct block {
    unsigned char *data;
    size_t size, capacity;
} block;

static bool append(void *user, const void *data, size_t size) {
    block *b = user;
    if (b->size + size > b->capacity) return false;
    memcpy(b->data + b->size, data, size);
    b->size += size;
    return true;
}

/* Every byte of a block with solids in it is changed in turn: what is read is refused, or is a scene
 * that can be committed. */
static void hostile_records_do_no_harm(void **unused) {
    (void)unused;
    rig r = rig_make(1, SNELL_ISA_AUTO);
    make_ball();
    snell_material_id red = add_lambert(&r, v3(1, 0, 0));
    snell_shape_id box = box_shape(&r, v3(0, 0, 0), v3(1, 1, 1)), inner, outer;
    const snell_shape_id first[2] = {box, add_leaf(&r, SPHERE)};
    const snell_transform to[2] = {shifted(1, 2, 3), transform_identity()};
    MUST(solid_of(&r, 2, first, to, 2, &inner));
    snell_solid_desc desc = SNELL_INIT(solid_desc);
    const snell_shape_id second[2] = {inner, add_angle(&r, false, false)};
    const snell_material_id materials[2] = {{0, 0}, red};
    desc.operation = SNELL_SOLID_OPERATION_INTERSECTION;
    desc.shapes = second;
    desc.materials = materials;
    desc.shapes_count = desc.materials_count = 2;
    MUST(snell_scene_add_solid(r.scene, &desc, &outer));
    place(&r, outer, red);
    block b = {malloc(1 << 16), 0, 1 << 16};
    assert_non_null(b.data);
    MUST(records_write(r.scene->description, append, &b));
    rig_clear(&r);
    MUST(records_read(b.data, b.size, r.scene->description)); /* after itself: ids are shifted */
    MUST(records_read(b.data, b.size, r.scene->description));
    const object_list *shapes = &r.scene->description->objects[CATEGORY_SHAPE];
    assert_int_equal(shapes->count, 10);
    const solid_desc *copied = shapes->items[9].desc;
    assert_int_equal(copied->shapes[0].index1, 8);
    assert_int_equal(copied->shapes[1].index1, 9);
    assert_int_equal(copied->materials[0].index1, 0);
    assert_int_equal(copied->materials[1].index1, 2);
    MUST(snell_scene_commit(r.scene, NULL, NULL));
    long refused = 0, read = 0;
    for (size_t i = 56; i < b.size; i++) {
        static const unsigned char flips[] = {1, 0x80, 0xff};
        for (size_t k = 0; k < COUNT_OF(flips); k++) {
            b.data[i] ^= flips[k];
            rig_clear(&r);
            snell_status status = records_read(b.data, b.size, r.scene->description);
            b.data[i] ^= flips[k];
            status ? refused++ : read++;
            if (!status && read % 16 == 0) (void)snell_scene_commit(r.scene, NULL, NULL);
        }
    }
    assert_true(refused > 500 && read > 500);
    free(b.data);
    rig_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_solids_are_what_their_points_say),
        cmocka_unit_test(touching_boxes_have_no_face_between_them),
        cmocka_unit_test(what_crosses_between_parts_no_faces),
        cmocka_unit_test(naming_a_mesh_often_is_not_checking_it_often),
        cmocka_unit_test(nothing_is_left_of_a_box_less_itself),
        cmocka_unit_test(a_hole_flush_with_the_face_is_open),
        cmocka_unit_test(the_first_of_two_faces_shows),
        cmocka_unit_test(lines_through_vertices_count_once),
        cmocka_unit_test(open_shapes_are_refused),
        cmocka_unit_test(wrong_solids_are_refused),
        cmocka_unit_test(too_many_stretches_are_an_error),
        cmocka_unit_test(spent_solids_are_the_askers_own),
        cmocka_unit_test(bounds_are_tight),
        cmocka_unit_test(halves_of_glass_are_one),
        cmocka_unit_test(solids_move_as_a_whole),
        cmocka_unit_test(stretches_stay_in_the_mesh),
        cmocka_unit_test(nothing_is_a_solid),
        cmocka_unit_test(hostile_records_do_no_harm),
    };
    return cmocka_run_group_tests_name("solids", tests, NULL, NULL);
}
