#include "importers/names.h"

#include <stdio.h>
#include <string.h>

void names_deinit(name_set *names) {
    for (int i = 0; i < NAME_KINDS; i++) json_decref(names->seen[i]);
    *names = (name_set){0};
}

/* Control characters would garble messages and lists of names; so would other encodings than UTF-8,
 * whose letters become '?'. Cut at a character's start. */
static void copy_clean(const char *wanted, char *out, size_t size) {
    size_t length = 0;
    for (; wanted[length] && length + 1 < size; length++)
        out[length] =
            (unsigned char)wanted[length] < 32 || wanted[length] == 127 ? ' ' : wanted[length];
    if (wanted[length])
        while (length > 0 && ((unsigned char)wanted[length] & 0xc0) == 0x80) length--;
    out[length] = '\0';
    json_t *probe = json_string(out);
    for (char *c = out; probe == NULL && *c; c++)
        if ((unsigned char)*c >= 128) *c = '?';
    json_decref(probe);
}

snell_status names_make_unique(name_set *names, int kind, const char *wanted, char *out) {
    copy_clean(wanted ? wanted : "", out, NAME_MAX_SIZE - 24);
    if (out[0] == '\0') return SNELL_OK;
    if (names->seen[kind] == NULL) names->seen[kind] = json_object();
    json_t *seen = names->seen[kind];
    if (seen == NULL) return error_no_memory();
    json_t *counter = json_object_get(seen, out);
    if (counter == NULL)
        return json_object_set_new(seen, out, json_integer(1)) == 0 ? SNELL_OK : error_no_memory();
    char base[NAME_MAX_SIZE];
    memcpy(base, out, NAME_MAX_SIZE);
    do { /* "a.2" may have been a name of the file's own */
        json_integer_set(counter, json_integer_value(counter) + 1);
        snprintf(out, NAME_MAX_SIZE, "%.*s.%lld", NAME_MAX_SIZE - 24, base,
                 (long long)json_integer_value(counter));
    } while (json_object_get(seen, out));
    return json_object_set_new(seen, out, json_integer(1)) == 0 ? SNELL_OK : error_no_memory();
}
