/* What stands before pbrt's WorldBegin: camera, film, sampler, integrator, filter. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "importers/pbrt.h"
#include "maths/functions.h"

/* pbrt's own defaults where a file says nothing. */
enum { WIDTH = 1280, HEIGHT = 720, SAMPLES = 16, DEPTH = 5 };

typedef struct screen { /* in pbrt's screen space; the picture's shorter side is -1 to 1 */
    double x0, x1, y0, y1;
} screen;

typedef struct view {
    int width, height, samples, depth, seed;
    const char *filter;
    double filter_radius;
} view;

/* ---- settings ---- */

/* Radiance to the film's values: exposure time times sensitivity, 1 for pbrt's defaults. */
static void read_sensor(pbrt *p) {
    double open = pbrt_float(p, &p->camera, "shutteropen", 0),
           close = pbrt_float(p, &p->camera, "shutterclose", 1),
           iso = pbrt_float(p, &p->film, "iso", 100),
           white = pbrt_float(p, &p->film, "whitebalance", 0);
    const char *sensor = pbrt_string(p, &p->film, "sensor", "cie1931");
    if (!p->status && !(close > open))
        pbrt_fail(p, p->camera.place, "'shutterclose' is later than 'shutteropen'",
                  "the camera's shutter does not open");
    if (!p->status && !(iso > 0 && iso < 1e9))
        pbrt_fail(p, p->film.place, NULL, "the film's 'iso' is above 0");
    if (p->status) return;
    p->shutter[0] = open, p->shutter[1] = close;
    p->light_factor = (close - open) * iso / 100;
    for (int i = 0; i < 3; i++) p->white[i] = 1;
    if (white > 0 && strcmp(sensor, "cie1931") == 0) pbrt_white_balance(white, p->white);
    if (strcmp(sensor, "cie1931") != 0)
        pbrt_warn(p, p->film.place,
                  "the colours of cameras' sensors are not supported: CIE 1931 is used");
}

/* A crop is for the command to say: which one. */
static void warn_of_crop(pbrt *p, const view *v) {
    size_t part_count, pixel_count;
    const double *part = pbrt_numbers(p, &p->film, "cropwindow", 4, &part_count),
                 *pixel = pbrt_numbers(p, &p->film, "pixelbounds", 4, &pixel_count);
    double box[4], size[4] = {v->width, v->width, v->height, v->height};
    if (p->status || (part_count != 1 && pixel_count != 1)) return;
    for (int i = 0; i < 4; i++) {
        box[i] = part_count ? ceil(size[i] * clamp01(part[i])) : pixel[i];
        box[i] = double_min(double_max(box[i], 0), size[i]);
    }
    pbrt_warn(
        p, p->film.place,
        "the film's crop is not read: the whole picture is made ('--crop %.0fx%.0f+%.0f+%.0f' "
        "is its part)",
        box[1] - box[0], box[3] - box[2], box[0], box[2]);
}

static void read_film(pbrt *p, view *v) {
    v->width = pbrt_int(p, &p->film, "xresolution", WIDTH);
    v->height = pbrt_int(p, &p->film, "yresolution", HEIGHT);
    if (!p->status && (v->width < 1 || v->width > 65536 || v->height < 1 || v->height > 65536))
        pbrt_fail(p, p->film.place, "both are 1 to 65536", "a film cannot have %d x %d pixels",
                  v->width, v->height);
    warn_of_crop(p, v);
    pbrt_ignore(&p->film, "filename savefp16 diagonal maxcomponentvalue coordinatesystem lambdamin "
                          "lambdamax nbuckets");
}

static void read_sampler(pbrt *p, view *v) {
    const char *type = p->sampler.type[0] ? p->sampler.type : "zsobol";
    bool stratified = strcmp(type, "stratified") == 0;
    v->samples = strcmp(type, "independent") == 0 ? 4 : SAMPLES;
    v->samples = pbrt_int(p, &p->sampler, "pixelsamples", v->samples);
    double x = pbrt_int(p, &p->sampler, "xsamples", 4), y = pbrt_int(p, &p->sampler, "ysamples", 4);
    if (stratified) v->samples = (int)double_min(double_max(x * y, 0), 1e9);
    v->seed = pbrt_int(p, &p->sampler, "seed", 0);
    if (!p->status && (v->samples < 1 || v->samples > 1 << 20))
        pbrt_fail(p, p->sampler.place, NULL, "a pixel has 1 to %d samples, not %d", 1 << 20,
                  v->samples);
    if (v->seed < 0) v->seed = 0;
    pbrt_ignore(&p->sampler, "randomization jitter");
}

