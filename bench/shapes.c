/* Rays per second of every registered shape, on one thread: alone, and a thousand of it scattered.
 *
 *     bench-shapes [--rays N] [--rounds N] [--copies N] [--isa NAME] [--json] [SHAPE]...
 *
 * The shapes are the registry's; an example of each is made by shapes.lua, or else it has its
 * defaults. Alone: rays from a sphere around its box to random points of the box. Scattered: copies
 * turned at random, in a cube as wide as 30 of their half diagonals, and rays to random points of the
 * cube. The shapes take turns in every round. Times are CPU time of tracing alone, without shading. */
#include <stdio.h>

#include "../tests/random_numbers.h"
#include "api/api.h"
#include "base/memory.h"
#include "measure.h"

enum { SETS = 2, ALONE = 0, SCATTERED = 1, BATCH = 1024, SHAPES_MAX = 64 };
static const char *const set_names[SETS] = {"alone", "scattered"};
static const double half_diagonals = 30; /* the cube's side */

typedef struct settings {
    uint32_t rays, rounds, copies;
    snell_isa isa;
    bool json;
} settings;

typedef struct ray_set {
    accel *accel; /* NULL: not traced */
    ray *rays;
    size_t hits;
    trace_counters counters;
    double mrays[ROUNDS_MAX];
} ray_set;

typedef struct subject {
    const primitive_type *registered;
    snell_scene *scene;   /* of shapes.lua; NULL: it has its defaults */
    accel_geometry shape; /* as rays meet it */
    void *own_desc, *own_prepared;
    bool defaults;
    uint32_t parts; /* or triangles */
    ray_set sets[SETS];
} subject;

static void die(const char *what) {
    fprintf(stderr, "bench-shapes: %s\n", what);
    exit(1);
}

static void die_of(const subject *s, const char *what) {
    fprintf(stderr, "bench-shapes: %s: %s\n", s->registered->info.name, what);
    exit(1);
}

static void *need(void *memory) {
    if (memory == NULL) die("out of memory");
    return memory;
}

/* ---- shapes ---- */

static void use_defaults(subject *s) {
    const primitive_type *type = s->registered;
    s->own_desc = need(memory_zeroed(1, type->info.desc_size));
    desc_init(&type->info, s->own_desc);
    s->defaults = true;
    if (type == &primitive_solid || desc_check(&type->info, s->own_desc, NULL) ||
        (type->check && type->check(s->own_desc)))
        die_of(s, "its defaults are no shape: it needs an example in bench/shapes.lua");
    if (type->prepare) s->own_prepared = need(type->prepare(s->own_desc));
    s->shape =
        (accel_geometry){.type = type, .desc = s->own_prepared ? s->own_prepared : s->own_desc};
}

static void find_shape(subject *s, snell_context *context) {
    char param[128];
    snprintf(param, sizeof param, "shape=%s", s->registered->info.name);
    const char *params[] = {param};
    snell_load_desc load = snell_load_desc_init(sizeof load);
    load.params = params;
    load.param_count = 1;
    if (snell_scene_create(context, &s->scene) ||
        snell_scene_load(s->scene, BENCH_SOURCE_DIR "/shapes.lua", &load) ||
        snell_scene_commit(s->scene, NULL, NULL))
        die_of(s, snell_last_error()->text);
    const scene *made = s->scene->frozen;
    if (made->instance_count == 0) {
        use_defaults(s);
        return;
    }
    if (made->instance_count != 1) die_of(s, "shapes.lua makes more than one shape of it");
    const scene_instance *only = &made->instances[0];
    const object *as = &s->scene->description->objects[CATEGORY_SHAPE].items[only->shape_index];
    if ((const primitive_type *)as->type != s->registered)
        die_of(s, "shapes.lua makes another shape of it");
    s->shape = (accel_geometry){.type = only->type, .desc = only->shape};
}

