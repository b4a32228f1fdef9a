/* The rays of one sample as a drawing. From the side and from the top the scene is a section: the line
 * along which its surfaces cut the upright plane of the camera's ray, or the level plane of the first
 * hit. From the camera it is the picture itself. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "explain.h"
#include "report.h"

enum { WIDTH = 800, HEIGHT = 560, STEP = 3 /* between two lines of the section, pixels */ };
enum { SECTION_HITS = 400 /* on one line, at most */, PIECES = 24 /* of a ray, from the camera */ };
enum { CAMERA_WIDTH = 800, CAMERA_SAMPLES = 4 };

typedef struct dvec3 {
    double x, y, z;
} dvec3;

static dvec3 from_vec3(snell_vec3 v) { return (dvec3){(double)v.x, (double)v.y, (double)v.z}; }
static snell_vec3 to_vec3(dvec3 v) { return (snell_vec3){(float)v.x, (float)v.y, (float)v.z}; }
static double dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static dvec3 along(dvec3 p, dvec3 d, double t) {
    return (dvec3){p.x + d.x * t, p.y + d.y * t, p.z + d.z * t};
}

typedef struct point {
    double x, y;
} point;

/* Where on the sheet a point of the world is. */
typedef struct sheet {
    const explained *e;
    bool by_camera;
    dvec3 u, v, origin;      /* of a section: its axes, unit; a point of it */
    double left, top, scale; /* u of the left edge, v of the top one, pixels per metre */
    double width, height;    /* pixels */
    snell_render_desc desc;  /* by_camera: of the picture behind */
} sheet;

/* ---- what is drawn: the rays of the sample that have a way ---- */

static const snell_explained_sample *sample_of(const explained *e) {
    return &e->samples[e->sample];
}

static bool is_drawn(const explained *e, const snell_explained_ray *r) {
    return explain_shows(e, r) && r->end <= SNELL_RAY_LEFT;
}

static bool has_end(const snell_explained_ray *r) { return isfinite(r->distance); }

static dvec3 end_of(const snell_explained_ray *r) {
    return along(from_vec3(r->origin), from_vec3(r->direction), r->distance);
}

/* ---- sections ---- */

static void set_axes(sheet *s, const snell_explained_ray *camera, bool from_top) {
    dvec3 d = from_vec3(camera->direction), level = {d.x, 0, d.z};
    double length = sqrt(dot(level, level));
    /* Straight up or down: the drawing's right is that of the world. */
    s->u = length > 1e-6 ? (dvec3){level.x / length, 0, level.z / length} : (dvec3){1, 0, 0};
    s->v = from_top ? (dvec3){s->u.z, 0, -s->u.x} : (dvec3){0, 1, 0};
    s->origin = has_end(camera) ? end_of(camera) : from_vec3(camera->origin);
}

static point to_plane(const sheet *s, dvec3 p) { return (point){dot(p, s->u), dot(p, s->v)}; }

typedef struct frame {
    double left, right, bottom, top;
} frame;

static void include(frame *f, point p) {
    f->left = fmin(f->left, p.x);
    f->right = fmax(f->right, p.x);
    f->bottom = fmin(f->bottom, p.y);
    f->top = fmax(f->top, p.y);
}

