/* Directional albedos E(wo) of microfacet lobes: the share of light from one direction that they
 * send on, from tables that tools/gen_albedo has integrated once. */
#ifndef SNELL_MATERIALS_ALBEDO_H
#define SNELL_MATERIALS_ALBEDO_H

/* Of GGX (lobe_ggx) with Schlick's reflectance, f0 at normal incidence and f90 at grazing:
 * f0 A + f90 B. */
double albedo_ggx(double alpha, double cosine, double f0, double f90);
/* Its mean, 2 int E cos dcos. */
double albedo_ggx_mean(double alpha, double f0, double f90);
/* Of lobe_sheen in white. */
double albedo_sheen(double alpha, double cosine);

enum { ALBEDO_SIZE = 32 };
/* The nodes: sqrt(alpha) and sqrt(cosine) are index / (ALBEDO_SIZE - 1). */
extern const float albedo_ggx_table[ALBEDO_SIZE][ALBEDO_SIZE][2]; /* A, B by alpha, cosine */
extern const float albedo_ggx_mean_table[ALBEDO_SIZE][2];
extern const float albedo_sheen_table[ALBEDO_SIZE][ALBEDO_SIZE];

#endif
