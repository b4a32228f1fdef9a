#include "text.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORD_MAX = 47 };

/* Optimal string alignment: insert, delete, replace, swap of neighbours cost one each. */
static size_t edit_distance(const char *a, size_t a_length, const char *b, size_t b_length) {
    size_t rows[3][WORD_MAX + 1];
    if (a_length > WORD_MAX || b_length > WORD_MAX) return SIZE_MAX;
    for (size_t j = 0; j <= b_length; j++) rows[0][j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t *row = rows[i % 3];
        const size_t *above = rows[(i + 2) % 3], *above2 = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            size_t best = above[j - 1] + (a[i - 1] != b[j - 1]);
            if (above[j] + 1 < best) best = above[j] + 1;
            if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                above2[j - 2] + 1 < best) {
                best = above2[j - 2] + 1;
            }
            row[j] = best;
        }
    }
    return rows[a_length % 3][b_length];
}

/* How far a misspelling may be: one letter in three, or one in a word of two to five; a single letter
 * is like no other. A word that was cut short is near too. */
static size_t word_distance(const char *word, const char *other, size_t other_length) {
    size_t length = strlen(word), far = length < 2 ? 0 : length < 6 ? 1 : length / 3;
    if (other_length == 0) return SIZE_MAX;
    if (length >= 3 && other_length > length && strncmp(word, other, length) == 0) return 1;
    size_t distance = edit_distance(word, length, other, other_length);
    return distance <= far ? distance : SIZE_MAX;
}

const char *text_closest(const char *word, const char *const *words, size_t count) {
    const char *best = NULL;
    size_t best_distance = SIZE_MAX;
    for (size_t i = 0; i < count; i++) {
        size_t distance = word_distance(word, words[i], strlen(words[i]));
        if (distance < best_distance) {
            best_distance = distance;
            best = words[i];
        }
    }
    return best;
}

bool text_choice_has(const char *choices, const char *word) {
    size_t length = strlen(word);
    for (const char *at = choices; *at != '\0';) {
        size_t span = strcspn(at, "|");
        if (span == length && strncmp(at, word, span) == 0) return true;
        at += span + (at[span] == '|');
    }
    return false;
}

bool text_choice_closest(const char *choices, const char *word, char *out, size_t size) {
    size_t best_distance = SIZE_MAX;
    for (const char *at = choices; *at != '\0';) {
        size_t span = strcspn(at, "|"), distance = word_distance(word, at, span);
        if (distance < best_distance) {
            best_distance = distance;
            snprintf(out, size, "%.*s", (int)span, at);
        }
        at += span + (at[span] == '|');
    }
    return best_distance != SIZE_MAX;
}

void text_choice_list(const char *choices, char *out, size_t size) {
    size_t used = 0;
    for (const char *c = choices; *c != '\0' && used + 3 < size; c++) {
        if (*c == '|') out[used++] = ',';
        out[used++] = *c == '|' ? ' ' : *c;
    }
    out[used] = '\0';
}

bool text_uint(const char *text, uint64_t min, uint64_t max, uint64_t *out) {
    uint64_t value = 0;
    if (*text == '\0') return false;
    for (const char *c = text; *c != '\0'; c++) {
        if (*c < '0' || *c > '9') return false;
        uint64_t digit = (uint64_t)(*c - '0');
        if (value > (UINT64_MAX - digit) / 10) return false;
        value = value * 10 + digit;
    }
    if (value < min || value > max) return false;
    *out = value;
    return true;
}

/* The program never calls setlocale, so strtod reads '.' everywhere. Hexadecimal, "inf" and "nan"
 * are not numbers here. */
bool text_number(const char *text, double *out) {
    if (*text == '\0' || strspn(text, "+-0123456789.eE") != strlen(text)) return false;
    char *end = NULL;
    double value = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(value)) return false;
    *out = value;
    return true;
}

bool text_bytes(const char *text, uint64_t *out) {
    char *end = NULL;
    if (*text < '0' || *text > '9') return false;
    double value = strtod(text, &end);
    if (end == text || value <= 0) return false;
    static const char units[] = "KMGT";
    if (*end != '\0') {
        const char *unit = strchr(units, toupper((unsigned char)*end));
        if (unit == NULL) return false;
        for (long i = 0; i <= unit - units; i++) value *= 1024;
        end++;
        if (*end == 'i') end++;
        if (*end == 'B') end++;
    }
    if (*end != '\0' || !(value >= 1 && value < 9e18)) return false;
    *out = (uint64_t)value;
    return true;
}

/* The fifth root by Newton's method in doubles: +, *, / give the same bits on every machine, which
 * pow() does not. The iteration comes down from above and stops when it no longer falls. */
static double fifth_root(double a) {
    if (a <= 0) return 0;
    double y = a < 1 ? 1 : a;
    for (int i = 0; i < 200; i++) {
        double next = (4 * y + a / (y * y * y * y)) / 5;
        if (!(next < y)) break;
        y = next;
    }
    return y;
}

/* IEC 61966-2-1: ((c + 0.055) / 1.055) ^ 2.4, written as x^2 * (x^2)^(1/5). */
static float srgb_decode(unsigned byte) {
    double c = byte / 255.0;
    if (c <= 0.04045) return (float)(c / 12.92);
    double x = (c + 0.055) / 1.055;
    return (float)(x * x * fifth_root(x * x));
}

