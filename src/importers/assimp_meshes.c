/* Meshes and the node tree. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "importers/assimp_reader.h"
#include "importers/up.h"

enum { INSTANCES_MAX = 10000000, DEPTH_MAX = 10000 };

typedef struct arrays {
    snell_vec3 *positions, *normals, *colors;
    snell_vec2 *uvs;
    uint32_t *indices;
} arrays;

static void arrays_deinit(arrays *a) {
    free(a->positions);
    free(a->normals);
    free(a->colors);
    free(a->uvs);
    free(a->indices);
}

/* libassimp marks the normals of points and lines, which no triangle uses, with NaN. */
static void clear_nans(snell_vec3 *normals, size_t count) {
    for (size_t i = 0; normals && i < count; i++)
        if (!isfinite(normals[i].x + normals[i].y + normals[i].z))
            normals[i] = (snell_vec3){0, 0, 0};
}

static snell_vec3 *copy_vectors(const struct aiVector3D *in, size_t count) {
    snell_vec3 *out = memory_resize(NULL, count + 1, sizeof *out);
    for (size_t i = 0; out && i < count; i++)
        out[i] = (snell_vec3){(float)in[i].x, (float)in[i].y, (float)in[i].z};
    return out;
}

static float positive(double value) { return value > 0 && value < 1e6 ? (float)value : 0; }

static snell_vec3 *copy_colors(const struct aiColor4D *in, size_t count) {
    snell_vec3 *out = memory_resize(NULL, count + 1, sizeof *out);
    for (size_t i = 0; out && i < count; i++)
        out[i] = (snell_vec3){positive((double)in[i].r), positive((double)in[i].g),
                              positive((double)in[i].b)};
    return out;
}

/* The triangles of a mesh; *count indices. Some readers leave odd faces in. */
static snell_status copy_indices(const struct aiMesh *m, uint32_t **out, size_t *count) {
    uint32_t *indices = memory_resize(NULL, 3 * (size_t)m->mNumFaces + 1, sizeof *indices);
    if (indices == NULL) return error_no_memory();
    size_t used = 0;
    for (unsigned i = 0; i < m->mNumFaces; i++) {
        const struct aiFace *face = &m->mFaces[i];
        if (face->mNumIndices != 3 || face->mIndices == NULL) continue;
        for (int k = 0; k < 3; k++) indices[used++] = face->mIndices[k];
    }
    *out = indices;
    *count = used;
    return SNELL_OK;
}

static snell_status add_shape(reader *r, const struct aiMesh *m, const arrays *a,
                              size_t index_count, uint32_t *shape) {
    char name[NAME_MAX_SIZE], what[300];
    snell_status status = names_make_unique(&r->names, CATEGORY_SHAPE, m->mName.data, name);
    if (status) return status;
    size_t count = m->mNumVertices;
    mesh_desc desc = {.struct_size = sizeof desc,
                      .positions = a->positions,
                      .positions_count = count,
                      .indices = a->indices,
                      .indices_count = index_count,
                      .normals = a->normals,
                      .normals_count = a->normals ? count : 0,
                      .uvs = a->uvs,
                      .uvs_count = a->uvs ? count : 0,
                      .colors = a->colors,
                      .colors_count = a->colors ? count : 0};
    object_source source = {name[0] ? name : NULL, r->path, 0};
    status = description_add_desc(r->d, type_find(CATEGORY_SHAPE, "mesh"), &desc, source, shape);
    snprintf(what, sizeof what, "mesh '%s'", name);
    return reader_blame(r, what, status);
}

