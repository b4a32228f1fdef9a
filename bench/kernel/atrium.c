/* A vaulted hall with two storeys of arcades: triangles from walls 30 m long to beads of a few
 * mm. */
#include "maths/functions.h"
#include "parts.h"

/* Metres: the hall is 2 * LENGTH long (x), the court between the arcades 2 * COURT wide (z). */
#define LENGTH 15.0
#define COURT 3.6
#define WIDTH 6.6
#define GALLERY 5.0 /* height of the upper floor */
#define SPRING 9.2  /* where the vault begins */
enum { BAYS = 10 };
#define BAY (2 * LENGTH / BAYS)

/* ---- floor ---- */

/* A slab with worn edges, a little out of true. */
static void add_tile(bench_scene *s, rng *r, double x0, double z0, double x1, double z1) {
    double gap = 0.004, bevel = 0.008 + 0.01 * rng_unit(r), top = 0.004 * rng_unit(r);
    dvec3 low[4] = {{x0 + gap, -0.03, z0 + gap},
                    {x0 + gap, -0.03, z1 - gap},
                    {x1 - gap, -0.03, z1 - gap},
                    {x1 - gap, -0.03, z0 + gap}};
    dvec3 high[4];
    for (int i = 0; i < 4; i++) {
        double inward_x = i < 2 ? bevel : -bevel, inward_z = i == 0 || i == 3 ? bevel : -bevel;
        high[i] = (dvec3){low[i].x + inward_x, top + 0.003 * rng_unit(r), low[i].z + inward_z};
    }
    bench_add_quad(s, high[0], high[1], high[2], high[3]);
    for (int i = 0; i < 4; i++)
        bench_add_quad(s, low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]);
}

static void add_floor(bench_scene *s, rng *r, double detail) {
    double tile = 0.55 / sqrt(detail);
    for (double z = -WIDTH; z < WIDTH;) {
        double z1 = double_min(z + tile * (0.5 + rng_unit(r)), WIDTH);
        for (double x = -LENGTH; x < LENGTH;) {
            double x1 = double_min(x + tile * (0.5 + 1.5 * rng_unit(r)), LENGTH);
            add_tile(s, r, x, z, x1, z1);
            x = x1;
        }
        z = z1;
    }
    bench_add_quad(s, (dvec3){-LENGTH, -0.03, -WIDTH}, (dvec3){-LENGTH, -0.03, WIDTH},
                   (dvec3){LENGTH, -0.03, WIDTH}, (dvec3){LENGTH, -0.03, -WIDTH});
}

/* ---- walls and vault ---- */

/* Along the hall: two triangles for each step of the profile (z inwards from the wall, y). */
static void add_cornice(bench_scene *s, double wall, double height, double size) {
    enum { STEPS = 9 };
    double inward = wall < 0 ? 1 : -1;
    for (int i = 0; i < STEPS; i++) {
        dvec3 p[2];
        for (int k = 0; k < 2; k++) {
            double turn = PI / 2 * (i + k) / STEPS;
            p[k] = (dvec3){0, height + size * fn_sin(turn),
                           wall + inward * size * (1.2 - fn_cos(turn))};
        }
        bench_add_quad(s, (dvec3){-LENGTH, p[0].y, p[0].z}, (dvec3){LENGTH, p[0].y, p[0].z},
                       (dvec3){LENGTH, p[1].y, p[1].z}, (dvec3){-LENGTH, p[1].y, p[1].z});
    }
}

static dvec3 vault_point(const void *user, double u, double v) {
    const uint32_t *coffers = user; /* along and across */
    double x = fn_sin(PI * u * coffers[0]), y = fn_sin(PI * v * coffers[1]);
    double depth = 0.25 * clamp01(3 * x * x - 0.5) * clamp01(3 * y * y - 0.5);
    double turn = PI * v, radius = COURT + 0.15 + depth;
    return (dvec3){LENGTH * (2 * u - 1), SPRING + 0.9 * radius * fn_sin(turn),
                   -radius * fn_cos(turn)};
}

static void add_shell(bench_scene *s, double detail) {
    static const uint32_t coffers[2] = {20, 8};
    for (int side = -1; side <= 1; side += 2) {
        double z = side * WIDTH, x = side * LENGTH, court = side * (COURT + 0.15);
        bench_add_quad(s, (dvec3){-LENGTH, 0, z}, (dvec3){LENGTH, 0, z}, (dvec3){LENGTH, SPRING, z},
                       (dvec3){-LENGTH, SPRING, z});
        bench_add_quad(s, (dvec3){x, 0, -WIDTH}, (dvec3){x, 0, WIDTH}, (dvec3){x, 14, WIDTH},
                       (dvec3){x, 14, -WIDTH});
        bench_add_quad(s, (dvec3){-LENGTH, SPRING, z}, (dvec3){LENGTH, SPRING, z},
                       (dvec3){LENGTH, SPRING, court}, (dvec3){-LENGTH, SPRING, court});
        bench_add_box(s, (dvec3){-LENGTH, GALLERY - 0.3, double_min(z, court - side * 0.5)},
                      (dvec3){LENGTH, GALLERY, double_max(z, court - side * 0.5)});
        add_cornice(s, z, 4.2, 0.4);
        add_cornice(s, z, SPRING - 0.5, 0.4);
        add_cornice(s, z, 1.1, 0.08);
    }
    bench_add_sheet(s, bench_steps(150, detail, 40), bench_steps(72, detail, 16), false,
                    vault_point, coffers);
}

