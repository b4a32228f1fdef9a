/* What tests ask of a description: an object by its name or place, and a field of it by its name. What is not there
 * fails the test. After cmocka.h. */
#ifndef SNELL_TESTS_DESCRIBED_H
#define SNELL_TESTS_DESCRIBED_H

#include "scene/description.h"

static inline const object *named(const description *d, category which, const char *name) {
    const object *o = description_find(d, which, name);
    if (o == NULL) print_error("nothing is called %s\n", name);
    assert_non_null(o);
    return o;
}

static inline const object *object_at(const description *d, category which, size_t index,
                                      const char *type) {
    assert_true(index < d->objects[which].count);
    const object *o = &d->objects[which].items[index];
    assert_string_equal(o->type->name, type);
    return o;
}

static inline const void *field_of(const object *o, const char *name) {
    const field *f = type_find_field(o->type, name);
    if (f == NULL) print_error("%s has no %s\n", o->type->name, name);
    assert_non_null(f);
    return (const char *)o->desc + f->offset;
}

static inline double float_of(const object *o, const char *name) {
    return (double)*(const float *)field_of(o, name);
}

static inline int int_of(const object *o, const char *name) {
    return *(const int32_t *)field_of(o, name);
}

static inline snell_input input_of(const object *o, const char *name) {
    return *(const snell_input *)field_of(o, name);
}

#endif
