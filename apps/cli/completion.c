/* Completion scripts for bash, zsh and fish, from the table of options. */
#include <stdio.h>
#include <string.h>

#include <snell/snell.h>

#include "commands.h"
#include "report.h"

static bool shown(const option_info *info, const command_info *command) {
    return option_belongs(info, command) && (info->flags & OPTION_HIDDEN) == 0;
}

/* "a|b|c" as "a b c". */
static void put_words(const char *choices) {
    for (const char *c = choices; *c != '\0'; c++) putchar(*c == '|' ? ' ' : *c);
}

static bool has_choices(const option_info *info) {
    return info->values != NULL && info->values[0] != '@';
}

static void put_topics(void) {
    snell_type_info type;
    for (size_t i = 0; i < command_table_count; i++) printf(" %s", command_table[i].name);
    for (size_t i = 0; i < help_topic_count; i++) printf(" %s", help_topics[i].name);
    for (uint32_t i = 0; i < snell_type_count(); i++) {
        if (snell_type_get(i, &type) == SNELL_OK) printf(" %s", type.name);
    }
}

static void put_examples(void) {
    for (size_t i = 0; example_name(i) != NULL; i++) printf(" %s", example_name(i));
}

/* ---- bash ---- */

static void bash_values(void) {
    puts("    case $prev in");
    for (size_t i = 0; i < option_table_count; i++) {
        const option_info *info = &option_table[i];
        if ((info->flags & OPTION_HIDDEN) != 0 || info->metavar == NULL ||
            (info->flags & OPTION_OPTIONAL_VALUE) != 0) {
            continue;
        }
        printf("    --%s", info->name);
        if (info->letter != 0) printf("|-%c", info->letter);
        fputs(") ", stdout);
        if (has_choices(info)) {
            fputs("COMPREPLY=($(compgen -W '", stdout);
            put_words(info->values);
            fputs("' -- \"$cur\"));", stdout);
        } else if (info->values != NULL) {
            printf("COMPREPLY=($(compgen -%c -- \"$cur\"));",
                   strcmp(info->values, "@folder") == 0 ? 'd' : 'f');
        }
        puts(" return;;");
    }
    puts("    esac");
}

static void print_bash(void) {
    puts("# bash completion for snell; made by snell help --completion bash\n"
         "_snell() {\n"
         "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} word "
         "command=\n"
         "    compopt -o filenames 2>/dev/null");
    fputs("    for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
          "        case $word in",
          stdout);
    for (size_t i = 0; i < command_table_count; i++) {
        printf("%c%s", i == 0 ? ' ' : '|', command_table[i].name);
    }
    puts(") command=$word; break;;\n        *.*|*/*) command=render; break;;\n        esac\n    "
         "done");
    bash_values();
    puts("    case $command:$cur in");
    for (size_t c = 0; c <= command_table_count; c++) {
        const command_info *command = c < command_table_count ? &command_table[c] : NULL;
        printf("    %s:-*) COMPREPLY=($(compgen -W '", command != NULL ? command->name : "");
        for (size_t i = 0; i < option_table_count; i++) {
            if (shown(&option_table[i], command)) printf("--%s ", option_table[i].name);
        }
        puts("' -- \"$cur\"));;");
    }
    fputs("    help:*) COMPREPLY=($(compgen -W '", stdout);
    put_topics();
    fputs("' -- \"$cur\"));;\n    example:*) COMPREPLY=($(compgen -W '", stdout);
    put_examples();
    fputs("' -- \"$cur\"));;\n    :*) COMPREPLY=($(compgen -W '", stdout);
    for (size_t i = 0; i < command_table_count; i++) printf("%s ", command_table[i].name);
    puts("' -- \"$cur\") $(compgen -f -- \"$cur\"));;\n"
         "    *) COMPREPLY=($(compgen -f -- \"$cur\"));;\n"
         "    esac\n}\n"
         "complete -F _snell snell");
}

/* ---- zsh ---- */

/* Inside single quotes, inside [..] of _arguments. */
static void put_zsh(const char *text) {
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '\'')
            fputs("'\\''", stdout);
        else if (*c == '[' || *c == ']' || *c == ':' || *c == '\\')
            printf("\\%c", *c);
        else
            putchar(*c);
    }
}

