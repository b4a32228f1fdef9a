#include "scene/compiled.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "sampling/sampling.h"
#include "scene/records.h"

enum { HEADER_VERSION = 1, BYTE_ORDER_MARK = 0x01020304, BUFFER_SIZE = 1 << 16 };

static const unsigned char magic[8] = {0x89, 'S', 'N', 'L', '\r', '\n', 0x1a, '\n'};

typedef struct file_header {
    unsigned char magic[8];
    uint32_t byte_order, version;
    uint64_t size, checksum;
    char writer[32], source[64];
} file_header;
_Static_assert(sizeof(file_header) == COMPILED_HEADER_SIZE, "no padding");

/* Of whole words: a record's size is a multiple of 8. Lengths differ by the start. */
static uint64_t add_to_checksum(uint64_t sum, const void *data, size_t size) {
    const char *bytes = data;
    for (size_t at = 0; at + 8 <= size; at += 8) {
        uint64_t word;
        memcpy(&word, bytes + at, sizeof word);
        sum = hash_mix(sum ^ word) + 1;
    }
    return sum;
}

/* ---- writing: once to know size and checksum, once into the file ---- */

typedef struct output {
    char *buffer;
    size_t used;
    uint64_t size, checksum;
    file_writer *file; /* NULL: only measured */
    snell_status status;
    const char *path;
    char text[256], hint[256]; /* of the error: records_write only knows that there was one */
} output;

static bool flush(output *o) {
    if (o->file)
        o->status = file_append(o->file, o->buffer, o->used);
    else
        o->checksum = add_to_checksum(o->checksum, o->buffer, o->used);
    o->size += o->used;
    o->used = 0;
    if (o->status == SNELL_OK) return true;
    snprintf(o->text, sizeof o->text, "%s", error_last()->text);
    snprintf(o->hint, sizeof o->hint, "%s", error_last()->hint);
    return false;
}

static bool take(void *user, const void *data, size_t size) {
    output *o = user;
    const char *from = data;
    while (size > 0) {
        size_t part = size < BUFFER_SIZE - o->used ? size : BUFFER_SIZE - o->used;
        memcpy(o->buffer + o->used, from, part);
        o->used += part;
        from += part;
        size -= part;
        if (o->used == BUFFER_SIZE && !flush(o)) return false;
    }
    return true;
}

static snell_status put_records(output *o, const description *d) {
    snell_status status = records_write(d, take, o);
    if (o->status == SNELL_OK && status == SNELL_OK) flush(o);
    if (o->status == SNELL_OK) return status;
    return error_set_at(o->status, (source_place){o->path, 0, 0}, o->hint, "%s", o->text);
}

/* The last name of the first file that is named in the description. */
static void find_source(const description *d, char *out, size_t size) {
    for (int c = CATEGORY_COUNT - 1; c >= 0; c--)
        for (size_t i = 0; i < d->objects[c].count; i++) {
            const char *file = d->objects[c].items[i].file, *slash = strrchr(file, '/');
            if (file[0] == '\0') continue;
            snprintf(out, size, "%s", slash ? slash + 1 : file);
            return;
        }
}

static snell_status write_file(const description *d, output *o, const char *path) {
    file_header header = {
        .byte_order = BYTE_ORDER_MARK, .version = HEADER_VERSION, .writer = SNELL_VERSION_STRING};
    memcpy(header.magic, magic, sizeof magic);
    find_source(d, header.source, sizeof header.source);
    snell_status status = put_records(o, d);
    if (status) return status;
    header.size = o->size;
    header.checksum = o->checksum;
    status = file_begin(path, &o->file);
    if (!status) status = file_append(o->file, &header, sizeof header);
    if (!status) status = put_records(o, d);
    if (!status) return file_finish(o->file, NULL);
    if (o->file) file_abandon(o->file);
    return status;
}

/* What is said of no file is of the machine that read it. The list is freed by the caller; its texts are the
 * description's. */
