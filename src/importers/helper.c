/* The parent's side of the import helper. snell-import reads the file in a sandbox and writes a
 * scene block (scene/records.h), or a picture, into shared memory; what it says on the way comes
 * through a pipe.
 *
 *     helper_import ──posix_spawn──▶ snell-import: limits, Landlock, seccomp, then reads the file
 *        ▲  ▲ pipe: progress, the error, "done" ────┤
 *        │  └ pidfd: it has ended                   │
 *        └── memory file, sealed after its end ◀────┘
 *
 * Nothing that comes back is trusted. The host's signal handling is not relied on: it may ignore
 * SIGCHLD or reap all children, so that how the helper ended can be unknown; then "done" decides.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/pidfd.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/thread.h"
#include "importers/importer.h"
#include "importers/protocol.h"
#include "scene/records.h"

enum { TIME_MAX_DEFAULT = 300, POLL_MS = 40 };

/* ---- before it starts ---- */

static snell_status check_file(const char *path) {
    source_place place = {path, 0, 0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY), error = errno;
    struct stat status = {0};
    if (fd >= 0) {
        error = fstat(fd, &status) == 0 ? 0 : errno;
        if (!error && S_ISDIR(status.st_mode)) error = EISDIR;
        close(fd);
    }
    if (error)
        return error_set_at(SNELL_ERR_IO, place, NULL, "cannot open '%s': %s", path,
                            strerror(error));
    if (!S_ISREG(status.st_mode))
        return error_set_at(SNELL_ERR_IO, place, "copy it to a file first",
                            "cannot read '%s': not a regular file", path);
    if (status.st_size == 0)
        return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "cannot read '%s': the file is empty",
                            path);
    return SNELL_OK;
}

static snell_status check_folders(const import_options *options) {
    for (size_t i = 0; i < options->asset_dir_count; i++) {
        struct stat status;
        int error = stat(options->asset_dirs[i], &status) != 0 ? errno : 0;
        if (!error && !S_ISDIR(status.st_mode)) error = ENOTDIR;
        if (error)
            return error_set(SNELL_ERR_IO, NULL, "cannot read the folder '%s': %s",
                             options->asset_dirs[i], strerror(error));
    }
    return SNELL_OK;
}

static uint64_t read_number(const char *path) {
    char text[64] = "";
    FILE *file = fopen(path, "re");
    if (file == NULL) return UINT64_MAX;
    char *got = fgets(text, sizeof text, file);
    fclose(file);
    if (got == NULL || text[0] < '0' || text[0] > '9') return UINT64_MAX; /* "max" */
    return strtoull(text, NULL, 10);
}

/* The lowest memory.max of this process's control group (version 2) and those above it. */
static uint64_t group_memory(void) {
    char line[PATH_MAX], path[PATH_MAX + 64];
    uint64_t lowest = UINT64_MAX;
    FILE *file = fopen("/proc/self/cgroup", "re");
    if (file == NULL) return lowest;
    while (fgets(line, sizeof line, file)) {
        if (strncmp(line, "0::/", 4) != 0) continue;
        line[strcspn(line, "\n")] = '\0';
        char *group = line + 3;
        for (char *slash; (slash = strrchr(group, '/')) != NULL; *slash = '\0') {
            snprintf(path, sizeof path, "/sys/fs/cgroup%s/memory.max", group);
            uint64_t limit = read_number(path);
            if (limit < lowest) lowest = limit;
        }
    }
    fclose(file);
    return lowest;
}

/* Half of what the machine, or the control group, has. */
static uint64_t default_memory(void) {
    long pages = sysconf(_SC_PHYS_PAGES), page_size = sysconf(_SC_PAGESIZE);
    uint64_t memory =
        pages > 0 && page_size > 0 ? (uint64_t)pages * (uint64_t)page_size : (uint64_t)2 << 30;
    uint64_t group = group_memory();
    return (group < memory ? group : memory) / 2;
}

