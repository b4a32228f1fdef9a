/* pbrt's spectra as linear Rec. 709. pbrt follows wavelengths, snell three colours: a spectrum becomes
 * the colour that the CIE 1931 observer sees, a reflectance under D65. Where pbrt scales a light's
 * spectrum by its luminance (its photometric lights), so does this. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "importers/files.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

enum { LAMBDA_MIN = 360, LAMBDA_MAX = 830 }; /* nm; pbrt's range */

typedef struct spectrum { /* piecewise linear, wavelength and value in turn */
    const double *pairs;
    size_t count;       /* pairs */
    double temperature; /* K; above 0: a black body instead */
} spectrum;

/* ---- the observer and the illuminant ---- */

static double lobe(double x, double middle, double left, double right) {
    double t = (x - middle) * (x < middle ? left : right);
    return fn_exp(-0.5 * t * t);
}

/* The CIE 1931 matching functions: Wyman, Sloan and Shirley, Simple Analytic Approximations to the CIE
 * XYZ Color Matching Functions, JCGT 2(2), 2013, the multi-lobe fit. */
static dvec3 matching(double nm) {
    return (dvec3){
        1.056 * lobe(nm, 599.8, 1 / 37.9, 1 / 31.0) + 0.362 * lobe(nm, 442.0, 1 / 16.0, 1 / 26.7) -
            0.065 * lobe(nm, 501.1, 1 / 20.4, 1 / 26.2),
        0.821 * lobe(nm, 568.8, 1 / 46.9, 1 / 40.5) + 0.286 * lobe(nm, 530.9, 1 / 16.3, 1 / 31.1),
        1.217 * lobe(nm, 437.0, 1 / 11.8, 1 / 36.0) + 0.681 * lobe(nm, 459.0, 1 / 26.0, 1 / 13.8)};
}

/* The standard illuminant D65 from 380 to 780 nm in steps of 10 (CIE 15). */
static const double d65[] = {49.9755, 54.6482, 82.7549, 91.486,  93.4318, 86.6823, 104.865,
                             117.008, 117.812, 114.861, 115.923, 108.811, 109.354, 107.802,
                             104.79,  107.689, 104.405, 104.046, 100,     96.3342, 95.788,
                             88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268,
                             80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349,  61.604,
                             69.8856, 75.087,  63.5927, 46.4182, 66.8054, 63.3828};

static double daylight(double nm) {
    double at = (nm - 380) / 10;
    int last = (int)(sizeof d65 / sizeof d65[0]) - 1;
    if (at <= 0) return d65[0];
    if (at >= last) return d65[last];
    int i = (int)at;
    return d65[i] + (at - i) * (d65[i + 1] - d65[i]);
}

/* Planck's law, but for a factor. */
static double black_body(double nm, double temperature) {
    double metres = nm * 1e-9, exponent = 1.438776877e-2 / (metres * temperature);
    if (exponent > 700) return 0;
    return 1 / (fn_pow(metres * 1e6, 5) * (fn_exp(exponent) - 1));
}

/* 0 beyond its ends, as in pbrt. */
static double value_at(const spectrum *s, double nm) {
    if (s->temperature > 0) return black_body(nm, s->temperature);
    const double *p = s->pairs;
    if (nm < p[0]) return 0;
    for (size_t i = 1; i < s->count; i++)
        if (nm <= p[2 * i])
            return p[2 * i - 1] +
                   (nm - p[2 * i - 2]) / (p[2 * i] - p[2 * i - 2]) * (p[2 * i + 1] - p[2 * i - 1]);
    return nm == p[2 * s->count - 2] ? p[2 * s->count - 1] : 0;
}

static dvec3 observe(const spectrum *s, bool under_daylight) {
    dvec3 sum = {0, 0, 0}, white = {0, 0, 0};
    for (int nm = LAMBDA_MIN; nm <= LAMBDA_MAX; nm++) {
        dvec3 sees = matching(nm);
        double light = under_daylight ? daylight(nm) : 1;
        sum = dvec3_add(sum, dvec3_scale(sees, light * value_at(s, nm)));
        white = dvec3_add(white, dvec3_scale(sees, light));
    }
    return dvec3_scale(sum, 1 / white.y);
}

