#include "report.h"

#include <stdio.h>

#include "maths/functions.h"

static const char *const quality_names[] = {"low", "medium", "high"};

/* The two groups that have a figure of their own. */
static const struct {
    const char *name;
    bool kinds[RAY_KINDS];
} groups[] = {
    {"reflect, diffuse", {[RAY_REFLECT] = true, [RAY_DIFFUSE] = true}},
    {"primary, shadow, ao", {[RAY_PRIMARY] = true, [RAY_SHADOW] = true, [RAY_AO] = true}},
};
enum { GROUPS = sizeof groups / sizeof *groups };

typedef struct mean {
    double ratio, least; /* geometric mean of the cells' medians; the least of them, and which */
    const char *scene, *kind;
    uint32_t cells;
} mean;

static mean mean_of(const scene_results *r, size_t count, const settings *t, int group,
                    uint32_t threads) {
    mean m = {0, INFINITY, "", "", 0};
    for (size_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < r[i].cell_count; k++) {
            const cell *c = &r[i].cells[k];
            uint32_t beside = cell_peer(c, t);
            if (!groups[group].kinds[c->kind] || c->threads != threads || beside == TRACERS)
                continue;
            double ratio = cell_ratio(c, t, beside).median;
            m.ratio += fn_log(ratio);
            m.cells++;
            if (ratio < m.least)
                m.least = ratio, m.scene = r[i].name, m.kind = ray_kind_names[c->kind];
        }
    if (m.cells) m.ratio = fn_exp(m.ratio / m.cells);
    return m;
}

static summary rate(const cell *c, const settings *t, uint32_t tracer) {
    return summarise(c->mrays[tracer], t->rounds);
}

/* How many times the rate of one thread, round by round; 0: one thread was not measured. */
static summary scaling(const scene_results *r, const cell *c, const settings *t, uint32_t tracer) {
    double times[ROUNDS_MAX];
    for (uint32_t k = 0; k < r->cell_count; k++) {
        const cell *one = &r->cells[k];
        if (one->kind != c->kind || one->threads != 1) continue;
        for (uint32_t i = 0; i < t->rounds; i++)
            times[i] = c->mrays[tracer][i] / one->mrays[tracer][i];
        return summarise(times, t->rounds);
    }
    return (summary){0};
}

static double agreeing(const cell *c, const agreement *a) {
    return 100 * (1 - (double)a->hit_or_miss / (double)c->rays);
}

/* ---- text ---- */

void report_head(const settings *t, const char *embree) {
    printf("snell %s, build %s, batches of %u; ", tracer_names[t->own],
           accel_quality_names[t->own_quality], t->batch);
    if (embree)
        printf("Embree %s, %s, quality %s, single rays and packets of %d, the better one is the "
               "peer; ",
               embree, PEER_FLAGS, quality_names[t->quality], PEER_PACKET);
    printf("%u rounds; cycles by %s\n", t->rounds, cycles_source());
}

static void print_build(const scene_results *r, const settings *t) {
    size_t things = r->spheres ? r->spheres : r->triangles;
    double n = (double)things;
    const accel_memory *m = &r->memory;
    summary own = summarise(r->build, t->builds), beside = summarise(r->peer_build, t->builds);
    printf("\n%s: %zu %s\n", r->name, things, r->spheres ? "spheres" : "triangles");
    printf(
        "  built by snell in %.3f s (%.3f .. %.3f), %.1f bytes each (nodes %.1f, triangles %.1f, "
        "other %.1f)\n",
        own.median, own.low, own.high,
        (double)(m->node_bytes + m->triangle_bytes + m->other_bytes) / n, (double)m->node_bytes / n,
        (double)m->triangle_bytes / n, (double)m->other_bytes / n);
    if (t->embree)
        printf("  by Embree in %.3f s (%.3f .. %.3f), %.1f bytes each\n", beside.median, beside.low,
               beside.high, (double)r->peer_bytes / n);
    printf("  ao rays are %.4g long\n", r->ao_length);
}

static void print_agreement(const cell *c, const settings *t) {
    for (uint32_t i = 0; i < TRACERS; i++) {
        const agreement *a = &c->agree[i];
        if (!t->wanted[i]) continue;
        if (i < SINGLE && a->bits)
            printf("           %s: %zu rays with other bits\n", tracer_names[i], a->bits);
        if (i < SINGLE || (a->hit_or_miss == 0 && a->ulp_max <= 4)) continue;
        printf("           %s: %.5f %% agree in hit or miss (%zu do not)", tracer_names[i],
               agreeing(c, a), a->hit_or_miss);
        if (a->both)
            printf("; t to %u ulp, over 4 in %zu of %zu; snell is right in %zu, Embree in %zu",
                   a->ulp_max, a->over_4_ulp, a->both, a->own_right, a->other_right);
        printf("\n");
    }
}

