/* FBX, COLLADA and what else libassimp reads, through its C interface. */
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/assimp_reader.h"

snell_status reader_warn(reader *r, const char *format, ...) {
    char text[800];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return description_add_message(r->d, SNELL_WARNING, r->path, 0, NULL, "%s", text);
}

snell_status reader_blame(const reader *r, const char *what, snell_status status) {
    if (status == SNELL_OK || status == SNELL_ERR_MEMORY) return status;
    char text[800];
    snprintf(text, sizeof text, "%s", error_last()->text);
    return error_set_at(status == SNELL_ERR_ARGUMENT ? SNELL_ERR_SYNTAX : status,
                        (source_place){r->path, 0, 0}, NULL, "%s: %s", what, text);
}

/* ---- files: everything that libassimp opens goes through files.h ---- */

typedef struct memory_file {
    struct aiFile calls;
    const uint8_t *data;
    uint8_t *owned; /* NULL: the scene file, which is kept for the next opening */
    size_t size, at;
} memory_file;

typedef struct file_system {
    struct aiFileIO calls;
    reader *reader;
    uint8_t *data; /* of the scene file */
    size_t size;
} file_system;

static memory_file *file_of(struct aiFile *file) { return (memory_file *)(void *)file->UserData; }

static size_t file_read(struct aiFile *file, char *out, size_t size, size_t count) {
    memory_file *f = file_of(file);
    if (size == 0) return 0;
    size_t most = (f->size - f->at) / size, items = count < most ? count : most;
    if (items > 0) memcpy(out, f->data + f->at, items * size);
    f->at += items * size;
    return items;
}

static size_t file_write(struct aiFile *file, const char *data, size_t size, size_t count) {
    (void)file, (void)data, (void)size, (void)count;
    return 0;
}

static size_t file_tell(struct aiFile *file) { return file_of(file)->at; }
static size_t file_size(struct aiFile *file) { return file_of(file)->size; }
static void file_flush(struct aiFile *file) { (void)file; }

/* Offsets are unsigned, with which negative ones come wrapped round. */
static enum aiReturn file_seek(struct aiFile *file, size_t offset, enum aiOrigin origin) {
    memory_file *f = file_of(file);
    size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? f->at : f->size;
    size_t to = base + offset;
    if (to > f->size) return aiReturn_FAILURE;
    f->at = to;
    return aiReturn_SUCCESS;
}

/* libassimp puts the scene file's folder in front of what the file says; files.h does that
 * itself. Windows paths become ours. */
static snell_status read_beside(const reader *r, const char *path, uint8_t **data, size_t *size) {
    char name[1024];
    const char *slash = strrchr(r->path, '/');
    size_t folder = slash ? (size_t)(slash - r->path) + 1 : 0;
    if (folder > 0 && strncmp(path, r->path, folder) == 0) path += folder;
    while (path[0] == '.' && (path[1] == '/' || path[1] == '\\')) path += 2;
    snprintf(name, sizeof name, "%s", path);
    for (char *c = name; *c; c++)
        if (*c == '\\') *c = '/';
    return import_read_beside(r->path, name, r->options, data, size);
}

static struct aiFile *fs_open(struct aiFileIO *io, const char *path, const char *mode) {
    file_system *fs = (file_system *)(void *)io->UserData;
    if (strchr(mode, 'w') || strchr(mode, 'a') || strchr(mode, '+')) return NULL;
    memory_file *f = memory_zeroed(1, sizeof *f);
    if (f == NULL) return NULL;
    if (strcmp(path, fs->reader->shown) == 0) {
        f->data = fs->data, f->size = fs->size;
    } else if (read_beside(fs->reader, path, &f->owned, &f->size) == SNELL_OK) {
        f->data = f->owned;
    } else {
        free(f);
        return NULL;
    }
    f->calls = (struct aiFile){file_read, file_write, file_tell,        file_size,
                               file_seek, file_flush, (char *)(void *)f};
    return &f->calls;
}

static void fs_close(struct aiFileIO *io, struct aiFile *file) {
    (void)io;
    memory_file *f = file_of(file);
    free(f->owned);
    free(f);
}

/* ---- the importer ---- */

extern const importer importer_assimp;

/* libassimp's message, shortened, without line ends, the kind of file (which ours names) and the
 * full stop. */
static void foreign_text(const char *kind, char *out, size_t size) {
    const char *from = aiGetErrorString();
    size_t length = strlen(kind);
    if (length > 0 && strncmp(from, kind, length) == 0) {
        if (strncmp(from + length, ": ", 2) == 0)
            from += length + 2;
        else if (strcmp(from + length, "-file is too small.") == 0)
            from = "it is too small to be one";
    }
    snprintf(out, size, "%s", from);
    for (char *c = out; *c; c++)
        if ((unsigned char)*c < 32) *c = ' ';
    length = strlen(out);
    while (length > 0 && (out[length - 1] == '.' || out[length - 1] == ' ')) out[--length] = 0;
}

