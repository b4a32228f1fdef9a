/* Which importer reads a file. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "importers/files.h"

#define IMPORTER(name) extern const importer importer_##name;
#include "importers/importers.def"
#undef IMPORTER
const importer *const importers[] = {
#define IMPORTER(name) &importer_##name,
#include "importers/importers.def"
#undef IMPORTER
    NULL,
};

enum { FIRST_SIZE = 4096 };

/* The file's first bytes; fewer when it is shorter. */
static snell_status read_first(const char *path, uint8_t first[FIRST_SIZE], size_t *size) {
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) return error_set(SNELL_ERR_IO, NULL, "cannot open '%s': %s", path, strerror(errno));
    *size = 0;
    ssize_t got;
    while (*size < FIRST_SIZE && (got = read(fd, first + *size, FIRST_SIZE - *size)) != 0) {
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            int error = errno;
            close(fd);
            return error_set(SNELL_ERR_IO, NULL, "cannot read '%s': %s", path, strerror(error));
        }
        *size += (size_t)got;
    }
    close(fd);
    return SNELL_OK;
}

/* By name, or one of its extensions without the dot: the format ply means whoever reads .ply. */
static bool answers_to(const importer *reader, const char *format) {
    if (strcmp(reader->name, format) == 0) return true;
    size_t length = strlen(format);
    for (const char *at = reader->extensions; at && *at; at += strspn(at, " ")) {
        size_t here = strcspn(at, " ");
        if (here == length + 1 && at[0] == '.' && memcmp(at + 1, format, length) == 0) return true;
        at += here;
    }
    return false;
}

static snell_status unknown_format(const char *format) {
    char hint[512] = "there are ";
    for (size_t i = 0; importers[i]; i++) {
        size_t used = strlen(hint);
        snprintf(hint + used, sizeof hint - used, "%s%s", i ? ", " : "", importers[i]->name);
    }
    return error_set(SNELL_ERR_UNSUPPORTED, hint, "unknown file format '%s'", format);
}

static bool begins(const uint8_t *first, size_t size, const char *mark) {
    size_t length = strlen(mark);
    return size >= length && memcmp(first, mark, length) == 0;
}

/* PNG, JPEG, WebP, OpenEXR, PFM and PPM by their first bytes. */
static bool is_picture(const uint8_t *first, size_t size) {
    static const char *const marks[] = {"\x89PNG\r\n", "\xff\xd8\xff", "v/1\x01", "PF\n",
                                        "Pf\n",        "P6\n",         "P3\n"};
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++)
        if (begins(first, size, marks[i])) return true;
    return size >= 12 && begins(first, size, "RIFF") && memcmp(first + 8, "WEBP", 4) == 0;
}

static snell_status unknown_content(const char *path, const uint8_t *first, size_t size) {
    source_place place = {path, 0, 0};
    if (begins(first, size, "#?R"))
        return error_set_at(SNELL_ERR_UNSUPPORTED, place,
                            "'snell help environment' says how it lights a scene; 'snell convert' "
                            "makes a .png of it",
                            "this is a Radiance HDR picture, not a model or a scene");
    if (is_picture(first, size))
        return error_set_at(SNELL_ERR_UNSUPPORTED, place, "'snell info FILE' says how it was made",
                            "this is a picture, not a model or a scene");
    return error_set_at(SNELL_ERR_UNSUPPORTED, place,
                        "name its format with --input-format, if snell reads it",
                        "no reader knows this kind of file");
}

snell_status import_file(const char *path, const char *format, const import_options *options,
                         description *d) {
    import_options chosen = *options;
    chosen.format = format;
    if (format) {
        for (size_t i = 0; importers[i]; i++)
            if (answers_to(importers[i], format)) return importers[i]->read(path, &chosen, d);
        return unknown_format(format);
    }
    uint8_t first[FIRST_SIZE];
    size_t size = 0;
    snell_status status = read_first(path, first, &size);
    if (status) return status;
    char extension[16];
    import_extension(path, extension, sizeof extension);
    size_t mark = import_mark_size(first, size);
    for (size_t i = 0; importers[i]; i++)
        if (importers[i]->recognise(extension, first + mark, size - mark))
            return importers[i]->read(path, &chosen, d);
    return unknown_content(path, first, size);
}