/* Everything that rays meet, with some room around; the eye only if it is near. */
static void set_frame(sheet *s) {
    const explained *e = s->e;
    const snell_explained_sample *sample = sample_of(e);
    frame f = {INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (uint32_t i = 0; i < sample->ray_count; i++) {
        const snell_explained_ray *r = &e->rays[sample->first_ray + i];
        if (is_drawn(e, r) && has_end(r)) include(&f, to_plane(s, end_of(r)));
    }
    const snell_explained_ray *camera = &e->rays[sample->first_ray];
    point eye = to_plane(s, from_vec3(camera->origin));
    if (!(f.left <= f.right)) include(&f, eye);
    double size = fmax(f.right - f.left, f.top - f.bottom);
    double distance = has_end(camera) ? camera->distance : 1;
    if (!(size > 1e-3 * distance)) size = distance / 2;
    if (hypot(eye.x - (f.left + f.right) / 2, eye.y - (f.bottom + f.top) / 2) < 1.5 * size)
        include(&f, eye);
    f.left -= 0.3 * size, f.right += 0.3 * size;
    f.bottom -= 0.3 * size, f.top += 0.3 * size;
    s->width = WIDTH, s->height = HEIGHT;
    s->scale = fmin(WIDTH / (f.right - f.left), HEIGHT / (f.top - f.bottom));
    s->left = (f.left + f.right) / 2 - WIDTH / (2 * s->scale);
    s->top = (f.bottom + f.top) / 2 + HEIGHT / (2 * s->scale);
}

/* The point of the section that lies at a place of the sheet. */
static dvec3 from_sheet(const sheet *s, double x, double y) {
    double u = s->left + x / s->scale - dot(s->origin, s->u),
           v = s->top - y / s->scale - dot(s->origin, s->v);
    return along(along(s->origin, s->u, u), s->v, v);
}

static point to_sheet(const sheet *s, dvec3 p) {
    point at = to_plane(s, p);
    return (point){(at.x - s->left) * s->scale, (s->top - at.y) * s->scale};
}

/* A dash along the surface, where a line meets it steeply enough: the lines the other way have the
 * rest. */
static void print_dash(const sheet *s, const snell_ray *line, const snell_hit *hit, bool level) {
    dvec3 n = from_vec3(hit->normal);
    double nu = dot(n, s->u), nv = dot(n, s->v), length = hypot(nu, nv);
    double across = level ? nu : nv; /* the sine of the dash to the line */
    if (!(fabs(across) >= 0.7 * length) || !(length > 1e-3)) return;
    point at =
        to_sheet(s, along(from_vec3(line->origin), from_vec3(line->direction), (double)hit->t));
    double reach = 0.6 * STEP / fabs(across), dx = -nv * reach, dy = -nu * reach;
    printf("M%.1f %.1fl%.1f %.1f", at.x - dx, at.y - dy, 2 * dx, 2 * dy);
}

/* All hits of `count` parallel lines. */
static int print_hits(const sheet *s, snell_ray *lines, snell_hit *hits, size_t count, bool level) {
    float least = (float)(1e-3 * STEP / s->scale);
    for (int round = 0; round < SECTION_HITS && count > 0; round++) {
        int code = stage_status(s->e->stage,
                                snell_scene_intersect_all(s->e->stage->scene, lines, hits, count));
        if (code != EXIT_DONE) return code;
        size_t left = 0;
        for (size_t i = 0; i < count; i++) {
            if (isinf(hits[i].t)) continue;
            print_dash(s, &lines[i], &hits[i], level);
            lines[left] = lines[i];
            lines[left++].t_min = hits[i].t + least;
        }
        count = left;
    }
    return EXIT_DONE;
}

static int print_section(const sheet *s) {
    enum { LINES = (WIDTH > HEIGHT ? WIDTH : HEIGHT) / STEP + 1 };
    snell_ray lines[LINES];
    snell_hit hits[LINES];
    const snell_explained_ray *camera = &s->e->rays[sample_of(s->e)->first_ray];
    int code = EXIT_DONE;
    fputs("<path class=\"section\" d=\"", stdout);
    for (int level = 0; level < 2 && code == EXIT_DONE; level++) {
        size_t count = (size_t)(level ? s->height : s->width) / STEP;
        dvec3 d = level ? s->u : (dvec3){-s->v.x, -s->v.y, -s->v.z};
        for (size_t i = 0; i < count; i++) {
            double place = ((double)i + 0.5) * STEP;
            dvec3 o = level ? from_sheet(s, 0, place) : from_sheet(s, place, 0);
            lines[i] = (snell_ray){.origin = to_vec3(o),
                                   .direction = to_vec3(d),
                                   .t_max = (float)((level ? s->width : s->height) / s->scale),
                                   .time = camera->time,
                                   .mask = 1};
        }
        code = print_hits(s, lines, hits, count, level);
    }
    puts("\"/>");
    return code;
}

/* ---- the picture behind, from the camera ---- */

static void print_base64(const unsigned char *data, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t word = (uint32_t)data[i] << 16;
        if (left > 1) word |= (uint32_t)data[i + 1] << 8;
        if (left > 2) word |= data[i + 2];
        putchar(digits[word >> 18]);
        putchar(digits[word >> 12 & 63]);
        putchar(left > 1 ? digits[word >> 6 & 63] : '=');
        putchar(left > 2 ? digits[word & 63] : '=');
    }
}

