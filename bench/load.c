/* How long a model file takes to load, and how much memory, beside libassimp's own plain import.
 *
 *     bench-load [--triangles N] [--rounds N] [--folder DIR] [--keep] [--json] [FORMAT|FILE]...
 *
 * The files are made here: one closed bumpy tube of N triangles. snell's time is that of everything up to
 * a scene that could be committed: the start of snell-import, its sandbox, reading, the checks on both
 * sides and the hand-over; libassimp's that of aiImportFile with aiProcess_Triangulate. Each load is a
 * process of its own, forked from one that has loaded nothing; the two take turns, the other way round in
 * every other round. Loads of their own, which are not timed, are looked at every half millisecond for the memory that
 * both of snell's processes take at one moment. */
#include <dirent.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <snell/snell.h>

#if SNELL_HAS_ASSIMP
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#endif

#include "base/thread.h"
#include "importers/importer.h"
#include "measure.h"

static void die(const char *text) {
    fprintf(stderr, "bench-load: %s\n", text);
    exit(1);
}

/* ---- the files ---- */

typedef struct tube {
    uint32_t around, along; /* both are closed; 2 around x along triangles */
} tube;

typedef struct vertex {
    float p[3], n[3], uv[2];
} vertex;

static void place(double u, double v, double out[3]) {
    double bump = 1 + 0.1 * sin(23 * u) * sin(17 * v), r = 0.4 * bump;
    double ring = 1 + r * cos(v);
    out[0] = ring * cos(u), out[1] = r * sin(v), out[2] = ring * sin(u);
}

static vertex vertex_at(const tube *t, uint32_t i, uint32_t j) {
    const double turn = 6.283185307179586, step = 1e-4;
    double u = turn * i / t->along, v = -turn * j / t->around, p[3], du[3], dv[3], n[3];
    place(u, v, p), place(u + step, v, du), place(u, v - step, dv);
    for (int k = 0; k < 3; k++) du[k] -= p[k], dv[k] -= p[k];
    for (int k = 0; k < 3; k++) {
        int a = (k + 1) % 3, b = (k + 2) % 3;
        n[k] = du[a] * dv[b] - du[b] * dv[a];
    }
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    vertex made = {.uv = {(float)i / (float)t->along, (float)j / (float)t->around}};
    for (int k = 0; k < 3; k++) made.p[k] = (float)p[k], made.n[k] = (float)(n[k] / length);
    return made;
}

static void triangle_at(const tube *t, uint32_t index, uint32_t out[3]) {
    uint32_t quad = index / 2, i = quad / t->around, j = quad % t->around;
    uint32_t i1 = (i + 1) % t->along, j1 = (j + 1) % t->around;
    uint32_t a = i * t->around + j, b = i1 * t->around + j, c = i1 * t->around + j1,
             d = i * t->around + j1;
    out[0] = a, out[1] = index % 2 ? c : b, out[2] = index % 2 ? d : c;
}

typedef struct mesh_file {
    FILE *file;
    tube shape;
    const vertex *vertices;
    uint32_t vertex_count, triangle_count;
} mesh_file;

static void write_ply(const mesh_file *m, bool ascii, bool bare) {
    fprintf(m->file, "ply\nformat %s 1.0\nelement vertex %u\n",
            ascii ? "ascii" : "binary_little_endian", m->vertex_count);
    fputs("property float x\nproperty float y\nproperty float z\n", m->file);
    if (!bare) fputs("property float nx\nproperty float ny\nproperty float nz\n", m->file);
    fprintf(m->file, "element face %u\nproperty list uchar int vertex_indices\nend_header\n",
            m->triangle_count);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        const vertex *v = &m->vertices[i];
        if (!ascii) {
            fwrite(v->p, 4, bare ? 3 : 6, m->file);
            continue;
        }
        fprintf(m->file, "%g %g %g", (double)v->p[0], (double)v->p[1], (double)v->p[2]);
        if (!bare) fprintf(m->file, " %g %g %g", (double)v->n[0], (double)v->n[1], (double)v->n[2]);
        fputc('\n', m->file);
    }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        uint32_t k[3];
        triangle_at(&m->shape, i, k);
        if (ascii)
            fprintf(m->file, "3 %u %u %u\n", k[0], k[1], k[2]);
        else
            fputc(3, m->file), fwrite(k, 4, 3, m->file);
    }
}

