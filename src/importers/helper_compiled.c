/* Compiled scenes (scene/compiled.h), which hold one frame. They are no more than the records that
 * snell-import sends, so that the host's process reads them itself, checking them in the same way. */
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "importers/importer.h"
#include "scene/compiled.h"
#include "scene/settings.h"

/* Has an object of that category keys of its own? */
static bool has_keys(const object_list *list) {
    for (size_t i = 0; i < list->count; i++)
        for (uint32_t k = 0; k < list->items[i].type->field_count; k++) {
            const field *f = &list->items[i].type->fields[k];
            if (f->kind != FIELD_KEYS && strcmp(f->name, "key_times") != 0) continue;
            size_t count;
            const char *member = (const char *)list->items[i].desc + f->offset;
            memcpy(&count, member + sizeof(void *), sizeof count);
            if (count) return true;
        }
    return false;
}

static bool moves(const description *d) {
    for (size_t i = 0; i < d->instance_count; i++)
        if (d->instances[i].key_count) return true;
    return has_keys(&d->objects[CATEGORY_SHAPE]) || has_keys(&d->objects[CATEGORY_CAMERA]);
}

/* What was decided when it was written cannot be asked for now. */
static snell_status check_options(const char *path, const import_options *o, const description *d) {
    source_place place = {path, 0, 0};
    if (o->within) return SNELL_OK;
    if (o->param_count)
        return error_set_at(SNELL_ERR_ARGUMENT, place, "give -D to snell convert",
                            "-D %.60s: a compiled scene takes no values", o->params[0]);
    if (o->up)
        return error_set_at(SNELL_ERR_ARGUMENT, place, "give --up to snell convert",
                            "--up: which way is up was decided when the scene was compiled");
    const object *clock = description_setting(d, "animation");
    int32_t frame = clock ? ((const animation_desc *)clock->desc)->frame : 0;
    if (o->frame && clock && o->frame != (uint32_t)frame)
        return error_set_at(SNELL_ERR_ARGUMENT, place, "give --frame to snell convert",
                            "frame %u: the compiled scene is of frame %d alone", o->frame, frame);
    if (o->next_frame && !d->has_next_frame && moves(d))
        return error_set_at(SNELL_ERR_UNSUPPORTED, place,
                            "render the file that it was made of, or give that a camera first",
                            "motion vectors need the next frame, which is not in the scene");
    return SNELL_OK;
}

bool compiled_is_file(const char *path) {
    void *first = NULL;
    size_t size = 0;
    if (file_read_start(path, 8, &first, &size)) return false;
    bool is = compiled_recognise(first, size);
    free(first);
    return is;
}

/* Not mapped: the records are looked at more than once, and must not change meanwhile. */
snell_status compiled_import(const char *path, const import_options *options, description *d) {
    size_t size = 0, most = options->memory_max ? (size_t)(options->memory_max / 2) : SIZE_MAX;
    void *data = NULL;
    snell_status status = file_read_start(path, most, &data, &size);
    if (status) return status;
    if (size == most) {
        free(data);
        return error_set_at(SNELL_ERR_MEMORY, (source_place){path, 0, 0},
                            "allow more memory (--memory)",
                            "the compiled scene is larger than %zu MiB", most >> 20);
    }
    description_mark mark = description_get_mark(d);
    status = compiled_read(path, data, size, d);
    free(data);
    if (!status) status = check_options(path, options, d);
    if (status) description_rewind(d, &mark);
    return status;
}
