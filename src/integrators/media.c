#include "integrators/media.h"

#include "maths/functions.h"

static const medium vacuum = {.ior = 1, .ior_by_color = {1, 1, 1}};

const medium *media_current(const media *m, const scene *s) {
    const medium *current = NULL;
    for (uint32_t i = 0; i < m->count; i++) {
        const medium *here = &scene_part(s, m->instances[i])->inside;
        if (current == NULL || here->priority >= current->priority) current = here;
    }
    return current ? current : &vacuum;
}

bool media_enter(media *m, uint32_t id) {
    if (m->count == MEDIA_MAX) return false;
    m->instances[m->count++] = id;
    return true;
}

bool media_leave(media *m, uint32_t id) {
    for (uint32_t i = m->count; i-- > 0;) {
        if (m->instances[i] != id) continue;
        for (uint32_t j = i + 1; j < m->count; j++) m->instances[j - 1] = m->instances[j];
        m->count--;
        return true;
    }
    return false;
}

/* The distance may be infinite. */
static double optical_depth(double absorption, double distance) {
    return absorption > 0 ? absorption * distance : 0;
}

dvec3 media_transmittance(const media *m, const scene *s, double distance) {
    const medium *current = media_current(m, s);
    dvec3 a = current->absorption;
    if (!(dvec3_largest(a) > 0)) return (dvec3){1, 1, 1};
    double depth[3] = {-optical_depth(a.x, distance), -optical_depth(a.y, distance),
                       -optical_depth(a.z, distance)};
    double through[3];
    fn_exp3(depth, through);
    return (dvec3){through[0], through[1], through[2]};
}

typedef struct half_spaces {
    const scene *s;
    dvec3 p;
    float time;
    media *m;
} half_spaces;

static bool is_half_space(const scene_instance *at) { return at->bounds_half; }

static snell_status enter_half_space(void *user, uint32_t number, const scene_instance *part) {
    const half_spaces *h = user;
    posed_instance room;
    const scene_instance *at = scene_posed(h->s, number, h->time, &room);
    if (part->type->side(part->shape, transform_point(&at->to_local, h->p)) > 0)
        media_enter(h->m, number);
    return SNELL_OK;
}

/* Walks from p to infinity. A closed surface that is left more often than entered surrounds p. */
media media_around(const scene *s, snell_isa isa, vec3 p, float time) {
    media m = {0};
    if (!s->has_media) return m;
    half_spaces around_p = {s, dvec3_from(p), time, &m};
    scene_each_shape(s, is_half_space, enter_half_space, &around_p);
    /* An irregular direction, so that the walk meets no edge of what people build. A surface that
     * is left without having been entered on the way surrounds p; the innermost is left first. */
    ray r = ray_make(p, (vec3){0.5477226f, 0.7745967f, 0.3162278f}, 0, INFINITY);
    r.time = time;
    media entered = {0}, around = {0};
    for (int step = 0; step < 10000; step++) {
        hit h;
        accel_trace(s->accel, isa, &r, &h, 1, NULL);
        if (h.instance == NO_ID) break;
        const scene_instance *at = scene_part(s, h.instance);
        if (at->has_medium && !at->type->unbounded) {
            shade_point point;
            scene_shade_point(s, &r, &h, &point);
            /* A mesh has several materials; what is clear bounds nothing. */
            bool bounds = material_bounds_medium(point.material->type, point.material->desc) &&
                          material_alpha(point.material, &point.at) > 0;
            if (bounds && point.outside)
                media_enter(&entered, h.instance);
            else if (bounds && !media_leave(&entered, h.instance))
                media_enter(&around, h.instance);
        }
        r.after_t = h.t;
        r.after_instance = h.instance;
        r.after_primitive = h.primitive;
    }
    while (around.count > 0) media_enter(&m, around.instances[--around.count]);
    return m;
}
