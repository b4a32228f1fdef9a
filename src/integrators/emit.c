/* What policies emit: light to the film, next rays, and shadow rays towards the lights. */
#include "base/memory.h"
#include "integrators/aov.h"
#include "integrators/record.h"
#include "integrators/wave.h"

static void add_radiance(wave *w, const path_ray *r, dvec3 radiance) {
    if (radiance.x == 0 && radiance.y == 0 && radiance.z == 0) return;
    film_block_add(w->film, r->pixel, dvec3_mul(dvec3_from(r->weight), radiance));
}

void wave_add_coverage(wave *w, const path_ray *r, double alpha) {
    if (w->settings.record) record_coverage(w, r, alpha);
    film_block_add_alpha(w->film, r->pixel, alpha);
}

/* Of which `ambient` is no emission. */
static void add_from_surface(wave *w, const path_ray *r, dvec3 radiance, dvec3 ambient) {
    if (w->settings.record) record_surface(w, r, radiance);
    if (w->aovs) aov_surface(w, r, radiance, ambient);
    add_radiance(w, r, radiance);
}

void emit_radiance(wave *w, const path_ray *r, dvec3 radiance) {
    add_from_surface(w, r, radiance, (dvec3){0, 0, 0});
}

void emit_own_light(wave *w, const path_ray *r, const bsdf *b) {
    dvec3 ambient = dvec3_mul(b->ambient, w->settings.scene->ambient);
    add_from_surface(w, r, dvec3_add(b->emission, ambient), ambient);
}

/* In a transparent picture the camera sees through to nothing, or to as much of the background as the
 * scene's alpha says. */
void emit_sky(wave *w, const path_ray *r, light_weight_fn *weight) {
    const scene *s = w->settings.scene;
    dvec3 d = dvec3_normalize(dvec3_from(r->ray.d)), radiance = {0, 0, 0};
    bool sees_lights = false;
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (!scene_light_is_seen(s, i, r->primary)) continue;
        const light *l = &s->lights[i];
        dvec3 here = l->type->radiance(l, d);
        sees_lights |= l->type->irradiance != NULL; /* a disk in the sky is not all of it */
        if (!(dvec3_largest(here) > 0)) continue;
        here = dvec3_scale(here, weight ? weight(w, r, i) : 1);
        if (w->aovs) aov_sky_share(w, i, here);
        radiance = dvec3_add(radiance, here);
    }
    if (!sees_lights) {
        dvec3 here = scene_background(s, dvec3_from(r->ray.d));
        if (w->aovs) aov_sky_share(w, NO_ID, here);
        radiance = dvec3_add(radiance, here);
    }
    double alpha = 1;
    if (r->primary && w->settings.transparent) {
        alpha = s->background_alpha < 1 ? s->background_alpha : 0;
        wave_add_coverage(w, r, (double)r->coverage * alpha);
        radiance = dvec3_scale(radiance, alpha);
    }
    if (w->settings.record) record_sky(w, r, radiance);
    if (w->aovs) aov_sky(w, r, radiance, alpha);
    add_radiance(w, r, radiance);
}

void emit_background(wave *w, const path_ray *r) { emit_sky(w, r, NULL); }

/* Room for one more ray, which the caller fills; NULL without memory. */
static path_ray *push_ray(wave *w, ray_kind kind) {
    if (!ARRAY_GROW(w->next, w->next_count, w->next_capacity, 1)) {
        w->out_of_memory = true;
        return NULL;
    }
    w->stats.rays[kind]++;
    return &w->next[w->next_count++];
}

/* min_weight only saves time: what it drops is counted. */
static bool matters(wave *w, vec3 weight) {
    double largest = (double)vec3_largest(weight);
    if (w->settings.integrator->one_branch) return largest > 0; /* chance ends the path */
    double brightest = double_max(1, w->settings.scene->brightest_background);
    if (largest * brightest >= (double)w->settings.min_weight && largest > 0) return true;
    w->stats.dropped_weight += fixed_from(largest, &w->stats.film_overflows);
    return false;
}

/* Where rays start from the surface that a policy is asked about. */
static dvec3 origin_of(wave *w, const shade_point *p, bool above) {
    if (!w->has_origin[above]) w->origin[above] = dvec3_from(scene_origin(p, above));
    w->has_origin[above] = true;
    return w->origin[above];
}

