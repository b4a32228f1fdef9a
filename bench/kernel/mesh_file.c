/* The triangles of any file that snell reads, where they stand at time 0. */
#include "api/api.h"
#include "parts.h"

static bool is_wanted(const scene_instance *part) {
    return part->group != NO_ID || mesh_is(part->type);
}

typedef struct gathering {
    bench_scene *to;
    const scene *from;
} gathering;

static snell_status add_mesh(void *user, uint32_t number, const scene_instance *part) {
    const gathering *g = user;
    transform place = scene_instance_transform(g->from, number, 0);
    if (part->type == &primitive_deforming) bench_die("a mesh that deforms: not measured");
    const mesh_desc *mesh = part->shape;
    uint32_t first = (uint32_t)g->to->position_count;
    for (size_t i = 0; i < mesh->positions_count; i++)
        bench_add_vertex(g->to, transform_point(&place, dvec3_from(mesh->positions[i])));
    for (size_t i = 0; i + 2 < mesh->indices_count; i += 3)
        bench_add_triangle(g->to, first + mesh->indices[i], first + mesh->indices[i + 1],
                           first + mesh->indices[i + 2]);
    return SNELL_OK;
}

void bench_scene_file(bench_scene *s, const char *path) {
    snell_context *context = NULL;
    snell_scene *loaded = NULL;
    if (snell_context_create(NULL, &context) || snell_scene_create(context, &loaded) ||
        snell_scene_load(loaded, path, NULL) || snell_scene_commit(loaded, NULL, NULL))
        bench_die(snell_last_error()->text);
    gathering g = {s, loaded->frozen};
    if (scene_each_shape(loaded->frozen, is_wanted, add_mesh, &g)) bench_die(error_last()->text);
    snell_scene_destroy(loaded);
    snell_context_destroy(context);
    if (s->index_count == 0) bench_die("the file has no triangles");
}
