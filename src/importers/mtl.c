#include "importers/mtl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/memory.h"
#include "importers/maps.h"
#include "importers/number.h"
#include "importers/params.h"
#include "importers/surfaces.h"
#include "maths/functions.h"

enum { MATERIALS_MAX = 100000, PATH_SIZE = 512 };

typedef enum map_kind {
    MAP_KD,
    MAP_KS,
    MAP_KE,
    MAP_D,
    MAP_BUMP,
    MAP_NORM,
    MAP_PR,
    MAP_PM,
    MAP_PS,
    MAPS
} map_kind;

typedef struct mtl_map {
    char *path; /* owned; NULL: none */
    uint32_t line;
    char channel; /* of -imfchan: r, g, b, m, l, z; 0: not said */
    bool clamp;
    float multiplier; /* -bm */
    snell_vec2 offset, scale;
} mtl_map;

typedef enum number_kind { NS, NI, D, PR, PM, PC, PCR, NUMBERS } number_kind;
typedef enum color_kind { KD, KS, KE, TF, PS, COLORS } color_kind;

typedef struct mtl_material {
    char *name; /* owned */
    const char *file;
    uint32_t line, made; /* NO_MATERIAL: not yet */
    int illum;           /* -1: not said */
    float number[NUMBERS];
    snell_vec3 color[COLORS];
    uint32_t has_number, has_color; /* bits */
    mtl_map maps[MAPS];
    char lost[200]; /* ", Kt, aniso" */
} mtl_material;

struct mtl {
    const char *base;
    const import_options *options;
    description *d;
    name_set *names;
    mtl_material *list;
    size_t count, capacity;
    json_t *by_name, *textures; /* hash tables */
    char **files;               /* of libraries, as messages name them; owned */
    size_t file_count, file_capacity;
    char lost[400];
};

snell_status mtl_create(const char *base, const import_options *options, description *d,
                        name_set *names, mtl **out) {
    mtl *m = memory_zeroed(1, sizeof *m);
    if (m == NULL) return error_no_memory();
    *m = (mtl){.base = base, .options = options, .d = d, .names = names};
    m->by_name = json_object();
    m->textures = json_object();
    if (m->by_name == NULL || m->textures == NULL) {
        mtl_destroy(m);
        return error_no_memory();
    }
    *out = m;
    return SNELL_OK;
}

void mtl_destroy(mtl *m) {
    if (m == NULL) return;
    for (size_t i = 0; i < m->count; i++) {
        free(m->list[i].name);
        for (int k = 0; k < MAPS; k++) free(m->list[i].maps[k].path);
    }
    for (size_t i = 0; i < m->file_count; i++) free(m->files[i]);
    free(m->files);
    free(m->list);
    json_decref(m->by_name);
    json_decref(m->textures);
    free(m);
}

/* Hash tables want UTF-8; other bytes become '?', which two names may share. */
static void clean_key(const char *name, char *out, size_t size) {
    snprintf(out, size, "%s", name);
    json_t *probe = json_string(out);
    for (char *c = out; probe == NULL && *c; c++)
        if ((unsigned char)*c >= 128) *c = '?';
    json_decref(probe);
}

uint32_t mtl_find(const mtl *m, const char *name) {
    char key[PATH_SIZE];
    clean_key(name, key, sizeof key);
    const json_t *found = json_object_get(m->by_name, key);
    return found ? (uint32_t)json_integer_value(found) : MTL_NONE;
}

size_t mtl_count(const mtl *m) { return m->count; }

/* ---- reading ---- */

typedef struct reading {
    mtl *m;
    const char *text, *at, *line_end, *file;
    uint32_t line;
    mtl_material *now; /* the last newmtl; NULL: none yet */
} reading;

static snell_status wrong(const reading *r, const char *at, const char *what) {
    source_place place = {r->file, r->line, (uint32_t)(at - r->text) + 1};
    return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "MTL: %s", what);
}

static void skip_space(reading *r) {
    while (r->at < r->line_end && (unsigned char)*r->at <= ' ') r->at++;
}

/* The next word of the line; its length, 0 at the end. */
static size_t next_word(reading *r, const char **word) {
    skip_space(r);
    *word = r->at;
    while (r->at < r->line_end && (unsigned char)*r->at > ' ') r->at++;
    return (size_t)(r->at - *word);
}

