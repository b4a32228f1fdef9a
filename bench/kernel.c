/* Kernel benchmark: primary, shadow and mirror rays by every instruction set of this machine, and by
 * Embree fed the same rays in the same run. See bench/README.md. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/deforming.h"
#include "kernel_scenes.h"
#include "maths/functions.h"
#include "measure.h"

#if BENCH_HAS_EMBREE
#include <embree3/rtcore.h>
#endif

enum { KINDS = 3, TRACERS = 4, BATCH = 1024 };
static const char *const kind_names[KINDS] = {"primary", "shadow", "mirror"};
static const char *const tracer_names[TRACERS] = {"scalar", "avx2", "avx512", "embree"};
static const snell_isa tracer_isas[TRACERS - 1] = {SNELL_ISA_SCALAR, SNELL_ISA_AVX2,
                                                   SNELL_ISA_AVX512};
enum { EMBREE = TRACERS - 1, SHADOW = 1 };

typedef struct settings {
    uint32_t size, rounds, leaf_size;
    bool json, embree, deforming;
} settings;

typedef struct ray_set {
    ray *rays;
    size_t count;
    hit *hits[TRACERS]; /* shadow rays: instance 0 or NO_ID */
    bool traced[TRACERS];
    double mrays[TRACERS][ROUNDS_MAX];
    trace_counters counters;
} ray_set;

typedef struct bench {
    settings settings;
    bench_scene scene;
    bounds3 bounds;
    mesh_desc mesh;
    vec3 *keys; /* of a mesh that deforms: positions at both */
    deforming_mesh *deforming;
    void *sphere_descs;
    accel_geometry *geometries;
    accel_instance *instances;
    accel *accel;
    double build_seconds, embree_build_seconds;
    ray_set sets[KINDS];
#if BENCH_HAS_EMBREE
    RTCDevice device;
    RTCScene embree;
#endif
} bench;

static void die(const char *what) {
    fprintf(stderr, "bench-kernel: %s\n", what);
    exit(1);
}

static void *need(void *memory) {
    if (memory == NULL) die("out of memory");
    return memory;
}

/* ---- building ---- */

static const float key_times[2] = {0, 1};

/* At the second key it is stretched, and twisted about y by up to a radian. */
static void describe_deforming(bench *b) {
    const bench_scene *s = &b->scene;
    double height = (double)b->bounds.max.y - (double)b->bounds.min.y;
    b->keys = need(memory_resize(NULL, 2 * s->position_count, sizeof *b->keys));
    for (size_t i = 0; i < s->position_count; i++) {
        dvec3 p = dvec3_from(s->positions[i]);
        double turn = (p.y - (double)b->bounds.min.y) / height, c = fn_cos(turn), n = fn_sin(turn);
        b->keys[i] = s->positions[i];
        b->keys[s->position_count + i] = (vec3){(float)(1.2 * (c * p.x - n * p.z)),
                                                s->positions[i].y, (float)(n * p.x + c * p.z)};
    }
    b->mesh.positions = b->keys;
    b->mesh.positions_count = 2 * s->position_count;
    b->mesh.key_times = key_times;
    b->mesh.key_times_count = 2;
    b->deforming = need(deforming_create(&b->mesh, 0, 1));
    b->geometries[0] = (accel_geometry){.type = &primitive_deforming, .desc = b->deforming};
}

static void describe_scene(bench *b) {
    const bench_scene *s = &b->scene;
    size_t count = s->sphere_count ? s->sphere_count : 1;
    b->geometries = need(memory_zeroed(count, sizeof *b->geometries));
    b->instances = need(memory_zeroed(count, sizeof *b->instances));
    for (size_t i = 0; i < count; i++)
        b->instances[i] = (accel_instance){(uint32_t)i,          ~0u, true, transform_identity(),
                                           transform_identity(), NULL};
    if (s->sphere_count == 0) {
        b->mesh = (mesh_desc){.positions = s->positions,
                              .positions_count = s->position_count,
                              .indices = s->indices,
                              .indices_count = s->index_count};
        b->geometries[0] = (accel_geometry){.type = primitive_find("mesh"), .desc = &b->mesh};
        if (b->settings.deforming) describe_deforming(b);
        return;
    }
    const primitive_type *type = primitive_find("sphere");
    b->sphere_descs = need(memory_zeroed(count, type->info.desc_size));
    for (size_t i = 0; i < count; i++) {
        char *desc = (char *)b->sphere_descs + i * type->info.desc_size;
        desc_init(&type->info, desc);
        snell_param center = {
            .name = "center", .kind = SNELL_PARAM_VEC3, .value.v = s->spheres[i].center};
        snell_param radius = {
            .name = "radius", .kind = SNELL_PARAM_FLOAT, .value.f = s->spheres[i].radius};
        if (desc_set(&type->info, desc, &center) || desc_set(&type->info, desc, &radius))
            die(error_last()->text);
        b->geometries[i] = (accel_geometry){.type = type, .desc = desc};
    }
}

