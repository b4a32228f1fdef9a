/* Does a build keep to the memory that was stated before it, at any size?
 *
 *     bench-huge [--triangles N] [--copies N] [--build NAME] [--threads N]
 *     bench-huge [--triangles N] --ply FILE
 *
 * One lumpy ball of N triangles (1,000,000), or N copies of it, are committed at each quality in a process of their own
 * and traced: printed are the bytes of the description, the statement before the commit, how much more memory the process
 * then had at the most, what the tree keeps, and seconds. Exit code 1 if any takes more than was stated. --ply writes the
 * ball as a binary PLY file instead. */
#include <math.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <snell/snell.h>

#include "measure.h"

typedef struct settings {
    uint64_t triangles, copies;
    uint32_t threads;
    int build; /* -1: all */
    const char *ply;
} settings;

typedef struct ball {
    snell_vec3 *positions;
    uint32_t *indices;
    size_t vertex_count, index_count;
} ball;

static const char *const build_names[] = {"balanced", "fast", "best"}; /* as snell_build */

static void die(const char *what) {
    fprintf(stderr, "bench-huge: %s\n", what);
    exit(2);
}

static void must(snell_status status) {
    if (status != SNELL_OK) die(snell_last_error()->text);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Longitude u, latitude v, in [0,1]. */
static snell_vec3 place(double u, double v) {
    double a = 6.283185307179586 * u, b = 3.141592653589793 * v;
    double far =
        1 + 0.08 * sin(7 * a) * sin(9 * b) * sin(b) + 0.02 * sin(61 * a) * sin(83 * b) * sin(b);
    return (snell_vec3){(float)(far * sin(b) * cos(a)), (float)(far * cos(b)),
                        (float)(far * sin(b) * sin(a))};
}

/* Rows of latitude, each of twice as many quads, of two triangles each. */
static ball make_ball(uint64_t triangles) {
    size_t rows = (size_t)sqrt((double)triangles / 4), columns = 2 * rows;
    ball b = {.vertex_count = (rows + 1) * (columns + 1), .index_count = 6 * rows * columns};
    b.positions = malloc(b.vertex_count * sizeof *b.positions);
    b.indices = malloc(b.index_count * sizeof *b.indices);
    if (b.positions == NULL || b.indices == NULL) die("out of memory");
    for (size_t i = 0, n = 0; i <= rows; i++)
        for (size_t j = 0; j <= columns; j++)
            b.positions[n++] =
                place((double)(j % columns) / (double)columns, (double)i / (double)rows);
    uint32_t *to = b.indices;
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < columns; j++) {
            uint32_t at = (uint32_t)(i * (columns + 1) + j), below = at + (uint32_t)columns + 1;
            const uint32_t faces[] = {at, at + 1, below, below, at + 1, below + 1};
            memcpy(to, faces, sizeof faces);
            to += 6;
        }
    return b;
}

static void write_ply(const ball *b, const char *path) {
    FILE *f = fopen(path, "wb");
    if (f == NULL) die("the file cannot be written");
    fprintf(f,
            "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\n"
            "property float y\nproperty float z\nelement face %zu\n"
            "property list uchar uint vertex_indices\nend_header\n",
            b->vertex_count, b->index_count / 3);
    fwrite(b->positions, sizeof *b->positions, b->vertex_count, f);
    for (size_t i = 0; i < b->index_count; i += 3) {
        fputc(3, f);
        fwrite(b->indices + i, sizeof *b->indices, 3, f);
    }
    if (ferror(f) || fclose(f)) die("the file cannot be written");
}

static void add_ball(snell_scene *scene, uint64_t triangles, uint64_t copies) {
    ball b = make_ball(triangles);
    snell_mesh_desc mesh = SNELL_INIT(mesh_desc);
    snell_shape_id shape;
    mesh.positions = b.positions;
    mesh.positions_count = b.vertex_count;
    mesh.indices = b.indices;
    mesh.indices_count = b.index_count;
    must(snell_scene_add_mesh(scene, &mesh, &shape));
    free(b.positions);
    free(b.indices);
    uint64_t side = (uint64_t)ceil(sqrt((double)copies));
    for (uint64_t i = 0; i < copies; i++) {
        float x = 2.2f * (float)(i % side), z = 2.2f * (float)(i / side);
        snell_transform at = {{{1, 0, 0, x}, {0, 1, 0, 0}, {0, 0, 1, z}}};
        must(snell_scene_add_instance(scene, shape, (snell_material_id){0, 0}, &at, NULL));
    }
}

