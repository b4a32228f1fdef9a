#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { LINKS_MAX = 40, NAMES_TRIED = 1000 };

typedef struct reason {
    int number;
    const char *text, *hint;
} reason;

static const reason reasons[] = {
    {ENOSPC, "no space left", "free some space, or write to another disk"},
    {EDQUOT, "no space left in your quota", "free some space, or write to another disk"},
    {EFBIG, "the file is larger than is allowed here", "see 'ulimit -f', or choose a smaller one"},
    {EACCES, "permission denied", "choose a place that you may write to"},
    {EPERM, "permission denied", "choose a place that you may write to"},
    {EROFS, "the disk is read-only", "choose a place that you may write to"},
    {ENOENT, "there is no such folder", "make the folder first"},
    {ENOTDIR, "a part of the path is no folder", NULL},
    {EISDIR, "it is a folder", "give a file name"},
    {ENAMETOOLONG, "the name is too long", NULL},
    {ELOOP, "too many symbolic links", NULL},
};

static snell_status write_error(const char *path, int number) {
    source_place place = {.file = path};
    for (size_t i = 0; i < sizeof reasons / sizeof reasons[0]; i++)
        if (reasons[i].number == number)
            return error_set_at(SNELL_ERR_IO, place, reasons[i].hint, "cannot write: %s",
                                reasons[i].text);
    char text[128];
    return error_set_at(SNELL_ERR_IO, place, NULL, "cannot write: %s",
                        strerror_r(number, text, sizeof text));
}

/* Follows symbolic links, also one that points to nothing yet, into `out`; 0 or an errno. */
static int follow_links(const char *path, char out[PATH_MAX]) {
    if (strlen(path) >= PATH_MAX) return ENAMETOOLONG;
    strcpy(out, path);
    for (int i = 0; i < LINKS_MAX; i++) {
        char target[PATH_MAX];
        ssize_t length = readlink(out, target, sizeof target - 1);
        if (length < 0) return errno == EINVAL || errno == ENOENT ? 0 : errno;
        target[length] = '\0';
        char *slash = strrchr(out, '/');
        size_t folder = target[0] == '/' || slash == NULL ? 0 : (size_t)(slash - out) + 1;
        if (folder + (size_t)length >= PATH_MAX) return ENAMETOOLONG;
        memcpy(out + folder, target, (size_t)length + 1);
    }
    return ELOOP;
}

static int write_all(int file, const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        size_t part = size < (size_t)1 << 30 ? size : (size_t)1 << 30;
        ssize_t written = write(file, at, part);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        if (written == 0) return ENOSPC;
        at += written;
        size -= (size_t)written;
    }
    return 0;
}

static int write_directly(const char *path, const void *data, size_t size) {
    int file = open(path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (file < 0) return errno;
    int failed = write_all(file, data, size);
    if (close(file) != 0 && !failed) failed = errno;
    return failed;
}

/* Some file systems and devices cannot fsync; that is no failure to write. */
static int sync_file(int file) {
    if (fsync(file) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS) return 0;
    return errno;
}

/* A new file beside `path`; its name goes to `name`. Returns the descriptor, or -1 with errno. */
static int create_beside(const char *path, char name[PATH_MAX]) {
    static atomic_uint counter;
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash - path) + 1 : 0;
    for (int i = 0; i < NAMES_TRIED; i++) {
        unsigned number = atomic_fetch_add(&counter, 1);
        int length =
            snprintf(name, PATH_MAX, "%.*s.snell-%ld-%u.tmp", folder, path, (long)getpid(), number);
        if (length < 0 || length >= PATH_MAX) {
            errno = ENAMETOOLONG;
            return -1;
        }
        int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (file >= 0 || errno != EEXIST) return file;
    }
    return -1;
}

static void sync_folder_of(const char *path) {
    char folder[PATH_MAX] = ".";
    const char *slash = strrchr(path, '/');
    if (slash) snprintf(folder, sizeof folder, "%.*s", (int)(slash - path) + 1, path);
    int file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return; /* a folder may be writable and not readable: the rename still holds */
    (void)sync_file(file);
    close(file);
}

/* What a path leads to, and what is there. */
typedef struct target {
    char path[PATH_MAX];
    struct stat old;
    bool exists;
} target;

static int find_target(const char *path, target *out) {
    int failed = follow_links(path, out->path);
    out->exists = !failed && stat(out->path, &out->old) == 0;
    return failed == 0 && out->exists && S_ISDIR(out->old.st_mode) ? EISDIR : failed;
}

static bool is_special(const target *t) { return t->exists && !S_ISREG(t->old.st_mode); }

