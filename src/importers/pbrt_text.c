/* The text of pbrt files: tokens, parameter lists, files within files. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/files.h"
#include "importers/pbrt.h"

enum { INCLUDE_DEPTH_MAX = 32, FILES_MAX = 10000 };

/* ---- errors ---- */

snell_status pbrt_fail(pbrt *p, source_place place, const char *hint, const char *format, ...) {
    if (p->status) return p->status;
    char text[800];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return p->status = error_set_at(SNELL_ERR_SYNTAX, place, hint, "%s", text);
}

snell_status pbrt_blame(pbrt *p, source_place place, snell_status status) {
    if (status == SNELL_OK || p->status) return p->status;
    error_place(place);
    return p->status = status;
}

snell_status pbrt_warn(pbrt *p, source_place place, const char *format, ...) {
    if (p->status) return p->status;
    char text[400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return pbrt_blame(
        p, place,
        description_add_message(p->d, SNELL_WARNING, place.file, place.line, NULL, "%s", text));
}

snell_status pbrt_spend(pbrt *p, source_place place, uint64_t size) {
    if (p->status) return p->status;
    if (size > p->budget)
        return p->status = error_set_at(SNELL_ERR_MEMORY, place, NULL,
                                        "the file asks for more memory than it may have");
    p->budget -= size;
    return SNELL_OK;
}

/* ---- tokens ---- */

static source_place here(const pbrt_text *t) {
    return (source_place){t->path, t->line, (uint32_t)(t->at - t->line_start) + 1};
}

static void skip_space(pbrt_text *t) {
    for (; t->at < t->end; t->at++) {
        if (*t->at == '#')
            while (t->at < t->end && *t->at != '\n') t->at++;
        if (t->at == t->end) return;
        if (*t->at == '\n') {
            t->line++;
            t->line_start = t->at + 1;
        } else if (*t->at != ' ' && *t->at != '\t' && *t->at != '\r') {
            return;
        }
    }
}

static snell_status add_letter(pbrt *p, char letter) {
    if (!ARRAY_GROW(p->word, p->word_size, p->word_capacity, 2))
        return pbrt_blame(p, p->place, error_no_memory());
    p->word[p->word_size++] = letter;
    p->word[p->word_size] = 0;
    return SNELL_OK;
}

static char unescape(char letter) {
    static const char from[] = "bfnrt", to[] = "\b\f\n\r\t";
    const char *at = letter ? strchr(from, letter) : NULL;
    return at ? to[at - from] : letter;
}

static snell_status read_string(pbrt *p) {
    pbrt_text *t = p->text;
    for (t->at++; t->at < t->end && *t->at != '"'; t->at++) {
        if (*t->at == '\n') break;
        if (*t->at == '\\' && t->at + 1 < t->end) {
            t->at++;
            if (!strchr("bfnrt\\'\"", *t->at) || *t->at == 0)
                return pbrt_fail(p, here(t), NULL, "no character is written '\\%.1s'", t->at);
            if (add_letter(p, unescape(*t->at))) return p->status;
        } else if (*t->at == 0) {
            return pbrt_fail(p, here(t), NULL, "a zero byte in a string");
        } else if (add_letter(p, *t->at)) {
            return p->status;
        }
    }
    if (t->at == t->end || *t->at != '"')
        return pbrt_fail(p, p->place, "close it with \"", "this string does not end on its line");
    t->at++;
    p->kind = PBRT_STRING;
    return SNELL_OK;
}

snell_status pbrt_next(pbrt *p) {
    if (p->status) return p->status;
    if (p->held) {
        p->held = false;
        return SNELL_OK;
    }
    pbrt_text *t = p->text;
    skip_space(t);
    p->place = here(t);
    p->word_size = 0;
    if (add_letter(p, 0)) return p->status;
    p->word_size = 0;
    if (t->at == t->end) {
        p->kind = PBRT_END;
    } else if (*t->at == '"') {
        return read_string(p);
    } else if (*t->at == '[' || *t->at == ']') {
        p->kind = *t->at == '[' ? PBRT_OPEN : PBRT_CLOSE;
        add_letter(p, *t->at++);
    } else {
        p->kind = PBRT_WORD;
        while (t->at < t->end && (*t->at == 0 || !strchr(" \t\r\n\"[]#", *t->at)))
            if (add_letter(p, *t->at++)) break;
    }
    return p->status;
}

/* What stands there instead of what was needed. */
static snell_status complain(pbrt *p, const char *directive, const char *needed) {
    if (p->kind == PBRT_END)
        return pbrt_fail(p, p->place, "the file may be cut off",
                         "the file ends where '%s' needs %s", directive, needed);
    return pbrt_fail(p, p->place, NULL, "'%s' needs %s here, not '%.40s'", directive, needed,
                     p->word);
}

snell_status pbrt_need_string(pbrt *p, const char *directive) {
    if (pbrt_next(p)) return p->status;
    return p->kind == PBRT_STRING ? SNELL_OK : complain(p, directive, "a name in quotes");
}

bool pbrt_to_number(const char *word, double *out) {
    if (word[strspn(word, "+-.0123456789eE")] != 0 || !strpbrk(word, "0123456789")) return false;
    char *rest;
    *out = strtod(word, &rest);
    return *rest == 0 && fabs(*out) < 3e38;
}

snell_status pbrt_need_numbers(pbrt *p, const char *directive, double *out, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (pbrt_next(p)) return p->status;
        if (p->kind != PBRT_WORD || !pbrt_to_number(p->word, &out[i]))
            return complain(p, directive, "a number");
    }
    return SNELL_OK;
}