static snell_status read_mesh(reader *r, const struct aiMesh *m, uint32_t *shape) {
    *shape = NO_SHAPE;
    if (m->mVertices == NULL || m->mFaces == NULL) return SNELL_OK;
    size_t count = m->mNumVertices, index_count = 0;
    arrays a = {0};
    snell_status status = copy_indices(m, &a.indices, &index_count);
    if (!status && index_count > 0) {
        a.positions = copy_vectors(m->mVertices, count);
        bool failed = a.positions == NULL;
        if (m->mNormals) failed |= (a.normals = copy_vectors(m->mNormals, count)) == NULL;
        clear_nans(a.normals, count);
        if (m->mColors[0]) failed |= (a.colors = copy_colors(m->mColors[0], count)) == NULL;
        if (m->mTextureCoords[0]) {
            a.uvs = memory_resize(NULL, count + 1, sizeof *a.uvs);
            failed |= a.uvs == NULL;
            for (size_t i = 0; a.uvs && i < count; i++)
                a.uvs[i] = (snell_vec2){(float)m->mTextureCoords[0][i].x,
                                        (float)m->mTextureCoords[0][i].y};
        }
        status = failed ? error_no_memory() : add_shape(r, m, &a, index_count, shape);
    }
    arrays_deinit(&a);
    return status;
}

/* ---- the tree ---- */

static transform node_local(const struct aiNode *node) {
    const struct aiMatrix4x4 *m = &node->mTransformation;
    return (transform){{{(float)m->a1, (float)m->a2, (float)m->a3, (float)m->a4},
                        {(float)m->b1, (float)m->b2, (float)m->b3, (float)m->b4},
                        {(float)m->c1, (float)m->c2, (float)m->c3, (float)m->c4}}};
}

static snell_status draw_node(reader *r, const struct aiNode *node, const transform *world) {
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        unsigned mesh = node->mMeshes[i];
        if (mesh >= r->scene->mNumMeshes || r->shapes[mesh] == NO_SHAPE) continue;
        unsigned material = r->scene->mMeshes[mesh]->mMaterialIndex;
        uint32_t used = material < r->scene->mNumMaterials ? r->materials[material] : NO_MATERIAL;
        if (++r->instance_count > INSTANCES_MAX)
            return error_set(SNELL_ERR_UNSUPPORTED, NULL, "there are more than %d instances",
                             INSTANCES_MAX);
        char name[NAME_MAX_SIZE], what[300];
        const char *wanted = r->scene->mMeshes[mesh]->mName.data;
        snell_status status = names_make_unique(&r->names, NAMES_INSTANCE,
                                                wanted[0] ? wanted : node->mName.data, name);
        if (status) return status;
        transform inverse;
        snprintf(what, sizeof what, "node '%.200s'", node->mName.data);
        if (!transform_inverse(world, &inverse)) {
            status = reader_warn(r, "%s: a flat or infinite transform: not drawn", what);
        } else {
            object_source source = {name[0] ? name : NULL, r->path, 0};
            uint32_t index;
            status = description_add_instance(r->d, r->shapes[mesh], used, world, source, &index);
        }
        if (status) return reader_blame(r, what, status);
    }
    return SNELL_OK;
}

static snell_status draw_tree(reader *r, const struct aiNode *node, const transform *parent,
                              int depth) {
    if (depth > DEPTH_MAX)
        return error_set(SNELL_ERR_UNSUPPORTED, NULL, "nodes are nested too deeply");
    transform local = node_local(node), world = transform_multiply(parent, &local);
    snell_status status = draw_node(r, node, &world);
    for (unsigned i = 0; i < node->mNumChildren && !status; i++)
        status = draw_tree(r, node->mChildren[i], &world, depth + 1);
    return status;
}

snell_status reader_read_meshes(reader *r) {
    const struct aiScene *scene = r->scene;
    snell_status status = SNELL_OK;
    for (unsigned i = 0; i < scene->mNumMeshes && !status; i++)
        status = read_mesh(r, scene->mMeshes[i], &r->shapes[i]);
    if (status) return status;
    transform up;
    import_up_rotation(r->options->up, &up);
    if (scene->mRootNode) status = draw_tree(r, scene->mRootNode, &up, 0);
    if (!status && r->instance_count == 0)
        return error_set(SNELL_ERR_SYNTAX, NULL, "the file has no surfaces%s",
                         scene->mNumMeshes > 0 ? ", only points or lines" : "");
    return status;
}
