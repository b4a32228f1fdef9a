/* A clear sky without its sun (light.directional with an angle is the sun): Preetham, Shirley,
 * Smits, A Practical Analytic Model for Daylight, SIGGRAPH 1999, appendix A. Luminance in cd/m^2 is
 * divided by 683, as every photometric figure here. Below the horizon is ground that reflects what
 * the sky and the sun send down. */
#include "lights/sky.h"

#include <stdlib.h>

#include "base/error.h"
#include "base/memory.h"
#include "lights/light.h"
#include "lights/sphere_map.h"
#include "maths/functions.h"

#define SKY_FIELDS(F, T)                                                                           \
    F(T, sun, VEC3, DEFAULT(0.4f, 0.5f, 0.3f), REQUIRED_DIRECTION, "",                             \
      "the direction towards the sun, at or over the horizon (+Y is up)")                          \
    F(T, turbidity, FLOAT, DEFAULT(3), RANGE(1.8, 10), "", "haze: 2 very clear, 3 clear, 6 hazy")  \
    F(T, scale, FLOAT, DEFAULT(1), NOT_NEGATIVE, "", "multiplies the sky's radiance")              \
    F(T, ground, COLOR, DEFAULT(0.2f, 0.2f, 0.2f), RANGE(0, 1), "",                                \
      "the fraction that the ground below the horizon reflects")                                   \
    F(T, visible, BOOL, DEFAULT(1), ANY, "", "camera rays see it; otherwise the background")
DESCRIBE(sky, SKY_FIELDS)

static const double LUMEN_PER_WATT = 683;
enum { GRID_WIDTH = 256, GRID_HEIGHT = 128 };

/* Perez' five coefficients of luminance Y and chromaticity x, y: slope times turbidity + base. */
static const double perez_slope[3][5] = {{0.1787, -0.3554, -0.0227, 0.1206, -0.0670},
                                         {-0.0193, -0.0665, -0.0004, -0.0641, -0.0033},
                                         {-0.0167, -0.0950, -0.0079, -0.0441, -0.0109}};
static const double perez_base[3][5] = {{-1.4630, 0.4275, 5.3251, -2.5771, 0.3703},
                                        {-0.2592, 0.0008, 0.2125, -0.8989, 0.0452},
                                        {-0.2608, 0.0092, 0.2102, -1.6537, 0.0529}};
/* Zenith chromaticity: rows by turbidity^2, turbidity, 1; columns by the sun's zenith angle^3, ^2,
 * ^1, 1. */
static const double zenith_x[3][4] = {{0.00166, -0.00375, 0.00209, 0},
                                      {-0.02903, 0.06377, -0.03202, 0.00394},
                                      {0.11693, -0.21196, 0.06052, 0.25886}};
static const double zenith_y[3][4] = {{0.00275, -0.00610, 0.00317, 0},
                                      {-0.04214, 0.08970, -0.04153, 0.00516},
                                      {0.15346, -0.26756, 0.06670, 0.26688}};

typedef struct sky_state {
    dvec3 sun;
    double coefficients[3][5], zenith[3]; /* of Y, x, y; the zenith's already divided by F there */
    double scale;
    dvec3 ground; /* radiance */
    sphere_map map;
} sky_state;

static snell_status check(const void *desc) {
    const sky_desc *l = desc;
    if (l->sun.y >= 0) return SNELL_OK;
    return error_set(SNELL_ERR_ARGUMENT, "its y must be 0 or more",
                     "sky: the sun is below the horizon");
}

/* F of an angle from the zenith and an angle from the sun, each by its cosine. */
static double perez(const double c[5], double cos_zenith, double cos_sun) {
    double from_sun = fn_acos(cos_sun < -1 ? -1 : cos_sun > 1 ? 1 : cos_sun);
    return (1 + c[0] * fn_exp(c[1] / double_max(cos_zenith, 0.01))) *
           (1 + c[2] * fn_exp(c[3] * from_sun) + c[4] * cos_sun * cos_sun);
}

static double zenith_chromaticity(const double table[3][4], double t, double angle) {
    const double turbidity[3] = {t * t, t, 1};
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += turbidity[i] *
               (((table[i][0] * angle + table[i][1]) * angle + table[i][2]) * angle + table[i][3]);
    return sum;
}

/* From CIE xyY to linear Rec. 709; what lies outside is cut off at 0. */
static dvec3 rgb_from(double x, double y, double luminance) {
    double big_x = x / y * luminance, big_z = (1 - x - y) / y * luminance;
    dvec3 c = {3.2404542 * big_x - 1.5371385 * luminance - 0.4985314 * big_z,
               -0.9692660 * big_x + 1.8760108 * luminance + 0.0415560 * big_z,
               0.0556434 * big_x - 0.2040259 * luminance + 1.0572252 * big_z};
    return (dvec3){double_max(c.x, 0), double_max(c.y, 0), double_max(c.z, 0)};
}