snell_status pbrt_need_matrix(pbrt *p, const char *directive, double out[16]) {
    if (pbrt_next(p)) return p->status;
    bool bracket = p->kind == PBRT_OPEN;
    p->held = !bracket;
    if (pbrt_need_numbers(p, directive, out, 16) || !bracket || pbrt_next(p)) return p->status;
    return p->kind == PBRT_CLOSE ? SNELL_OK : complain(p, directive, "the closing ']'");
}

/* ---- parameters ---- */

void pbrt_param_free(pbrt_param *param) {
    if (param == NULL) return;
    for (size_t i = 0; param->strings && i < param->count; i++) free(param->strings[i]);
    free(param->strings);
    free(param->numbers);
    free(param->type);
    free(param);
}

void pbrt_params_free(pbrt_params *params) {
    while (params->own) {
        pbrt_param *next = params->own->next;
        pbrt_param_free(params->own);
        params->own = next;
    }
}

static const char *const types[] = {"integer", "float",    "point2",    "vector2", "point3",
                                    "vector3", "normal",   "normal3",   "bool",    "string",
                                    "texture", "spectrum", "blackbody", "rgb"};
enum { TYPE_COUNT = sizeof types / sizeof types[0] };

static snell_status check_type(pbrt *p, const pbrt_param *param) {
    static const char *const old[] = {"point", "vector", "color", "xyz"};
    for (size_t i = 0; i < TYPE_COUNT; i++)
        if (strcmp(types[i], param->type) == 0) return SNELL_OK;
    for (size_t i = 0; i < 4; i++)
        if (strcmp(old[i], param->type) == 0)
            return pbrt_fail(p, param->place, "'pbrt --upgrade' of pbrt-v4 converts it",
                             "the type '%s' is of an older pbrt; this is a reader of pbrt-v4",
                             param->type);
    char hint[80];
    const char *like = closest_word(param->type, types, TYPE_COUNT);
    snprintf(hint, sizeof hint, "did you mean '%s'?", like ? like : "");
    return pbrt_fail(p, param->place, like ? hint : NULL, "unknown type '%.40s' of a parameter",
                     param->type);
}

/* "float radius": the type and the name, with blanks between. */
static snell_status split_declaration(pbrt *p, pbrt_param *param) {
    static const char blanks[] = " \t";
    param->place = p->place;
    param->type = memory_copy_string(p->word);
    if (param->type == NULL) return pbrt_blame(p, p->place, error_no_memory());
    char *type = param->type + strspn(param->type, blanks);
    char *end = type + strcspn(type, blanks), *name = end + strspn(end, blanks);
    if (*name == 0)
        return pbrt_fail(p, p->place, "such as \"float radius\"",
                         "a parameter needs a type and a name, not '%.40s'", p->word);
    name[strcspn(name, blanks)] = 0;
    *end = 0;
    memmove(param->type, type, (size_t)(end - type) + 1);
    param->name = name;
    return check_type(p, param);
}

static pbrt_value_kind kind_of(const char *type) {
    if (strcmp(type, "bool") == 0) return PBRT_BOOLS;
    return strcmp(type, "string") == 0 || strcmp(type, "texture") == 0 ? PBRT_STRINGS
                                                                       : PBRT_NUMBERS;
}

static snell_status complain_of_value(pbrt *p, const pbrt_param *param) {
    static const char *const needs[] = {"numbers", "strings in quotes", "true or false"};
    return pbrt_fail(p, p->place, p->kind == PBRT_END ? "the file may be cut off" : NULL,
                     "'%s %s' needs %s, not '%.40s'", param->type, param->name, needs[param->kind],
                     p->kind == PBRT_END ? "the end of the file" : p->word);
}

static snell_status add_string(pbrt *p, pbrt_param *param) {
    if (!ARRAY_GROW(param->strings, param->count, param->capacity, 1))
        return pbrt_blame(p, p->place, error_no_memory());
    char *copy = memory_copy_string(p->word);
    if (copy == NULL) return pbrt_blame(p, p->place, error_no_memory());
    param->strings[param->count++] = copy;
    return SNELL_OK;
}