static bool is(const char *word, size_t length, const char *name) {
    return strlen(name) == length && strncasecmp(word, name, length) == 0;
}

static void add_word(char *list, size_t size, const char *word, size_t length) {
    char item[48];
    snprintf(item, sizeof item, ", %.*s", (int)(length < 40 ? length : 40), word);
    if (strstr(list, item)) return;
    size_t used = strlen(list);
    if (used + strlen(item) < size) memcpy(list + used, item, strlen(item) + 1);
}

/* A number, if there is one. */
static bool take_number(reading *r, float *out) {
    skip_space(r);
    if (r->at == r->line_end) return false;
    const char *rest = number_read(r->at, out);
    if (rest == NULL || (rest < r->line_end && (unsigned char)*rest > ' ') || !isfinite(*out))
        return false;
    r->at = rest;
    return true;
}

static snell_status need_number(reading *r, float *out) {
    if (take_number(r, out)) return SNELL_OK;
    return wrong(r, r->at, r->at == r->line_end ? "a number is missing" : "this is not a number");
}

/* A number that is none, as exporters write where a division failed: nan, -nan(ind), inf, 1e999. It is a loss of the
 * statement that begins at `word`, whose default holds. */
static bool lose_not_finite(reading *r, const char *word) {
    skip_space(r);
    const char *start = r->at, *number = start + (*start == '-' || *start == '+');
    float value;
    bool named = strncasecmp(number, "nan", 3) == 0 || strncasecmp(number, "inf", 3) == 0;
    if (!named && (number_read(start, &value) == NULL || isfinite(value))) return false;
    const char *unused;
    next_word(r, &unused);
    add_word(r->now->lost, sizeof r->now->lost, word, (size_t)(r->at - word));
    return true;
}

/* r, or r g b. What is a curve or CIE XYZ is not used. */
static snell_status read_color(reading *r, color_kind kind, const char *word, size_t length) {
    float c[3];
    const char *start = r->at, *form;
    size_t form_length = next_word(r, &form);
    if (is(form, form_length, "spectral") || is(form, form_length, "xyz")) {
        add_word(r->now->lost, sizeof r->now->lost, word, length);
        return SNELL_OK;
    }
    r->at = start;
    if (lose_not_finite(r, word)) return SNELL_OK;
    snell_status status = need_number(r, &c[0]);
    if (status) return status;
    c[1] = c[2] = c[0];
    if (lose_not_finite(r, word)) return SNELL_OK;
    if (take_number(r, &c[1])) {
        if (lose_not_finite(r, word)) return SNELL_OK;
        status = need_number(r, &c[2]);
        if (status) return status;
    }
    for (int i = 0; i < 3; i++) c[i] = c[i] > 0 ? c[i] < 1e6f ? c[i] : 1e6f : 0;
    r->now->color[kind] = (snell_vec3){c[0], c[1], c[2]};
    r->now->has_color |= 1u << kind;
    return SNELL_OK;
}

static snell_status read_value(reading *r, number_kind kind, const char *word) {
    float value;
    if (lose_not_finite(r, word)) return SNELL_OK;
    snell_status status = need_number(r, &value);
    if (status) return status;
    r->now->number[kind] = value;
    r->now->has_number |= 1u << kind;
    return SNELL_OK;
}

/* d [-halo] factor */
static snell_status read_dissolve(reading *r, const char *statement) {
    const char *start = r->at, *word;
    size_t length = next_word(r, &word);
    if (is(word, length, "-halo"))
        add_word(r->now->lost, sizeof r->now->lost, word, length);
    else
        r->at = start;
    return read_value(r, D, statement);
}

/* 1 - d, unless d says so itself. */
static snell_status read_transparency(reading *r, const char *word) {
    float value;
    if (r->now->has_number & (1u << D) || lose_not_finite(r, word)) return SNELL_OK;
    snell_status status = need_number(r, &value);
    if (!status) r->now->number[D] = 1 - value;
    return status;
}

