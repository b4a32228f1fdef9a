/* What a scene draws: shapes, and groups of them. A node is drawn unless a later call takes it; at
 * the end the nodes that are left are flattened to instances. Groups that are `shared`, and of a scene that
 * would draw more than FLAT_MAX shapes those that are drawn more than once, are kept as groups, each once. */
#include "importers/lua_scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/solids.h"

/* Groups in groups, with an instance around each, and a shape. */
enum { DEPTH_MAX = GROUP_DEPTH_MAX, PATH_MAX_NODES = 2 * DEPTH_MAX + 2 };
enum { FLAT_MAX = 1 << 16, PLACED_MAX = 4 << 20, NAME_SIZE = 256 };
#define LEAVES_MAX (UINT32_MAX - 1)

static void append(lua_State *L, const node *like) {
    lua_scene *s = scene_of(L);
    node made = *like;
    if (like->name && !(made.name = memory_copy_string(like->name)))
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    if (s->node_count >= UINT32_MAX - 1 ||
        !ARRAY_GROW(s->nodes, s->node_count, s->node_capacity, 1)) {
        free(made.name);
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    }
    s->nodes[s->node_count++] = made;
    handle_push(L, HANDLE_SHAPE, (uint32_t)(s->node_count - 1));
}

void nodes_add_shape(lua_State *L, const node *like) {
    node made = *like;
    made.leaf_count = 1;
    append(L, &made);
}

void nodes_add_group(lua_State *L, const node *like, const char *label, const uint32_t *indices,
                     size_t count) {
    lua_scene *s = scene_of(L);
    node made = *like;
    made.shape = NO_SHAPE;
    made.first_child = s->child_count;
    made.child_count = count;
    if (!ARRAY_GROW(s->children, s->child_count, s->child_capacity, count))
        scene_fail(L, SNELL_ERR_MEMORY, NULL, "out of memory");
    for (size_t i = 0; i < count; i++) {
        node *child = &s->nodes[indices[i]];
        child->taken = true;
        made.leaf_count += child->leaf_count;
        /* An instance places a group, and adds no depth unless it places another instance. */
        bool adds = !like->overrides || child->overrides;
        if (child->depth + adds > made.depth) made.depth = child->depth + adds;
        child->uses++;
        s->children[s->child_count++] = indices[i];
    }
    if (made.depth > DEPTH_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "put parts into one group instead of groups in groups",
                   "%s: nested more than %d deep", label, DEPTH_MAX);
    if (made.leaf_count > LEAVES_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "draw fewer copies", "%s: draws more than %u shapes", label,
                   LEAVES_MAX);
    append(L, &made);
}

/* ---- walking ---- */

/* What a leaf inherits on the way down to it. */
typedef struct inherited {
    placement placed;
    uint32_t path[PATH_MAX_NODES]; /* nodes, the leaf's last */
    size_t depth;
    bool moves;
    uint32_t forced, usual; /* materials: of an instance, over all; of a group, for what has none */
    char name[NAME_SIZE];   /* of the groups, joined by '/' */
} inherited;

/* leaf: a shape, or a group that is kept; then `from` is what comes to it from above. */
typedef void leaf_fn(lua_State *L, void *user, const node *leaf, const inherited *from);

static void join_name(char *names, const char *name) {
    if (name == NULL) return;
    size_t used = strlen(names);
    snprintf(names + used, NAME_SIZE - used, "%s%s", used ? "/" : "", name);
}