static snell_status add_value(pbrt *p, pbrt_param *param) {
    /* A spectrum is a name or numbers. */
    if (param->count == 0 && p->kind == PBRT_STRING && strcmp(param->type, "spectrum") == 0)
        param->kind = PBRT_STRINGS;
    double value = 0;
    bool truth = strcmp(p->word, "true") == 0, untruth = strcmp(p->word, "false") == 0;
    if (param->kind == PBRT_STRINGS)
        return p->kind == PBRT_STRING ? add_string(p, param) : complain_of_value(p, param);
    if (param->kind == PBRT_BOOLS ? !truth && !untruth
                                  : p->kind != PBRT_WORD || !pbrt_to_number(p->word, &value))
        return complain_of_value(p, param);
    if (strcmp(param->type, "integer") == 0 && !(value == floor(value) && fabs(value) < 0x1p31))
        return pbrt_fail(p, p->place, NULL, "'integer %s' needs a whole number, not '%.40s'",
                         param->name, p->word);
    if (!ARRAY_GROW(param->numbers, param->count, param->capacity, 1))
        return pbrt_blame(p, p->place, error_no_memory());
    param->numbers[param->count++] = param->kind == PBRT_BOOLS ? truth : value;
    return SNELL_OK;
}

static snell_status read_values(pbrt *p, pbrt_param *param) {
    param->kind = kind_of(param->type);
    if (pbrt_next(p)) return p->status;
    if (p->kind != PBRT_OPEN) {
        if (p->kind == PBRT_CLOSE) return complain_of_value(p, param);
        return add_value(p, param);
    }
    while (!pbrt_next(p) && p->kind != PBRT_CLOSE) {
        if (p->kind == PBRT_END || p->kind == PBRT_OPEN)
            return pbrt_fail(p, p->place, "close the list with ']'",
                             "the list of '%s %s' does not end", param->type, param->name);
        if (add_value(p, param)) break;
    }
    return p->status;
}

snell_status pbrt_read_params(pbrt *p, pbrt_params *out) {
    while (!pbrt_next(p)) {
        if (p->kind != PBRT_STRING) {
            p->held = true;
            return SNELL_OK;
        }
        pbrt_param *param = memory_zeroed(1, sizeof *param);
        if (param == NULL) return pbrt_blame(p, p->place, error_no_memory());
        param->space = p->state.space;
        if (split_declaration(p, param)) { /* in the list, all have names */
            pbrt_param_free(param);
            break;
        }
        param->next = out->own;
        out->own = param;
        if (read_values(p, param)) break;
    }
    return p->status;
}

snell_status pbrt_need_params(pbrt *p, const char *directive, pbrt_params *out) {
    *out = (pbrt_params){.place = p->place, .space = p->state.space};
    if (pbrt_need_string(p, directive)) return p->status;
    snprintf(out->type, sizeof out->type, "%s", p->word);
    snprintf(out->what, sizeof out->what, "%s \"%.40s\"", directive, p->word);
    return pbrt_read_params(p, out);
}

/* ---- files ---- */

static snell_status keep_path(pbrt *p, char *path, source_place place) {
    if (!ARRAY_GROW(p->paths, p->path_count, p->path_capacity, 1)) {
        free(path);
        return pbrt_blame(p, place, error_no_memory());
    }
    p->paths[p->path_count++] = path;
    return SNELL_OK;
}

static snell_status load(pbrt *p, pbrt_text *t, source_place place) {
    uint8_t *data;
    size_t size;
    snell_status status = import_read_file(t->path, NULL, p->options, &data, &size);
    if (status) return pbrt_blame(p, place, status);
    t->data = (char *)data;
    t->at = t->line_start = t->data + import_mark_size(data, size);
    t->end = t->data + size;
    t->line = 1;
    source_place start = {t->path, 0, 0};
    if (size >= 2 && data[0] == 0x1f && data[1] == 0x8b)
        return pbrt_fail(p, start, "unpack it with gunzip, and name the unpacked file",
                         "this file is compressed");
    if (size >= 2 && ((data[0] == 0xff && data[1] == 0xfe) || (data[0] == 0xfe && data[1] == 0xff)))
        return pbrt_fail(p, start, "save it as UTF-8", "this file is UTF-16");
    return pbrt_spend(p, place, size);
}

snell_status pbrt_with_file(pbrt *p, const char *name, source_place place,
                            snell_status (*read)(pbrt *p)) {
    if (p->status) return p->status;
    if (p->depth == INCLUDE_DEPTH_MAX || p->file_count == FILES_MAX)
        return pbrt_fail(p, place, "a file may include itself", "too many files within files");
    char *path = NULL;
    snell_status status = p->depth ? import_resolve(p->path, name, p->options, &path) : SNELL_OK;
    if (status) return pbrt_blame(p, place, status);
    if (path && keep_path(p, path, place)) return p->status;
    pbrt_text text = {.path = path ? path : p->path}, *before = p->text;
    p->text = &text;
    p->depth++;
    p->file_count++;
    if (!load(p, &text, place)) read(p);
    free(text.data);
    p->text = before;
    p->depth--;
    return p->status;
}
