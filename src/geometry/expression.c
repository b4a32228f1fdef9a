#include "geometry/expression.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/memory.h"
#include "maths/functions.h"

typedef enum code {
    CODE_NUMBER, /* number */
    CODE_X,
    CODE_Y,
    CODE_Z,
    CODE_NEGATE,
    CODE_ADD,
    CODE_SUBTRACT,
    CODE_MULTIPLY,
    CODE_DIVIDE,
    CODE_WHOLE_POWER, /* a to number, which is at least 2 */
    CODE_POWER,       /* a to number, for a >= 0 */
    CODE_SQRT,
    CODE_ABS,
    CODE_SIN,
    CODE_COS,
    CODE_ASIN,
    CODE_ACOS,
    CODE_ATAN,
    CODE_ATAN2,
    CODE_EXP,
    CODE_LOG,
    CODE_FLOOR,
    CODE_MIN,
    CODE_MAX,
    CODE_HYPOT
} code;

/* What the steps a and b gave goes in; only `code` says whether they, or the number, matter. */
typedef struct step {
    code code;
    uint16_t a, b;
    double number;
} step;

struct expression {
    uint32_t count; /* the last one is the result */
    step steps[EXPRESSION_STEPS_MAX];
};

const size_t expression_size = sizeof(expression);

/* ---- values ---- */

/* NaN if either is: fmin and a < b ? a : b would each drop one. */
static double strict_min(double a, double b) { return a < b ? a : a >= b ? b : NAN; }
static double strict_max(double a, double b) { return a > b ? a : a <= b ? b : NAN; }

static double apply(code what, double a, double b, double number) {
    switch (what) {
    case CODE_NEGATE: return -a;
    case CODE_ADD: return a + b;
    case CODE_SUBTRACT: return a - b;
    case CODE_MULTIPLY: return a * b;
    case CODE_DIVIDE: return a / b;
    case CODE_WHOLE_POWER: return integer_power(a, (int)number);
    case CODE_POWER: return a >= 0 ? fn_pow(a, number) : NAN;
    case CODE_SQRT: return sqrt(a);
    case CODE_ABS: return fabs(a);
    case CODE_SIN: return fn_sin(a);
    case CODE_COS: return fn_cos(a);
    case CODE_ASIN: return fabs(a) <= 1 ? fn_asin(a) : NAN;
    case CODE_ACOS: return fabs(a) <= 1 ? fn_acos(a) : NAN;
    case CODE_ATAN: return fn_atan(a);
    case CODE_ATAN2: return fn_atan2(a, b);
    case CODE_EXP: return fn_exp(a);
    case CODE_LOG: return a > 0 ? fn_log(a) : NAN;
    case CODE_FLOOR: return floor(a);
    case CODE_MIN: return strict_min(a, b);
    case CODE_MAX: return strict_max(a, b);
    case CODE_HYPOT: return sqrt(a * a + b * b);
    default: return number;
    }
}

/* The partial derivatives of a step by a and b. */
static void partials(const step *at, double a, double b, double value, double *by_a, double *by_b) {
    *by_a = *by_b = 0;
    switch (at->code) {
    case CODE_NEGATE: *by_a = -1; break;
    case CODE_ADD: *by_a = *by_b = 1; break;
    case CODE_SUBTRACT: *by_a = 1, *by_b = -1; break;
    case CODE_MULTIPLY: *by_a = b, *by_b = a; break;
    case CODE_DIVIDE: *by_a = 1 / b, *by_b = -value / b; break;
    case CODE_WHOLE_POWER: *by_a = at->number * integer_power(a, (int)at->number - 1); break;
    case CODE_POWER: *by_a = at->number * fn_pow(a, at->number - 1); break;
    case CODE_SQRT: *by_a = 0.5 / value; break;
    case CODE_ABS: *by_a = a < 0 ? -1 : 1; break;
    case CODE_SIN: *by_a = fn_cos(a); break;
    case CODE_COS: *by_a = -fn_sin(a); break;
    case CODE_ASIN: *by_a = 1 / sqrt(1 - a * a); break;
    case CODE_ACOS: *by_a = -1 / sqrt(1 - a * a); break;
    case CODE_ATAN: *by_a = 1 / (1 + a * a); break;
    case CODE_ATAN2: *by_a = b / (a * a + b * b), *by_b = -a / (a * a + b * b); break;
    case CODE_EXP: *by_a = value; break;
    case CODE_LOG: *by_a = 1 / a; break;
    case CODE_MIN: *(a < b ? by_a : by_b) = 1; break;
    case CODE_MAX: *(a > b ? by_a : by_b) = 1; break;
    case CODE_HYPOT:
        if (value > 0) *by_a = a / value, *by_b = b / value;
        break;
    default: break;
    }
}

