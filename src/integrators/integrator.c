#include "integrators/integrator.h"

#define INTEGRATOR(name) extern const integrator integrator_##name;
#include "integrators/integrators.def"
#undef INTEGRATOR
const integrator *const integrators[INTEGRATOR_COUNT] = {
#define INTEGRATOR(name) &integrator_##name,
#include "integrators/integrators.def"
#undef INTEGRATOR
};
