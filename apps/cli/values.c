#include "values.h"

#include <inttypes.h>
#include <string.h>

#include "report.h"
#include "text.h"

static const double pi = 3.14159265358979323846;

const char *integrator_name(snell_integrator integrator) {
    static const char *const names[] = {"", "appel", "whitted", "cook", "path"};
    size_t index = (size_t)integrator;
    return index < sizeof names / sizeof names[0] ? names[index] : "";
}

/* Copies up to the separator and steps over it; false when it does not fit or is not there. */
static bool take_until(const char **at, char separator, char *out, size_t size) {
    const char *end = strchr(*at, separator);
    if (end == NULL || (size_t)(end - *at) >= size) return false;
    memcpy(out, *at, (size_t)(end - *at));
    out[end - *at] = '\0';
    *at = end + 1;
    return true;
}

static int bad_size(const char *text) {
    return report_usage("such as 800x600, 640x, x480 or 50%; sides up to 65536, 2^30 pixels in all",
                        "--size: '%s' is no size", text);
}

static int read_size(const char *text, render_values *v) {
    char word[32];
    const char *at = text;
    uint64_t width = 0, height = 0;
    size_t length = strlen(text);
    if (length > 1 && length < sizeof word && text[length - 1] == '%') {
        memcpy(word, text, length - 1);
        word[length - 1] = '\0';
        bool fine = text_number(word, &v->percent) && v->percent > 0 && v->percent <= 1e6;
        return fine ? EXIT_DONE : bad_size(text);
    }
    if (!take_until(&at, 'x', word, sizeof word) || (word[0] == '\0' && *at == '\0')) {
        return bad_size(text);
    }
    if (word[0] != '\0' && !text_uint(word, 1, IMAGE_SIDE_MAX, &width)) return bad_size(text);
    if (*at != '\0' && !text_uint(at, 1, IMAGE_SIDE_MAX, &height)) return bad_size(text);
    if (width * height > (1u << 30)) return bad_size(text);
    v->width = (uint32_t)width;
    v->height = (uint32_t)height;
    return EXIT_DONE;
}

static int read_crop(const char *text, render_values *v) {
    char w[16], h[16], x[16];
    const char *at = text;
    uint64_t n[4];
    bool fine = take_until(&at, 'x', w, sizeof w) && take_until(&at, '+', h, sizeof h) &&
                take_until(&at, '+', x, sizeof x) && text_uint(w, 1, IMAGE_SIDE_MAX, &n[0]) &&
                text_uint(h, 1, IMAGE_SIDE_MAX, &n[1]) && text_uint(x, 0, IMAGE_SIDE_MAX, &n[2]) &&
                text_uint(at, 0, IMAGE_SIDE_MAX, &n[3]);
    if (!fine) {
        return report_usage("such as 200x100+300+250: width, height, and the top left pixel",
                            "--crop: '%s' is no rectangle", text);
    }
    v->has_crop = true;
    v->crop_width = (uint32_t)n[0];
    v->crop_height = (uint32_t)n[1];
    v->crop_x = (uint32_t)n[2];
    v->crop_y = (uint32_t)n[3];
    return EXIT_DONE;
}

static int read_view(const char *text, render_values *v) {
    /* iso: the corner of a cube, elevation atan(1 / sqrt 2). */
    static const struct {
        const char *name;
        double azimuth, elevation;
    } names[] = {{"front", 0, 0},
                 {"back", 180, 0},
                 {"left", -90, 0},
                 {"right", 90, 0},
                 {"top", 0, 90},
                 {"bottom", 0, -90},
                 {"iso", 45, 35.264389682754654}};
    double azimuth = 0, elevation = 0;
    char word[32], near[16],
        hint[160] = "front, back, left, right, top, bottom, iso, or azimuth "
                    "and elevation in degrees such as 30,15";
    const char *at = text;
    bool found = false;
    for (size_t i = 0; i < sizeof names / sizeof names[0] && !found; i++) {
        if (strcmp(text, names[i].name) != 0) continue;
        azimuth = names[i].azimuth;
        elevation = names[i].elevation;
        found = true;
    }
    if (!found && take_until(&at, ',', word, sizeof word)) {
        found = text_number(word, &azimuth) && text_number(at, &elevation) && elevation >= -90 &&
                elevation <= 90 && azimuth >= -3600 && azimuth <= 3600;
    } else if (!found && text_choice_closest("front|back|left|right|top|bottom|iso", text, near,
                                             sizeof near)) {
        snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    }
    if (!found) return report_usage(hint, "--view: '%s' is no direction", text);
    v->has_view = true;
    v->view[0] = (float)(azimuth * pi / 180);
    v->view[1] = (float)(elevation * pi / 180);
    return EXIT_DONE;
}

