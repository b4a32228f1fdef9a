#include "output.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "report.h"

bool output_is_standard(const output *out) { return strcmp(out->path, "-") == 0; }

void output_input_name(const char *input, const char **name, size_t *length) {
    if (strcmp(input, "-") == 0) input = "stdin";
    const char *slash = strrchr(input, '/');
    *name = slash != NULL ? slash + 1 : input;
    if (**name == '\0')
        *name = "picture"; /* "folder/": reading it will fail with its own message */
    const char *dot = strrchr(*name, '.');
    *length = dot != NULL && dot != *name ? (size_t)(dot - *name) : strlen(*name);
}

/* The first {word} in `pattern` that means nothing; its length in *length, 0 for none. */
static const char *unknown_mark(const char *pattern, bool cameras, size_t *length) {
    *length = 0;
    for (const char *at = strchr(pattern, '{'); at != NULL; at = strchr(at + 1, '{')) {
        size_t span = strspn(at + 1, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_");
        if (at[span + 1] != '}' || (span == 4 && strncmp(at, "{name}", 6) == 0)) continue;
        if (cameras && span == 6 && strncmp(at, "{camera}", 8) == 0) continue;
        *length = span + 2;
        return at;
    }
    return NULL;
}

/* `pattern` with `text` in place of every mark, such as "{name}"; NULL on lack of memory. */
static char *expand(const char *pattern, const char *mark, const char *text, size_t length) {
    size_t count = 0, width = strlen(mark);
    for (const char *at = pattern; (at = strstr(at, mark)) != NULL; at += width) count++;
    char *path = malloc(strlen(pattern) + count * length + 1), *to = path;
    if (path == NULL) return NULL;
    while (*pattern != '\0') {
        if (strncmp(pattern, mark, width) == 0) {
            memcpy(to, text, length);
            to += length;
            pattern += width;
        } else {
            *to++ = *pattern++;
        }
    }
    *to = '\0';
    return path;
}

static char *expand_name(const char *pattern, const char *input, bool whole) {
    const char *name;
    size_t length;
    output_input_name(input, &name, &length);
    return expand(pattern, "{name}", name, whole ? strlen(name) : length);
}

/* What a file's name should not have. */
static void make_plain(char *name) {
    for (char *c = name; *c != '\0'; c++)
        if (strchr("/\\:*?\"<>|", *c) != NULL || (unsigned char)*c <= ' ') *c = '_';
}

/* `path` with the camera's name where {camera} stands, else before the extension; takes the path. */
static char *expand_camera(char *path, const char *camera) {
    char name[128];
    snprintf(name, sizeof name, "%s", camera);
    make_plain(name);
    char *named = strstr(path, "{camera}") != NULL ? expand(path, "{camera}", name, strlen(name))
                                                   : output_aov_path(path, name);
    free(path);
    return named;
}

/* The place of "%d", "%4d" or "%04d" and its length; NULL without one. The other % of a pattern stand
 * for themselves. */
static const char *find_number(const char *pattern, size_t *length) {
    for (const char *at = strchr(pattern, '%'); at != NULL; at = strchr(at + 1, '%')) {
        size_t digits = strspn(at + 1, "0123456789");
        if (digits > 2 || at[digits + 1] != 'd') continue;
        *length = digits + 2;
        return at;
    }
    return NULL;
}

/* `path` with the frame's number where its %04d stands, else before its extension. */
static char *expand_number(char *path, uint32_t frame) {
    size_t length = 0, size = strlen(path) + 128;
    const char *mark = find_number(path, &length);
    char *numbered = malloc(size);
    if (numbered != NULL && mark != NULL) {
        int width = atoi(mark + 1);
        snprintf(numbered, size, mark[1] == '0' ? "%.*s%0*u%s" : "%.*s%*u%s", (int)(mark - path),
                 path, width, frame, mark + length);
    } else if (numbered != NULL) {
        const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
        const char *dot = strrchr(name, '.');
        size_t stem = dot != NULL && dot != name ? (size_t)(dot - path) : strlen(path);
        snprintf(numbered, size, "%.*s.%04u%s", (int)stem, path, frame, path + stem);
    }
    free(path);
    return numbered;
}

const char *output_extension(const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    return dot != NULL && dot != name ? dot + 1 : "";
}

bool output_find_format(const char *word, snell_picture_format_info *out) {
    *out = (snell_picture_format_info){.struct_size = sizeof *out};
    for (uint32_t i = 0; snell_picture_format(i, out); i++) {
        bool same = strcasecmp(word, out->name) == 0 || strcasecmp(word, out->extension + 1) == 0;
        if (!same && out->extension_too[0] != '\0')
            same = strcasecmp(word, out->extension_too + 1) == 0;
        if (same) return true;
    }
    return false;
}

bool output_is_movie(const options *o, bool many_frames) {
    const char *given = o->value[OPT_OUTPUT], *word = "png";
    bool standard = given != NULL && strcmp(given, "-") == 0;
    size_t length;
    if (given != NULL && !standard) word = output_extension(given);
    if (standard && o->value[OPT_FORMAT] != NULL) word = o->value[OPT_FORMAT];
    snell_picture_format_info format;
    if (!output_find_format(word, &format) || !format.animation) return false;
    return !format.picture || (many_frames && !standard && find_number(given, &length) == NULL);
}

/* What --bits, --quality and --chroma ask for must be there to be had. */
static int check_encoding(const options *o, const snell_picture_format_info *f) {
    uint32_t bits, quality;
    int code = values_read_encoding(o, &bits, &quality);
    if (code == EXIT_DONE && quality > 0 && !f->quality)
        code = report_usage("it is for .jpg and .webp", "--quality: a %s file loses nothing",
                            f->extension);
    if (code == EXIT_DONE && o->value[OPT_CHROMA] != NULL && !f->chroma)
        code =
            report_usage("it is for .y4m", "--chroma: a %s file has no choice of it", f->extension);
    if (code == EXIT_DONE && bits > 0 && bits != f->bits[0] && bits != f->bits[1])
        code = report_usage("PNG has 8 or 16, EXR 16 or 32", "--bits: a %s file has no %u of them",
                            f->extension, bits);
    return code;
}

static int check_format(const char *label, const char *extension, const char *path,
                        snell_picture_format_info *format) {
    struct stat info;
    if (output_find_format(extension, format)) {
        if (format->built) return EXIT_DONE;
        return report_error(EXIT_UNSUPPORTED,
                            "'snell --version' tells what it lacks; write .png, or "
                            ".pfm for floats",
                            "'%s': this build does not write %s", path, format->extension);
    }
    bool folder = *path == '\0' || path[strlen(path) - 1] == '/' ||
                  (stat(path, &info) == 0 && S_ISDIR(info.st_mode));
    if (folder) {
        return report_usage(*label == '-' ? "such as -o 'folder/{name}.png'" : NULL,
                            "%s'%s' is a folder", label, path);
    }
    return report_usage(*label == '\0' /* convert */
                            ? "the extension says how it is written: .png, .exr, .jpg, .webp, .pfm "
                              "or .ppm, and .snell or .lua for a scene"
                            : "the extension says how it is written: .png, .exr, .jpg, .webp, .pfm "
                              "or .ppm, and .apng, .webp or .y4m for an animation",
                        "%s'%s' is no kind of picture that snell writes", label, path);
}

/* Makes a file and removes it: permissions alone do not tell, as root and on read-only or virtual
 * file systems. */
static bool can_write_in(const char *folder) {
    static const char name[] = "/.snell-XXXXXX";
    if (access(folder, W_OK | X_OK) != 0) return false;
    size_t length = strlen(folder);
    char *path = malloc(length + sizeof name);
    if (path == NULL) return false;
    memcpy(path, folder, length);
    memcpy(path + length, name, sizeof name);
    int file = mkstemp(path), error = errno;
    if (file >= 0) {
        close(file);
        unlink(path);
    }
    free(path);
    errno = error;
    return file >= 0;
}

/* A picture that cannot be written should be known before it is computed. */
int output_check_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    size_t length = slash == NULL ? 1 : slash == path ? 1 : (size_t)(slash - path);
    char *folder = slash == NULL ? strdup(".") : strndup(path, length);
    struct stat info;
    int code = EXIT_DONE;
    if (folder == NULL) {
        code = report_error(EXIT_MEMORY, NULL, "out of memory");
    } else if (stat(folder, &info) != 0) {
        code =
            report_error(EXIT_IO, errno == ENOENT ? "make it first, with mkdir -p" : NULL,
                         "%s: the folder '%s' cannot be used: %s", path, folder, strerror(errno));
    } else if (!S_ISDIR(info.st_mode)) {
        code = report_error(EXIT_IO, NULL, "%s: '%s' is no folder", path, folder);
    } else if (!can_write_in(folder)) {
        code = report_error(EXIT_IO, "name another place", "%s: cannot write in %s: %s", path,
                            strcmp(folder, ".") == 0 ? "this folder" : folder, strerror(errno));
    } else if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        code = report_error(EXIT_IO, NULL, "%s is there already, and is no ordinary file", path);
    }
    free(folder);
    return code;
}

