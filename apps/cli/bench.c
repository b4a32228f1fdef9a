/* snell bench: a picture made several times over, to see where the time goes. */
#include "bench.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "commands.h"
#include "examples.h"
#include "progress.h"
#include "report.h"

/* Fewer than so many rounds where they take longer, unless --rounds says how many. */
enum { ROUNDS_DEFAULT = 5, SECONDS_ENOUGH = 60 };

/* What is measured without a FILE: spheres that mirror one another, the same in every version. */
static const char score_scene[] = "balls";
static const char *const score_options[] = {"--size=400x300", "--samples=16"};

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Of this process and of the import helpers that have ended. */
static double cpu_seconds(void) {
    struct rusage children;
    double sum = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
    if (getrusage(RUSAGE_CHILDREN, &children) == 0)
        sum += (double)(children.ru_utime.tv_sec + children.ru_stime.tv_sec) +
               1e-6 * (double)(children.ru_utime.tv_usec + children.ru_stime.tv_usec);
    return sum;
}

/* ---- one round ---- */

typedef struct timer {
    bench_round *round;
    double wall, cpu;
} timer;

static void end_phase(timer *t, bench_phase phase) {
    double wall = clock_seconds(CLOCK_MONOTONIC), cpu = cpu_seconds();
    t->round->wall[phase] = wall - t->wall;
    t->round->cpu[phase] = cpu - t->cpu;
    t->wall = wall;
    t->cpu = cpu;
}

static int load(session *s, const example_scene *example, const char *label, snell_scene **out) {
    if (example == NULL) return session_load(s, label, out);
    return session_load_text(s, label, example->text, example->size, out);
}

static int render_and_encode(stage *at, snell_film *film, timer *t) {
    snell_image_desc image = stage_image(at);
    void *data = NULL;
    size_t size;
    int code = stage_status(at, snell_render(at->scene, &at->desc, film));
    end_phase(t, BENCH_RENDER);
    if (code == EXIT_DONE)
        code = stage_status(at, snell_film_encode(film, "png", &image, &data, &size));
    end_phase(t, BENCH_WRITE);
    snell_free(data);
    return code;
}

/* From the file to the finished picture, which goes nowhere. */
static int make_round(bench *b, session *s, const example_scene *example) {
    bench_round *round = &b->rounds[b->round_count];
    stage at = {.options = b->options, .values = b->values, .session = s, .input = b->label};
    snell_film *film = NULL;
    timer t = {round, clock_seconds(CLOCK_MONOTONIC), cpu_seconds()};
    *round = (bench_round){.stats = {.struct_size = sizeof round->stats}};
    b->scene.struct_size = sizeof b->scene;
    int code = load(s, example, b->label, &at.scene);
    if (code == EXIT_DONE) code = stage_add_light(&at);
    end_phase(&t, BENCH_LOAD);
    if (code == EXIT_DONE) code = stage_prepare(&at);
    if (code == EXIT_DONE) code = stage_status(&at, snell_film_create(s->context, &film));
    at.desc.timed = true;
    end_phase(&t, BENCH_BUILD);
    if (code == EXIT_DONE) code = render_and_encode(&at, film, &t);
    if (code == EXIT_DONE) code = stage_status(&at, snell_film_get_stats(film, &round->stats));
    if (code == EXIT_DONE) code = stage_status(&at, snell_scene_get_stats(at.scene, &b->scene));
    if (code == EXIT_DONE) code = report_strict();
    if (code == EXIT_DONE) b->round_count++;
    b->desc = at.desc;
    if (at.desc.noise > 0) b->desc.samples = (uint32_t)round->stats.samples_done;
    b->scene.format = NULL;
    b->memory_peak = session_memory_peak(RUSAGE_SELF);
    b->memory_peak_import = session_memory_peak(RUSAGE_CHILDREN);
    snell_film_destroy(film);
    snell_scene_destroy(at.scene);
    return code;
}

/* ---- rounds ---- */

typedef struct subject {
    options options;
    render_values values;
    session session;
    bench *bench;
} subject;

static int open_subject(subject *s, const options *o, const char *const *words, size_t count,
                        const char *label) {
    *s = (subject){.bench = calloc(1, sizeof *s->bench)};
    int code = options_with(o, words, count, &s->options);
    if (code == EXIT_DONE && s->bench == NULL)
        code = report_error(EXIT_MEMORY, NULL, "out of memory");
    if (code == EXIT_DONE) code = values_read(&s->options, &s->values);
    if (code == EXIT_DONE) code = session_open(&s->session, &s->options);
    if (code != EXIT_DONE) return code;
    stage_set_frame(&s->session, &s->values, s->values.frame_first);
    s->bench->options = &s->options;
    s->bench->values = &s->values;
    s->bench->label = label;
    s->bench->threads = snell_context_thread_count(s->session.context);
    s->bench->isa = snell_context_isa(s->session.context);
    return EXIT_DONE;
}

static void close_subject(subject *s) {
    session_close(&s->session);
    options_free(&s->options);
    free(s->bench);
}

/* The subjects take turns, so that what disturbs the machine disturbs them alike. What there is to
 * say of the scene is said once. */
