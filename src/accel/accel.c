/* Building both levels, and handing rays to a kernel. */
#include "accel/accel.h"

#include <stdlib.h>
#include <string.h>

#include "accel/build.h"
#include "accel/kernels/kernel.h"
#include "base/memory.h"
#include "simd/cpu.h"

/* Shapes of fewer parts are built several at a time, each by one thread. */
enum { SMALL_TREE = 16384, LEAF_SIZE_DEFAULT = 8 };

typedef struct tree_builds {
    accel *accel;
    const uint32_t *geometries; /* which */
    snell_status *status;       /* of each */
    const accel_options *options;
    build_progress *progress;
} tree_builds;

static bool is_mesh(const primitive_type *type) { return type->intersect == NULL; }
static bool has_tree(const primitive_type *type) { return type->primitive_count != NULL; }

static uint32_t leaf_size(const accel_options *options) {
    uint32_t size = options ? options->leaf_size : 0;
    if (size == 0) size = LEAF_SIZE_DEFAULT;
    return size < BVH_WIDTH ? size : BVH_WIDTH;
}

static snell_status build_geometry(frozen_geometry *g, const accel_options *options,
                                   build_progress *progress, thread_pool *pool, bool reports) {
    const mesh_desc *mesh = is_mesh(g->type) ? g->desc : NULL;
    build_job job = {.mesh = mesh,
                     .leaf_size = mesh ? leaf_size(options) : 1,
                     .seed = options ? options->seed : 0,
                     .progress = progress};
    if (mesh)
        job.references = build_mesh_references(mesh, &job.count, &g->bounds);
    else
        job.references = build_part_references(g->type, g->desc, &job.count, &g->bounds);
    if (job.references == NULL) return SNELL_ERR_MEMORY;
    snell_status status = job.count ? build_tree(&job, pool, reports, &g->tree) : SNELL_OK;
    free(job.references);
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
        if (!g->used || !has_tree(g->type)) continue;
        if (primitive_count_of(g->type, g->desc) < SMALL_TREE)
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

static snell_status copy_geometries(accel *a, const accel_input *input) {
    a->geometries = memory_zeroed(input->geometry_count, sizeof *a->geometries);
    if (a->geometries == NULL) return SNELL_ERR_MEMORY;
    a->geometry_count = input->geometry_count;
    for (size_t i = 0; i < input->instance_count; i++)
        a->geometries[input->instances[i].geometry].used = true;
    for (size_t i = 0; i < input->geometry_count; i++) {
        frozen_geometry *g = &a->geometries[i];
        g->type = input->geometries[i].type;
        g->desc = input->geometries[i].desc;
        if (!has_tree(g->type) && !g->type->unbounded) g->bounds = g->type->bounds(g->desc);
    }
    return SNELL_OK;
}

/* Also lists the boundless ones, and gives references to all others that are not empty. */
static snell_status copy_instances(accel *a, const accel_input *input, build_reference *references,
                                   size_t *reference_count) {
    a->instances = memory_zeroed(input->instance_count, sizeof *a->instances);
    a->unbounded = memory_resize(NULL, input->instance_count, sizeof *a->unbounded);
    if (a->instances == NULL || a->unbounded == NULL) return SNELL_ERR_MEMORY;
    a->instance_count = input->instance_count;
    for (size_t i = 0; i < input->instance_count; i++) {
        const accel_instance *from = &input->instances[i];
        const frozen_geometry *g = &a->geometries[from->geometry];
        bool in_parts = has_tree(g->type) && !is_mesh(g->type);
        a->instances[i] = (frozen_instance){.type = g->type,
                                            .desc = g->desc,
                                            .mesh = is_mesh(g->type) ? &g->tree : NULL,
                                            .parts = in_parts ? &g->tree : NULL,
                                            .mask = from->mask,
                                            .identity = from->identity,
                                            .flat = g->type->flat,
                                            .bounds = g->bounds,
                                            .moves = from->moves,
                                            .to_local = from->to_local};
        if (g->type->unbounded) {
            a->unbounded[a->unbounded_count++] = (uint32_t)i;
            continue;
        }
        bounds3 box = from->moves      ? motion_bounds(from->moves, g->bounds)
                      : from->identity ? g->bounds
                                       : transform_bounds(&from->to_world, g->bounds);
        if (!bounds3_is_empty(box))
            references[(*reference_count)++] = (build_reference){box.min, (uint32_t)i, box.max, 0};
    }
    return SNELL_OK;
}

static snell_status build_top(accel *a, const accel_input *input, const accel_options *options,
                              build_progress *progress, thread_pool *pool) {
    build_reference *references = memory_resize(NULL, input->instance_count, sizeof *references);
    size_t count = 0;
    snell_status status =
        references ? copy_instances(a, input, references, &count) : SNELL_ERR_MEMORY;
    if (status == SNELL_OK && count > 0) {
        build_job job = {references, count, NULL, 1, options ? options->seed : 0, progress};
        status = build_tree(&job, pool, true, &a->top);
    }
    if (count == 0) a->top.bounds = bounds3_empty();
    free(references);
    return status;
}

static snell_status build_all(accel *a, const accel_input *input, const accel_options *options,
                              thread_pool *pool) {
    build_progress progress = {.options = options, .total = input->instance_count};
    snell_status status = copy_geometries(a, input);
    for (size_t i = 0; i < a->geometry_count && status == SNELL_OK; i++)
        if (a->geometries[i].used && has_tree(a->geometries[i].type))
            progress.total += primitive_count_of(a->geometries[i].type, a->geometries[i].desc);
    if (status == SNELL_OK && !build_progress_report(&progress)) status = SNELL_CANCELLED;
    if (status == SNELL_OK) status = build_trees(a, options, &progress, pool);
    if (status == SNELL_OK) status = build_top(a, input, options, &progress, pool);
    return status;
}

snell_status accel_build(const accel_input *input, const accel_options *options, thread_pool *pool,
                         accel **out) {
    if (input->instance_count >= BVH_LEAF || input->geometry_count >= UINT32_MAX)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "more than %u instances", BVH_LEAF - 1);
    for (size_t i = 0; i < input->instance_count; i++)
        if (input->instances[i].geometry >= input->geometry_count)
            return error_set(SNELL_ERR_ARGUMENT, NULL, "instance %zu: there is no geometry %u", i,
                             input->instances[i].geometry);
    accel *a = memory_zeroed(1, sizeof *a);
    if (a == NULL) return error_no_memory();
    snell_status status = build_all(a, input, options, pool);
    if (status != SNELL_OK) {
        accel_destroy(a);
        return status == SNELL_ERR_MEMORY ? error_no_memory()
                                          : error_set(status, NULL, "the build was cancelled");
    }
    *out = a;
    return SNELL_OK;
}

void accel_destroy(accel *a) {
    if (a == NULL) return;
    for (size_t i = 0; i < a->geometry_count; i++) build_tree_free(&a->geometries[i].tree);
    build_tree_free(&a->top);
    free(a->geometries);
    free(a->instances);
    free(a->unbounded);
    free(a);
}

bounds3 accel_bounds(const accel *a) { return a->top.bounds; }

accel_memory accel_get_memory(const accel *a) {
    accel_memory m = {.node_bytes = a->top.node_count * sizeof *a->top.nodes,
                      .other_bytes =
                          sizeof *a + a->geometry_count * sizeof *a->geometries +
                          a->instance_count * (sizeof *a->instances + sizeof *a->unbounded)};
    for (size_t i = 0; i < a->geometry_count; i++) {
        const frozen_geometry *g = &a->geometries[i];
        m.node_bytes += g->tree.node_count * sizeof *g->tree.nodes;
        m.triangle_bytes += g->tree.block_count * sizeof *g->tree.blocks;
        if (g->used && is_mesh(g->type)) m.triangle_count += mesh_triangle_count(g->desc);
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