double expression_at(const expression *e, dvec3 p, const dvec3 *along, int count,
                     double *derivatives) {
    double value[EXPRESSION_STEPS_MAX], slope[EXPRESSION_STEPS_MAX][3];
    for (uint32_t i = 0; i < e->count; i++) {
        const step *at = &e->steps[i];
        if (at->code <= CODE_Z) {
            const double parts[] = {at->number, p.x, p.y, p.z};
            value[i] = parts[at->code];
            for (int k = 0; k < count; k++) {
                const double direction[] = {0, along[k].x, along[k].y, along[k].z};
                slope[i][k] = direction[at->code];
            }
            continue;
        }
        double a = value[at->a], b = value[at->b], by_a, by_b;
        value[i] = apply(at->code, a, b, at->number);
        if (count == 0) continue;
        partials(at, a, b, value[i], &by_a, &by_b);
        for (int k = 0; k < count; k++)
            slope[i][k] = (slope[at->a][k] != 0 ? by_a * slope[at->a][k] : 0) +
                          (by_b != 0 ? by_b * slope[at->b][k] : 0);
    }
    for (int k = 0; k < count; k++) derivatives[k] = slope[e->count - 1][k];
    return value[e->count - 1];
}

/* ---- intervals ---- */

typedef struct bounded {
    interval value, slope[3];
    bool undefined_somewhere, undefined;
} bounded;

static interval wider(double low, double high) { return interval_wider(low, high, 2); }

/* Clips the argument to where the function is defined, and says so. */
static interval domain(bounded *out, interval a, double low, double high) {
    if (a.low >= low && a.high <= high) return a;
    out->undefined_somewhere = true;
    if (a.high < low || a.low > high) out->undefined = true;
    return (interval){double_min(double_max(a.low, low), high),
                      double_max(double_min(a.high, high), low)};
}

/* min, where `less` says that a is surely the smaller, `more` that b is. */
static void choose(interval *by_a, interval *by_b, bool a_only, bool b_only) {
    *by_a = a_only ? interval_point(1) : b_only ? interval_point(0) : (interval){0, 1};
    *by_b = b_only ? interval_point(1) : a_only ? interval_point(0) : (interval){0, 1};
}

static interval inverse_root(interval a) { /* 1 / sqrt(1 - a^2) */
    interval under = interval_sub(interval_point(1), interval_square(a));
    return interval_div(interval_point(1), interval_sqrt(under));
}

