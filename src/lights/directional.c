/* Light from infinitely far away, such as the sun: no falloff. With an angle it comes from a disk
 * in the sky, whose shadows have soft edges and which rays can see. */
#include "lights/light.h"

#include "maths/functions.h"
#include "sampling/warp.h"

#define DIRECTIONAL_FIELDS(F, T)                                                                   \
    F(T, direction, VEC3, DEFAULT(0, -1, 0), REQUIRED_DIRECTION, "", "the way the light travels")  \
    F(T, irradiance, COLOR, DEFAULT(1, 1, 1), NOT_NEGATIVE, "W/m^2", "on a surface that faces it") \
    F(T, angle, FLOAT, DEFAULT(0), RANGE(0, 3.1415926), "rad",                                     \
      "across the disk that it comes from: the sun's is 0.53 degrees; 0: one direction")           \
    F(T, visible, BOOL, DEFAULT(1), ANY, "", "camera rays see the disk")
DESCRIBE(directional, DIRECTIONAL_FIELDS)

static dvec3 towards(const directional_desc *l) {
    return dvec3_normalize(dvec3_negate(dvec3_from(l->direction)));
}

/* 1 - cos of the disk's half-angle, as 2 sin^2 of a quarter, which is exact for small disks. */
static double disk_height(const directional_desc *l) {
    double s = fn_sin((double)l->angle / 4);
    return 2 * s * s;
}

/* A disk of uniform radiance L and half-angle a gives the irradiance pi L sin^2 a. */
static dvec3 disk_radiance(const directional_desc *l) {
    double s = fn_sin((double)l->angle / 2);
    return dvec3_scale(dvec3_from(l->irradiance), 1 / (PI * s * s));
}

static bool middle(const light *l, light_sample *out) {
    const directional_desc *desc = l->desc;
    dvec3 d = towards(desc);
    *out = (light_sample){d, d, true, dvec3_from(desc->irradiance), 0};
    return true;
}

static bool sample(const light *l, dvec3 p, dvec3 eye, sample2 u, light_sample *out) {
    (void)p, (void)eye;
    const directional_desc *desc = l->desc;
    dvec3 d = towards(desc);
    middle(l, out);
    if (!(desc->angle > 0)) return true;
    double height = disk_height(desc);
    out->to_light = out->to_end = dvec3_normalize(dvec3_from_frame(d, warp_cone(u, height)));
    out->light = disk_radiance(desc);
    out->pdf = 1 / (2 * PI * height);
    return true;
}

/* Inside the disk? The chord between two unit vectors has the squared length 2 (1 - cos). */
static bool is_inside(const directional_desc *l, dvec3 d) {
    dvec3 chord = dvec3_sub(d, towards(l));
    return l->angle > 0 && dvec3_dot(chord, chord) <= 2 * disk_height(l);
}

static dvec3 radiance(const light *l, dvec3 d) {
    return is_inside(l->desc, d) ? disk_radiance(l->desc) : (dvec3){0, 0, 0};
}

static double pdf(const light *l, dvec3 d) {
    return is_inside(l->desc, d) ? 1 / (2 * PI * disk_height(l->desc)) : 0;
}

static dvec3 power(const light *l, double scene_radius) {
    const directional_desc *desc = l->desc;
    return dvec3_scale(dvec3_from(desc->irradiance), PI * scene_radius * scene_radius);
}

static bool is_visible(const void *desc) { return ((const directional_desc *)desc)->visible; }

const light_type light_directional = {
    .info = TYPE_INFO(CATEGORY_LIGHT, directional, "directional", "parallel light from far away"),
    .sample = sample,
    .middle = middle,
    .radiance = radiance,
    .pdf = pdf,
    .power = power,
    .casts_shadow = true,
    .is_visible = is_visible,
};
