/* snell compare: how far two pictures are apart, and whether that is too far. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "commands.h"
#include "output.h"
#include "picture.h"
#include "progress.h"
#include "report.h"
#include "text.h"
#include "values.h"

typedef struct limit {
    option_id id;
    const char *option, *label; /* as in "FLIP 0.2 is over --max-flip 0.1" */
    double found, bound;        /* found beyond the bound fails */
    bool least;                 /* the bound is the least that passes */
} limit;

enum { LIMIT_COUNT = 7 };

typedef struct job {
    const options *options;
    session *session;
    output error;
    picture_file pictures[2];
    snell_film *variances[2], *errors;
    snell_compare_desc desc;
    picture_look look;
    snell_comparison found;
    json_t *over; /* names of the limits that are not kept */
} job;

/* ---- limits ---- */

/* A count of pixels, or a share of them in percent. */
static int read_pixels(const char *text, const snell_comparison *c, double *out) {
    char number[32];
    size_t length = strlen(text);
    double share;
    uint64_t count;
    bool fine = false;
    if (length > 1 && length < sizeof number && text[length - 1] == '%') {
        memcpy(number, text, length - 1);
        number[length - 1] = '\0';
        fine = text_number(number, &share) && share >= 0 && share <= 100;
        *out = fine ? share / 100 * c->width * c->height : 0;
    } else if (text_uint(text, 0, UINT32_MAX, &count)) {
        fine = true;
        *out = (double)count;
    }
    return fine ? EXIT_DONE
                : report_usage("a whole number, or such as 0.1%",
                               "--max-differing: '%s' is no number of pixels", text);
}

/* Reads all limits; what was found is filled in after the comparison. */
static int read_limits(const options *o, const snell_comparison *c, limit limits[LIMIT_COUNT]) {
    const limit all[LIMIT_COUNT] = {
        {OPT_MAX_FLIP, "max-flip", "FLIP", c->flip, 0, false},
        {OPT_MAX_RMSE, "max-rmse", "RMSE", c->rmse, 0, false},
        {OPT_MAX_REL_MSE, "max-rel-mse", "relMSE", c->rel_mse, 0, false},
        {OPT_MIN_PSNR, "min-psnr", "PSNR", c->psnr, 0, true},
        {OPT_MAX_DIFFERENCE, "max-difference", "the largest difference", c->difference_max, 0,
         false},
        {OPT_MAX_REJECTED, "max-rejected", "the number of rejected pixels", (double)c->z_rejected,
         0, false},
        {OPT_MAX_DIFFERING, "max-differing", "the number of differing pixels", (double)c->differing,
         0, false}};
    int code = EXIT_DONE;
    for (int i = 0; i < LIMIT_COUNT && code == EXIT_DONE; i++) {
        limits[i] = all[i];
        const char *text = o->value[all[i].id];
        if (text != NULL && all[i].id == OPT_MAX_DIFFERING)
            code = read_pixels(text, c, &limits[i].bound);
        else
            code = values_read_decimal(o, all[i].id, all[i].option, 0, 1e30, &limits[i].bound);
    }
    return code;
}

static bool is_over(const limit *l) {
    return l->least ? !(l->found >= l->bound) : !(l->found <= l->bound);
}

/* Without a limit no pixel may differ. With one, pixels that are no numbers are over it: their
 * error is not known. */
static int judge(job *j) {
    limit limits[LIMIT_COUNT];
    bool any = false;
    int code = read_limits(j->options, &j->found, limits);
    for (int i = 0; i < LIMIT_COUNT && code == EXIT_DONE; i++) {
        const limit *l = &limits[i];
        const char *text = j->options->value[l->id];
        if (text == NULL) continue;
        any = true;
        if (!is_over(l)) continue;
        report_note("%s, %.6g, is %s --%s %s", l->label, l->found, l->least ? "under" : "over",
                    l->option, text);
        json_array_append_new(j->over, report_text(l->option));
    }
    if (code != EXIT_DONE) return code;
    if (any && j->found.not_finite > 0) {
        report_note("%" PRIu64 " pixel%s NaN or infinite: how far they are apart is not known",
                    j->found.not_finite, j->found.not_finite == 1 ? " is" : "s are");
        json_array_append_new(j->over, json_string("not-finite"));
    }
    bool differs = any ? json_array_size(j->over) > 0 : j->found.differing > 0;
    return differs ? EXIT_DIFFERS : EXIT_DONE;
}

/* ---- what is asked for ---- */

static bool is_same_file(const char *a, const char *b) {
    struct stat one, other;
    return stat(a, &one) == 0 && stat(b, &other) == 0 && one.st_dev == other.st_dev &&
           one.st_ino == other.st_ino;
}

