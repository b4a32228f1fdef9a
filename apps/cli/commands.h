/* Each command: takes the parsed options, returns the exit code. */
#ifndef SNELL_CLI_COMMANDS_H
#define SNELL_CLI_COMMANDS_H

#include "options.h"

int render_command(const options *o);
int info_command(const options *o);
int example_command(const options *o);
int help_command(const options *o);

int help_main(void);                      /* snell --help */
int help_of(const command_info *command); /* snell COMMAND --help */
int help_version(void);                   /* snell --version */
int man_print(const char *page);          /* a page in roff */
int completion_print(const char *shell);  /* a script */

/* The built-in scenes, for completion; NULL after the last. */
const char *example_name(size_t index);
/* What `snell help` knows besides commands and types. */
typedef struct help_topic {
    const char *name, *category; /* category of types to list, or NULL */
    const char *title, *text;
} help_topic;
extern const help_topic help_topics[];
extern const size_t help_topic_count;

#endif
