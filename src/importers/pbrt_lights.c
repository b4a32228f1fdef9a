/* pbrt's lights. Each is scaled so that the luminance of its spectrum counts as 1 (pbrt_spectrum.c), by
 * its own `scale` and `power` or `illuminance`, and by the film's imaging ratio. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

static const double white[3] = {1, 1, 1};

static snell_status add_light(pbrt *p, source_place place, const char *type,
                              const snell_param *params, size_t count) {
    uint32_t made;
    object_source source = {NULL, place.file, place.line};
    return pbrt_blame(p, place,
                      description_add(p->d, CATEGORY_LIGHT, type, params, count, source, &made));
}

/* A light's spectrum times scale and what the film makes of it. */
static vec3 read_emission(pbrt *p, const pbrt_params *params, const char *name, double *scale) {
    double color[3], own = pbrt_float(p, params, "scale", 1);
    bool found;
    pbrt_color(p, params, name, PBRT_LIGHT, white, color, &found);
    if (!p->status && !(own >= 0 && own < 1e30))
        pbrt_fail(p, params->place, NULL, "%s: 'scale' is not negative", params->what);
    if (scale) *scale = own;
    double f = own * p->light_factor;
    return (vec3){(float)(color[0] * f * p->white[0]), (float)(color[1] * f * p->white[1]),
                  (float)(color[2] * f * p->white[2])};
}

static snell_param color_param(const char *name, vec3 v, double factor) {
    return (snell_param){name, SNELL_PARAM_VEC3, {.v = vec3_scale(v, (float)factor)}};
}

static snell_status warn_of_motion(pbrt *p, const pbrt_params *params) {
    return pbrt_is_animated(p) ? pbrt_warn(p, params->place,
                                           "lights do not move: they stand where "
                                           "they are at the start")
                               : p->status;
}

/* power over the solid angle, in place of the intensity. */
static double power_factor(pbrt *p, const pbrt_params *params, double solid_angle) {
    double power = pbrt_float(p, params, "power", -1);
    return power > 0 ? power / solid_angle : 1;
}

static snell_status point_light(pbrt *p, const pbrt_params *params) {
    vec3 intensity = read_emission(p, params, "I", NULL);
    double factor = power_factor(p, params, 4 * PI);
    dvec3 from = pbrt_vec3(p, params, "from", (dvec3){0, 0, 0});
    if (p->status) return p->status;
    dtransform to_world = pbrt_to_world(p, 0);
    const snell_param list[] = {
        {"position", SNELL_PARAM_VEC3, {.v = vec3_from(pbrt_point(&to_world, from))}},
        color_param("intensity", intensity, factor)};
    return add_light(p, params->place, "point", list, 2);
}

static snell_status cone_light(pbrt *p, const pbrt_params *params, vec3 intensity, double cone,
                               double blend, dvec3 from, dvec3 to) {
    dtransform to_world = pbrt_to_world(p, 0);
    dvec3 position = pbrt_point(&to_world, from), at = pbrt_point(&to_world, to);
    const snell_param list[] = {{"position", SNELL_PARAM_VEC3, {.v = vec3_from(position)}},
                                {"at", SNELL_PARAM_VEC3, {.v = vec3_from(at)}},
                                color_param("intensity", intensity, 1),
                                {"cone", SNELL_PARAM_FLOAT, {.f = cone * (PI / 180)}},
                                {"blend", SNELL_PARAM_FLOAT, {.f = blend * (PI / 180)}}};
    return p->status ? p->status : add_light(p, params->place, "spot", list, 5);
}

static snell_status spot_light(pbrt *p, const pbrt_params *params) {
    vec3 intensity = read_emission(p, params, "I", NULL);
    double cone = pbrt_float(p, params, "coneangle", 30),
           blend = pbrt_float(p, params, "conedeltaangle", 5);
    if (!p->status && !(cone > 0.01 && cone <= 180 && blend >= 0 && blend <= cone))
        return pbrt_fail(p, params->place, "'conedeltaangle' is a part of it, in degrees",
                         "a spot light cannot have a 'coneangle' of %g", cone);
    double outer = fn_cos(cone * (PI / 180)), inner = fn_cos((cone - blend) * (PI / 180)),
           factor = power_factor(p, params, 2 * PI * (1 - inner + (inner - outer) / 2));
    dvec3 from = pbrt_vec3(p, params, "from", (dvec3){0, 0, 0}),
          to = pbrt_vec3(p, params, "to", (dvec3){0, 0, 1});
    return cone_light(p, params, vec3_scale(intensity, (float)factor), cone, blend, from, to);
}

