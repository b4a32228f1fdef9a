#include "scene/lights.h"

#include <stdlib.h>

#include "base/memory.h"
#include "geometry/mesh.h"
#include "maths/functions.h"
#include "scene/seen.h"

/* Where one shadow ray goes to the middle of each light, a light that has no one middle is
 * represented by so many points: a mesh of more triangles, a shape that is seen from one side at a
 * time (a box, a torus), a surface that does not shine evenly. */
enum { CENTERS_MAX = 12 };

/* Each costs about 150 bytes, however often its group is drawn. */
enum { EMITTERS_MAX = 1 << 24 };

/* ---- finding what shines ---- */

static const material *emitter_material(const scene *s, const scene_instance *at,
                                        uint32_t primitive) {
    if (at->type->intersect != NULL) return &s->materials[at->material];
    const mesh_desc *mesh = at->shape;
    if (mesh->material_slots_count == 0) return &s->materials[at->material];
    return &s->materials[mesh->materials[mesh->material_slots[primitive]].index1 - 1];
}

/* Does to_world keep angles: are its columns orthogonal and of one length? */
static bool keeps_angles(const transform *m) {
    dvec3 c[3];
    for (int i = 0; i < 3; i++)
        c[i] = (dvec3){(double)m->m[0][i], (double)m->m[1][i], (double)m->m[2][i]};
    double size = dvec3_dot(c[0], c[0]), slack = 1e-6 * size;
    return fabs(dvec3_dot(c[1], c[1]) - size) <= slack &&
           fabs(dvec3_dot(c[2], c[2]) - size) <= slack && fabs(dvec3_dot(c[0], c[1])) <= slack &&
           fabs(dvec3_dot(c[1], c[2])) <= slack && fabs(dvec3_dot(c[2], c[0])) <= slack;
}

static bool is_emitter(const scene_instance *at) { return at->shines; }

/* Called now and then: shapes of which the area is a sum over many lines take a while. */
static snell_status look_up(const accel_options *options) {
    if (options->progress == NULL || options->progress(options->user, 1)) return SNELL_OK;
    return error_set(SNELL_CANCELLED, NULL, "the build was cancelled");
}

enum { EMITTERS_BETWEEN_LOOKS = 4096 };

typedef struct finding {
    scene *s;
    const accel_options *options;
    double *areas; /* of the description's shapes of one part; below 0: not yet known */
    size_t emitter_capacity, light_capacity;
} finding;

/* Of a shape of one part: worked out once, however many copies shine. */
static snell_status find_area(finding *f, const scene_instance *at, double *area) {
    bool kept = at->shape_index < f->s->prepared_count && at->type->primitive_count == NULL;
    if (kept && f->areas[at->shape_index] >= 0) {
        *area = f->areas[at->shape_index];
        return SNELL_OK;
    }
    snell_status status = look_up(f->options);
    if (status) return status;
    *area = at->type->area(at->shape, 0);
    if (kept && *area >= 0) f->areas[at->shape_index] = *area;
    return SNELL_OK;
}

static snell_status add_emitters(void *user, uint32_t number, const scene_instance *at) {
    finding *f = user;
    scene *s = f->s;
    bool seen = at->type->area == NULL;
    uint32_t primitives = seen ? 1 : primitive_count_of(at->type, at->shape);
    uint32_t first = s->emitter_count;
    surface_light made = {number, first, 0, seen, 0, {0, 0, 0}};
    double whole = 0;
    snell_status status = SNELL_OK;
    if (seen) seen_measure(&made, at);
    /* What is not known is taken for half of the ball's: it matters for choosing alone. */
    if (seen)
        whole = 2 * PI * made.radius * made.radius;
    else if (at->type->primitive_count == NULL && emitter_material(s, at, 0)->shines)
        status = find_area(f, at, &whole);
    if (status) return status;
    for (uint32_t k = 0; k < primitives; k++) {
        if (!seen && !emitter_material(s, at, k)->shines) continue;
        bool in_parts = !seen && at->type->primitive_count;
        double area = in_parts ? at->type->area(at->shape, k) : whole;
        if (!(area > 0)) continue;
        if (s->emitter_count >= EMITTERS_MAX)
            return error_set(SNELL_ERR_ARGUMENT, "draw fewer copies of what shines",
                             "more than %d shapes and triangles shine", EMITTERS_MAX);
        if (!ARRAY_GROW(s->emitters, s->emitter_count, f->emitter_capacity, 1))
            return error_no_memory();
        s->emitters[s->emitter_count++] = (emitter){number, k, area, 0};
        if (s->emitter_count % EMITTERS_BETWEEN_LOOKS == 0) status = look_up(f->options);
        if (status) return status;
    }
    if (s->emitter_count == first) return SNELL_OK;
    if (!ARRAY_GROW(s->surface_lights, s->surface_light_count, f->light_capacity, 1))
        return error_no_memory();
    made.emitter_count = s->emitter_count - first;
    s->surface_lights[s->surface_light_count++] = made;
    return SNELL_OK;
}