/* Of those that are LOST there is a warning; NEEDLESS ones change nothing that we could show. */
typedef enum option_kind { SCALE, OFFSET, MULTIPLIER, CLAMP, CHANNEL, NEEDLESS, LOST } option_kind;
typedef struct option {
    const char *name;
    option_kind kind;
    int least, most; /* arguments: numbers, or a word where both are 0 */
} option;
static const option options[] = {
    {"-s", SCALE, 1, 3},    {"-o", OFFSET, 1, 3},        {"-t", LOST, 1, 3},
    {"-mm", LOST, 2, 2},    {"-bm", MULTIPLIER, 1, 1},   {"-clamp", CLAMP, 0, 0},
    {"-boost", LOST, 1, 1}, {"-imfchan", CHANNEL, 0, 0}, {"-blendu", NEEDLESS, 0, 0},
    {"-cc", LOST, 0, 0},    {"-blendv", NEEDLESS, 0, 0}, {"-texres", NEEDLESS, 1, 1},
    {"-type", LOST, 0, 0},  {"-colorspace", LOST, 0, 0},
};
enum { OPTIONS = sizeof options / sizeof options[0] };

/* v: what is not said is as if the option were not. */
static void apply_option(mtl_map *map, option_kind kind, const float v[3], int count,
                         const char *word, size_t length) {
    switch (kind) {
    case SCALE: map->scale = (snell_vec2){v[0], count > 1 ? v[1] : 1}; break;
    case OFFSET: map->offset = (snell_vec2){v[0], v[1]}; break;
    case MULTIPLIER: map->multiplier = v[0]; break;
    case CLAMP: map->clamp = is(word, length, "on"); break;
    case CHANNEL:
        if (length == 1) map->channel = (char)(*word | 32);
        break;
    default: break;
    }
}

/* Options may stand before the name of the picture or after it. false: no option here. */
static snell_status take_option(reading *r, mtl_map *map, bool *taken) {
    const char *start = r->at, *name, *word = NULL;
    size_t length = next_word(r, &name), word_length = 0;
    const option *o = NULL;
    for (size_t i = 0; i < OPTIONS; i++)
        if (is(name, length, options[i].name)) o = &options[i];
    *taken = o != NULL;
    if (o == NULL) {
        r->at = start;
        return SNELL_OK;
    }
    float v[3] = {0, 0, 0};
    int count = 0;
    while (count < o->most && take_number(r, &v[count])) count++;
    if (o->most == 0) word_length = next_word(r, &word);
    if (count < o->least || (o->most == 0 && word_length == 0))
        return wrong(r, r->at, "the option lacks its value");
    if (o->kind == LOST) add_word(r->now->lost, sizeof r->now->lost, name, length);
    apply_option(map, o->kind, v, count, word, word_length);
    return SNELL_OK;
}

/* A picture's name may have spaces in it: it ends where an option begins, or the line. Some exporters write
 * the statement without one. */
static snell_status read_map(reading *r, map_kind kind, const char *statement, size_t size) {
    mtl_map map = {.multiplier = 1, .scale = {1, 1}, .line = r->line};
    const char *begin = NULL, *end = NULL, *word;
    for (;;) {
        bool taken;
        skip_space(r);
        snell_status status = take_option(r, &map, &taken);
        if (status) return status;
        if (taken) continue;
        if (next_word(r, &word) == 0) break;
        if (begin == NULL) begin = word;
        end = r->at;
    }
    if (begin == NULL)
        return add_word(r->now->lost, sizeof r->now->lost, statement, size), SNELL_OK;
    size_t length = (size_t)(end - begin);
    if (length >= PATH_SIZE) return wrong(r, begin, "the name of the picture is too long");
    if (length >= 2 && *begin == '"' && begin[length - 1] == '"') begin++, length -= 2;
    map.path = memory_zeroed(length + 1, 1);
    if (map.path == NULL) return error_no_memory();
    memcpy(map.path, begin, length);
    free(r->now->maps[kind].path);
    r->now->maps[kind] = map;
    return SNELL_OK;
}