static int bad_color(const char *option, const char *text, const char *names) {
    char hint[200], near[16];
    if (text_choice_closest(names, text, near, sizeof near))
        snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    else
        snprintf(hint, sizeof hint,
                 "'#rrggbb' or '#rgb' (sRGB), linear 'r,g,b', or a name such as "
                 "white, grey, navy");
    return report_usage(hint, "--%s: '%s' is no colour", option, text);
}

static int read_background(const char *text, render_values *v) {
    v->transparent = strcmp(text, "transparent") == 0;
    v->has_background = !v->transparent;
    if (v->transparent || text_color(text, &v->background)) return EXIT_DONE;
    return bad_color("background", text, "transparent|" TEXT_COLORS);
}

static int read_ground(const char *text, render_values *v) {
    v->has_ground = true;
    v->ground = (snell_vec3){0.5f, 0.5f, 0.5f};
    if (*text == '\0' || text_color(text, &v->ground)) return EXIT_DONE;
    return bad_color("ground", text, TEXT_COLORS);
}

int values_read_whole(const options *o, option_id id, const char *name, uint64_t min, uint64_t max,
                      uint64_t *out) {
    if (o->value[id] == NULL || text_uint(o->value[id], min, max, out)) return EXIT_DONE;
    return report_usage(NULL, "--%s: '%s' is not a whole number from %llu to %llu", name,
                        o->value[id], (unsigned long long)min, (unsigned long long)max);
}

int values_read_decimal(const options *o, option_id id, const char *name, double min, double max,
                        double *out) {
    double number;
    if (o->value[id] == NULL) return EXIT_DONE;
    if (!text_number(o->value[id], &number) || number < min || number > max) {
        return report_usage(NULL, "--%s: '%s' is not a number from %g to %g", name, o->value[id],
                            min, max);
    }
    *out = number;
    return EXIT_DONE;
}

bool values_white(const char *text, char out[WHITE_TEXT_MAX]) {
    double kelvin;
    snell_vec3 c;
    bool number = text_number(text, &kelvin);
    if (number && !(kelvin >= 1000 && kelvin <= 25000)) return false;
    if (!number && !text_color(text, &c)) return false;
    if (number) {
        snprintf(out, WHITE_TEXT_MAX, "%.6f", kelvin);
        return true;
    }
    float most = c.x > c.y ? c.x : c.y;
    if (c.z > most) most = c.z;
    if (!(most > 0)) return false;
    /* How bright it is does not matter; digits do. */
    snprintf(out, WHITE_TEXT_MAX, "%.9f,%.9f,%.9f", (double)(c.x / most), (double)(c.y / most),
             (double)(c.z / most));
    return true;
}

int values_read_white(const options *o, char out[WHITE_TEXT_MAX], bool *given) {
    const char *text = o->value[OPT_WHITE_BALANCE];
    *given = text != NULL;
    if (text == NULL || values_white(text, out)) return EXIT_DONE;
    return report_usage(
        "kelvin from 1000 to 25000, such as 3200, or a colour as of --background; 6504 "
        "changes nothing",
        "--white-balance: '%s' is no light", text);
}

int values_read_encoding(const options *o, uint32_t *bits, uint32_t *quality) {
    const char *text = o->value[OPT_BITS];
    uint64_t whole = 0;
    *bits = text == NULL ? 0 : text[0] == '8' ? 8 : text[0] == '1' ? 16 : 32;
    int code = values_read_whole(o, OPT_QUALITY, "quality", 1, 100, &whole);
    *quality = (uint32_t)whole;
    return code;
}

static int read_picture(const options *o, render_values *v) {
    int code = EXIT_DONE;
    double number = 0;
    if (o->value[OPT_SIZE] != NULL) code = read_size(o->value[OPT_SIZE], v);
    if (code == EXIT_DONE && o->value[OPT_CROP] != NULL) code = read_crop(o->value[OPT_CROP], v);
    if (code == EXIT_DONE && o->value[OPT_EXPOSURE] != NULL) {
        code = values_read_decimal(o, OPT_EXPOSURE, "exposure", -50, 50, &number);
        v->exposure = (float)number;
        v->has_exposure = true;
    }
    if (code == EXIT_DONE) code = values_read_white(o, v->white_balance, &v->has_white_balance);
    if (code == EXIT_DONE) code = values_read_encoding(o, &v->bits, &v->quality);
    if (code == EXIT_DONE && o->value[OPT_BACKGROUND] != NULL) {
        code = read_background(o->value[OPT_BACKGROUND], v);
    }
    if (code == EXIT_DONE && o->value[OPT_VIEW] != NULL) code = read_view(o->value[OPT_VIEW], v);
    if (code == EXIT_DONE && o->value[OPT_FOV] != NULL) {
        code = values_read_decimal(o, OPT_FOV, "fov", 0.01, 179, &number);
        v->fov = (float)(number * pi / 180);
    }
    if (code == EXIT_DONE && o->value[OPT_GROUND] != NULL) {
        code = read_ground(o->value[OPT_GROUND], v);
    }
    const char *light = o->value[OPT_LIGHT];
    v->light_none = light != NULL && strcmp(light, "none") == 0;
    v->light_sky = light != NULL && strcmp(light, "sky") == 0;
    if (light == NULL || v->light_none || v->light_sky || strcmp(light, "studio") == 0) return code;
    if (code == EXIT_DONE && strpbrk(light, "./") == NULL)
        code = report_usage("studio, sky, none, or a picture of the surroundings such as roof.hdr",
                            "--light: there is no light '%s'", light);
    v->light_image = light;
    return code;
}

