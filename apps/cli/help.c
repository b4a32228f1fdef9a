/* Help texts, made from the tables of options, commands, topics and types. */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "report.h"
#include "text.h"

enum { WIDTH = 79, MAIN_COLUMN = 22, OPTION_COLUMN = 24 };

/* ---- options ---- */

/* The default stands at the right edge of the last line, or on one of its own. */
static void print_option(const option_info *info, size_t start) {
    char head[64], initial[96] = "";
    if (info->letter != 0)
        snprintf(head, sizeof head, "  -%c, --%s", info->letter, info->name);
    else
        snprintf(head, sizeof head, "      --%s", info->name);
    size_t used = strlen(head);
    if (info->metavar != NULL) {
        bool optional = (info->flags & OPTION_OPTIONAL_VALUE) != 0;
        snprintf(head + used, sizeof head - used, optional ? "[=%s]" : " %s", info->metavar);
    }
    if (info->initial != NULL) snprintf(initial, sizeof initial, "[%s]", info->initial);
    printf("%-*s", (int)start, head);
    if (strlen(head) >= start) printf("\n%*s", (int)start, "");
    size_t column = start;
    column = text_print_wrapped(stdout, info->help, column, start, WIDTH);
    if (info->initial != NULL) {
        size_t length = strlen(initial);
        if (column + 1 + length > WIDTH) {
            putchar('\n');
            column = 0;
        }
        printf("%*s", (int)(WIDTH - column), initial);
    }
    putchar('\n');
}

static void print_options(const command_info *command) {
    const char *group = "";
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if (!option_belongs(info, command) || (info->flags & OPTION_HIDDEN) != 0) continue;
        if (info->commands == CMD_ALL && command != NULL) continue;
        if (strcmp(group, info->group) != 0)
            printf("\n%s%s\n", info->group, command == NULL ? ":" : "");
        group = info->group;
        print_option(info, command == NULL ? MAIN_COLUMN : OPTION_COLUMN);
    }
}

static void print_paragraph(const char *text) {
    text_print_wrapped(stdout, text, 0, 0, WIDTH);
    putchar('\n');
}

static void print_indented(const char *text) {
    fputs("  ", stdout);
    text_print_wrapped(stdout, text, 2, 2, 200);
    putchar('\n');
}

int help_of(const command_info *command) {
    const char *rest = strchr(command->about, '\n');
    size_t first = rest != NULL ? (size_t)(rest - command->about) : strlen(command->about);
    printf("snell %s - %.*s\n\nUsage: snell %s %s [OPTION...]\n", command->name, (int)first,
           command->about, command->name, command->operands);
    if (rest != NULL) {
        putchar('\n');
        print_paragraph(rest + 1);
    }
    print_options(command);
    puts("\nCommon: -h -q -v --json --strict --color -V     ('snell --help')");
    if (command->notes != NULL) {
        putchar('\n');
        print_paragraph(command->notes);
    }
    puts("\nExamples");
    print_indented(command->examples);
    if ((command->bit & CMD_PICTURE) != 0) {
        puts("\nThe fields of render{} in a scene: 'snell help settings'");
    }
    return EXIT_DONE;
}

