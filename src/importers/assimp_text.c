/* Files as libassimp's readers understand them. Its OBJ reader refuses a whole file for numbers such
 * as ".5" and for statements of newer dialects that it takes for numbers ("aniso"); its PLY reader
 * never ends on a header that does not. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/assimp_reader.h"

static bool is_space(uint8_t c) { return c == ' ' || c == '\t'; }

/* A '.' that begins a number: after a space, or after a sign that follows a space. */
static bool is_bare_point(const uint8_t *text, size_t size, size_t i) {
    if (text[i] != '.' || i == 0 || i + 1 >= size || text[i + 1] < '0' || text[i + 1] > '9')
        return false;
    if (is_space(text[i - 1])) return true;
    return i >= 2 && (text[i - 1] == '-' || text[i - 1] == '+') && is_space(text[i - 2]);
}

snell_status obj_repair(uint8_t **text, size_t *size) {
    size_t points = 0;
    for (size_t i = 0; i < *size; i++) points += is_bare_point(*text, *size, i);
    if (points == 0) return SNELL_OK;
    uint8_t *out = memory_resize(NULL, *size + points + 1, 1);
    if (out == NULL) return error_no_memory();
    size_t used = 0;
    for (size_t i = 0; i < *size; i++) {
        if (is_bare_point(*text, *size, i)) out[used++] = '0';
        out[used++] = (*text)[i];
    }
    out[used] = 0;
    free(*text);
    *text = out;
    *size = used;
    return SNELL_OK;
}

snell_status ply_check(const uint8_t *text, size_t size) {
    if (memmem(text, size, "end_header", 10)) return SNELL_OK;
    return error_set(SNELL_ERR_SYNTAX, NULL, "the PLY header has no end");
}

/* The statements that materials are made from; bump and reflection maps stay, to be warned of. */
static bool is_mtl_word(const uint8_t *word, size_t length) {
    static const char *const words[] = {"newmtl", "Ka",   "Kd",   "Ks",   "Ke",
                                        "Tf",     "Ns",   "Ni",   "d",    "Tr",
                                        "illum",  "bump", "norm", "refl", "disp"};
    if (length >= 4 && memcmp(word, "map_", 4) == 0) return true;
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        if (strlen(words[i]) == length && memcmp(words[i], word, length) == 0) return true;
    return false;
}

/* Other lines become blank, in place, so that line numbers stay. */
void mtl_repair(uint8_t *text, size_t size) {
    for (size_t at = 0; at < size;) {
        size_t end = at, word = at;
        while (end < size && text[end] != '\n') end++;
        while (word < end && is_space(text[word])) word++;
        size_t length = 0;
        while (word + length < end && text[word + length] > ' ') length++;
        if (length > 0 && !is_mtl_word(text + word, length))
            for (size_t i = at; i < end; i++)
                if (text[i] != '\r') text[i] = ' ';
        at = end + 1;
    }
}

/* ---- which text is OBJ ---- */

static bool begins_with_word(const char *line, size_t length, const char *word) {
    size_t span = strlen(word);
    return length > span && memcmp(line, word, span) == 0 &&
           (line[span] == ' ' || line[span] == '\t');
}

static bool number_follows(const char *line, size_t length, size_t at) {
    while (at < length && (line[at] == ' ' || line[at] == '\t')) at++;
    if (at < length && (line[at] == '-' || line[at] == '+')) at++;
    if (at < length && line[at] == '.') at++;
    return at < length && line[at] >= '0' && line[at] <= '9';
}

/* The first line that says something begins with a word of OBJ, and one of them is a vertex, a face
 * or a material library. */
bool obj_recognise(const uint8_t *first, size_t size) {
    static const char *const words[] = {"v", "vn", "vt", "f",      "o",
                                        "g", "s",  "l",  "mtllib", "usemtl"};
    bool begun = false;
    for (size_t at = 0; at < size;) {
        const char *line = (const char *)first + at;
        const char *end = memchr(line, '\n', size - at);
        size_t length = end ? (size_t)(end - line) : size - at;
        at += length + 1;
        while (length > 0 && (*line == ' ' || *line == '\t' || *line == '\r')) line++, length--;
        if (length == 0 || *line == '#') continue;
        for (size_t i = 0; i < sizeof words / sizeof words[0] && !begun; i++)
            begun = begins_with_word(line, length, words[i]);
        if (!begun) return false;
        if (begins_with_word(line, length, "mtllib")) return true;
        if ((begins_with_word(line, length, "v") || begins_with_word(line, length, "f")) &&
            number_follows(line, length, 1))
            return true;
    }
    return false;
}