static void write_ply_binary(const mesh_file *m) { write_ply(m, false, false); }
static void write_ply_bare(const mesh_file *m) { write_ply(m, false, true); }
static void write_ply_ascii(const mesh_file *m) { write_ply(m, true, false); }

static void write_stl(const mesh_file *m) {
    char head[80] = "bench-load";
    fwrite(head, 1, sizeof head, m->file);
    fwrite(&m->triangle_count, 4, 1, m->file);
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        uint32_t k[3];
        uint16_t attribute = 0;
        triangle_at(&m->shape, i, k);
        fwrite(m->vertices[k[0]].n, 4, 3, m->file);
        for (int c = 0; c < 3; c++) fwrite(m->vertices[k[c]].p, 4, 3, m->file);
        fwrite(&attribute, 2, 1, m->file);
    }
}

static void write_stl_ascii(const mesh_file *m) {
    fputs("solid tube\n", m->file);
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        uint32_t k[3];
        triangle_at(&m->shape, i, k);
        const float *n = m->vertices[k[0]].n;
        fprintf(m->file, "facet normal %g %g %g\nouter loop\n", (double)n[0], (double)n[1],
                (double)n[2]);
        for (int c = 0; c < 3; c++) {
            const float *p = m->vertices[k[c]].p;
            fprintf(m->file, "vertex %g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
        }
        fputs("endloop\nendfacet\n", m->file);
    }
    fputs("endsolid tube\n", m->file);
}

static void write_obj(const mesh_file *m, bool bare) {
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        const vertex *v = &m->vertices[i];
        fprintf(m->file, "v %.6f %.6f %.6f\n", (double)v->p[0], (double)v->p[1], (double)v->p[2]);
        if (bare) continue;
        fprintf(m->file, "vt %.6f %.6f\nvn %.4f %.4f %.4f\n", (double)v->uv[0], (double)v->uv[1],
                (double)v->n[0], (double)v->n[1], (double)v->n[2]);
    }
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        uint32_t k[3];
        triangle_at(&m->shape, i, k);
        fputc('f', m->file);
        for (int c = 0; c < 3; c++)
            if (bare)
                fprintf(m->file, " %u", k[c] + 1);
            else
                fprintf(m->file, " %u/%u/%u", k[c] + 1, k[c] + 1, k[c] + 1);
        fputc('\n', m->file);
    }
}

static void write_obj_whole(const mesh_file *m) { write_obj(m, false); }
static void write_obj_bare(const mesh_file *m) { write_obj(m, true); }

static void write_glb(const mesh_file *m) {
    char text[1400];
    float low[3] = {2, 2, 2}, high[3] = {-2, -2, -2};
    for (uint32_t i = 0; i < m->vertex_count; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], m->vertices[i].p[k]);
            high[k] = fmaxf(high[k], m->vertices[i].p[k]);
        }
    uint32_t first = m->vertex_count * (uint32_t)sizeof(vertex), second = m->triangle_count * 12;
    int length = snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
        "\"NORMAL\":1,\"TEXCOORD_0\":2},\"indices\":3}]}],\"buffers\":[{\"byteLength\":%u}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%u,\"byteStride\":32},"
        "{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\","
        "\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]},"
        "{\"bufferView\":0,\"byteOffset\":12,\"componentType\":5126,\"count\":%u,\"type\":"
        "\"VEC3\"},{\"bufferView\":0,\"byteOffset\":24,\"componentType\":5126,\"count\":%u,"
        "\"type\":\"VEC2\"},{\"bufferView\":1,\"componentType\":5125,\"count\":%u,\"type\":"
        "\"SCALAR\"}]}",
        first + second, first, first, second, m->vertex_count, (double)low[0], (double)low[1],
        (double)low[2], (double)high[0], (double)high[1], (double)high[2], m->vertex_count,
        m->vertex_count, 3 * m->triangle_count);
    while (length % 4) text[length++] = ' ';
    uint32_t head[] = {0x46546c67,       2,          28 + (uint32_t)length + first + second,
                       (uint32_t)length, 0x4e4f534a, first + second,
                       0x004e4942};
    fwrite(head, 4, 5, m->file);
    fwrite(text, 1, (size_t)length, m->file);
    fwrite(head + 5, 4, 2, m->file);
    fwrite(m->vertices, sizeof(vertex), m->vertex_count, m->file);
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        uint32_t k[3];
        triangle_at(&m->shape, i, k);
        fwrite(k, 4, 3, m->file);
    }
}