/* The recursion ends: depth is checked where groups are made. */
static void walk(lua_State *L, uint32_t index, const inherited *above, leaf_fn *leaf, void *user) {
    lua_scene *s = scene_of(L);
    const node *n = &s->nodes[index];
    if (n->kept && above->depth > 0) { /* not the one whose parts are walked */
        leaf(L, user, n, above);
        return;
    }
    inherited here = *above;
    here.path[here.depth++] = index; /* a leaf under DEPTH_MAX groups is the last that fits */
    if (n->motion) {
        here.moves = true;
        here.placed = dtransform_multiply(&here.placed, &s->motions[n->motion - 1].now);
    }
    here.placed = dtransform_multiply(&here.placed, &n->placed);
    join_name(here.name, n->name);
    if (n->material != NO_MATERIAL) {
        if (n->overrides && here.forced == NO_MATERIAL) here.forced = n->material;
        if (!n->overrides) here.usual = n->material;
    }
    if (n->shape != NO_SHAPE) {
        leaf(L, user, n, &here);
        return;
    }
    for (size_t i = 0; i < n->child_count; i++)
        walk(L, s->children[n->first_child + i], &here, leaf, user);
}

static inherited nothing_above(void) {
    return (inherited){
        .placed = dtransform_identity(), .forced = NO_MATERIAL, .usual = NO_MATERIAL};
}

static void add_bounds(lua_State *L, void *user, const node *leaf, const inherited *from) {
    const description *d = scene_of(L)->d;
    const object *o = &d->objects[CATEGORY_SHAPE].items[leaf->shape];
    bounds3 *sum = user;
    transform placed = dtransform_round(&from->placed), identity = transform_identity();
    bounds3 own = shape_bounds(d, leaf->shape, &identity);
    if (bounds_are_finite(own)) *sum = bounds3_union(*sum, transform_bounds(&placed, own));
    /* Computed anew each time. */
    const primitive_type *type = (const primitive_type *)o->type;
    sandbox_charge(L, primitive_count_of(type, o->desc));
    if (type == &primitive_solid)
        sandbox_charge(L, 16 * (uint64_t)shape_part_count(d, leaf->shape));
}

/* A node's box in the space that it stands in. Of a large group each node is looked at once, so the
 * box may be larger than that of its shapes. */
static bounds3 large_box(lua_State *L, uint32_t index) {
    lua_scene *s = scene_of(L);
    node *n = &s->nodes[index];
    dtransform placed = n->placed;
    if (n->motion) placed = dtransform_multiply(&s->motions[n->motion - 1].now, &placed);
    if (n->shape != NO_SHAPE) {
        bounds3 sum = bounds3_empty();
        inherited above = nothing_above();
        walk(L, index, &above, add_bounds, &sum);
        return sum;
    }
    if (!n->has_box) {
        bounds3 all = bounds3_empty();
        sandbox_charge(L, 16 * (uint64_t)n->child_count);
        for (size_t i = 0; i < n->child_count; i++)
            all = bounds3_union(all, large_box(L, s->children[n->first_child + i]));
        n->box = all;
        n->has_box = true;
    }
    transform rounded = dtransform_round(&placed);
    return transform_bounds(&rounded, n->box);
}

bounds3 nodes_bounds(lua_State *L, uint32_t index) {
    bounds3 sum = bounds3_empty();
    if (scene_of(L)->nodes[index].leaf_count > FLAT_MAX) {
        sum = large_box(L, index);
        if (!bounds3_is_empty(sum)) return sum;
    }
    inherited above = nothing_above();
    sandbox_charge(L, 16 * scene_of(L)->nodes[index].leaf_count);
    walk(L, index, &above, add_bounds, &sum);
    if (bounds3_is_empty(sum))
        scene_fail(L, SNELL_ERR_SYNTAX, "a plane goes on for ever; a quad has bounds",
                   "bounds of something that has none");
    return sum;
}

typedef struct leaf_visit {
    node_leaf_fn *visit;
    void *user;
} leaf_visit;

static void visit_leaf(lua_State *L, void *user, const node *leaf, const inherited *from) {
    const leaf_visit *v = user;
    node here = *leaf;
    here.material = from->forced != NO_MATERIAL ? from->forced : from->usual;
    here.placed = from->placed;
    v->visit(L, v->user, &here, from->moves);
}

