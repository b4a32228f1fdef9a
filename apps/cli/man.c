/* Manual pages in roff (man macros), from the same tables as the help texts. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include <snell/snell.h>

#include "commands.h"
#include "report.h"

/* Text of ours for roff: backslashes, dashes, and dots or quotes that begin a line. */
static void put_text(const char *text) {
    bool line_start = true;
    for (const char *c = text; *c != '\0'; c++) {
        if (line_start && (*c == '.' || *c == '\'')) fputs("\\&", stdout);
        line_start = *c == '\n';
        if (*c == '\\')
            fputs("\\e", stdout);
        else if (*c == '-')
            fputs("\\-", stdout);
        else if (*c == '\'')
            fputs("\\(aq", stdout);
        else if (*c == '~')
            fputs("\\(ti", stdout);
        else if (*c == '^')
            fputs("\\(ha", stdout);
        else
            putchar(*c);
    }
}

static void put_line(const char *text) {
    put_text(text);
    putchar('\n');
}

static void put_header(const char *name, const char *section, const char *summary) {
    char title[64];
    size_t i = 0;
    for (; name[i] != '\0' && i + 1 < sizeof title; i++) {
        title[i] = (char)toupper((unsigned char)name[i]);
    }
    title[i] = '\0';
    printf(".\\\" Made by snell help --man; do not edit.\n.TH \"%s\" \"%s\" \"\" \"snell %s\"\n",
           title, section, snell_version());
    puts(".SH NAME");
    put_text(name);
    fputs(" \\- ", stdout);
    put_line(summary);
}

static void put_literal(const char *text) {
    puts(".PP\n.nf");
    put_line(text);
    puts(".fi");
}

static void put_option(const option_info *info) {
    puts(".TP");
    if (info->letter != 0) printf("\\fB\\-%c\\fR, ", info->letter);
    fputs("\\fB\\-\\-", stdout);
    put_text(info->name);
    fputs("\\fR", stdout);
    if (info->metavar != NULL) {
        bool optional = (info->flags & OPTION_OPTIONAL_VALUE) != 0;
        fputs(optional ? "[=\\fI" : " \\fI", stdout);
        put_text(info->metavar);
        fputs(optional ? "\\fR]" : "\\fR", stdout);
    }
    putchar('\n');
    if (info->help[0] != '\0') put_line(info->help);
    if (info->initial != NULL) {
        fputs("[", stdout);
        put_text(info->initial);
        puts("]");
    }
}

static void put_options(const command_info *command) {
    const char *group = "";
    puts(".SH OPTIONS");
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if (!option_belongs(info, command) || (info->flags & OPTION_HIDDEN) != 0) continue;
        if (strcmp(group, info->group) != 0) {
            fputs(".SS \"", stdout);
            put_text(info->group);
            puts("\"");
        }
        group = info->group;
        put_option(info);
    }
}

static void put_tail(void) {
    puts(".SH ENVIRONMENT");
    put_literal(help_find_topic("environment")->text);
    puts(".SH EXIT STATUS");
    put_literal(help_find_topic("exit")->text);
}

static void put_see_also(void) {
    puts(".SH SEE ALSO");
    fputs(".BR snell (1)", stdout);
    for (size_t i = 0; i < command_table_count; i++) {
        printf(",\n.BR snell\\-%s (1)", command_table[i].name);
    }
    puts(",\n.BR snell\\-scene (5)");
}

static void man_main(void) {
    put_header("snell", "1", "a ray tracer: give it a model or a scene, get a picture");
    puts(".SH SYNOPSIS\n.B snell\n.I FILE\n.RI [ OPTION... ]\n.br\n.B snell\n.I COMMAND\n"
         ".RI [ OPTION... ]\n.RI [ FILE... ]");
    puts(".SH DESCRIPTION");
    put_line("snell FILE is short for snell render FILE. FILE is glTF, OBJ, PLY, STL, a Lua scene "
             "or another of the formats that 'snell help formats' lists; '-' is standard input. A "
             "first word with a dot or a slash in it is a FILE. Pictures and text asked for go to "
             "standard output, everything else to standard error. A setting on the command line "
             "beats the scene's own, which beats the default.");
    puts(".SH COMMANDS");
    for (size_t i = 0; i < command_table_count; i++) {
        const command_info *command = &command_table[i];
        printf(".TP\n.BI \"%s \" \"", command->name);
        put_text(command->operands);
        puts("\"");
        put_line(command->summary);
    }
    put_options(NULL);
    put_tail();
    put_see_also();
}

static void man_command(const command_info *command) {
    char name[32];
    const char *rest = strchr(command->about, '\n');
    snprintf(name, sizeof name, "snell-%s", command->name);
    put_header(name, "1", command->summary);
    printf(".SH SYNOPSIS\n.B snell %s\n.I ", command->name);
    put_text(command->operands);
    puts("\n.RI [ OPTION... ]\n.SH DESCRIPTION");
    put_line(rest != NULL ? rest + 1 : command->about);
    put_options(command);
    if (command->notes != NULL) {
        puts(".SH NOTES");
        put_line(command->notes);
    }
    puts(".SH EXAMPLES");
    put_literal(command->examples);
    put_tail();
    put_see_also();
}

static void put_type(uint32_t index, const snell_type_info *info) {
    fputs(".SS \"", stdout);
    put_text(info->name);
    puts("\"");
    put_line(info->help);
    const char *note = help_note(info);
    if (note != NULL) {
        puts(".br");
        put_line(note);
    }
    for (uint32_t i = 0; i < info->field_count; i++) {
        snell_field_info field;
        if (snell_type_get_field(index, i, &field) != SNELL_OK) continue;
        fputs(".TP\n\\fB", stdout);
        put_text(field.name);
        fputs("\\fR (", stdout);
        put_text(field.kind);
        const char *facts[] = {field.unit, field.range};
        for (size_t k = 0; k < 2; k++) {
            if (facts[k][0] != '\0') fputs("; ", stdout);
            put_text(facts[k]);
        }
        puts(")");
        put_line(field.help);
        if (field.required) puts("(required)");
        if (field.default_value[0] != '\0') {
            fputs("[", stdout);
            put_text(field.default_value);
            puts("]");
        }
    }
}

/* snell-scene(5): the language, every type by category, and its other words. */
static void man_scene(void) {
    put_header("snell-scene", "5", "the scene language of snell");
    puts(".SH DESCRIPTION");
    put_literal(help_find_topic("scene")->text);
    for (size_t t = 0; t < help_topic_count; t++) {
        const help_topic *topic = &help_topics[t];
        if (topic->category == NULL && !topic->word && strcmp(topic->name, "units") != 0) continue;
        fputs(".SH ", stdout);
        for (const char *c = topic->name; *c != '\0'; c++) putchar(toupper((unsigned char)*c));
        putchar('\n');
        put_literal(topic->text);
        for (uint32_t i = 0; topic->category != NULL && i < snell_type_count(); i++) {
            snell_type_info info;
            if (snell_type_get(i, &info) != SNELL_OK) continue;
            if (strcmp(info.category, topic->category) == 0) put_type(i, &info);
        }
    }
    put_see_also();
}

int man_print(const char *page) {
    if (strcmp(page, "snell") == 0)
        man_main();
    else if (strcmp(page, "scene") == 0)
        man_scene();
    else
        man_command(command_find(page));
    return EXIT_DONE;
}
