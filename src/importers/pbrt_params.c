/* Values out of pbrt's parameter lists. */
#include <stdio.h>
#include <string.h>

#include "importers/pbrt.h"

static pbrt_param *find_in(pbrt_param *list, const char *name) {
    while (list && strcmp(list->name, name) != 0) list = list->next;
    return list;
}

pbrt_param *pbrt_find(const pbrt_params *params, const char *name) {
    pbrt_param *own = find_in(params->own, name);
    return own ? own : find_in(params->attributes, name);
}

/* The parameter if it is there, of one of the types (blanks between), with `count` values (0: any). */
static const pbrt_param *take(pbrt *p, const pbrt_params *params, const char *name,
                              const char *wanted, size_t count) {
    pbrt_param *param = pbrt_find(params, name);
    if (param == NULL || p->status) return NULL;
    param->used = true;
    size_t length = strlen(param->type), here;
    const char *at = wanted;
    for (; *at; at += here, at += *at == ' ') {
        here = strcspn(at, " ");
        if (here == length && memcmp(at, param->type, here) == 0) break;
    }
    if (*at == 0) {
        pbrt_fail(p, param->place, NULL, "%s: '%s' is a %.*s, not a %s", params->what, name,
                  (int)strcspn(wanted, " "), wanted, param->type);
        return NULL;
    }
    if (count ? param->count == count : param->count > 0) return param;
    pbrt_fail(p, param->place, NULL, "%s: '%s' needs %zu value%s, not %zu", params->what, name,
              count ? count : 1, count > 1 ? "s" : "", param->count);
    return NULL;
}

double pbrt_float(pbrt *p, const pbrt_params *params, const char *name, double otherwise) {
    const pbrt_param *param = take(p, params, name, "float integer", 1);
    return param ? param->numbers[0] : otherwise;
}

int pbrt_int(pbrt *p, const pbrt_params *params, const char *name, int otherwise) {
    const pbrt_param *param = take(p, params, name, "integer", 1);
    return param ? (int)param->numbers[0] : otherwise;
}

bool pbrt_bool(pbrt *p, const pbrt_params *params, const char *name, bool otherwise) {
    const pbrt_param *param = take(p, params, name, "bool", 1);
    return param ? param->numbers[0] > 0 : otherwise;
}

const char *pbrt_string(pbrt *p, const pbrt_params *params, const char *name,
                        const char *otherwise) {
    const pbrt_param *param = take(p, params, name, "string", 1);
    return param ? param->strings[0] : otherwise;
}

dvec3 pbrt_vec3(pbrt *p, const pbrt_params *params, const char *name, dvec3 otherwise) {
    const pbrt_param *param = take(p, params, name, "point3 vector3 normal normal3", 3);
    return param ? (dvec3){param->numbers[0], param->numbers[1], param->numbers[2]} : otherwise;
}

const double *pbrt_numbers(pbrt *p, const pbrt_params *params, const char *name, size_t per,
                           size_t *count) {
    static const char *const wanted[] = {"", "integer float", "point2 vector2 float",
                                         "point3 vector3 normal normal3", "float integer"};
    *count = 0;
    pbrt_param *there = pbrt_find(params, name);
    if (there && there->count == 0) {
        there->used = true;
        return NULL;
    }
    const pbrt_param *param = take(p, params, name, wanted[per], 0);
    if (param == NULL) return NULL;
    if (param->count % per) {
        pbrt_fail(p, param->place, NULL, "%s: '%s' has %zu numbers, which is no multiple of %zu",
                  params->what, name, param->count, per);
        return NULL;
    }
    *count = param->count / per;
    return param->numbers;
}

/* Calls for each of the names that is given. */
static void for_each(pbrt *p, const pbrt_params *params, const char *names, bool warn) {
    char name[40];
    for (const char *at = names; *at;) {
        size_t length = strcspn(at, " ");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        pbrt_param *param = pbrt_find(params, name);
        if (param) param->used = true;
        if (param && warn)
            pbrt_warn(p, param->place, "%s: '%s' is not supported: ignored", params->what, name);
        at += length;
        at += strspn(at, " ");
    }
}

void pbrt_ignore(const pbrt_params *params, const char *names) {
    for_each(NULL, params, names, false);
}

void pbrt_lacks(pbrt *p, const pbrt_params *params, const char *names) {
    for_each(p, params, names, true);
}

snell_status pbrt_check_unused(pbrt *p, const pbrt_params *params) {
    for (const pbrt_param *param = params->own; param && !p->status; param = param->next)
        if (!param->used && find_in(params->own, param->name) == param)
            pbrt_warn(p, param->place, "%s has no '%.60s': ignored", params->what, param->name);
    return p->status;
}