int help_main(void) {
    puts("snell - a ray tracer: give it a model or a scene, get a picture\n\n"
         "Usage:\n"
         "  snell FILE [OPTION...]              short for: snell render FILE\n"
         "  snell COMMAND [OPTION...] [FILE...]\n\n"
         "Commands:");
    for (size_t i = 0; i < command_table_count; i++) {
        char head[64];
        const command_info *command = &command_table[i];
        const char *operands = command->operands, *rest = strstr(operands, " [");
        size_t length = rest != NULL ? (size_t)(rest - operands) : strlen(operands);
        snprintf(head, sizeof head, "  %s %.*s", command->name, (int)length, operands);
        printf("%-22s%s\n", head, command->summary);
    }
    char topics[512] = "topics: ";
    for (size_t i = 0; i < help_topic_count; i++) {
        size_t used = strlen(topics);
        if (help_topics[i].word) continue;
        snprintf(topics + used, sizeof topics - used, "%s, ", help_topics[i].name);
    }
    size_t used = strlen(topics);
    snprintf(topics + used, sizeof topics - used,
             "or any one name, such as 'dielectric' or 'roughness'");
    printf("%*s", MAIN_COLUMN, "");
    text_print_wrapped(stdout, topics, MAIN_COLUMN, MAIN_COLUMN, WIDTH);
    putchar('\n');
    print_options(NULL);
    puts("\nStart here:\n"
         "  snell duck.glb                              writes duck.png\n"
         "  snell duck.glb -o duck.exr --size 1920x1080\n"
         "  snell example whitted-1980 > my.lua\n"
         "  snell my.lua\n"
         "  snell info my.png                           how it was made\n"
         "  snell explain my.png 400 300                the rays behind that pixel\n\n"
         "FILE is glTF, OBJ, PLY, STL, a Lua scene or another of 'snell help formats';\n"
         "'-' is standard input. A first word with a '.' or '/' in it is a FILE.\n"
         "Pictures and text asked for go to standard output, everything else to standard\n"
         "error. A setting on the command line beats the scene's own, which beats the\n"
         "default; there is no configuration file.\n\n"
         "Exit: 0 done, 1 differs or some files failed, 2 wrong command line,\n"
         "3 wrong input, 4 unsupported, 5 read/write, 6 memory ('snell help exit').\n"
         "Manual: man snell, man 5 snell-scene");
    return EXIT_DONE;
}

/* ---- version ---- */

static void cpu_features(char *out, size_t size) {
    out[0] = '\0';
#if defined(__x86_64__)
    const struct {
        const char *name;
        int present;
    } rows[] = {{"sse4.2", __builtin_cpu_supports("sse4.2")},
                {"avx", __builtin_cpu_supports("avx")},
                {"avx2", __builtin_cpu_supports("avx2")},
                {"fma", __builtin_cpu_supports("fma")},
                {"avx512f", __builtin_cpu_supports("avx512f")},
                {"avx512vl", __builtin_cpu_supports("avx512vl")},
                {"avx512dq", __builtin_cpu_supports("avx512dq")},
                {"avx512bw", __builtin_cpu_supports("avx512bw")}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        size_t used = strlen(out);
        if (rows[i].present) {
            snprintf(out + used, size - used, "%s%s", used > 0 ? " " : "", rows[i].name);
        }
    }
#endif
}

#if defined(__clang__)
#define TEXT(x) #x
#define NUMBER(x) TEXT(x)
#define COMPILER                                                                                   \
    "clang " NUMBER(__clang_major__) "." NUMBER(__clang_minor__) "." NUMBER(__clang_patchlevel__)
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "unknown compiler"
#endif

int help_version(void) {
    char cpu[160];
    const char *missing = "", *parts = snell_features(&missing), *isa = "unknown";
    uint32_t threads = 0;
    snell_context *context = NULL;
    cpu_features(cpu, sizeof cpu);
    if (snell_context_create(NULL, &context) == SNELL_OK) {
        isa = snell_isa_name(snell_context_isa(context));
        threads = snell_context_thread_count(context);
    }
    snell_context_destroy(context);
    if (report_json()) {
        json_t *root = json_object();
        json_object_set_new(root, "schema", json_integer(1));
        json_object_set_new(root, "version", report_text(snell_version()));
        json_object_set_new(root, "build", report_text(SNELL_BUILD_TYPE));
        json_object_set_new(root, "compiler", report_text(COMPILER));
        json_object_set_new(root, "isa", report_text(isa));
        json_object_set_new(root, "cpu", report_text(cpu));
        json_object_set_new(root, "threads", json_integer(threads));
        json_object_set_new(root, "parts", report_text(parts));
        json_object_set_new(root, "missing", report_text(missing == NULL ? "" : missing));
        return report_emit(root, EXIT_DONE);
    }
    printf("snell %s\n", snell_version());
    printf("build    %s, %s\n", SNELL_BUILD_TYPE, COMPILER);
    printf("kernels  %s (CPU: %s)\n", isa, cpu);
    printf("threads  %u\n", (unsigned)threads);
    printf("parts    %s\n", parts);
    if (missing != NULL && missing[0] != '\0') printf("missing  %s\n", missing);
    return EXIT_DONE;
}

