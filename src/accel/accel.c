/* Building all levels, and handing rays to a kernel. */
#include "accel/accel.h"

#include <stdlib.h>
#include <string.h>

#include "accel/build.h"
#include "accel/kernels/kernel.h"
#include "base/memory.h"
#include "geometry/sphere.h"
#include "simd/cpu.h"

const char *const accel_quality_names[ACCEL_QUALITIES] = {"balanced", "fast", "best"};

typedef struct tree_builds {
    accel *accel;
    const uint32_t *geometries; /* which */
    snell_status *status;       /* of each */
    const accel_options *options;
    build_progress *progress;
} tree_builds;

static bool is_deforming(const primitive_type *type) { return type == &primitive_deforming; }
static bool is_mesh(const primitive_type *type) {
    return type->intersect == NULL && !is_deforming(type);
}
static bool has_tree(const primitive_type *type) { return type->primitive_count != NULL; }

static uint32_t leaf_size(const accel_options *options) {
    uint32_t size = options ? options->leaf_size : 0;
    if (size == 0) size = BUILD_LEAF_SIZE;
    return size < BVH_WIDTH ? size : BVH_WIDTH;
}

static snell_status build_geometry(frozen_geometry *g, const accel_options *options,
                                   build_progress *progress, thread_pool *pool, bool reports) {
    const deforming_mesh *deforming = is_deforming(g->type) ? g->desc : NULL;
    const mesh_desc *mesh = deforming ? &deforming->mesh : is_mesh(g->type) ? g->desc : NULL;
    build_way *ways = NULL;
    build_job job = {.mesh = mesh,
                     .leaf_size = mesh ? leaf_size(options) : 1,
                     .seed = options ? options->seed : 0,
                     .quality = options ? options->quality : ACCEL_BALANCED,
                     .progress = progress};
    if (deforming)
        job.references = build_deforming_references(deforming, &job.count, &g->bounds, &ways);
    else if (mesh)
        job.references = build_mesh_references(mesh, pool, &job.count, &g->bounds);
    else
        job.references = build_part_references(g->type, g->desc, &job.count, &g->bounds);
    if (job.references == NULL) {
        free(ways);
        return SNELL_ERR_MEMORY;
    }
    job.ways = ways;
    snell_status status = SNELL_OK;
    if (job.count)
        status = build_tree(&job, pool, reports, &g->tree);
    else
        memory_free_aligned(job.references);
    free(ways);
    if (deforming && status == SNELL_OK && job.count) {
        if (!build_tree_at_keys(deforming, pool, &g->tree)) return SNELL_ERR_MEMORY;
        g->tree.bounds = g->bounds;
    }
    if (mesh && status == SNELL_OK && job.count)
        build_widen(&g->tree, deforming ? deforming->key_count : 1, pool);
    return status;
}

static void build_small_tree(void *data, size_t index, uint32_t worker) {
    tree_builds *t = data;
    if (atomic_load(&t->progress->stop))
        t->status[index] = SNELL_CANCELLED;
    else
        t->status[index] = build_geometry(&t->accel->geometries[t->geometries[index]], t->options,
                                          t->progress, NULL, worker == 0);
}

/* The small ones side by side, the large ones one after the other with all threads each. */
static snell_status build_trees(accel *a, const accel_options *options, build_progress *progress,
                                thread_pool *pool) {
    uint32_t *small = memory_resize(NULL, a->geometry_count, sizeof *small);
    snell_status *results = memory_zeroed(a->geometry_count, sizeof *results);
    snell_status status = small && results ? SNELL_OK : SNELL_ERR_MEMORY;
    size_t small_count = 0;
    for (size_t i = 0; i < a->geometry_count && status == SNELL_OK; i++) {
        frozen_geometry *g = &a->geometries[i];
        if (!g->used || g->type == NULL || !has_tree(g->type)) continue;
        if (primitive_count_of(g->type, g->desc) < BUILD_SMALL)
            small[small_count++] = (uint32_t)i;
        else
            status = build_geometry(g, options, progress, pool, true);
    }
    if (status == SNELL_OK) {
        tree_builds t = {a, small, results, options, progress};
        if (pool) thread_pool_run(pool, small_count, build_small_tree, &t);
        for (size_t i = 0; i < small_count && !pool; i++) build_small_tree(&t, i, 0);
    }
    for (size_t i = 0; i < small_count && status == SNELL_OK; i++) status = results[i];
    free(small);
    free(results);
    return status;
}