static bounds3 box_of(const subject *s) {
    bounds3 box = {{-1, -1, -1}, {1, 1, 1}};
    if (s->shape.type->unbounded) return box;
    box = bounds3_empty();
    if (s->shape.type->intersect == NULL) {
        const mesh_desc *mesh = s->shape.desc;
        for (size_t i = 0; i < mesh->indices_count; i++)
            box = bounds3_add_point(box, mesh->positions[mesh->indices[i]]);
        return box;
    }
    uint32_t count = primitive_count_of(s->shape.type, s->shape.desc);
    for (uint32_t i = 0; i < count; i++)
        box = bounds3_union(box, primitive_bounds_of(s->shape.type, s->shape.desc, i));
    return box;
}

/* ---- where they stand, and rays ---- */

static dvec3 random_direction(rng *r) {
    for (;;) {
        dvec3 d = dvec3_from(rng_vec3(r, 1));
        double length = dvec3_length(d);
        if (length > 0.1 && length < 1) return dvec3_scale(d, 1 / length);
    }
}

static dvec3 random_point(rng *r, dvec3 low, dvec3 high) {
    double x = rng_unit(r), y = rng_unit(r), z = rng_unit(r);
    return (dvec3){low.x + (high.x - low.x) * x, low.y + (high.y - low.y) * y,
                   low.z + (high.z - low.z) * z};
}

/* Turned about its middle, which comes to `at`. */
static transform random_place(rng *r, dvec3 middle, dvec3 at) {
    dvec3 z = random_direction(r), x, y;
    dvec3_frame(z, &x, &y);
    transform turn = {{{(float)x.x, (float)y.x, (float)z.x, 0},
                       {(float)x.y, (float)y.y, (float)z.y, 0},
                       {(float)x.z, (float)y.z, (float)z.z, 0}}};
    dvec3 shift = dvec3_sub(at, transform_vector(&turn, middle));
    turn.m[0][3] = (float)shift.x;
    turn.m[1][3] = (float)shift.y;
    turn.m[2][3] = (float)shift.z;
    return turn;
}

static void make_rays(ray_set *set, dvec3 low, dvec3 high, uint32_t count) {
    rng r = {11};
    set->rays = need(memory_aligned(count * sizeof *set->rays));
    dvec3 middle = dvec3_scale(dvec3_add(low, high), 0.5);
    double radius = dvec3_length(dvec3_sub(high, low));
    for (uint32_t i = 0; i < count; i++) {
        dvec3 target = random_point(&r, low, high);
        dvec3 from = dvec3_add(middle, dvec3_scale(random_direction(&r), radius));
        dvec3 d = dvec3_normalize(dvec3_sub(target, from));
        set->rays[i] = ray_make(vec3_from(from), vec3_from(d), 0, INFINITY);
    }
}

static accel *build(const subject *s, const accel_instance *instances, size_t count) {
    accel_input input = {&s->shape, 1, instances, count};
    accel_options options = {0};
    accel *out;
    if (accel_build(&input, &options, NULL, &out)) die_of(s, error_last()->text);
    return out;
}

static void prepare_sets(subject *s, const settings *t) {
    bounds3 box = box_of(s);
    dvec3 low = dvec3_from(box.min), high = dvec3_from(box.max);
    dvec3 middle = dvec3_scale(dvec3_add(low, high), 0.5);
    double half = dvec3_length(dvec3_sub(high, low)) / 2;
    accel_instance one = {0, ~0u, true, transform_identity(), transform_identity(), NULL};
    s->sets[ALONE].accel = build(s, &one, 1);
    make_rays(&s->sets[ALONE], low, high, t->rays);
    if (s->shape.type->unbounded) return;
    rng r = {5};
    double side = half_diagonals * half;
    dvec3 corner = {side / 2, side / 2, side / 2}, opposite = dvec3_negate(corner);
    accel_instance *copies = need(memory_zeroed(t->copies, sizeof *copies));
    for (uint32_t i = 0; i < t->copies; i++) {
        copies[i] = one;
        copies[i].identity = false;
        copies[i].to_world = random_place(&r, middle, random_point(&r, opposite, corner));
        if (!transform_inverse(&copies[i].to_world, &copies[i].to_local)) die("a turn is singular");
    }
    s->sets[SCATTERED].accel = build(s, copies, t->copies);
    free(copies);
    make_rays(&s->sets[SCATTERED], opposite, corner, t->rays);
}

