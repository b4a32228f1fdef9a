#include "materials/fresnel.h"

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

dvec3 fresnel_evaluate(const fresnel *f, double cosine) {
    double r;
    switch (f->kind) {
    case FRESNEL_NONE: break;
    case FRESNEL_DIELECTRIC: r = fresnel_dielectric(cosine, 1, f->a.x); return (dvec3){r, r, r};
    case FRESNEL_CONDUCTOR:
        return (dvec3){fresnel_conductor(cosine, f->a.x, f->b.x),
                       fresnel_conductor(cosine, f->a.y, f->b.y),
                       fresnel_conductor(cosine, f->a.z, f->b.z)};
    case FRESNEL_SCHLICK: {
        double m = clamp01(1 - cosine), m5 = m * m * m * m * m;
        return dvec3_add(f->a, dvec3_scale(dvec3_sub(f->b, f->a), m5));
    }
    }
    return (dvec3){1, 1, 1};
}