/* The program belongs to the library: it is looked for beside it first, so that a moved tree works,
 * then, for what runs in the build folder, there, then where it was to be installed. */
static bool find_program(char out[PATH_MAX]) {
    static const char here = 0; /* any object of the library */
    Dl_info info;
    char library[PATH_MAX];
    if (dladdr(&here, &info) && info.dli_fname && realpath(info.dli_fname, library)) {
        *strrchr(library, '/') = '\0';
        static const char *const places[] = {"/../libexec/snell-import",
                                             "/../../libexec/snell-import"};
        for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
            int length = snprintf(out, PATH_MAX, "%s%s", library, places[i]);
            if (length > 0 && length < PATH_MAX && access(out, X_OK) == 0) return true;
        }
        /* The one in the build folder is for what runs in the build folder. */
        static const char built[] = SNELL_HELPER_BUILT;
        size_t folder = (size_t)(strrchr(built, '/') - built);
        if (strncmp(library, built, folder) == 0 &&
            (library[folder] == '/' || library[folder] == '\0')) {
            snprintf(out, PATH_MAX, "%s", built);
            if (access(out, X_OK) == 0) return true;
        }
    }
    snprintf(out, PATH_MAX, "%s", SNELL_LIBEXEC_INSTALLED "/snell-import");
    return access(out, X_OK) == 0;
}

/* ---- the running helper ---- */

typedef struct running {
    const char *path;
    pid_t pid;
    int pidfd; /* -1 where the kernel has none, or the process is gone already */
    int result_fd, pipe_fd;
    uint64_t memory_max;
    double time_max;
    double fraction;
    bool done, failed; /* what it said last */
    bool status_known; /* wait_status is how it ended */
    int wait_status;
    size_t pending_size; /* bytes of a record that has not come whole yet */
    protocol_record pending, error;
} running;

static void close_fd(int *fd) {
    if (*fd >= 0) close(*fd);
    *fd = -1;
}

/* Numbers from 10: the helper's own 3 and 4 then never collide with them. */
static int raise_fd(int fd) {
    if (fd < 0) return -1;
    int raised = fcntl(fd, F_DUPFD_CLOEXEC, 10);
    int error = errno;
    close(fd);
    errno = error;
    return raised;
}

static snell_status open_channels(running *r, int *pipe_write) {
    int ends[2] = {-1, -1};
    r->result_fd = raise_fd(memfd_create("snell-import", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (r->result_fd >= 0 && pipe2(ends, O_CLOEXEC) == 0) {
        r->pipe_fd = raise_fd(ends[0]);
        *pipe_write = raise_fd(ends[1]);
        if (r->pipe_fd >= 0 && *pipe_write >= 0) return SNELL_OK;
    }
    return error_set(SNELL_ERR_IO, NULL, "cannot start snell-import: %s", strerror(errno));
}

enum { ARGUMENTS_FIXED = 20 };

/* The arguments point into path, options and numbers; NULL when out of memory. */
static const char **make_arguments(const running *r, const helper_options *options,
                                   char numbers[3][32]) {
    const import_options *import = &options->import;
    size_t lists = import->param_count + import->asset_dir_count;
    if (lists > INT_MAX / 4) return NULL;
    const char **list = memory_zeroed(ARGUMENTS_FIXED + 2 * lists, sizeof *list);
    if (list == NULL) return NULL;
    snprintf(numbers[0], 32, "%llu", (unsigned long long)r->memory_max);
    snprintf(numbers[1], 32, "%.0f", r->time_max);
    snprintf(numbers[2], 32, "%u", import->frame);
    const char *pairs[][2] = {{PROTOCOL_FILE, r->path},
                              {PROTOCOL_MEMORY, numbers[0]},
                              {PROTOCOL_TIME, numbers[1]},
                              {PROTOCOL_PROGRAMS, import->allow_programs ? "1" : "0"},
                              {PROTOCOL_FORMAT, options->format},
                              {PROTOCOL_UP, import->up},
                              {PROTOCOL_FRAME, numbers[2]},
                              {PROTOCOL_LAYER, import->layer},
                              {PROTOCOL_NEXT, import->next_frame ? "1" : NULL}};
    size_t count = 0;
    list[count++] = "snell-import";
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        if (pairs[i][1] == NULL) continue;
        list[count++] = pairs[i][0];
        list[count++] = pairs[i][1];
    }
    for (size_t i = 0; i < import->param_count; i++) {
        list[count++] = PROTOCOL_PARAM;
        list[count++] = import->params[i];
    }
    for (size_t i = 0; i < import->asset_dir_count; i++) {
        list[count++] = PROTOCOL_ALLOW;
        list[count++] = import->asset_dirs[i];
    }
    return list;
}

static int add_file_actions(posix_spawn_file_actions_t *files, int result_fd, int pipe_write) {
    int error = posix_spawn_file_actions_addopen(files, 0, "/dev/null", O_RDONLY, 0);
    if (!error) error = posix_spawn_file_actions_addopen(files, 1, "/dev/null", O_WRONLY, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) /* sanitizers report there */
    if (!error) error = posix_spawn_file_actions_addopen(files, 2, "/dev/null", O_WRONLY, 0);
#endif
    if (!error) error = posix_spawn_file_actions_adddup2(files, result_fd, PROTOCOL_RESULT_FD);
    if (!error) error = posix_spawn_file_actions_adddup2(files, pipe_write, PROTOCOL_PIPE_FD);
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 34)
    if (!error) error = posix_spawn_file_actions_addclosefrom_np(files, PROTOCOL_PIPE_FD + 1);
#endif
    return error;
}

