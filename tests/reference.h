/* The reference values in tests/reference/cases.json: closed forms and integrals that every part of
 * the renderer is held against. |got - expected| <= abs + rel * |expected|. */
#ifndef SNELL_TESTS_REFERENCE_H
#define SNELL_TESTS_REFERENCE_H

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reference_case {
    const char *name, *group;
    json_t *scene, *expected;
    double rel, abs;
} reference_case;

/* All records, or an end of the program: a test without its values must not pass. Read once. */
static inline json_t *reference_all(void) {
    static json_t *all;
    if (all) return all;
    json_error_t error;
    all = json_load_file(TEST_SOURCE_DIR "/tests/reference/cases.json", 0, &error);
    if (all && json_is_array(all)) return all;
    fprintf(stderr, "tests/reference/cases.json: %s\n", error.text);
    exit(1);
}

/* Calls test for every record of the group, and returns how many there were. */
static inline int reference_each(const char *group, void (*test)(const reference_case *)) {
    int count = 0;
    size_t index;
    json_t *record;
    json_array_foreach(reference_all(), index, record) {
        const char *its = json_string_value(json_object_get(record, "group"));
        if (its == NULL || strcmp(its, group) != 0) continue;
        json_t *tolerance = json_object_get(record, "tolerance");
        reference_case found = {json_string_value(json_object_get(record, "name")),
                                its,
                                json_object_get(record, "scene"),
                                json_object_get(record, "expected"),
                                json_number_value(json_object_get(tolerance, "rel")),
                                json_number_value(json_object_get(tolerance, "abs"))};
        test(&found);
        count++;
    }
    return count;
}

static inline bool reference_agrees(const reference_case *c, double got, double expected) {
    if (fabs(got - expected) <= c->abs + c->rel * fabs(expected)) return true;
    fprintf(stderr, "%s: got %.9g, expected %.9g\n", c->name, got, expected);
    return false;
}

/* The index-th number of an array. */
static inline double reference_number(const json_t *array, size_t index) {
    return json_number_value(json_array_get(array, index));
}

/* Frees what reference_all has read, so that a leak checker sees nothing. */
static inline void reference_free(void) { json_decref(reference_all()); }

#endif
