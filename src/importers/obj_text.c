#include "importers/obj_text.h"

#include <string.h>

#include "base/memory.h"
#include "importers/files.h"

/* ---- lines that end with \n ---- */

static size_t put_utf8(char *out, uint32_t c) {
    if (c < 0x80) return out[0] = (char)c, (size_t)1;
    if (c < 0x800)
        return out[0] = (char)(0xc0 | c >> 6), out[1] = (char)(0x80 | (c & 63)), (size_t)2;
    out[0] = (char)(0xe0 | c >> 12);
    out[1] = (char)(0x80 | (c >> 6 & 63));
    out[2] = (char)(0x80 | (c & 63));
    return 3;
}

/* UTF-16 with its mark; letters beyond the first plane become two odd ones. */
static char *from_utf16(const char *text, size_t *size) {
    bool big = (uint8_t)text[0] == 0xfe;
    char *out = memory_resize(NULL, *size / 2 + 1, 3);
    size_t used = 0;
    for (size_t i = 2; out && i + 1 < *size; i += 2) {
        uint32_t c = (uint32_t)(uint8_t)text[i + !big] << 8 | (uint8_t)text[i + big];
        used += put_utf8(out + used, c ? c : ' ');
    }
    if (out) out[used] = 0;
    *size = used;
    return out;
}

/* A line goes on where it ends with a backslash. Both become blanks, so that places stay. */
static bool has_continuation(const char *text, size_t size) {
    enum { PART = 1 << 20 };
    for (size_t done = 0; done < size;
         done += PART) { /* what was looked at need not stay in memory */
        size_t part = size - done < PART ? size - done : PART;
        const char *at = text + done, *end = at + part;
        for (; (at = memchr(at, '\\', (size_t)(end - at))) != NULL; at++)
            if (at[1] == '\n' || at[1] == '\r') return true;
        import_forget(text, size, end);
    }
    return false;
}

static void join_lines(char *text) {
    for (char *at = text; (at = strchr(at, '\\')) != NULL; at++) {
        if (at[1] != '\n' && at[1] != '\r') continue;
        *at++ = ' ';
        if (at[0] == '\r' && at[1] == '\n') *at++ = ' ';
        *at = ' ';
    }
}

bool obj_text_prepare(const char *text, size_t size, obj_text *out) {
    bool wide = size >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0);
    size_t mark = import_mark_size(text, size);
    bool old = !wide && !memchr(text, '\n', size) && memchr(text, '\r', size);
    if (wide) {
        text = out->copy = from_utf16(text, &size);
        if (text == NULL) return false;
    }
    text += mark, size -= mark;
    out->lines = text;
    if (old || has_continuation(text, size)) {
        if (out->copy == NULL) {
            out->copy = memory_resize(NULL, size + 1, 1);
            if (out->copy == NULL) return false;
            memcpy(out->copy, text, size);
            out->copy[size] = 0;
            text = out->copy;
        }
        for (size_t i = 0; i < size; i++)
            if (out->copy[i] == 0 || (old && out->copy[i] == '\r'))
                out->copy[i] = out->copy[i] ? '\n' : ' ';
        join_lines(out->copy);
    }
    out->begin = text;
    out->size = size;
    return true;
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

bool obj_text_is_likely(const uint8_t *first, size_t size) {
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
