#include "session.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "progress.h"
#include "report.h"
#include "text.h"

extern char **environ;

enum { THREADS_MAX = 1024 };

const char *session_label(const char *path) {
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

void session_check_environment(void) {
    static const char *const known[] = {"SNELL_THREADS", "SNELL_ISA"};
    for (char **entry = environ; entry != NULL && *entry != NULL; entry++) {
        char name[64], hint[120] = "snell reads SNELL_THREADS, SNELL_ISA and NO_COLOR";
        size_t length = strcspn(*entry, "=");
        if (strncmp(*entry, "SNELL_", 6) != 0 || length >= sizeof name) continue;
        memcpy(name, *entry, length);
        name[length] = '\0';
        if (strcmp(name, known[0]) == 0 || strcmp(name, known[1]) == 0) continue;
        const char *near = text_closest(name, known, 2);
        if (near != NULL) snprintf(hint, sizeof hint, "did you mean %s?", near);
        report_warning(hint, "the environment variable %s means nothing to snell", name);
    }
}

/* The option, else the environment variable; `source` names which in messages. */
static const char *option_or_environment(const options *o, option_id id, const char *option,
                                         const char *variable, const char **source) {
    *source = option;
    if (o->value[id] != NULL) return o->value[id];
    const char *value = getenv(variable);
    *source = variable;
    return value != NULL && *value != '\0' ? value : NULL;
}

static int read_threads(const options *o, uint32_t *out) {
    const char *source,
        *text = option_or_environment(o, OPT_THREADS, "--threads", "SNELL_THREADS", &source);
    uint64_t threads = 0;
    if (text != NULL && !text_uint(text, 1, THREADS_MAX, &threads)) {
        return report_usage(NULL, "%s: '%s' is not a whole number from 1 to %d", source, text,
                            THREADS_MAX);
    }
    *out = (uint32_t)threads;
    return EXIT_DONE;
}

static int read_isa(const options *o, snell_isa *out) {
    const char *source, *text = option_or_environment(o, OPT_ISA, "--isa", "SNELL_ISA", &source);
    *out = SNELL_ISA_AUTO;
    if (text == NULL) return EXIT_DONE;
    for (int isa = SNELL_ISA_AUTO; isa <= SNELL_ISA_AVX512; isa++) {
        if (strcmp(text, snell_isa_name((snell_isa)isa)) == 0) {
            *out = (snell_isa)isa;
            return EXIT_DONE;
        }
    }
    return report_usage("it is one of: scalar, avx2, avx512, auto", "%s: there is no '%s'", source,
                        text);
}

static int read_build(const options *o, snell_build *out) {
    static const char *const names[] = {"balanced", "fast", "best"}; /* as snell_build */
    const char *text = o->value[OPT_BUILD];
    *out = SNELL_BUILD_BALANCED;
    if (text == NULL) return EXIT_DONE;
    for (int i = 0; i < 3; i++) {
        if (strcmp(text, names[i]) != 0) continue;
        *out = (snell_build)i;
        return EXIT_DONE;
    }
    return report_usage("it is one of: fast, balanced, best", "--build: there is no '%s'", text);
}

/* --memory holds for this process by the kernel's count of its writable memory (RLIMIT_DATA), so
 * that an allocation fails instead of the machine; the import helper inherits it. */
static int limit_memory(session *s) {
    const char *text = s->options->value[OPT_MEMORY];
    if (text == NULL) return EXIT_DONE;
    if (!text_bytes(text, &s->memory_max) || s->memory_max < (16u << 20)) {
        return report_usage("such as 512M or 8G; at least 16M", "--memory: '%s' is no size", text);
    }
    struct rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit) == 0 && limit.rlim_cur > s->memory_max) {
        limit.rlim_cur = s->memory_max;
        if (setrlimit(RLIMIT_DATA, &limit) != 0) {
            return report_error(EXIT_MEMORY, NULL, "--memory: the limit cannot be set: %s",
                                strerror(errno));
        }
    }
    return EXIT_DONE;
}

static int check_input_format(const options *o) {
    const char *format = o->value[OPT_INPUT_FORMAT];
    const char *names[128], *name;
    size_t count = 0;
    if (format == NULL) return EXIT_DONE;
    while (count < 128 && (name = snell_formats((uint32_t)count, NULL)) != NULL) {
        if (name[0] == '.') name++; /* an extension */
        if (strcmp(name, format) == 0) return EXIT_DONE;
        names[count++] = name;
    }
    char hint[120] = "'snell help formats' lists them";
    const char *near = text_closest(format, names, count);
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return report_usage(hint, "--input-format: there is no '%s'", format);
}