/* The picture of errors, before any work. */
static int plan_error(job *j) {
    const options *o = j->options;
    const char *path = o->value[OPT_ERROR];
    if (path == NULL && o->value[OPT_ERROR_MAP] != NULL) {
        return report_usage("such as --error difference.png", "--error-map needs --error FILE");
    }
    if (path == NULL) return EXIT_DONE;
    if (strcmp(path, "-") == 0) {
        return report_usage("the numbers go there", "--error cannot be standard output");
    }
    for (size_t i = 0; i < 2; i++)
        if (is_same_file(path, o->operands.items[i]))
            return report_usage("name another file", "--error would replace %s",
                                o->operands.items[i]);
    return output_plan_path(&j->error, o, "--error: ", path);
}

static int read_desc(job *j) {
    const options *o = j->options;
    snell_comparison nothing = {.width = 1, .height = 1};
    limit limits[LIMIT_COUNT];
    double ppd = (double)j->desc.pixels_per_degree;
    uint64_t count = 0;
    int code = read_limits(o, &nothing, limits);
    if (code == EXIT_DONE) code = values_read_decimal(o, OPT_PPD, "ppd", 1, 1000, &ppd);
    if (code == EXIT_DONE)
        code = values_read_whole(o, OPT_VARIANCE_COUNT, "variance-count", 2, 1u << 30, &count);
    if (code == EXIT_DONE) code = plan_error(j);
    j->desc.pixels_per_degree = (float)ppd;
    j->desc.variance_count = (uint32_t)count;
    j->desc.as_shown = o->value[OPT_EXPOSURE] != NULL || o->value[OPT_TONEMAP] != NULL ||
                       o->value[OPT_WHITE_BALANCE] != NULL;
    j->desc.progress = progress_report;
    const char *map = o->value[OPT_ERROR_MAP], *path = o->value[OPT_ERROR];
    bool difference = map != NULL && strcmp(map, "difference") == 0;
    j->desc.error_map = difference ? SNELL_ERROR_DIFFERENCE : SNELL_ERROR_FLIP;
    size_t length = path != NULL ? strlen(path) : 0;
    j->desc.error_values = length > 4 && (strcasecmp(path + length - 4, ".exr") == 0 ||
                                          strcasecmp(path + length - 4, ".pfm") == 0);
    return code;
}

/* The look of the one that has none of its own. */
static int choose_look(job *j) {
    const options *o = j->options;
    const picture_file *a = &j->pictures[0], *b = &j->pictures[1];
    bool a_linear = snell_film_encoded_bits(a->film) == 0,
         b_linear = snell_film_encoded_bits(b->film) == 0;
    if (j->desc.as_shown && !a_linear && !b_linear) {
        return report_usage("they are for files of floats, such as .exr",
                            "--exposure and --tonemap change nothing: both pictures are as shown");
    }
    int code = picture_read_look(o, a_linear ? a : b, &j->look);
    j->desc.exposure = j->look.exposure;
    j->desc.tonemap = j->look.tonemap;
    j->desc.white_balance = j->look.white_balance;
    return code;
}

static int read_variances(job *j) {
    const options *o = j->options;
    int code = EXIT_DONE;
    for (int i = 0; i < 2 && code == EXIT_DONE && o->value[OPT_LAYER] == NULL; i++)
        code = picture_open_layer(j->session, &j->pictures[i], "variance", &j->variances[i]);
    j->desc.reference_variance = j->variances[0];
    j->desc.picture_variance = j->variances[1];
    bool none = j->variances[0] == NULL && j->variances[1] == NULL;
    bool wanted = o->value[OPT_MAX_REJECTED] != NULL || o->value[OPT_VARIANCE_COUNT] != NULL;
    if (code == EXIT_DONE && none && wanted) {
        code = report_usage("the z-test wants an EXR with channels variance.R, variance.G and "
                            "variance.B",
                            "--%s: neither picture has a layer 'variance'",
                            o->value[OPT_MAX_REJECTED] != NULL ? "max-rejected" : "variance-count");
    }
    return code;
}

/* ---- what is said ---- */

static double percent(uint64_t part, double whole) {
    return whole > 0 ? 100 * (double)part / whole : 0;
}

static void print_result(const job *j) {
    const snell_comparison *c = &j->found;
    double pixels = (double)c->width * c->height;
    text_print_safe(stdout, j->pictures[0].path);
    fputs("  ", stdout);
    text_print_safe(stdout, j->pictures[1].path);
    printf("  %" PRIu32 "x%" PRIu32 "  %s\n", c->width, c->height,
           c->linear ? "in linear light" : "as shown, sRGB 0 to 1");
    if (c->differing == 0) {
        puts("equal");
        return;
    }
    printf("differing   %" PRIu64 " of %.0f pixels (%.3g %%)\n", c->differing, pixels,
           percent(c->differing, pixels));
    if (c->not_finite > 0)
        printf("left out    %" PRIu64 " pixels that are NaN or infinite\n", c->not_finite);
    printf("largest     %.6g at %" PRIu32 ",%" PRIu32 "\n", c->difference_max, c->difference_x,
           c->difference_y);
    printf("FLIP        %.6g%s\n", c->flip, c->linear ? " (HDR)" : "");
    printf("RMSE        %.6g\n", c->rmse);
    printf("relMSE      %.6g\n", c->rel_mse);
    printf("PSNR        %.4g dB\n", c->psnr);
    if (c->z_values == 0) return;
    printf("z-test      %.3g %% of the values beyond the 5 %% level, %" PRIu64
           " pixel%s rejected\n",
           percent(c->z_beyond, (double)c->z_values), c->z_rejected, c->z_rejected == 1 ? "" : "s");
    printf("            the largest z %.4g at %" PRIu32 ",%" PRIu32 "\n", c->z_max, c->z_x, c->z_y);
}