static snell_status begin_material(reading *r) {
    mtl *m = r->m;
    skip_space(r);
    const char *end = r->line_end;
    while (end > r->at && (unsigned char)end[-1] <= ' ') end--;
    size_t length = (size_t)(end - r->at);
    if (length >= NAME_MAX_SIZE) length = NAME_MAX_SIZE - 1;
    if (m->count >= MATERIALS_MAX) return wrong(r, r->at, "too many materials");
    if (!ARRAY_GROW(m->list, m->count, m->capacity, 1)) return error_no_memory();
    mtl_material *made = &m->list[m->count];
    *made = (mtl_material){.file = r->file, .line = r->line, .made = NO_MATERIAL, .illum = -1};
    made->number[D] = 1;
    made->name = memory_zeroed(length + 1, 1);
    if (made->name == NULL) return error_no_memory();
    memcpy(made->name, r->at, length);
    r->now = made;
    char key[PATH_SIZE];
    clean_key(made->name, key, sizeof key);
    m->count++;
    if (json_object_get(m->by_name, key)) return SNELL_OK; /* the first of a name counts */
    json_t *number = json_integer((json_int_t)m->count - 1);
    return json_object_set_new(m->by_name, key, number) == 0 ? SNELL_OK : error_no_memory();
}

static snell_status read_statement(reading *r) {
    static const struct {
        const char *name;
        color_kind kind;
    } colors[] = {{"Kd", KD}, {"Ks", KS}, {"Ke", KE}, {"Tf", TF}, {"Ps", PS}};
    static const struct {
        const char *name;
        number_kind kind;
    } numbers[] = {{"Ns", NS}, {"Ni", NI}, {"Pr", PR}, {"Pm", PM}, {"Pc", PC}, {"Pcr", PCR}};
    static const struct {
        const char *name;
        map_kind kind;
    } maps[] = {{"map_Kd", MAP_KD},       {"map_Ks", MAP_KS},     {"map_Ke", MAP_KE},
                {"map_emissive", MAP_KE}, {"map_d", MAP_D},       {"map_opacity", MAP_D},
                {"bump", MAP_BUMP},       {"map_bump", MAP_BUMP}, {"norm", MAP_NORM},
                {"map_Kn", MAP_NORM},     {"map_Pr", MAP_PR},     {"map_Pm", MAP_PM},
                {"map_Ps", MAP_PS}};
    const char *word;
    size_t length = next_word(r, &word);
    if (length == 0 || *word == '#') return SNELL_OK;
    if (is(word, length, "newmtl")) return begin_material(r);
    if (r->now == NULL) {
        add_word(r->m->lost, sizeof r->m->lost, word, length);
        return SNELL_OK;
    }
    for (size_t i = 0; i < sizeof colors / sizeof colors[0]; i++)
        if (is(word, length, colors[i].name)) return read_color(r, colors[i].kind, word, length);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        if (is(word, length, numbers[i].name)) return read_value(r, numbers[i].kind, word);
    for (size_t i = 0; i < sizeof maps / sizeof maps[0]; i++)
        if (is(word, length, maps[i].name)) return read_map(r, maps[i].kind, word, length);
    if (is(word, length, "d")) return read_dissolve(r, word);
    if (is(word, length, "Tr")) return read_transparency(r, word);
    if (is(word, length, "illum")) {
        float value;
        if (lose_not_finite(r, word)) return SNELL_OK;
        snell_status status = need_number(r, &value);
        if (!status) r->now->illum = value >= 0 && value <= 10 ? (int)value : -1;
        return status;
    }
    if (!is(word, length, "Ka")) /* how much ambient light there is, is the scene's to say */
        add_word(r->now->lost, sizeof r->now->lost, word, length);
    return SNELL_OK;
}

static snell_status read_lines(mtl *m, const char *file, const char *text, size_t size) {
    reading r = {.m = m, .at = text, .file = file};
    const char *end = text + size;
    snell_status status = SNELL_OK;
    r.at += import_mark_size(text, size);
    while (r.at < end && !status) {
        const char *stop = r.at;
        while (stop < end && *stop != '\n' && *stop != '\r') stop++;
        r.text = r.at;
        r.line_end = stop;
        r.line++;
        status = read_statement(&r);
        r.at = stop + 1 + (*stop == '\r' && stop + 1 < end && stop[1] == '\n');
    }
    return status;
}