/* ---- arcades ---- */

static const bench_profile column[] = {
    {0.34, 0},    {0.34, 0.12}, {0.30, 0.14}, {0.33, 0.20}, {0.30, 0.26}, {0.25, 0.28},
    {0.24, 0.6},  {0.24, 1},    {0.235, 1.4}, {0.23, 1.8},  {0.22, 2.2},  {0.21, 2.5},
    {0.24, 2.53}, {0.22, 2.57}, {0.26, 2.7},  {0.34, 2.85}, {0.40, 2.9},  {0.40, 3}};
enum { COLUMN_POINTS = sizeof column / sizeof *column };

/* `height` metres high instead of 3. */
static void add_column(bench_scene *s, double x, double z, double base, double height,
                       double detail) {
    bench_profile p[COLUMN_POINTS];
    for (int i = 0; i < COLUMN_POINTS; i++)
        p[i] = (bench_profile){column[i].radius * height / 3, column[i].height * height / 3};
    bench_add_lathe(s, (dvec3){x, base, z}, p, COLUMN_POINTS, 54, 18, detail);
}

/* A half circle of stone over an opening, and the wall above it up to `top`. */
static void add_arch(bench_scene *s, double middle, double z, double spring, double radius,
                     double top, double detail) {
    enum { RINGS_MAX = 256 };
    bench_ring rings[RINGS_MAX];
    uint32_t steps = bench_steps(24, detail, 6);
    if (steps > RINGS_MAX - 1) steps = RINGS_MAX - 1;
    for (uint32_t i = 0; i <= steps; i++) {
        double turn = PI * i / steps;
        rings[i].center =
            (dvec3){middle - radius * fn_cos(turn), spring + radius * fn_sin(turn), z};
        rings[i].radius = 0.16;
    }
    bench_add_tube(s, rings, steps + 1, bench_steps(10, detail, 5));
    for (double face = -0.15; face <= 0.15; face += 0.3)
        for (uint32_t i = 0; i < steps; i++) {
            dvec3 a = rings[i].center, b = rings[i + 1].center;
            a.z = b.z = z + face;
            bench_add_quad(s, a, b, (dvec3){b.x, top, b.z}, (dvec3){a.x, top, a.z});
        }
}

static const bench_profile baluster[] = {{0.07, 0},     {0.07, 0.05}, {0.04, 0.07}, {0.055, 0.12},
                                         {0.075, 0.22}, {0.07, 0.3},  {0.04, 0.42}, {0.03, 0.55},
                                         {0.045, 0.6},  {0.04, 0.68}, {0.06, 0.72}, {0.06, 0.78}};

static void add_balustrade(bench_scene *s, double z, double detail) {
    enum { BALUSTERS = 88 };
    for (int i = 0; i < BALUSTERS; i++) {
        double x = LENGTH * (2 * (i + 0.5) / BALUSTERS - 1);
        bench_add_lathe(s, (dvec3){x, GALLERY, z}, baluster, sizeof baluster / sizeof *baluster, 12,
                        0, detail);
    }
    bench_add_box(s, (dvec3){-LENGTH, GALLERY + 0.78, z - 0.1},
                  (dvec3){LENGTH, GALLERY + 0.86, z + 0.1});
}

static void add_arcades(bench_scene *s, double detail) {
    for (int side = -1; side <= 1; side += 2) {
        double z = side * COURT;
        for (int i = 0; i <= BAYS; i++) add_column(s, -LENGTH + i * BAY, z, 0, 3, detail);
        for (int i = 0; i < BAYS; i++)
            add_arch(s, -LENGTH + (i + 0.5) * BAY, z, 3, BAY / 2, GALLERY - 0.3, detail);
        for (int i = 0; i <= 2 * BAYS; i++)
            add_column(s, -LENGTH + i * BAY / 2, z, GALLERY, 2.4, 0.25 * detail);
        for (int i = 0; i < 2 * BAYS; i++)
            add_arch(s, -LENGTH + (i + 0.5) * BAY / 2, z, GALLERY + 2.4, BAY / 4, SPRING,
                     0.4 * detail);
        add_balustrade(s, z - side * 0.3, detail);
    }
}

/* ---- ornaments ---- */

static const bench_profile vase[] = {{0.001, 0.9}, {0.16, 0.9},  {0.2, 0.92},  {0.12, 0.97},
                                     {0.08, 1.03}, {0.14, 1.1},  {0.24, 1.22}, {0.30, 1.36},
                                     {0.31, 1.5},  {0.27, 1.64}, {0.18, 1.75}, {0.13, 1.84},
                                     {0.14, 1.9},  {0.2, 1.98},  {0.22, 2.0},  {0.19, 1.98}};