/* Default signals, none blocked, a process group of its own: Ctrl-C is the host's to handle, which
 * then cancels. */
static int set_attributes(posix_spawnattr_t *attributes) {
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    int error = posix_spawnattr_setsigmask(attributes, &none);
    if (!error) error = posix_spawnattr_setsigdefault(attributes, &all);
    if (!error) error = posix_spawnattr_setpgroup(attributes, 0);
    if (!error)
        error = posix_spawnattr_setflags(
            attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    return error;
}

static int spawn(running *r, const char *program, const char *const *arguments, int pipe_write) {
    static char locale[] = "LC_ALL=C";
    char *const environment[] = {locale, NULL};
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&files);
    if (error) return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        error = add_file_actions(&files, r->result_fd, pipe_write);
        if (!error) error = set_attributes(&attributes);
        if (!error) /* the cast drops a const that posix_spawn keeps but cannot express */
            error = posix_spawn(&r->pid, program, &files, &attributes,
                                (char *const *)(uintptr_t)arguments, environment);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return error;
}

static snell_status start(running *r, const helper_options *options) {
    char program[PATH_MAX], numbers[3][32];
    if (!find_program(program))
        return error_set(SNELL_ERR_IO, "install snell completely: it belongs into libexec",
                         "the program snell-import, which reads files, is missing");
    int pipe_write = -1;
    snell_status status = open_channels(r, &pipe_write);
    if (status == SNELL_OK) {
        const char **arguments = make_arguments(r, options, numbers);
        int error = arguments ? spawn(r, program, arguments, pipe_write) : ENOMEM;
        if (error)
            status =
                error_set(SNELL_ERR_IO, NULL, "cannot start '%s': %s", program, strerror(error));
        else
            r->pidfd = pidfd_open(r->pid, 0);
        free(arguments);
    }
    close_fd(&pipe_write);
    return status;
}

/* ---- what it says ---- */

static void take_record(running *r, const protocol_record *record) {
    if (record->kind == PROTOCOL_PROGRESS && record->fraction > r->fraction &&
        record->fraction <= 1)
        r->fraction = record->fraction;
    if (record->kind == PROTOCOL_DONE) r->done = true;
    if (record->kind == PROTOCOL_ERROR && !r->failed) {
        r->failed = true;
        r->error = *record;
    }
}