static const struct {
    const char *name, *file;
    void (*write)(const mesh_file *m);
} formats[] = {
    {"glb", "tube.glb", write_glb},
    {"ply", "tube.ply", write_ply_binary},
    {"ply-ascii", "tube-ascii.ply", write_ply_ascii},
    {"ply-bare", "tube-bare.ply", write_ply_bare},
    {"stl", "tube.stl", write_stl},
    {"stl-ascii", "tube-ascii.stl", write_stl_ascii},
    {"obj", "tube.obj", write_obj_whole},
    {"obj-bare", "tube-bare.obj", write_obj_bare},
};
enum { FORMATS = sizeof formats / sizeof formats[0] };

static void make_file(size_t format, const char *path, uint32_t triangles) {
    mesh_file m = {.shape = {.around = (uint32_t)lround(sqrt(triangles / 8.0))}};
    if (m.shape.around < 3) m.shape.around = 3;
    m.shape.along = triangles / (2 * m.shape.around);
    if (m.shape.along < 3) m.shape.along = 3;
    m.vertex_count = m.shape.around * m.shape.along;
    m.triangle_count = 2 * m.vertex_count;
    vertex *vertices = malloc(m.vertex_count * sizeof *vertices);
    m.file = fopen(path, "wb");
    if (vertices == NULL || m.file == NULL) die("cannot write the file");
    for (uint32_t i = 0; i < m.vertex_count; i++)
        vertices[i] = vertex_at(&m.shape, i / m.shape.around, i % m.shape.around);
    m.vertices = vertices;
    formats[format].write(&m);
    if (fclose(m.file) != 0) die("cannot write the file");
    free(vertices);
}

/* ---- loading ---- */

typedef struct cost {
    double seconds, cpu; /* of the clock; of all processes that took part */
    double peak;         /* MiB: the sum of the processes' largest resident sizes */
    uint32_t triangles;
} cost;

static double cpu_of(int who) {
    struct rusage used;
    getrusage(who, &used);
    return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static uint32_t load_snell(const char *path) {
    description *d;
    helper_options options = {.import = {.memory_max = (uint64_t)4 << 30}};
    if (description_create(&d) || helper_import(path, &options, d)) die(error_last()->text);
    size_t total = 0;
    for (size_t i = 0; i < d->objects[CATEGORY_SHAPE].count; i++) {
        const object *o = &d->objects[CATEGORY_SHAPE].items[i];
        size_t count;
        const field *f = type_find_field(o->type, "indices");
        if (f == NULL) continue;
        memcpy(&count, (const char *)o->desc + f->offset + sizeof(void *), sizeof count);
        total += count / 3;
    }
    return (uint32_t)total;
}

#if SNELL_HAS_ASSIMP
static uint32_t load_assimp(const char *path) {
    const struct aiScene *scene = aiImportFile(path, aiProcess_Triangulate);
    if (scene == NULL) die(aiGetErrorString());
    uint32_t total = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) total += scene->mMeshes[i]->mNumFaces;
    return total;
}
#endif