static void build(bench *b) {
    describe_scene(b);
    size_t count = b->scene.sphere_count ? b->scene.sphere_count : 1;
    accel_input input = {b->geometries, count, b->instances, count};
    accel_options options = {.leaf_size = b->settings.leaf_size};
    thread_pool *pool;
    if (thread_pool_create(0, &pool)) die(error_last()->text);
    double start = time_seconds();
    if (accel_build(&input, &options, pool, &b->accel)) die(error_last()->text);
    b->build_seconds = time_seconds() - start;
    thread_pool_destroy(pool);
}

#if BENCH_HAS_EMBREE
static void build_embree(bench *b) {
    const bench_scene *s = &b->scene;
    b->device = rtcNewDevice(NULL);
    if (b->device == NULL) die("Embree gives no device");
    double start = time_seconds();
    b->embree = rtcNewScene(b->device);
    rtcSetSceneFlags(b->embree, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry g = rtcNewGeometry(b->device, s->sphere_count ? RTC_GEOMETRY_TYPE_SPHERE_POINT
                                                              : RTC_GEOMETRY_TYPE_TRIANGLE);
    if (s->sphere_count) {
        void *to = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                                           sizeof(bench_sphere), s->sphere_count);
        memcpy(need(to), s->spheres, s->sphere_count * sizeof(bench_sphere));
    } else {
        unsigned keys = b->deforming ? 2 : 1;
        void *to;
        rtcSetGeometryTimeStepCount(g, keys);
        for (unsigned k = 0; k < keys; k++) {
            to = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, k, RTC_FORMAT_FLOAT3,
                                         sizeof(vec3), s->position_count);
            memcpy(need(to), b->deforming ? b->keys + k * s->position_count : s->positions,
                   s->position_count * sizeof(vec3));
        }
        to = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                     3 * sizeof(uint32_t), s->index_count / 3);
        memcpy(need(to), s->indices, s->index_count * sizeof(uint32_t));
    }
    rtcCommitGeometry(g);
    rtcAttachGeometry(b->embree, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(b->embree);
    b->embree_build_seconds = time_seconds() - start;
}
#endif

/* ---- tracing one set of rays ---- */

static void trace_snell(const bench *b, snell_isa isa, const ray_set *set, hit *hits, bool shadow,
                        trace_counters *counters) {
    uint8_t blocked[BATCH];
    for (size_t i = 0; i < set->count; i += BATCH) {
        size_t n = set->count - i < BATCH ? set->count - i : BATCH;
        if (!shadow) {
            accel_trace(b->accel, isa, set->rays + i, hits + i, n, counters);
            continue;
        }
        accel_occluded(b->accel, isa, set->rays + i, blocked, n, counters);
        for (size_t j = 0; j < n; j++) hits[i + j].instance = blocked[j] ? 0 : NO_ID;
    }
}

#if BENCH_HAS_EMBREE
static void trace_embree(const bench *b, const ray_set *set, hit *hits, bool shadow) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < set->count; i++) {
        const ray *r = &set->rays[i];
        struct RTCRayHit q = {.ray = {r->o.x, r->o.y, r->o.z, r->t_min, r->d.x, r->d.y, r->d.z,
                                      r->time, r->t_max, ~0u, 0, 0},
                              .hit.geomID = RTC_INVALID_GEOMETRY_ID};
        if (shadow) {
            rtcOccluded1(b->embree, &context, &q.ray);
            hits[i].instance = q.ray.tfar < 0 ? 0 : NO_ID;
            continue;
        }
        rtcIntersect1(b->embree, &context, &q);
        bool found = q.hit.geomID != RTC_INVALID_GEOMETRY_ID, balls = b->scene.sphere_count > 0;
        hits[i] = (hit){.t = found ? q.ray.tfar : INFINITY,
                        .u = q.hit.u,
                        .v = q.hit.v,
                        .primitive = found ? (balls ? 0 : q.hit.primID) : NO_ID,
                        .instance = found ? (balls ? q.hit.primID : 0) : NO_ID};
    }
}
#endif