static snell_status find_emitters(scene *s, const accel_options *options) {
    for (uint32_t i = 0; i < s->part_count; i++) {
        scene_instance *at = &s->instances[i];
        at->similar = at->moves == NULL && keeps_angles(&at->to_world);
    }
    finding f = {.s = s,
                 .options = options,
                 .areas = memory_resize(NULL, s->prepared_count, sizeof *f.areas)};
    if (f.areas == NULL) return error_no_memory();
    for (size_t i = 0; i < s->prepared_count; i++) f.areas[i] = -1;
    snell_status status = scene_each_shape(s, is_emitter, add_emitters, &f);
    free(f.areas);
    return status;
}

const surface_light *scene_surface_light(const scene *s, uint32_t id) {
    if (s->surface_light_count == 0 || !scene_part(s, id)->shines) return NULL;
    uint32_t low = 0, high = s->surface_light_count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (s->surface_lights[middle].instance < id)
            low = middle + 1;
        else
            high = middle;
    }
    return s->surface_lights[low].instance == id ? &s->surface_lights[low] : NULL;
}

/* ---- points on emitters ---- */

/* How much larger an area of the unit normal n (own space) is in the world; at: posed. */
static double area_scale(const scene_instance *at, dvec3 n) {
    if (at->identity) return 1;
    return fabs(transform_determinant(&at->to_world)) *
           dvec3_length(transform_normal(&at->to_local, n));
}

/* In the shape's own space; at: posed. */
static double emitter_area(const scene_instance *at, const emitter *e) {
    return at->type == &primitive_deforming ? at->type->area(at->shape, e->primitive) : e->area;
}

/* The radiance that leaves a point of an emitter towards `wo`, as much of it as is there. */
static dvec3 radiance_at(const shade_point *p) {
    const material *m = p->material;
    dvec3 radiance = material_emission(m, &p->at);
    bool solid = m->opaque_alpha && p->at.alpha == 1;
    return solid ? radiance : dvec3_scale(radiance, material_alpha(m, &p->at));
}

/* About how bright something of it is: without textures, which nobody has looked up yet. */
static double luminance_of(const scene *s, const scene_instance *at) {
    double most = 0;
    material_point nowhere = {.tint = {1, 1, 1},
                              .alpha = 1,
                              .outside = true,
                              .textures = s->textures,
                              .materials = s->materials};
    for (uint32_t i = 0; i < instance_slot_count(at); i++) {
        const material *m = &s->materials[instance_slot(at, i)];
        if (!m->shines) continue;
        dvec3 radiance = m->textured ? (dvec3){1, 1, 1} : material_emission(m, &nowhere);
        most = double_max(most, LUMINANCE(radiance));
    }
    return most;
}

/* Of what is seen by rays: shining everywhere, from anywhere. */
static light_bounds bound_seen(const scene *s, const surface_light *l) {
    posed_instance room;
    shape_path path;
    scene_find_path(s, l->instance, 0, &path);
    const scene_instance *at = scene_posed(s, l->instance, 0, &room);
    float time = at->moves ? at->moves->steps[0].time : 0;
    if (at->moves) at = scene_posed(s, l->instance, time, &room);
    bounds3 box = shape_path_bounds(&path, at->type->bounds(at->shape));
    double scale2 = fn_pow(fabs(transform_determinant(&at->to_world)), 2.0 / 3);
    return (light_bounds){.low = dvec3_from(box.min),
                          .high = dvec3_from(box.max),
                          .axis = {0, 1, 0},
                          .cos_spread = -1,
                          .cos_emission = 0,
                          .two_sided = true,
                          .power =
                              2 * PI * PI * l->radius * l->radius * scale2 * luminance_of(s, at)};
}

