/* Rays of the caller's own. */
#include "api/api.h"

enum { CHUNK = 256, TASK = 4096 };

static ray convert_ray(const snell_ray *in) {
    ray r = ray_make(in->origin, in->direction, in->t_min, in->t_max);
    r.time = in->time;
    r.mask = in->mask ? MASK_ALL : 0;
    return r;
}

static void convert_hit(const snell_scene *s, const ray *r, const hit *in, snell_hit *out) {
    *out = (snell_hit){.t = INFINITY};
    if (in->instance == NO_ID) return;
    shade_point p;
    scene_shade_point(s->frozen, r, in, &p);
    const scene *frozen = s->frozen;
    shape_path path;
    scene_find_path(frozen, in->instance, r->time, &path);
    uint32_t index = frozen->instance_ids[path.levels[0] - frozen->instances];
    out->t = in->t;
    out->u = in->u;
    out->v = in->v;
    out->primitive = in->primitive;
    out->instance = (snell_instance_id){index + 1, s->description->instances[index].generation};
    out->number = in->instance;
    out->normal = vec3_from(p.outside ? p.n : dvec3_negate(p.n));
}

/* SNELL_ERR_UNSUPPORTED: a solid met more than it can hold, for which hits lack it. */
static snell_status intersect(const snell_scene *s, const snell_ray *rays, snell_hit *hits,
                              size_t count) {
    ray converted[CHUNK];
    hit found[CHUNK];
    solid_take_spent();
    for (size_t start = 0; start < count; start += CHUNK) {
        size_t n = count - start < CHUNK ? count - start : CHUNK;
        for (size_t i = 0; i < n; i++) converted[i] = convert_ray(&rays[start + i]);
        accel_trace(s->frozen->accel, s->context->isa, converted, found, n, NULL);
        for (size_t i = 0; i < n; i++) convert_hit(s, &converted[i], &found[i], &hits[start + i]);
    }
    return solid_take_spent() ? solid_error_spent() : SNELL_OK;
}

static snell_status begin_query(const snell_scene *s, const void *rays, const void *results,
                                size_t count) {
    if (count > 0 && (rays == NULL || results == NULL))
        return error_set(SNELL_ERR_ARGUMENT, NULL, "rays or results is NULL");
    return scene_begin_read(s);
}

snell_status snell_scene_intersect(const snell_scene *s, const snell_ray *rays, snell_hit *hits,
                                   size_t count) {
    snell_status status = begin_query(s, rays, hits, count);
    if (status) return status;
    unsigned saved = floatenv_enter();
    status = intersect(s, rays, hits, count);
    floatenv_leave(saved);
    scene_end_read(s);
    return status;
}

snell_status snell_scene_get_path(const snell_scene *s, const snell_hit *found,
                                  snell_instance_id *path, uint32_t *count) {
    if (found == NULL || path == NULL || count == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "an argument is NULL");
    snell_status status = scene_begin_read(s);
    if (status) return status;
    const scene *frozen = s->frozen;
    *count = 0;
    if (found->instance.index1 == 0 || found->number >= frozen->shape_count) {
        status = error_set(SNELL_ERR_ARGUMENT, "pass what snell_scene_intersect wrote",
                           "a miss, or a hit of another commit");
    } else {
        shape_path way;
        scene_find_path(frozen, found->number, 0, &way);
        for (uint32_t i = 0; i < way.count; i++) {
            uint32_t id = frozen->instance_ids[way.levels[i] - frozen->instances];
            if (id != NO_ID)
                path[(*count)++] =
                    (snell_instance_id){id + 1, s->description->instances[id].generation};
        }
    }
    scene_end_read(s);
    return status;
}

typedef struct query {
    const snell_scene *scene;
    const snell_ray *rays;
    snell_hit *hits;
    size_t count;
    _Atomic bool spent;
} query;

static void intersect_part(void *data, size_t index, uint32_t worker) {
    (void)worker;
    query *q = data;
    size_t start = index * TASK, n = q->count - start < TASK ? q->count - start : TASK;
    if (intersect(q->scene, q->rays + start, q->hits + start, n)) q->spent = true;
}

snell_status snell_scene_intersect_all(const snell_scene *s, const snell_ray *rays, snell_hit *hits,
                                       size_t count) {
    snell_status status = begin_query(s, rays, hits, count);
    if (status) return status;
    unsigned saved = floatenv_enter();
    query q = {s, rays, hits, count, false};
    thread_pool_run(s->context->pool, (count + TASK - 1) / TASK, intersect_part, &q);
    floatenv_leave(saved);
    scene_end_read(s);
    return q.spent ? solid_error_spent() : SNELL_OK;
}

snell_status snell_scene_occluded(const snell_scene *s, const snell_ray *rays, uint8_t *blocked,
                                  size_t count) {
    snell_status status = begin_query(s, rays, blocked, count);
    if (status) return status;
    unsigned saved = floatenv_enter();
    ray converted[CHUNK];
    solid_take_spent();
    for (size_t start = 0; start < count; start += CHUNK) {
        size_t n = count - start < CHUNK ? count - start : CHUNK;
        for (size_t i = 0; i < n; i++) converted[i] = convert_ray(&rays[start + i]);
        accel_occluded(s->frozen->accel, s->context->isa, converted, blocked + start, n, NULL);
    }
    floatenv_leave(saved);
    scene_end_read(s);
    return solid_take_spent() ? solid_error_spent() : SNELL_OK;
}