static void measure(bench *b, uint32_t kind, uint32_t tracer, uint32_t round) {
    ray_set *set = &b->sets[kind];
    double start = cpu_seconds();
    if (tracer != EMBREE)
        trace_snell(b, tracer_isas[tracer], set, set->hits[tracer], kind == SHADOW, NULL);
#if BENCH_HAS_EMBREE
    else
        trace_embree(b, set, set->hits[tracer], kind == SHADOW);
#endif
    set->mrays[tracer][round] = (double)set->count * 1e-6 / (cpu_seconds() - start);
    set->traced[tracer] = true;
}

static bool has_tracer(const bench *b, uint32_t tracer) {
    if (tracer == EMBREE) return BENCH_HAS_EMBREE && b->settings.embree;
    return accel_has_isa(tracer_isas[tracer]);
}

/* ---- rays ---- */

static void allocate_set(ray_set *set, size_t count) {
    set->rays = need(memory_aligned(count * sizeof *set->rays));
    for (uint32_t i = 0; i < TRACERS; i++) set->hits[i] = need(memory_zeroed(count, sizeof(hit)));
}

/* A pinhole in front of everything, pixel by pixel in blocks of 8 x 8. */
static void make_primary(bench *b) {
    ray_set *set = &b->sets[0];
    uint32_t n = b->settings.size;
    allocate_set(set, (size_t)n * n);
    dvec3 low = dvec3_from(b->bounds.min), high = dvec3_from(b->bounds.max);
    dvec3 center = dvec3_scale(dvec3_add(low, high), 0.5);
    double radius = 0.5 * dvec3_length(dvec3_sub(high, low));
    dvec3 back = dvec3_normalize((dvec3){1, 0.6, 1.4});
    dvec3 right = dvec3_normalize(dvec3_cross((dvec3){0, 1, 0}, back));
    dvec3 up = dvec3_cross(back, right);
    vec3 eye = vec3_from(dvec3_add(center, dvec3_scale(back, 2.4 * radius)));
    for (uint32_t i = 0; i < n * n; i++) {
        uint32_t block = i / 64, inside = i % 64;
        uint32_t x = block % (n / 8) * 8 + inside % 8, y = block / (n / 8) * 8 + inside / 8;
        double sx = 0.7 * ((x + 0.5) / n - 0.5), sy = 0.7 * (0.5 - (y + 0.5) / n);
        dvec3 d = dvec3_sub(dvec3_add(dvec3_scale(right, sx), dvec3_scale(up, sy)), back);
        set->rays[set->count] = ray_make(eye, vec3_from(dvec3_normalize(d)), 0, INFINITY);
        set->rays[set->count++].time = (float)(i * 2654435769u >> 8) * 0x1p-24f;
    }
}

static dvec3 vertex_at(const bench *b, uint32_t index, float time) {
    dvec3 from = dvec3_from(b->scene.positions[index]);
    if (b->deforming == NULL) return from;
    dvec3 to = dvec3_from(b->keys[b->scene.position_count + index]);
    return dvec3_add(from, dvec3_scale(dvec3_sub(to, from), (double)time));
}

static dvec3 normal_at(const bench *b, const hit *h, dvec3 p, float time) {
    const bench_scene *s = &b->scene;
    if (s->sphere_count)
        return dvec3_normalize(dvec3_sub(p, dvec3_from(s->spheres[h->instance].center)));
    const uint32_t *index = s->indices + 3 * (size_t)h->primitive;
    dvec3 v0 = vertex_at(b, index[0], time);
    return dvec3_normalize(dvec3_cross(dvec3_sub(vertex_at(b, index[1], time), v0),
                                       dvec3_sub(vertex_at(b, index[2], time), v0)));
}

/* From every primary hit, a little off the surface: to a light, and on along the mirror direction. */
static void make_secondary(bench *b) {
    ray_set *from = &b->sets[0], *shadow = &b->sets[1], *mirror = &b->sets[2];
    allocate_set(shadow, from->count);
    allocate_set(mirror, from->count);
    trace_snell(b, SNELL_ISA_AUTO, from, from->hits[0], false, NULL);
    dvec3 extent = dvec3_sub(dvec3_from(b->bounds.max), dvec3_from(b->bounds.min));
    double size = dvec3_length(extent);
    dvec3 light = dvec3_add(dvec3_from(b->bounds.max), dvec3_scale((dvec3){-0.3, 1, 0.2}, size));
    for (size_t i = 0; i < from->count; i++) {
        const hit *h = &from->hits[0][i];
        if (h->instance == NO_ID) continue;
        dvec3 d = dvec3_from(from->rays[i].d);
        dvec3 p = dvec3_add(dvec3_from(from->rays[i].o), dvec3_scale(d, h->t));
        dvec3 n = normal_at(b, h, p, from->rays[i].time);
        if (dvec3_dot(n, d) > 0) n = dvec3_negate(n);
        dvec3 o = dvec3_add(p, dvec3_scale(n, 1e-4 * size));
        dvec3 r = dvec3_sub(d, dvec3_scale(n, 2 * dvec3_dot(n, d)));
        vec3 to_light = vec3_from(dvec3_sub(light, o));
        shadow->rays[shadow->count++] = ray_make(vec3_from(o), to_light, 0, 1);
        mirror->rays[mirror->count++] = ray_make(vec3_from(o), vec3_from(r), 0, INFINITY);
        shadow->rays[shadow->count - 1].time = from->rays[i].time;
        mirror->rays[mirror->count - 1].time = from->rays[i].time;
    }
}

