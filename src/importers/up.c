#include "importers/up.h"

#include <string.h>

bool import_up_rotation(const char *axis, transform *out) {
    static const struct {
        const char *axis;
        transform rotation;
    } table[] = {{"y", {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}},
                 {"-y", {{{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}}}},
                 {"z", {{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}}},
                 {"-z", {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}}},
                 {"x", {{{0, -1, 0, 0}, {1, 0, 0, 0}, {0, 0, 1, 0}}}},
                 {"-x", {{{0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 1, 0}}}}};
    *out = transform_identity();
    for (size_t i = 0; axis && i < sizeof table / sizeof table[0]; i++)
        if (strcmp(axis, table[i].axis) == 0) {
            *out = table[i].rotation;
            return true;
        }
    return false;
}
