/* Light from everywhere: a colour, or an image of the surroundings in longitude and latitude
 * (sphere_map.h says how they lie), sampled by its brightness. Every ray that leaves sees it. */
#include <stdlib.h>

#include "base/memory.h"
#include "lights/light.h"
#include "lights/sphere_map.h"
#include "maths/functions.h"

#define ENVIRONMENT_FIELDS(F, T)                                                                   \
    F(T, radiance, INPUT, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/(m^2 sr)",                            \
      "what comes from each direction; a texture is looked up by longitude and latitude")          \
    F(T, rotate, FLOAT, DEFAULT(0), ANY, "rad",                                                    \
      "turns it about +Y, counter-clockwise seen from above")                                      \
    F(T, visible, BOOL, DEFAULT(1), ANY, "", "camera rays see it; otherwise the background")
DESCRIBE(environment, ENVIRONMENT_FIELDS)

/* A larger grid would not be sampled better: what is finer than a cell is a part of its mean. */
enum { GRID_WIDTH_MAX = 2048, GRID_HEIGHT_MAX = 1024, DETAIL_MIN = 2, ROWS_MIN = 32 };

typedef struct environment_state {
    double c, s;    /* cosine and sine of `rotate` */
    bool constant;  /* no texture */
    sphere_map map; /* empty when constant */
} environment_state;

typedef struct environment {
    const environment_desc *desc;
    const texture *textures;
    double du, dv; /* the footprint of a look; 0: a point */
} environment;

/* By the map's own directions, before it is turned. */
static dvec3 look_up(const void *user, dvec3 d) {
    const environment *e = user;
    texture_point at = {.has_uv = true, .local = d, .n = d, .dudx = e->du, .dvdy = e->dv};
    sphere_map_coordinates(d, &at.u, &at.v);
    return input_color(&e->desc->radiance, e->textures, &at);
}

/* By the angle's sine: +1 from the map to the world, -1 back. */
static dvec3 turn(const environment_state *s, dvec3 d, double way) {
    double sine = way * s->s;
    return (dvec3){s->c * d.x + sine * d.z, d.y, s->c * d.z - sine * d.x};
}

static dvec3 radiance(const light *l, dvec3 d) {
    const environment_state *s = l->state;
    const environment_desc *desc = l->desc;
    environment e = {desc, l->textures, 0, 0};
    return s->constant ? dvec3_from(desc->radiance.value) : look_up(&e, turn(s, d, -1));
}

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)p, (void)eye;
    const environment_state *s = l->state;
    dvec3 d;
    double pdf = 1 / (4 * PI);
    if (s->constant) {
        double cosine = 1 - 2 * u.x, sine = sqrt(double_max(0, 1 - cosine * cosine));
        d = (dvec3){sine * fn_cos(2 * PI * u.y), cosine, sine * fn_sin(2 * PI * u.y)};
    } else {
        if (!sphere_map_sample(&s->map, u, &d, &pdf)) return false;
        d = turn(s, d, 1);
    }
    *out = (light_sample){d, d, true, radiance(l, d), pdf};
    return true;
}

static double pdf(const light *l, dvec3 d) {
    const environment_state *s = l->state;
    return s->constant ? 1 / (4 * PI) : sphere_map_pdf(&s->map, turn(s, d, -1));
}

static dvec3 irradiance(const light *l, dvec3 n) {
    const environment_state *s = l->state;
    const environment_desc *desc = l->desc;
    if (s->constant) return dvec3_scale(dvec3_from(desc->radiance.value), PI);
    return sphere_map_irradiance(&s->map, turn(s, n, -1));
}

static double brightest(const light *l) {
    const environment_state *s = l->state;
    const environment_desc *desc = l->desc;
    return s->constant ? (double)vec3_largest(desc->radiance.value) : s->map.brightest;
}

static dvec3 power(const light *l, double scene_radius) {
    const environment_state *s = l->state;
    const environment_desc *desc = l->desc;
    dvec3 mean = s->constant ? dvec3_from(desc->radiance.value) : s->map.mean;
    return dvec3_scale(mean, 4 * PI * PI * scene_radius * scene_radius);
}

/* As many cells as pixels, or as the grid may have. Then no two of the directions in a cell are more
 * than a pixel apart, or each is seen with a footprint as wide as they are apart, in the image's mip
 * maps. */
static sphere_grid grid_of(const texture *t, environment *e) {
    sphere_grid grid = {256, 128, DETAIL_MIN, true};
    if (t->type->size == NULL) return grid;
    uint32_t w, h, shrink = 1;
    t->type->size(t->desc, &w, &h);
    while (w / shrink > GRID_WIDTH_MAX || h / shrink > GRID_HEIGHT_MAX) shrink++;
    grid.width = w / shrink < 1 ? 1 : w / shrink;
    grid.height = h / shrink < 1 ? 1 : h / shrink;
    if (shrink == 1) {
        grid.spills = false;
        while (grid.height * grid.detail < ROWS_MIN || grid.width * grid.detail < 2 * ROWS_MIN)
            grid.detail++; /* the harmonics need that many directions */
    } else if (texture_filters(t) && (t->map == MAP_AUTO || t->map == MAP_UV)) {
        e->du = 1.0 / (grid.width * DETAIL_MIN);
        e->dv = 1.0 / (grid.height * DETAIL_MIN);
    } else {
        grid.detail = shrink + 1;
    }
    return grid;
}

static void release(void *state) {
    environment_state *s = state;
    if (s) sphere_map_free(&s->map);
    free(s);
}

static snell_status prepare(const void *desc, const texture *textures, thread_pool *pool,
                            void **state) {
    const environment_desc *l = desc;
    environment_state *s = memory_zeroed(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    s->c = fn_cos((double)l->rotate);
    s->s = fn_sin((double)l->rotate);
    s->constant = l->radiance.texture.index1 == 0;
    snell_status status = SNELL_OK;
    if (!s->constant) {
        environment e = {l, textures, 0, 0};
        sphere_grid grid = grid_of(&textures[l->radiance.texture.index1 - 1], &e);
        status = sphere_map_build(&grid, pool, look_up, &e, &s->map);
    }
    if (status)
        release(s);
    else
        *state = s;
    return status;
}

static bool is_visible(const void *desc) { return ((const environment_desc *)desc)->visible; }

const light_type light_environment = {
    .info = TYPE_INFO(CATEGORY_LIGHT, environment, "environment",
                      "light from everywhere: a colour or an image of the surroundings"),
    .sample = sample,
    .radiance = radiance,
    .pdf = pdf,
    .irradiance = irradiance,
    .brightest = brightest,
    .power = power,
    .prepare = prepare,
    .release = release,
    .casts_shadow = true,
    .is_visible = is_visible,
};
