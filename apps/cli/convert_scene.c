/* snell convert SCENE OUT.snell: a scene in another form, its picture unchanged. */
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "convert.h"
#include "output.h"
#include "progress.h"
#include "report.h"
#include "text.h"
#include "values.h"

static const char *const extensions[] = {"snell", "lua"};

bool convert_writes_scene(const char *path) {
    for (size_t i = 0; i < sizeof extensions / sizeof extensions[0]; i++)
        if (strcasecmp(output_extension(path), extensions[i]) == 0) return true;
    return false;
}

/* Of a picture alone, or of a scene. */
static const option_id of_pictures[] = {OPT_EXPOSURE, OPT_TONEMAP, OPT_WHITE_BALANCE, OPT_LAYER,
                                        OPT_FORMAT,   OPT_BITS,    OPT_QUALITY,       OPT_STRIP};
static const option_id of_scenes[] = {OPT_SET, OPT_ALLOW, OPT_INPUT_FORMAT, OPT_UP, OPT_FRAME};

static bool is_given(const options *o, option_id id) {
    if (id == OPT_SET) return o->set.count > 0;
    return id == OPT_ALLOW ? o->allow.count > 0 : o->value[id] != NULL;
}

int convert_check_options(const options *o, bool scene) {
    const option_id *wrong = scene ? of_pictures : of_scenes;
    size_t count = scene ? sizeof of_pictures / sizeof *wrong : sizeof of_scenes / sizeof *wrong;
    for (size_t i = 0; i < count; i++) {
        if (!is_given(o, wrong[i])) continue;
        const char *name = "";
        for (size_t k = 0; k < option_table_count; k++)
            if (option_table[k].id == wrong[i] && (option_table[k].flags & OPTION_HIDDEN) == 0)
                name = option_table[k].name;
        return report_usage(scene ? "'snell render' makes its picture"
                                  : "B would be a .snell or .lua file",
                            "--%s is for %s, and B is %s", name, scene ? "pictures" : "scenes",
                            scene ? "a scene" : "a picture");
    }
    return EXIT_DONE;
}

/* A camera frames all that a scene without one ever shows: what lies beyond the shutter would change the
 * picture, and does without motion vectors. */
static int load(session *s, const char *path, snell_scene **out) {
    snell_scene_stats has = {.struct_size = sizeof has};
    s->keeps_input = true; /* it may be read twice */
    s->next_frame = true;
    int code = session_load(s, path, out);
    if (code != EXIT_DONE) return code;
    snell_status status = snell_scene_get_stats(*out, &has);
    if (status != SNELL_OK) return report_status(status, path);
    bool may_move = s->frame > 0 || strcmp(has.format, "lua") == 0;
    if (has.camera_count > 0 || !may_move) return EXIT_DONE;
    snell_scene_destroy(*out);
    s->next_frame = false;
    report_mute(true); /* the same warnings again */
    code = session_load(s, path, out);
    report_mute(false);
    return code;
}

static int check_itself(const char *from, const char *to) {
    struct stat a, b;
    if (stat(from, &a) != 0 || stat(to, &b) != 0) return EXIT_DONE;
    if (a.st_dev != b.st_dev || a.st_ino != b.st_ino) return EXIT_DONE;
    return report_usage("give B another name", "%s would be written over itself", from);
}

static void say_done(const char *from, const char *to) {
    struct stat info = {.st_size = 0};
    char size[32];
    (void)stat(to, &info);
    if (report_json()) {
        json_t *root = json_pack("{s:i,s:o,s:o,s:I}", "schema", 1, "file", report_text(from),
                                 "output", report_text(to), "size", (json_int_t)info.st_size);
        json_object_set_new(root, "warnings", report_take_warnings());
        report_emit(root, EXIT_DONE);
        return;
    }
    text_format_bytes((uint64_t)info.st_size, size);
    report_note("%s  %s  from %s", to, size, session_label(from));
}

int convert_scene(session *s) {
    const char *from = s->options->operands.items[0], *to = s->options->operands.items[1];
    snell_scene *scene = NULL;
    uint32_t last;
    int code = check_itself(from, to);
    if (code == EXIT_DONE) code = output_check_folder(to);
    if (code == EXIT_DONE) code = values_read_frames(s->options, &s->frame, &last);
    if (code == EXIT_DONE) code = load(s, from, &scene);
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE) {
        snell_status status = snell_scene_save(scene, to);
        code = status == SNELL_OK ? EXIT_DONE : report_status(status, session_label(from));
    }
    if (code == EXIT_DONE) say_done(from, to);
    snell_scene_destroy(scene);
    return code;
}
