#include "picture.h"

#include <stdlib.h>
#include <string.h>

#include "progress.h"
#include "report.h"
#include "tag.h"
#include "text.h"
#include "values.h"

static int read_layer(session *s, const char *real, const char *shown, const char *layer,
                      snell_film **out) {
    snell_film_read_desc desc = SNELL_INIT(film_read_desc);
    desc.layer = layer;
    desc.memory_max = s->memory_max;
    desc.progress = progress_report;
    snell_status status = snell_film_create(s->context, out);
    if (status == SNELL_OK) status = snell_film_read(*out, real, &desc);
    if (status == SNELL_OK) return EXIT_DONE;
    snell_film_destroy(*out);
    *out = NULL;
    if (signals_caught() != 0) return EXIT_SOME_FAILED;
    bool wrong_layer = status == SNELL_ERR_ARGUMENT && layer != NULL;
    return wrong_layer ? report_status_as(EXIT_USAGE, status, shown) : report_status(status, shown);
}

static void read_tag(const char *real, picture_file *p) {
    snell_picture_info info = {.struct_size = sizeof info};
    bool known = snell_picture_read_info(real, &info) == SNELL_OK; /* HDR has none */
    p->tag = known ? info.tag : NULL;
    if (known) snell_free(info.layers);
    if (p->tag != NULL) p->parsed = tag_read(p->tag);
}

int picture_open(session *s, const char *path, picture_file *out) {
    const char *real;
    *out = (picture_file){.path = path};
    int code = session_input(s, path, &real);
    if (code == EXIT_DONE)
        code = read_layer(s, real, session_label(path), s->options->value[OPT_LAYER], &out->film);
    if (code == EXIT_DONE) read_tag(real, out);
    session_end_input(s);
    return code;
}

void picture_close(picture_file *p) {
    snell_film_destroy(p->film);
    snell_free(p->tag);
    json_decref(p->parsed);
    *p = (picture_file){.path = p->path};
}

int picture_open_layer(session *s, const picture_file *p, const char *layer, snell_film **out) {
    const char *name;
    *out = NULL;
    for (uint32_t i = 0; (name = snell_film_layer(p->film, i)) != NULL; i++)
        if (strcmp(name, layer) == 0) return read_layer(s, p->path, p->path, layer, out);
    return EXIT_DONE;
}

int picture_read_look(const options *o, const picture_file *p, picture_look *out) {
    bool own = snell_film_encoded_bits(p->film) == 0 && o->value[OPT_LAYER] == NULL, given;
    const char *made = own ? tag_option(p->parsed, "exposure") : NULL,
               *white = own ? tag_option(p->parsed, "white-balance") : NULL;
    double number = 0;
    if (made == NULL || !text_number(made, &number) || number < -50 || number > 50) number = 0;
    int code = values_read_decimal(o, OPT_EXPOSURE, "exposure", -50, 50, &number);
    out->exposure = (float)number;
    out->tonemap = o->value[OPT_TONEMAP];
    if (out->tonemap == NULL && own) out->tonemap = tag_option(p->parsed, "tonemap");
    if (out->tonemap == NULL || !text_choice_has(option_find("tonemap", 7)->values, out->tonemap))
        out->tonemap = "clip";
    if (white == NULL || !values_white(white, out->white_balance)) out->white_balance[0] = '\0';
    if (code == EXIT_DONE) code = values_read_white(o, out->white_balance, &given);
    return code;
}