/* ---- topics ---- */

/* Name and kind, what values it may have, the default at the right edge; then what it is. */
static void print_field(const snell_field_info *f) {
    char facts[256], initial[128] = "";
    const char *const more[] = {f->range, f->unit};
    snprintf(facts, sizeof facts, "  %-20s  %s", f->name, f->kind);
    for (size_t i = 0; i < sizeof more / sizeof more[0]; i++) {
        size_t used = strlen(facts);
        if (more[i][0] == '\0') continue;
        snprintf(facts + used, sizeof facts - used, ", ");
        /* A choice reads "a | b". */
        for (const char *c = more[i]; *c != '\0'; c++) {
            used = strlen(facts);
            snprintf(facts + used, sizeof facts - used, *c == '|' ? " | " : "%c", *c);
        }
    }
    if (f->default_value[0] != '\0') snprintf(initial, sizeof initial, "[%s]", f->default_value);
    if (f->required) snprintf(initial, sizeof initial, "required");
    size_t column = strlen(facts), length = strlen(initial);
    const char *rest = facts, *bar = column > WIDTH ? facts + WIDTH : facts;
    while (bar > facts && *bar != '|') bar--;
    if (bar > facts) { /* many words: the last ones on a line of their own */
        printf("%.*s\n%*s", (int)(bar - facts + 1), facts, MAIN_COLUMN + 1, "");
        rest = bar + 1;
        column = MAIN_COLUMN + 1 + strlen(rest);
    }
    fputs(rest, stdout);
    if (length > 0) {
        bool fits = column + 1 + length <= WIDTH;
        if (!fits) putchar('\n');
        printf("%*s", (int)(WIDTH - (fits ? column : 0)), initial);
    }
    printf("\n%*s", MAIN_COLUMN + 2, "");
    text_print_wrapped(stdout, f->help, MAIN_COLUMN + 2, MAIN_COLUMN + 2, WIDTH);
    putchar('\n');
}

static void print_type(uint32_t type, const snell_type_info *info) {
    const char *note = help_note(info), *common = help_common_fields(info->category);
    printf("%s (%s) - %s\n\n", info->name, info->category, info->help);
    if (note != NULL) {
        print_paragraph(note);
        putchar('\n');
    }
    snell_field_info field;
    for (uint32_t i = 0; i < info->field_count; i++) {
        if (snell_type_get_field(type, i, &field) == SNELL_OK) print_field(&field);
    }
    if (info->field_count == 0) puts("  it has no fields of its own");
    if (common != NULL) {
        printf("\nand, as every %s: %s ('snell help %ss')\n", info->category, common,
               info->category);
    }
}

static bool print_types_named(const char *name) {
    bool found = false;
    snell_type_info info;
    for (uint32_t i = 0; i < snell_type_count(); i++) {
        if (snell_type_get(i, &info) != SNELL_OK || strcmp(info.name, name) != 0) continue;
        if (found) putchar('\n');
        print_type(i, &info);
        found = true;
    }
    return found;
}

/* ---- fields by their names ---- */

static bool find_field(uint32_t type, const char *name, snell_type_info *info,
                       snell_field_info *out) {
    if (snell_type_get(type, info) != SNELL_OK) return false;
    for (uint32_t i = 0; i < info->field_count; i++)
        if (snell_type_get_field(type, i, out) == SNELL_OK && strcmp(out->name, name) == 0)
            return true;
    return false;
}