/* The value of a step and its partial derivatives. Longer than a screen: one case per operation. */
static void apply_over(const step *at, const bounded *from_a, const bounded *from_b, bounded *out,
                       interval *by_a, interval *by_b) {
    interval a = from_a->value, b = from_b->value, one = interval_point(1);
    *by_a = *by_b = interval_point(0);
    switch (at->code) {
    case CODE_NEGATE:
        out->value = interval_negate(a);
        *by_a = interval_point(-1);
        break;
    case CODE_ADD:
        out->value = interval_add(a, b);
        *by_a = *by_b = one;
        break;
    case CODE_SUBTRACT:
        out->value = interval_sub(a, b);
        *by_a = one;
        *by_b = interval_point(-1);
        break;
    case CODE_MULTIPLY:
        out->value = at->a == at->b ? interval_square(a) : interval_mul(a, b);
        *by_a = b;
        *by_b = a;
        break;
    case CODE_DIVIDE:
        out->value = interval_div(a, b);
        out->undefined_somewhere |= interval_contains(b, 0);
        *by_a = interval_div(one, b);
        *by_b = interval_negate(interval_mul(out->value, *by_a));
        break;
    case CODE_WHOLE_POWER: {
        int power = (int)at->number;
        out->value = interval_integer_power(a, power);
        *by_a = interval_scale(interval_integer_power(a, power - 1), power);
        break;
    }
    case CODE_POWER: {
        double c = at->number;
        a = domain(out, a, 0, INFINITY);
        interval slope = wider(fn_pow(a.low, c - 1), fn_pow(a.high, c - 1));
        if (c < 1) slope = wider(fn_pow(a.high, c - 1), fn_pow(a.low, c - 1));
        out->value = c < 0 ? wider(fn_pow(a.high, c), fn_pow(a.low, c))
                           : wider(fn_pow(a.low, c), fn_pow(a.high, c));
        *by_a = interval_scale(slope, c);
        break;
    }
    case CODE_SQRT:
        out->value = interval_sqrt(domain(out, a, 0, INFINITY));
        *by_a = interval_div(interval_point(0.5), out->value);
        break;
    case CODE_ABS:
        out->value = interval_abs(a);
        *by_a = (interval){a.low >= 0 ? 1 : -1, a.high <= 0 ? -1 : 1};
        if (a.low >= 0) *by_a = one;
        break;
    case CODE_SIN:
        out->value = interval_sin(a);
        *by_a = interval_cos(a);
        break;
    case CODE_COS:
        out->value = interval_cos(a);
        *by_a = interval_negate(interval_sin(a));
        break;
    case CODE_ASIN:
        a = domain(out, a, -1, 1);
        out->value = wider(fn_asin(a.low), fn_asin(a.high));
        *by_a = inverse_root(a);
        break;
    case CODE_ACOS:
        a = domain(out, a, -1, 1);
        out->value = wider(fn_acos(a.high), fn_acos(a.low));
        *by_a = interval_negate(inverse_root(a));
        break;
    case CODE_ATAN:
        out->value = wider(fn_atan(a.low), fn_atan(a.high));
        *by_a = interval_div(one, interval_add(one, interval_square(a)));
        break;
    case CODE_ATAN2: {
        bool cut = b.low <= 0 && interval_contains(a, 0);
        interval square = interval_add(interval_square(a), interval_square(b));
        out->value = interval_atan2(a, b);
        *by_a = cut ? interval_entire() : interval_div(b, square);
        *by_b = cut ? interval_entire() : interval_negate(interval_div(a, square));
        break;
    }
    case CODE_EXP:
        out->value = wider(fn_exp(a.low), fn_exp(a.high));
        *by_a = out->value;
        break;
    case CODE_LOG:
        if (!(a.low > 0)) out->undefined_somewhere = true;
        a = domain(out, a, 0, INFINITY);
        if (!(a.high > 0)) out->undefined = true;
        out->value = (interval){a.low > 0 ? wider(fn_log(a.low), 0).low : -INFINITY,
                                a.high > 0 ? wider(0, fn_log(a.high)).high : INFINITY};
        *by_a = interval_div(one, a);
        break;
    case CODE_FLOOR:
        out->value = (interval){floor(a.low), floor(a.high)};
        if (!(out->value.low == out->value.high)) *by_a = interval_entire();
        break;
    case CODE_MIN:
        out->value = (interval){double_min(a.low, b.low), double_min(a.high, b.high)};
        choose(by_a, by_b, a.high < b.low, b.high < a.low);
        break;
    case CODE_MAX:
        out->value = (interval){double_max(a.low, b.low), double_max(a.high, b.high)};
        choose(by_a, by_b, a.low > b.high, b.low > a.high);
        break;
    case CODE_HYPOT: {
        const interval unit = {-1, 1};
        out->value = interval_sqrt(interval_add(interval_square(a), interval_square(b)));
        *by_a = interval_both(unit, interval_div(a, out->value));
        *by_b = interval_both(unit, interval_div(b, out->value));
        break;
    }
    default: break;
    }
}

