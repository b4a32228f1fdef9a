/* The import helper under attack: its snell-import (tests/trouble) crashes, hangs, lies and tries to
 * break out, and whatever it does, the caller gets a clear error in time and loses nothing. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/thread.h"
#include "importers/importer.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

static char folder[] = "/tmp/snell-test-helper-XXXXXX";
static char scene[256];

static int set_up(void **state) {
    (void)state;
    if (mkdtemp(folder) == NULL) return -1;
    snprintf(scene, sizeof scene, "%s/scene.trouble", folder);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    char command[300];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static void write_scene(const char *word) {
    FILE *file = fopen(scene, "w");
    assert_non_null(file);
    fputs(word, file);
    assert_int_equal(fclose(file), 0);
}

static int open_files(void) {
    int count = 0;
    DIR *directory = opendir("/proc/self/fd");
    assert_non_null(directory);
    while (readdir(directory)) count++;
    closedir(directory);
    return count;
}

/* Imports the file `path`; nothing may be left over: no process, no open file, no half a scene. */
static snell_status import_path(const char *path, const helper_options *options,
                                description **kept) {
    description *d;
    int files = open_files();
    assert_int_equal(description_create(&d), SNELL_OK);
    snell_status status = helper_import(path, options, d);
    assert_int_equal(open_files(), files);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
    description_mark nothing = {0}, mark = description_get_mark(d);
    if (status) assert_memory_equal(&mark, &nothing, sizeof mark);
    if (kept)
        *kept = d;
    else
        description_destroy(d);
    return status;
}

static snell_status import_word(const char *word, const helper_options *options,
                                description **kept) {
    write_scene(word);
    return import_path(scene, options, kept);
}

static const helper_options usual = {.import = {.memory_max = 64 << 20}, .time_max = 10};

static void a_scene_comes_back(void **state) {
    (void)state;
    description *d;
    assert_int_equal(import_word("ball", &usual, &d), SNELL_OK);
    assert_non_null(description_find(d, CATEGORY_SHAPE, "ball"));
    assert_int_equal(d->instance_count, 1);
    for (size_t i = 0; i < d->message_count; i++) print_message("%s\n", d->messages[i].text);
    description_destroy(d);
    const helper_options plain = {0}; /* every limit by default */
    assert_int_equal(import_word("ball", &plain, NULL), SNELL_OK);
}

static void options_reach_the_importer(void **state) {
    (void)state;
    const char *params[] = {"--file=x y", "b=\n'"};
    helper_options options = usual;
    options.import.params = params;
    options.import.param_count = 2;
    options.import.up = "-z";
    options.import.allow_programs = true;
    description *d;
    assert_int_equal(import_word("params", &options, &d), SNELL_OK);
    assert_string_equal(d->params[0].name, "--file=x y");
    assert_string_equal(d->params[0].kind, "b=\n'");
    assert_string_equal(d->params[0].value, "-z");
    assert_string_equal(d->params[0].default_value, "yes");
    description_destroy(d);
}

static void errors_come_back_whole(void **state) {
    (void)state;
    assert_int_equal(import_word("error", &usual, NULL), SNELL_ERR_UNSUPPORTED);
    const snell_message *error = error_last();
    assert_string_equal(error->text, "a text");
    assert_string_equal(error->hint, "a hint");
    assert_string_equal(error->file, "other.file");
    assert_true(error->line == 7 && error->column == 3);
    assert_int_equal(import_word("odd-error", &usual, NULL), SNELL_ERR_SYNTAX);
    assert_null(strpbrk(error_last()->text, "\a\033"));
}

static void files_that_cannot_be_read(void **state) {
    (void)state;
    char path[300], expected[400];
    snprintf(path, sizeof path, "%s/missing", folder);
    assert_int_equal(import_path(path, &usual, NULL), SNELL_ERR_IO);
    snprintf(expected, sizeof expected, "cannot open '%s': No such file or directory", path);
    assert_string_equal(error_last()->text, expected);
    assert_int_equal(import_path(folder, &usual, NULL), SNELL_ERR_IO);
    assert_non_null(strstr(error_last()->text, "Is a directory"));
    assert_int_equal(import_word("", &usual, NULL), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "empty"));
    snprintf(path, sizeof path, "%s/pipe", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(import_path(path, &usual, NULL), SNELL_ERR_IO);
    assert_non_null(strstr(error_last()->text, "not a regular file"));
    const char *nowhere[] = {"/nowhere/at/all"};
    helper_options options = usual;
    options.import.asset_dirs = nowhere;
    options.import.asset_dir_count = 1;
    assert_int_equal(import_word("ball", &options, NULL), SNELL_ERR_IO);
    if (geteuid() == 0) {
        print_message("NOT TESTED as root: an unreadable file\n");
        return;
    }
    write_scene("ball");
    assert_int_equal(chmod(scene, 0), 0);
    assert_int_equal(import_path(scene, &usual, NULL), SNELL_ERR_IO);
    assert_int_equal(chmod(scene, 0600), 0);
}