static size_t folder_length(const char *path) { /* with its slash */
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* As messages name it: in the folder of the model. */
static char *shown_path(const mtl *m, const char *path) {
    size_t folder = path[0] != '/' ? folder_length(m->base) : 0;
    char *file = memory_zeroed(folder + strlen(path) + 1, 1);
    if (file == NULL) return NULL;
    memcpy(file, m->base, folder);
    memcpy(file + folder, path, strlen(path));
    return file;
}

snell_status mtl_read(mtl *m, const char *name) {
    uint8_t *data = NULL;
    size_t size;
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s", name);
    for (char *c = path; *c; c++)
        if (*c == '\\') *c = '/';
    char *file = shown_path(m, path);
    if (file == NULL) return error_no_memory();
    bool known = false;
    for (size_t i = 0; i < m->file_count; i++) known |= strcmp(m->files[i], file) == 0;
    snell_status status =
        known ? SNELL_OK : import_read_beside(m->base, path, m->options, &data, &size);
    if (status || known) {
        free(file);
        return status;
    }
    if (!ARRAY_GROW(m->files, m->file_count, m->file_capacity, 1)) {
        free(file);
        free(data);
        return error_no_memory();
    }
    m->files[m->file_count++] = file;
    status = read_lines(m, file, (const char *)data, size);
    free(data);
    return status;
}

/* ---- textures ---- */

/* Is it a picture of normals, though the file calls it one of heights? They are mostly blue. */
static bool shows_normals(const decoded_image *image) {
    if (image->channels < 3 || image->floats || image->wide) return false;
    uint64_t sum[3] = {0, 0, 0};
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3; k++) sum[k] += image->pixels[i * image->channels + k];
    double red = (double)sum[0] / (double)count, green = (double)sum[1] / (double)count,
           blue = (double)sum[2] / (double)count;
    return blue > 180 && fabs(red - 128) < 40 && fabs(green - 128) < 40;
}

static snell_status warn_of_picture(mtl *m, const mtl_material *of, const mtl_map *map) {
    char text[400];
    snprintf(text, sizeof text, "%s", error_last()->text);
    return description_add_message(m->d, SNELL_WARNING, of->file, map->line, NULL,
                                   "texture '%.200s': %s; the plain colour is used", map->path,
                                   text);
}

/* Beside the library, where that lies in another folder than the model, or else beside the model. */
static snell_status load_picture(const mtl *m, const char *library, const char *name,
                                 decoded_image *out) {
    size_t folder = folder_length(library), known = folder_length(m->base);
    if (strncmp(library, m->base, known) != 0) known = 0;
    char path[2 * PATH_SIZE];
    if (folder > known && folder - known < PATH_SIZE) {
        snprintf(path, sizeof path, "%.*s%s", (int)(folder - known), library + known, name);
        snell_status status = map_load(m->base, path, m->options, out);
        if (status != SNELL_ERR_IO) return status;
    }
    return map_load(m->base, name, m->options, out);
}

static snell_status make_texture(mtl *m, const mtl_material *of, const mtl_map *map, map_use use,
                                 snell_texture_id *out, bool *normals) {
    static const char *const channels[] = {"r", "g", "b"};
    decoded_image image;
    snell_status status = load_picture(m, of->file, map->path, &image);
    if (status == SNELL_ERR_MEMORY) return status;
    if (status) return warn_of_picture(m, of, map);
    const char *wrap = map->clamp ? "clamp" : "repeat";
    map_look look = {.use = use, .wrap = {wrap, wrap}, .offset = map->offset, .scale = map->scale};
    const char *place = map->channel ? strchr("rgb", map->channel) : NULL;
    bool grey = map == &of->maps[MAP_D] || map == &of->maps[MAP_PR] || map == &of->maps[MAP_PM] ||
                map == &of->maps[MAP_BUMP];
    if (grey && place && image.channels >= 3) look.channel = channels[place - strchr("rgb", 'r')];
    /* An opacity map with alpha is meant by that. */
    if (map->channel == 'm' ||
        (map == &of->maps[MAP_D] && !map->channel && image_has_alpha(&image)))
        look.use = MAP_ALPHA;
    *normals = shows_normals(&image);
    status = map_add(m->d, of->file, &image, &look, out);
    image_free(&image);
    return status;
}

