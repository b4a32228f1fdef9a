/* snell convert: a picture in another format or look; scenes are convert_scene.c's. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "convert.h"
#include "output.h"
#include "picture.h"
#include "progress.h"
#include "report.h"
#include "tag.h"
#include "values.h"

/* Light is kept as it is: a look would be lost without a word. */
static int check_look(const options *o, const output *out) {
    static const option_id ids[] = {OPT_EXPOSURE, OPT_TONEMAP, OPT_WHITE_BALANCE};
    static const char *const names[] = {"exposure", "tonemap", "white-balance"};
    for (size_t i = 0; out->format.linear && i < sizeof ids / sizeof ids[0]; i++) {
        if (o->value[ids[i]] == NULL) continue;
        return report_usage("it is for .png and other files for screens",
                            "%s: --%s would change nothing, these files hold linear light",
                            out->path, names[i]);
    }
    return EXIT_DONE;
}

static int write_picture(const options *o, const picture_file *p, const output *out) {
    snell_image_desc image = SNELL_INIT(image_desc);
    char *tag = NULL;
    picture_look look;
    int code = picture_read_look(o, p, &look);
    image.exposure = look.exposure;
    image.exposure_set = true;
    image.tonemap = look.tonemap;
    image.white_balance = look.white_balance;
    if (code == EXIT_DONE) code = values_read_encoding(o, &image.bits, &image.quality);
    if (code == EXIT_DONE && o->value[OPT_STRIP] == NULL && p->tag != NULL) {
        tag = tag_convert(p->tag, o, snell_film_encoded_bits(p->film) == 0);
        if (tag == NULL) code = report_error(EXIT_MEMORY, NULL, "out of memory");
    }
    image.tag = tag;
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE) code = output_write(out, p->film, &image);
    free(tag);
    return code;
}

static void say_done(const picture_file *p, const output *out) {
    uint32_t width = 0, height = 0;
    snell_film_pixels(p->film, &width, &height, NULL);
    if (report_json()) {
        json_t *root =
            json_pack("{s:i,s:o,s:o,s:i,s:i}", "schema", 1, "file", report_text(p->path), "output",
                      report_text(out->path), "width", (int)width, "height", (int)height);
        json_object_set_new(root, "warnings", report_take_warnings());
        report_emit(root, EXIT_DONE);
        return;
    }
    report_note("%s  %" PRIu32 "x%" PRIu32 "  from %s",
                strcmp(out->path, "-") == 0 ? "standard output" : out->path, width, height,
                session_label(p->path));
}

static int convert(session *s, const output *out) {
    const options *o = s->options;
    picture_file picture;
    int code = picture_open(s, o->operands.items[0], &picture);
    if (code == EXIT_DONE && signals_caught() != 0) code = EXIT_SOME_FAILED;
    if (code == EXIT_DONE) code = write_picture(o, &picture, out);
    if (code == EXIT_DONE) say_done(&picture, out);
    picture_close(&picture);
    return code;
}

static int open_and_convert(const options *o, const output *picture) {
    signals_setup();
    progress_setup(NULL);
    session s = {.options = o};
    int code = session_open(&s, o);
    if (code == EXIT_DONE) {
        progress_begin(session_label(o->operands.items[0]));
        code = picture != NULL ? convert(&s, picture) : convert_scene(&s);
        progress_end();
    }
    session_close(&s);
    return code;
}

static int convert_picture(const options *o) {
    output out = {.path = NULL};
    double exposure = 0;
    int code = values_read_decimal(o, OPT_EXPOSURE, "exposure", -50, 50, &exposure);
    if (code == EXIT_DONE) code = output_plan_path(&out, o, "", o->operands.items[1]);
    if (code == EXIT_DONE) code = check_look(o, &out);
    if (code == EXIT_DONE) code = open_and_convert(o, &out);
    output_free(&out);
    return code;
}

int convert_command(const options *o) {
    if (o->operands.count != 2) {
        return report_usage("such as: snell convert glass.exr glass.png",
                            "convert needs two names: the picture or scene, and what to write");
    }
    bool scene = convert_writes_scene(o->operands.items[1]);
    int code = convert_check_options(o, scene);
    if (code != EXIT_DONE) return code;
    return scene ? open_and_convert(o, NULL) : convert_picture(o);
}
