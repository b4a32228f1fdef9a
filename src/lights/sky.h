/* The sun that belongs to an analytic sky. */
#ifndef SNELL_LIGHTS_SKY_H
#define SNELL_LIGHTS_SKY_H

#include "maths/vec.h"

/* The sun's irradiance on a surface that faces it, W/m^2, after the way through the air. elevation:
 * the sine of its height over the horizon, 0..1. */
dvec3 sky_sun_irradiance(double elevation, double turbidity);
#define SUN_ANGLE 0.00925 /* rad across, 0.53 degrees */

#endif