static cost measure(uint32_t (*load)(const char *path), const char *path) {
    int ends[2];
    cost result = {0};
    if (pipe(ends) != 0) die("no pipe");
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) die("cannot fork");
    if (child == 0) {
        struct rusage own, others;
        double begin = time_seconds(), cpu = cpu_of(RUSAGE_SELF);
        result.triangles = load(path);
        result.seconds = time_seconds() - begin;
        result.cpu = cpu_of(RUSAGE_SELF) - cpu + cpu_of(RUSAGE_CHILDREN);
        getrusage(RUSAGE_SELF, &own), getrusage(RUSAGE_CHILDREN, &others);
        result.peak = (double)(own.ru_maxrss + others.ru_maxrss) / 1024;
        _exit(write(ends[1], &result, sizeof result) == sizeof result ? 0 : 1);
    }
    int status;
    close(ends[1]);
    bool whole = read(ends[0], &result, sizeof result) == sizeof result;
    close(ends[0]);
    if (waitpid(child, &status, 0) != child || status != 0 || !whole) die("a load failed");
    return result;
}

/* ---- memory ---- */

typedef struct footprint { /* MiB */
    double import; /* the most at one moment of both processes, beyond what there was before */
    double scene,
        tree; /* the description's arrays; the acceleration structure of the committed scene */
} footprint;

static const char handed_over[] = "/memfd:snell-import"; /* from the helper to the parent */

/* kB of a process: each page over the number of processes that map it. Without the block that is handed over, which
 * takes memory where nobody maps it too. */
static double mapped_by(pid_t process) {
    char path[64], line[512];
    double sum = 0, kb;
    bool counts = true;
    snprintf(path, sizeof path, "/proc/%d/smaps", (int)process);
    FILE *file = fopen(path, "r");
    while (file != NULL && fgets(line, sizeof line, file)) {
        unsigned long from, to;
        if (sscanf(line, "%lx-%lx ", &from, &to) == 2) counts = strstr(line, handed_over) == NULL;
        if (counts && sscanf(line, "Pss: %lf kB", &kb) == 1) sum += kb;
    }
    if (file != NULL) fclose(file);
    return sum;
}

/* kB of the block that is handed over, which the parent holds open. */
static double block_of(pid_t parent) {
    char folder[64], path[400], target[64];
    double kb = 0;
    snprintf(folder, sizeof folder, "/proc/%d/fd", (int)parent);
    DIR *open_files = opendir(folder);
    for (struct dirent *entry; open_files != NULL && (entry = readdir(open_files)) != NULL;) {
        struct stat info;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        ssize_t length = readlink(path, target, sizeof target);
        bool is_block = length >= (ssize_t)sizeof handed_over - 1 &&
                        memcmp(target, handed_over, sizeof handed_over - 1) == 0;
        if (is_block && stat(path, &info) == 0) kb = (double)info.st_blocks / 2;
    }
    if (open_files != NULL) closedir(open_files);
    return kb;
}

/* MiB of a process and its child. */
static double memory_of(pid_t parent) {
    char path[64];
    int helper = 0;
    snprintf(path, sizeof path, "/proc/%d/task/%d/children", (int)parent, (int)parent);
    FILE *file = fopen(path, "r");
    if (file == NULL) return NAN; /* a kernel that does not tell */
    if (fscanf(file, "%d", &helper) != 1) helper = 0;
    fclose(file);
    double kb = mapped_by(parent) + block_of(parent) + (helper ? mapped_by(helper) : 0);
    return kb / 1024;
}

static void must(snell_status status) {
    if (status) die(snell_last_error()->text);
}

/* In a process of its own: says when the scene is loaded, commits it, and tells its size. */
static void load_and_commit(const char *path, int to) {
    snell_context *context;
    snell_scene *scene;
    snell_scene_stats stats = {.struct_size = sizeof stats};
    footprint sizes = {0};
    snell_load_desc desc = SNELL_INIT(load_desc);
    desc.memory_max = (uint64_t)4 << 30;
    sizes.import = -mapped_by(getpid()) / 1024;
    must(snell_context_create(NULL, &context));
    must(snell_scene_create(context, &scene));
    must(snell_scene_load(scene, path, &desc));
    bool told = write(to, "", 1) == 1;
    must(snell_scene_commit(scene, NULL, NULL));
    must(snell_scene_get_stats(scene, &stats));
    sizes.scene = (double)stats.memory_geometry / (1 << 20);
    sizes.tree = (double)stats.memory_accel / (1 << 20);
    _exit(told && write(to, &sizes, sizeof sizes) == sizeof sizes ? 0 : 1);
}