static void zsh_option(const option_info *info) {
    bool repeats = (info->flags & OPTION_REPEATS) != 0;
    fputs("        ", stdout);
    if (info->letter != 0 && repeats)
        printf("'*'{-%c,--%s}'", info->letter, info->name);
    else if (info->letter != 0) {
        printf("'(-%c --%s)'{-%c,--%s}'", info->letter, info->name, info->letter, info->name);
    } else {
        printf("'%s--%s", repeats ? "*" : "", info->name);
    }
    if ((info->flags & OPTION_OPTIONAL_VALUE) != 0) fputs("=-", stdout);
    putchar('[');
    put_zsh(info->help);
    putchar(']');
    if (info->metavar != NULL) {
        fputs((info->flags & OPTION_OPTIONAL_VALUE) != 0 ? "::" : ":", stdout);
        put_zsh(info->metavar);
        putchar(':');
        if (has_choices(info)) {
            putchar('(');
            put_words(info->values);
            putchar(')');
        } else if (info->values != NULL) {
            fputs(strcmp(info->values, "@folder") == 0 ? "_files -/" : "_files", stdout);
        }
    }
    puts("' \\");
}

static void print_zsh(void) {
    puts("#compdef snell\n# made by snell help --completion zsh\n"
         "_snell() {\n    local command=${words[2]}\n    case $command in");
    for (size_t c = 0; c < command_table_count; c++) {
        const command_info *command = &command_table[c];
        printf("    %s%s) _arguments -s -S \\\n", command->name,
               command->bit == CMD_RENDER ? "|*.*|*/*" : "");
        for (size_t i = 0; i < option_table_count; i++) {
            if (shown(&option_table[i], command)) zsh_option(&option_table[i]);
        }
        fputs("        '1: :' ", stdout);
        if (command->bit == CMD_HELP || command->bit == CMD_EXAMPLE) {
            fputs("'2: :(", stdout);
            if (command->bit == CMD_HELP)
                put_topics();
            else
                put_examples();
            puts(")';;");
        } else {
            puts("'*:file:_files';;");
        }
    }
    fputs("    *) _arguments '1: :{_alternative \"commands:command:(", stdout);
    for (size_t i = 0; i < command_table_count; i++) printf("%s ", command_table[i].name);
    puts(")\" \"files:file:_files\"}';;\n    esac\n}\n_snell \"$@\"");
}

/* ---- fish ---- */

static void put_fish(const char *text) {
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '\'' || *c == '\\') putchar('\\');
        putchar(*c);
    }
}

static void fish_option(const option_info *info) {
    fputs("complete -c snell", stdout);
    if (info->commands != CMD_ALL) {
        fputs(" -n '__fish_seen_subcommand_from", stdout);
        for (size_t i = 0; i < command_table_count; i++) {
            if ((info->commands & command_table[i].bit) != 0) printf(" %s", command_table[i].name);
        }
        /* `snell FILE` has no command word: render's options go there too. */
        fputs((info->commands & CMD_RENDER) != 0 ? "; or not __fish_use_subcommand'" : "'", stdout);
    }
    printf(" -l %s", info->name);
    if (info->letter != 0) printf(" -s %c", info->letter);
    if (info->metavar != NULL && (info->flags & OPTION_OPTIONAL_VALUE) == 0) {
        fputs(info->values != NULL && info->values[0] == '@' ? " -r -F" : " -x", stdout);
    }
    if (has_choices(info)) {
        fputs(" -a '", stdout);
        put_words(info->values);
        putchar('\'');
    }
    fputs(" -d '", stdout);
    put_fish(info->help);
    puts("'");
}

static void print_fish(void) {
    puts("# fish completion for snell; made by snell help --completion fish");
    for (size_t i = 0; i < command_table_count; i++) {
        printf("complete -c snell -n __fish_use_subcommand -a %s -d '", command_table[i].name);
        put_fish(command_table[i].summary);
        puts("'");
    }
    for (size_t i = 0; i < option_table_count; i++) {
        if ((option_table[i].flags & OPTION_HIDDEN) == 0) fish_option(&option_table[i]);
    }
    fputs("complete -c snell -n '__fish_seen_subcommand_from help' -f -a '", stdout);
    put_topics();
    fputs("'\ncomplete -c snell -n '__fish_seen_subcommand_from example' -f -a '", stdout);
    put_examples();
    puts("'");
}

int completion_print(const char *shell) {
    if (strcmp(shell, "bash") == 0)
        print_bash();
    else if (strcmp(shell, "zsh") == 0)
        print_zsh();
    else
        print_fish();
    return EXIT_DONE;
}