static bool hex_color(const char *digits, snell_vec3 *out) {
    size_t length = strlen(digits);
    unsigned v[6];
    if (length != 3 && length != 6) return false;
    for (size_t i = 0; i < length; i++) {
        if (!isxdigit((unsigned char)digits[i])) return false;
        int c = tolower((unsigned char)digits[i]);
        v[i] = (unsigned)(c <= '9' ? c - '0' : c - 'a' + 10);
    }
    unsigned rgb[3];
    for (size_t i = 0; i < 3; i++) {
        rgb[i] = length == 3 ? v[i] * 17 : v[2 * i] * 16 + v[2 * i + 1];
    }
    *out = (snell_vec3){srgb_decode(rgb[0]), srgb_decode(rgb[1]), srgb_decode(rgb[2])};
    return true;
}

bool text_color(const char *text, snell_vec3 *out) {
    static const struct {
        const char *name, *digits;
    } names[] = {
        {"white", "fff"},     {"silver", "c0c0c0"}, {"grey", "808080"},   {"gray", "808080"},
        {"black", "000"},     {"red", "f00"},       {"maroon", "800000"}, {"yellow", "ff0"},
        {"olive", "808000"},  {"lime", "0f0"},      {"green", "008000"},  {"cyan", "0ff"},
        {"teal", "008080"},   {"blue", "00f"},      {"navy", "000080"},   {"magenta", "f0f"},
        {"purple", "800080"}, {"orange", "ffa500"}, {"pink", "ffc0cb"},
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(text, names[i].name) == 0) return hex_color(names[i].digits, out);
    }
    if (text[0] == '#') return hex_color(text + 1, out);
    double v[3];
    size_t count = 0;
    for (const char *at = text; count < 3; at++) {
        char word[64];
        size_t span = strcspn(at, ",");
        if (span >= sizeof word) return false;
        memcpy(word, at, span);
        word[span] = '\0';
        if (!text_number(word, &v[count]) || v[count] < 0 || v[count] > 1e6) return false;
        count++;
        at += span;
        if (*at == '\0') break;
        if (count == 3) return false;
    }
    if (count == 2) return false;
    if (count == 1) v[1] = v[2] = v[0];
    *out = (snell_vec3){(float)v[0], (float)v[1], (float)v[2]};
    return true;
}

void text_print_safe(FILE *to, const char *text) {
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        if (*c == '\n' && c[1] != '\0') {
            fputs("\n  ", to);
        } else if (*c < 32 || *c == 127) {
            fprintf(to, "\\x%02x", (unsigned)*c);
        } else if (*c == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) { /* C1 controls in UTF-8 */
            fprintf(to, "\\u%04x", (unsigned)c[1]);
            c++;
        } else {
            fputc(*c, to);
        }
    }
}

void text_print_shell(FILE *to, const char *text) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "-_=+./,:@%";
    if (*text != '\0' && strspn(text, plain) == strlen(text)) {
        fputs(text, to);
        return;
    }
    bool control = false;
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        if (*c < 32 || *c == 127 || *c == 0xc2) control = true;
    }
    fputs(control ? "$'" : "'", to);
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        if (control && (*c < 32 || *c >= 127))
            fprintf(to, "\\x%02x", (unsigned)*c);
        else if (control && (*c == '\'' || *c == '\\'))
            fprintf(to, "\\%c", *c);
        else if (*c == '\'')
            fputs("'\\''", to);
        else
            fputc(*c, to);
    }
    fputc('\'', to);
}

size_t text_print_wrapped(FILE *to, const char *text, size_t column, size_t indent, size_t width) {
    bool first = true;
    while (*text != '\0') {
        if (*text == '\n') {
            fprintf(to, "\n%*s", (int)indent, "");
            column = indent;
            first = true;
            text++;
            continue;
        }
        size_t span = strcspn(text, " \n");
        if (!first && column + 1 + span > width) {
            fprintf(to, "\n%*s", (int)indent, "");
            column = indent;
        } else if (!first) {
            fputc(' ', to);
            column++;
        }
        fwrite(text, 1, span, to);
        column += span;
        first = false;
        text += span;
        while (*text == ' ') text++;
    }
    return column;
}

void text_format_bytes(uint64_t bytes, char out[32]) {
    static const char *const units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
    double value = (double)bytes;
    size_t unit = 0;
    while (value >= 1024 && unit + 1 < sizeof units / sizeof units[0]) {
        value /= 1024;
        unit++;
    }
    snprintf(out, 32, unit == 0 || value >= 100 ? "%.0f %s" : "%.1f %s", value, units[unit]);
}

void text_format_count(uint64_t count, char out[32]) {
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)count);
    size_t used = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0 && length > 4) out[used++] = ' ';
        out[used++] = digits[i];
    }
    out[used] = '\0';
}

void text_format_float(float value, char out[32]) {
    for (int digits = 1; digits <= 9; digits++) {
        snprintf(out, 32, "%.*g", digits, (double)value);
        if (strtof(out, NULL) == value) return;
    }
}