/* A factor that is 0 because nothing depends on it stays 0, whatever the other one's bounds. */
static interval chain(interval factor, interval slope) {
    bool none = (factor.low == 0 && factor.high == 0) || (slope.low == 0 && slope.high == 0);
    return none ? interval_point(0) : interval_mul(factor, slope);
}

static interval sum(interval a, interval b) {
    if (a.low == 0 && a.high == 0) return b;
    return b.low == 0 && b.high == 0 ? a : interval_add(a, b);
}

/* min and max of two that bend: the slope lies between theirs, which is tighter than a sum. */
static interval between(interval by_a, interval slope_a, interval slope_b) {
    if (by_a.low == by_a.high) return by_a.low == 1 ? slope_a : slope_b;
    return interval_hull(slope_a, slope_b);
}

void expression_over(const expression *e, const interval p[3], const dvec3 *along, int count,
                     expression_range *out) {
    bounded all[EXPRESSION_STEPS_MAX];
    for (uint32_t i = 0; i < e->count; i++) {
        const step *at = &e->steps[i];
        bounded *to = &all[i];
        const bounded *a = &all[at->a], *b = &all[at->b];
        to->undefined_somewhere = to->undefined = false;
        if (at->code <= CODE_Z) {
            to->value = at->code == CODE_NUMBER ? interval_point(at->number) : p[at->code - CODE_X];
            for (int k = 0; k < count; k++) {
                const double direction[] = {0, along[k].x, along[k].y, along[k].z};
                to->slope[k] = interval_point(direction[at->code]);
            }
            continue;
        }
        interval by_a, by_b;
        apply_over(at, a, b, to, &by_a, &by_b);
        to->undefined_somewhere |= a->undefined_somewhere || b->undefined_somewhere;
        to->undefined |= a->undefined || b->undefined;
        bool chooses = at->code == CODE_MIN || at->code == CODE_MAX;
        for (int k = 0; k < count; k++)
            to->slope[k] = chooses ? between(by_a, a->slope[k], b->slope[k])
                                   : sum(chain(by_a, a->slope[k]), chain(by_b, b->slope[k]));
    }
    const bounded *result = &all[e->count - 1];
    *out = (expression_range){.value = result->value,
                              .undefined_somewhere = result->undefined_somewhere,
                              .undefined = result->undefined};
    for (int k = 0; k < count; k++) out->derivatives[k] = result->slope[k];
}

/* ---- reading ---- */

typedef struct definition {
    const char *name;
    size_t length;
    int step;
} definition;

typedef struct reader {
    const char *label, *text, *at;
    expression *made;
    definition names[EXPRESSION_NAMES_MAX];
    int name_count, depth;
    snell_status status; /* the first error: everything after it gives step 0 */
} reader;

static int fail_at(reader *r, const char *at, const char *hint, const char *what) {
    if (r->status == SNELL_OK)
        r->status = error_set(SNELL_ERR_ARGUMENT, hint, "%s: column %d: %s", r->label,
                              (int)(at - r->text) + 1, what);
    return 0;
}

static int fail(reader *r, const char *hint, const char *what) {
    return fail_at(r, r->at, hint, what);
}