/* ---- results ---- */

/* Between our instruction sets every bit must agree. With Embree: hit or miss, and t to 1e-4. */
static size_t count_mismatches(const ray_set *set, uint32_t tracer) {
    size_t count = 0;
    for (size_t i = 0; i < set->count; i++) {
        const hit *a = &set->hits[0][i], *b = &set->hits[tracer][i];
        if (tracer != EMBREE)
            count += memcmp(a, b, sizeof *a) != 0;
        else if ((a->instance == NO_ID) != (b->instance == NO_ID))
            count++;
        else if (a->instance != NO_ID)
            count += fabsf(a->t - b->t) > 1e-4f * fabsf(a->t);
    }
    return count;
}

static void print_text(const bench *b) {
    accel_memory m = accel_get_memory(b->accel);
    size_t things = b->scene.sphere_count ? b->scene.sphere_count : b->scene.index_count / 3;
    printf("%s: %zu %s, %.1f bytes each (%.1f nodes, %.1f triangles, %.1f other), built in %.3f s",
           b->scene.name, things, b->scene.sphere_count ? "spheres" : "triangles",
           (double)(m.node_bytes + m.triangle_bytes + m.other_bytes) / (double)things,
           (double)m.node_bytes / (double)things, (double)m.triangle_bytes / (double)things,
           (double)m.other_bytes / (double)things, b->build_seconds);
    if (has_tracer(b, EMBREE)) printf(" (Embree %.3f s)", b->embree_build_seconds);
    printf("\n");
    for (uint32_t k = 0; k < KINDS; k++) {
        const ray_set *set = &b->sets[k];
        double n = (double)(set->count ? set->count : 1);
        printf("  %-8s %8zu rays; a ray: %.1f nodes, %.1f boxes, %.1f triangles, %.1f shapes\n",
               kind_names[k], set->count, (double)set->counters.nodes / n,
               (double)set->counters.boxes / n, (double)set->counters.triangles / n,
               (double)set->counters.primitives / n);
        double peer =
            set->traced[EMBREE] ? summarise(set->mrays[EMBREE], b->settings.rounds).median : 0;
        for (uint32_t t = 0; t < TRACERS; t++) {
            if (!set->traced[t]) {
                printf("    %-8s NOT TESTED\n", tracer_names[t]);
                continue;
            }
            summary s = summarise(set->mrays[t], b->settings.rounds);
            printf("    %-8s %7.2f Mrays/s (%.2f to %.2f)", tracer_names[t], s.median, s.low,
                   s.high);
            if (peer > 0 && t != EMBREE) printf("  %.2f of Embree", s.median / peer);
            printf("  %zu mismatches\n", count_mismatches(set, t));
        }
    }
}

static void print_json(const bench *b, bool first) {
    accel_memory m = accel_get_memory(b->accel);
    printf("%s{\"scene\":\"%s\",\"triangles\":%zu,\"spheres\":%zu,\"node_bytes\":%llu,"
           "\"triangle_bytes\":%llu,\"other_bytes\":%llu,\"build_seconds\":%.6f,"
           "\"embree_build_seconds\":%.6f,\"rays\":[",
           first ? "" : ",\n", b->scene.name, b->scene.index_count / 3, b->scene.sphere_count,
           (unsigned long long)m.node_bytes, (unsigned long long)m.triangle_bytes,
           (unsigned long long)m.other_bytes, b->build_seconds, b->embree_build_seconds);
    for (uint32_t k = 0; k < KINDS; k++) {
        const ray_set *set = &b->sets[k];
        printf("%s{\"kind\":\"%s\",\"count\":%zu,\"nodes\":%llu,\"boxes\":%llu,\"triangles\":%llu,"
               "\"primitives\":%llu,\"tracers\":[",
               k ? "," : "", kind_names[k], set->count, (unsigned long long)set->counters.nodes,
               (unsigned long long)set->counters.boxes, (unsigned long long)set->counters.triangles,
               (unsigned long long)set->counters.primitives);
        const char *comma = "";
        for (uint32_t t = 0; t < TRACERS; t++) {
            if (!set->traced[t]) continue;
            summary s = summarise(set->mrays[t], b->settings.rounds);
            printf("%s{\"name\":\"%s\",\"mrays_per_second\":%.4f,\"low\":%.4f,\"high\":%.4f,"
                   "\"mismatches\":%zu}",
                   comma, tracer_names[t], s.median, s.low, s.high, count_mismatches(set, t));
            comma = ",";
        }
        printf("]}");
    }
    printf("]}");
}