/* As large as the picture, or smaller; with few samples, since it is only what is behind. */
static void set_camera(sheet *s) {
    snell_render_desc *d = &s->desc;
    *d = s->e->stage->desc;
    if (d->crop_width == 0 && d->width > CAMERA_WIDTH) {
        d->height = (uint32_t)fmax(1, (double)d->height * CAMERA_WIDTH / d->width + 0.5);
        d->width = CAMERA_WIDTH;
    }
    d->noise = 0;
    if (d->samples > CAMERA_SAMPLES) d->samples = CAMERA_SAMPLES;
    s->width = d->crop_width ? d->crop_width : d->width;
    s->height = d->crop_width ? d->crop_height : d->height;
}

static int print_picture(const sheet *s) {
    stage *set = s->e->stage;
    snell_film *film = NULL;
    snell_image_desc image = stage_image(set);
    void *data = NULL;
    size_t size = 0;
    snell_status status = snell_film_create(set->session->context, &film);
    if (status == SNELL_OK) status = snell_render(set->scene, &s->desc, film);
    if (status == SNELL_OK) status = snell_film_encode(film, "png", &image, &data, &size);
    if (status == SNELL_OK) {
        printf("<image width=\"%.0f\" height=\"%.0f\" href=\"data:image/png;base64,", s->width,
               s->height);
        print_base64(data, size);
        puts("\"/>");
    }
    snell_free(data);
    snell_film_destroy(film);
    return stage_status(set, status);
}

/* ---- rays ---- */

static void print_safe(const char *text) {
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '<')
            fputs("&lt;", stdout);
        else if (*c == '&')
            fputs("&amp;", stdout);
        else
            putchar(*c);
    }
}

/* A straight way through the world: of a section two points, from the camera many. */
static void print_way(const sheet *s, dvec3 from, dvec3 to) {
    if (!s->by_camera) {
        point a = to_sheet(s, from), b = to_sheet(s, to);
        printf("M%.1f %.1fL%.1f %.1fL%.1f %.1f", a.x, a.y, (a.x + b.x) / 2, (a.y + b.y) / 2, b.x,
               b.y);
        return;
    }
    snell_vec3 points[PIECES + 1];
    snell_vec2 pixels[PIECES + 1];
    for (int i = 0; i <= PIECES; i++) {
        double t = (double)i / PIECES;
        points[i] = to_vec3((dvec3){from.x + t * (to.x - from.x), from.y + t * (to.y - from.y),
                                    from.z + t * (to.z - from.z)});
    }
    if (snell_scene_project(s->e->stage->scene, &s->desc, points, pixels, PIECES + 1) != SNELL_OK)
        return;
    bool on = false; /* a way that goes round the back comes in again elsewhere */
    for (int i = 0; i <= PIECES; i++) {
        double x = (double)pixels[i].x, y = (double)pixels[i].y;
        bool near =
            on && hypot(x - (double)pixels[i - 1].x, y - (double)pixels[i - 1].y) < s->width;
        if (isnan(x) || fabs(x) > 1e5 || fabs(y) > 1e5) {
            on = false;
            continue;
        }
        printf("%c%.1f %.1f", near ? 'L' : 'M', x, y);
        on = true;
    }
}

