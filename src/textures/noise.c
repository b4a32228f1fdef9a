/* Clouds, smoke and marble from gradient noise (Perlin, Improving Noise, SIGGRAPH 2002: the same
 * twelve gradients and quintic fade; corners are hashed instead of looked up in a table).
 *
 *     fbm         1/2 + 1/2 sum of gain^i noise(lacunarity^i p), i = 0 .. octaves - 1
 *     turbulence  sum of gain^i |noise(lacunarity^i p)|
 *     marble      1/2 + 1/2 sin(2 pi (x + distortion * turbulence(p)))
 *
 * with p in units of `size`, clamped to 0..1, is how much of color_b. An octave that the footprint
 * covers fades to its mean: it is whole where its cells are at least two footprints wide, gone where
 * they are less than one. */
#include "maths/functions.h"
#include "textures/texture.h"

#define NOISE_FIELDS(F, T)                                                                         \
    F(T, color_a, COLOR, DEFAULT(0, 0, 0), NOT_NEGATIVE, "", "where the noise is 0")               \
    F(T, color_b, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "", "where it is 1")                      \
    F(T, kind, CHOICE, DEFAULT(0), CHOICES("fbm|turbulence|marble"), "", "clouds, smoke, veins")   \
    F(T, size, FLOAT, DEFAULT(1), POSITIVE, "m", "of the largest features; of a stripe of marble") \
    F(T, octaves, INT, DEFAULT(6), RANGE(1, 16), "", "layers of ever finer noise")                 \
    F(T, lacunarity, FLOAT, DEFAULT(2), RANGE(1, 8), "", "how much finer each layer is")           \
    F(T, gain, FLOAT, DEFAULT(0.5f), RANGE(0, 1), "", "how much weaker each layer is")             \
    F(T, distortion, FLOAT, DEFAULT(1), NOT_NEGATIVE, "", "of marble: in stripes")                 \
    F(T, seed, INT, DEFAULT(0), RANGE(0, 1e9), "", "another number, another pattern")              \
    F(T, map, CHOICE, DEFAULT(MAP_OBJECT), CHOICES(MAP_CHOICES), "",                               \
      "object and triplanar: fills space; otherwise flat")
DESCRIBE(noise, NOISE_FIELDS)

enum { KIND_FBM, KIND_TURBULENCE, KIND_MARBLE };

/* The finalizer of SplitMix64 (Steele, Lea, Flood 2014) over the corner's three numbers. */
static uint64_t hash_corner(int64_t x, int64_t y, int64_t z, uint64_t seed) {
    uint64_t h = seed;
    const uint64_t parts[3] = {(uint64_t)x, (uint64_t)y, (uint64_t)z};
    for (int i = 0; i < 3; i++) {
        h = (h ^ parts[i]) + 0x9e3779b97f4a7c15u;
        h = (h ^ h >> 30) * 0xbf58476d1ce4e5b9u;
        h = (h ^ h >> 27) * 0x94d049bb133111ebu;
        h ^= h >> 31;
    }
    return h;
}

/* The dot product with one of the directions to the middles of a cube's twelve edges; four of them
 * come twice. */
static double corner_slope(uint64_t hash, double x, double y, double z) {
    unsigned h = (unsigned)(hash >> 60);
    double u = h < 8 ? x : y, v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
static double mix(double a, double b, double t) { return a + (b - a) * t; }

/* 0 at the corners of the cells, -1..1; of mean 0. */
static double gradient_noise(dvec3 p, uint64_t seed) {
    /* Beyond this doubles have no fraction to speak of. */
    if (!(fabs(p.x) < 0x1p40 && fabs(p.y) < 0x1p40 && fabs(p.z) < 0x1p40)) return 0;
    double x = floor(p.x), y = floor(p.y), z = floor(p.z);
    int64_t i = (int64_t)x, j = (int64_t)y, k = (int64_t)z;
    double value[8];
    x = p.x - x, y = p.y - y, z = p.z - z;
    for (int c = 0; c < 8; c++) {
        int a = c & 1, b = c >> 1 & 1, d = c >> 2;
        value[c] = corner_slope(hash_corner(i + a, j + b, k + d, seed), x - a, y - b, z - d);
    }
    double u = fade(x), v = fade(y), w = fade(z);
    double front = mix(mix(value[0], value[1], u), mix(value[2], value[3], u), v);
    double back = mix(mix(value[4], value[5], u), mix(value[6], value[7], u), v);
    return mix(front, back, w);
}

/* How much of a pattern of this period is left under a footprint. */
static double kept(double period, double width) {
    if (!(period < 2 * width)) return 1;
    return clamp01(period / width - 1);
}

/* The mean of |gradient_noise| over space (measured; tests/test_textures.c measures it again). */
static const double MEAN_ABSOLUTE = 0.2203;

static double sum_octaves(const noise_desc *n, dvec3 p, double width, bool absolute) {
    double sum = 0, weight = 1, period = 1;
    for (int i = 0; i < n->octaves; i++) {
        double share = kept(period, width), value = 0;
        if (share > 0)
            value =
                gradient_noise(dvec3_scale(p, 1 / period), (uint64_t)n->seed * 16 + (unsigned)i);
        if (absolute)
            sum += weight * mix(MEAN_ABSOLUTE, fabs(value), share);
        else
            sum += weight * share * value;
        weight *= (double)n->gain;
        period /= (double)n->lacunarity;
    }
    return sum;
}

static double noise_value(const noise_desc *n, dvec3 p, double width) {
    if (n->kind == KIND_FBM) return clamp01(0.5 + 0.5 * sum_octaves(n, p, width, false));
    double turbulence = sum_octaves(n, p, width, true);
    if (n->kind == KIND_TURBULENCE) return clamp01(turbulence);
    double turn = p.x + (double)n->distortion * turbulence;
    turn -= floor(turn);
    return 0.5 + 0.5 * kept(1, width) * fn_sin(2 * PI * turn);
}

static texel evaluate(const texture *t, const texture_point *point) {
    const noise_desc *n = t->desc;
    double width, scale = 1 / (double)n->size;
    dvec3 p = dvec3_scale(texture_solid(t->map, point, &width), scale);
    double part = clamp01(noise_value(n, p, width * scale));
    return (texel){dvec3_add(dvec3_scale(dvec3_from(n->color_a), 1 - part),
                             dvec3_scale(dvec3_from(n->color_b), part)),
                   1};
}

static bool filters(const void *desc) {
    (void)desc;
    return true;
}

const texture_type texture_noise = {
    .info = TYPE_INFO(CATEGORY_TEXTURE, noise, "noise", "clouds, smoke or marble"),
    .filters = filters,
    .evaluate = evaluate,
};