void nodes_each_leaf(lua_State *L, uint32_t index, node_leaf_fn *visit, void *user) {
    inherited above = nothing_above();
    leaf_visit v = {visit, user};
    walk(L, index, &above, visit_leaf, &v);
}

static void add_instance(lua_State *L, void *user, const node *leaf, const inherited *from) {
    uint32_t owner = *(const uint32_t *)user;
    lua_scene *s = scene_of(L);
    if (s->d->instance_count >= PLACED_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "draw one group of them often",
                   "the scene places more than %d shapes one by one", PLACED_MAX);
    uint32_t shape = leaf->kept ? leaf->group : leaf->shape;
    uint32_t material = from->forced != NO_MATERIAL ? from->forced : from->usual;
    transform placed = dtransform_round(&from->placed);
    object_source source = {from->name, s->path, leaf->line};
    uint32_t made, line = leaf->line;
    snell_status status = description_add_instance(s->d, shape, material, &placed, source, &made);
    if (!status) s->d->instances[made].fills = leaf->kept && from->forced == NO_MATERIAL;
    if (!status && owner != NO_GROUP) status = description_set_owner(s->d, made, owner);
    if (!status && from->moves) {
        size_t count;
        const motion_key *keys = motion_of_chain(L, from->path, from->depth, &count);
        status = description_set_motion(s->d, made, keys, count);
        lua_pop(L, 1);
    }
    if (status) {
        error_place((source_place){s->path, line, 0});
        scene_fail_last(L, NULL, NULL);
    }
}

/* Which groups are kept: those that are to be, and in a large scene what is drawn often, of at least two
 * shapes; parts come before their groups.
 * Where the description's groups would be too deep, the outer ones are flattened. */
static void keep_groups(lua_State *L, bool large) {
    lua_scene *s = scene_of(L);
    inherited above = nothing_above();
    for (size_t i = 0; i < s->node_count; i++) {
        node *n = &s->nodes[i];
        for (size_t k = 0; k < n->child_count; k++) {
            uint32_t below = s->nodes[s->children[n->first_child + k]].kept_depth;
            if (below > n->kept_depth) n->kept_depth = below;
        }
        bool often = large && n->uses >= 2 && n->leaf_count >= 2;
        if (!(often || n->shared) || n->kept_depth == GROUP_DEPTH_MAX) continue;
        object_source source = {.file = s->path, .line = n->line};
        if (description_add_empty_group(s->d, source, &n->group)) scene_fail_last(L, NULL, NULL);
        n->kept_depth++;
        n->kept = true;
        walk(L, (uint32_t)i, &above, add_instance, &n->group);
    }
}

void nodes_draw(lua_State *L) {
    lua_scene *s = scene_of(L);
    motion_sample_functions(L);
    uint64_t total = 0;
    for (size_t i = 0; i < s->node_count; i++)
        if (!s->nodes[i].taken) total += s->nodes[i].leaf_count;
    if (total > LEAVES_MAX)
        scene_fail(L, SNELL_ERR_SYNTAX, "draw fewer copies", "the scene draws more than %u shapes",
                   LEAVES_MAX);
    /* What is included becomes nodes of the program that includes it. */
    if (s->parent == NULL) keep_groups(L, total > FLAT_MAX);
    inherited above = nothing_above();
    uint32_t world = NO_GROUP;
    for (size_t i = 0; i < s->node_count; i++)
        if (!s->nodes[i].taken) walk(L, (uint32_t)i, &above, add_instance, &world);
}

void nodes_free(lua_scene *s) {
    for (size_t i = 0; i < s->node_count; i++) free(s->nodes[i].name);
    free(s->nodes);
    free(s->children);
    free(s->framings);
    motion_free_all(s);
}

/* ---- group, instance ---- */

static const char *const common_names[] = {"material", "transform", "name", "motion", "shared"};