static dvec3 look_up(const void *user, dvec3 d) {
    const sky_state *s = user;
    if (d.y < 0) return s->ground;
    double cos_sun = dvec3_dot(d, s->sun), value[3];
    for (int i = 0; i < 3; i++) value[i] = s->zenith[i] * perez(s->coefficients[i], d.y, cos_sun);
    return dvec3_scale(rgb_from(value[1], value[2], double_max(value[0], 0)), s->scale);
}

static void fill_state(const sky_desc *l, sky_state *s) {
    double t = (double)l->turbidity;
    s->sun = dvec3_normalize(dvec3_from(l->sun));
    double sun_angle = fn_acos(clamp01(s->sun.y));
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 5; k++)
            s->coefficients[i][k] = perez_slope[i][k] * t + perez_base[i][k];
    double chi = (4.0 / 9 - t / 120) * (PI - 2 * sun_angle);
    double luminance = (4.0453 * t - 4.9710) * fn_tan(chi) - 0.2155 * t + 2.4192; /* kcd/m^2 */
    s->zenith[0] = double_max(luminance, 0) * 1000 / LUMEN_PER_WATT;
    s->zenith[1] = zenith_chromaticity(zenith_x, t, sun_angle);
    s->zenith[2] = zenith_chromaticity(zenith_y, t, sun_angle);
    for (int i = 0; i < 3; i++) s->zenith[i] /= perez(s->coefficients[i], 1, s->sun.y);
    s->scale = (double)l->scale;
}

/* Extraterrestrial sunlight, 133.8 klx (Kasten and Young's air mass; Rayleigh and aerosol
 * extinction after Preetham et al., appendix 2, at 650, 550 and 450 nm). */
dvec3 sky_sun_irradiance(double elevation, double turbidity) {
    static const double micrometres[3] = {0.65, 0.55, 0.45};
    double height = clamp01(elevation), zenith = fn_acos(height);
    double mass = 1 / (height + 0.15 * fn_pow(93.885 - zenith * (180 / PI), -1.253));
    double beta = 0.04608 * turbidity - 0.04586, left[3];
    for (int i = 0; i < 3; i++) {
        double rayleigh = 0.008735 * fn_pow(micrometres[i], -4.08);
        double aerosol = beta * fn_pow(micrometres[i], -1.3);
        left[i] = fn_exp(-mass * (rayleigh + aerosol)) * (133800 / LUMEN_PER_WATT);
    }
    return (dvec3){left[0], left[1], left[2]};
}

static void release(void *state) {
    sky_state *s = state;
    if (s) sphere_map_free(&s->map);
    free(s);
}

/* The map is made twice: the ground reflects what the sky above it sends. */
static snell_status prepare(const void *desc, const texture *textures, thread_pool *pool,
                            void **state) {
    (void)textures;
    static const sphere_grid coarse = {GRID_WIDTH, GRID_HEIGHT, 1, false},
                             fine = {GRID_WIDTH, GRID_HEIGHT, 2, false};
    const sky_desc *l = desc;
    sky_state *s = memory_zeroed(1, sizeof *s);
    if (s == NULL) return error_no_memory();
    fill_state(l, s);
    snell_status status = sphere_map_build(&coarse, pool, look_up, s, &s->map);
    if (!status) {
        dvec3 down = sphere_map_irradiance(&s->map, (dvec3){0, 1, 0});
        dvec3 sun = sky_sun_irradiance(s->sun.y, (double)l->turbidity);
        down = dvec3_add(down, dvec3_scale(sun, s->sun.y * s->scale));
        s->ground = dvec3_scale(dvec3_mul(dvec3_from(l->ground), down), 1 / PI);
        sphere_map_free(&s->map);
        status = sphere_map_build(&fine, pool, look_up, s, &s->map);
    }
    if (status)
        release(s);
    else
        *state = s;
    return status;
}

static dvec3 radiance(const light *l, dvec3 d) { return look_up(l->state, d); }

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)p, (void)eye;
    const sky_state *s = l->state;
    dvec3 d;
    double pdf;
    if (!sphere_map_sample(&s->map, u, &d, &pdf)) return false;
    *out = (light_sample){d, d, true, look_up(s, d), pdf};
    return true;
}

static double pdf(const light *l, dvec3 d) {
    return sphere_map_pdf(&((const sky_state *)l->state)->map, d);
}

static dvec3 irradiance(const light *l, dvec3 n) {
    return sphere_map_irradiance(&((const sky_state *)l->state)->map, n);
}

static dvec3 power(const light *l, double scene_radius) {
    const sky_state *s = l->state;
    return dvec3_scale(s->map.mean, 4 * PI * PI * scene_radius * scene_radius);
}

static double brightest(const light *l) { return ((const sky_state *)l->state)->map.brightest; }

static bool is_visible(const void *desc) { return ((const sky_desc *)desc)->visible; }

const light_type light_sky = {
    .info = TYPE_INFO(CATEGORY_LIGHT, sky, "sky", "a clear sky by day, without the sun itself"),
    .check = check,
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