/* JSON knows no infinity: null. */
static json_t *json_number(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *json_result(const job *j, int code) {
    const snell_comparison *c = &j->found;
    json_t *root = json_object();
    json_object_set_new(root, "schema", json_integer(1));
    json_object_set_new(root, "reference", report_text(j->pictures[0].path));
    json_object_set_new(root, "file", report_text(j->pictures[1].path));
    json_object_set_new(root, "width", json_integer(c->width));
    json_object_set_new(root, "height", json_integer(c->height));
    json_object_set_new(root, "linear", json_boolean(c->linear));
    json_object_set_new(root, "differing", json_integer((json_int_t)c->differing));
    json_object_set_new(root, "not_finite", json_integer((json_int_t)c->not_finite));
    json_object_set_new(root, "difference_max", json_number(c->difference_max));
    json_object_set_new(
        root, "difference_at",
        json_pack("[I,I]", (json_int_t)c->difference_x, (json_int_t)c->difference_y));
    json_object_set_new(root, "flip", json_number(c->flip));
    json_object_set_new(root, "rmse", json_number(c->rmse));
    json_object_set_new(root, "rel_mse", json_number(c->rel_mse));
    json_object_set_new(root, "psnr", json_number(c->psnr));
    if (c->z_values > 0) {
        json_t *z = json_object();
        json_object_set_new(z, "values", json_integer((json_int_t)c->z_values));
        json_object_set_new(z, "beyond", json_integer((json_int_t)c->z_beyond));
        json_object_set_new(z, "rejected", json_integer((json_int_t)c->z_rejected));
        json_object_set_new(z, "max", json_number(c->z_max));
        json_object_set_new(z, "at", json_pack("[I,I]", (json_int_t)c->z_x, (json_int_t)c->z_y));
        json_object_set_new(root, "z_test", z);
    }
    if (j->options->value[OPT_ERROR] != NULL)
        json_object_set_new(root, "error_map", report_text(j->options->value[OPT_ERROR]));
    json_object_set_new(root, "over", json_incref(j->over));
    json_object_set_new(root, "passed", json_boolean(code == EXIT_DONE));
    json_object_set_new(root, "warnings", report_take_warnings());
    return root;
}

/* ---- the command ---- */

static int compute(job *j) {
    snell_status status = SNELL_OK;
    if (j->options->value[OPT_ERROR] != NULL)
        status = snell_film_create(j->session->context, &j->errors);
    j->desc.error = j->errors;
    j->found = (snell_comparison){.struct_size = sizeof j->found};
    if (status == SNELL_OK)
        status = snell_film_compare(j->pictures[0].film, j->pictures[1].film, &j->desc, &j->found);
    progress_end();
    if (signals_caught() != 0) return EXIT_SOME_FAILED;
    return status == SNELL_OK ? EXIT_DONE : report_status(status, j->pictures[1].path);
}

static int compare(job *j) {
    int code = EXIT_DONE;
    for (int i = 0; i < 2 && code == EXIT_DONE; i++)
        code = picture_open(j->session, j->options->operands.items[i], &j->pictures[i]);
    if (code == EXIT_DONE) code = choose_look(j);
    if (code == EXIT_DONE) code = read_variances(j);
    if (code == EXIT_DONE) code = compute(j);
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE && j->errors != NULL) code = output_write(&j->error, j->errors, NULL);
    if (code != EXIT_DONE) return code;
    if (!report_json() && report_level() > LEVEL_QUIET) print_result(j);
    code = judge(j);
    return report_json() ? report_emit(json_result(j, code), code) : code;
}

int compare_command(const options *o) {
    const string_list *files = &o->operands;
    if (files->count != 2) {
        return report_usage("such as: snell compare reference.png new.png",
                            "compare needs two pictures");
    }
    if (strcmp(files->items[0], "-") == 0 || strcmp(files->items[1], "-") == 0) {
        return report_usage("put it into a file", "compare does not read standard input");
    }
    session s = {.options = o};
    job j = {.options = o, .session = &s, .desc = SNELL_INIT(compare_desc), .over = json_array()};
    int code = read_desc(&j);
    signals_setup();
    progress_setup(o->value[OPT_PROGRESS]);
    if (code == EXIT_DONE) code = session_open(&s, o);
    if (code == EXIT_DONE) {
        progress_begin("compare");
        code = compare(&j);
        progress_end();
    }
    for (int i = 0; i < 2; i++) {
        picture_close(&j.pictures[i]);
        snell_film_destroy(j.variances[i]);
    }
    snell_film_destroy(j.errors);
    output_free(&j.error);
    json_decref(j.over);
    session_close(&s);
    return code;
}
