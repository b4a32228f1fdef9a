/* Every family of shapes and their slow solvers. */
#ifndef SNELL_TESTS_SHAPE_SUBJECTS_H
#define SNELL_TESTS_SHAPE_SUBJECTS_H

#include <string.h>

#include "geometry/primitive.h"
#include "shapes_analytic.h"
#include "shapes_basic.h"
#include "shapes_fields.h"

#define FAMILY(table)                                                                              \
    { table, sizeof table / sizeof table[0] }
static const struct family {
    const subject *subjects;
    size_t count;
} families[] = {
    FAMILY(subjects_basic),
    FAMILY(subjects_analytic),
    FAMILY(subjects_fields),
};

static const subject *subject_of(const primitive_type *type) {
    for (size_t k = 0; k < sizeof families / sizeof families[0]; k++)
        for (size_t i = 0; i < families[k].count; i++)
            if (strcmp(families[k].subjects[i].name, type->info.name) == 0)
                return &families[k].subjects[i];
    fail_msg("no slow solver in tests/shapes_*.h for the shape '%s'", type->info.name);
    return NULL;
}

#endif