/* What instances draw, and how deep groups nest in them; limit: only geometries before it exist. */
static snell_status count_shapes(const accel *a, const accel_instance *instances, size_t count,
                                 size_t limit, uint64_t *shapes, uint32_t *depth) {
    *shapes = 0;
    *depth = 0;
    if (count >= BVH_LEAF)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "more than %u instances", BVH_LEAF - 1);
    for (size_t i = 0; i < count; i++) {
        if (instances[i].geometry >= limit)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "instance %zu: there is no geometry %u", i,
                             instances[i].geometry);
        const frozen_geometry *g = &a->geometries[instances[i].geometry];
        *shapes += g->shape_count;
        if (g->depth > *depth) *depth = g->depth;
        if (*shapes >= NO_ID)
            return error_set(SNELL_ERR_ARGUMENT, "draw fewer copies",
                             "groups of groups draw more than %u shapes", NO_ID - 1);
    }
    return SNELL_OK;
}

static void mark_used(accel *a, const accel_instance *instances, size_t count) {
    for (size_t i = 0; i < count; i++) a->geometries[instances[i].geometry].used = true;
}

static snell_status copy_geometries(accel *a, const accel_input *input) {
    a->geometries = memory_zeroed(input->geometry_count, sizeof *a->geometries);
    if (a->geometries == NULL) return error_no_memory();
    a->geometry_count = input->geometry_count;
    for (size_t i = 0; i < input->geometry_count; i++) {
        const accel_geometry *from = &input->geometries[i];
        frozen_geometry *g = &a->geometries[i];
        *g = (frozen_geometry){.type = from->type, .desc = from->desc, .shape_count = 1};
        if (g->type) continue;
        snell_status status =
            count_shapes(a, from->parts, from->part_count, i, &g->shape_count, &g->depth);
        if (status) return status;
        if (++g->depth > GROUP_DEPTH_MAX)
            return error_set(SNELL_ERR_ARGUMENT, "put parts into one group",
                             "groups are nested more than %d deep", GROUP_DEPTH_MAX);
    }
    uint64_t shapes;
    uint32_t depth;
    snell_status status = count_shapes(a, input->instances, input->instance_count,
                                       input->geometry_count, &shapes, &depth);
    if (status) return status;
    mark_used(a, input->instances, input->instance_count);
    for (size_t i = input->geometry_count; i-- > 0;) { /* groups come after what they mark */
        frozen_geometry *g = &a->geometries[i];
        if (g->type == NULL && g->used)
            mark_used(a, input->geometries[i].parts, input->geometries[i].part_count);
        if (g->used && g->type && !has_tree(g->type) && !g->type->unbounded)
            g->bounds = g->type->bounds(g->desc);
    }
    return SNELL_OK;
}

/* The box in which an instance's rays may find it. Rays are rounded on their way into a group and in
 * it: the boxes allow for that. */
static bounds3 instance_box(const accel_instance *from, const frozen_geometry *g, bool in_group) {
    bool widened = in_group || g->type == NULL;
    if (from->moves) {
        bounds3 box = motion_bounds(from->moves, g->bounds);
        for (uint32_t i = 0; i < from->moves->count && widened; i++) {
            const transform *to_world = &from->moves->steps[i].transform;
            transform to_local;
            if (transform_inverse(to_world, &to_local))
                box = bounds3_union(box, transform_bounds_widened(to_world, &to_local, g->bounds));
        }
        return box;
    }
    if (from->identity) return g->bounds;
    return widened ? transform_bounds_widened(&from->to_world, &from->to_local, g->bounds)
                   : transform_bounds(&from->to_world, g->bounds);
}

static bool is_unbounded(const frozen_geometry *g) {
    return g->type ? g->type->unbounded : g->level.unbounded_count > 0;
}

static void outline_of(const frozen_instance *in, frozen_outline *out) {
    *out = (frozen_outline){.first = in->first};
    if (!in->plain || in->type != &primitive_sphere) return;
    const sphere_desc *sphere = in->desc;
    memcpy(out->center, &sphere->center, sizeof out->center);
    out->radius = sphere->radius;
    out->sphere_mask = in->mask;
}