/* Of this process now; 0: unknown. */
static uint64_t resident(void) {
    unsigned long long pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    if (f == NULL) return 0;
    if (fscanf(f, "%*u %llu", &pages) != 1) pages = 0;
    fclose(f);
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

static double trace(const snell_scene *scene, snell_context *context) {
    snell_render_desc desc = SNELL_INIT(render_desc);
    snell_view view = SNELL_INIT(view);
    snell_bounds bounds;
    snell_film *film;
    must(snell_scene_bounds(scene, &bounds));
    must(snell_view_frame(&view, &bounds, 0.5f, 0.5f, 1));
    must(snell_film_create(context, &film));
    desc.integrator = SNELL_APPEL;
    desc.width = desc.height = 1024;
    desc.samples = 1;
    desc.view = &view;
    double start = now();
    must(snell_render(scene, &desc, film));
    double seconds = now() - start;
    snell_film_destroy(film);
    return seconds;
}

static int measure(const settings *s, int build) {
    snell_context_desc desc = SNELL_INIT(context_desc);
    snell_context *context;
    snell_scene *scene;
    snell_scene_stats before = {.struct_size = sizeof before}, after = before;
    desc.thread_count = s->threads;
    desc.build = (snell_build)build;
    must(snell_context_create(&desc, &context));
    must(snell_scene_create(context, &scene));
    add_ball(scene, s->triangles, s->copies);
    must(snell_scene_get_stats(scene, &before));
    uint64_t had = resident();
    double start = now();
    must(snell_scene_commit(scene, NULL, NULL));
    double seconds = now() - start;
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    uint64_t peak = (uint64_t)usage.ru_maxrss * 1024, more = peak > had ? peak - had : 0;
    must(snell_scene_get_stats(scene, &after));
    double each = (double)before.unique_triangle_count, mib = 0x1p-20;
    printf("%-9s %12llu %7llu %10.0f %10.0f %10.0f %7.1f %10.0f %7.1f %8.2f %8.2f\n",
           build_names[build], (unsigned long long)before.unique_triangle_count,
           (unsigned long long)before.instance_count, (double)before.memory_geometry * mib,
           (double)before.memory_planned * mib, (double)more * mib, (double)more / each,
           (double)after.memory_accel * mib, (double)after.memory_accel / each, seconds,
           trace(scene, context));
    fflush(stdout);
    snell_scene_destroy(scene);
    snell_context_destroy(context);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return 0; /* with memory of its own for each byte */
#else
    return more > before.memory_planned + (1 << 20); /* that the allocator keeps */
#endif
}

/* Nobody else has used its memory. */
static int measure_alone(const settings *s, int build) {
    fflush(stdout);
    pid_t child = fork();
    int status = 1;
    if (child < 0) die("a process cannot be started");
    if (child == 0) exit(measure(s, build));
    waitpid(child, &status, 0);
    return status != 0;
}

static int build_of(const char *text) {
    for (int i = 0; text && i < 3; i++)
        if (strcmp(text, build_names[i]) == 0) return i;
    die("--build takes balanced, fast or best");
    return -1;
}

static uint64_t number(const char *text, uint64_t low, uint64_t high) {
    uint64_t value;
    if (!read_number(text, low, high, &value)) die("a number is missing or wrong");
    return value;
}

int main(int argc, char **argv) {
    settings s = {.triangles = 1000000, .copies = 1, .build = -1};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--triangles") == 0)
            s.triangles = number(argv[++i], 64, 2000000000);
        else if (strcmp(argv[i], "--copies") == 0)
            s.copies = number(argv[++i], 1, 1000000000);
        else if (strcmp(argv[i], "--threads") == 0)
            s.threads = (uint32_t)number(argv[++i], 0, 4096);
        else if (strcmp(argv[i], "--build") == 0)
            s.build = build_of(argv[++i]);
        else if (strcmp(argv[i], "--ply") == 0 && argv[i + 1])
            s.ply = argv[++i];
        else
            die("usage: bench-huge [--triangles N] [--copies N] [--build NAME] [--threads N] "
                "[--ply FILE]");
    }
    if (s.ply) {
        ball b = make_ball(s.triangles);
        write_ply(&b, s.ply);
        free(b.positions);
        free(b.indices);
        return 0;
    }
    printf("MiB; bytes for each triangle that is stored\n%-9s %12s %7s %10s %10s %10s %7s %10s %7s "
           "%8s %8s\n",
           "build", "triangles", "copies", "geometry", "stated", "taken", "each", "tree", "each",
           "commit s", "1 Mray s");
    int over = 0;
    for (int build = 0; build < 3; build++)
        if (s.build < 0 || s.build == build) over |= measure_alone(&s, build);
    return over;
}
