/* Inside the wave loop: what its three parts share. wave.c keeps the rays going, emit.c is what
 * policies emit, shadows.c tests what stands between a point and a light. */
#ifndef SNELL_INTEGRATORS_WAVE_H
#define SNELL_INTEGRATORS_WAVE_H

#include "integrators/integrator.h"

/* What a shadow ray adds to the film if light gets through. */
typedef struct shadow_ray {
    vec3 light; /* weighted */
    uint32_t pixel;
    bool met; /* a path could find this light by itself: `shadow = "none"` hides nothing */
    media media;
} shadow_ray;

struct wave {
    wave_settings settings;
    path_ray *pool; /* a stack: the newest rays are traced first, which bounds it */
    size_t pool_count, pool_capacity;
    path_ray *next; /* what the wave that is being traced emits */
    size_t next_count, next_capacity;
    shadow_ray *shadows;
    ray *shadow_rays;    /* of each the ray, as the kernels take them */
    size_t shadow_count; /* at most a wave: then they are tested */
    /* what is being traced */
    ray *rays;
    hit *hits;
    uint8_t *blocked;
    film_block *film;
    struct aov_block *aovs;                    /* NULL: none are wanted */
    struct light_way *light_ways;              /* with them: of the shadow rays */
    uint32_t scramble;                         /* of the pixels' sequences */
    uint32_t sharing;                          /* the pixel's footprint: so many samples */
    uint64_t streams[FILM_BLOCK * FILM_BLOCK]; /* of the random numbers of each pixel's place */
    media beyond;                              /* of the surface that a policy is asked about */
    const hit *at;                             /* and where that is */
    dvec3 origin[2];                           /* of rays that leave there, below and above, .. */
    bool has_origin[2];                        /* .. once one has; floats */
    uint32_t asked;                            /* the light that emit_light is about */
    double asked_chance;                       /* of its choice; 0: there was none, all are asked */
    bool out_of_memory, stopped;
    bool (*go_on)(void *user, const wave_stats *stats);
    void *user;
    wave_stats stats;
    wave_phase phase; /* that the time since phase_began belongs to */
    double phase_began;
};
/* To the film: coverage of a transparent picture. */
void wave_add_coverage(wave *w, const path_ray *r, double alpha);
/* Adds to the film what gets through, and forgets the shadow rays. */
void wave_test_shadows(wave *w);
/* Another phase begins; returns the one that ends. */
wave_phase wave_begin_phase(wave *w, wave_phase next);
/* Progress and cancelling, after some work in the midst of a wave. */
void wave_look_up(wave *w);
/* A smooth face between media of one ior: light goes straight on, and in `path` that is no new
 * direction. Of what is there in part, that is only true of what has entered. */
bool wave_goes_straight_on(const bsdf *b);

#endif
