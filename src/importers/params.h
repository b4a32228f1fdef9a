/* The parameters that a reader collects for a material. */
#ifndef SNELL_IMPORTERS_PARAMS_H
#define SNELL_IMPORTERS_PARAMS_H

#include <assert.h>

#include "scene/description.h"

enum { PARAMS_MAX = 32 }; /* more than any material has fields that readers set */
typedef struct params {
    snell_param list[PARAMS_MAX];
    size_t count;
} params;

static inline void add_param(params *p, snell_param param) {
    assert(p->count < PARAMS_MAX);
    p->list[p->count++] = param;
}
static inline void add_input(params *p, const char *name, snell_input value) {
    add_param(p, (snell_param){name, SNELL_PARAM_INPUT, {.input = value}});
}
static inline void add_float(params *p, const char *name, double value) {
    add_param(p, (snell_param){name, SNELL_PARAM_FLOAT, {.f = value}});
}

#endif