static int make_rounds(subject *subjects, size_t count, const example_scene *example) {
    uint64_t rounds = ROUNDS_DEFAULT;
    const options *o = &subjects[0].options;
    int code = values_read_whole(o, OPT_ROUNDS, "rounds", 1, ROUNDS_MAX, &rounds);
    double began = clock_seconds(CLOCK_MONOTONIC);
    for (size_t i = 0; i < rounds && code == EXIT_DONE; i++) {
        for (size_t k = 0; k < count && code == EXIT_DONE; k++) {
            progress_part(i * count + k, rounds * count);
            progress_begin(session_label(subjects[k].bench->label));
            code = make_round(subjects[k].bench, &subjects[k].session, example);
            progress_end();
            if (code == EXIT_DONE && signals_caught() != 0) code = EXIT_SOME_FAILED;
            report_mute(true);
        }
        bool enough = clock_seconds(CLOCK_MONOTONIC) - began > SECONDS_ENOUGH;
        if (enough && o->value[OPT_ROUNDS] == NULL) break;
    }
    report_mute(false);
    return code;
}

/* ---- the command ---- */

static int bench_file(const options *o, const char *file) {
    subject s = {.bench = NULL};
    int code = open_subject(&s, o, NULL, 0, file);
    s.session.keeps_input = true;
    if (code == EXIT_DONE) code = make_rounds(&s, 1, NULL);
    if (code == EXIT_DONE && report_json()) {
        json_t *root = bench_json(s.bench);
        json_object_set_new(root, "schema", json_integer(1));
        json_object_set_new(root, "warnings", report_take_warnings());
        code = report_emit(root, code);
    } else if (code == EXIT_DONE) {
        bench_text(s.bench);
    }
    close_subject(&s);
    return code;
}

static const example_scene *find_example(const char *name) {
    for (size_t i = 0; i < example_count; i++)
        if (strcmp(example_table[i].name, name) == 0) return &example_table[i];
    return NULL;
}

static void print_score(const bench *one, const bench *many) {
    const bench *rows[] = {one, many};
    double single = bench_rate(one).median;
    printf("%s, %s, %" PRIu32 "x%" PRIu32 ", %" PRIu32 " samples; snell %s, %s; %" PRIu32
           " round%s\n\n",
           one->label, integrator_name(one->desc.integrator), one->desc.width, one->desc.height,
           one->desc.samples, snell_version(), snell_isa_name(one->isa), one->round_count,
           one->round_count == 1 ? "" : "s, medians");
    puts("threads   Mrays/s   least..most     times    Mrays/CPU s");
    for (size_t i = 0; i < (many->round_count > 0 ? 2 : 1); i++) {
        char range[32];
        summary rate = bench_rate(rows[i]);
        snprintf(range, sizeof range, "%.2f..%.2f", rate.least, rate.most);
        printf("%7" PRIu32 "  %8.2f   %-14s  %5.2f  %13.2f\n", rows[i]->threads, rate.median, range,
               rate.median / single, bench_rate_cpu(rows[i]).median);
    }
    bench_print_advice(many->round_count > 0 ? many : one);
    puts("\n'snell bench FILE' says where the time of a picture goes.");
}

/* What decides the picture is the same on every machine. */
static int check_plain(const options *o) {
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if ((info->flags & OPTION_PICTURE) != 0 && o->given[info->id] > 0)
            return report_usage(
                "such as: snell bench duck.glb; the score's picture is always the same",
                "--%s: bench without FILE takes no options of a picture", info->name);
    }
    return EXIT_DONE;
}

static int bench_machine(const options *o) {
    const example_scene *example = find_example(score_scene);
    const char *alone[] = {score_options[0], score_options[1], "--threads=1"};
    subject s[2] = {{.bench = NULL}, {.bench = NULL}};
    int code = check_plain(o);
    if (code != EXIT_DONE) return code;
    code = open_subject(&s[0], o, alone, 3, score_scene);
    if (code == EXIT_DONE) code = open_subject(&s[1], o, score_options, 2, score_scene);
    if (code == EXIT_DONE) code = make_rounds(s, s[1].bench->threads > 1 ? 2 : 1, example);
    if (code == EXIT_DONE && report_json()) {
        json_t *runs = json_array();
        json_array_append_new(runs, bench_json(s[0].bench));
        if (s[1].bench->round_count > 0) json_array_append_new(runs, bench_json(s[1].bench));
        code = report_emit(json_pack("{s:i,s:s,s:o,s:o}", "schema", 1, "scene", score_scene, "runs",
                                     runs, "warnings", report_take_warnings()),
                           code);
    } else if (code == EXIT_DONE) {
        print_score(s[0].bench, s[1].bench);
    }
    close_subject(&s[1]);
    close_subject(&s[0]);
    return code;
}

int bench_command(const options *o) {
    if (o->operands.count > 1) return report_usage(NULL, "bench takes one FILE");
    signals_setup();
    progress_setup(o->value[OPT_PROGRESS]);
    return o->operands.count == 0 ? bench_machine(o) : bench_file(o, o->operands.items[0]);
}