/* ---- measuring ---- */

/* counters: NULL where time counts. Returns how many rays hit. */
static size_t trace(const ray_set *set, const settings *t, trace_counters *counters) {
    hit hits[BATCH];
    size_t found = 0;
    for (size_t i = 0; i < t->rays; i += BATCH) {
        size_t n = t->rays - i < BATCH ? t->rays - i : BATCH;
        accel_trace(set->accel, t->isa, set->rays + i, hits, n, counters);
        for (size_t j = 0; j < n; j++) found += hits[j].instance != NO_ID;
    }
    return found;
}

static void measure(ray_set *set, const settings *t, uint32_t round) {
    double start = cpu_seconds();
    size_t hits = trace(set, t, NULL);
    set->mrays[round] = (double)t->rays * 1e-6 / (cpu_seconds() - start);
    if (hits != set->hits) die("the same rays hit another number of times");
}

static void measure_all(subject *subjects, uint32_t count, const settings *t) {
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < SETS; k++)
            if (subjects[i].sets[k].accel)
                subjects[i].sets[k].hits =
                    trace(&subjects[i].sets[k], t, &subjects[i].sets[k].counters);
    for (uint32_t round = 0; round < t->rounds; round++)
        for (uint32_t i = 0; i < count; i++)
            for (int k = 0; k < SETS; k++)
                if (subjects[i].sets[k].accel) measure(&subjects[i].sets[k], t, round);
}

/* ---- results ---- */

static void print_text(const subject *subjects, uint32_t count, const settings *t) {
    printf("%u rays, %u rounds, 1 thread, %s; scattered: %u copies\n", t->rays, t->rounds,
           snell_isa_name(accel_best_isa(t->isa)), t->copies);
    printf("%-15s %8s %-10s %8s %19s %6s %7s %7s %9s\n", "shape", "parts", "", "Mrays/s",
           "least .. most", "hit", "nodes", "boxes", "tests/ray");
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < SETS; k++) {
            const subject *s = &subjects[i];
            const ray_set *set = &s->sets[k];
            if (set->accel == NULL) continue;
            summary m = summarise(set->mrays, t->rounds);
            double n = t->rays;
            char spread[32];
            snprintf(spread, sizeof spread, "(%.3f .. %.3f)", m.low, m.high);
            printf("%-15s %8u %-10s %8.3f %19s %5.1f%% %7.2f %7.2f %9.2f%s\n",
                   s->registered->info.name, s->parts, set_names[k], m.median, spread,
                   100 * (double)set->hits / n, (double)set->counters.nodes / n,
                   (double)set->counters.boxes / n,
                   (double)(set->counters.triangles + set->counters.primitives) / n,
                   s->defaults ? "  (defaults)" : "");
        }
}

static void print_json(const subject *subjects, uint32_t count, const settings *t) {
    printf("{\"rays\":%u,\"rounds\":%u,\"copies\":%u,\"isa\":\"%s\",\"shapes\":[", t->rays,
           t->rounds, t->copies, snell_isa_name(accel_best_isa(t->isa)));
    for (uint32_t i = 0; i < count; i++) {
        printf("%s{\"name\":\"%s\",\"defaults\":%s,\"parts\":%u", i ? ",\n" : "",
               subjects[i].registered->info.name, subjects[i].defaults ? "true" : "false",
               subjects[i].parts);
        for (int k = 0; k < SETS; k++) {
            const ray_set *set = &subjects[i].sets[k];
            if (set->accel == NULL) continue;
            summary m = summarise(set->mrays, t->rounds);
            printf(",\"%s\":{\"mrays_per_second\":%.4f,\"low\":%.4f,\"high\":%.4f,\"hits\":%zu,"
                   "\"nodes\":%llu,\"boxes\":%llu,\"triangles\":%llu,\"primitives\":%llu}",
                   set_names[k], m.median, m.low, m.high, set->hits,
                   (unsigned long long)set->counters.nodes, (unsigned long long)set->counters.boxes,
                   (unsigned long long)set->counters.triangles,
                   (unsigned long long)set->counters.primitives);
        }
        printf("}");
    }
    printf("]}\n");
}