/* Adds a step, or finds its equal. What depends on nothing is computed at once. */
static int emit(reader *r, code what, int a, int b, double number) {
    expression *e = r->made;
    if (r->status) return 0;
    const step *left = &e->steps[a], *right = &e->steps[b];
    if (what > CODE_Z && left->code == CODE_NUMBER && right->code == CODE_NUMBER) {
        number = apply(what, left->number, right->number, number);
        if (!isfinite(number))
            return fail(r, "it depends on no x, y or z, and has no value anywhere, as sqrt(-1)",
                        "this number is not finite");
        what = CODE_NUMBER;
        a = b = 0;
    }
    for (uint32_t i = 0; i < e->count; i++) {
        const step *old = &e->steps[i];
        if (old->code == what && old->a == a && old->b == b &&
            memcmp(&old->number, &number, sizeof number) == 0)
            return (int)i;
    }
    if (e->count == EXPRESSION_STEPS_MAX) {
        char text[64];
        snprintf(text, sizeof text, "more than %d operations", EXPRESSION_STEPS_MAX);
        return fail(r, "make it of several shapes", text);
    }
    e->steps[e->count] = (step){what, (uint16_t)a, (uint16_t)b, number};
    return (int)e->count++;
}

static int number_step(reader *r, double x) { return emit(r, CODE_NUMBER, 0, 0, x); }
static int one(reader *r, code what, int a) { return emit(r, what, a, a, 0); }
static int two(reader *r, code what, int a, int b) { return emit(r, what, a, b, 0); }

static bool as_number(const reader *r, int at, double *out) {
    *out = r->made->steps[at].number;
    return r->made->steps[at].code == CODE_NUMBER;
}

static int power(reader *r, int a, int b) {
    enum { WHOLE_MAX = 1024 };
    double c;
    if (r->status) return 0;
    if (!as_number(r, b, &c)) /* exp(b log a) */
        return one(r, CODE_EXP, two(r, CODE_MULTIPLY, b, one(r, CODE_LOG, a)));
    if (c == 0) return number_step(r, 1);
    if (c == 1) return a;
    double size = fabs(c);
    if (c != floor(c) || size > WHOLE_MAX) return emit(r, CODE_POWER, a, a, c);
    int whole = size == 1 ? a : emit(r, CODE_WHOLE_POWER, a, a, size);
    return c > 0 ? whole : two(r, CODE_DIVIDE, number_step(r, 1), whole);
}

static int smooth(reader *r, int a, int b, int width, bool is_min) {
    int apart = one(r, CODE_ABS, two(r, CODE_SUBTRACT, a, b));
    int h = two(r, CODE_SUBTRACT, number_step(r, 1), two(r, CODE_DIVIDE, apart, width));
    h = power(r, two(r, CODE_MAX, h, number_step(r, 0)), number_step(r, 2));
    int bulge = two(r, CODE_MULTIPLY, h, two(r, CODE_MULTIPLY, width, number_step(r, 0.25)));
    int sharp = two(r, is_min ? CODE_MIN : CODE_MAX, a, b);
    return two(r, is_min ? CODE_SUBTRACT : CODE_ADD, sharp, bulge);
}

typedef enum special {
    SPECIAL_NONE,
    SPECIAL_TAN,
    SPECIAL_MOD,
    SPECIAL_CLAMP,
    SPECIAL_MIX,
    SPECIAL_SMOOTH_MIN,
    SPECIAL_SMOOTH_MAX
} special;

enum { ARGUMENTS_MAX = 16 };

