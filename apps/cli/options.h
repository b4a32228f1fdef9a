/* The one table of options. The parser, the --help texts, the man pages and the completion scripts
 * are made from it; tests/test_cli.sh compares them. */
#ifndef SNELL_CLI_OPTIONS_H
#define SNELL_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum option_id {
    OPT_OUTPUT,
    OPT_FORMAT,
    OPT_FORCE,
    OPT_STRIP,
    OPT_BITS,
    OPT_QUALITY,
    OPT_CHROMA,
    OPT_AOV,
    OPT_ERROR,
    OPT_ERROR_MAP,
    OPT_LAYER,
    OPT_SIZE,
    OPT_CROP,
    OPT_EXPOSURE,
    OPT_TONEMAP,
    OPT_WHITE_BALANCE,
    OPT_BACKGROUND,
    OPT_CAMERA,
    OPT_VIEW,
    OPT_FOV,
    OPT_UP,
    OPT_LIGHT,
    OPT_GROUND,
    OPT_INTEGRATOR,
    OPT_SAMPLES,
    OPT_NOISE,
    OPT_TIME_LIMIT,
    OPT_MAX_DEPTH,
    OPT_MIN_WEIGHT,
    OPT_SEED,
    OPT_FILTER,
    OPT_FILTER_RADIUS,
    OPT_FRAME,
    OPT_FRAMES,
    OPT_FPS,
    OPT_TURNTABLE,
    OPT_SET,
    OPT_ALLOW,
    OPT_INPUT_FORMAT,
    OPT_MAX_FLIP,
    OPT_MAX_RMSE,
    OPT_MAX_REL_MSE,
    OPT_MIN_PSNR,
    OPT_MAX_DIFFERENCE,
    OPT_MAX_DIFFERING,
    OPT_MAX_REJECTED,
    OPT_PPD,
    OPT_VARIANCE_COUNT,
    OPT_THREADS,
    OPT_MEMORY,
    OPT_ISA,
    OPT_BUILD,
    OPT_NO_BUILD,
    OPT_PROGRESS,
    OPT_ROUNDS,
    OPT_SAMPLE,
    OPT_LEVELS,
    OPT_DOT,
    OPT_SVG,
    OPT_MAN,
    OPT_COMPLETION,
    OPT_LIST,
    OPT_HELP,
    OPT_QUIET,
    OPT_VERBOSE,
    OPT_JSON,
    OPT_STRICT,
    OPT_COLOR,
    OPT_VERSION,
    OPT_COUNT
} option_id;

enum command_bits {
    CMD_RENDER = 1,
    CMD_INFO = 2,
    CMD_EXAMPLE = 4,
    CMD_HELP = 8,
    CMD_COMPARE = 16,
    CMD_CONVERT = 32,
    CMD_EXPLAIN = 64,
    CMD_BENCH = 128,
    /* those that take what decides a picture */
    CMD_PICTURE = CMD_RENDER | CMD_EXPLAIN | CMD_BENCH,
    CMD_ALL = 255
};

enum option_flags {
    OPTION_HIDDEN = 1,         /* an alias: works, but no text mentions it */
    OPTION_OPTIONAL_VALUE = 2, /* the value, if any, follows '=' */
    OPTION_REPEATS = 4,        /* every value counts, not just the last */
    OPTION_PICTURE = 8         /* decides the picture: goes into its tag */
};

typedef struct option_info {
    option_id id;
    const char *name;                     /* without the dashes */
    char letter;                          /* 0: none */
    const char *metavar, *initial, *help; /* metavar NULL: a switch; initial: the default as text */
    const char *group;                    /* heading in the help text */
    unsigned commands, flags;
    const char *values; /* "a|b|c" for a choice, "@file", "@folder", or NULL */
    bool open;          /* other values than `values` are fine too */
} option_info;

typedef struct command_info {
    unsigned bit;
    const char *name, *operands, *summary, *about, *notes, *examples;
} command_info;

typedef struct string_list {
    const char **items;
    size_t count;
} string_list;

typedef struct options {
    const command_info *command;      /* NULL: none was named */
    const char *value[OPT_COUNT];     /* the last one given; NULL: not given; "" for a switch */
    unsigned given[OPT_COUNT];        /* how often */
    string_list set, allow, operands; /* pointers into argv */
} options;

extern const option_info option_table[];
extern const size_t option_table_count;
extern const command_info command_table[];
extern const size_t command_table_count;

/* Returns the exit code: 0, or 2 after an error was reported. `out` is filled as far as parsing
 * came, so that --json and --color are known even then. */
int options_parse(int argc, char **argv, options *out);
void options_free(options *o);
/* A copy that takes more options, each one word such as "--size=3x3"; borrowed. Exit code; it is to be
 * freed whatever that is. */
int options_with(const options *o, const char *const *words, size_t count, options *out);
const option_info *option_find(const char *name, size_t length);
const command_info *command_find(const char *name);
bool option_belongs(const option_info *info, const command_info *command);

#endif
