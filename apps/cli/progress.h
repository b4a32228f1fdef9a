/* The progress line, and stopping: signals set a flag that the callback reads. */
#ifndef SNELL_CLI_PROGRESS_H
#define SNELL_CLI_PROGRESS_H

#include <signal.h>

#include <snell/snell.h>

/* `when` is a word of --progress, NULL for auto. */
void progress_setup(const char *when);
void progress_begin(const char *label); /* borrowed; the clock starts */
/* Of several pictures, the index-th is next: the line shows all of them. */
void progress_part(size_t index, size_t count);
void progress_end(void);   /* takes the line off the screen */
void progress_clear(void); /* the same for the moment; the caller holds report_lock */
bool progress_report(void *user, const snell_progress *progress); /* a snell_progress_fn */
double progress_seconds(void);                                    /* since progress_begin */

void signals_setup(void);
int signals_caught(void); /* 0, or the signal's number */
/* Ends the program by the signal that was caught, so that the shell sees 130 or 143. */
void signals_raise(void);

#endif