static dvec3 from_xyz(dvec3 c) {
    return (dvec3){3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
                   -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
                   0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

static void put(dvec3 c, double out[3]) {
    out[0] = double_max(c.x, 0), out[1] = double_max(c.y, 0), out[2] = double_max(c.z, 0);
}

static void to_color(const spectrum *s, pbrt_spectrum_use use, double out[3]) {
    dvec3 seen = observe(s, use != PBRT_LIGHT);
    if (use == PBRT_LIGHT) seen = seen.y > 0 ? dvec3_scale(seen, 1 / seen.y) : (dvec3){0, 0, 0};
    put(from_xyz(seen), out);
}

/* ---- spectra by name ---- */

/* Metals and oxides: eta and k for red, green and blue, such that a smooth surface reflects at normal
 * incidence the colour that the measured spectra give under D65. The measurements are pbrt-v4's:
 * refractiveindex.info, CC0. */
typedef struct metal {
    const char *name;
    double eta[3], k[3];
} metal;
static const metal metals[] = {
    {"Ag", {0.127, 0.121, 0.149}, {4.054, 3.292, 2.391}},
    {"Al", {1.421, 0.931, 0.590}, {7.726, 6.610, 5.360}},
    {"Au", {0.085, 0.455, 1.822}, {3.380, 2.509, 1.770}},
    {"Cu", {0.140, 0.954, 1.215}, {3.261, 2.598, 2.369}},
    {"CuZn", {0.350, 0.527, 1.072}, {3.656, 2.687, 1.770}},
    {"MgO", {1.734, 1.741, 1.754}, {0, 0, 0}},
    {"TiO2", {2.862, 2.956, 3.186}, {0, 0, 0.001}},
};

/* Glasses by the index at 587.6 nm that their makers state. */
static const struct {
    const char *name;
    double index;
} glasses[] = {{"BK7", 1.5168},  {"BAF10", 1.6700}, {"FK51A", 1.4866}, {"LASF9", 1.8503},
               {"F5", 1.6727},   {"F10", 1.7283},   {"F11", 1.7847},   {"SF5", 1.6727},
               {"SF10", 1.7283}, {"SF11", 1.7847}};

/* Illuminants by their chromaticities (CIE 15; ACES: SMPTE ST 2065-1). */
static const struct {
    const char *name;
    double x, y;
} illuminants[] = {{"stdillum-A", 0.44757, 0.40745},   {"stdillum-D50", 0.34567, 0.35850},
                   {"stdillum-D65", 0.31271, 0.32902}, {"stdillum-F1", 0.3131, 0.3371},
                   {"stdillum-F2", 0.3721, 0.3751},    {"stdillum-F3", 0.4091, 0.3941},
                   {"stdillum-F4", 0.4402, 0.4031},    {"stdillum-F5", 0.3138, 0.3452},
                   {"stdillum-F6", 0.3779, 0.3882},    {"stdillum-F7", 0.3129, 0.3292},
                   {"stdillum-F8", 0.3458, 0.3586},    {"stdillum-F9", 0.3741, 0.3727},
                   {"stdillum-F10", 0.3458, 0.3588},   {"stdillum-F11", 0.3805, 0.3769},
                   {"stdillum-F12", 0.4370, 0.4042},   {"illum-acesD60", 0.32168, 0.33767}};

static bool find_metal(const char *name, double out[3]) {
    const char *dash = strrchr(name, '-');
    if (strncmp(name, "metal-", 6) != 0 || dash < name + 6) return false;
    size_t length = (size_t)(dash - name) - 6;
    for (size_t i = 0; i < sizeof metals / sizeof metals[0]; i++) {
        const metal *m = &metals[i];
        if (strlen(m->name) != length || memcmp(m->name, name + 6, length) != 0) continue;
        bool k = strcmp(dash, "-k") == 0;
        if (!k && strcmp(dash, "-eta") != 0) return false;
        for (int c = 0; c < 3; c++) out[c] = k ? m->k[c] : m->eta[c];
        return true;
    }
    return false;
}

static bool find_named(const char *name, double out[3]) {
    if (find_metal(name, out)) return true;
    if (strncmp(name, "glass-", 6) == 0)
        for (size_t i = 0; i < sizeof glasses / sizeof glasses[0]; i++)
            if (strcmp(glasses[i].name, name + 6) == 0) {
                out[0] = out[1] = out[2] = glasses[i].index;
                return true;
            }
    for (size_t i = 0; i < sizeof illuminants / sizeof illuminants[0]; i++)
        if (strcmp(illuminants[i].name, name) == 0) {
            double x = illuminants[i].x, y = illuminants[i].y;
            put(from_xyz((dvec3){x / y, 1, (1 - x - y) / y}), out);
            return true;
        }
    return false;
}

/* ---- reading ---- */

static snell_status check_pairs(pbrt *p, const pbrt_param *param, const double *pairs,
                                size_t numbers) {
    if (numbers == 0 || numbers % 2)
        return pbrt_fail(p, param->place, NULL,
                         "the spectrum '%s' needs pairs of a wavelength and a value", param->name);
    for (size_t i = 2; i < numbers; i += 2)
        if (!(pairs[i] > pairs[i - 2]))
            return pbrt_fail(p, param->place, NULL,
                             "the wavelengths of the spectrum '%s' do not ascend: %g after %g",
                             param->name, pairs[i], pairs[i - 2]);
    return SNELL_OK;
}

enum { FILE_NUMBERS_MAX = 2 * 10000 };

/* Numbers with white space and comments between. */
static snell_status read_file(pbrt *p, const pbrt_param *param, pbrt_spectrum_use use,
                              double out[3]) {
    char *text;
    size_t size, count = 0;
    snell_status status =
        import_read_beside(p->path, param->strings[0], p->options, (uint8_t **)&text, &size);
    if (status) return pbrt_blame(p, param->place, status);
    double *pairs = calloc(FILE_NUMBERS_MAX, sizeof *pairs);
    if (pairs == NULL) {
        free(text);
        return pbrt_blame(p, param->place, error_no_memory());
    }
    for (char *at = text; *at && !p->status;) {
        at += strspn(at, " \t\r\n,");
        if (*at == '#') at += strcspn(at, "\n");
        size_t length = strcspn(at, " \t\r\n,#");
        if (length == 0) continue;
        char next = at[length];
        at[length] = 0;
        if (count == FILE_NUMBERS_MAX || !pbrt_to_number(at, &pairs[count]))
            pbrt_fail(p, param->place, NULL, "'%s' is no spectrum: '%.40s'", param->strings[0], at);
        count++;
        at[length] = next;
        at += length;
    }
    if (!p->status) check_pairs(p, param, pairs, count);
    if (!p->status) to_color(&(spectrum){pairs, count / 2, 0}, use, out);
    free(pairs);
    free(text);
    return p->status;
}

/* To Rec. 709 from the primaries of the file's own colour space. */
static const double space_matrices[][9] = {
    [PBRT_P3] = {1.2249401762, -0.2249401762, 0, -0.0420569547, 1.0420569547, 0, -0.0196375546,
                 -0.0786360456, 1.0982736001},
    [PBRT_REC2020] = {1.6604910021, -0.5876411388, -0.0728498633, -0.1245504745, 1.1328998971,
                      -0.0083494226, -0.0181507634, -0.1005788980, 1.1187296614},
    /* AP0, its white adapted from D60 (Bradford). */
    [PBRT_ACES] = {2.5216494298, -1.1368885542, -0.3849175932, -0.2752135512, 1.3697051510,
                   -0.0943924508, -0.0159250101, -0.1478063681, 1.1638058159},
};

static void from_space(pbrt_color_space space, const double *rgb, double out[3]) {
    memcpy(out, rgb, 3 * sizeof *out);
    if (space == PBRT_SRGB) return;
    const double *m = space_matrices[space];
    put((dvec3){m[0] * rgb[0] + m[1] * rgb[1] + m[2] * rgb[2],
                m[3] * rgb[0] + m[4] * rgb[1] + m[5] * rgb[2],
                m[6] * rgb[0] + m[7] * rgb[1] + m[8] * rgb[2]},
        out);
}

static snell_status read_rgb(pbrt *p, const pbrt_param *param, pbrt_spectrum_use use,
                             double out[3]) {
    if (param->count != 3)
        return pbrt_fail(p, param->place, NULL, "'rgb %s' needs 3 numbers, not %zu", param->name,
                         param->count);
    for (int i = 0; i < 3; i++)
        if (param->numbers[i] < 0 || (use == PBRT_REFLECTANCE && param->numbers[i] > 1))
            return pbrt_fail(p, param->place, NULL, "'rgb %s' has %g: it is %s", param->name,
                             param->numbers[i],
                             param->numbers[i] < 0 ? "not negative" : "a fraction, 0 to 1");
    from_space(param->space, param->numbers, out);
    return SNELL_OK;
}

snell_status pbrt_spectrum(pbrt *p, pbrt_param *param, pbrt_spectrum_use use, double out[3]) {
    if (p->status) return p->status;
    param->used = true;
    if (strcmp(param->type, "rgb") == 0) return read_rgb(p, param, use, out);
    if (strcmp(param->type, "blackbody") == 0) {
        if (param->count != 1 || !(param->numbers[0] > 100 && param->numbers[0] < 1e6))
            return pbrt_fail(p, param->place, NULL,
                             "'blackbody %s' needs one temperature, 100 to 1000000 K", param->name);
        to_color(&(spectrum){.temperature = param->numbers[0]}, use, out);
        return SNELL_OK;
    }
    if (strcmp(param->type, "spectrum") == 0 && param->kind == PBRT_STRINGS) {
        if (param->count != 1)
            return pbrt_fail(p, param->place, NULL, "'spectrum %s' needs one name", param->name);
        return find_named(param->strings[0], out) ? SNELL_OK : read_file(p, param, use, out);
    }
    if (strcmp(param->type, "spectrum") == 0) {
        if (!check_pairs(p, param, param->numbers, param->count))
            to_color(&(spectrum){param->numbers, param->count / 2, 0}, use, out);
        return p->status;
    }
    return pbrt_fail(p, param->place, "such as \"rgb\"", "'%s' is a spectrum, not a %s",
                     param->name, param->type);
}

snell_status pbrt_color(pbrt *p, const pbrt_params *params, const char *name, pbrt_spectrum_use use,
                        const double otherwise[3], double out[3], bool *found) {
    pbrt_param *param = pbrt_find(params, name);
    *found = param != NULL;
    memcpy(out, otherwise, 3 * sizeof *out);
    return param ? pbrt_spectrum(p, param, use, out) : p->status;
}

double pbrt_index(pbrt *p, const pbrt_params *params, const char *name, double otherwise) {
    static const double sodium = 589.3;
    pbrt_param *param = pbrt_find(params, name);
    if (param == NULL || strcmp(param->type, "float") == 0)
        return pbrt_float(p, params, name, otherwise);
    if (strcmp(param->type, "spectrum") == 0 && param->kind == PBRT_NUMBERS) {
        param->used = true;
        if (check_pairs(p, param, param->numbers, param->count)) return otherwise;
        return value_at(&(spectrum){param->numbers, param->count / 2, 0}, sodium);
    }
    double color[3] = {otherwise, otherwise, otherwise};
    pbrt_spectrum(p, param, PBRT_COEFFICIENT, color);
    return color[1];
}

/* The chromaticity of daylight (CIE 15), 4000 to 25000 K; von Kries' rule in Rec. 709. */
void pbrt_white_balance(double temperature, double out[3]) {
    double t = temperature < 4000 ? 4000 : temperature > 25000 ? 25000 : temperature, u = 1e3 / t;
    double x = t <= 7000 ? 0.244063 + u * (0.09911 + u * (2.9678 - u * 4.6070))
                         : 0.237040 + u * (0.24748 + u * (1.9018 - u * 2.0064)),
           y = -3 * x * x + 2.87 * x - 0.275, seen[3];
    put(from_xyz((dvec3){x / y, 1, (1 - x - y) / y}), seen);
    for (int i = 0; i < 3; i++) out[i] = seen[i] > 0.05 ? 1 / seen[i] : 20;
}