static void print_cell(const scene_results *r, const cell *c, const settings *t) {
    double n = (double)c->rays;
    uint32_t beside = cell_peer(c, t);
    summary own = rate(c, t, t->own);
    printf("  %-8s %u  %7.3f Mrays/s (%.3f .. %.3f)", ray_kind_names[c->kind], c->threads,
           own.median, own.low, own.high);
    if (beside < TRACERS) {
        summary ratio = cell_ratio(c, t, beside);
        printf("  single %.3f, packet %.3f, ratio %.3f (%.3f .. %.3f)", rate(c, t, SINGLE).median,
               rate(c, t, PACKET).median, ratio.median, ratio.low, ratio.high);
    }
    if (c->threads > 1) {
        printf("  scales %.2f", scaling(r, c, t, t->own).median);
        if (beside < TRACERS) printf(", Embree %.2f", scaling(r, c, t, beside).median);
    }
    printf("\n           %zu rays; each %.1f nodes, %.1f boxes, %.1f triangles, %.1f shapes, %.0f "
           "cycles",
           c->rays, (double)c->counters.nodes / n, (double)c->counters.boxes / n,
           (double)c->counters.triangles / n, (double)c->counters.primitives / n,
           summarise(c->cycles, t->rounds).median);
    if (c->spoiled) {
        summary s = summarise(c->spoiled_time, t->rounds);
        printf("; with %zu bad ones %.3f (%.3f .. %.3f) of the time, %zu wrong", c->spoiled,
               s.median, s.low, s.high, c->spoiled_wrong);
    }
    printf("\n");
    for (uint32_t i = 0; i < SINGLE; i++)
        if (t->wanted[i] && i != t->own)
            printf("           %s %.3f Mrays/s\n", tracer_names[i], rate(c, t, i).median);
    print_agreement(c, t);
}

void report_scene(const scene_results *r, const settings *t) {
    print_build(r, t);
    for (uint32_t i = 0; i < r->cell_count; i++) print_cell(r, &r->cells[i], t);
    fflush(stdout);
}

void report_means(const scene_results *r, size_t count, const settings *t) {
    if (!t->embree) return;
    printf("\n");
    for (uint32_t i = 0; i < t->threads_count; i++)
        for (int g = 0; g < GROUPS; g++) {
            mean m = mean_of(r, count, t, g, t->threads[i]);
            printf("%s, threads %u: %.3f times Embree in the geometric mean of %u, least %.3f (%s, "
                   "%s)\n",
                   groups[g].name, t->threads[i], m.ratio, m.cells, m.least, m.scene, m.kind);
        }
}

/* ---- JSON ---- */

