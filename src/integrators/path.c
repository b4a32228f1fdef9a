/* Kajiya 1986, The Rendering Equation: a path that goes on in one direction at a time. Light is
 * found in two ways, by a sample of one light at every point and by what the path meets, joined by
 * multiple importance sampling (Veach and Guibas 1995); Russian roulette ends it. After the code in
 * the margins of Bikker's slides:
 *
 *     survive = SurvivalProbability(diffuse)
 *     radiance = SampleLight(rand, I, L, lightDistance)
 *     brdfPdf = EvaluateDiffuse(L, N) * survive;   weight = Mis2(directPdf, brdfPdf)
 *     E * weight * dot(N, L) / directPdf * radiance
 *     brdf = SampleDiffuse(diffuse, N, r1, r2, R, pdf);   E *= brdf * dot(N, R) / pdf / survive
 */
#include "integrators/follow.h"

enum { ROULETTE_FROM = 4 };

/* The power heuristic, with the exponent 2: the weight of what was drawn with the density `a` and
 * could have been drawn with `b`. */
static double mis2(double a, double b) {
    if (!(b > 0)) return 1;
    double ratio = b / a;
    return 1 / (1 + ratio * ratio);
}

/* From the fourth bounce on a path lives with the probability of its throughput. */
static double survival_probability(const path_ray *r) {
    if (r->depth < ROULETTE_FROM) return 1;
    return double_min((double)vec3_largest(r->weight), 1);
}

/* The side that lights must be on to matter; none for what transmits. */
static dvec3 receiving_side(const shade_point *p, const bsdf *b) {
    for (int i = 0; i < b->lobe_count; i++)
        if (b->lobes[i].type->transmits) return (dvec3){0, 0, 0};
    return p->n;
}

/* What the path met by itself: the more sampling lights would have found it, the less it counts. */
static double weight_of_hit(const wave *w, const path_ray *r, const shade_point *p) {
    if (!(r->drawn_pdf > 0)) return 1;
    double light_pdf = scene_hit_pdf(wave_scene(w), dvec3_from(r->drawn_from),
                                     dvec3_from(r->drawn_n), p, r->ray.time);
    return mis2((double)r->drawn_pdf, light_pdf);
}

static double weight_of_sky(const wave *w, const path_ray *r, uint32_t index) {
    if (!(r->drawn_pdf > 0)) return 1;
    dvec3 d = dvec3_normalize(dvec3_from(r->ray.d));
    return mis2((double)r->drawn_pdf, scene_miss_pdf(wave_scene(w), index, d));
}

/* One sample of one light. */
static void sample_light(wave *w, const path_ray *r, const shade_point *p, const bsdf *b,
                         double survive) {
    if (!bsdf_is_lit(b, LOBES_LIT)) return;
    const scene *s = wave_scene(w);
    sample2 choice = wave_draw(w, r, SAMPLE_LIGHT_CHOICE), u = wave_draw(w, r, SAMPLE_LIGHT);
    uint32_t source;
    double chance;
    light_sample found;
    if (!scene_choose_source(s, p->p, receiving_side(p, b), choice.x, &source, &chance)) return;
    if (!scene_sample_source(s, source, p, wave_eye(w), r->ray.time, u, &found)) return;
    dvec3 wi = dvec3_normalize(found.to_light);
    double weight = 1 / chance;
    if (found.pdf > 0) {
        double light_pdf = chance * found.pdf, direction_pdf = 0;
        if (r->depth < wave_max_depth(w)) /* else no ray goes on that could meet it */
            direction_pdf = bsdf_pdf(b, p->ns, p->wo, wi) * survive;
        weight = mis2(light_pdf, direction_pdf) / light_pdf;
    }
    wave_ask(w, source, chance);
    emit_light(w, r, p, b, LOBES_LIT, &found, weight, scene_source_casts_shadow(s, source));
}

static void go_on(wave *w, const path_ray *r, const shade_point *p, const bsdf *b, double survive) {
    bsdf_direction next;
    sample2 luck = wave_draw(w, r, SAMPLE_LOBE);
    if (!(luck.y < survive)) return;
    if (!bsdf_sample(b, p->ns, p->wo, luck.x, wave_draw(w, r, SAMPLE_DIRECTION), &next)) return;
    double height = dvec3_dot(next.wi, p->n);
    bool wrong_side = next.transmitted ? height >= 0 : height <= 0;
    bool nothing = !(dvec3_largest(next.weight) > 0); /* such as a coat's sample under its base */
    if ((wrong_side || nothing) && next.pdf > 0) return;
    if (wrong_side) {
        if (next.transmitted) {
            if (!refract_direction(p->wo, p->n, b->ior1 / b->ior2, &next.wi)) return;
        } else {
            next.wi = bent_back(p, next.wi);
        }
    }
    dvec3 weight = dvec3_scale(next.weight, 1 / survive);
    if (p->material->thin && next.transmitted && !(next.pdf > 0)) {
        emit_through_pane(w, r, p, weight, next.transmitted);
        return;
    }
    path_ray *child =
        emit_ray(w, r, p, next.wi, weight, next.transmitted ? wave_beyond(w) : &r->media,
                 next.transmitted, next.transmitted ? RAY_REFRACTED : RAY_REFLECTED);
    if (child == NULL) return;
    child->drawn_pdf = (float)(next.pdf * survive);
    child->drawn_n = vec3_from(receiving_side(p, b));
    child->drawn_from = child->ray.o;
}

static void hit_surface(wave *w, const path_ray *r, const shade_point *p, const bsdf *b) {
    if (dvec3_largest(b->emission) > 0)
        emit_radiance(w, r, dvec3_scale(b->emission, weight_of_hit(w, r, p)));
    double survive = survival_probability(r);
    sample_light(w, r, p, b, survive);
    go_on(w, r, p, b, survive);
}

static void miss(wave *w, const path_ray *r) { emit_sky(w, r, weight_of_sky); }

const integrator integrator_path = {
    .name = "path",
    .help = "all light, by chance: path tracing (1986)",
    .samples = 128,
    .max_depth = 64,
    .max_depth_media = 64,
    .one_branch = true,
    .hit = hit_surface,
    .miss = miss,
};