static void crashes_are_errors(void **state) {
    (void)state;
    assert_int_equal(import_word("crash", &usual, NULL), SNELL_ERR_SYNTAX);
    if (!SANITIZED) /* whose own handler ends the program */
        assert_string_equal(error_last()->text, "the file made the reader crash (signal 11)");
    assert_string_equal(error_last()->file, scene);
    assert_int_equal(import_word("abort", &usual, NULL), SNELL_ERR_SYNTAX);
    assert_int_equal(import_word("code", &usual, NULL), SNELL_ERR_SYNTAX);
    assert_non_null(strstr(error_last()->text, "exit code 7"));
    const char *lies[] = {"silent", "half", "lie", "garbage"};
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(import_word(lies[i], &usual, NULL), SNELL_ERR_SYNTAX);
}

static void too_much_memory_is_refused(void **state) {
    (void)state;
    if (SANITIZED) {
        print_message("NOT TESTED: sanitizers need the address space\n");
        return;
    }
    assert_int_equal(import_word("allocate", &usual, NULL), SNELL_ERR_MEMORY);
    assert_string_equal(error_last()->hint,
                        "reading may use 64 MiB of memory: --memory allows more");
    helper_options tiny = usual;
    tiny.import.memory_max = 1;
    assert_int_equal(import_word("allocate", &tiny, NULL), SNELL_ERR_MEMORY);
}

static void endless_work_is_stopped(void **state) {
    (void)state;
    helper_options options = usual;
    options.time_max = 0.5; /* rounded up to a second */
    double begin = time_seconds();
    assert_int_equal(import_word("loop", &options, NULL), SNELL_ERR_SYNTAX);
    double seconds = time_seconds() - begin;
    assert_non_null(strstr(error_last()->text, "more than 1 s of processor time"));
    assert_true(seconds < 10);
}

typedef struct watch {
    int calls, stop_at;
    double last_call, longest_gap, stopped, fraction;
} watch;

static bool on_progress(void *user, double fraction) {
    watch *w = user;
    double now = time_seconds();
    if (now - w->last_call > w->longest_gap) w->longest_gap = now - w->last_call;
    w->last_call = now;
    w->fraction = fraction;
    w->stopped = now;
    return ++w->calls != w->stop_at;
}

static void cancelling_takes_effect_at_once(void **state) {
    (void)state;
    const char *words[] = {"hang", "loop", "flood"};
    for (size_t i = 0; i < 3; i++) {
        watch w = {.stop_at = 3, .last_call = time_seconds()};
        helper_options options = usual;
        options.progress = on_progress;
        options.user = &w;
        assert_int_equal(import_word(words[i], &options, NULL), SNELL_CANCELLED);
        double seconds = time_seconds() - w.stopped;
        print_message("%s: cancelled after %.1f ms, calls at most %.1f ms apart\n", words[i],
                      seconds * 1e3, w.longest_gap * 1e3);
        assert_int_equal(w.calls, 3);
        assert_true(seconds < 0.2 && w.longest_gap < 0.2);
    }
}

static void progress_is_passed_on(void **state) {
    (void)state;
    watch w = {.last_call = time_seconds()};
    helper_options options = usual;
    options.progress = on_progress;
    options.user = &w;
    assert_int_equal(import_word("progress", &options, NULL), SNELL_OK);
    assert_true(w.fraction == 0.5);
    assert_true(w.calls >= 20 && w.longest_gap < 0.2);
    assert_int_equal(import_word("much", &options, NULL), SNELL_OK);
}