static footprint measure_memory(const char *path) {
    int ends[2], status;
    footprint result;
    double most = 0;
    char loaded;
    if (pipe(ends) != 0) die("no pipe");
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) die("cannot fork");
    if (child == 0) load_and_commit(path, ends[1]);
    close(ends[1]);
    struct pollfd waiting = {ends[0], POLLIN, 0};
    while (poll(&waiting, 1, 0) == 0) {
        double now = memory_of(child);
        if (!(now <= most)) most = now;
        usleep(500);
    }
    bool whole =
        read(ends[0], &loaded, 1) == 1 && read(ends[0], &result, sizeof result) == sizeof result;
    close(ends[0]);
    if (waitpid(child, &status, 0) != child || status != 0 || !whole) die("a load failed");
    result.import += most;
    return result;
}

/* ---- the table ---- */

enum { SNELL, ASSIMP, READERS, MEMORY_ROUNDS = 5 };
typedef struct row {
    const char *name;
    double size; /* MB */
    uint32_t triangles;
    summary seconds[READERS], cpu[READERS], peak[READERS], ratio, cpu_ratio;
    footprint memory;
} row;

static row measure_file(const char *name, const char *path, uint32_t rounds) {
    static double seconds[READERS][ROUNDS_MAX], cpu[READERS][ROUNDS_MAX], peak[READERS][ROUNDS_MAX];
    double ratio[ROUNDS_MAX], cpu_ratio[ROUNDS_MAX];
    uint32_t (*loads[READERS])(const char *) = {load_snell, NULL};
#if SNELL_HAS_ASSIMP
    loads[ASSIMP] = load_assimp;
#endif
    row r = {.name = name};
    FILE *file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) die("cannot open the file");
    r.size = (double)ftell(file) / 1e6;
    fclose(file);
    for (uint32_t i = 0; i < rounds; i++) {
        for (int turn = 0; turn < READERS; turn++) {
            int k = i % 2 ? READERS - 1 - turn : turn;
            cost c = loads[k] ? measure(loads[k], path) : (cost){NAN, NAN, NAN, 0};
            seconds[k][i] = c.seconds, cpu[k][i] = c.cpu, peak[k][i] = c.peak;
            if (k == SNELL) r.triangles = c.triangles;
        }
        ratio[i] = seconds[SNELL][i] / seconds[ASSIMP][i];
        cpu_ratio[i] = cpu[SNELL][i] / cpu[ASSIMP][i];
    }
    for (uint32_t i = 0; i < MEMORY_ROUNDS; i++) { /* a moment may be missed */
        footprint f = measure_memory(path);
        if (i == 0 || !(f.import <= r.memory.import)) r.memory = f;
    }
    for (int k = 0; k < READERS; k++) {
        r.seconds[k] = summarise(seconds[k], rounds);
        r.cpu[k] = summarise(cpu[k], rounds);
        r.peak[k] = summarise(peak[k], rounds);
    }
    r.ratio = summarise(ratio, rounds);
    r.cpu_ratio = summarise(cpu_ratio, rounds);
    return r;
}