static bool made_by_snell(const char *path) {
    snell_picture_info info = {.struct_size = sizeof info};
    if (snell_picture_read_info(path, &info) != SNELL_OK) return false;
    bool made = info.tag != NULL && info.tag[0] != '\0';
    snell_free(info.tag);
    snell_free(info.layers);
    return made;
}

/* Without -o the name was not chosen by the user, so a file of somebody else's stays. */
int output_check_owner(const output *out, const char *path) {
    struct stat info;
    if (out->given != NULL || out->force || lstat(path, &info) != 0) return EXIT_DONE;
    if (made_by_snell(path)) return EXIT_DONE;
    return report_error(EXIT_IO, "-o names another file, --force overwrites it",
                        "%s is there already, and snell did not make it", path);
}

static int plan_standard(output *out, const options *o, const char *label) {
    const char *format = o->value[OPT_FORMAT] != NULL ? o->value[OPT_FORMAT] : "png";
    if (report_json()) {
        return report_usage(NULL, "%sthe picture and --json both want standard output", label);
    }
    if (isatty(STDOUT_FILENO)) {
        return report_usage("redirect it: snell ... > picture.png",
                            "%sstandard output is a terminal", label);
    }
    char name[16];
    snprintf(name, sizeof name, "-.%s", format);
    return check_format(label, format, name, &out->format);
}

