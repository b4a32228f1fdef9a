/* Embeds snell: loads a model, walks once around it, then sends a million rays of its own.
 *   cc embed.c $(pkg-config --cflags --libs snell) && ./a.out duck.glb 12    -> orbit-00.png ...
 * SNELL_OK is 0, so calls joined by || stop at the first that fails. */
#include <snell/snell.h>
#include <stdio.h>
#include <stdlib.h>
enum { SIDE = 1000 };
static snell_ray rays[SIDE * SIDE];
static snell_hit hits[SIDE * SIDE];
static snell_bounds box;

static bool show(void *user, const snell_progress *progress) {
    (void)user;
    fprintf(stderr, "\r%-8s %3.0f %%", progress->phase, 100 * progress->fraction);
    return true; /* false would cancel */
}

static bool orbit(const snell_scene *scene, snell_film *film, int count) {
    snell_view view = SNELL_INIT(view);
    snell_render_desc render = {.struct_size = sizeof render};
    bool failed = snell_scene_settings(scene, 0, &render);
    render.view = &view, render.width = 400, render.height = 300, render.progress = show;
    for (int i = 0; i < count && !failed; i++) {
        char name[32];
        snprintf(name, sizeof name, "orbit-%02d.png", i);
        failed = snell_view_frame(&view, &box, (float)i * 6.2831853f / (float)count, 0.3f, 1.33f) ||
                 snell_render(scene, &render, film) || snell_film_write(film, name, NULL);
    }
    return failed;
}

static bool cast(const snell_scene *scene) { /* parallel rays along -z */
    for (int i = 0; i < SIDE * SIDE; i++) {
        float x = ((float)(i % SIDE) + 0.5f) / SIDE, y = ((float)(i / SIDE) + 0.5f) / SIDE;
        rays[i] = (snell_ray){.direction = {0, 0, -1}, .t_max = 1e30f, .mask = UINT32_MAX};
        rays[i].origin = (snell_vec3){box.min.x + x * (box.max.x - box.min.x),
                                      box.min.y + y * (box.max.y - box.min.y), box.max.z + 1};
    }
    int count = 0, failed = snell_scene_intersect_all(scene, rays, hits, SIDE * SIDE) != SNELL_OK;
    for (int i = 0; i < SIDE * SIDE; i++) count += hits[i].t < 1e30f;
    return failed || printf("\n%d of %d rays hit the model\n", count, SIDE * SIDE) < 0;
}

int main(int argc, char **argv) {
    if (argc < 2) return fprintf(stderr, "usage: embed MODEL [PICTURES]\n"), 2;
    snell_context *context = NULL;
    snell_scene *scene = NULL;
    snell_film *film = NULL;
    bool failed = snell_context_create(NULL, &context) || snell_scene_create(context, &scene) ||
                  snell_film_create(context, &film) || snell_scene_load(scene, argv[1], NULL) ||
                  snell_scene_add_studio(scene, NULL, NULL) ||
                  snell_scene_commit(scene, show, NULL) || snell_scene_bounds(scene, &box) ||
                  orbit(scene, film, argc > 2 ? atoi(argv[2]) : 12) || cast(scene);
    const snell_message *e = snell_last_error();
    if (failed && e->line) fprintf(stderr, "\n%s:%u:", e->file, e->line);
    if (failed) fprintf(stderr, "\n%s\n%s\n", e->text, e->hint);
    snell_film_destroy(film), snell_scene_destroy(scene), snell_context_destroy(context);
    return failed;
}
