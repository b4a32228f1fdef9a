/* Each command: takes the parsed options, returns the exit code. */
#ifndef SNELL_CLI_COMMANDS_H
#define SNELL_CLI_COMMANDS_H

#include <snell/snell.h>

#include "options.h"

int render_command(const options *o);
int explain_command(const options *o);
int bench_command(const options *o);
int info_command(const options *o);
int compare_command(const options *o);
int convert_command(const options *o);
int example_command(const options *o);
int help_command(const options *o);

int help_main(void);                      /* snell --help */
int help_of(const command_info *command); /* snell COMMAND --help */
int help_aovs(void);                      /* the table of AOVs */
int help_version(void);                   /* snell --version */
int man_print(const char *page);          /* a page in roff */
int completion_print(const char *shell);  /* a script */

/* The built-in scenes, for completion; NULL after the last. */
const char *example_name(size_t index);
/* What `snell help` knows besides commands and types. */
typedef struct help_topic {
    const char *name, *category; /* category of types to list, or NULL */
    const char *title, *text;
    bool word; /* one of the scene language: found by name, not listed in the overview */
} help_topic;
extern const help_topic help_topics[];
extern const size_t help_topic_count;
/* By name; the singular of a plural and the plural of a singular do too. NULL: there is none. */
const help_topic *help_find_topic(const char *word);
/* Words of which no page is: how a page that explains what they mean is called, number `at` from 0;
 * NULL when there is no such page, or no more. */
const char *help_find_synonym(const char *word, size_t at);
/* What a scene writes otherwise than the type's table says; NULL: nothing. */
const char *help_note(const snell_type_info *type);
/* Fields that every type of the category takes besides its own; NULL: none. */
const char *help_common_fields(const char *category);

#endif