int session_open(session *s, const options *o) {
    *s = (session){.options = o};
    snell_context_desc desc = SNELL_INIT(context_desc);
    int code = read_threads(o, &desc.thread_count);
    if (code == EXIT_DONE) code = read_isa(o, &desc.isa_max);
    if (code == EXIT_DONE) code = read_build(o, &desc.build);
    if (code == EXIT_DONE) code = check_input_format(o);
    if (code == EXIT_DONE) code = limit_memory(s);
    if (code != EXIT_DONE) return code;
    desc.log = report_log;
    desc.memory_max = s->memory_max;
    snell_status status = snell_context_create(&desc, &s->context);
    return status == SNELL_OK ? EXIT_DONE : report_status(status, NULL);
}

void session_end_input(session *s) {
    report_alias(NULL, NULL);
    if (s->spool_file != NULL) unlink(s->spool_file);
    if (s->spool_folder != NULL) rmdir(s->spool_folder);
    free(s->spool_file);
    free(s->spool_folder);
    s->spool_file = s->spool_folder = NULL;
}

void session_close(session *s) {
    session_end_input(s);
    snell_context_destroy(s->context);
    s->context = NULL;
}

uint64_t session_memory_peak(int who) {
    struct rusage usage;
    return getrusage(who, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024 : 0;
}

static int copy_input(FILE *to) {
    static char block[1 << 16];
    for (;;) {
        ssize_t got = read(STDIN_FILENO, block, sizeof block);
        if (signals_caught() != 0) return EXIT_SOME_FAILED;
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            return report_error(EXIT_IO, NULL, "standard input cannot be read: %s",
                                strerror(errno));
        }
        if (got == 0) break;
        if (fwrite(block, 1, (size_t)got, to) != (size_t)got) {
            return report_error(EXIT_IO, "TMPDIR names another folder for it",
                                "standard input cannot be kept: %s", strerror(errno));
        }
    }
    return EXIT_DONE;
}

static int spool_failed(const char *what) {
    return report_error(EXIT_IO, NULL, "%s cannot be kept: %s", what, strerror(errno));
}

/* Importers want a file that they can map and seek: what is none becomes one, in a folder of its own
 * that nobody else can read. */