static snell_status reading_failed(const reader *r) {
    const char *error = aiGetErrorString();
    source_place place = {r->path, 0, 0};
    if (strstr(error, "bad_alloc") || strstr(error, "bad allocation") ||
        strstr(error, "bad_array_new_length"))
        return error_set_at(SNELL_ERR_MEMORY, place, "allow more memory for reading",
                            "the file needs more memory than reading may use");
    if (strstr(error, "mNumMeshes is 0"))
        return error_set_at(SNELL_ERR_SYNTAX, place, NULL, "the file has no surfaces");
    char text[400], kind[sizeof r->extension] = "";
    for (size_t i = 0; r->extension[0] && r->extension[i + 1]; i++)
        kind[i] = (char)toupper((unsigned char)r->extension[i + 1]), kind[i + 1] = 0;
    foreign_text(kind, text, sizeof text);
    return error_set_at(
        SNELL_ERR_SYNTAX, place, "it may be damaged, or of another format than its name says",
        "cannot read the %s file: %s", kind[0] ? kind : "model", text[0] ? text : "it is broken");
}

/* Where a format has no normals, faces that meet at less than 60 degrees are smooth. */
static const struct aiScene *import_once(const reader *r, file_system *fs, bool validate) {
    unsigned flags = aiProcess_Triangulate | aiProcess_GenSmoothNormals;
    if (validate) flags |= aiProcess_ValidateDataStructure | aiProcess_SortByPType;
    struct aiPropertyStore *store = aiCreatePropertyStore();
    if (store == NULL) return NULL;
    aiSetImportPropertyFloat(store, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 60);
    const struct aiScene *scene = aiImportFileExWithProperties(r->shown, flags, &fs->calls, store);
    aiReleasePropertyStore(store);
    return scene;
}

/* libassimp's validation keeps its later steps away from indices out of range; but it also refuses
 * a file for one part that is empty, which does no harm. */
static const struct aiScene *import_scene(const reader *r, file_system *fs) {
    const struct aiScene *scene = import_once(r, fs, true);
    if (scene) return scene;
    const char *error = aiGetErrorString();
    bool harmless = strstr(error, "contains no faces") || strstr(error, "contains no vertices");
    return harmless ? import_once(r, fs, false) : NULL;
}

static snell_status fill(reader *r) {
    const struct aiScene *scene = r->scene;
    r->materials = memory_zeroed((size_t)scene->mNumMaterials + 1, sizeof *r->materials);
    r->shapes = memory_zeroed((size_t)scene->mNumMeshes + 1, sizeof *r->shapes);
    if (r->materials == NULL || r->shapes == NULL) return error_no_memory();
    snell_status status = reader_read_materials(r);
    if (!status) status = reader_read_meshes(r);
    if (!status && (scene->mNumCameras > 0 || scene->mNumLights > 0))
        status = reader_warn(r, "cameras and lights of this format are not read yet");
    if (!status && scene->mNumAnimations > 0)
        status = reader_warn(r, "%u animation%s: the model is shown at rest", scene->mNumAnimations,
                             scene->mNumAnimations == 1 ? "" : "s");
    return status;
}

/* libassimp goes by the extension: by the one that was asked for, else the file's own. */
static snell_status choose_reader(reader *r) {
    const char *asked = r->options->format;
    char named[16];
    import_extension(r->path, named, sizeof named);
    snprintf(r->extension, sizeof r->extension, "%s", named);
    if (asked && strcmp(asked, importer_assimp.name) != 0)
        snprintf(r->extension, sizeof r->extension, ".%.14s", asked);
    size_t length = strlen(r->path) + sizeof r->extension;
    r->shown = malloc(length);
    if (r->shown == NULL) return error_no_memory();
    bool differs = strcmp(named, r->extension) != 0;
    snprintf(r->shown, length, "%s%s", r->path, differs ? r->extension : "");
    return SNELL_OK;
}

static snell_status assimp_read(const char *path, const import_options *options, description *d) {
    reader r = {.path = path, .options = options, .d = d};
    file_system fs = {.reader = &r};
    fs.calls = (struct aiFileIO){fs_open, fs_close, (char *)(void *)&fs};
    snell_status status = import_read_file(path, NULL, options, &fs.data, &fs.size);
    if (!status && fs.size == 0) status = error_set(SNELL_ERR_SYNTAX, NULL, "the file is empty");
    if (!status) status = choose_reader(&r);
    if (!status) {
        r.scene = import_scene(&r, &fs);
        status = r.scene ? fill(&r) : reading_failed(&r);
        if (r.scene) aiReleaseImport(r.scene);
    }
    for (size_t i = 0; i < r.map_count; i++) free(r.maps[i].path);
    free(r.maps);
    free(r.shown);
    free(r.materials);
    free(r.shapes);
    free(fs.data);
    names_deinit(&r.names);
    if (status) error_place((source_place){path, 0, 0});
    snprintf(d->format, sizeof d->format, "%.15s", r.extension[0] ? r.extension + 1 : "assimp");
    d->is_model = true;
    return status;
}

static bool assimp_recognise(const char *extension, const uint8_t *first, size_t size) {
    (void)first, (void)size;
    return extension[0] == '.' && aiIsExtensionSupported(extension) == AI_TRUE;
}

const importer importer_assimp = {
    .name = "assimp",
    .extensions = ".fbx .dae .3ds .x3d .off .blend .dxf .lwo .ms3d .x .ac .3mf",
    .help = "what else libassimp reads",
    .recognise = assimp_recognise,
    .read = assimp_read,
};