/* Made before? By path and all that decides how it looks. */
static snell_status find_texture(mtl *m, const mtl_material *of, map_kind kind, map_use use,
                                 snell_texture_id *out, bool *normals) {
    const mtl_map *map = &of->maps[kind];
    *out = (snell_texture_id){0, 0};
    *normals = false;
    if (map->path == NULL) return SNELL_OK;
    char key[2 * PATH_SIZE + 160], path[2 * PATH_SIZE], clean[2 * PATH_SIZE];
    snprintf(path, sizeof path, "%s %s", map->path, of->file);
    clean_key(path, clean, sizeof clean);
    snprintf(key, sizeof key, "%d %d %d %d %.9g %.9g %.9g %.9g %s", (int)use, kind == MAP_D,
             map->channel, map->clamp, (double)map->offset.x, (double)map->offset.y,
             (double)map->scale.x, (double)map->scale.y, clean);
    const json_t *known = json_object_get(m->textures, key);
    if (known) {
        json_int_t value = json_integer_value(known);
        if (value) *out = (snell_texture_id){(uint32_t)(value >> 1), 0};
        *normals = value & 1;
        return SNELL_OK;
    }
    snell_status status = make_texture(m, of, map, use, out, normals);
    if (status) return status;
    json_t *value = json_integer((json_int_t)out->index1 << 1 | *normals);
    return json_object_set_new(m->textures, key, value) == 0 ? SNELL_OK : error_no_memory();
}

static snell_status find_input(mtl *m, const mtl_material *of, map_kind kind, map_use use,
                               snell_input *out) {
    bool unused;
    return find_texture(m, of, kind, use, &out->texture, &unused);
}

/* ---- what a material becomes ---- */

typedef struct look {
    mtl *m;
    const mtl_material *of;
    snell_input color, specular, emission, alpha, roughness, metallic, sheen, bump;
    snell_texture_id normals;
    float normal_scale, bump_scale;
    double exponent, ior;
} look;

static snell_input grey(double value) {
    float v = (float)value;
    return (snell_input){{v, v, v}, {0, 0}};
}

static double limited(double value, double low, double high) {
    return value >= low ? value < high ? value : high : low;
}

static double number_of(const mtl_material *of, number_kind kind, double otherwise, double low,
                        double high) {
    bool said = of->has_number & (1u << kind);
    return limited(said ? (double)of->number[kind] : otherwise, low, high);
}

static bool is_black(snell_input i) { return !i.texture.index1 && !(vec3_largest(i.value) > 0); }

/* `base`: what is under a glaze has no alpha, emission, bumps and name of its own. */
static snell_status add(const look *k, const char *type, params *p, bool base, uint32_t *out) {
    mtl *m = k->m;
    char name[NAME_MAX_SIZE] = "";
    if (!base) {
        if (!is_black(k->emission)) add_input(p, "emission", k->emission);
        if (k->alpha.value.x < 1 || k->alpha.texture.index1) add_input(p, "alpha", k->alpha);
        if (k->normals.index1) {
            p->list[p->count++] =
                (snell_param){"normal_map", SNELL_PARAM_TEXTURE, {.texture = k->normals}};
            add_input(p, "normal_scale", grey((double)k->normal_scale));
        }
        if (k->bump.texture.index1) {
            add_input(p, "bump", k->bump);
            add_float(p, "bump_scale", (double)k->bump_scale);
        }
        snell_status status = names_make_unique(m->names, CATEGORY_MATERIAL, k->of->name, name);
        if (status) return status;
    }
    object_source source = {name[0] ? name : NULL, k->of->file, k->of->line};
    snell_status status =
        description_add(m->d, CATEGORY_MATERIAL, type, p->list, p->count, source, out);
    if (status && status != SNELL_ERR_MEMORY)
        error_place((source_place){k->of->file, k->of->line, 0});
    return status == SNELL_ERR_ARGUMENT ? SNELL_ERR_SYNTAX : status;
}

static snell_status add_lambert(const look *k, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "color", k->color);
    return add(k, "lambert", &p, false, out);
}

/* illum 0: the colour itself, whatever the light. */
static snell_status add_constant(const look *k, uint32_t *out) {
    look shown = *k;
    params p = {.count = 0};
    shown.emission = k->color;
    add_input(&p, "color", grey(0));
    return add(&shown, "lambert", &p, false, out);
}

/* MTL adds Kd (n.l) and Ks (n.h)^Ns under the same light; our diffuse term is Kd / pi, so k_s = Ks / pi keeps
 * their proportion. */
static snell_status add_glossy(const look *k, bool base, uint32_t *out) {
    params p = {.count = 0};
    snell_input specular = k->specular;
    specular.value = vec3_scale(specular.value, (float)(1 / PI));
    add_input(&p, "color", k->color);
    add_input(&p, "specular", specular);
    add_float(&p, "exponent", k->exponent);
    return add(k, "blinn_phong", &p, base, out);
}

