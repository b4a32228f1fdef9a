/* What every command that reads a scene shares: the context, the limits, the loading. */
#ifndef SNELL_CLI_SESSION_H
#define SNELL_CLI_SESSION_H

#include <snell/snell.h>

#include "options.h"

typedef struct session {
    const options *options;
    snell_context *context;
    uint64_t memory_max;     /* 0: not limited */
    uint32_t frame;          /* of an animation; 0: its first */
    uint32_t frame_last;     /* of --frames; 0: not given */
    bool next_frame;         /* functions of time are asked about the next frame too */
    uint32_t turn;           /* the same of --turntable; 0: there is none */
    uint32_t camera;         /* with --camera all: which, from 0 */
    const char *framed_file; /* whose frames are all seen from `framed`; NULL: not known yet */
    snell_view framed;
    bool keeps_input;   /* standard input is read once and kept until session_close */
    char *spool_folder; /* where standard input was written; NULL when it was not */
    char *spool_file;
} session;

/* Exit codes, errors reported. */
int session_open(session *s, const options *o);
void session_close(session *s);
/* Reads a file, or standard input when path is "-", into a new scene. */
int session_load(session *s, const char *path, snell_scene **out);
/* One that is not there is an error, which names one that is and is nearly called so; also of the calls
 * that open one. */
int session_check_file(const char *path);
/* The same of a scene program's text, which messages call `name`. */
int session_load_text(session *s, const char *name, const unsigned char *text, size_t size,
                      snell_scene **out);
/* A file that can be mapped and sought: `path` itself, or what standard input held when it is "-";
 * until session_end_input. Messages about it name `path`. */
int session_input(session *s, const char *path, const char **real);
void session_end_input(session *s);
/* Bytes: the largest resident size of this process (RUSAGE_SELF) or of its children so far. */
uint64_t session_memory_peak(int who);
/* An unknown SNELL_* variable is a warning. */
void session_check_environment(void);
/* The file's name as messages show it. */
const char *session_label(const char *path);

#endif
