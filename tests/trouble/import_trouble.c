/* In place of src/importers/import.c in the snell-import of test_helper: the scene file's first word
 * says what trouble to make. Everything runs inside the real sandbox. */
#include <errno.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"
#include "importers/files.h"
#include "importers/protocol.h"

static void wait_seconds(time_t seconds) { /* the sandbox knows no sleep */
    static uint32_t word;
    struct timespec limit = {seconds, 0};
    syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, 0, &limit, NULL, 0);
}

static void write_raw(int fd, const void *data, size_t size) {
    if (write(fd, data, size) < 0) _exit(9);
}

static snell_status make_ball(description *d) {
    uint32_t shape;
    snell_status status = description_add(d, CATEGORY_SHAPE, "sphere", NULL, 0,
                                          (object_source){"ball", "ball.trouble", 1}, &shape);
    if (status) return status;
    return description_add_instance(d, shape, NO_MATERIAL, NULL, (object_source){0}, NULL);
}

/* ---- each tries to leave the sandbox; true: it got out ---- */

static bool opens(const char *path, int flags) {
    int fd = open(path, flags | O_CLOEXEC, 0600);
    if (fd < 0) return false;
    close(fd);
    return true;
}

static bool reads_password_file(const char *scene) {
    (void)scene;
    return opens("/etc/passwd", O_RDONLY);
}

static bool lists_root(const char *scene) {
    (void)scene;
    return opens("/", O_RDONLY | O_DIRECTORY);
}

static bool reads_proc(const char *scene) {
    (void)scene;
    return opens("/proc/self/mem", O_RDONLY);
}

static bool writes_scene(const char *scene) {
    return opens(scene, O_WRONLY) || opens(scene, O_RDWR) || opens(scene, O_RDONLY | O_TRUNC);
}

static bool makes_file(const char *scene) {
    char path[4096];
    snprintf(path, sizeof path, "%s.new", scene);
    return opens(path, O_WRONLY | O_CREAT) || opens(path, O_RDONLY | O_CREAT);
}

static bool removes_file(const char *scene) { return unlink(scene) == 0; }

static bool changes_mode(const char *scene) { return chmod(scene, 0777) == 0; }

static bool opens_sockets(const char *scene) {
    (void)scene;
    int ends[2];
    return socket(AF_INET, SOCK_STREAM, 0) >= 0 || socket(AF_UNIX, SOCK_STREAM, 0) >= 0 ||
           socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0;
}

static bool runs_programs(const char *scene) {
    (void)scene;
    char name[] = "true";
    char *arguments[] = {name, NULL}, *environment[] = {NULL};
    execve("/bin/true", arguments, environment); /* succeeding would end us without "done" */
    return false;
}

static bool forks(const char *scene) {
    (void)scene;
    pid_t child = fork();
    if (child == 0) _exit(0);
    return child > 0;
}

static bool signals_parent(const char *scene) {
    (void)scene;
    return kill(1, 0) == 0 || kill(getpid(), 0) == 0;
}

static bool traces(const char *scene) {
    (void)scene;
    return ptrace(PTRACE_TRACEME, 0, NULL, NULL) == 0;
}

static bool maps_code(const char *scene) {
    (void)scene;
    void *page = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (page == MAP_FAILED) return false;
    return mprotect(page, 4096, PROT_READ | PROT_EXEC) == 0 ||
           mmap(NULL, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) !=
               MAP_FAILED;
}

static bool raises_limits(const char *scene) {
    (void)scene;
    struct rlimit old, more = {RLIM_INFINITY, RLIM_INFINITY};
    if (getrlimit(RLIMIT_CPU, &old) != 0) return true; /* asking is allowed */
    return setrlimit(RLIMIT_CPU, &more) == 0;
}

static bool keeps_open_files(const char *scene) {
    (void)scene;
    for (int fd = PROTOCOL_PIPE_FD + 1; fd < 64; fd++)
        if (lseek(fd, 0, SEEK_CUR) >= 0 || errno != EBADF) return true;
    return false;
}

static bool dumps_core(const char *scene) {
    (void)scene;
    struct rlimit core;
    return getrlimit(RLIMIT_CORE, &core) != 0 || core.rlim_max != 0;
}

static const struct {
    const char *name;
    bool (*escapes)(const char *scene);
} walls[] = {
    {"reads_password_file", reads_password_file},
    {"lists_root", lists_root},
    {"reads_proc", reads_proc},
    {"writes_scene", writes_scene},
    {"makes_file", makes_file},
    {"removes_file", removes_file},
    {"changes_mode", changes_mode},
    {"opens_sockets", opens_sockets},
    {"runs_programs", runs_programs},
    {"forks", forks},
    {"signals_parent", signals_parent},
    {"traces", traces},
    {"maps_code", maps_code},
    {"raises_limits", raises_limits},
    {"keeps_open_files", keeps_open_files},
    {"dumps_core", dumps_core},
};