static int read_rendering(const options *o, render_values *v) {
    int code = EXIT_DONE;
    uint64_t whole = 0;
    double number = 0;
    const char *integrator = o->value[OPT_INTEGRATOR];
    for (int i = SNELL_APPEL; integrator != NULL && i <= SNELL_PATH; i++)
        if (strcmp(integrator, integrator_name((snell_integrator)i)) == 0)
            v->integrator = (snell_integrator)i;
    if (o->value[OPT_SAMPLES] != NULL) {
        code = values_read_whole(o, OPT_SAMPLES, "samples", 1, SAMPLES_MAX, &whole);
        v->samples = (uint32_t)whole;
    }
    if (code == EXIT_DONE && o->value[OPT_MAX_DEPTH] != NULL) {
        code = values_read_whole(o, OPT_MAX_DEPTH, "max-depth", 0, DEPTH_MAX, &whole);
        v->max_depth = (uint32_t)whole;
        v->has_max_depth = true;
    }
    if (code == EXIT_DONE && o->value[OPT_MIN_WEIGHT] != NULL) {
        code = values_read_decimal(o, OPT_MIN_WEIGHT, "min-weight", 0, 1, &number);
        v->min_weight = (float)number;
        v->has_min_weight = true;
    }
    if (code == EXIT_DONE && o->value[OPT_SEED] != NULL) {
        code = values_read_whole(o, OPT_SEED, "seed", 0, INT64_MAX, &v->seed);
        v->has_seed = true;
    }
    return code;
}

/* A number before one of the units, each a letter; its place among them. */
static bool take_unit(const char *text, const char *units, double *number, size_t *unit) {
    char word[32];
    size_t length = strlen(text);
    if (length < 2 || length >= sizeof word) return false;
    const char *found = strchr(units, text[length - 1]);
    if (found == NULL) return false;
    memcpy(word, text, length - 1);
    word[length - 1] = '\0';
    *unit = (size_t)(found - units);
    return text_number(word, number);
}

static int read_stopping(const options *o, render_values *v) {
    static const double seconds[] = {1, 60, 3600};
    const char *noise = o->value[OPT_NOISE], *limit = o->value[OPT_TIME_LIMIT];
    double number = 0;
    size_t unit = 0;
    if (noise != NULL) {
        bool percent = take_unit(noise, "%", &number, &unit);
        if (!percent && !text_number(noise, &number)) number = 0;
        if (percent) number /= 100;
        v->noise = (float)number;
        if (!(v->noise > 0 && v->noise <= 1))
            return report_usage("such as 1% or 0.01: over 0, up to 100%",
                                "--noise: '%s' is no relative error", noise);
    }
    if (limit != NULL) {
        if (!take_unit(limit, "smh", &number, &unit)) number = 0;
        v->time_limit = number * seconds[unit];
        if (!(v->time_limit > 0))
            return report_usage("such as 90s, 10m or 2h", "--time-limit: '%s' is no time", limit);
    }
    if (v->noise > 0 && v->samples > 0 && v->samples < 4)
        return report_usage("the error is estimated from four groups of samples",
                            "--noise needs --samples 4 or more");
    return EXIT_DONE;
}

/* "A..B" */
static bool read_range(const char *text, uint64_t *first, uint64_t *last) {
    char number[16];
    const char *dots = strstr(text, "..");
    if (dots == NULL || (size_t)(dots - text) >= sizeof number) return false;
    memcpy(number, text, (size_t)(dots - text));
    number[dots - text] = '\0';
    return text_uint(number, 1, FRAME_MAX, first) && text_uint(dots + 2, *first, FRAME_MAX, last);
}