static void add_vases(bench_scene *s, double detail) {
    for (int i = 0; i < 12; i++) {
        double x = -12.5 + 5 * (i % 6), z = i < 6 ? -2.7 : 2.7;
        bench_add_box(s, (dvec3){x - 0.28, 0, z - 0.28}, (dvec3){x + 0.28, 0.9, z + 0.28});
        bench_add_lathe(s, (dvec3){x, 0, z}, vase, sizeof vase / sizeof *vase, 48, i % 3 ? 0 : 16,
                        detail);
    }
}

typedef struct curtain {
    double x, z, width;
    uint64_t seed;
} curtain;

static dvec3 curtain_point(const void *user, double u, double v) {
    const curtain *c = user;
    double phase = (double)(c->seed % 100), sway = 0.3 + 0.7 * v;
    double fold = 0.12 * sway * fn_sin(40 * u + phase) + 0.05 * fn_sin(95 * u + 3 * v + phase);
    return (dvec3){c->x + c->width * (u - 0.5) * (1 - 0.2 * fn_sin(PI * v)), 4.6 - 3.4 * v,
                   c->z + fold};
}

/* A line that hangs from one column to the next, with beads. */
static void add_garland(bench_scene *s, double x0, double x1, double y, double z, double detail) {
    enum { RINGS = 25 };
    bench_ring rings[RINGS];
    for (int i = 0; i < RINGS; i++) {
        double u = (double)i / (RINGS - 1);
        rings[i].center = (dvec3){x0 + (x1 - x0) * u, y - 2.4 * u * (1 - u), z};
        rings[i].radius = 0.012 + 0.02 * (i % 3 == 1);
    }
    bench_add_tube(s, rings, RINGS, bench_steps(6, detail, 3));
}

static dvec3 statue_point(const void *user, dvec3 d) {
    (void)user;
    double lumps = bench_noise_sum(dvec3_scale(d, 2.3), 5, 0.5, false);
    dvec3 p = dvec3_scale(d, 0.6 + 0.35 * lumps);
    return (dvec3){12.3 + p.x, 2.2 + 1.9 * p.y, p.z};
}

static dvec3 bead_point(const void *user, dvec3 d) {
    const bench_ring *at = user;
    return dvec3_add(at->center, dvec3_scale((dvec3){d.x, 1.8 * d.y, d.z}, at->radius));
}

static void add_chandelier(bench_scene *s, double x, double y, double detail) {
    enum { AROUND = 41 };
    bench_ring rings[AROUND];
    for (int tier = 0; tier < 3; tier++) {
        double radius = 1.1 - 0.32 * tier, height = y + 0.45 * tier;
        for (int i = 0; i < AROUND; i++) {
            double turn = 2 * PI * i / (AROUND - 1);
            rings[i].center = (dvec3){x + radius * fn_cos(turn), height, radius * fn_sin(turn)};
            rings[i].radius = 0.03;
            bench_ring bead = {{rings[i].center.x, height - 0.09, rings[i].center.z}, 0.022};
            if (i) bench_add_body(s, bench_steps(3, detail, 1), bead_point, &bead);
        }
        bench_add_tube(s, rings, AROUND, bench_steps(6, detail, 3));
    }
    bench_ring rod[2] = {{{x, y, 0}, 0.02}, {{x, SPRING + COURT, 0}, 0.02}};
    bench_add_tube(s, rod, 2, 6);
}

static void add_ornaments(bench_scene *s, rng *r, double detail) {
    add_vases(s, detail);
    for (int i = 0; i < BAYS; i++) {
        curtain c = {-LENGTH + (i + 0.5) * BAY, i % 2 ? -5.6 : 5.6, 2.2, rng_bits(r)};
        bench_add_sheet(s, bench_steps(38, detail, 10), bench_steps(20, detail, 4), false,
                        curtain_point, &c);
        for (int side = -1; side <= 1; side += 2)
            add_garland(s, -LENGTH + i * BAY, -LENGTH + (i + 1) * BAY, 3.1, side * (COURT - 0.35),
                        detail);
    }
    bench_add_body(s, bench_steps(32, detail, 8), statue_point, NULL);
    bench_add_box(s, (dvec3){11.6, 0, -0.7}, (dvec3){13, 1.3, 0.7});
    for (int i = 0; i < 3; i++) add_chandelier(s, 7.5 * (i - 1), 7.6, detail);
}

void bench_scene_atrium(bench_scene *s, double detail) {
    rng r = {1};
    add_floor(s, &r, detail);
    add_shell(s, detail);
    add_arcades(s, detail);
    add_ornaments(s, &r, detail);
    s->camera = (bench_camera){{-12.2, 1.75, 1.1}, {4, 4, -0.6}, 72};
    s->light = (dvec3){-2.5, 8.6, 0.9};
}
