#include "progress.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "report.h"

/* A picture that takes less than this shows no progress; a line is redrawn ten times a second, and
 * one for a log comes every two. */
static const double quiet_seconds = 0.5, line_seconds = 0.1, plain_seconds = 2, json_seconds = 0.5;

enum progress_kind { PROGRESS_NONE, PROGRESS_LINE, PROGRESS_PLAIN, PROGRESS_JSON };

static struct {
    enum progress_kind kind;
    const char *label;
    double started, shown, rate_time, rate;
    uint64_t rate_rays;
    char phase[16];
    bool on_screen, active;
    size_t part, parts; /* of several pictures */
    double all_started;
} state;

static volatile sig_atomic_t caught;

static double now_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

void progress_setup(const char *when) {
    const char *word = when == NULL ? "auto" : when;
    const char *term = getenv("TERM");
    bool terminal = isatty(STDERR_FILENO) && term != NULL && strcmp(term, "dumb") != 0;
    state.kind = terminal ? PROGRESS_LINE : PROGRESS_NONE;
    if (strcmp(word, "line") == 0) state.kind = PROGRESS_LINE;
    if (strcmp(word, "plain") == 0) state.kind = PROGRESS_PLAIN;
    if (strcmp(word, "json") == 0) state.kind = PROGRESS_JSON;
    if (strcmp(word, "none") == 0) state.kind = PROGRESS_NONE;
    /* --quiet wins over what was not asked for by name. */
    if (report_level() == LEVEL_QUIET && strcmp(word, "auto") == 0) state.kind = PROGRESS_NONE;
}

void progress_begin(const char *label) {
    state.label = label;
    state.started = now_seconds();
    state.shown = state.rate_time = 0;
    state.rate = 0;
    state.rate_rays = 0;
    state.phase[0] = '\0';
    state.active = true;
}

double progress_seconds(void) { return now_seconds() - state.started; }

void progress_clear(void) {
    if (!state.on_screen) return;
    fputs("\r\033[K", stderr);
    state.on_screen = false;
}

void progress_part(size_t index, size_t count) {
    if (index == 0) state.all_started = now_seconds();
    state.part = index;
    state.parts = count;
}

/* What is said of one picture, as said of them all: reading and building count for little. */
static snell_progress of_all(const snell_progress *one, double now) {
    snell_progress all = *one;
    if (state.parts < 2) return all;
    double within = strcmp(one->phase, "render") == 0 ? one->fraction : 0;
    all.fraction = ((double)state.part + within) / (double)state.parts;
    all.seconds_left =
        all.fraction > 0.005 ? (now - state.all_started) * (1 - all.fraction) / all.fraction : -1;
    return all;
}

void progress_end(void) {
    report_lock();
    progress_clear();
    state.active = false;
    report_unlock();
}

/* Rays per second over the last half second or so. */
static void update_rate(double now, const snell_progress *p) {
    if (state.rate_time == 0 || p->rays_traced < state.rate_rays) {
        state.rate_time = now;
        state.rate_rays = p->rays_traced;
    } else if (now - state.rate_time >= 0.5) {
        state.rate = (double)(p->rays_traced - state.rate_rays) / (now - state.rate_time);
        state.rate_time = now;
        state.rate_rays = p->rays_traced;
    }
}

static void format_rate(char *out, size_t size) {
    out[0] = '\0';
    if (state.rate >= 1e6)
        snprintf(out, size, "  %.1f Mrays/s", state.rate * 1e-6);
    else if (state.rate > 0)
        snprintf(out, size, "  %.0f krays/s", state.rate * 1e-3);
}

static void format_noise(double noise, char *out, size_t size) {
    out[0] = '\0';
    if (noise > 0) snprintf(out, size, "  error %.2g %%", 100 * noise);
}

static void format_left(double seconds, char *out, size_t size) {
    out[0] = '\0';
    if (!(seconds >= 0) || seconds > 1e7) return;
    unsigned long s = (unsigned long)(seconds + 0.5);
    if (s < 3600)
        snprintf(out, size, "  %lu:%02lu left", s / 60, s % 60);
    else
        snprintf(out, size, "  %lu:%02lu h left", s / 3600, s / 60 % 60);
}

