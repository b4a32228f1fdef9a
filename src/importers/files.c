#include "importers/files.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

static const char outside_hint[] =
    "files outside the scene's folder are not read; allow their folder with --allow DIR";

static snell_status cannot_open(const char *name, int error) {
    const char *hint = error == EACCES || error == EPERM ? outside_hint : NULL;
    return error_set(SNELL_ERR_IO, hint, "cannot open '%s': %s", name, strerror(error));
}

/* Is `path` (real, absolute) in `folder` (any spelling) or below? */
static bool is_inside(const char *path, const char *folder) {
    char root[PATH_MAX];
    if (realpath(folder, root) == NULL) return false;
    size_t length = strlen(root);
    if (length == 1) return true; /* "/" */
    return strncmp(path, root, length) == 0 && (path[length] == '/' || path[length] == '\0');
}

static bool is_allowed(const char *path, const char *base_folder, const import_options *options) {
    if (is_inside(path, base_folder)) return true;
    for (size_t i = 0; i < options->asset_dir_count; i++)
        if (is_inside(path, options->asset_dirs[i])) return true;
    return false;
}

/* Does the name climb out of the folder that it starts in? Decided on the text alone, for files
 * that do not exist: whether they do is nothing that a scene may find out. */
static bool climbs_out(const char *name) {
    int depth = 0;
    while (*name) {
        size_t length = strcspn(name, "/");
        if (length == 2 && name[0] == '.' && name[1] == '.')
            depth--;
        else if (length > 0 && !(length == 1 && name[0] == '.'))
            depth++;
        if (depth < 0) return true;
        name += length;
        name += strspn(name, "/");
    }
    return false;
}

/* Tries folder/name (name alone when absolute): 0 and *path when it is there and may be read, else
 * an errno. */
static int try_folder(const char *folder, const char *base_folder, const char *name,
                      const import_options *options, char **path) {
    char joined[PATH_MAX], real[PATH_MAX];
    bool absolute = name[0] == '/';
    int length = absolute ? snprintf(joined, sizeof joined, "%s", name)
                          : snprintf(joined, sizeof joined, "%s/%s", folder, name);
    if (length < 0 || (size_t)length >= sizeof joined) return ENAMETOOLONG;
    if (realpath(joined, real) == NULL) {
        bool hidden = errno == ENOENT && (absolute || climbs_out(name));
        return hidden ? EACCES : errno;
    }
    if (!is_allowed(real, base_folder, options)) return EACCES;
    *path = memory_copy_string(joined);
    return *path ? 0 : ENOMEM;
}

snell_status import_resolve(const char *base_file, const char *name, const import_options *options,
                            char **path) {
    char base_folder[PATH_MAX] = ".";
    const char *slash = strrchr(base_file, '/');
    if (slash) {
        size_t length = slash == base_file ? 1 : (size_t)(slash - base_file);
        if (length >= sizeof base_folder) return cannot_open(base_file, ENAMETOOLONG);
        memcpy(base_folder, base_file, length);
        base_folder[length] = '\0';
    }
    int error = name[0] ? try_folder(base_folder, base_folder, name, options, path) : ENOENT;
    for (size_t i = 0; i < options->asset_dir_count && error && name[0] && name[0] != '/'; i++) {
        int other = try_folder(options->asset_dirs[i], base_folder, name, options, path);
        if (other == 0) error = 0;
    }
    if (error == ENOMEM) return error_no_memory();
    return error ? cannot_open(name, error) : SNELL_OK;
}

static snell_status read_all(int fd, const char *name, size_t size, uint8_t **data) {
    uint8_t *bytes = memory_resize(NULL, size + 1, 1);
    if (bytes == NULL) return error_no_memory();
    size_t done = 0;
    while (done < size) {
        ssize_t got = read(fd, bytes + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) {
            int error = got < 0 ? errno : EIO; /* it shrank meanwhile */
            free(bytes);
            return error_set(SNELL_ERR_IO, NULL, "cannot read '%s': %s", name, strerror(error));
        }
        done += (size_t)got;
    }
    bytes[size] = 0;
    *data = bytes;
    return SNELL_OK;
}

/* An open file that may be read whole. */
static snell_status open_whole(const char *path, const char *name, const import_options *options,
                               int *fd, size_t *size) {
    /* O_NONBLOCK: a pipe with no writer must not hold us up. */
    *fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (*fd < 0) return cannot_open(name, errno);
    uint64_t size_max = (uint64_t)4 << 30;
    if (options->memory_max && options->memory_max / 2 < size_max)
        size_max = options->memory_max / 2;
    struct stat status;
    snell_status result = SNELL_OK;
    if (fstat(*fd, &status) != 0)
        result = cannot_open(name, errno);
    else if (S_ISDIR(status.st_mode))
        result = cannot_open(name, EISDIR);
    else if (!S_ISREG(status.st_mode))
        result = error_set(SNELL_ERR_IO, NULL, "cannot read '%s': not a regular file", name);
    else if ((uint64_t)status.st_size > size_max)
        result = error_set(SNELL_ERR_MEMORY, "allow more memory for reading (--memory)",
                           "'%s' has %lld bytes; at most %llu are read", name,
                           (long long)status.st_size, (unsigned long long)size_max);
    if (result == SNELL_OK)
        *size = (size_t)status.st_size;
    else
        close(*fd);
    return result;
}

snell_status import_read_file(const char *path, const char *name, const import_options *options,
                              uint8_t **data, size_t *size) {
    if (name == NULL) name = path;
    int fd;
    size_t bytes = 0;
    snell_status result = open_whole(path, name, options, &fd, &bytes);
    if (result) return result;
    result = read_all(fd, name, bytes, data);
    if (result == SNELL_OK) *size = bytes;
    close(fd);
    return result;
}

static bool can_be_mapped(size_t size) { return size % (size_t)sysconf(_SC_PAGESIZE) != 0; }

snell_status import_map_file(const char *path, const import_options *options, const char **data,
                             size_t *size) {
    int fd;
    snell_status result = open_whole(path, path, options, &fd, size);
    if (result) return result;
    if (can_be_mapped(*size)) {
        void *mapped = mmap(NULL, *size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (mapped == MAP_FAILED)
            result = error_no_memory();
        else
            *data = mapped;
    } else {
        uint8_t *bytes;
        result = read_all(fd, path, *size, &bytes);
        if (result == SNELL_OK) *data = (const char *)bytes;
    }
    close(fd);
    return result;
}

void import_unmap_file(const char *data, size_t size) {
    void *start = (void *)(uintptr_t)data;
    if (can_be_mapped(size))
        munmap(start, size);
    else
        free(start);
}

snell_status import_read_beside(const char *base_file, const char *name,
                                const import_options *options, uint8_t **data, size_t *size) {
    char *path = NULL;
    snell_status status = import_resolve(base_file, name, options, &path);
    if (status) return status;
    status = import_read_file(path, name, options, data, size);
    free(path);
    return status;
}

void import_forget(const char *data, size_t size, const char *upto) {
    size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (size_t)(upto - data) & ~(page - 1);
    if (can_be_mapped(size) && whole) madvise((void *)(uintptr_t)data, whole, MADV_DONTNEED);
}

void import_extension(const char *path, char *out, size_t size) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    out[0] = '\0';
    if (dot == NULL || dot == name || strlen(dot) >= size) return;
    size_t i = 0;
    for (; dot[i]; i++)
        out[i] = dot[i] >= 'A' && dot[i] <= 'Z' ? (char)(dot[i] - 'A' + 'a') : dot[i];
    out[i] = '\0';
}