static void print_row(const row *r, bool json, bool last) {
    if (json) {
        printf("  {\"name\": \"%s\", \"megabytes\": %.1f, \"triangles\": %u, \"seconds\": %.4f, "
               "\"cpu_seconds\": %.4f, \"peak_mib\": %.0f, \"import_mib\": %.1f, \"scene_mib\": "
               "%.1f, \"tree_mib\": %.1f",
               r->name, r->size, r->triangles, r->seconds[SNELL].median, r->cpu[SNELL].median,
               r->peak[SNELL].median, r->memory.import, r->memory.scene, r->memory.tree);
        if (SNELL_HAS_ASSIMP)
            printf(", \"assimp_seconds\": %.4f, \"assimp_cpu_seconds\": %.4f, \"assimp_peak_mib\": "
                   "%.0f, \"ratio\": %.3f, \"ratio_min\": %.3f, \"ratio_max\": %.3f, "
                   "\"cpu_ratio\": %.3f, \"cpu_ratio_min\": %.3f, \"cpu_ratio_max\": %.3f",
                   r->seconds[ASSIMP].median, r->cpu[ASSIMP].median, r->peak[ASSIMP].median,
                   r->ratio.median, r->ratio.low, r->ratio.high, r->cpu_ratio.median,
                   r->cpu_ratio.low, r->cpu_ratio.high);
        printf("}%s\n", last ? "" : ",");
        return;
    }
    printf("%-10s %7.1f MB %9u %8.3f s %6.0f MiB", r->name, r->size, r->triangles,
           r->seconds[SNELL].median, r->peak[SNELL].median);
    if (SNELL_HAS_ASSIMP)
        printf(" %8.3f s %6.0f MiB   %5.2f [%.2f, %.2f]   %5.2f [%.2f, %.2f]",
               r->seconds[ASSIMP].median, r->peak[ASSIMP].median, r->ratio.median, r->ratio.low,
               r->ratio.high, r->cpu_ratio.median, r->cpu_ratio.low, r->cpu_ratio.high);
    printf("   %4.0f MiB %4.0f %4.0f   %.2f %.2f\n", r->memory.import, r->memory.scene,
           r->memory.tree, r->memory.import / r->memory.scene,
           r->memory.import / (r->memory.scene + r->memory.tree));
    fflush(stdout);
}

static const char usage[] =
    "usage: bench-load [--triangles N] [--rounds N] [--folder DIR] [--keep] "
    "[--json] [glb|ply|ply-ascii|ply-bare|stl|stl-ascii|obj|obj-bare|FILE]...";

typedef struct settings {
    uint64_t triangles, rounds;
    const char *folder;
    bool keep, json;
} settings;

static row measure_format(const settings *s, size_t format) {
    char path[1024];
    snprintf(path, sizeof path, "%s/snell-%d-%s", s->folder, (int)getpid(), formats[format].file);
    if (s->keep) snprintf(path, sizeof path, "%s/%s", s->folder, formats[format].file);
    make_file(format, path, (uint32_t)s->triangles);
    row r = measure_file(formats[format].name, path, (uint32_t)s->rounds);
    if (!s->keep) unlink(path);
    return r;
}

static row measure_named(const settings *s, const char *name) {
    for (size_t k = 0; k < FORMATS; k++)
        if (strcmp(name, formats[k].name) == 0) return measure_format(s, k);
    const char *slash = strrchr(name, '/');
    return measure_file(slash ? slash + 1 : name, name, (uint32_t)s->rounds);
}

int main(int count, char **arguments) {
    settings s = {1000000, 11, access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp", false, false};
    int i = 1;
    for (; i < count && strncmp(arguments[i], "--", 2) == 0; i++) {
        const char *option = arguments[i];
        bool good = true;
        if (strcmp(option, "--json") == 0)
            s.json = true;
        else if (strcmp(option, "--keep") == 0)
            s.keep = true;
        else if (strcmp(option, "--folder") == 0 && i + 1 < count)
            s.folder = arguments[++i];
        else if (strcmp(option, "--triangles") == 0)
            good = read_number(arguments[++i], 18, 50000000, &s.triangles);
        else if (strcmp(option, "--rounds") == 0)
            good = read_number(arguments[++i], 1, ROUNDS_MAX, &s.rounds);
        else
            good = false;
        if (!good) die(usage);
    }
    if (s.json)
        printf("{\"rounds\": %u, \"files\": [\n", (unsigned)s.rounds);
    else
        printf("%-10s %10s %9s %10s %10s%s   at once scene tree   over scene, + tree\n", "", "file",
               "triangles", "snell", "peak",
               SNELL_HAS_ASSIMP ? "  libassimp       peak   ratio [least, most]   of CPU time      "
                                : "");
    size_t total = i < count ? (size_t)(count - i) : FORMATS;
    for (size_t k = 0; k < total; k++) {
        row r = i < count ? measure_named(&s, arguments[(size_t)i + k]) : measure_format(&s, k);
        print_row(&r, s.json, k + 1 == total);
    }
    if (s.json) printf("]}\n");
    return 0;
}
