/* The tree of rays as text. Each line is a ray or a light and begins with what it adds to the sample;
 * so the numbers stand under one another however deep the tree is. */
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "explain.h"
#include "report.h"
#include "text.h"

enum { TREE_DEPTH = 400, GROUPS = 64 };

#define PLAIN "\033[0m"
#define BOLD "\033[1m"
#define DIM "\033[2m"
#define RED "\033[31m"
#define YELLOW "\033[33m"
#define BLUE "\033[34m"
#define MAGENTA "\033[35m"
#define CYAN "\033[36m"

typedef struct printer {
    const explained *e;
    bool color;
    bool last[TREE_DEPTH]; /* of what is open: is it the last of its siblings? */
} printer;

static void paint(const printer *p, const char *code) {
    if (p->color) fputs(code, stdout);
}

/* ---- a line's beginning: what it adds, and its place in the tree ---- */

static void print_added(const printer *p, const double added[4], bool nothing) {
    paint(p, DIM);
    if (nothing) {
        printf("  %-27s", "");
    } else {
        printf(" ");
        for (int c = 0; c < 3; c++) printf(" %8.3g", added[c]);
    }
    paint(p, PLAIN);
    fputs("  ", stdout);
}

static void print_branch(const printer *p, int depth) {
    paint(p, DIM);
    for (int i = 1; i < depth && i < TREE_DEPTH; i++) fputs(p->last[i] ? "   " : "│  ", stdout);
    if (depth > 0)
        fputs(p->last[depth < TREE_DEPTH ? depth : TREE_DEPTH - 1] ? "└─ " : "├─ ", stdout);
    paint(p, PLAIN);
}

static void print_label(const printer *p, const snell_object_info *info) {
    char label[EXPLAIN_LABEL];
    paint(p, BOLD);
    fputs(explain_label(info, label), stdout);
    paint(p, PLAIN);
}

static bool is_one(const double c[3]) { return c[0] == 1 && c[1] == 1 && c[2] == 1; }
static bool is_zero(const double c[3]) { return c[0] == 0 && c[1] == 0 && c[2] == 0; }

static void print_factor(const char *name, const double color[3]) {
    char text[EXPLAIN_COLOR];
    printf(", %s %s", name, explain_color(color, text));
}

/* ---- lights ---- */

static void print_asked(const printer *p, const snell_explained_light *l) {
    char text[EXPLAIN_COLOR];
    fputs("light ", stdout);
    print_label(p, &l->light);
    if (isfinite(l->distance)) printf(" at %.4g m", l->distance);
    if (!l->tested && is_zero(l->contribution)) {
        paint(p, DIM);
        fputs(": the surface faces away", stdout);
        paint(p, PLAIN);
        return;
    }
    if (is_zero(l->visibility)) {
        paint(p, DIM);
        fputs(": in the shadow of ", stdout);
        print_label(p, &l->blocker);
        if (l->blocker.type[0] != '\0') printf(", %.4g m away", l->blocker_distance);
        return;
    }
    printf(": %s %s", l->pdf > 0 ? "L" : "E", explain_color(l->incoming, text));
    print_factor("f", l->bsdf);
    printf(", cos %.3g", l->cosine);
    if (l->weight != 1) printf(", weight %.3g", l->weight);
    if (l->pdf > 0) printf(" (pdf %.3g)", l->pdf);
    if (l->choice < 1) printf(", chosen with %.3g", l->choice);
    if (!is_one(l->visibility)) print_factor("comes through", l->visibility);
}

static void print_light(const printer *p, const snell_explained_light *l, int depth) {
    char text[EXPLAIN_COLOR];
    print_added(p, l->contribution, false);
    print_branch(p, depth);
    paint(p, YELLOW);
    if (l->source == SNELL_SOURCE_LIGHT) {
        print_asked(p, l);
    } else if (l->source == SNELL_SOURCE_COVERAGE) {
        printf("covers %.3g of the pixel", l->contribution[3]);
    } else {
        printf("%s: %s", explain_source(l->source), explain_color(l->incoming, text));
        if (l->weight != 1) printf(", weight %.3g", l->weight);
    }
    paint(p, PLAIN);
    putchar('\n');
}

/* ---- rays ---- */

static const char *kind_color(snell_ray_kind kind) {
    static const char *const codes[] = {"", "", CYAN, BLUE, MAGENTA};
    return codes[kind];
}

static void print_surface(const printer *p, const snell_explained_ray *r) {
    print_label(p, &r->shape);
    if (r->material.type[0] != '\0') {
        char label[EXPLAIN_LABEL];
        snell_object_info material = r->material;
        material.line = 0;
        printf(" (%s%s%s)", r->material.type, material.name[0] != '\0' ? " " : "",
               material.name[0] != '\0' ? explain_label(&material, label) : "");
    }
    if (r->inside) fputs(" from inside", stdout);
    printf(" at %.4g m", r->distance);
}