static void json_text(const char *text) {
    putchar('"');
    for (; *text; text++) {
        if ((unsigned char)*text < ' ')
            printf("\\u%04x", (unsigned char)*text);
        else
            printf(*text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    putchar('"');
}

static void json_summary(const char *name, summary s) {
    printf("\"%s\":%.6g,\"%s_low\":%.6g,\"%s_high\":%.6g", name, s.median, name, s.low, name,
           s.high);
}

static void json_scene(const scene_results *r, const settings *t) {
    const accel_memory *m = &r->memory;
    printf("{\"scene\":");
    json_text(r->name);
    printf(",\"triangles\":%zu,\"spheres\":%zu,\"ao_length\":%.9g,", r->triangles, r->spheres,
           r->ao_length);
    json_summary("build_seconds", summarise(r->build, t->builds));
    printf(",\"node_bytes\":%llu,\"triangle_bytes\":%llu,\"other_bytes\":%llu",
           (unsigned long long)m->node_bytes, (unsigned long long)m->triangle_bytes,
           (unsigned long long)m->other_bytes);
    if (t->embree) {
        printf(",");
        json_summary("embree_build_seconds", summarise(r->peer_build, t->builds));
        printf(",\"embree_bytes\":%zu", r->peer_bytes);
    }
    printf("}");
}

static void json_tracers(const cell *c, const settings *t) {
    const char *comma = "";
    printf(",\"tracers\":[");
    for (uint32_t i = 0; i < TRACERS; i++) {
        const agreement *a = &c->agree[i];
        if (!t->wanted[i]) continue;
        printf("%s{\"name\":\"%s\",", comma, tracer_names[i]);
        json_summary("mrays_per_second", rate(c, t, i));
        if (i < SINGLE)
            printf(",\"other_bits\":%zu}", a->bits);
        else
            printf(",\"hit_or_miss_mismatches\":%zu,\"agreeing_percent\":%.7f,\"both_hit\":%zu,"
                   "\"ulp_max\":%u,\"over_4_ulp\":%zu,\"snell_right\":%zu,"
                   "\"embree_right\":%zu}",
                   a->hit_or_miss, agreeing(c, a), a->both, a->ulp_max, a->over_4_ulp, a->own_right,
                   a->other_right);
        comma = ",";
    }
    printf("]");
}

static void json_cell(const scene_results *r, const cell *c, const settings *t) {
    double n = (double)c->rays;
    uint32_t beside = cell_peer(c, t);
    printf("{\"scene\":");
    json_text(r->name);
    printf(",\"kind\":\"%s\",\"threads\":%u,\"rays\":%zu,", ray_kind_names[c->kind], c->threads,
           c->rays);
    json_summary("snell_mrays_per_second", rate(c, t, t->own));
    if (beside < TRACERS) {
        printf(",\"peer\":\"%s\",", tracer_names[beside]);
        json_summary("peer_mrays_per_second", rate(c, t, beside));
        printf(",");
        json_summary("ratio", cell_ratio(c, t, beside));
        printf(",\"mismatches\":%zu,\"agreeing_percent\":%.7f,\"ulp_max\":%u,\"over_4_ulp\":%zu",
               c->agree[beside].hit_or_miss, agreeing(c, &c->agree[beside]),
               c->agree[beside].ulp_max, c->agree[beside].over_4_ulp);
    }
    if (c->threads > 1 && scaling(r, c, t, t->own).median > 0) {
        printf(",");
        json_summary("scaling", scaling(r, c, t, t->own));
        if (beside < TRACERS) printf(",");
        if (beside < TRACERS) json_summary("peer_scaling", scaling(r, c, t, beside));
    }
    printf(",\"nodes_per_ray\":%.4f,\"boxes_per_ray\":%.4f,\"triangles_per_ray\":%.4f,"
           "\"shapes_per_ray\":%.4f,\"cycles_per_ray\":%.2f",
           (double)c->counters.nodes / n, (double)c->counters.boxes / n,
           (double)c->counters.triangles / n, (double)c->counters.primitives / n,
           summarise(c->cycles, t->rounds).median);
    if (c->spoiled) {
        printf(",\"bad_rays\":%zu,\"bad_rays_wrong\":%zu,", c->spoiled, c->spoiled_wrong);
        json_summary("bad_rays_time", summarise(c->spoiled_time, t->rounds));
    }
    json_tracers(c, t);
    printf("}");
}

static void json_means(const scene_results *r, size_t count, const settings *t) {
    const char *comma = "";
    for (uint32_t i = 0; t->embree && i < t->threads_count; i++)
        for (int g = 0; g < GROUPS; g++) {
            mean m = mean_of(r, count, t, g, t->threads[i]);
            printf("%s{\"kinds\":\"%s\",\"threads\":%u,\"cells\":%u,\"ratio\":%.6g,"
                   "\"least\":%.6g,\"least_scene\":",
                   comma, groups[g].name, t->threads[i], m.cells, m.ratio, m.least);
            json_text(m.scene);
            printf(",\"least_kind\":\"%s\"}", m.kind);
            comma = ",\n ";
        }
}

void report_json(const scene_results *r, size_t count, const settings *t, const char *embree) {
    printf("{\"isa\":\"%s\",\"build\":\"%s\",\"batch\":%u,\"rounds\":%u,\"size\":%u,\"cycles_by\":"
           "\"%s\"",
           tracer_names[t->own], accel_quality_names[t->own_quality], t->batch, t->rounds, t->size,
           cycles_source());
    if (embree)
        printf(",\"embree\":\"%s\",\"embree_flags\":\"%s\",\"embree_quality\":\"%s\","
               "\"embree_packet\":%d",
               embree, PEER_FLAGS, quality_names[t->quality], PEER_PACKET);
    printf(",\n\"scenes\":[");
    for (size_t i = 0; i < count; i++) {
        if (i) printf(",\n ");
        json_scene(&r[i], t);
    }
    printf("],\n\"cells\":[");
    for (size_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < r[i].cell_count; k++) {
            if (i + k) printf(",\n ");
            json_cell(&r[i], &r[i].cells[k], t);
        }
    printf("],\n\"means\":[");
    json_means(r, count, t);
    printf("]}\n");
}
