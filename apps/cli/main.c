/* snell: the command. It knows the library only by <snell/snell.h>. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "progress.h"
#include "report.h"
#include "session.h"

static int dispatch(const options *o) {
    if (o->value[OPT_VERSION] != NULL) return help_version();
    if (o->value[OPT_HELP] != NULL) return o->command == NULL ? help_main() : help_of(o->command);
    if (o->command == NULL) {
        return report_usage("snell FILE renders one; 'snell --help' tells the rest",
                            "which file, or which command?");
    }
    switch (o->command->bit) {
    case CMD_RENDER: return render_command(o);
    case CMD_EXPLAIN: return explain_command(o);
    case CMD_BENCH: return bench_command(o);
    case CMD_INFO: return info_command(o);
    case CMD_COMPARE: return compare_command(o);
    case CMD_CONVERT: return convert_command(o);
    case CMD_EXAMPLE: return example_command(o);
    default: return help_command(o);
    }
}

/* Text that could not be written is an error too: a full disk must not look like success. */
static int finish_output(int code) {
    bool lost = ferror(stdout) != 0;
    errno = 0; /* what an earlier write met is not known where this one succeeds */
    if (fflush(stdout) == 0 && !lost) return code;
    return code != EXIT_DONE ? code : report_no_output(errno);
}

int main(int argc, char **argv) {
    options o;
    int code = options_parse(argc, argv, &o);
    if (code == EXIT_DONE) {
        session_check_environment();
        code = dispatch(&o);
    }
    if (report_json() && !report_emitted() && code != EXIT_DONE) {
        json_t *root = json_object(), *error = report_take_error();
        json_object_set_new(root, "schema", json_integer(1));
        json_object_set_new(root, "error", error == NULL ? json_null() : error);
        json_object_set_new(root, "warnings", report_take_warnings());
        code = report_emit(root, code);
    }
    code = finish_output(code);
    report_begin();
    options_free(&o);
    if (signals_caught() != 0) signals_raise();
    return code;
}