/* ---- all ---- */

static void make_subject(subject *s, snell_context *context, const settings *t) {
    find_shape(s, context);
    const mesh_desc *mesh = s->shape.type->intersect ? NULL : s->shape.desc;
    s->parts = mesh ? (uint32_t)mesh_triangle_count(mesh)
                    : primitive_count_of(s->shape.type, s->shape.desc);
    prepare_sets(s, t);
}

static void clear_subject(subject *s) {
    for (int k = 0; k < SETS; k++) {
        accel_destroy(s->sets[k].accel);
        memory_free_aligned(s->sets[k].rays);
    }
    snell_scene_destroy(s->scene);
    if (s->own_prepared && s->registered->release) s->registered->release(s->own_prepared);
    free(s->own_desc);
}

static uint32_t number(const char *text, uint32_t low, uint32_t high) {
    uint64_t value;
    if (!read_number(text, low, high, &value)) die("a number is missing or wrong");
    return (uint32_t)value;
}

static snell_isa isa_of(const char *text) {
    for (int i = SNELL_ISA_AUTO; text && i <= SNELL_ISA_AVX512; i++)
        if (strcmp(text, snell_isa_name((snell_isa)i)) == 0) {
            if (i != SNELL_ISA_AUTO && !accel_has_isa((snell_isa)i)) die("not on this machine");
            return (snell_isa)i;
        }
    die("--isa takes auto, scalar, avx2 or avx512");
    return SNELL_ISA_AUTO;
}

static void add_subject(subject *subjects, uint32_t *count, const primitive_type *type) {
    if (type == NULL) die("there is no such shape");
    if (*count == SHAPES_MAX) die("too many shapes");
    subjects[(*count)++] = (subject){.registered = type};
}

static const char usage[] = "usage: bench-shapes [--rays N] [--rounds N] [--copies N] [--isa NAME] "
                            "[--json] [SHAPE]...";

int main(int argc, char **argv) {
    static subject subjects[SHAPES_MAX];
    settings t = {.rays = 50000, .rounds = 9, .copies = 1000};
    uint32_t count = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0)
            t.json = true;
        else if (strcmp(argv[i], "--rays") == 0)
            t.rays = number(argv[++i], 1, 100000000);
        else if (strcmp(argv[i], "--rounds") == 0)
            t.rounds = number(argv[++i], 1, ROUNDS_MAX);
        else if (strcmp(argv[i], "--copies") == 0)
            t.copies = number(argv[++i], 1, 1000000);
        else if (strcmp(argv[i], "--isa") == 0)
            t.isa = isa_of(argv[++i]);
        else if (strcmp(argv[i], "--help") == 0) {
            printf("%s\n", usage);
            return 0;
        } else if (argv[i][0] != '-')
            add_subject(subjects, &count, primitive_find(argv[i]));
        else
            die(usage);
    }
    if (count == 0)
        for (uint32_t i = 0; i < primitive_type_count; i++)
            add_subject(subjects, &count, primitive_types[i]);
    snell_context *context;
    if (snell_context_create(NULL, &context)) die(snell_last_error()->text);
    for (uint32_t i = 0; i < count; i++) make_subject(&subjects[i], context, &t);
    unsigned saved = floatenv_enter();
    measure_all(subjects, count, &t);
    floatenv_leave(saved);
    if (t.json)
        print_json(subjects, count, &t);
    else
        print_text(subjects, count, &t);
    for (uint32_t i = 0; i < count; i++) clear_subject(&subjects[i]);
    snell_context_destroy(context);
    return 0;
}
