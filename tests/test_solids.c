/* Solids: what rays meet of random unions, intersections and differences is held against asking, point
 * by point, whether it is inside; faces that coincide; limits and what cannot be. */
#include <string.h>

#include "api/api.h"
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
        assert_true(off * slope < 2e-6 && off < 2e-3);
        check_face(t, &p, out);
    }
    for (int i = 0; i < 48; i++) {
        double at = uniform01() * reach;
        bool in = inside, close = at < 2e-5;
        for (int k = 0; k < count; k++) {
            if ((double)found[k].t < at) in = !in;
            close |= fabs((double)found[k].t - at) < 2e-5;
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
        ray next = scene_spawn_ray(&p, direction(), INFINITY);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_solids_are_what_their_points_say),
    };
    return cmocka_run_group_tests_name("solids", tests, NULL, NULL);
}