static snell_status distant_light(pbrt *p, const pbrt_params *params) {
    vec3 irradiance = read_emission(p, params, "L", NULL);
    double wanted = pbrt_float(p, params, "illuminance", -1);
    dvec3 from = pbrt_vec3(p, params, "from", (dvec3){0, 0, 0}),
          to = pbrt_vec3(p, params, "to", (dvec3){0, 0, 1});
    if (p->status) return p->status;
    dtransform to_world = pbrt_to_world(p, 0);
    dvec3 way = pbrt_vector(&to_world, dvec3_sub(to, from));
    if (!(dvec3_length(way) > 0))
        return pbrt_fail(p, params->place, "move one of them",
                         "a distant light's 'from' and 'to' are the same point");
    const snell_param list[] = {
        {"direction", SNELL_PARAM_VEC3, {.v = vec3_from(dvec3_normalize(way))}},
        color_param("irradiance", irradiance, wanted > 0 ? wanted : 1)};
    return add_light(p, params->place, "directional", list, 2);
}

/* ---- pictures on lights ---- */

typedef struct picture {
    decoded_image image;
    bool found;
} picture;

/* Of the parameter `filename`, where there is one. */
static snell_status read_picture(pbrt *p, const pbrt_params *params, picture *out) {
    *out = (picture){.found = false};
    const pbrt_param *param = pbrt_find(params, "filename");
    const char *name = pbrt_string(p, params, "filename", NULL);
    if (p->status || name == NULL || name[0] == 0) return p->status;
    return pbrt_read_image(p, name, param->place, &out->image, &out->found);
}

static void mean_of(const decoded_image *image, double out[3]) {
    double sum[3] = {0, 0, 0}, c[3], count = (double)image->width * image->height;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            pbrt_pixel(image, 0, x, y, c);
            for (int i = 0; i < 3; i++) sum[i] += c[i] / count;
        }
    memcpy(out, sum, sizeof sum);
}

/* The mean in every direction. */
static snell_status goniometric_light(pbrt *p, const pbrt_params *params) {
    picture seen;
    double mean[3] = {1, 1, 1};
    if (read_picture(p, params, &seen)) return p->status;
    if (seen.found) {
        mean_of(&seen.image, mean);
        image_free(&seen.image);
        pbrt_warn(
            p, params->place,
            "the picture of a goniometric light is not supported: it shines everywhere alike");
    }
    double luminance = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
    vec3 intensity = read_emission(p, params, "I", NULL);
    /* pbrt's power is that of the picture. */
    double factor = power_factor(p, params, 4 * PI * luminance) * luminance;
    if (p->status) return p->status;
    dtransform to_world = pbrt_to_world(p, 0);
    const snell_param list[] = {
        {"position", SNELL_PARAM_VEC3, {.v = vec3_from(pbrt_point(&to_world, (dvec3){0, 0, 0}))}},
        color_param("intensity", intensity, luminance > 0 ? factor : 0)};
    return add_light(p, params->place, "point", list, 2);
}

/* A round cone of the picture's width in its mean colour. */
static snell_status projection_light(pbrt *p, const pbrt_params *params) {
    picture seen;
    double mean[3] = {1, 1, 1}, fov = pbrt_float(p, params, "fov", 90),
           scale = pbrt_float(p, params, "scale", 1) * p->light_factor;
    if (read_picture(p, params, &seen)) return p->status;
    if (seen.found) {
        mean_of(&seen.image, mean);
        image_free(&seen.image);
    }
    pbrt_warn(
        p, params->place,
        "the picture of a projection light is not supported: it is a spot of its mean colour");
    if (!p->status && !(fov > 0.1 && fov < 179.9))
        return pbrt_fail(p, params->place, NULL, "a projection light cannot have a 'fov' of %g",
                         fov);
    double luminance = 0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2];
    double round = 2 * PI * (1 - fn_cos(fov * (PI / 360)));
    double factor = scale * (luminance > 0 ? power_factor(p, params, round * luminance) : 0);
    vec3 intensity = {(float)(mean[0] * factor), (float)(mean[1] * factor),
                      (float)(mean[2] * factor)};
    return cone_light(p, params, intensity, fov / 2, 0, (dvec3){0, 0, 0}, (dvec3){0, 0, 1});
}