/* ---- one scene, and all ---- */

static void run(bench *b, bool first) {
    b->bounds = bench_scene_bounds(&b->scene);
    build(b);
#if BENCH_HAS_EMBREE
    if (b->settings.embree) build_embree(b);
#endif
    make_primary(b);
    make_secondary(b);
    for (uint32_t k = 0; k < KINDS; k++)
        trace_snell(b, SNELL_ISA_AUTO, &b->sets[k], b->sets[k].hits[0], k == SHADOW,
                    &b->sets[k].counters);
    for (uint32_t round = 0; round < b->settings.rounds; round++)
        for (uint32_t k = 0; k < KINDS; k++)
            for (uint32_t t = 0; t < TRACERS; t++)
                if (has_tracer(b, t)) measure(b, k, t, round);
    if (b->settings.json)
        print_json(b, first);
    else
        print_text(b);
}

static void clean(bench *b) {
#if BENCH_HAS_EMBREE
    if (b->settings.embree) {
        rtcReleaseScene(b->embree);
        rtcReleaseDevice(b->device);
    }
#endif
    for (uint32_t k = 0; k < KINDS; k++) {
        memory_free_aligned(b->sets[k].rays);
        for (uint32_t t = 0; t < TRACERS; t++) free(b->sets[k].hits[t]);
    }
    accel_destroy(b->accel);
    free(b->sphere_descs);
    free(b->keys);
    free(b->deforming);
    free(b->geometries);
    free(b->instances);
    bench_scene_free(&b->scene);
    free(b);
}

static bool make_scene(bench_scene *s, const char *name) {
    if (strcmp(name, "blob") == 0) return bench_scene_blob(s, 188, 188);
    if (strcmp(name, "blob-1m") == 0) return bench_scene_blob(s, 752, 752);
    if (strcmp(name, "balls") == 0) return bench_scene_balls(s, 4);
    return bench_scene_obj(s, name);
}

static uint32_t number(const char *text, uint32_t low, uint32_t high) {
    uint64_t value;
    if (!read_number(text, low, high, &value)) die("a number is wrong");
    return (uint32_t)value;
}

static const char usage[] = "usage: bench-kernel [--json] [--no-embree] [--deforming] [--size N] "
                            "[--rounds N] [--leaf-size N] [blob|blob-1m|balls|FILE.obj]...";

int main(int argc, char **argv) {
    settings s = {.size = 512, .rounds = 9, .embree = true};
    const char *names[16] = {"blob", "balls"};
    size_t count = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0)
            s.json = true;
        else if (strcmp(argv[i], "--no-embree") == 0)
            s.embree = false;
        else if (strcmp(argv[i], "--deforming") == 0)
            s.deforming = true;
        else if (strcmp(argv[i], "--size") == 0)
            s.size = number(argv[++i], 8, 8192) / 8 * 8;
        else if (strcmp(argv[i], "--rounds") == 0)
            s.rounds = number(argv[++i], 1, ROUNDS_MAX);
        else if (strcmp(argv[i], "--leaf-size") == 0)
            s.leaf_size = number(argv[++i], 1, 8);
        else if (argv[i][0] != '-' && count < 16)
            names[count++] = argv[i];
        else if (strcmp(argv[i], "--help") == 0) {
            printf("%s\n", usage);
            return 0;
        } else
            die(usage);
    }
    if (s.json) printf("[");
    for (size_t i = 0; i < (count ? count : 2); i++) {
        bench *b = need(memory_zeroed(1, sizeof *b));
        b->settings = s;
        if (!make_scene(&b->scene, names[i])) {
            fprintf(stderr, "bench-kernel: %s: %s\n", names[i], strerror(errno));
            return 1;
        }
        run(b, i == 0);
        clean(b);
    }
    if (s.json) printf("]\n");
    return 0;
}