/* Those with more arguments than two that are one operation take it again and again. */
static const struct function {
    const char *name;
    code what;
    int least, most;
    special special;
} functions[] = {
    {"sqrt", CODE_SQRT, 1, 1, SPECIAL_NONE},
    {"abs", CODE_ABS, 1, 1, SPECIAL_NONE},
    {"sin", CODE_SIN, 1, 1, SPECIAL_NONE},
    {"cos", CODE_COS, 1, 1, SPECIAL_NONE},
    {"tan", CODE_SIN, 1, 1, SPECIAL_TAN},
    {"asin", CODE_ASIN, 1, 1, SPECIAL_NONE},
    {"acos", CODE_ACOS, 1, 1, SPECIAL_NONE},
    {"atan", CODE_ATAN, 1, 1, SPECIAL_NONE},
    {"atan2", CODE_ATAN2, 2, 2, SPECIAL_NONE},
    {"exp", CODE_EXP, 1, 1, SPECIAL_NONE},
    {"log", CODE_LOG, 1, 1, SPECIAL_NONE},
    {"floor", CODE_FLOOR, 1, 1, SPECIAL_NONE},
    {"mod", CODE_FLOOR, 2, 2, SPECIAL_MOD},
    {"min", CODE_MIN, 2, ARGUMENTS_MAX, SPECIAL_NONE},
    {"max", CODE_MAX, 2, ARGUMENTS_MAX, SPECIAL_NONE},
    {"clamp", CODE_MAX, 3, 3, SPECIAL_CLAMP},
    {"mix", CODE_ADD, 3, 3, SPECIAL_MIX},
    {"length", CODE_HYPOT, 2, ARGUMENTS_MAX, SPECIAL_NONE},
    {"smooth_min", CODE_MIN, 3, 3, SPECIAL_SMOOTH_MIN},
    {"smooth_max", CODE_MAX, 3, 3, SPECIAL_SMOOTH_MAX},
};
#define FUNCTION_COUNT (sizeof functions / sizeof functions[0])

static int call(reader *r, const struct function *f, const int *a, int count) {
    switch (f->special) {
    case SPECIAL_TAN: return two(r, CODE_DIVIDE, one(r, CODE_SIN, a[0]), one(r, CODE_COS, a[0]));
    case SPECIAL_MOD: {
        int turns = one(r, CODE_FLOOR, two(r, CODE_DIVIDE, a[0], a[1]));
        return two(r, CODE_SUBTRACT, a[0], two(r, CODE_MULTIPLY, a[1], turns));
    }
    case SPECIAL_CLAMP: return two(r, CODE_MIN, two(r, CODE_MAX, a[0], a[1]), a[2]);
    case SPECIAL_MIX:
        return two(r, CODE_ADD, a[0],
                   two(r, CODE_MULTIPLY, a[2], two(r, CODE_SUBTRACT, a[1], a[0])));
    case SPECIAL_SMOOTH_MIN: return smooth(r, a[0], a[1], a[2], true);
    case SPECIAL_SMOOTH_MAX: return smooth(r, a[0], a[1], a[2], false);
    default: break;
    }
    if (f->most == 1) return one(r, f->what, a[0]);
    int made = a[0];
    for (int i = 1; i < count; i++) made = two(r, f->what, made, a[i]);
    return made;
}

static void skip_space(reader *r) {
    while (*r->at == ' ' || *r->at == '\t' || *r->at == '\n' || *r->at == '\r') r->at++;
}

static bool take(reader *r, char c) {
    skip_space(r);
    if (*r->at != c) return false;
    r->at++;
    return true;
}

static bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static size_t word_length(const char *at) {
    size_t length = 0;
    if (!is_letter(*at)) return 0;
    while (is_letter(at[length]) || is_digit(at[length])) length++;
    return length;
}

static int read_sum(reader *r);

static int read_call(reader *r, const struct function *f, const char *start) {
    int arguments[ARGUMENTS_MAX] = {0}, count = 0;
    do {
        if (count == ARGUMENTS_MAX)
            return fail_at(r, start, NULL, "too many values for a function");
        arguments[count++] = read_sum(r);
    } while (!r->status && take(r, ','));
    if (r->status) return 0;
    if (!take(r, ')')) return fail(r, NULL, "a ')' is missing");
    if (count < f->least || count > f->most) {
        char text[96];
        snprintf(text, sizeof text, "'%s' takes %s%d value%s, not %d", f->name,
                 f->most > f->least ? "at least " : "", f->least, f->least == 1 ? "" : "s", count);
        return fail_at(r, start, NULL, text);
    }
    return call(r, f, arguments, count);
}