/* ---- the surroundings ---- */

/* The equal-area map of the sphere to a square: Clarberg, Fast Equal-Area Mapping of the (Hemi)Sphere
 * using SIMD, Journal of Graphics Tools 13(3), 2008. d: unit. */
static void square_of(dvec3 d, double *u, double *v) {
    double x = fabs(d.x), y = fabs(d.y), r = sqrt(double_max(0, 1 - fabs(d.z)));
    double turn = fn_atan2(y, x) * (2 / PI); /* 0 to 1 over the quadrant */
    double a = r * (1 - turn), b = r * turn;
    if (d.z < 0) {
        double swap = a;
        a = 1 - b;
        b = 1 - swap;
    }
    *u = ((d.x < 0 ? -a : a) + 1) / 2;
    *v = ((d.y < 0 ? -b : b) + 1) / 2;
}

/* Beyond an edge the square goes on on the other half of that edge. */
static void wrapped_pixel(const decoded_image *image, long x, long y, double out[3]) {
    long w = (long)image->width, h = (long)image->height;
    if (x < 0) x = -x - 1, y = h - 1 - y;
    if (x >= w) x = 2 * w - 1 - x, y = h - 1 - y;
    if (y < 0) y = -y - 1, x = w - 1 - x;
    if (y >= h) y = 2 * h - 1 - y, x = w - 1 - x;
    x = x < 0 ? 0 : x >= w ? w - 1 : x;
    y = y < 0 ? 0 : y >= h ? h - 1 : y;
    pbrt_pixel(image, 0, (uint32_t)x, (uint32_t)y, out);
}

static void look_up(const decoded_image *image, dvec3 d, double out[3]) {
    double u, v;
    square_of(d, &u, &v);
    double x = u * image->width - 0.5, y = v * image->height - 0.5;
    long x0 = (long)floor(x), y0 = (long)floor(y);
    double fx = x - (double)x0, fy = y - (double)y0, c[3];
    out[0] = out[1] = out[2] = 0;
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            double weight = (i ? fx : 1 - fx) * (j ? fy : 1 - fy);
            wrapped_pixel(image, x0 + i, y0 + j, c);
            for (int k = 0; k < 3; k++) out[k] += weight * c[k];
        }
}

/* The irradiance of a surface that faces pbrt's +z, of luminance: pbrt's illuminance of a picture. */
static double illuminance_of(const decoded_image *image) {
    uint32_t n = 256;
    double sum = 0, c[3];
    for (uint32_t j = 0; j < n; j++)
        for (uint32_t i = 0; i < n; i++) {
            double cosine = sqrt((i + 0.5) / n), sine = sqrt(1 - cosine * cosine),
                   turn = 2 * PI * (j + 0.5) / n;
            look_up(image, (dvec3){sine * fn_cos(turn), sine * fn_sin(turn), cosine}, c);
            sum += 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        }
    return PI * sum / ((double)n * n);
}

/* snell's own map: longitude over latitude, -z in the middle (lights/sphere_map.h). */
static snell_status spread(pbrt *p, const pbrt_params *params, const decoded_image *image,
                           decoded_image *out) {
    dtransform to_world = pbrt_to_world(p, 0), to_light;
    if (!pbrt_inverse(&to_world, &to_light))
        return pbrt_fail(p, params->place, NULL, "the transform of the light cannot be undone");
    uint32_t height = image->width < 8 ? 8 : image->width > 2048 ? 2048 : image->width;
    *out = (decoded_image){.width = 2 * height, .height = height, .channels = 4, .floats = true};
    size_t size = (size_t)out->width * height * 16;
    if (pbrt_spend(p, params->place, 2 * size)) return p->status;
    out->pixels = memory_resize(NULL, size, 1);
    if (out->pixels == NULL) return pbrt_blame(p, params->place, error_no_memory());
    float *at = (float *)(void *)out->pixels;
    for (uint32_t y = 0; y < height; y++) {
        double above = PI * (y + 0.5) / height, sine = fn_sin(above), cosine = fn_cos(above);
        for (uint32_t x = 0; x < out->width; x++, at += 4) {
            double turn = 2 * PI * (x + 0.5) / out->width, c[3];
            dvec3 d = {-sine * fn_sin(turn), cosine, sine * fn_cos(turn)};
            look_up(image, dvec3_normalize(pbrt_vector(&to_light, d)), c);
            for (int i = 0; i < 3; i++) at[i] = (float)c[i];
            at[3] = 1;
        }
    }
    return SNELL_OK;
}