path_ray *emit_ray(wave *w, const path_ray *r, const shade_point *p, dvec3 d, dvec3 weight,
                   const media *m, uint32_t slot, ray_kind kind) {
    if (r->depth >= w->settings.max_depth) {
        if (w->settings.record) record_unborn(w, r, p, d, weight, kind, SNELL_RAY_TOO_DEEP);
        return NULL;
    }
    vec3 carried = vec3_from(dvec3_mul(dvec3_from(r->weight), weight));
    path_ray *child = matters(w, carried) ? push_ray(w, kind) : NULL;
    if (child == NULL) {
        if (w->settings.record) record_unborn(w, r, p, d, weight, kind, SNELL_RAY_TOO_FAINT);
        return NULL;
    }
    /* In place, since rays are large and many. */
    dvec3 o = origin_of(w, p, dvec3_dot(p->n, d) > 0);
    scene_start_ray(p, vec3_from(o), vec3_from(d), INFINITY, &child->ray);
    child->weight = carried;
    child->pixel = r->pixel;
    child->sample = r->sample;
    child->code = path_code_child(r->code, slot);
    child->media = *m;
    child->depth = (uint16_t)(r->depth + 1);
    child->kind = (uint8_t)kind;
    child->color = r->color;
    child->route = r->route == RAY_CAMERA ? (uint8_t)kind : r->route;
    child->primary = child->has_differential = false;
    child->coverage = child->drawn_pdf = 0;
    if (w->settings.record) record_child(w, r, child, weight);
    return child;
}

static path_ray *walk_on(wave *w, const path_ray *r, const hit *from, dvec3 weight,
                         const media *m) {
    vec3 carried = vec3_from(dvec3_mul(dvec3_from(r->weight), weight));
    path_ray *child = matters(w, carried) ? push_ray(w, RAY_CONTINUED) : NULL;
    if (child == NULL) {
        if (w->settings.record) record_ended(w, r, weight);
        return NULL;
    }
    *child = *r;
    child->ray.after_t = from->t;
    child->ray.after_instance = from->instance;
    child->ray.after_primitive = from->primitive;
    child->weight = carried;
    child->media = *m;
    child->kind = RAY_CONTINUED;
    if (w->settings.record) record_child(w, r, child, weight);
    return child;
}

void emit_continued(wave *w, const path_ray *r, const hit *from, dvec3 weight, const media *m) {
    walk_on(w, r, from, weight, m);
}

void emit_through_pane(wave *w, const path_ray *r, const shade_point *p, dvec3 weight,
                       uint32_t slot) {
    path_ray *child = walk_on(w, r, w->at, weight, &w->beyond);
    if (child == NULL) return;
    child->code = path_code_child(r->code, slot);
    child->ray.mask = UINT32_MAX;
    child->primary = false; /* the pane has covered the pixel */
    if (child->route == RAY_CAMERA) child->route = RAY_REFRACTED;
    if (material_casts_full_shadow(p->material)) child->drawn_pdf = 0;
}

/* ---- direct light ---- */

/* A surface that light falls on: what all samples of lights share. */
typedef struct lit_surface {
    const path_ray *r;
    const shade_point *p;
    const bsdf *b;
    lobe_set lobes;
    bool even; /* the lobes reflect `f` from everywhere above, as Lambert does */
    dvec3 f;
} lit_surface;

/* What shadow rays pass as if it were not there does not absorb them either. */
static void set_shadow_media(const media *m, const scene *s, bool met, media *out) {
    out->count = 0;
    for (uint32_t i = 0; i < m->count; i++) {
        const material *of = &s->materials[scene_part(s, m->instances[i])->medium_material];
        if (met || ((const material_common *)of->desc)->shadow != SHADOW_NONE)
            media_enter(out, m->instances[i]);
    }
}

/* `radiance` leaves the surface towards the eye unless it is in shadow. */
static void push_shadow(wave *w, const lit_surface *on, const light_sample *from, dvec3 radiance) {
    vec3 carried = vec3_from(dvec3_mul(dvec3_from(on->r->weight), radiance));
    if (!(vec3_largest(carried) > 0)) return;
    if (w->shadow_count == w->settings.wave_size) wave_test_shadows(w);
    bool above = dvec3_dot(on->p->n, from->to_light) > 0;
    bool met = w->settings.integrator->one_branch && from->pdf > 0;
    if (w->aovs) aov_waits(w, on->r);
    ray *to_light = &w->shadow_rays[w->shadow_count];
    shadow_ray *s = &w->shadows[w->shadow_count++];
    s->light = carried;
    s->pixel = on->r->pixel;
    s->met = met;
    set_shadow_media(above ? &on->r->media : &w->beyond, w->settings.scene, met, &s->media);
    dvec3 o = origin_of(w, on->p, above), end = dvec3_add(on->p->p, from->to_end);
    dvec3 d = from->infinite ? from->to_light : dvec3_sub(end, o); /* t = 1 at the end */
    scene_start_ray(on->p, vec3_from(o), vec3_from(d), from->infinite ? INFINITY : 1, to_light);
    to_light->mask = MASK_OPAQUE | MASK_LIGHT;
    w->stats.shadow_rays++;
}

/* f |cos| of the lobes times the sample's light, for its density; 0 where the geometric and the
 * shading side disagree about where it comes from, of which the bsdf sees to where a coat has another
 * shading normal. */