/* Reads what is there, a bounded amount; false at the end of the pipe. */
static bool read_pipe(running *r) {
    for (int i = 0; i < 16; i++) {
        ssize_t got = read(r->pipe_fd, (char *)&r->pending + r->pending_size,
                           sizeof r->pending - r->pending_size);
        if (got < 0) return errno == EAGAIN || errno == EINTR;
        if (got == 0) return false;
        r->pending_size += (size_t)got;
        if (r->pending_size < sizeof r->pending) continue;
        take_record(r, &r->pending);
        r->pending_size = 0;
    }
    return true;
}

/* ---- its end ---- */

static void kill_it(const running *r) {
    if (r->pidfd >= 0)
        pidfd_send_signal(r->pidfd, SIGKILL, NULL, 0);
    else
        kill(r->pid, SIGKILL);
}

/* Has it ended? Then it is reaped, by us or by the host. */
static bool has_ended(running *r, bool wait) {
    pid_t got;
    do got = waitpid(r->pid, &r->wait_status, wait ? 0 : WNOHANG);
    while (got < 0 && errno == EINTR);
    if (got == 0) return false;
    r->status_known = got == r->pid;
    return true;
}

/* Waits until it has ended. SNELL_CANCELLED, SNELL_ERR_SYNTAX (too slow) when it was killed. */
static snell_status watch(running *r, const helper_options *options) {
    /* Waiting for a slow disk costs no CPU time, but somewhere it has to end. */
    double begin = time_seconds(), wall_max = 2 * r->time_max + 10, called = begin;
    bool pipe_open = true;
    fcntl(r->pipe_fd, F_SETFL, O_NONBLOCK);
    for (;;) {
        struct pollfd polled[2] = {{pipe_open ? r->pipe_fd : -1, POLLIN, 0}, {r->pidfd, POLLIN, 0}};
        poll(polled, 2, r->pidfd >= 0 ? POLL_MS : POLL_MS / 4);
        if (pipe_open && polled[0].revents) pipe_open = read_pipe(r);
        bool maybe = r->pidfd < 0 || polled[1].revents || !pipe_open;
        if (maybe && has_ended(r, false)) return SNELL_OK;
        double now = time_seconds();
        bool stop = false, late = now - begin > wall_max;
        if (options->progress && now - called >= POLL_MS / 2000.0) {
            stop = !options->progress(options->user, r->fraction);
            called = now;
        }
        if (!stop && !late) continue;
        kill_it(r);
        has_ended(r, true);
        if (stop) return error_set(SNELL_CANCELLED, NULL, "cancelled");
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){r->path, 0, 0}, NULL,
                            "reading took more than %.0f s", wall_max);
    }
}

/* Text from a file may hold what a terminal would obey. */
static void clean_text(char *text) {
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 0x7f)
            if (*text != '\n' && *text != '\t') *text = '?';
}

static snell_status report_error(running *r) {
    protocol_record *e = &r->error;
    char *texts[] = {e->text, e->hint, e->file};
    size_t sizes[] = {sizeof e->text, sizeof e->hint, sizeof e->file};
    for (int i = 0; i < 3; i++) {
        texts[i][sizes[i] - 1] = '\0';
        clean_text(texts[i]);
    }
    snell_status status = (snell_status)e->status;
    if (e->status < SNELL_ERR_ARGUMENT || e->status > SNELL_ERR_INTERNAL) status = SNELL_ERR_SYNTAX;
    if (e->text[0] == '\0') snprintf(e->text, sizeof e->text, "the file could not be read");
    if (status == SNELL_ERR_MEMORY)
        snprintf(e->hint, sizeof e->hint,
                 "reading may use %llu MiB of memory: --memory allows more",
                 (unsigned long long)(r->memory_max >> 20));
    source_place place = {e->file[0] ? e->file : r->path, e->line, e->column};
    return error_set_at(status, place, e->hint, "%s", e->text);
}