/* Also lists the boundless ones, and gives references to all others that are not empty. */
static snell_status copy_instances(const accel *a, const accel_instance *instances, size_t count,
                                   bool in_group, frozen_level *level, build_reference *references,
                                   size_t *reference_count) {
    level->instances = memory_zeroed(count, sizeof *level->instances);
    level->unbounded = memory_resize(NULL, count, sizeof *level->unbounded);
    level->outlines = memory_aligned(count * sizeof *level->outlines);
    if (!level->instances || !level->unbounded || !level->outlines) return SNELL_ERR_MEMORY;
    level->instance_count = count;
    level->bounds = bounds3_empty();
    uint64_t first = 0;
    for (size_t i = 0; i < count; i++) {
        const accel_instance *from = &instances[i];
        const frozen_geometry *g = &a->geometries[from->geometry];
        bool is_group = g->type == NULL;
        bool in_parts = !is_group && has_tree(g->type) && !is_mesh(g->type);
        level->instances[i] =
            (frozen_instance){.type = g->type,
                              .desc = g->desc,
                              .mesh = !is_group && is_mesh(g->type) ? &g->tree : NULL,
                              .parts = in_parts ? &g->tree : NULL,
                              .group = is_group ? &g->level : NULL,
                              .mask = from->mask,
                              .first = (uint32_t)first,
                              .identity = from->identity,
                              .flat = !is_group && g->type->flat,
                              .plain = from->identity && !is_group && !has_tree(g->type),
                              .bounds = g->bounds,
                              .moves = from->moves,
                              .to_local = from->to_local};
        outline_of(&level->instances[i], &level->outlines[i]);
        first += g->shape_count;
        if (is_unbounded(g)) level->unbounded[level->unbounded_count++] = (uint32_t)i;
        if (g->type && g->type->unbounded) continue;
        bounds3 box = bounds3_is_empty(g->bounds) ? g->bounds : instance_box(from, g, in_group);
        if (bounds3_is_empty(box)) continue;
        level->bounds = bounds3_union(level->bounds, box);
        if (!is_unbounded(g))
            references[(*reference_count)++] = (build_reference){box.min, (uint32_t)i, box.max, 0};
    }
    return SNELL_OK;
}

/* The world, or a group whose geometries are built. */
static snell_status build_level(const accel *a, const accel_instance *instances,
                                size_t instance_count, bool in_group, const accel_options *options,
                                build_progress *progress, thread_pool *pool, frozen_level *out) {
    build_reference *references = build_references(instance_count);
    size_t count = 0;
    snell_status status =
        references ? copy_instances(a, instances, instance_count, in_group, out, references, &count)
                   : SNELL_ERR_MEMORY;
    if (status == SNELL_OK && count > 0) {
        build_job job = {.references = references,
                         .count = count,
                         .leaf_size = 1,
                         .seed = options ? options->seed : 0,
                         .quality = options ? options->quality : ACCEL_BALANCED,
                         .progress = progress};
        status = build_tree(&job, pool, true, &out->top);
    } else {
        out->top.bounds = bounds3_empty();
        memory_free_aligned(references);
    }
    out->small = out->top.node_count <= 1;
    for (size_t i = 0; status == SNELL_OK && out->small && i < instance_count; i++)
        out->small = out->instances[i].mesh == NULL;
    return status;
}

/* Each stands on geometries before it. */
static snell_status build_groups(accel *a, const accel_input *input, const accel_options *options,
                                 build_progress *progress, thread_pool *pool) {
    snell_status status = SNELL_OK;
    for (size_t i = 0; i < a->geometry_count && !status; i++) {
        frozen_geometry *g = &a->geometries[i];
        const accel_geometry *from = &input->geometries[i];
        if (g->type != NULL || !g->used) continue;
        status =
            build_level(a, from->parts, from->part_count, true, options, progress, pool, &g->level);
        g->bounds = g->level.bounds;
    }
    return status;
}