static dvec3 light_reflected(const lit_surface *on, const light_sample *sample) {
    const shade_point *p = on->p;
    dvec3 to = sample->to_light, wi, f = on->f;
    /* Clearly below, whatever is rounded: nothing would come of the root and the division. */
    double slack = -1e-9 * (fabs(to.x) + fabs(to.y) + fabs(to.z));
    bool below = dvec3_dot(p->ns, to) < slack || dvec3_dot(p->n, to) < slack;
    if (on->even && below) return (dvec3){0, 0, 0};
    wi = dvec3_normalize(to);
    double cosine = dvec3_dot(p->ns, wi);
    bool agree = cosine * dvec3_dot(p->n, wi) > 0;
    if (!agree && !on->b->coat.own) return (dvec3){0, 0, 0};
    if (on->even && !(cosine > 0)) return (dvec3){0, 0, 0};
    if (!on->even) f = bsdf_evaluate(on->b, on->lobes, p->ns, p->wo, wi);
    return dvec3_scale(dvec3_mul(f, sample->light), fabs(cosine));
}

static void add_light(wave *w, const lit_surface *on, const light_sample *sample, double weight,
                      bool casts_shadow) {
    dvec3 radiance = dvec3_scale(light_reflected(on, sample), weight);
    if (w->settings.record) record_asked(w, on->r, on->p, sample, weight, radiance, casts_shadow);
    if (casts_shadow) {
        push_shadow(w, on, sample, radiance);
        return;
    }
    if (w->aovs) aov_asked(w, on->r, radiance);
    add_radiance(w, on->r, radiance);
}

void emit_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b, lobe_set lobes,
                const light_sample *sample, double weight, bool casts_shadow) {
    const lit_surface on = {.r = r, .p = p, .b = b, .lobes = lobes};
    add_light(w, &on, sample, weight, casts_shadow);
}

/* Light from everywhere on matte lobes, with nothing in the way; they look as they do to light along
 * the normal. */
static void emit_irradiance(wave *w, const lit_surface *on, const light *l) {
    const shade_point *p = on->p;
    const bsdf *b = on->b;
    double cosine = dvec3_dot(p->ns, p->wo);
    dvec3 sum = {0, 0, 0};
    for (int i = 0; i < b->lobe_count; i++) {
        const lobe *part = &b->lobes[i];
        if (!part->type->matte) continue;
        dvec3 f = part->type->evaluate(part, b, p->ns, p->wo, p->ns);
        sum = dvec3_add(sum, dvec3_scale(f, lobe_passing(part, b, p->wo, p->ns, cosine, 1)));
    }
    dvec3 irradiance = l->type->irradiance(l, p->ns);
    if (w->settings.record) record_irradiance(w, on->r, sum, irradiance);
    if (w->aovs) aov_asked(w, on->r, dvec3_mul(sum, irradiance));
    add_radiance(w, on->r, dvec3_mul(sum, irradiance));
}

/* One sample stands for the whole light. */
static double weight_of(const light_sample *sample) {
    return sample->pdf > 0 ? 1 / sample->pdf : 1;
}

/* A light that is a surface, from its representatives. */
static void emit_centers(wave *w, const lit_surface *on, uint32_t light_index) {
    const scene *s = w->settings.scene;
    uint32_t count = scene_light_center_count(s, light_index);
    w->asked = light_index;
    for (uint32_t k = 0; k < count; k++) {
        light_sample sample;
        if (scene_sample_light_center(s, light_index, k, on->p, wave_eye(w), on->r->ray.time,
                                      &sample))
            add_light(w, on, &sample, weight_of(&sample), true);
    }
}

/* One that is none. */
static void emit_center(wave *w, const lit_surface *on, uint32_t light_index) {
    const light *l = &w->settings.scene->lights[light_index];
    light_sample sample;
    w->asked = light_index;
    if (l->type->irradiance)
        emit_irradiance(w, on, l);
    else if (light_sample_middle(l, on->p->p, wave_eye(w), &sample))
        add_light(w, on, &sample, weight_of(&sample), l->type->casts_shadow);
}

static void emit_area(wave *w, const lit_surface *on, uint32_t light_index) {
    const scene *s = w->settings.scene;
    const light_type *type = scene_light_type(s, light_index);
    light_sample sample;
    sample2 u = wave_draw_child(w, on->r, light_index, SAMPLE_LIGHT);
    w->asked = light_index;
    if (!scene_sample_light(s, light_index, on->p, wave_eye(w), on->r->ray.time, u, &sample))
        return;
    lit_surface part = *on;
    if (sample.pdf > 0) part.lobes &= LOBES_DIFFUSE;
    add_light(w, &part, &sample, weight_of(&sample), !type || type->casts_shadow);
}

void emit_direct_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                       lobe_set lobes, light_places places) {
    if (!bsdf_is_lit(b, lobes)) return;
    lit_surface on = {.r = r, .p = p, .b = b, .lobes = lobes};
    on.even = bsdf_is_even(b, lobes, &on.f);
    const scene *s = w->settings.scene;
    uint32_t i = 0, count = scene_light_count(s);
    if (places == LIGHT_AREAS) {
        for (; i < count; i++) emit_area(w, &on, i);
        return;
    }
    for (; i < s->light_count; i++) emit_center(w, &on, i);
    for (; i < count; i++) emit_centers(w, &on, i);
}