static int fail_unknown(reader *r, const char *start, size_t length) {
    const char *known[FUNCTION_COUNT + 4] = {"x", "y", "z", "pi"};
    for (size_t i = 0; i < FUNCTION_COUNT; i++) known[4 + i] = functions[i].name;
    char word[32], text[64], hint[64];
    snprintf(word, sizeof word, "%.*s", (int)length, start);
    snprintf(text, sizeof text, "unknown name '%s'", word);
    const char *near = closest_word(word, known, FUNCTION_COUNT + 4);
    snprintf(hint, sizeof hint, near ? "did you mean '%s'?" : "x, y, z and pi are known", near);
    return fail_at(r, start, hint, text);
}

static int read_word(reader *r, size_t length) {
    const char *start = r->at;
    r->at += length;
    bool called = take(r, '(');
    for (size_t i = 0; called && i < FUNCTION_COUNT; i++)
        if (strlen(functions[i].name) == length && memcmp(functions[i].name, start, length) == 0)
            return read_call(r, &functions[i], start);
    if (called) return fail_unknown(r, start, length);
    for (int i = r->name_count - 1; i >= 0; i--)
        if (r->names[i].length == length && memcmp(r->names[i].name, start, length) == 0)
            return r->names[i].step;
    if (length == 1 && *start >= 'x' && *start <= 'z')
        return emit(r, (code)(CODE_X + (*start - 'x')), 0, 0, 0);
    if (length == 2 && memcmp(start, "pi", 2) == 0) return number_step(r, PI);
    return fail_unknown(r, start, length);
}

/* Digits, a point, an exponent of ten. strtod would follow the program's locale. As exact as double is
 * up to 15 digits and 22 decimal places (Clinger, How to Read Floating Point Numbers Accurately,
 * 1990); beyond that a few ulps off, but the same on every machine. */
static double scale_by_ten(double x, int power) {
    for (; power > 0; power -= power > 22 ? 22 : power)
        x *= integer_power(10, power > 22 ? 22 : power);
    for (; power < 0; power += power < -22 ? 22 : -power)
        x /= integer_power(10, power < -22 ? 22 : -power);
    return x;
}

static int read_exponent(const char **at) {
    if (**at != 'e' && **at != 'E') return 0;
    const char *digit = *at + 1;
    bool negative = *digit == '-';
    int power = 0;
    if (*digit == '-' || *digit == '+') digit++;
    if (!is_digit(*digit)) return 0;
    for (; is_digit(*digit); digit++)
        if (power < 1000) power = 10 * power + (*digit - '0');
    *at = digit;
    return negative ? -power : power;
}

static int read_number(reader *r) {
    const char *start = r->at, *at = start;
    double digits = 0; /* exact below 2^53 */
    int power = 0, points = 0, count = 0;
    for (; is_digit(*at) || *at == '.'; at++) {
        if (*at == '.') {
            points++;
            continue;
        }
        count++;
        bool kept = digits < 0x1p53 / 10 - 1;
        if (kept) digits = 10 * digits + (*at - '0');
        power += (kept ? 0 : 1) - (points ? 1 : 0);
    }
    if (count == 0 || points > 1) return fail(r, NULL, "not a number");
    power += read_exponent(&at);
    double x = scale_by_ten(digits, power);
    if (!isfinite(x)) return fail(r, NULL, "this number is too large");
    r->at = at;
    if (is_letter(*at)) return fail(r, "write 2*x", "an operator is missing");
    return number_step(r, x);
}

static int read_unary(reader *r);

static int read_atom(reader *r) {
    skip_space(r);
    size_t length = word_length(r->at);
    if (length) return read_word(r, length);
    if (is_digit(*r->at) || *r->at == '.') return read_number(r);
    const char *start = r->at;
    if (!take(r, '(')) {
        char text[64];
        bool shown = *r->at > ' ' && *r->at <= '~';
        snprintf(text, sizeof text, shown ? "a value is missing before '%c'" : "a value is missing",
                 *r->at);
        return fail(r, NULL, text);
    }
    int made = read_sum(r);
    if (r->status) return 0;
    return take(r, ')') ? made : fail_at(r, start, NULL, "this '(' is not closed");
}