uint32_t *nodes_read_parts(lua_State *L, const char *label, size_t count) {
    uint32_t *parts = lua_newuserdatauv(L, (count + 1) * sizeof *parts, 0);
    for (size_t i = 0; i < count; i++) {
        lua_rawgeti(L, 1, (lua_Integer)i + 1);
        if (!handle_get(L, -1, HANDLE_SHAPE, &parts[i])) {
            const char *kind = sandbox_tostring(L, -1);
            char hint[96];
            snprintf(hint, sizeof hint, "such as %s { sphere { radius = 1 } }", label);
            scene_fail(L, SNELL_ERR_SYNTAX, hint, "%s: value %d must be a shape, not %s", label,
                       (int)i + 1, kind);
        }
        lua_pop(L, 1);
    }
    return parts;
}

static int make_group(lua_State *L) {
    const char *name;
    values_need_table(L, "group");
    size_t count = (size_t)lua_rawlen(L, 1);
    sandbox_charge(L, 4 * (uint64_t)count);
    values_check_keys(L, "group", common_names, 5, (lua_Integer)count);
    node made = objects_read_common(L, "group", &name);
    made.shared = values_get_bool(L, "group", "shared", false);
    uint32_t *parts = nodes_read_parts(L, "group", count);
    nodes_add_group(L, &made, "group", parts, count);
    return 1;
}

/* Its material, where given, replaces those of the parts: the same chair in red and in blue. */
static int make_instance(lua_State *L) {
    const char *name;
    values_need_table(L, "instance");
    values_check_keys(L, "instance", common_names, 4, 1);
    node made = objects_read_common(L, "instance", &name);
    uint32_t *part = nodes_read_parts(L, "instance", 1);
    made.overrides = true;
    nodes_add_group(L, &made, "instance", part, 1);
    return 1;
}

static int shape_index(lua_State *L) {
    uint32_t index;
    if (!handle_get(L, 1, HANDLE_SHAPE, &index)) return luaL_error(L, "not a shape");
    const char *member = lua_tostring(L, 2);
    if (member == NULL || strcmp(member, "bounds") != 0) {
        const char *names[] = {"bounds"};
        scene_fail_unknown(L, "shape", "a shape has no member", member ? member : "?", names, 1);
    }
    bounds3 b = nodes_bounds(L, index);
    double low[3] = {(double)b.min.x, (double)b.min.y, (double)b.min.z};
    double high[3] = {(double)b.max.x, (double)b.max.y, (double)b.max.z};
    static const char *const members[] = {"min", "max", "center", "size"};
    lua_createtable(L, 0, 4);
    for (int m = 0; m < 4; m++) {
        lua_createtable(L, 3, 0);
        for (int i = 0; i < 3; i++) {
            double values[] = {low[i], high[i], (low[i] + high[i]) / 2, high[i] - low[i]};
            lua_pushnumber(L, values[m]);
            lua_rawseti(L, -2, i + 1);
        }
        lua_setfield(L, -2, members[m]);
    }
    sandbox_guard(L, "bounds");
    return 1;
}

void nodes_open(lua_State *L) {
    lua_pushcfunction(L, make_group);
    lua_setglobal(L, "group");
    lua_pushcfunction(L, make_instance);
    lua_setglobal(L, "instance");
    static const char *const kinds[] = {HANDLE_SHAPE, HANDLE_MATERIAL, HANDLE_TEXTURE};
    for (int i = 0; i < 3; i++) {
        luaL_newmetatable(L, kinds[i]);
        lua_pushboolean(L, false);
        lua_setfield(L, -2, "__metatable");
        if (i == 0) {
            lua_pushcfunction(L, shape_index);
            lua_setfield(L, -2, "__index");
        }
        if (i == 2) {
            lua_pushcfunction(L, texture_multiply);
            lua_setfield(L, -2, "__mul");
        }
        lua_pop(L, 1);
    }
}