static void draw_line(const snell_progress *p, int percent) {
    struct winsize window = {0};
    int columns =
        ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
    char bar[25], rate[32], left[32], noise[32], line[256];
    int filled = percent * 24 / 100;
    for (int i = 0; i < 24; i++) bar[i] = i < filled ? '#' : '.';
    bar[24] = '\0';
    format_rate(rate, sizeof rate);
    format_left(p->seconds_left, left, sizeof left);
    format_noise(p->noise, noise, sizeof noise);
    int length = snprintf(line, sizeof line, "[%s] %3d %%  %-6s%s%s%s", bar, percent, p->phase,
                          noise, rate, left);
    if (length >= columns) line[columns - 1 < 255 ? columns - 1 : 255] = '\0';
    fprintf(stderr, "\r%s\033[K", line);
    fflush(stderr);
    state.on_screen = true;
}

static void print_plain(const snell_progress *p, int percent) {
    char rate[32], left[32], noise[32];
    format_rate(rate, sizeof rate);
    format_left(p->seconds_left, left, sizeof left);
    format_noise(p->noise, noise, sizeof noise);
    fprintf(stderr, "%s: %s %d %%%s%s%s\n", state.label, p->phase, percent, noise, rate, left);
}

static void print_json(const snell_progress *p) {
    json_t *object = json_object();
    json_object_set_new(object, "event", json_string("progress"));
    json_object_set_new(object, "file", report_text(state.label));
    json_object_set_new(object, "phase", report_text(p->phase));
    json_object_set_new(object, "fraction", json_real(p->fraction));
    json_object_set_new(object, "rays", json_integer((json_int_t)p->rays_traced));
    json_object_set_new(object, "rays_per_second", json_real(state.rate));
    json_object_set_new(object, "seconds_left",
                        p->seconds_left >= 0 ? json_real(p->seconds_left) : json_null());
    if (p->noise > 0) json_object_set_new(object, "noise", json_real(p->noise));
    json_dumpf(object, stderr, JSON_COMPACT | JSON_REAL_PRECISION(6));
    fputc('\n', stderr);
    json_decref(object);
}

static void show(const snell_progress *p, double now) {
    double fraction = p->fraction < 0 ? 0 : p->fraction > 1 ? 1 : p->fraction;
    double interval = state.kind == PROGRESS_LINE    ? line_seconds
                      : state.kind == PROGRESS_PLAIN ? plain_seconds
                                                     : json_seconds;
    bool other_phase = strcmp(state.phase, p->phase) != 0;
    if (now - state.shown < interval && !other_phase) return;
    state.shown = now;
    snprintf(state.phase, sizeof state.phase, "%s", p->phase);
    report_lock();
    if (state.kind == PROGRESS_LINE) draw_line(p, (int)(fraction * 100));
    if (state.kind == PROGRESS_PLAIN) print_plain(p, (int)(fraction * 100));
    if (state.kind == PROGRESS_JSON) print_json(p);
    report_unlock();
}

bool progress_report(void *user, const snell_progress *progress) {
    (void)user;
    if (caught != 0) return false;
    double now = now_seconds();
    if (!state.active || state.kind == PROGRESS_NONE) return true;
    update_rate(now, progress);
    snell_progress all = of_all(progress, now);
    if (now - state.started >= quiet_seconds) show(&all, now);
    return true;
}

static void on_signal(int number) { caught = number; }

/* The second signal of a kind ends the program at once (SA_RESETHAND); without SA_RESTART a read of
 * standard input is interrupted too. */
void signals_setup(void) {
    static const int numbers[] = {SIGINT, SIGTERM};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        struct sigaction action, old;
        memset(&action, 0, sizeof action);
        action.sa_handler = on_signal;
        action.sa_flags = (int)SA_RESETHAND;
        sigemptyset(&action.sa_mask);
        /* Who started us with the signal ignored (nohup, a shell's &) wants it ignored. */
        if (sigaction(numbers[i], NULL, &old) == 0 && old.sa_handler != SIG_IGN) {
            sigaction(numbers[i], &action, NULL);
        }
    }
}

int signals_caught(void) { return caught; }

void signals_raise(void) {
    int number = caught;
    fflush(NULL);
    signal(number, SIG_DFL);
    raise(number);
}