/* How far a ray that leaves is drawn. */
static double far_off(const sheet *s) {
    if (!s->by_camera) return 2 * (s->width + s->height) / s->scale;
    const snell_explained_ray *camera = &s->e->rays[sample_of(s->e)->first_ray];
    return has_end(camera) ? camera->distance : 10;
}

static double opacity(double throughput) { return fmin(1, fmax(0.3, pow(throughput, 0.3))); }

static double largest(const double c[3]) { return fmax(c[0], fmax(c[1], c[2])); }

static void print_ray(const sheet *s, const snell_explained_ray *r) {
    char label[EXPLAIN_LABEL], weight[EXPLAIN_COLOR];
    const double carried[3] = {(double)r->throughput.x, (double)r->throughput.y,
                               (double)r->throughput.z};
    dvec3 from = from_vec3(r->origin);
    dvec3 to = has_end(r) ? end_of(r) : along(from, from_vec3(r->direction), far_off(s));
    printf("<path class=\"%s\" stroke-opacity=\"%.2f\" d=\"", explain_kind(r->kind),
           opacity(largest(carried)));
    print_way(s, from, to);
    printf("\"><title>%s × %s", explain_kind(r->kind), explain_color(r->weight, weight));
    fputs(r->end == SNELL_RAY_LEFT ? " leaves" : " to ", stdout);
    if (r->end != SNELL_RAY_LEFT) print_safe(explain_label(&r->shape, label));
    printf(", adds %.3g %.3g %.3g</title></path>\n", r->radiance[0], r->radiance[1],
           r->radiance[2]);
}

static void print_light(const sheet *s, const snell_explained_light *l) {
    char label[EXPLAIN_LABEL];
    if (l->source != SNELL_SOURCE_LIGHT || !l->tested) return;
    bool dark = !(largest(l->visibility) > 0);
    dvec3 from = from_vec3(s->e->rays[l->ray].position), d = from_vec3(l->direction);
    double distance = dark && l->blocker.type[0] != '\0' ? l->blocker_distance
                      : isfinite(l->distance)            ? l->distance
                                                         : far_off(s);
    printf("<path class=\"%s\" d=\"", dark ? "shadow" : "light");
    print_way(s, from, along(from, d, distance));
    fputs("\"><title>", stdout);
    print_safe(explain_label(&l->light, label));
    if (dark) {
        fputs(", behind ", stdout);
        print_safe(explain_label(&l->blocker, label));
    }
    fputs("</title></path>\n", stdout);
}

/* ---- names ---- */

enum { NAMES_MAX = 24, LETTER = 7, LINE = 14 /* pixels, about */ };

typedef struct name {
    point at;
    double width;
} name;

static bool overlaps(const name *a, const name *b) {
    return a->at.x < b->at.x + b->width && b->at.x < a->at.x + a->width &&
           fabs(a->at.y - b->at.y) < LINE;
}

/* Upwards, until it covers no other. */
static void make_room(const name *names, uint32_t count, name *wanted) {
    for (uint32_t i = 0; i < count; i++) {
        if (!overlaps(&names[i], wanted)) continue;
        wanted->at.y = names[i].at.y - LINE;
        i = UINT32_MAX; /* again from the first */
    }
}

static bool is_met(const explained *e, const snell_explained_ray *r) {
    return is_drawn(e, r) && has_end(r);
}

static bool is_new(const explained *e, const snell_explained_ray *first,
                   const snell_explained_ray *r) {
    if (!is_met(e, r)) return false;
    for (; first < r; first++)
        if (is_met(e, first) && first->hit.number == r->hit.number) return false;
    return true;
}

static bool place_of(const sheet *s, const snell_explained_ray *r, point *out) {
    snell_vec3 position = to_vec3(end_of(r));
    snell_vec2 pixel;
    if (!s->by_camera) {
        *out = to_sheet(s, end_of(r));
        return true;
    }
    if (snell_scene_project(s->e->stage->scene, &s->desc, &position, &pixel, 1) != SNELL_OK)
        return false;
    *out = (point){(double)pixel.x, (double)pixel.y};
    return !isnan(pixel.x);
}