static void read_integrator(pbrt *p, view *v) {
    static const char *const as_path[] = {"path",       "volpath", "simplepath", "simplevolpath",
                                          "lightpath",  "bdpt",    "mlt",        "sppm",
                                          "randomwalk", ""};
    size_t i = 0, count = sizeof as_path / sizeof as_path[0];
    while (i < count && strcmp(as_path[i], p->integrator.type) != 0) i++;
    if (i == count)
        pbrt_warn(p, p->integrator.place, "the integrator '%s' is not supported: 'path' is used",
                  p->integrator.type);
    /* pbrt counts bounces, and a path's last one is not lit any more. */
    v->depth = pbrt_int(p, &p->integrator, "maxdepth", DEPTH) - 1;
    v->depth = v->depth < 0 ? 0 : v->depth > 1000 ? 1000 : v->depth;
    for (pbrt_param *param = p->integrator.own; param; param = param->next) param->used = true;
}

static void read_filter(pbrt *p, view *v) {
    static const struct {
        const char *pbrt, *snell;
        double radius; /* pbrt's default */
    } known[] = {{"gaussian", "gaussian", 1.5},
                 {"", "gaussian", 1.5},
                 {"box", "box", 0.5},
                 {"triangle", "tent", 2},
                 {"mitchell", "blackman-harris", 2},
                 {"sinc", "blackman-harris", 4}};
    size_t i = 0, count = sizeof known / sizeof known[0];
    while (i < count && strcmp(known[i].pbrt, p->filter.type) != 0) i++;
    if (i == count) {
        pbrt_fail(p, p->filter.place, "it is box, triangle, gaussian, mitchell or sinc",
                  "unknown filter '%s'", p->filter.type);
        return;
    }
    double x = pbrt_float(p, &p->filter, "xradius", known[i].radius),
           y = pbrt_float(p, &p->filter, "yradius", known[i].radius),
           sigma = pbrt_float(p, &p->filter, "sigma", 0.5);
    v->filter = known[i].snell;
    v->filter_radius = (x + y) / 2;
    if (strcmp(v->filter, "gaussian") == 0) v->filter_radius = 3 * sigma;
    if (strcmp(v->filter, "blackman-harris") == 0) {
        v->filter_radius = 1.5;
        pbrt_warn(p, p->filter.place,
                  "filters with negative parts are not supported: blackman-harris is used");
    }
    if (!p->status && !(v->filter_radius > 0 && v->filter_radius <= 16))
        pbrt_fail(p, p->filter.place, NULL, "a filter's radius is above 0, at most 16 pixels");
    pbrt_ignore(&p->filter, "B C tau");
}

static object_source source_at(source_place place) {
    return (object_source){NULL, place.file, place.line};
}

static snell_status add_render(pbrt *p, const view *v) {
    const snell_param params[] = {
        {"integrator", SNELL_PARAM_STRING, {.s = "path"}},
        {"width", SNELL_PARAM_INT, {.i = v->width}},
        {"height", SNELL_PARAM_INT, {.i = v->height}},
        {"samples", SNELL_PARAM_INT, {.i = v->samples}},
        {"max_depth", SNELL_PARAM_INT, {.i = v->depth}},
        {"seed", SNELL_PARAM_INT, {.i = v->seed}},
        {"filter", SNELL_PARAM_STRING, {.s = v->filter}},
        {"filter_radius", SNELL_PARAM_FLOAT, {.f = v->filter_radius}},
    };
    uint32_t made;
    return pbrt_blame(p, p->film.place,
                      description_add(p->d, CATEGORY_SETTING, "render", params,
                                      sizeof params / sizeof params[0], source_at(p->film.place),
                                      &made));
}

/* ---- the camera ---- */

static screen read_screen(pbrt *p, const view *v) {
    double aspect = (double)v->width / v->height,
           frame = pbrt_float(p, &p->camera, "frameaspectratio", aspect);
    if (!(frame > 1e-6 && frame < 1e6)) frame = aspect;
    screen s = {-1, 1, -1, 1};
    if (frame > 1)
        s.x0 = -frame, s.x1 = frame;
    else
        s.y0 = -1 / frame, s.y1 = 1 / frame;
    size_t count;
    const double *window = pbrt_numbers(p, &p->camera, "screenwindow", 4, &count);
    if (!p->status && window && count == 1)
        s = (screen){window[0], window[1], window[2], window[3]};
    double width = s.x1 - s.x0, height = s.y1 - s.y0;
    if (!p->status && !(width > 0 && height > 0))
        pbrt_fail(p, p->camera.place, NULL, "the camera's screen window is empty");
    if (!p->status && fabs(width / height / aspect - 1) > 1e-3)
        pbrt_warn(p, p->camera.place,
                  "pixels that are not square are not supported: the height of the screen counts");
    if (fabs(s.x0 + s.x1) > 1e-6 * width || fabs(s.y0 + s.y1) > 1e-6 * height)
        pbrt_warn(p, p->camera.place,
                  "a screen window beside the axis is not supported: it is moved to the middle");
    return s;
}