static snell_status add_mirror(const look *k, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "color", k->specular);
    return add(k, "mirror", &p, false, out);
}

static snell_status add_glazed(const look *k, bool fresnel, uint32_t *out) {
    uint32_t base;
    snell_status status = add_glossy(k, true, &base);
    if (status) return status;
    params p = {.count = 0};
    snell_material_id id = {base + 1, k->m->d->objects[CATEGORY_MATERIAL].items[base].generation};
    p.list[p.count++] = (snell_param){"base", SNELL_PARAM_MATERIAL, {.material = id}};
    if (fresnel)
        add_float(&p, "ior", k->ior);
    else
        add_input(&p, "reflectance", k->specular);
    return add(k, "glazed", &p, false, out);
}

/* Tf filters what passes the whole body: each of its two faces takes the root. d says that light passes,
 * which glass does anyway. */
static snell_status add_glass(const look *k, uint32_t *out) {
    look clear = *k;
    params p = {.count = 0};
    const mtl_material *of = k->of;
    snell_vec3 tf = of->color[TF];
    clear.alpha = grey(1);
    if ((of->has_color & (1u << TF)) && vec3_largest(tf) > 0) {
        float root[] = {sqrtf(float_min(tf.x, 1)), sqrtf(float_min(tf.y, 1)),
                        sqrtf(float_min(tf.z, 1))};
        add_input(&p, "color", (snell_input){{root[0], root[1], root[2]}, {0, 0}});
    }
    if ((of->has_number & (1u << PR)) || k->roughness.texture.index1)
        add_input(&p, "roughness", k->roughness);
    add_float(&p, "ior", k->ior);
    return add(&clear, "dielectric", &p, false, out);
}

static snell_status add_principled(const look *k, uint32_t *out) {
    params p = {.count = 0};
    add_input(&p, "base_color", k->color);
    add_input(&p, "metallic", k->metallic);
    add_input(&p, "roughness", k->roughness);
    add_float(&p, "ior", k->ior);
    add_float(&p, "clearcoat", number_of(k->of, PC, 0, 0, 1));
    add_float(&p, "clearcoat_roughness", number_of(k->of, PCR, 0, 0, 1));
    if (!is_black(k->sheen)) {
        add_input(&p, "sheen_color", k->sheen);
        add_input(&p, "sheen_roughness", grey(0.5));
    }
    return add(k, "principled", &p, false, out);
}

static bool is_glass(const mtl_material *of) {
    return of->illum == 4 || of->illum == 6 || of->illum == 7 || of->illum == 9;
}

static bool has_facets(const mtl_material *of) {
    uint32_t numbers = 1u << PR | 1u << PM | 1u << PC | 1u << PCR;
    return (of->has_number & numbers) || (of->has_color & (1u << PS)) || of->maps[MAP_PR].path ||
           of->maps[MAP_PM].path || of->maps[MAP_PS].path;
}

static snell_status add_by_illum(const look *k, uint32_t *out) {
    bool shiny = !is_black(k->specular) && k->exponent > 0;
    if (is_glass(k->of)) return add_glass(k, out);
    if (has_facets(k->of)) return add_principled(k, out);
    switch (k->of->illum) {
    case 0: return add_constant(k, out);
    case 1:
    case 10: return add_lambert(k, out);
    case 3: return is_black(k->color) ? add_mirror(k, out) : add_glazed(k, false, out);
    case 5: return add_glazed(k, true, out);
    default: return shiny ? add_glossy(k, false, out) : add_lambert(k, out);
    }
}

bool mtl_is_apart(const mtl *m, uint32_t material) {
    const mtl_material *of = &m->list[material];
    bool shines = of->maps[MAP_KE].path || vec3_largest(of->color[KE]) > 0;
    return is_glass(of) || shines || (of->illum == 0 && !has_facets(of));
}

/* A colour that a picture multiplies: 1 where only the picture is given, or black beside it. */
static snell_vec3 color_of(const mtl_material *of, color_kind kind, bool pictured,
                           float otherwise) {
    snell_vec3 c = of->color[kind];
    float usual = pictured ? 1 : otherwise;
    bool said = of->has_color & (1u << kind);
    if (!said || (pictured && !(vec3_largest(c) > 0))) c = (snell_vec3){usual, usual, usual};
    return c;
}

