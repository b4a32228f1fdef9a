/* White balance: a light is said to be white, and colours are adapted from it to D65 as Bradford's
 * transform has it (K. M. Lam, Metamerism and colour constancy, thesis, Bradford 1985; the matrix is
 * that of CIECAM97s and of ICC profiles), each cone's response scaled by itself (von Kries).
 *
 * A temperature is of daylight from 5000 K (CIE 015: the D series; D65 is at 6504 K), of a black body up to 4000 K
 * (M. Krystek, An algorithm to calculate correlated colour temperature, Color Res. Appl. 10, 1985),
 * and between the two goes from one to the other along a straight line in the reciprocal, so that
 * there is no step. */
#include "image/white_balance.h"

#include "image/srgb.h"

enum { KELVIN_MIN = 1000, KELVIN_MAX = 25000, KELVIN_D65 = 6504 };

/* IEC 61966-2-1. */
static const dmat3 xyz_of_rgb = {
    {0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
static const dmat3 cones_of_xyz = {
    {0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};

static dmat3 columns(dvec3 a, dvec3 b, dvec3 c) {
    return (dmat3){{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}};
}

static dmat3 product(const dmat3 *a, const dmat3 *b) {
    return columns(dmat3_apply(a, (dvec3){b->x.x, b->y.x, b->z.x}),
                   dmat3_apply(a, (dvec3){b->x.y, b->y.y, b->z.y}),
                   dmat3_apply(a, (dvec3){b->x.z, b->y.z, b->z.z}));
}

static dmat3 inverse(const dmat3 *m) {
    double scale = 1 / dvec3_dot(m->x, dvec3_cross(m->y, m->z));
    return columns(dvec3_scale(dvec3_cross(m->y, m->z), scale),
                   dvec3_scale(dvec3_cross(m->z, m->x), scale),
                   dvec3_scale(dvec3_cross(m->x, m->y), scale));
}

/* ---- temperatures ---- */

static void daylight(double t, double *x, double *y) {
    double n = 1000 / t;
    *x = t <= 7000 ? 0.244063 + n * (0.09911 + n * (2.9678 - n * 4.6070))
                   : 0.237040 + n * (0.24748 + n * (1.9018 - n * 2.0064));
    *y = -0.275 + *x * (2.870 - 3 * *x);
}

static void black_body(double t, double *x, double *y) {
    double u = (0.860117757 + t * (1.54118254e-4 + t * 1.28641212e-7)) /
               (1 + t * (8.42420235e-4 + t * 7.08145163e-7));
    double v = (0.317398726 + t * (4.22806245e-5 + t * 4.20481691e-8)) /
               (1 + t * (-2.89741816e-5 + t * 1.61456053e-7));
    double w = 2 * u - 8 * v + 4; /* from CIE 1960 u, v */
    *x = 3 * u / w;
    *y = 2 * v / w;
}

void white_balance_locus(double kelvin, double *x, double *y) {
    if (kelvin >= 5000) {
        daylight(kelvin, x, y);
    } else {
        double share = kelvin > 4000 ? (1.0 / 4000 - 1 / kelvin) / (1.0 / 4000 - 1.0 / 5000) : 0;
        double dx, dy;
        daylight(kelvin > 4000 ? kelvin : 4000, &dx, &dy);
        black_body(kelvin, x, y);
        *x += share * (dx - *x);
        *y += share * (dy - *y);
    }
}

static dvec3 white_of(double kelvin) {
    double x, y;
    white_balance_locus(kelvin, &x, &y);
    return (dvec3){x / y, 1, (1 - x - y) / y};
}

/* ---- the matrix ---- */

static void adapt(dvec3 from, dvec3 to, white_balance *out) {
    dvec3 a = dmat3_apply(&cones_of_xyz, from), b = dmat3_apply(&cones_of_xyz, to);
    dmat3 in = product(&cones_of_xyz, &xyz_of_rgb), back = inverse(&in), scaled = in;
    scaled.x = dvec3_scale(in.x, b.x / a.x);
    scaled.y = dvec3_scale(in.y, b.y / a.y);
    scaled.z = dvec3_scale(in.z, b.z / a.z);
    *out = (white_balance){true, product(&back, &scaled)};
}

dvec3 white_balance_apply(const white_balance *balance, dvec3 color) {
    return balance->on ? dmat3_apply(&balance->m, color) : color;
}

/* ---- what people write ---- */

/* Digits with a '.' somewhere, in any locale. */
static bool read_number(const char **at, double *out) {
    double value = 0, unit = 1;
    int digits = 0;
    bool point = false;
    for (; (**at >= '0' && **at <= '9') || (**at == '.' && !point); ++*at) {
        if (**at == '.') {
            point = true;
            continue;
        }
        value = 10 * value + (**at - '0');
        if (point) unit *= 10;
        digits++;
    }
    *out = value / unit;
    return digits > 0 && digits < 40;
}

/* "1,0.7,0.4" or "#ffd9b0"; one number goes to *kelvin. */
static bool read_white(const char *text, double *kelvin, dvec3 *color) {
    snell_vec3 shown;
    double *parts[3] = {&color->x, &color->y, &color->z};
    int count = 0;
    if (srgb_read_hex(text, &shown)) {
        *color = dvec3_from((vec3){shown.x, shown.y, shown.z});
        return true;
    }
    for (const char *at = text;; at++) {
        if (count == 3 || !read_number(&at, parts[count++])) return false;
        if (*at == '\0') break;
        if (*at != ',') return false;
    }
    if (count == 1) *kelvin = color->x;
    return count != 2;
}

snell_status white_balance_parse(const char *text, white_balance *out) {
    static const char hint[] =
        "kelvin from 1000 to 25000, such as 3200 (6504 changes nothing), or a "
        "colour: '#rrggbb' or linear 'r,g,b'";
    double kelvin = 0;
    dvec3 color = {0, 0, 0};
    *out = (white_balance){.on = false};
    if (text == NULL || *text == '\0') return SNELL_OK;
    if (!read_white(text, &kelvin, &color))
        return error_set(SNELL_ERR_ARGUMENT, hint,
                         "white_balance: '%.40s' is neither a temperature nor a colour", text);
    dvec3 white = dmat3_apply(&xyz_of_rgb, color);
    if (kelvin != 0 ? kelvin < KELVIN_MIN || kelvin > KELVIN_MAX : !(white.y > 0))
        return error_set(SNELL_ERR_ARGUMENT, hint, "white_balance: '%.40s' is out of range", text);
    if (kelvin != 0) {
        if (kelvin != KELVIN_D65) adapt(white_of(kelvin), white_of(KELVIN_D65), out);
    } else if (color.x != color.y || color.y != color.z) {
        adapt(dvec3_scale(white, 1 / white.y), dmat3_apply(&xyz_of_rgb, (dvec3){1, 1, 1}), out);
    }
    return SNELL_OK;
}