/* Every way to nest passes through here. */
static int read_unary(reader *r) {
    if (r->status) return 0;
    if (++r->depth > EXPRESSION_DEPTH_MAX) return fail(r, NULL, "nested too deep");
    int made;
    if (take(r, '-')) {
        made = one(r, CODE_NEGATE, read_unary(r));
    } else {
        made = read_atom(r);
        if (!r->status && take(r, '^')) made = power(r, made, read_unary(r));
    }
    r->depth--;
    return made;
}

static int read_product(reader *r) {
    int made = read_unary(r);
    while (!r->status)
        if (take(r, '*'))
            made = two(r, CODE_MULTIPLY, made, read_unary(r));
        else if (take(r, '/'))
            made = two(r, CODE_DIVIDE, made, read_unary(r));
        else
            break;
    return made;
}

static int read_sum(reader *r) {
    int made = read_product(r);
    while (!r->status)
        if (take(r, '+'))
            made = two(r, CODE_ADD, made, read_product(r));
        else if (take(r, '-'))
            made = two(r, CODE_SUBTRACT, made, read_product(r));
        else
            break;
    return made;
}

/* A word and '=': a definition. */
static size_t definition_length(reader *r) {
    skip_space(r);
    size_t length = word_length(r->at), at = length;
    while (r->at[at] == ' ' || r->at[at] == '\t') at++;
    return r->at[at] == '=' ? length : 0;
}

static int read_all(reader *r) {
    size_t length;
    while (!r->status && (length = definition_length(r)) != 0) {
        const char *name = r->at;
        if (r->name_count == EXPRESSION_NAMES_MAX) return fail(r, NULL, "too many definitions");
        r->at += length;
        take(r, '=');
        int made = read_sum(r);
        if (r->status) return 0;
        if (!take(r, ';')) return fail(r, NULL, "a ';' is missing after a definition");
        r->names[r->name_count++] = (definition){name, length, made};
    }
    int made = read_sum(r);
    if (r->status) return 0;
    take(r, ';');
    skip_space(r);
    if (*r->at == '\0') return made;
    char text[64];
    bool shown = *r->at > ' ' && *r->at <= '~';
    snprintf(text, sizeof text, shown ? "'%c' is not expected here" : "this is not expected here",
             *r->at);
    return fail(r, NULL, text);
}

/* Keeps what the result depends on, in order, with the result last. */
static void trim(expression *e, int result) {
    bool used[EXPRESSION_STEPS_MAX] = {false};
    uint16_t moved[EXPRESSION_STEPS_MAX];
    uint32_t count = 0;
    used[result] = true;
    for (int i = result; i >= 0; i--)
        if (used[i] && e->steps[i].code > CODE_Z) used[e->steps[i].a] = used[e->steps[i].b] = true;
    for (int i = 0; i <= result; i++) {
        if (!used[i]) continue;
        step kept = e->steps[i];
        if (kept.code > CODE_Z) kept.a = moved[kept.a], kept.b = moved[kept.b];
        moved[i] = (uint16_t)count;
        e->steps[count++] = kept;
    }
    e->count = count;
}

snell_status expression_create(const char *label, const char *text, expression **out) {
    size_t length = strlen(text);
    if (length > EXPRESSION_TEXT_MAX)
        return error_set(SNELL_ERR_ARGUMENT, "make it of several shapes",
                         "%s has %zu characters; it must have at most %d", label, length,
                         EXPRESSION_TEXT_MAX);
    reader r = {.label = label, .text = text, .at = text, .made = memory_zeroed(1, sizeof *r.made)};
    if (r.made == NULL) return error_no_memory();
    number_step(&r, 0); /* so that step 0 is there */
    int result = read_all(&r);
    if (r.status) {
        free(r.made);
        return r.status;
    }
    trim(r.made, result);
    *out = r.made;
    return SNELL_OK;
}

void expression_destroy(expression *e) { free(e); }