int values_read_frames(const options *o, uint32_t *first, uint32_t *last) {
    const char *one = o->value[OPT_FRAME], *many = o->value[OPT_FRAMES];
    uint64_t a = 0, b = 0;
    if (one != NULL && many != NULL) {
        return report_usage(NULL, "--frame and --frames exclude each other");
    }
    if (one != NULL && !text_uint(one, 1, FRAME_MAX, &a)) {
        return report_usage(NULL, "--frame: '%s' is not a whole number from 1 to %d", one,
                            FRAME_MAX);
    }
    if (many != NULL && !read_range(many, &a, &b)) {
        return report_usage("such as --frames 1..120", "--frames: '%s' is no range of frames",
                            many);
    }
    *first = (uint32_t)a;
    *last = (uint32_t)(many != NULL ? b : a);
    return EXIT_DONE;
}

/* Frames of a turntable are those of its turn. */
static int read_animation(const options *o, render_values *v) {
    uint64_t turn = 0;
    int code = values_read_frames(o, &v->frame_first, &v->frame_last);
    if (code == EXIT_DONE)
        code = values_read_whole(o, OPT_TURNTABLE, "turntable", 1, TURNTABLE_MAX, &turn);
    if (code == EXIT_DONE) code = values_read_decimal(o, OPT_FPS, "fps", 0.001, 100000, &v->fps);
    v->turntable = (uint32_t)turn;
    v->many_frames = o->value[OPT_FRAMES] != NULL;
    if (code != EXIT_DONE || turn == 0) return code;
    if (v->frame_first == 0) {
        v->frame_first = 1;
        v->frame_last = v->turntable;
        v->many_frames = true;
    }
    if (v->frame_last <= turn) return EXIT_DONE;
    return report_usage(NULL, "--turntable: its frames are 1 to %" PRIu32 ", %" PRIu32 " is none",
                        v->turntable, v->frame_last);
}

static int read_filter(const options *o, render_values *v) {
    static const char *const names[] = {"box", "tent", "gaussian", "blackman-harris"};
    const char *name = o->value[OPT_FILTER];
    double number = 0;
    v->has_filter = name != NULL;
    for (int i = 0; i < 4 && name != NULL; i++)
        if (strcmp(name, names[i]) == 0) v->filter = (snell_filter)i;
    if (o->value[OPT_FILTER_RADIUS] == NULL) return EXIT_DONE;
    int code = values_read_decimal(o, OPT_FILTER_RADIUS, "filter-radius", 0.01, 16, &number);
    v->filter_radius = (float)number;
    return code;
}

/* A name that the library would not know is an error before any work. */
static int check_aov(const char *name, size_t length) {
    const char *names[64], *near;
    char word[48], hint[96] = "'snell help aovs' lists them";
    size_t count = 0;
    snprintf(word, sizeof word, "%.*s", (int)length, name);
    if (strcmp(word, "all") == 0) return EXIT_DONE;
    while (count < 64 && (names[count] = snell_aov_name((uint32_t)count, NULL, NULL)) != NULL)
        if (strcmp(names[count++], word) == 0) return EXIT_DONE;
    near = text_closest(word, names, count);
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return report_usage(hint, "--aov: there is no '%s'", word);
}

static int read_aov(const options *o, render_values *v) {
    const char *list = o->value[OPT_AOV];
    int code = EXIT_DONE;
    v->aov = list != NULL && strcmp(list, "none") == 0 ? "" : list;
    for (const char *at = v->aov; at != NULL && *at != '\0' && code == EXIT_DONE;) {
        size_t length = strcspn(at, ",");
        code = check_aov(at, length);
        at += length + (at[length] == ',');
    }
    if (list != NULL && *list == '\0') code = check_aov("", 0);
    return code;
}

int values_read(const options *o, render_values *v) {
    memset(v, 0, sizeof *v);
    int code = read_picture(o, v);
    if (code == EXIT_DONE) code = read_rendering(o, v);
    if (code == EXIT_DONE) code = read_stopping(o, v);
    if (code == EXIT_DONE) code = read_filter(o, v);
    if (code == EXIT_DONE) code = read_aov(o, v);
    if (code == EXIT_DONE) code = read_animation(o, v);
    v->all_cameras = o->value[OPT_CAMERA] != NULL && strcmp(o->value[OPT_CAMERA], "all") == 0;
    if (code == EXIT_DONE && o->value[OPT_CAMERA] != NULL && v->has_view) {
        code = report_usage("--view frames the model by itself", "--camera and --view exclude each "
                                                                 "other");
    }
    for (size_t i = 0; i < o->set.count && code == EXIT_DONE; i++) {
        const char *equals = strchr(o->set.items[i], '=');
        if (equals == NULL || equals == o->set.items[i]) {
            code = report_usage("such as -D depth=5", "--set: '%s' is not NAME=VALUE",
                                o->set.items[i]);
        }
    }
    return code;
}