/* Brightness and place of an emitter, from its middle and three points about it. */
static light_bounds bound_emitter(const scene *s, const emitter *e) {
    if (scene_part(s, e->instance)->type->area == NULL)
        return bound_seen(s, scene_surface_light(s, e->instance));
    static const sample2 places[4] = {{0.5, 0.5}, {0.2, 0.3}, {0.8, 0.4}, {0.4, 0.85}};
    shape_path path;
    posed_instance room;
    scene_find_path(s, e->instance, 0, &path);
    const scene_instance *at = scene_posed(s, e->instance, 0, &room);
    float time = at->moves ? at->moves->steps[0].time : 0;
    if (at->moves) at = scene_posed(s, e->instance, time, &room);
    bool deforms = at->type == &primitive_deforming;
    const material_common *common = emitter_material(s, at, e->primitive)->desc;
    light_bounds b = {.low = {INFINITY, INFINITY, INFINITY},
                      .high = {-INFINITY, -INFINITY, -INFINITY},
                      .cos_spread = at->type->flat && !at->moves && !deforms ? 1 : -1,
                      .cos_emission = 0,
                      .two_sided = common->emit_two_sided};
    double luminance = 0, scale = 0;
    for (int i = 0; i < 4; i++) {
        surface on;
        shade_point p;
        at->type->sample_area(at->shape, e->primitive, places[i].x, places[i].y, &on);
        scale += area_scale(at, on.n) / 4;
        scene_surface_point(s, e->instance, e->primitive, time, &on, (dvec3){0, 0, 0}, &p);
        p.at.outside = true;
        luminance += LUMINANCE(radiance_at(&p)) / 4;
        b.axis = p.n;
    }
    const void *shape = path.levels[path.count - 1]->shape; /* at all times */
    bounds3 box = shape_path_bounds(&path, primitive_bounds_of(at->type, shape, e->primitive));
    b.low = dvec3_from(box.min);
    b.high = dvec3_from(box.max);
    b.power = PI * luminance * e->area * scale * (b.two_sided ? 2 : 1);
    return b;
}

static light_bounds bound_light(const scene *s, const light *l) {
    (void)s;
    light_bounds b = {.cos_emission = -1, .cos_spread = 1};
    double spread;
    l->type->place(l, &b.low, &b.axis, &spread);
    b.high = b.low;
    dvec3 power = l->type->power(l, 0);
    b.power = LUMINANCE(power);
    /* Within its cone a spot is as bright as a point light: no cosine falls on its way. */
    b.cos_spread = spread;
    b.cos_emission = spread > -1 ? 0 : -1;
    return b;
}

/* Sums of a mesh's emitters, by power; what seems black may only be so at the points looked at. */
static void sum_weights(scene *s, const light_bounds *bounds) {
    for (uint32_t i = 0; i < s->surface_light_count; i++) {
        const surface_light *at = &s->surface_lights[i];
        emitter *e = s->emitters + at->first_emitter;
        double power = 0, area = 0, sum = 0;
        for (uint32_t k = 0; k < at->emitter_count; k++) {
            power += bounds[at->first_emitter + k].power;
            area += e[k].area;
        }
        double floor = power > 0 ? 0.02 * power / area : 1;
        double total = power + floor * area;
        for (uint32_t k = 0; k < at->emitter_count; k++) {
            sum += (bounds[at->first_emitter + k].power + floor * e[k].area) / total;
            e[k].sum = sum;
        }
        e[at->emitter_count - 1].sum = 1;
    }
}