static snell_status report_signal(const running *r, int signal) {
    source_place place = {r->path, 0, 0};
    if (signal == SIGXCPU)
        return error_set_at(SNELL_ERR_SYNTAX, place,
                            "a program that never ends, or a file that takes more time",
                            "reading took more than %.0f s of processor time", r->time_max);
    if (signal == SIGKILL) /* not ours: the kernel's, when memory is short or CPU time is up */
        return error_set_at(SNELL_ERR_MEMORY, place, "use a smaller file, or allow more (--memory)",
                            "the reader was killed; it may use %llu MiB of memory",
                            (unsigned long long)(r->memory_max >> 20));
    return error_set_at(SNELL_ERR_SYNTAX, place,
                        "the file may be damaged; another format may fare better",
                        "the file made the reader crash (signal %d)", signal);
}

static snell_status report_end(running *r) {
    while (read_pipe(r) && r->pending_size == 0 && !r->done && !r->failed) {
        struct pollfd polled = {r->pipe_fd, POLLIN, 0};
        if (poll(&polled, 1, 0) <= 0) break;
    }
    if (r->failed) return report_error(r);
    if (r->status_known && WIFSIGNALED(r->wait_status))
        return report_signal(r, WTERMSIG(r->wait_status));
    if (r->done && (!r->status_known || WEXITSTATUS(r->wait_status) == 0)) return SNELL_OK;
    source_place place = {r->path, 0, 0};
    if (!r->status_known)
        return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "the file made the reader end early");
    return error_set_at(SNELL_ERR_SYNTAX, place, NULL,
                        "the file made the reader end early (exit code %d)",
                        WEXITSTATUS(r->wait_status));
}

/* ---- its result ---- */

static snell_status read_result(const running *r, helper_take *take, void *user) {
    source_place place = {r->path, 0, 0};
    struct stat status;
    /* Sealed, nobody can change it any more; it fails if someone still could. */
    if (fcntl(r->result_fd, F_ADD_SEALS,
              F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE) != 0 ||
        fstat(r->result_fd, &status) != 0)
        return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "the reader's result is not at rest: %s",
                            strerror(errno));
    if (status.st_size == 0)
        return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "the reader gave no result");
    size_t size = (size_t)status.st_size;
    void *data = mmap(NULL, size, PROT_READ, MAP_SHARED, r->result_fd, 0);
    if (data == MAP_FAILED)
        return errno == ENOMEM ? error_no_memory()
                               : error_set(SNELL_ERR_IO, NULL, "cannot map the reader's result: %s",
                                           strerror(errno));
    snell_status result = take(user, data, size);
    if (result) error_place(place);
    munmap(data, size);
    return result;
}

snell_status helper_run(const char *path, const helper_options *options, helper_take *take,
                        void *user) {
    snell_status status = check_file(path);
    if (!status) status = check_folders(&options->import);
    if (status) return status;
    running r = {.path = path, .pidfd = -1, .result_fd = -1, .pipe_fd = -1};
    r.memory_max = options->import.memory_max ? options->import.memory_max : default_memory();
    r.time_max = options->time_max > 0 ? ceil(options->time_max) : TIME_MAX_DEFAULT;
    if (!(r.time_max < 1e9)) r.time_max = 1e9;
    status = start(&r, options);
    if (!status) status = watch(&r, options);
    if (!status) status = report_end(&r);
    close_fd(&r.pidfd);
    close_fd(&r.pipe_fd);
    if (!status) status = read_result(&r, take, user);
    close_fd(&r.result_fd);
    return status;
}

static snell_status take_records(void *user, const void *data, size_t size) {
    description *d = user;
    size_t message_count = d->message_count;
    snell_status status = records_read(data, size, d);
    for (size_t i = message_count; i < d->message_count; i++) {
        clean_text(d->messages[i].text);
        clean_text(d->messages[i].hint);
        clean_text(d->messages[i].file);
    }
    return status;
}

snell_status helper_import(const char *path, const helper_options *options, description *d) {
    return helper_run(path, options, take_records, d);
}