/* What the library says lives until it is asked again. */
typedef struct kept_field {
    snell_field_info field;
    char initial[128], range[512];
} kept_field;

static void keep(const snell_field_info *field, kept_field *out) {
    out->field = *field;
    snprintf(out->initial, sizeof out->initial, "%s", field->default_value);
    snprintf(out->range, sizeof out->range, "%s", field->range);
    out->field.default_value = out->initial;
    out->field.range = out->range;
}

static bool same_field(const snell_field_info *a, const snell_field_info *b) {
    return strcmp(a->kind, b->kind) == 0 && strcmp(a->default_value, b->default_value) == 0 &&
           strcmp(a->range, b->range) == 0 && strcmp(a->unit, b->unit) == 0 &&
           strcmp(a->help, b->help) == 0 && a->required == b->required;
}

/* Once for all types in which it is the same: their names, then what it is. */
static bool print_fields_named(const char *name) {
    snell_type_info info;
    snell_field_info other;
    kept_field kept;
    bool found = false;
    for (uint32_t i = 0; i < snell_type_count(); i++) {
        if (!find_field(i, name, &info, &other)) continue;
        keep(&other, &kept);
        bool known = false;
        for (uint32_t k = 0; k < i && !known; k++)
            known = find_field(k, name, &info, &other) && same_field(&kept.field, &other);
        if (known) continue;
        char types[1024] = "in";
        const char *category = "";
        for (uint32_t k = i; k < snell_type_count(); k++) {
            if (!find_field(k, name, &info, &other) || !same_field(&kept.field, &other)) continue;
            size_t used = strlen(types);
            bool first = strcmp(category, info.category) != 0;
            snprintf(types + used, sizeof types - used, "%s %s%s%s", k > i ? "," : "",
                     first ? info.category : "", first ? " " : "", info.name);
            category = info.category;
        }
        if (found) putchar('\n');
        print_paragraph(types);
        print_field(&kept.field);
        found = true;
    }
    return found;
}

/* ---- all types of a category ---- */

/* All of them with their fields. */
static void print_types_of(const char *category) {
    bool first = true;
    snell_type_info info;
    for (uint32_t i = 0; i < snell_type_count(); i++) {
        if (snell_type_get(i, &info) != SNELL_OK || strcmp(info.category, category) != 0) continue;
        if (!first) putchar('\n');
        first = false;
        print_type(i, &info);
    }
}

static void print_category(const char *category) {
    snell_type_info info;
    for (uint32_t i = 0; i < snell_type_count(); i++) {
        if (snell_type_get(i, &info) != SNELL_OK || strcmp(info.category, category) != 0) continue;
        printf("  %-18s  ", info.name);
        text_print_wrapped(stdout, info.help, 22, 22, WIDTH);
        putchar('\n');
    }
    printf("\n'snell help NAME' tells the fields of one.\n");
}

static void print_formats(void) {
    const char *description = "", *name;
    for (uint32_t i = 0; (name = snell_formats(i, &description)) != NULL; i++) {
        printf("  %-10s  %s\n", name, description == NULL ? "" : description);
    }
    puts("\nand others that libassimp reads, by their extension. Without a known extension\n"
         "the content decides; --input-format names the format of a wrong one.");
    puts("\nPictures and animations are written as\n");
    snell_picture_format_info format = {.struct_size = sizeof format};
    for (uint32_t i = 0; snell_picture_format(i, &format); i++)
        printf("  %-10s  %s%s%s\n", format.extension, format.help,
               format.picture && format.animation ? "; also animated" : "",
               format.built ? "" : " (not in this build)");
    puts("\n--bits 16 makes a .png of 16 bits and an .exr of half floats. Animations take all\n"
         "frames of --frames or --turntable; a .y4m may go to standard output, into a video\n"
         "encoder: it is BT.709, limited range, 4:2:0 or with --chroma 444 4:4:4.");
}