static snell_status build_choice(scene *s, const accel_options *options) {
    s->placed = memory_resize(NULL, s->light_count, sizeof *s->placed);
    s->nowhere = memory_resize(NULL, s->light_count, sizeof *s->nowhere);
    size_t most = (size_t)s->light_count + s->emitter_count;
    light_bounds *bounds = memory_resize(NULL, most, sizeof *bounds);
    if (!s->placed || !s->nowhere || !bounds) {
        free(bounds);
        return error_no_memory();
    }
    for (uint32_t i = 0; i < s->light_count; i++) {
        if (s->lights[i].type->place == NULL) {
            s->nowhere[s->nowhere_count++] = i;
        } else {
            bounds[s->placed_count] = bound_light(s, &s->lights[i]);
            s->placed[s->placed_count++] = i;
        }
    }
    light_bounds *of_emitters = bounds + s->placed_count;
    snell_status status = SNELL_OK;
    for (uint32_t i = 0; i < s->emitter_count && !status; i++) {
        of_emitters[i] = bound_emitter(s, &s->emitters[i]);
        if (i % EMITTERS_BETWEEN_LOOKS == EMITTERS_BETWEEN_LOOKS - 1) status = look_up(options);
    }
    if (!status) {
        sum_weights(s, of_emitters);
        status = light_tree_build(bounds, s->placed_count + s->emitter_count, &s->tree);
    }
    free(bounds);
    return status;
}

snell_status scene_freeze_lights(scene *s, const accel_options *options) {
    snell_status status = find_emitters(s, options);
    return status ? status : build_choice(s, options);
}

void scene_free_lights(scene *s) {
    light_tree_destroy(s->tree);
    free(s->emitters);
    free(s->surface_lights);
    free(s->placed);
    free(s->nowhere);
}

/* ---- sampling ---- */

/* The shadow ray ends before the surface that shines, by more than its rounding: its direction is
 * rounded to floats, 2^-24 of its length, and so is its origin. */
static dvec3 shadow_end(const shade_point *end, dvec3 p, dvec3 to_light) {
    double size = dvec3_length(to_light) + fabs(p.x) + fabs(p.y) + fabs(p.z);
    return dvec3_add(to_light, dvec3_scale(end->n, end->clearance + 0x1p-20 * size));
}

static bool sample_seen(const scene *s, const surface_light *l, const scene_instance *at,
                        const shade_point *from, float time, sample2 u, light_sample *out) {
    shade_point shine;
    double pdf;
    if (!seen_sample(s, l, at, from, time, u, &shine, &pdf)) return false;
    dvec3 to_light = dvec3_sub(shine.p, from->p);
    shine.at.outside = shine.outside;
    *out = (light_sample){.to_light = to_light,
                          .to_end = shadow_end(&shine, from->p, to_light),
                          .light = radiance_at(&shine),
                          .pdf = pdf};
    return dvec3_largest(out->light) > 0;
}

static bool sample_emitter(const scene *s, const emitter *e, const shade_point *from_point,
                           float time, sample2 u, light_sample *out) {
    posed_instance room;
    const scene_instance *at = scene_posed(s, e->instance, time, &room);
    if (at->type->area == NULL)
        return sample_seen(s, scene_surface_light(s, e->instance), at, from_point, time, u, out);
    dvec3 p = from_point->p;
    dvec3 from = at->identity ? p : transform_point(&at->to_local, p);
    surface on;
    double pdf = 0;
    bool by_angle = at->similar && at->type->sample_toward &&
                    at->type->sample_toward(at->shape, from, u.x, u.y, &on, &pdf);
    if (!by_angle) at->type->sample_area(at->shape, e->primitive, u.x, u.y, &on);
    dvec3 local_n = on.n;
    shade_point shine;
    scene_surface_point(s, e->instance, e->primitive, time, &on, (dvec3){0, 0, 0}, &shine);
    dvec3 to_light = dvec3_sub(shine.p, p);
    double distance2 = dvec3_dot(to_light, to_light);
    double cosine = -dvec3_dot(shine.n, to_light) / sqrt(distance2);
    shine.at.outside = cosine > 0;
    if (cosine < 0) shine.n = dvec3_negate(shine.n);
    if (!by_angle) pdf = distance2 / (fabs(cosine) * emitter_area(at, e) * area_scale(at, local_n));
    if (!(distance2 > 0) || !(pdf > 0) || !isfinite(pdf)) return false;
    *out = (light_sample){.to_light = to_light,
                          .to_end = shadow_end(&shine, p, to_light),
                          .light = radiance_at(&shine),
                          .pdf = pdf};
    return dvec3_largest(out->light) > 0;
}