static snell_status try_walls(const char *path, description *d) {
    for (size_t i = 0; i < sizeof walls / sizeof walls[0]; i++) {
        snell_status status = description_add_param(
            d, walls[i].name, "wall", walls[i].escapes(path) ? "open" : "held", "held", NULL);
        if (status) return status;
    }
    return make_ball(d);
}

static snell_status allocate(void) {
    for (size_t i = 0; i < 1u << 20; i++) {
        char *volatile memory = malloc(1 << 20); /* volatile: clang leaves unused memory out */
        if (memory == NULL) return error_no_memory();
        memset(memory, 1, 1 << 20);
    }
    return SNELL_OK;
}

static snell_status odd_error(void) {
    static protocol_record record;
    memset(&record, 'x', sizeof record);
    record.kind = PROTOCOL_ERROR;
    record.status = 12345;
    memcpy(record.text, "bell \a escape \033[31m", 19);
    write_raw(PROTOCOL_PIPE_FD, &record, sizeof record);
    _exit(0);
}

static snell_status flood(bool forever) {
    static protocol_record record = {.kind = PROTOCOL_PROGRESS, .fraction = 0.25};
    for (int i = 0; forever || i < 10000; i++) write_raw(PROTOCOL_PIPE_FD, &record, sizeof record);
    return SNELL_OK;
}

static snell_status read_other(const char *path, const char *name, const import_options *options,
                               description *d) {
    uint8_t *data;
    size_t size;
    snell_status status = import_read_beside(path, name, options, &data, &size);
    if (status) return status;
    free(data);
    return make_ball(d);
}

snell_status import_file(const char *path, const char *format, const import_options *options,
                         description *d) {
    (void)format;
    static const uint64_t garbage[64] = {1, 2, 3};
    static const protocol_record done = {.kind = PROTOCOL_DONE};
    char word[32] = "", rest[256] = "";
    FILE *file = fopen(path, "re");
    if (file == NULL) return error_set(SNELL_ERR_IO, NULL, "cannot open '%s'", path);
    int words = fscanf(file, "%31s %255s", word, rest);
    fclose(file);
    if (words < 1) return error_set(SNELL_ERR_SYNTAX, NULL, "no word");
    if (strcmp(word, "ball") == 0) return make_ball(d);
    if (strcmp(word, "crash") == 0) raise(SIGSEGV);
    if (strcmp(word, "abort") == 0) abort();
    if (strcmp(word, "loop") == 0)
        for (volatile int i = 0;; i = !i) continue;
    if (strcmp(word, "hang") == 0) wait_seconds(60);
    if (strcmp(word, "allocate") == 0) return allocate();
    if (strcmp(word, "walls") == 0) return try_walls(path, d);
    if (strcmp(word, "read") == 0) return read_other(path, rest, options, d);
    if (strcmp(word, "silent") == 0) _exit(0);
    if (strcmp(word, "code") == 0) _exit(7);
    if (strcmp(word, "odd-error") == 0) return odd_error();
    if (strcmp(word, "flood") == 0) return flood(true);
    if (strcmp(word, "much") == 0) return flood(false) ? SNELL_ERR_IO : make_ball(d);
    if (strcmp(word, "error") == 0)
        return error_set_at(SNELL_ERR_UNSUPPORTED, (source_place){"other.file", 7, 3}, "a hint",
                            "a text");
    if (strcmp(word, "params") == 0)
        return description_add_param(
            d, options->params[0], options->params[1], options->up ? options->up : "none",
            options->allow_programs ? "yes" : "no", format ? format : "none");
    if (strcmp(word, "progress") == 0) {
        options->progress(options->progress_user, 0);
        wait_seconds(1);
        options->progress(options->progress_user, 0.5);
        wait_seconds(1);
        return make_ball(d);
    }
    if (strcmp(word, "half") == 0) { /* of a record */
        write_raw(PROTOCOL_PIPE_FD, &done, 10);
        _exit(0);
    }
    if (strcmp(word, "lie") == 0) {
        write_raw(PROTOCOL_PIPE_FD, &done, sizeof done);
        _exit(0);
    }
    if (strcmp(word, "garbage") == 0) {
        write_raw(PROTOCOL_RESULT_FD, garbage, sizeof garbage);
        write_raw(PROTOCOL_PIPE_FD, &done, sizeof done);
        _exit(0);
    }
    return error_set(SNELL_ERR_SYNTAX, NULL, "unknown word '%s'", word);
}