static snell_status picture_around(pbrt *p, const pbrt_params *params, const decoded_image *image,
                                   double factor, double wanted) {
    if (image->width != image->height)
        return pbrt_fail(p, params->place,
                         "'imgtool makeequiarea' of pbrt-v4 converts longitude "
                         "and latitude",
                         "a picture of the surroundings is square in pbrt-v4, not %u x %u",
                         image->width, image->height);
    double light = wanted > 0 ? illuminance_of(image) : 0;
    if (light > 0) factor *= wanted / light;
    decoded_image around;
    snell_input radiance = {.value = {(float)(factor * p->white[0]), (float)(factor * p->white[1]),
                                      (float)(factor * p->white[2])}};
    if (spread(p, params, image, &around)) return p->status;
    pbrt_add_image(p, params->place, &around, false, NULL, &radiance.texture);
    image_free(&around);
    const snell_param list[] = {{"radiance", SNELL_PARAM_INPUT, {.input = radiance}}};
    return p->status ? p->status : add_light(p, params->place, "environment", list, 1);
}

static snell_status infinite_light(pbrt *p, const pbrt_params *params) {
    double scale, wanted = pbrt_float(p, params, "illuminance", -1);
    vec3 radiance = read_emission(p, params, "L", &scale);
    picture around;
    pbrt_lacks(p, params, "portal");
    if (read_picture(p, params, &around)) return p->status;
    if (around.found) {
        picture_around(p, params, &around.image, scale * p->light_factor, wanted);
        image_free(&around.image);
        return p->status;
    }
    const snell_param list[] = {color_param("radiance", radiance, wanted > 0 ? wanted / PI : 1)};
    return add_light(p, params->place, "environment", list, 1);
}

/* ---- any ---- */

snell_status pbrt_light(pbrt *p, const pbrt_params *params) {
    static const struct {
        const char *name;
        snell_status (*read)(pbrt *p, const pbrt_params *params);
    } types[] = {{"point", point_light},           {"spot", spot_light},
                 {"distant", distant_light},       {"goniometric", goniometric_light},
                 {"projection", projection_light}, {"infinite", infinite_light}};
    warn_of_motion(p, params);
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
        if (strcmp(params->type, types[i].name) == 0)
            return p->status ? p->status : types[i].read(p, params);
    return pbrt_fail(p, params->place,
                     "it is point, spot, distant, goniometric, projection or infinite",
                     "unknown light '%s'", params->type);
}

snell_status pbrt_area_light_of(pbrt *p, const pbrt_params *params, pbrt_area_light *out) {
    if (strcmp(params->type, "diffuse") != 0)
        return pbrt_fail(p, params->place, "it is diffuse", "unknown area light '%s'",
                         params->type);
    double power = pbrt_float(p, params, "power", -1);
    *out = (pbrt_area_light){.lit = true};
    out->radiance = read_emission(p, params, "L", NULL);
    out->two_sided = pbrt_bool(p, params, "twosided", false);
    out->has_power = power > 0;
    if (power > 0)
        out->power = vec3_scale(out->radiance, (float)(power / (out->two_sided ? 2 : 1)));
    picture shown;
    if (read_picture(p, params, &shown)) return p->status;
    if (!shown.found) return SNELL_OK;
    double mean[3];
    mean_of(&shown.image, mean);
    image_free(&shown.image);
    out->radiance = vec3_mul(out->radiance, (vec3){(float)mean[0], (float)mean[1], (float)mean[2]});
    return pbrt_warn(p, params->place,
                     "the picture of an area light is not supported: its mean colour is used");
}
