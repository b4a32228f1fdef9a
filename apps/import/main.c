/* snell-import: reads one file in a sandbox and hands back a scene block. Started by the library
 * only; see src/importers/helper.c for the whole picture and protocol.h for what is said. */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/thread.h"
#include "importers/importer.h"
#include "importers/picture.h"
#include "importers/protocol.h"
#include "sandbox.h"
#include "scene/records.h"

typedef struct request {
    const char *file, *format;
    import_options import;
    uint64_t time_max;
    const char **params, **allow;
} request;

static bool write_all(int fd, const void *data, size_t size) {
    const char *at = data;
    while (size > 0) {
        ssize_t done = write(fd, at, size);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) return false;
        at += done;
        size -= (size_t)done;
    }
    return true;
}

static void say(const protocol_record *record) {
    write_all(PROTOCOL_PIPE_FD, record, sizeof *record);
}

static int say_error(void) {
    const snell_message *error = error_last();
    protocol_record record = {.kind = PROTOCOL_ERROR,
                              .status = error->status,
                              .line = error->line,
                              .column = error->column};
    snprintf(record.text, sizeof record.text, "%s", error->text);
    snprintf(record.hint, sizeof record.hint, "%s", error->hint);
    snprintf(record.file, sizeof record.file, "%s", error->file);
    say(&record);
    return 1;
}

/* At most one record each 20 ms, however often an importer calls. */
static void say_progress(void *user, double fraction) {
    double *last = user, now = time_seconds();
    if (now - *last < 0.02) return;
    *last = now;
    say(&(protocol_record){.kind = PROTOCOL_PROGRESS, .fraction = fraction});
}

static bool parse(int count, char **arguments, request *out) {
    out->params = memory_zeroed((size_t)count, sizeof *out->params);
    out->allow = memory_zeroed((size_t)count, sizeof *out->allow);
    if (!out->params || !out->allow) return false;
    for (int i = 1; i + 1 < count; i += 2) {
        const char *name = arguments[i], *value = arguments[i + 1];
        if (strcmp(name, PROTOCOL_FILE) == 0) out->file = value;
        if (strcmp(name, PROTOCOL_FORMAT) == 0) out->format = value;
        if (strcmp(name, PROTOCOL_UP) == 0) out->import.up = value;
        if (strcmp(name, PROTOCOL_LAYER) == 0) out->import.layer = value;
        if (strcmp(name, PROTOCOL_PROGRAMS) == 0) out->import.allow_programs = value[0] == '1';
        if (strcmp(name, PROTOCOL_NEXT) == 0) out->import.next_frame = value[0] == '1';
        if (strcmp(name, PROTOCOL_FRAME) == 0)
            out->import.frame = (uint32_t)strtoul(value, NULL, 10);
        if (strcmp(name, PROTOCOL_MEMORY) == 0) out->import.memory_max = strtoull(value, NULL, 10);
        if (strcmp(name, PROTOCOL_TIME) == 0) out->time_max = strtoull(value, NULL, 10);
        if (strcmp(name, PROTOCOL_PARAM) == 0) out->params[out->import.param_count++] = value;
        if (strcmp(name, PROTOCOL_ALLOW) == 0) out->allow[out->import.asset_dir_count++] = value;
    }
    out->import.params = out->params;
    out->import.asset_dirs = out->allow;
    return out->file != NULL;
}

/* ---- the result goes through a buffer: records are made of small pieces ---- */

enum { BUFFER_SIZE = 1 << 16 };
typedef struct buffer {
    char bytes[BUFFER_SIZE];
    size_t used;
} buffer;

static bool flush(buffer *b) {
    size_t used = b->used;
    b->used = 0;
    return write_all(PROTOCOL_RESULT_FD, b->bytes, used);
}

static bool write_result(void *user, const void *data, size_t size) {
    buffer *b = user;
    if (size > BUFFER_SIZE - b->used && !flush(b)) return false;
    if (size >= BUFFER_SIZE) return write_all(PROTOCOL_RESULT_FD, data, size);
    memcpy(b->bytes + b->used, data, size);
    b->used += size;
    return true;
}

static buffer result;

static int end_result(snell_status written) {
    if (written == SNELL_OK && !flush(&result)) written = SNELL_ERR_IO;
    if (written == SNELL_ERR_IO) /* the memory file is as large as it may be */
        written = error_set(SNELL_ERR_MEMORY, NULL, "the result needs more memory than it may use");
    if (written) return say_error();
    say(&(protocol_record){.kind = PROTOCOL_DONE});
    return 0;
}

static int read_scene(request *asked, const char *missing) {
    description *d;
    if (description_create(&d)) return say_error();
    if (missing[0])
        description_add_message(d, SNELL_INFO, NULL, 0, NULL,
                                "files are read without %s, which this machine lacks", missing);
    double last = time_seconds();
    asked->import.progress = say_progress;
    asked->import.progress_user = &last;
    if (import_file(asked->file, asked->format, &asked->import, d)) return say_error();
    d->has_next_frame |= asked->import.next_frame;
    return end_result(records_write(d, write_result, &result));
}

static int read_picture(const request *asked) {
    picture p;
    if (picture_import(asked->file, &asked->import, &p)) return say_error();
    return end_result(picture_write(&p, write_result, &result));
}

static int run(request *asked) {
    sandbox_options walls = {.file = asked->file,
                             .allow = asked->allow,
                             .allow_count = asked->import.asset_dir_count,
                             .memory_max = asked->import.memory_max,
                             .time_max = asked->time_max};
    const char *missing = sandbox_enter(&walls);
    return asked->import.layer ? read_picture(asked) : read_scene(asked, missing);
}

int main(int count, char **arguments) {
    struct pollfd parent = {PROTOCOL_PIPE_FD, POLLOUT, 0};
    request asked = {0};
    if (poll(&parent, 1, 0) < 0 || (parent.revents & POLLNVAL) ||
        !parse(count, arguments, &asked)) {
        fputs("snell-import reads files for the snell library, which starts it\n", stderr);
        return 2;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (poll(&parent, 1, 0) == 1 && (parent.revents & POLLERR)) return 1; /* it died before that */
    /* Whatever the host left open is not for importers. */
    close_range(PROTOCOL_PIPE_FD + 1, ~0u, 0);
    int code = run(&asked);
    _exit(code); /* tearing everything down would only take time */
}
