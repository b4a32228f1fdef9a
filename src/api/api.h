/* What the opaque objects of the public header are. */
#ifndef SNELL_API_API_H
#define SNELL_API_API_H

#include <pthread.h>

#include "image/film.h"
#include "image/white_balance.h"
#include "render/render.h"
#include "scene/scene.h"

struct snell_context {
    thread_pool *pool;
    snell_isa isa;
    snell_build build;
    uint64_t memory_max;
    log_sink log; /* writes under log_lock */
    log_sink user_log;
    pthread_mutex_t log_lock;
};

/* Whom snell_scene_add_studio lit for, and its lights by index; lit: it added some. */
typedef struct studio {
    bool lit;
    snell_view eye;
    uint32_t key, fill;
} studio;

/*  any number of readers (queries, renders)  OR  one editor (add, load, commit): the counts are
 * guarded by lock, and what does not fit is SNELL_ERR_STATE at once. */
struct snell_scene {
    snell_context *context;
    description *description;
    scene *frozen; /* of the last commit; borrows the description's data */
    studio studio;
    pthread_mutex_t lock;
    uint32_t readers;
    bool editing;
    unsigned float_saved; /* the editor's own, until it is done */
};

struct snell_film {
    snell_context *context;
    film film;
    /* Of the file it was read from: names, each with its 0, an empty one last; or NULL. */
    char *layers;
    snell_render_stats stats;
    float exposure;                             /* what the scene asks for */
    int tonemap;                                /* choice of render_desc.tonemap, never "default" */
    char white_balance[WHITE_BALANCE_TEXT_MAX]; /* checked; "": none */
};

/* An edit computes too (it normalises directions), so the caller's rounding is set aside for it. */
snell_status scene_begin_edit(snell_scene *s);
void scene_end_edit(snell_scene *s);
/* Reading what was added, committed or not; ends as reading does. */
snell_status scene_begin_look(const snell_scene *s);
/* Fails without a commit. const: reading is not an edit. */
snell_status scene_begin_read(const snell_scene *s);
void scene_end_read(const snell_scene *s);

/* The description struct of a typed public call: checked, copied and added; *index1 is the id's
 * number. */
snell_status scene_add_typed(snell_scene *s, category category, const char *type, const void *desc,
                             uint32_t *index1);

/* The same camera; keys are borrowed. */
snell_view view_from_perspective(const perspective_desc *camera);
perspective_desc view_to_perspective(const snell_view *view);

/* A render of the last commit, its description checked and its camera chosen. The options point into
 * it; it is freed only after SNELL_OK. */
typedef struct prepared_render {
    render_options options;
    motion moved; /* the camera's */
    pixel_filter filter;
} prepared_render;
snell_status prepare_render(const snell_scene *s, const snell_render_desc *r, prepared_render *out);
void prepared_render_free(prepared_render *p);

/* Bounds of everything that has bounds, before a commit. */
bounds3 description_bounds(const description *d);
/* snell_view_frame_scene */
snell_status framing_of(const description *d, float azimuth, float elevation, float aspect,
                        bool turning, snell_view *view);
snell_status framing_too_large(bounds3 b);             /* the error */
bool description_has_emission(const description *d);   /* some material shines */
bool description_has_dielectric(const description *d); /* some material bounds a medium */

#endif