static int spool_begin(session *s, const char *what, const char *format, FILE **to) {
    const char *base = getenv("TMPDIR");
    char path[4096];
    if (base == NULL || base[0] != '/') base = "/tmp";
    snprintf(path, sizeof path, "%.3000s/snell-XXXXXX", base);
    if (mkdtemp(path) == NULL) {
        return report_error(EXIT_IO, "TMPDIR names another folder for it",
                            "%s cannot be kept: %s: %s", what, base, strerror(errno));
    }
    s->spool_folder = strdup(path);
    size_t used = strlen(path);
    snprintf(path + used, sizeof path - used, "/stdin%s%.32s", format != NULL ? "." : "",
             format != NULL ? format : "");
    s->spool_file = strdup(path);
    if (s->spool_folder == NULL || s->spool_file == NULL) {
        return report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    *to = fopen(s->spool_file, "wbx");
    return *to != NULL ? EXIT_DONE : spool_failed(what);
}

static int spool_input(session *s) {
    FILE *to;
    int code = spool_begin(s, "standard input", s->options->value[OPT_INPUT_FORMAT], &to);
    if (code != EXIT_DONE) return code;
    code = copy_input(to);
    if (fclose(to) != 0 && code == EXIT_DONE) code = spool_failed("standard input");
    return code;
}

static int spool_text(session *s, const char *name, const unsigned char *text, size_t size) {
    FILE *to;
    int code = spool_begin(s, name, "lua", &to);
    if (code != EXIT_DONE) return code;
    if (fwrite(text, 1, size, to) != size) code = spool_failed(name);
    if (fclose(to) != 0 && code == EXIT_DONE) code = spool_failed(name);
    return code;
}

/* -D is for scene programs and animated models; with several files it may be meant for some of them, but a value that
 * does nothing is a mistake all the same. */
static int check_takes_values(const snell_scene *scene, const char *path) {
    snell_scene_stats stats = {.struct_size = sizeof stats};
    snell_status status = snell_scene_get_stats(scene, &stats);
    if (status != SNELL_OK) return report_status(status, path);
    if (strcmp(stats.format, "lua") == 0 || stats.param_count > 0) return EXIT_DONE;
    return report_usage("only scene programs and animated models do: 'snell help param'",
                        "%s takes no values (-D)", path);
}

/* A frame of what does not change is a mistake too, and the last of --frames is not to be found missing
 * when all others are done. */
static int check_has_frames(const session *s, const snell_scene *scene, const char *path) {
    snell_animation clock = {.struct_size = sizeof clock};
    snell_status status = snell_scene_get_animation(scene, &clock);
    if (status != SNELL_OK) return report_status(status, path);
    if (clock.frame_count > 0 && (int64_t)s->frame_last > clock.last)
        return report_usage(
            NULL, "--frames: %s has frames %" PRId32 " to %" PRId32 ", %" PRIu32 " is none", path,
            clock.first, clock.last, s->frame_last);
    if (clock.frame_count > 0) return EXIT_DONE;
    return report_usage("scene programs with animation{} and animated models have: 'snell help "
                        "animation'",
                        "%s has no frames", path);
}

static int load_into(session *s, snell_scene *scene, const char *path) {
    const options *o = s->options;
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.params = o->set.items;
    desc.param_count = o->set.count;
    desc.asset_dirs = o->allow.items;
    desc.asset_dir_count = o->allow.count;
    desc.format = o->value[OPT_INPUT_FORMAT];
    desc.up = o->value[OPT_UP];
    desc.frame = s->frame;
    const char *aov = o->value[OPT_AOV];
    desc.next_frame = s->next_frame || (aov && (strstr(aov, "motion") || strstr(aov, "all")));
    desc.memory_max = s->memory_max;
    desc.progress = progress_report;
    snell_status status = snell_scene_load(scene, path, &desc);
    if (signals_caught() != 0) return EXIT_SOME_FAILED;
    if (status != SNELL_OK) {
        bool from_command_line = status == SNELL_ERR_ARGUMENT && (o->set.count > 0 || s->frame > 0);
        return from_command_line ? report_status_as(EXIT_USAGE, status, path)
                                 : report_status(status, path);
    }
    int code = o->set.count > 0 ? check_takes_values(scene, path) : EXIT_DONE;
    return code == EXIT_DONE && s->frame > 0 ? check_has_frames(s, scene, path) : code;
}

/* A name that is nearly that of a file in the same folder; the caller's. */
static char *near_file(const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash == NULL ? path : slash + 1;
    size_t length = (size_t)(name - path);
    char *folder = length > 0 ? strndup(path, length) : strdup("."), *near = NULL;
    DIR *dir = folder != NULL ? opendir(folder) : NULL;
    for (struct dirent *at; dir != NULL && (at = readdir(dir)) != NULL;) {
        const char *names[] = {at->d_name, near};
        if (at->d_name[0] == '.' || text_closest(name, names, near == NULL ? 1 : 2) != names[0])
            continue;
        free(near);
        near = strdup(at->d_name);
    }
    if (dir != NULL) closedir(dir);
    free(folder);
    char *whole = near != NULL ? malloc(length + strlen(near) + 1) : NULL;
    if (whole != NULL) sprintf(whole, "%.*s%s", (int)length, path, near);
    free(near);
    return whole;
}

int session_check_file(const char *path) {
    if (strcmp(path, "-") == 0 || access(path, F_OK) == 0 || errno != ENOENT) return EXIT_DONE;
    char *near = near_file(path), hint[400];
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean '%.380s'?", near);
    int code = report_error(EXIT_IO, near != NULL ? hint : NULL, "cannot open '%s': %s", path,
                            strerror(ENOENT));
    free(near);
    return code;
}

int session_input(session *s, const char *path, const char **real) {
    *real = path;
    if (strcmp(path, "-") != 0) return session_check_file(path);
    int code = s->spool_file == NULL ? spool_input(s) : EXIT_DONE;
    *real = s->spool_file;
    report_alias(s->spool_file, session_label(path));
    return code;
}

/* Ends the input; `code`: whether `real` is there to be read. */
static int load_new(session *s, int code, const char *path, const char *real, snell_scene **out) {
    *out = NULL;
    if (code == EXIT_DONE) {
        snell_status status = snell_scene_create(s->context, out);
        code = status == SNELL_OK ? load_into(s, *out, real) : report_status(status, path);
    }
    if (!s->keeps_input) session_end_input(s);
    if (code != EXIT_DONE) {
        snell_scene_destroy(*out);
        *out = NULL;
    }
    return code;
}

int session_load(session *s, const char *path, snell_scene **out) {
    const char *real;
    int code = session_input(s, path, &real);
    return load_new(s, code, path, real, out);
}

int session_load_text(session *s, const char *name, const unsigned char *text, size_t size,
                      snell_scene **out) {
    int code = spool_text(s, name, text, size);
    if (s->spool_file != NULL) report_alias(s->spool_file, name);
    return load_new(s, code, name, s->spool_file, out);
}
