/* From a scene that was loaded to one that is committed and a render that is described: camera, light
 * and ground for a file that brings none, and what the command line says. */
#ifndef SNELL_CLI_STAGE_H
#define SNELL_CLI_STAGE_H

#include <snell/snell.h>

#include "options.h"
#include "session.h"
#include "values.h"

typedef struct stage {
    const options *options;
    const render_values *values;
    session *session;
    const char *input; /* as typed */
    snell_scene *scene;
    uint64_t hash;                 /* of the scene as it was loaded, where something asks for it */
    snell_render_desc desc, usual; /* usual: before a camera was chosen */
    snell_view view;
    const char *studio; /* what it added */
    char added[96];
    uint32_t camera_count; /* of the file */
    snell_bounds bounds;   /* of what was loaded, for a turntable */
    char camera[128];      /* its name, with --camera all */
} stage;

/* Reads the input into s->scene, and the surroundings that are to light it. */
int stage_load(stage *s, bool hashed);
/* Only the latter, for who loads it otherwise. */
int stage_add_light(stage *s);
/* Dresses and commits s->scene, and fills s->desc. Exit code. */
int stage_prepare(stage *s);
/* The same scene, prepared before, for the session's next camera or turn: only the view and the studio's lights change. */
int stage_look_again(stage *s);
/* Chooses a frame: of the scene's own time, or of --turntable; 0: none. */
void stage_set_frame(session *of, const render_values *values, uint32_t frame);
/* What the command line wants done to the picture. */
snell_image_desc stage_image(const stage *s);
/* The exit code of a call about the input, its error reported; a signal counts as one. */
int stage_status(const stage *s, snell_status status);

#endif