int help_aovs(void) {
    const char *help, *channels, *name;
    for (uint32_t i = 0; (name = snell_aov_name(i, &channels, &help)) != NULL; i++) {
        printf("  %-16s  ", name);
        text_print_wrapped(stdout, help, 20, 20, WIDTH);
        const char *last = strrchr(channels, ' ');
        size_t first = strcspn(channels, " ");
        if (last != NULL && strlen(channels) > 50)
            printf("\n%20s%.*s ..%s\n", "", (int)first, channels, last);
        else
            printf("\n%20s%s\n", "", channels);
    }
    return EXIT_DONE;
}

static void print_topic(const help_topic *topic) {
    printf("%s - %s\n\n", topic->name, topic->title);
    if (topic->text != NULL) puts(topic->text);
    if (topic->text != NULL && topic->category != NULL) putchar('\n');
    if (topic->category != NULL && strcmp(topic->category, "setting") == 0)
        print_types_of(topic->category);
    else if (topic->category != NULL)
        print_category(topic->category);
    if (strcmp(topic->name, "formats") == 0) print_formats();
    if (strcmp(topic->name, "aovs") == 0) help_aovs();
}

static int unknown_topic(const char *word) {
    const char *names[1024];
    size_t count = 0;
    snell_type_info info;
    snell_field_info field;
    char hint[160] = "'snell --help' lists the topics";
    for (size_t i = 0; i < command_table_count; i++) names[count++] = command_table[i].name;
    for (size_t i = 0; i < help_topic_count; i++) names[count++] = help_topics[i].name;
    for (uint32_t i = 0; i < snell_type_count() && count < 512; i++) {
        if (snell_type_get(i, &info) == SNELL_OK) names[count++] = info.name;
    }
    for (uint32_t i = 0; i < snell_type_count(); i++)
        for (uint32_t k = 0; snell_type_get_field(i, k, &field) == SNELL_OK && count < 1024; k++)
            names[count++] = field.name;
    const char *near = text_closest(word, names, count);
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean 'snell help %s'?", near);
    return report_usage(hint, "there is no help on '%s'", word);
}

static bool explain_page(const char *word) {
    if (print_types_named(word)) return true;
    const help_topic *topic = help_find_topic(word);
    if (topic != NULL) print_topic(topic);
    return topic != NULL;
}

static int explain(const char *word) {
    const command_info *command = command_find(word);
    if (command != NULL) return help_of(command);
    bool found = explain_page(word) || print_fields_named(word);
    const char *page;
    for (size_t i = 0; (page = help_find_synonym(word, i)) != NULL; i++) {
        if (found) putchar('\n');
        if (explain_page(page)) found = true;
    }
    return found ? EXIT_DONE : unknown_topic(word);
}

/* One line an option: command, name, letter, metavar, whether an alias; for scripts and tests. */
static int list_options(void) {
    for (size_t c = 0; c < command_table_count; c++) {
        for (size_t i = 0; i < option_table_count; i++) {
            const option_info *info = &option_table[i];
            if (!option_belongs(info, &command_table[c])) continue;
            printf("%s --%s -%c %s %s\n", command_table[c].name, info->name,
                   info->letter != 0 ? info->letter : '-',
                   info->metavar != NULL ? info->metavar : "-",
                   (info->flags & OPTION_HIDDEN) != 0 ? "alias" : "-");
        }
    }
    return EXIT_DONE;
}

int help_command(const options *o) {
    if (o->value[OPT_MAN] != NULL) return man_print(o->value[OPT_MAN]);
    if (o->value[OPT_COMPLETION] != NULL) return completion_print(o->value[OPT_COMPLETION]);
    if (o->value[OPT_LIST] != NULL) return list_options();
    if (o->operands.count == 0) return help_main();
    if (o->operands.count > 1) return report_usage(NULL, "help takes one TOPIC");
    return explain(o->operands.items[0]);
}