static void the_walls_hold(void **state) {
    (void)state;
    /* A file that the host left open, without close-on-exec, must not be inherited. */
    int open_file = open("/etc/passwd", O_RDONLY);
    description *d;
    assert_int_equal(import_word("walls", &usual, &d), SNELL_OK);
    close(open_file);
    bool complete = d->message_count == 0; /* else a part of the sandbox is missing here */
    for (size_t i = 0; i < d->message_count; i++)
        print_message("NOT TESTED in full: %s\n", d->messages[i].text);
    assert_int_equal(d->param_count, 16);
    for (size_t i = 0; i < d->param_count; i++) {
        if (strcmp(d->params[i].value, "held") == 0) continue;
        print_error("%s got out\n", d->params[i].name);
        assert_false(complete);
    }
    description_destroy(d);
}

static void files_outside_the_folder_are_not_read(void **state) {
    (void)state;
    char path[300];
    snprintf(path, sizeof path, "%s/leak", folder);
    assert_int_equal(symlink("/etc/passwd", path), 0);
    const char *words[] = {"read ../../../../../../etc/passwd", "read /etc/passwd", "read leak"};
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(import_word(words[i], &usual, NULL), SNELL_ERR_IO);
        assert_non_null(strstr(error_last()->text, "Permission denied"));
        assert_non_null(strstr(error_last()->hint, "--allow DIR"));
    }
    const char *folders[] = {"/etc"};
    helper_options options = usual;
    options.import.asset_dirs = folders;
    options.import.asset_dir_count = 1;
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(import_word(words[i], &options, NULL), SNELL_OK);
    /* A scene that is itself a link is read. */
    char link[300], target[300];
    snprintf(target, sizeof target, "%s/elsewhere", folder);
    assert_int_equal(mkdir(target, 0700), 0);
    snprintf(target, sizeof target, "%s/elsewhere/scene", folder);
    write_scene("ball");
    assert_int_equal(rename(scene, target), 0);
    snprintf(link, sizeof link, "%s/elsewhere/deeper", folder);
    assert_int_equal(mkdir(link, 0700), 0);
    snprintf(link, sizeof link, "%s/elsewhere/deeper/link", folder);
    assert_int_equal(symlink(target, link), 0);
    assert_int_equal(import_path(link, &usual, NULL), SNELL_OK);
}

static void hosts_that_ignore_children(void **state) {
    (void)state;
    struct sigaction ignore = {.sa_handler = SIG_IGN}, old;
    assert_int_equal(sigaction(SIGCHLD, &ignore, &old), 0);
    snell_status ball = import_word("ball", &usual, NULL),
                 crash = import_word("crash", &usual, NULL),
                 silent = import_word("silent", &usual, NULL);
    watch w = {.stop_at = 2, .last_call = time_seconds()};
    helper_options options = usual;
    options.progress = on_progress;
    options.user = &w;
    snell_status hang = import_word("hang", &options, NULL);
    assert_int_equal(sigaction(SIGCHLD, &old, NULL), 0);
    assert_int_equal(ball, SNELL_OK);
    assert_int_equal(crash, SNELL_ERR_SYNTAX);
    assert_int_equal(silent, SNELL_ERR_SYNTAX);
    assert_int_equal(hang, SNELL_CANCELLED);
}

static void hosts_with_few_open_files(void **state) {
    (void)state;
    /* 0, 1 and 2 closed: the channels must not land there. Output is restored before asserting. */
    int saved[3];
    for (int i = 0; i < 3; i++) saved[i] = fcntl(i, F_DUPFD_CLOEXEC, 20);
    write_scene("ball");
    description *d;
    snell_status made = description_create(&d);
    for (int i = 0; i < 3; i++) close(i);
    snell_status status = made ? made : helper_import(scene, &usual, d);
    for (int i = 0; i < 3; i++) {
        if (saved[i] < 0) continue;
        dup2(saved[i], i);
        close(saved[i]);
    }
    assert_int_equal(status, SNELL_OK);
    description_destroy(d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_comes_back),
        cmocka_unit_test(options_reach_the_importer),
        cmocka_unit_test(errors_come_back_whole),
        cmocka_unit_test(files_that_cannot_be_read),
        cmocka_unit_test(crashes_are_errors),
        cmocka_unit_test(too_much_memory_is_refused),
        cmocka_unit_test(endless_work_is_stopped),
        cmocka_unit_test(cancelling_takes_effect_at_once),
        cmocka_unit_test(progress_is_passed_on),
        cmocka_unit_test(the_walls_hold),
        cmocka_unit_test(files_outside_the_folder_are_not_read),
        cmocka_unit_test(hosts_that_ignore_children),
        cmocka_unit_test(hosts_with_few_open_files),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