static snell_status build_all(accel *a, const accel_input *input, const accel_options *options,
                              thread_pool *pool) {
    build_progress progress = {.options = options, .total = input->instance_count};
    for (size_t i = 0; i < a->geometry_count; i++) {
        const frozen_geometry *g = &a->geometries[i];
        if (!g->used) continue;
        if (g->type == NULL)
            progress.total += input->geometries[i].part_count;
        else if (has_tree(g->type))
            progress.total += primitive_count_of(g->type, g->desc);
    }
    snell_status status = build_progress_report(&progress) ? SNELL_OK : SNELL_CANCELLED;
    if (status == SNELL_OK) status = build_trees(a, options, &progress, pool);
    if (status == SNELL_OK) status = build_groups(a, input, options, &progress, pool);
    if (status == SNELL_OK)
        status = build_level(a, input->instances, input->instance_count, false, options, &progress,
                             pool, &a->world);
    return status;
}

snell_status accel_build(const accel_input *input, const accel_options *options, thread_pool *pool,
                         accel **out) {
    if (input->geometry_count >= UINT32_MAX)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "more than %u shapes", UINT32_MAX - 1);
    accel *a = memory_zeroed(1, sizeof *a);
    if (a == NULL) return error_no_memory();
    snell_status status = copy_geometries(a, input);
    if (status == SNELL_OK) {
        status = build_all(a, input, options, pool);
        if (status == SNELL_ERR_MEMORY) error_no_memory();
        if (status == SNELL_CANCELLED) error_set(status, NULL, "the build was cancelled");
    }
    if (status != SNELL_OK) {
        accel_destroy(a);
        return status;
    }
    *out = a;
    return SNELL_OK;
}

static void free_level(frozen_level *level) {
    build_tree_free(&level->top);
    free(level->instances);
    memory_free_aligned(level->outlines);
    free(level->unbounded);
}

void accel_destroy(accel *a) {
    if (a == NULL) return;
    for (size_t i = 0; i < a->geometry_count; i++) {
        build_tree_free(&a->geometries[i].tree);
        free_level(&a->geometries[i].level);
    }
    free_level(&a->world);
    free(a->geometries);
    free(a);
}

bounds3 accel_bounds(const accel *a) { return a->world.bounds; }

static void add_level_memory(accel_memory *m, const frozen_level *level) {
    m->node_bytes += level->top.node_count * sizeof *level->top.nodes;
    m->other_bytes += level->instance_count * (sizeof *level->instances + sizeof *level->outlines +
                                               sizeof *level->unbounded);
}

accel_memory accel_get_memory(const accel *a) {
    accel_memory m = {.other_bytes = sizeof *a + a->geometry_count * sizeof *a->geometries};
    add_level_memory(&m, &a->world);
    for (size_t i = 0; i < a->geometry_count; i++) {
        const frozen_geometry *g = &a->geometries[i];
        bool deforming = g->type && is_deforming(g->type);
        uint64_t keys = deforming ? ((const deforming_mesh *)g->desc)->key_count : 1;
        m.node_bytes += keys * g->tree.node_count * sizeof *g->tree.nodes;
        m.triangle_bytes += keys * g->tree.block_count * sizeof *g->tree.blocks;
        add_level_memory(&m, &g->level);
        if (g->used && g->type && mesh_is(g->type))
            m.triangle_count += primitive_count_of(g->type, g->desc);
    }
    return m;
}

/* ---- instruction sets ---- */

snell_isa accel_best_isa(snell_isa max) {
    snell_isa best = SNELL_HAS_SIMD ? cpu_best_isa() : SNELL_ISA_SCALAR;
    return max != SNELL_ISA_AUTO && max < best ? max : best;
}

bool accel_has_isa(snell_isa isa) {
    return isa >= SNELL_ISA_SCALAR && isa <= accel_best_isa(SNELL_ISA_AUTO);
}

static const trace_kernel *kernel_for(snell_isa isa) {
#if SNELL_HAS_SIMD
    if (isa == SNELL_ISA_AVX512) return &trace_kernel_avx512;
    if (isa == SNELL_ISA_AVX2) return &trace_kernel_avx2;
#endif
    (void)isa;
    return &trace_kernel_scalar;
}

void accel_trace(const accel *a, snell_isa isa, const ray *rays, hit *hits, size_t count,
                 trace_counters *counters) {
    kernel_for(accel_best_isa(isa))->trace(a, rays, hits, count, counters);
}

void accel_occluded(const accel *a, snell_isa isa, const ray *rays, uint8_t *blocked, size_t count,
                    trace_counters *counters) {
    kernel_for(accel_best_isa(isa))->occluded(a, rays, blocked, count, counters);
}