/* The names of what is met, once each, where it is met first. */
static void print_names(const sheet *s) {
    const explained *e = s->e;
    const snell_explained_ray *first = &e->rays[sample_of(e)->first_ray];
    name names[NAMES_MAX];
    uint32_t count = 0;
    for (uint32_t i = 0; i < sample_of(e)->ray_count && count < NAMES_MAX; i++) {
        char label[EXPLAIN_LABEL];
        name *made = &names[count];
        if (!is_new(e, first, &first[i]) || !place_of(s, &first[i], &made->at)) continue;
        explain_label(&first[i].shape, label);
        made->at.x += 6, made->at.y -= 6;
        made->width = LETTER * (double)strlen(label);
        make_room(names, count++, made);
        printf("<text x=\"%.1f\" y=\"%.1f\">", made->at.x, made->at.y);
        print_safe(label);
        puts("</text>");
    }
}

static void print_head(const sheet *s) {
    static const char style[] =
        "path{fill:none;stroke-width:1.5}.section{stroke:#999;stroke-width:2;stroke-linecap:round}"
        ".camera{stroke:#000}.reflected{stroke:#0a8f8f}.refracted{stroke:#1f4fd8}"
        ".continued{stroke:#8a2be2}.light{stroke:#e69500;stroke-dasharray:5 3}"
        ".shadow{stroke:#888;stroke-dasharray:2 4}"
        "text{font:12px sans-serif;fill:#333;stroke:#fff;stroke-width:3;paint-order:stroke}";
    printf("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
           "viewBox=\"0 0 %.0f %.0f\">\n<style>%s</style>\n<defs><marker id=\"arrow\" "
           "viewBox=\"0 0 8 8\" refX=\"4\" refY=\"4\" markerWidth=\"5\" markerHeight=\"5\" "
           "orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" style=\"fill:context-stroke;stroke:none\"/>"
           "</marker></defs>\n",
           s->width, s->height, s->width, s->height, style);
    printf("<title>pixel %" PRIu32 ",%" PRIu32 ", sample %" PRIu32 "</title>\n", s->e->x, s->e->y,
           s->e->sample);
    if (!s->by_camera)
        printf("<rect width=\"%.0f\" height=\"%.0f\" fill=\"#fff\"/>\n", s->width, s->height);
}

static void print_rays(const sheet *s) {
    const explained *e = s->e;
    const snell_explained_sample *sample = sample_of(e);
    puts(s->by_camera ? "<g>" : "<g marker-mid=\"url(#arrow)\">");
    for (uint32_t i = 0; i < sample->ray_count; i++) {
        const snell_explained_ray *r = &e->rays[sample->first_ray + i];
        if (!is_drawn(e, r)) continue;
        for (uint32_t k = 0; k < r->light_count; k++)
            print_light(s, &e->lights[r->first_light + k]);
        if (!s->by_camera || r->parent != UINT32_MAX) print_ray(s, r);
    }
    puts("</g>");
    if (s->by_camera) {
        double scale = s->width / (e->stage->desc.crop_width ? e->stage->desc.crop_width
                                                             : e->stage->desc.width);
        printf("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" fill=\"none\" stroke=\"#f0f\"/>\n",
               (e->x + 0.5) * scale, (e->y + 0.5) * scale);
    }
    print_names(s);
}

int explain_svg(const explained *e, const char *view) {
    sheet s = {.e = e, .by_camera = strcmp(view, "camera") == 0};
    if (sample_of(e)->ray_count == 0)
        return report_error(EXIT_INPUT, "choose another pixel",
                            "the camera sends no ray there: nothing can be drawn");
    if (s.by_camera) {
        set_camera(&s);
    } else {
        set_axes(&s, &e->rays[sample_of(e)->first_ray], strcmp(view, "top") == 0);
        set_frame(&s);
    }
    print_head(&s);
    int code = s.by_camera ? print_picture(&s) : print_section(&s);
    if (code == EXIT_DONE) print_rays(&s);
    puts("</svg>");
    return code;
}