/* Closes the file `name` and puts it in the target's place; it is removed if that fails. */
static int replace(const target *t, int file, const char *name, int failed) {
    if (!failed && t->exists) {
        (void)!fchown(file, t->old.st_uid, t->old.st_gid); /* root alone may give files away */
        if (fchmod(file, t->old.st_mode & 0777) != 0) failed = errno;
    }
    if (!failed) failed = sync_file(file);
    if (close(file) != 0 && !failed) failed = errno;
    if (!failed && rename(name, t->path) != 0) failed = errno;
    if (failed)
        unlink(name);
    else
        sync_folder_of(t->path);
    return failed;
}

static int write_new(const target *t, const void *data, size_t size) {
    char name[PATH_MAX];
    if (t->exists && access(t->path, W_OK) != 0) return errno;
    int file = create_beside(t->path, name);
    if (file < 0) return errno;
    return replace(t, file, name, write_all(file, data, size));
}

snell_status file_write_atomic(const char *path, const void *data, size_t size) {
    target t;
    int failed = find_target(path, &t);
    if (!failed)
        failed = is_special(&t) ? write_directly(t.path, data, size) : write_new(&t, data, size);
    return failed ? write_error(path, failed) : SNELL_OK;
}

/* ---- in parts ---- */

struct file_writer {
    char *path;          /* as given, for messages and the end */
    char name[PATH_MAX]; /* of the temporary; "" where it is written to directly */
    int file;
};

static int begin(file_writer *w) {
    target t;
    int failed = find_target(w->path, &t);
    if (failed) return failed;
    if (t.exists && access(t.path, W_OK) != 0) return errno;
    w->file = is_special(&t) ? open(t.path, O_WRONLY | O_CLOEXEC | O_NOCTTY)
                             : create_beside(t.path, w->name);
    if (is_special(&t)) w->name[0] = '\0';
    return w->file < 0 ? errno : 0;
}

snell_status file_begin(const char *path, file_writer **out) {
    file_writer *w = calloc(1, sizeof *w);
    if (w) w->path = strdup(path);
    if (w == NULL || w->path == NULL) {
        free(w);
        return error_no_memory();
    }
    int failed = begin(w);
    if (failed) {
        free(w->path);
        free(w);
        return write_error(path, failed);
    }
    *out = w;
    return SNELL_OK;
}

snell_status file_append(file_writer *w, const void *data, size_t size) {
    int failed = write_all(w->file, data, size);
    return failed ? write_error(w->path, failed) : SNELL_OK;
}

snell_status file_patch(file_writer *w, uint64_t offset, const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        ssize_t written = pwrite(w->file, at, size, (off_t)offset);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return write_error(w->path, written < 0 ? errno : ENOSPC);
        at += written;
        offset += (uint64_t)written;
        size -= (size_t)written;
    }
    return SNELL_OK;
}

snell_status file_finish(file_writer *w, const char *path) {
    target t;
    int failed = find_target(path ? path : w->path, &t);
    if (w->name[0])
        failed = replace(&t, w->file, w->name, is_special(&t) ? EEXIST : failed);
    else
        failed = close(w->file) != 0 ? errno : 0;
    snell_status status = failed ? write_error(path ? path : w->path, failed) : SNELL_OK;
    free(w->path);
    free(w);
    return status;
}

void file_abandon(file_writer *w) {
    if (w == NULL) return;
    close(w->file);
    if (w->name[0]) unlink(w->name);
    free(w->path);
    free(w);
}

/* ---- reading ---- */

static snell_status read_error(const char *path, int number) {
    source_place place = {.file = path};
    char text[128];
    if (number == ENOENT)
        return error_set_at(SNELL_ERR_IO, place, "is the name right?", "there is no such file");
    return error_set_at(SNELL_ERR_IO, place, NULL, "cannot read: %s",
                        strerror_r(number, text, sizeof text));
}

static int read_all(int file, char *data, size_t *size) {
    size_t done = 0;
    while (done < *size) {
        ssize_t got = read(file, data + done, *size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return errno;
        if (got == 0) break;
        done += (size_t)got;
    }
    *size = done;
    return 0;
}

snell_status file_read_start(const char *path, size_t size_max, void **data, size_t *size) {
    /* O_NONBLOCK: opening a pipe that nobody writes to must not wait for ever. */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file < 0) return read_error(path, errno);
    struct stat about;
    int failed = fstat(file, &about) != 0 ? errno : 0;
    if (!failed && !S_ISREG(about.st_mode)) failed = S_ISDIR(about.st_mode) ? EISDIR : EINVAL;
    char *buffer = NULL;
    size_t wanted = size_max;
    if (!failed) {
        if ((uint64_t)about.st_size < wanted) wanted = (size_t)about.st_size;
        buffer = malloc(wanted ? wanted : 1);
        failed = buffer ? read_all(file, buffer, &wanted) : ENOMEM;
    }
    close(file);
    if (failed) {
        free(buffer);
        return failed == ENOMEM ? error_no_memory() : read_error(path, failed);
    }
    *data = buffer;
    *size = wanted;
    return SNELL_OK;
}