static import_message *messages_of_files(const description *d, size_t *count) {
    import_message *list = memory_resize(NULL, d->message_count, sizeof *list);
    *count = 0;
    for (size_t i = 0; list && i < d->message_count; i++)
        if (d->messages[i].file[0]) list[(*count)++] = d->messages[i];
    return list;
}

snell_status compiled_write(const description *d, const char *path) {
    description final = *d; /* the same objects */
    snprintf(final.format, sizeof final.format, "snell");
    final.is_settled = true;
    final.param_count = 0;
    output o = {.buffer = memory_resize(NULL, BUFFER_SIZE, 1), .path = path};
    final.messages = messages_of_files(d, &final.message_count);
    snell_status status =
        o.buffer && final.messages ? write_file(&final, &o, path) : error_no_memory();
    free(final.messages);
    free(o.buffer);
    return status;
}

/* ---- reading ---- */

bool compiled_recognise(const void *first, size_t size) {
    return size >= sizeof magic && memcmp(first, magic, sizeof magic) == 0;
}

/* Text of the file, which may hold anything, as messages show it. */
static void copy_text(char *out, const char *text, size_t size) {
    for (size_t i = 0; i < size; i++)
        out[i] = text[i] != 0 && (text[i] < ' ' || text[i] == 0x7f) ? '?' : text[i];
    out[size - 1] = '\0';
}

static snell_status fail(const char *path, const file_header *header, snell_status status,
                         const char *what) {
    char source[sizeof header->source], hint[256];
    copy_text(source, header->source, sizeof source);
    snprintf(hint, sizeof hint, "write it again: snell convert %s %.120s",
             source[0] ? source : "SCENE", path);
    return error_set_at(status, (source_place){path, 0, 0}, hint, "%s", what);
}

static snell_status check_header(const char *path, const file_header *h, const void *data,
                                 size_t size) {
    char what[160], writer[sizeof h->writer];
    copy_text(writer, h->writer, sizeof writer);
    if (h->byte_order != BYTE_ORDER_MARK)
        return fail(path, h, SNELL_ERR_UNSUPPORTED,
                    "a compiled scene of a machine with another byte order");
    size_t there = size - sizeof *h;
    snprintf(what, sizeof what, "the compiled scene is %s: %zu bytes, not %llu",
             there < h->size ? "cut short" : "too long", size,
             (unsigned long long)h->size + sizeof *h);
    if (h->version == HEADER_VERSION && there != h->size)
        return fail(path, h, SNELL_ERR_SYNTAX, what);
    if (h->version == HEADER_VERSION && add_to_checksum(0, data, there) != h->checksum)
        return fail(path, h, SNELL_ERR_SYNTAX,
                    "the compiled scene is damaged: its checksum is wrong");
    snprintf(what, sizeof what, "a compiled scene made by snell %s; this is %s%s", writer,
             SNELL_VERSION_STRING,
             strcmp(writer, SNELL_VERSION_STRING) == 0 ? " of another build" : "");
    if (h->version != HEADER_VERSION || !records_fit(data, there))
        return fail(path, h, SNELL_ERR_UNSUPPORTED, what);
    return SNELL_OK;
}

snell_status compiled_read(const char *path, const void *data, size_t size, description *d) {
    file_header header;
    if (!compiled_recognise(data, size))
        return error_set_at(SNELL_ERR_SYNTAX, (source_place){path, 0, 0},
                            "'snell convert SCENE OUT.snell' writes one",
                            "not a compiled scene: it does not begin as one");
    memset(&header, 0, sizeof header);
    memcpy(&header, data, size < sizeof header ? size : sizeof header);
    if (size < sizeof header) {
        memset(header.source, 0, sizeof header.source);
        return fail(path, &header, SNELL_ERR_SYNTAX, "the compiled scene is cut short");
    }
    const char *records = (const char *)data + sizeof header;
    snell_status status = check_header(path, &header, records, size);
    if (status) return status;
    status = records_read(records, size - sizeof header, d);
    if (status) error_place((source_place){path, 0, 0});
    return status;
}