/* The density with which sample_emitter draws the direction of a point of the emitter. */
static double emitter_pdf(const scene *s, const emitter *e, dvec3 from, const shade_point *on,
                          float time) {
    posed_instance room;
    const scene_instance *at = scene_posed(s, e->instance, time, &room);
    if (at->type->area == NULL) return seen_pdf(scene_surface_light(s, e->instance), at, from);
    dvec3 to_light = dvec3_sub(on->p, from);
    double distance2 = dvec3_dot(to_light, to_light);
    if (!(distance2 > 0)) return 0;
    if (at->similar && at->type->pdf_toward) {
        dvec3 o = at->identity ? from : transform_point(&at->to_local, from);
        dvec3 d = at->identity ? to_light : transform_vector(&at->to_local, to_light);
        double pdf = at->type->pdf_toward(at->shape, o, dvec3_normalize(d));
        if (pdf > 0) return pdf;
    }
    /* n in the shape's own space, for the scale: the inverse of what surface_to_world did. */
    double scale = 1;
    if (!at->identity) {
        scale = area_scale(at, dvec3_normalize(transform_normal(&at->to_world, on->n)));
    }
    double cosine = fabs(dvec3_dot(on->n, to_light)) / sqrt(distance2);
    return distance2 / (cosine * emitter_area(at, e) * scale);
}

uint32_t scene_light_count(const scene *s) { return s->light_count + s->surface_light_count; }

const light_type *scene_light_type(const scene *s, uint32_t index) {
    return index < s->light_count ? s->lights[index].type : NULL;
}

static const surface_light *find_surface_light(const scene *s, uint32_t index) {
    return &s->surface_lights[index - s->light_count];
}

/* The emitter in whose interval u falls; u becomes its place in there. */
static uint32_t pick_emitter(const scene *s, const surface_light *at, double *u, double *chance) {
    const emitter *e = s->emitters + at->first_emitter;
    uint32_t low = 0, high = at->emitter_count - 1; /* the first whose sum is over u */
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (e[middle].sum > *u)
            high = middle;
        else
            low = middle + 1;
    }
    double before = low > 0 ? e[low - 1].sum : 0;
    *chance = e[low].sum - before;
    *u = (*u - before) / *chance;
    if (!(*u < 1)) *u = 0x1.fffffffffffffp-1;
    return at->first_emitter + low;
}

bool scene_sample_light(const scene *s, uint32_t index, const shade_point *from, dvec3 eye,
                        float time, sample2 u, light_sample *out) {
    if (index < s->light_count)
        return s->lights[index].type->sample(&s->lights[index], from->p, eye, u, out);
    double chance;
    uint32_t e = pick_emitter(s, find_surface_light(s, index), &u.x, &chance);
    if (!sample_emitter(s, &s->emitters[e], from, time, u, out)) return false;
    out->pdf *= chance;
    return true;
}

/* A flat shape shines from its middle, and so does one that is sampled as it is seen. */
static bool has_middle(const scene *s, const surface_light *of) {
    posed_instance room;
    const scene_instance *at = scene_posed(s, of->instance, 0, &room);
    bool seen_whole = at->type->flat || (at->similar && at->type->sample_toward);
    if (of->seen) return false;
    return at->type->primitive_count || (seen_whole && !s->materials[at->material].textured);
}

uint32_t scene_light_center_count(const scene *s, uint32_t index) {
    if (index < s->light_count) return 1;
    const surface_light *at = find_surface_light(s, index);
    if (!has_middle(s, at)) return CENTERS_MAX;
    return at->emitter_count < CENTERS_MAX ? at->emitter_count : CENTERS_MAX;
}

/* The k-th of `count` points spread over the unit square (Hammersley). */
static sample2 spread_point(uint32_t k, uint32_t count) {
    double y = 0x1p-5, digit = 0.5;
    for (uint32_t rest = k; rest; rest /= 2, digit /= 2) y += digit * (rest & 1);
    return (sample2){(k + 0.5) / count, y};
}