static void print_hit(const printer *p, const snell_explained_ray *r) {
    print_surface(p, r);
    printf(", %.1f°", acos(r->cosine < 1 ? r->cosine : 1) * 180 / 3.14159265358979323846);
    if (r->ior_from != r->ior_to) printf(", ior %.4g → %.4g", r->ior_from, r->ior_to);
    if (!is_zero(r->fresnel)) print_factor("Fresnel", r->fresnel);
    if (r->alpha < 1) printf(", alpha %.3g", r->alpha);
}

/* What it sees stands on its own line. */
static const snell_explained_light *sky_of(const printer *p, const snell_explained_ray *r) {
    bool seen = r->end == SNELL_RAY_LEFT && r->light_count == 1;
    const snell_explained_light *l = &p->e->lights[r->first_light];
    return seen && l->source == SNELL_SOURCE_SKY ? l : NULL;
}

static void print_sky(const printer *p, const snell_explained_ray *r) {
    char text[EXPLAIN_COLOR];
    const snell_explained_light *l = sky_of(p, r);
    if (l == NULL) {
        fputs("leaves the scene", stdout);
        return;
    }
    paint(p, YELLOW);
    if (l->light.type[0] != '\0')
        print_label(p, &l->light);
    else
        fputs("the sky", stdout);
    printf(": %s", explain_color(l->incoming, text));
    paint(p, PLAIN);
}

static void print_end(const printer *p, const snell_explained_ray *r) {
    switch (r->end) {
    case SNELL_RAY_HIT: print_hit(p, r); break;
    case SNELL_RAY_PASSED:
        fputs("passes ", stdout);
        print_surface(p, r);
        if (r->alpha < 1) printf(", alpha %.3g", r->alpha);
        break;
    case SNELL_RAY_LEFT: print_sky(p, r); break;
    case SNELL_RAY_TOO_DEEP: fputs("not traced: deeper than max_depth", stdout); break;
    case SNELL_RAY_TOO_FAINT: fputs("not traced: under min_weight", stdout); break;
    }
}

static void print_ray(const printer *p, const snell_explained_ray *r, int depth) {
    char text[EXPLAIN_COLOR];
    const snell_explained_ray *from = explain_origin(p->e, r);
    bool traced = r->end != SNELL_RAY_TOO_DEEP && r->end != SNELL_RAY_TOO_FAINT;
    print_added(p, r->radiance, !traced);
    print_branch(p, depth);
    paint(p, kind_color(r->kind));
    if (r->kind == SNELL_RAY_CAMERA)
        fputs("camera", stdout);
    else
        printf("%s × %s", explain_kind(r->kind), explain_color(r->weight, text));
    if (from != NULL && (r->kind == SNELL_RAY_REFRACTED || r->kind == SNELL_RAY_REFLECTED))
        printf(" at %.1f°", explain_angle(r->direction, from->normal));
    if (r->pdf > 0) printf(" (pdf %.3g)", r->pdf);
    paint(p, PLAIN);
    fputs(" ─▶ ", stdout);
    if (!traced) paint(p, DIM);
    print_end(p, r);
    if (!is_one(r->transmittance)) print_factor("Beer", r->transmittance);
    const double carried[3] = {(double)r->throughput.x, (double)r->throughput.y,
                               (double)r->throughput.z};
    /* Of the first child without anything on its way it is the weight that stands there. */
    bool known = r->depth <= 1 && is_one(r->transmittance) && r->kind != SNELL_RAY_CONTINUED;
    if (!known) print_factor("throughput", carried);
    paint(p, PLAIN);
    putchar('\n');
}

/* ---- trees ---- */

/* What deeper rays that are not shown add. */
static void print_cut(const printer *p, const snell_explained_ray *children, uint32_t count,
                      int depth) {
    double added[4] = {0, 0, 0, 0};
    uint32_t rays = 0;
    for (uint32_t i = 0; i < count; i += children[i].ray_count) {
        for (int c = 0; c < 4; c++) added[c] += children[i].radiance[c];
        rays += children[i].ray_count;
    }
    print_added(p, added, false);
    print_branch(p, depth);
    paint(p, DIM);
    printf("… %" PRIu32 " deeper ray%s (--levels %" PRIu32 ")", rays, rays == 1 ? "" : "s",
           p->e->levels + 1);
    paint(p, PLAIN);
    putchar('\n');
}

static void print_tree(printer *p, const snell_explained_ray *r, int depth) {
    const explained *e = p->e;
    print_ray(p, r, depth);
    uint32_t children = r->ray_count - 1, left = sky_of(p, r) ? 0 : r->light_count;
    bool cut = children > 0 && !explain_shows(e, r + 1);
    int next = depth + 1;
    for (uint32_t i = 0; left > 0; i++) {
        left--;
        if (next < TREE_DEPTH) p->last[next] = left == 0 && children == 0;
        print_light(p, &e->lights[r->first_light + i], next);
    }
    if (cut && next < TREE_DEPTH) p->last[next] = true;
    if (cut) {
        print_cut(p, r + 1, children, next);
        return;
    }
    for (uint32_t i = 1; i < r->ray_count; i += r[i].ray_count) {
        if (next < TREE_DEPTH) p->last[next] = i + r[i].ray_count == r->ray_count;
        print_tree(p, &r[i], next);
    }
}

