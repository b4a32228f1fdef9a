#include "materials/fresnel.h"

#include "maths/functions.h"

double fresnel_dielectric(double cos1, double ior1, double ior2) {
    double eta = ior1 / ior2, k = 1 - eta * eta * (1 - cos1 * cos1);
    if (!(k > 0)) return 1;
    double cos2 = sqrt(k);
    double s = (ior1 * cos1 - ior2 * cos2) / (ior1 * cos1 + ior2 * cos2);
    double p = (ior2 * cos1 - ior1 * cos2) / (ior2 * cos1 + ior1 * cos2);
    return (s * s + p * p) / 2;
}

/* Snell's law with a complex index leaves a complex cosine (a + i b) n; a^2 + b^2 and a follow from
 * the index alone (Born and Wolf, Principles of Optics, 14.2). */
double fresnel_conductor(double cosine, double eta, double k) {
    if (!(cosine > 0)) return 1;
    double cos2 = cosine * cosine, sin2 = 1 - cos2;
    double difference = eta * eta - k * k - sin2;
    double sum = sqrt(difference * difference + 4 * eta * eta * k * k); /* a^2 + b^2 */
    double a = sqrt(double_max((sum + difference) / 2, 0));
    double s = (sum + cos2 - 2 * a * cosine) / (sum + cos2 + 2 * a * cosine);
    double far = cos2 * sum + sin2 * sin2, near = 2 * a * cosine * sin2;
    double p = s * (far - near) / (far + near);
    return (s + p) / 2;
}

/* ---- thin films ---- */

static double schlick(double f0, double cosine) {
    double m = clamp01(1 - cosine), m2 = m * m;
    return f0 + (1 - f0) * m2 * m2 * m;
}

static double square(double x) { return x * x; }

static double normal_reflectance(double inside, double outside) {
    return square((inside - outside) / (inside + outside));
}

/* The colour of cos(2 pi path / wavelength + shift), path in metres: the Fourier transforms of the
 * observer's three responses, each a Gaussian (two for x), taken to linear Rec. 709. shift is that of
 * the colour, as in the extension's text. */
static dvec3 fringes(double path, dvec3 shift) {
    static const struct {
        double amplitude, position, variance;
    } response[4] = {{5.4856e-13, 1.6810e6, 4.3278e9},
                     {4.4201e-13, 1.7953e6, 9.3046e9},
                     {5.2481e-13, 2.2084e6, 6.6121e9},
                     {9.7470e-14, 2.2399e6, 4.5282e9}};
    static const double norm = 1.0685e-7;
    const double shifts[4] = {shift.x, shift.y, shift.z, shift.x};
    double phase = 2 * PI * path, part[4];
    for (int i = 0; i < 4; i++)
        part[i] = response[i].amplitude * sqrt(2 * PI * response[i].variance) / norm *
                  fn_cos(response[i].position * phase + shifts[i]) *
                  fn_exp(-response[i].variance * phase * phase);
    double x = part[0] + part[3], y = part[1], z = part[2];
    return (dvec3){3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                   -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                   0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
}

/* One colour's reflectance at the film's far side, and whether the wave turns over there. */
static double far_side(double f0, double ior, double cosine, double *shift) {
    double root = sqrt(f0 < 0.9999 ? f0 : 0.9999), base = (1 + root) / (1 - root);
    *shift = base < ior ? PI : 0;
    return schlick(normal_reflectance(base, ior), cosine);
}

/* The sum over orders m of the waves that ran to and fro m times: m = 0 has no colour, and three are
 * enough, since the next ones have hardly any. */
dvec3 fresnel_film(double cosine, double ior, double thickness, dvec3 f0) {
    double near = clamp01(thickness / 0.03); /* nm: without a film there is no film */
    ior = 1 + (ior - 1) * near * near * (3 - 2 * near);
    double cos2 = 1 - (1 - cosine * cosine) / (ior * ior);
    if (!(cos2 > 0)) return (dvec3){1, 1, 1};
    cos2 = sqrt(cos2);
    double r12 = schlick(normal_reflectance(ior, 1), cosine), t121 = 1 - r12;
    dvec3 shift;
    const double bases[3] = {f0.x, f0.y, f0.z};
    double *shifts[3] = {&shift.x, &shift.y, &shift.z};
    double r123[3], rs[3], sum[3];
    for (int c = 0; c < 3; c++) {
        double r23 = far_side(bases[c], ior, cos2, shifts[c]);
        *shifts[c] += ior < 1 ? 0 : PI; /* at the near side from within */
        r123[c] = double_min(r12 * r23, 0.9999);
        rs[c] = t121 * t121 * r23 / (1 - r123[c]);
        sum[c] = r12 + rs[c];
    }
    double path = 2 * ior * thickness * 1e-9 * cos2;
    for (int m = 1; m <= 2; m++) {
        dvec3 colour = fringes(m * path, dvec3_scale(shift, m));
        const double s[3] = {colour.x, colour.y, colour.z};
        for (int c = 0; c < 3; c++) {
            double power = m == 1 ? sqrt(r123[c]) : r123[c];
            sum[c] += 2 * (rs[c] - t121) * power * s[c];
        }
    }
    return (dvec3){clamp01(sum[0]), clamp01(sum[1]), clamp01(sum[2])};
}

double fresnel_film_bound(double ior, double thickness, dvec3 f0) {
    enum { COSINES = 8 };
    double most = 0;
    for (int i = 1; i <= COSINES; i++) {
        double cosine = (double)i / COSINES, grazing = schlick(0, cosine);
        double largest = dvec3_largest(fresnel_film(cosine, ior, thickness, f0));
        most = double_max(most, (largest - grazing) / (1 - grazing));
    }
    return clamp01(most);
}

dvec3 fresnel_evaluate(const fresnel *f, double cosine) {
    double r;
    switch (f->kind) {
    case FRESNEL_NONE: break;
    case FRESNEL_DIELECTRIC: r = fresnel_dielectric(cosine, 1, f->a.x); return (dvec3){r, r, r};
    case FRESNEL_CONDUCTOR:
        return (dvec3){fresnel_conductor(cosine, f->a.x, f->b.x),
                       fresnel_conductor(cosine, f->a.y, f->b.y),
                       fresnel_conductor(cosine, f->a.z, f->b.z)};
    case FRESNEL_FILM: return fresnel_film(clamp01(cosine), f->b.x, f->b.y, f->a);
    case FRESNEL_SCHLICK: {
        double m = clamp01(1 - cosine), m5 = m * m * m * m * m;
        return dvec3_add(f->a, dvec3_scale(dvec3_sub(f->b, f->a), m5));
    }
    }
    return (dvec3){1, 1, 1};
}