/* Where it is and what is to the right, up and forward, as pbrt has it. */
typedef struct placed {
    dvec3 from, forward, up;
    double scale;
} placed;

static placed place_camera(const pbrt *p) {
    dtransform m = p->from_camera[0];
    for (int c = 0; c < 4; c++) m.m[0][c] *= p->flip;
    return (placed){{m.m[0][3], m.m[1][3], m.m[2][3]},
                    {m.m[0][2], m.m[1][2], m.m[2][2]},
                    {m.m[0][1], m.m[1][1], m.m[2][1]},
                    fn_cbrt(fabs(pbrt_determinant(&m)))};
}

/* Where a camera at the origin stands that looks along -z, x to its right; a spherical one along -x, z
 * to its left. */
static transform camera_key(const pbrt *p, int which) {
    dtransform m = p->from_camera[which];
    bool turned = strcmp(p->camera.type, "spherical") != 0;
    for (int c = 0; c < 4; c++) m.m[0][c] *= p->flip;
    for (int r = 0; r < 3 && turned; r++) m.m[r][2] = -m.m[r][2];
    return dtransform_round(&m);
}

typedef struct camera_params {
    snell_param list[16];
    size_t count;
} camera_params;

static void add(camera_params *c, snell_param param) { c->list[c->count++] = param; }
static void add_float(camera_params *c, const char *name, double value) {
    add(c, (snell_param){name, SNELL_PARAM_FLOAT, {.f = value}});
}
static void add_vec3(camera_params *c, const char *name, dvec3 v) {
    add(c, (snell_param){name, SNELL_PARAM_VEC3, {.v = vec3_from(v)}});
}

static void add_lens(pbrt *p, camera_params *c, double scale) {
    double radius = pbrt_float(p, &p->camera, "lensradius", 0),
           focus = pbrt_float(p, &p->camera, "focaldistance", 1e6);
    if (!(radius > 0)) return;
    add_float(c, "lens_radius", radius * scale);
    add_float(c, "focus", focus * scale);
}

static void perspective(pbrt *p, const view *v, double scale, camera_params *c) {
    screen s = read_screen(p, v);
    double fov = pbrt_float(p, &p->camera, "fov", 90);
    if (!p->status && !(fov > 0.01 && fov < 179.9))
        pbrt_fail(p, p->camera.place, "it is the angle over the picture's shorter side, in degrees",
                  "a camera cannot have a 'fov' of %g", fov);
    /* fov is of the screen from -1 to 1. */
    double half = fn_tan(double_min(fov, 179.9) * (PI / 360)) * (s.y1 - s.y0) / 2;
    add_float(c, "fov", 2 * fn_atan(half));
    add_lens(p, c, scale);
}

static void orthographic(pbrt *p, const view *v, double scale, camera_params *c) {
    screen s = read_screen(p, v);
    add_float(c, "height", (s.y1 - s.y0) * scale);
    if (pbrt_float(p, &p->camera, "lensradius", 0) > 0)
        pbrt_warn(p, p->camera.place, "a lens of an orthographic camera is not supported: ignored");
    pbrt_ignore(&p->camera, "focaldistance");
}

/* A lens of 35 mm film is no more than its length and aperture here. */
static void realistic(pbrt *p, const view *v, double scale, camera_params *c) {
    pbrt_warn(p, p->camera.place, "the 'realistic' camera is not supported: a thin lens of 50 mm");
    double aperture = pbrt_float(p, &p->camera, "aperturediameter", 1),
           focus = pbrt_float(p, &p->camera, "focusdistance", 10),
           diagonal = pbrt_float(p, &p->film, "diagonal", 35),
           aspect = (double)v->width / v->height;
    double height = diagonal / sqrt(1 + aspect * aspect);
    add_float(c, "fov", 2 * fn_atan(height / 2 / 50));
    add_float(c, "lens_radius", double_max(aperture, 0) * 0.0005 * scale);
    add_float(c, "focus", double_max(focus, 0) * scale);
    pbrt_ignore(&p->camera, "lensfile aperture scale");
}