static int plan_file(output *out, const options *o, const char *label) {
    if (out->path == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    if (output_is_standard(out)) return plan_standard(out, o, label);
    if (o->value[OPT_FORMAT] != NULL) {
        return report_usage("with a file the extension of -o, or of B, says it",
                            "--format is for standard output, '-'");
    }
    int code = check_format(label, output_extension(out->path), out->path, &out->format);
    return code == EXIT_DONE ? output_check_folder(out->path) : code;
}

int output_plan_path(output *out, const options *o, const char *label, const char *path) {
    *out = (output){.path = strdup(path), .given = path};
    int code = plan_file(out, o, label);
    if (code == EXIT_DONE && !out->format.picture)
        code = report_usage("snell render writes animations", "%s'%s' is for several pictures",
                            label, path);
    return code == EXIT_DONE ? check_encoding(o, &out->format) : code;
}

int output_plan(output *out, const options *o, const output_subject *of) {
    *out = (output){.given = o->value[OPT_OUTPUT], .force = o->value[OPT_FORCE] != NULL};
    const char *pattern = out->given != NULL ? out->given : "{name}.png";
    out->path = expand_name(pattern, of->input, of->whole);
    bool camera = of->camera[0] != '\0' || strstr(pattern, "{camera}") != NULL;
    if (out->path != NULL && camera && !output_is_standard(out))
        out->path = expand_camera(out->path, of->camera[0] != '\0' ? of->camera : "camera");
    if (out->path != NULL && of->frame > 0 && !output_is_standard(out))
        out->path = expand_number(out->path, of->frame);
    int code = plan_file(out, o, "-o: ");
    if (code == EXIT_DONE) code = check_encoding(o, &out->format);
    if (code == EXIT_DONE && !output_is_standard(out)) code = output_check_owner(out, out->path);
    return code;
}

void output_free(output *out) {
    free(out->path);
    out->path = NULL;
}

/* Standard output takes one picture, or one stream of frames; standard input is read once. */
static int check_standard(const options *o, const render_values *v) {
    const char *given = o->value[OPT_OUTPUT];
    bool again = v->many_frames || v->all_cameras, standard = given && strcmp(given, "-") == 0;
    bool movie = output_is_movie(o, v->many_frames);
    const char *option = v->all_cameras ? "--camera all"
                         : v->turntable ? "--turntable"
                                        : "--frames";
    if (standard && v->all_cameras)
        return report_usage("such as -o '{camera}.png'",
                            "--camera all makes several pictures; standard output takes one");
    if (standard && v->many_frames && !movie)
        return report_usage("such as -o 'out/%04d.png', or --format y4m for a video encoder",
                            "%s makes several pictures; standard output takes one", option);
    if (movie && o->value[OPT_AOV] != NULL && strcmp(o->value[OPT_AOV], "none") != 0)
        return report_usage("write numbered pictures, such as -o 'out/%04d.exr'",
                            "--aov: an animation has no layers");
    for (size_t i = 0; i < o->operands.count && again; i++) {
        if (strcmp(o->operands.items[i], "-") == 0)
            return report_usage("put it into a file",
                                "%s reads the scene once per picture, standard input only once",
                                option);
    }
    return EXIT_DONE;
}

typedef struct planned {
    char *path;
    size_t index;
} planned;

static int compare_paths(const void *a, const void *b) {
    const planned *x = a, *y = b;
    int order = strcmp(x->path, y->path);
    return order != 0 ? order : (x->index > y->index) - (x->index < y->index);
}

static int check_unique(const options *o, const char *pattern, const bool *whole) {
    size_t count = o->operands.count;
    const char **items = o->operands.items;
    planned *all = calloc(count + 1, sizeof *all);
    int code = all != NULL ? EXIT_DONE : report_error(EXIT_MEMORY, NULL, "out of memory");
    for (size_t i = 0; i < count && code == EXIT_DONE; i++) {
        all[i] = (planned){expand_name(pattern, items[i], whole[i]), i};
        if (all[i].path == NULL) code = report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    if (code == EXIT_DONE) qsort(all, count, sizeof *all, compare_paths);
    for (size_t i = 0; i + 1 < count && code == EXIT_DONE; i++) {
        if (strcmp(all[i].path, all[i + 1].path) != 0) continue;
        code = report_usage("name them one at a time with -o",
                            "'%s' and '%s' would both be written to %s", items[all[i].index],
                            items[all[i + 1].index], all[i].path);
    }
    for (size_t i = 0; all != NULL && i < count; i++) free(all[i].path);
    free(all);
    return code;
}

int output_check_all(const options *o, const render_values *v, const bool *whole) {
    const char *given = o->value[OPT_OUTPUT];
    size_t count = o->operands.count, length = 0;
    if (o->given[OPT_OUTPUT] > 1) {
        return report_usage(NULL, "-o is given twice; one render writes one picture");
    }
    int code = check_standard(o, v);
    if (code != EXIT_DONE) return code;
    snell_picture_format_info format;
    bool standard = given != NULL && strcmp(given, "-") == 0;
    if (given != NULL && !standard)
        code = check_format("-o: ", output_extension(given), given, &format);
    if (code != EXIT_DONE) return code;
    const char *word = standard ? o->value[OPT_FORMAT] : given ? output_extension(given) : NULL;
    if (v->transparent && word != NULL && output_find_format(word, &format) && !format.alpha)
        report_warning("write .png, .webp, .exr or .apng",
                       "--background transparent: a %s file has no alpha, so black is behind",
                       format.extension);
    const char *mark = given != NULL ? unknown_mark(given, v->all_cameras, &length) : NULL;
    if (mark != NULL) {
        return report_usage(v->all_cameras ? "{name} is the input's name, {camera} the camera's"
                                           : "{name} stands for the input's name",
                            "-o: '%.*s' means nothing", (int)(length < 80 ? length : 80), mark);
    }
    if (count > 1 && given != NULL && strstr(given, "{name}") == NULL) {
        return report_usage("such as -o '{name}.png'", "-o: one name for %zu pictures", count);
    }
    const char *slash = given != NULL ? strrchr(given, '/') : NULL;
    if (slash != NULL && strcspn(given, "{%") > (size_t)(slash - given)) {
        code = output_check_folder(given); /* of all pictures: said once */
        if (code != EXIT_DONE) return code;
    }
    return check_unique(o, given != NULL ? given : "{name}.png", whole);
}

/* ---- AOVs ---- */

bool output_has_aov_files(const output *out) { return !out->format.layers; }

/* How many channels the first AOV in the list has. */
static size_t channel_count(const char *list) {
    const char *name, *channels;
    size_t length = strcspn(list, ","), count = 1;
    for (uint32_t i = 0; (name = snell_aov_name(i, &channels, NULL)) != NULL; i++) {
        if (strlen(name) != length || strncmp(name, list, length) != 0) continue;
        while ((channels = strchr(channels, ' ')) != NULL) channels++, count++;
        break;
    }
    return count;
}

int output_check_size(const output *out, const snell_render_desc *d) {
    uint32_t width = d->crop_width > 0 ? d->crop_width : d->width,
             height = d->crop_width > 0 ? d->crop_height : d->height, most = out->format.side_max;
    if (most == 0 || (width <= most && height <= most)) return EXIT_DONE;
    return report_usage("write .png or .apng", "%s: a %s file has at most %u pixels a side",
                        output_is_standard(out) ? "standard output" : out->path,
                        out->format.extension, most);
}

int output_check_aovs(const output *out, const char *list) {
    if (list == NULL || *list == '\0' || !output_has_aov_files(out)) return EXIT_DONE;
    if (output_is_standard(out)) {
        return report_usage("--format exr has room for them, --aov none leaves them out",
                            "--aov: standard output takes one picture");
    }
    bool numbers = out->format.linear;
    for (const char *at = list; numbers && *at != '\0';) {
        size_t length = strcspn(at, ",");
        if (channel_count(at) > 3) {
            return report_usage("write .exr, or .png to look at it",
                                "--aov: '%.*s' has more channels than a .pfm", (int)length, at);
        }
        at += length + (at[length] == ',');
    }
    return EXIT_DONE;
}

char *output_aov_path(const char *path, const char *name) {
    const char *extension = output_extension(path);
    size_t stem = strlen(path) - strlen(extension), size = strlen(path) + strlen(name) + 2;
    char *made = malloc(size);
    if (made == NULL) return NULL;
    snprintf(made, size, "%.*s%s.%s", (int)stem, path, name, extension);
    make_plain(made + stem);
    return made;
}

static int write_aov(const output *out, const snell_film *film, const snell_image_desc *desc,
                     const char *path, const char *name) {
    snell_image_desc one = *desc;
    char *place = output_aov_path(path, name);
    one.aov = name;
    if (place == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    int code = output_check_owner(out, place);
    if (code == EXIT_DONE) {
        snell_status status = snell_film_write(film, place, &one);
        if (status != SNELL_OK) code = report_status(status, place);
    }
    free(place);
    return code;
}

/* ---- writing ---- */

static int write_files(const output *out, const snell_film *film, const snell_image_desc *desc,
                       const char *path) {
    snell_aov aov;
    snell_status status = snell_film_write(film, path, desc);
    int code = status == SNELL_OK ? EXIT_DONE : report_status(status, path);
    bool files = output_has_aov_files(out);
    for (uint32_t i = 0; files && code == EXIT_DONE && snell_film_aov(film, i, &aov); i++)
        code = write_aov(out, film, desc, path, aov.name);
    return code;
}

int output_write(const output *out, const snell_film *film, const snell_image_desc *desc) {
    if (!output_is_standard(out)) return write_files(out, film, desc, out->path);
    void *data = NULL;
    size_t size = 0;
    snell_status status = snell_film_encode(film, out->format.name, desc, &data, &size);
    if (status != SNELL_OK) return report_status(status, "standard output");
    bool written = fwrite(data, 1, size, stdout) == size && fflush(stdout) == 0;
    int error = errno;
    snell_free(data);
    if (written) return EXIT_DONE;
    return report_no_output(error);
}

char *output_partial_path(const output *out) {
    const char *extension = output_extension(out->path);
    size_t stem = strlen(out->path) - strlen(extension), size = strlen(out->path) + 16;
    char *partial = malloc(size);
    if (partial != NULL) snprintf(partial, size, "%.*spartial.%s", (int)stem, out->path, extension);
    return partial;
}

int output_write_partial(const output *out, const snell_film *film, const snell_image_desc *desc,
                         char **path) {
    *path = NULL;
    if (output_is_standard(out)) return EXIT_DONE;
    char *partial = output_partial_path(out);
    if (partial == NULL) return report_error(EXIT_MEMORY, NULL, "out of memory");
    int code = output_check_owner(out, partial);
    if (code == EXIT_DONE) code = write_files(out, film, desc, partial);
    if (code == EXIT_DONE)
        *path = partial;
    else
        free(partial);
    return code;
}
