/* What snell-import (apps/import) and the process that started it (helper.c) say to each other: the
 * arguments, the open files, and the records on the pipe. */
#ifndef SNELL_IMPORTERS_PROTOCOL_H
#define SNELL_IMPORTERS_PROTOCOL_H

#include <stdint.h>

/* Open in the helper besides 0, 1 and 2, which are /dev/null. */
enum { PROTOCOL_RESULT_FD = 3, PROTOCOL_PIPE_FD = 4 };

/* Arguments come in pairs; all but --file may be missing, --param and --allow may repeat. */
#define PROTOCOL_FILE "--file"
#define PROTOCOL_FORMAT "--format"
#define PROTOCOL_UP "--up"
#define PROTOCOL_PARAM "--param"
#define PROTOCOL_ALLOW "--allow"
#define PROTOCOL_PROGRAMS "--programs" /* "1": may run programs */
#define PROTOCOL_FRAME "--frame"       /* from 1; "0": the first */
#define PROTOCOL_NEXT "--next"     /* "1": functions of time are asked about the next frame too */
#define PROTOCOL_LAYER "--layer"   /* of a picture: no scene is read */
#define PROTOCOL_MEMORY "--memory" /* bytes */
#define PROTOCOL_TIME "--time"     /* whole seconds */

enum protocol_kind { PROTOCOL_PROGRESS = 1, PROTOCOL_ERROR, PROTOCOL_DONE };

/* One record of the pipe, smaller than PIPE_BUF, so that it is written in one piece. */
typedef struct protocol_record {
    uint32_t kind, status, line, column; /* of an error */
    double fraction;                     /* of progress */
    char text[1024], hint[1024], file[512];
} protocol_record;
_Static_assert(sizeof(protocol_record) <= 4096, "PIPE_BUF");

#endif