static snell_status read_alpha(look *k) {
    snell_status status = find_input(k->m, k->of, MAP_D, MAP_LINEAR, &k->alpha);
    double opacity = (double)k->of->number[D];
    if (!status && !(opacity > 0)) { /* exporters that mean the opposite */
        if (!is_glass(k->of))
            status = description_add_message(
                k->m->d, SNELL_WARNING, k->of->file, k->of->line, NULL,
                "material '%.100s' is wholly transparent: drawn opaque", k->of->name);
        opacity = 1;
    }
    k->alpha.value = grey(limited(opacity, 0, 1)).value;
    return status;
}

static snell_status read_bumps(look *k, double size) {
    bool normals;
    snell_texture_id bump;
    snell_status status = find_texture(k->m, k->of, MAP_NORM, MAP_LINEAR, &k->normals, &normals);
    k->normal_scale = k->of->maps[MAP_NORM].multiplier;
    if (!status) status = find_texture(k->m, k->of, MAP_BUMP, MAP_LINEAR, &bump, &normals);
    if (status) return status;
    k->bump = grey(1);
    if (normals && k->normals.index1 == 0) {
        k->normals = bump;
        k->normal_scale = k->of->maps[MAP_BUMP].multiplier;
    } else if (!normals) {
        k->bump.texture = bump;
        k->bump_scale = (float)(0.01 * size) * k->of->maps[MAP_BUMP].multiplier;
    }
    return SNELL_OK;
}

static snell_status read_look(look *k, double size) {
    mtl *m = k->m;
    const mtl_material *of = k->of;
    snell_status status = find_input(m, of, MAP_KD, MAP_COLOR, &k->color);
    if (!status) status = find_input(m, of, MAP_KS, MAP_COLOR, &k->specular);
    if (!status) status = find_input(m, of, MAP_KE, MAP_COLOR, &k->emission);
    if (!status) status = find_input(m, of, MAP_PR, MAP_LINEAR, &k->roughness);
    if (!status) status = find_input(m, of, MAP_PM, MAP_LINEAR, &k->metallic);
    if (!status) status = find_input(m, of, MAP_PS, MAP_LINEAR, &k->sheen);
    if (!status) status = read_alpha(k);
    if (!status) status = read_bumps(k, size);
    if (status) return status;
    k->color.value = color_of(of, KD, k->color.texture.index1, 0.6f);
    k->specular.value = color_of(of, KS, k->specular.texture.index1, 0);
    k->emission.value = color_of(of, KE, k->emission.texture.index1, 0);
    k->sheen.value = color_of(of, PS, k->sheen.texture.index1, 0);
    k->sheen.value = vec3_min(k->sheen.value, (snell_vec3){1, 1, 1});
    bool rough = k->roughness.texture.index1, metal = k->metallic.texture.index1;
    k->roughness.value = grey(number_of(of, PR, rough ? 1 : 0.5, 0, 1)).value;
    k->metallic.value = grey(number_of(of, PM, metal ? 1 : 0, 0, 1)).value;
    k->exponent = number_of(of, NS, 0, 0, 1e5);
    double ior = number_of(of, NI, 1.5, 0, 100);
    k->ior = ior > 1 && ior <= 10 ? ior : 1.5;
    return SNELL_OK;
}

snell_status mtl_make(mtl *m, uint32_t material, double size, uint32_t *out) {
    mtl_material *of = &m->list[material];
    snell_status status = SNELL_OK;
    if (of->made == NO_MATERIAL) {
        look k = {.m = m, .of = of};
        status = read_look(&k, size);
        if (!status) status = add_by_illum(&k, &of->made);
        for (const char *at = of->lost; *at && !status;) {
            size_t length = strcspn(at += 2, ",");
            add_word(m->lost, sizeof m->lost, at, length);
            at += length;
        }
    }
    *out = of->made;
    return status;
}

snell_status mtl_warn_of_losses(mtl *m) {
    if (m->lost[0] == 0) return SNELL_OK;
    return description_add_message(m->d, SNELL_WARNING, m->file_count ? m->files[0] : m->base, 0,
                                   NULL, "of materials is not used: %s", m->lost + 2);
}