/* Its middle is where pbrt's camera has -x, and it is mirrored as pbrt's is (pbrt_begin_world). */
static void spherical(pbrt *p, placed *at) {
    const char *mapping = pbrt_string(p, &p->camera, "mapping", "equalarea");
    if (!p->status && strcmp(mapping, "equirectangular") != 0)
        pbrt_warn(p, p->camera.place,
                  "the equal-area mapping of a camera is not supported: longitude and latitude");
    dtransform m = p->from_camera[0];
    at->forward = (dvec3){-p->flip * m.m[0][0], -m.m[1][0], -m.m[2][0]};
    pbrt_ignore(&p->camera, "lensradius focaldistance frameaspectratio screenwindow");
}

static snell_status add_camera(pbrt *p, const view *v) {
    camera_params c = {.count = 0};
    placed at = place_camera(p);
    const char *kind = p->camera.type[0] ? p->camera.type : "perspective", *type = "perspective";
    bool moves = memcmp(&p->from_camera[0], &p->from_camera[1], sizeof p->from_camera[0]) != 0 &&
                 p->times[0] < p->times[1];
    motion_key keys[2] = {{(float)p->times[0], camera_key(p, 0)},
                          {(float)p->times[1], camera_key(p, 1)}};
    if (moves) {
        double scale = at.scale;
        at = (placed){{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, scale};
        add(&c, (snell_param){"motion", SNELL_PARAM_ARRAY, {.array = {keys, 2}}});
        p->moving = true;
    }
    if (strcmp(kind, "perspective") == 0) {
        perspective(p, v, moves ? 1 : at.scale, &c);
    } else if (strcmp(kind, "orthographic") == 0) {
        type = "orthographic";
        orthographic(p, v, moves ? 1 : at.scale, &c);
    } else if (strcmp(kind, "spherical") == 0) {
        type = "panorama";
        spherical(p, &at);
        if (moves) at.forward = (dvec3){-1, 0, 0};
    } else if (strcmp(kind, "realistic") == 0) {
        realistic(p, v, moves ? 1 : at.scale, &c);
    } else {
        return pbrt_fail(p, p->camera.place,
                         "it is perspective, orthographic, spherical or realistic",
                         "unknown camera '%s'", kind);
    }
    if (p->status) return p->status;
    double length = dvec3_length(at.forward);
    add_vec3(&c, "from", at.from);
    add_vec3(&c, "at", dvec3_add(at.from, dvec3_scale(at.forward, 1 / length)));
    add_vec3(&c, "up", at.up);
    snell_param shutter = {
        "shutter", SNELL_PARAM_VEC3, {.v = {(float)p->shutter[0], (float)p->shutter[1], 0}}};
    add(&c, shutter);
    return pbrt_blame(p, p->camera.place,
                      description_add(p->d, CATEGORY_CAMERA, type, c.list, c.count,
                                      source_at(p->camera.place), &p->camera_index));
}

snell_status pbrt_begin_world(pbrt *p) {
    view v = {0};
    source_place start = {p->path, 0, 0};
    pbrt_params *const lists[] = {&p->camera, &p->film, &p->sampler, &p->integrator, &p->filter};
    for (int i = 0; i < 5; i++)
        if (lists[i]->place.file == NULL) lists[i]->place = start;
    /* pbrt's own picture of x to the right, y up, z forward is left-handed. Where the camera's
     * transform mirrors, the file's world is right-handed. */
    bool mirrors = pbrt_determinant(&p->from_camera[0]) < 0;
    if (strcmp(p->camera.type, "spherical") == 0) mirrors = !mirrors;
    p->flip = mirrors ? 1 : -1;
    read_sensor(p);
    read_film(p, &v);
    read_sampler(p, &v);
    read_integrator(p, &v);
    read_filter(p, &v);
    if (!p->status) add_render(p, &v);
    if (!p->status) add_camera(p, &v);
    for (int i = 0; i < 5 && !p->status; i++) pbrt_check_unused(p, lists[i]);
    return p->status;
}

/* A clock on which a frame is a second, so that pbrt's seconds are snell's frames. */
snell_status pbrt_finish_view(pbrt *p) {
    if (p->status || !p->moving) return p->status;
    const snell_param clock[] = {{"fps", SNELL_PARAM_FLOAT, {.f = 1}},
                                 {"first", SNELL_PARAM_INT, {.i = 1}},
                                 {"last", SNELL_PARAM_INT, {.i = 1}},
                                 {"frame", SNELL_PARAM_INT, {.i = 1}}};
    uint32_t made;
    source_place start = {p->path, 0, 0};
    return pbrt_blame(
        p, start,
        description_add(p->d, CATEGORY_SETTING, "animation", clock, 4, source_at(start), &made));
}