bool scene_sample_light_center(const scene *s, uint32_t index, uint32_t k, const shade_point *from,
                               dvec3 eye, float time, light_sample *out) {
    const sample2 middle = {0.5, 0.5};
    if (index < s->light_count) return light_sample_middle(&s->lights[index], from->p, eye, out);
    const surface_light *at = find_surface_light(s, index);
    uint32_t count = scene_light_center_count(s, index);
    if (!has_middle(s, at)) {
        sample2 place = spread_point(k, count);
        if (!sample_emitter(s, &s->emitters[at->first_emitter], from, time, place, out))
            return false;
        out->pdf *= count;
        return true;
    }
    uint32_t e = at->first_emitter + k;
    double chance = 1; /* few: each is its own representative */
    if (at->emitter_count > CENTERS_MAX) {
        double u = (k + 0.5) / count;
        e = pick_emitter(s, at, &u, &chance);
        chance *= count;
    }
    if (!sample_emitter(s, &s->emitters[e], from, time, middle, out)) return false;
    out->pdf *= chance;
    return true;
}

/* ---- choosing one ---- */

/* Each light that is nowhere, and the tree as a whole, have the same chance. */
static double chance_of_each(const scene *s) {
    return 1.0 / (s->nowhere_count + (s->placed_count + s->emitter_count > 0));
}

bool scene_choose_source(const scene *s, dvec3 p, dvec3 n, double u, uint32_t *source,
                         double *chance) {
    bool has_tree = s->placed_count + s->emitter_count > 0;
    uint32_t count = s->nowhere_count + has_tree;
    if (count == 0) return false;
    double scaled = u * count;
    uint32_t which = (uint32_t)scaled;
    if (which >= count) which = count - 1;
    if (which < s->nowhere_count) {
        *source = s->nowhere[which];
        *chance = chance_of_each(s);
        return true;
    }
    uint32_t index;
    double within = double_min(scaled - which, 0x1.fffffffffffffp-1);
    if (!light_tree_sample(s->tree, p, n, within, &index, chance)) return false;
    *chance *= chance_of_each(s);
    *source =
        index < s->placed_count ? s->placed[index] : s->light_count + (index - s->placed_count);
    return true;
}

bool scene_sample_source(const scene *s, uint32_t source, const shade_point *from, dvec3 eye,
                         float time, sample2 u, light_sample *out) {
    if (source < s->light_count)
        return s->lights[source].type->sample(&s->lights[source], from->p, eye, u, out);
    return sample_emitter(s, &s->emitters[source - s->light_count], from, time, u, out);
}

bool scene_source_casts_shadow(const scene *s, uint32_t source) {
    return source >= s->light_count || s->lights[source].type->casts_shadow;
}

/* The emitter that a hit lies on, or NO_ID: emitters are in the order of their primitives. */
static uint32_t find_emitter(const scene *s, uint32_t id, uint32_t primitive) {
    const surface_light *at = scene_surface_light(s, id);
    if (at == NULL) return NO_ID;
    if (at->seen) return at->first_emitter;
    uint32_t low = at->first_emitter, end = low + at->emitter_count, high = end;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (s->emitters[middle].primitive < primitive)
            low = middle + 1;
        else
            high = middle;
    }
    return low < end && s->emitters[low].primitive == primitive ? low : NO_ID;
}

double scene_hit_pdf(const scene *s, dvec3 from, dvec3 n, const shade_point *on, float time) {
    uint32_t e = find_emitter(s, on->instance, on->primitive);
    if (e == NO_ID) return 0;
    double chance = light_tree_chance(s->tree, from, n, s->placed_count + e);
    return chance > 0 ? chance * chance_of_each(s) * emitter_pdf(s, &s->emitters[e], from, on, time)
                      : 0;
}

double scene_miss_pdf(const scene *s, uint32_t index, dvec3 d) {
    return chance_of_each(s) * s->lights[index].type->pdf(&s->lights[index], d);
}

bool scene_light_is_seen(const scene *s, uint32_t index, bool camera_ray) {
    const light *l = &s->lights[index];
    if (l->type->radiance == NULL) return false;
    return !camera_ray || l->type->is_visible == NULL || l->type->is_visible(l->desc);
}
