#include "batch.h"

#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "output.h"
#include "report.h"

static bool is_folder(const char *path) {
    struct stat info;
    return strcmp(path, "-") != 0 && stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

static bool is_model(const char *name) {
    const char *dot = strrchr(name, '.'), *known;
    for (uint32_t i = 0; dot != NULL && (known = snell_formats(i, NULL)) != NULL; i++)
        if (strcasecmp(dot, known) == 0) return true;
    return false;
}

static int no_memory(void) { return report_error(EXIT_MEMORY, NULL, "out of memory"); }

static int append(batch *b, const char *path, char *owned) {
    string_list *list = &b->options.operands;
    const char **items = realloc(list->items, (list->count + 1) * sizeof *items);
    if (items != NULL) list->items = items;
    char **kept = owned == NULL ? b->owned : realloc(b->owned, (b->owned_count + 1) * sizeof *kept);
    if (kept != NULL) b->owned = kept;
    if (items == NULL || (owned != NULL && kept == NULL)) {
        free(owned);
        return no_memory();
    }
    if (owned != NULL) b->owned[b->owned_count++] = owned;
    list->items[list->count++] = path;
    return EXIT_DONE;
}

/* An entry of a folder: a model is taken, another file counted. */
static int take_entry(batch *b, const char *folder, const char *name) {
    size_t length = strlen(folder), size = length + strlen(name) + 2;
    char *path = malloc(size);
    struct stat info;
    if (path == NULL) return no_memory();
    bool slash = length > 0 && folder[length - 1] == '/';
    snprintf(path, size, "%s%s%s", folder, slash ? "" : "/", name);
    bool file = name[0] != '.' && stat(path, &info) == 0 && S_ISREG(info.st_mode);
    if (file && is_model(name)) return append(b, path, path);
    b->others += file;
    free(path);
    return EXIT_DONE;
}

static int by_name(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

static int take_folder(batch *b, const char *folder) {
    struct dirent **entries = NULL;
    int count = scandir(folder, &entries, NULL, by_name), code = EXIT_DONE;
    if (count < 0) {
        return report_error(EXIT_IO, NULL, "%s: the folder cannot be read: %s", folder,
                            strerror(errno));
    }
    size_t before = b->options.operands.count;
    b->folders++;
    for (int i = 0; i < count; i++) {
        if (code == EXIT_DONE) code = take_entry(b, folder, entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    if (code != EXIT_DONE || b->options.operands.count > before) return code;
    return report_error(
        EXIT_INPUT, "'snell help formats' lists what is read; folders in it are not looked into",
        "%s: there is no model in this folder", folder);
}

typedef struct named {
    const char *name; /* without folder and extension, of this length */
    size_t length, index;
} named;

static int compare_names(const void *a, const void *b) {
    const named *x = a, *y = b;
    int order = strncmp(x->name, y->name, x->length < y->length ? x->length : y->length);
    if (order == 0) order = (x->length > y->length) - (x->length < y->length);
    return order != 0 ? order : (x->index > y->index) - (x->index < y->index);
}

/* In a folder may be duck.obj beside duck.glb. */
static int find_twins(batch *b) {
    size_t count = b->options.operands.count;
    named *names = malloc((count + 1) * sizeof *names);
    b->whole = calloc(count + 1, sizeof *b->whole);
    if (names == NULL || b->whole == NULL) {
        free(names);
        return no_memory();
    }
    for (size_t i = 0; i < count; i++) {
        names[i].index = i;
        output_input_name(b->options.operands.items[i], &names[i].name, &names[i].length);
    }
    if (b->folders > 0) qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 0; b->folders > 0 && i + 1 < count; i++) {
        bool same = names[i].length == names[i + 1].length &&
                    strncmp(names[i].name, names[i + 1].name, names[i].length) == 0;
        if (same) b->whole[names[i].index] = b->whole[names[i + 1].index] = true;
    }
    free(names);
    return EXIT_DONE;
}

int batch_open(const options *o, batch *out) {
    *out = (batch){.options = *o};
    out->options.operands = (string_list){NULL, 0};
    int code = EXIT_DONE;
    for (size_t i = 0; i < o->operands.count && code == EXIT_DONE; i++) {
        const char *path = o->operands.items[i];
        code = is_folder(path) ? take_folder(out, path) : append(out, path, NULL);
    }
    return code == EXIT_DONE ? find_twins(out) : code;
}

void batch_free(batch *b) {
    for (size_t i = 0; i < b->owned_count; i++) free(b->owned[i]);
    free(b->owned);
    free(b->whole);
    free(b->options.operands.items);
}