/* ---- the pixel, and its samples ---- */

static void print_pixel(const printer *p) {
    const explained *e = p->e;
    const snell_render_desc *d = &e->stage->desc;
    paint(p, BOLD);
    printf("pixel %" PRIu32 ",%" PRIu32, e->x, e->y);
    paint(p, PLAIN);
    fputs(" of ", stdout);
    text_print_safe(stdout, session_label(e->file));
    printf(", %s, %" PRIu32 " sample%s:", integrator_name(d->integrator), e->sample_count,
           e->sample_count == 1 ? "" : "s");
    paint(p, BOLD);
    for (uint32_t c = 0; c < e->channels; c++) {
        char number[32];
        text_format_float(e->pixel[c], number);
        printf(" %s", number);
    }
    paint(p, PLAIN);
    putchar('\n');
}

/* Where a sample's camera ray came to an end, past what it walked through. */
static const snell_explained_ray *first_end(const explained *e, uint32_t sample) {
    const snell_explained_sample *s = &e->samples[sample];
    if (s->ray_count == 0) return NULL;
    const snell_explained_ray *r = &e->rays[s->first_ray], *end = r + s->ray_count;
    while (r->end == SNELL_RAY_PASSED && r + 1 < end && r[1].kind == SNELL_RAY_CONTINUED) r++;
    return r;
}

typedef struct group {
    const snell_explained_ray *like;
    uint32_t count;
    double sum[3];
} group;

static bool alike(const snell_explained_ray *a, const snell_explained_ray *b) {
    if (a == NULL || b == NULL) return a == b;
    bool on_surface = a->end == SNELL_RAY_HIT;
    if (on_surface != (b->end == SNELL_RAY_HIT)) return false;
    return !on_surface || (a->hit.number == b->hit.number && a->material.line == b->material.line);
}

static uint32_t find_groups(const explained *e, group groups[GROUPS]) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < e->sample_count; i++) {
        const snell_explained_ray *end = first_end(e, i);
        uint32_t k = 0;
        while (k < count && !alike(groups[k].like, end)) k++;
        if (k == GROUPS) k = GROUPS - 1; /* the last holds all others */
        if (k == count) groups[count++] = (group){.like = end};
        groups[k].count++;
        for (int c = 0; c < 3; c++) groups[k].sum[c] += e->samples[i].radiance[c];
    }
    return count;
}

static double brightness(const snell_explained_sample *s) {
    return 0.2126 * s->radiance[0] + 0.7152 * s->radiance[1] + 0.0722 * s->radiance[2];
}

static void print_samples(const printer *p) {
    const explained *e = p->e;
    group groups[GROUPS];
    uint32_t count = find_groups(e, groups), dark = 0, bright = 0;
    puts("      mean of samples         samples  meet first");
    for (uint32_t i = 0; i < count; i++) {
        double mean[4] = {0, 0, 0, 0};
        for (int c = 0; c < 3; c++) mean[c] = groups[i].sum[c] / groups[i].count;
        print_added(p, mean, false);
        printf("%7" PRIu32 "  ", groups[i].count);
        if (i == GROUPS - 1)
            fputs("others", stdout);
        else if (groups[i].like == NULL)
            fputs("nothing: the camera sees nothing there", stdout);
        else if (groups[i].like->end != SNELL_RAY_HIT)
            fputs("nothing", stdout);
        else
            print_label(p, &groups[i].like->shape);
        putchar('\n');
    }
    for (uint32_t i = 1; i < e->sample_count; i++) {
        if (brightness(&e->samples[i]) < brightness(&e->samples[dark])) dark = i;
        if (brightness(&e->samples[i]) > brightness(&e->samples[bright])) bright = i;
    }
    if (dark != bright)
        printf("darkest is sample %" PRIu32 ", brightest %" PRIu32 ": --sample N draws one\n", dark,
               bright);
}

int explain_text(const explained *e) {
    printer p = {.e = e, .color = report_color(STDOUT_FILENO)};
    print_pixel(&p);
    if (!e->has_sample && e->sample_count > 1) {
        print_samples(&p);
        printf("\nsample %" PRIu32 ", nearest to the mean\n", e->sample);
    } else if (e->sample_count > 1) {
        printf("sample %" PRIu32 "\n", e->sample);
    }
    const snell_explained_sample *s = &e->samples[e->sample];
    if (s->ray_count > 0) print_tree(&p, &e->rays[s->first_ray], 0);
    if (s->ray_count == 0) puts("the camera sends no ray there");
    return EXIT_DONE;
}
