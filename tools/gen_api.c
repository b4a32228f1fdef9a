/* Prints, from the types' own tables, the reference page ("reference"), one description struct per registered type for the public
 * header ("header") or the functions that add them ("source"). */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "scene/description.h"

/* Shapes and materials are named by their own name; the others say what they are. */
static void public_name(const type_info *t, char *out, size_t size) {
    bool plain = t->category == CATEGORY_SHAPE || t->category == CATEGORY_MATERIAL;
    snprintf(out, size, plain ? "%s" : "%s_%s", t->name, category_name(t->category));
}

static const char *member_type(field_kind kind) {
    switch (kind) {
    case FIELD_BOOL: return "bool ";
    case FIELD_INT:
    case FIELD_CHOICE: return "int32_t ";
    case FIELD_FLOAT: return "float ";
    case FIELD_VEC2: return "snell_vec2 ";
    case FIELD_VEC3:
    case FIELD_COLOR: return "snell_vec3 ";
    case FIELD_INPUT:
    case FIELD_SCALAR: return "snell_input ";
    case FIELD_STRING: return "const char *";
    case FIELD_TEXTURE: return "snell_texture_id ";
    case FIELD_MATERIAL: return "snell_material_id ";
    case FIELD_TRANSFORM: return "snell_transform ";
    case FIELD_VEC3S: return "const snell_vec3 *";
    case FIELD_VEC2S: return "const snell_vec2 *";
    case FIELD_FLOATS: return "const float *";
    case FIELD_UINTS: return "const uint32_t *";
    case FIELD_BYTES: return "const void *";
    case FIELD_MATERIALS: return "const snell_material_id *";
    case FIELD_SHAPES: return "const snell_shape_id *";
    case FIELD_TRANSFORMS: return "const snell_transform *";
    case FIELD_KEYS: return "const snell_motion_key *";
    }
    return "";
}

static void print_choices(const char *name, const field *f) {
    const char *at = f->choices;
    printf("enum {");
    for (int i = 0; *at; i++) {
        size_t length = strcspn(at, "|");
        printf("%s SNELL_", i ? "," : "");
        for (const char *c = name; *c; c++) putchar(toupper((unsigned char)*c));
        putchar('_');
        for (const char *c = f->name; *c; c++) putchar(toupper((unsigned char)*c));
        putchar('_');
        for (size_t k = 0; k < length; k++)
            putchar(at[k] == '-' ? '_' : toupper((unsigned char)at[k]));
        at += length + (at[length] == '|');
    }
    printf(" };\n");
}

static void print_note(const field *f) {
    printf(" /* %s", f->help);
    if (f->unit[0]) printf("; %s", strcmp(f->unit, "rad") == 0 ? "radians" : f->unit);
    if (f->flags & FIELD_REQUIRED) printf("; required");
    if (f->kind != FIELD_CHOICE && !isinf(f->min)) {
        if (isinf(f->max))
            printf("; %s %g", f->flags & FIELD_OPEN_MIN ? ">" : ">=", f->min);
        else
            printf("; %g to %g", f->min, f->max);
    }
    printf(" */\n");
}

static void print_struct(const type_info *t, const char *name) {
    for (uint32_t i = 0; i < t->field_count; i++)
        if (t->fields[i].kind == FIELD_CHOICE) print_choices(name, &t->fields[i]);
    printf("typedef struct snell_%s_desc { /* %s */\n    size_t struct_size;\n", name, t->help);
    for (uint32_t i = 0; i < t->field_count; i++) {
        const field *f = &t->fields[i];
        printf("    %s%s;", member_type(f->kind), f->name);
        print_note(f);
        if (field_element_size(f->kind)) printf("    size_t %s_count;\n", f->name);
    }
    printf("} snell_%s_desc;\n", name);
}

static void print_initial(const field *f) {
    const float *v = f->initial;
    switch (f->kind) {
    case FIELD_BOOL:
        if (v[0] != 0) printf("    desc.%s = true;\n", f->name);
        break;
    case FIELD_INT:
    case FIELD_CHOICE:
        if (v[0] != 0) printf("    desc.%s = %d;\n", f->name, (int)v[0]);
        break;
    case FIELD_FLOAT:
        if (v[0] != 0) printf("    desc.%s = (float)%.9g;\n", f->name, (double)v[0]);
        break;
    case FIELD_VEC2:
    case FIELD_VEC3:
    case FIELD_COLOR:
    case FIELD_INPUT:
    case FIELD_SCALAR:
        for (int i = 0; i < (f->kind == FIELD_VEC2 ? 2 : 3); i++) {
            double value = (double)v[f->kind == FIELD_SCALAR ? 0 : i];
            const char *part = f->kind == FIELD_INPUT || f->kind == FIELD_SCALAR ? ".value" : "";
            if (value != 0)
                printf("    desc.%s%s.%c = (float)%.9g;\n", f->name, part, "xyz"[i], value);
        }
        break;
    case FIELD_STRING: printf("    desc.%s = \"\";\n", f->name); break;
    case FIELD_TRANSFORM:
        printf("    desc.%s.m[0][0] = desc.%s.m[1][1] = desc.%s.m[2][2] = 1;\n", f->name, f->name,
               f->name);
        break;
    default: break;
    }
}

static void print_init(const type_info *t, const char *name) {
    printf("static inline snell_%s_desc snell_%s_desc_init(size_t struct_size) {\n", name, name);
    printf("    snell_%s_desc desc;\n    memset(&desc, 0, sizeof desc);\n    desc.struct_size = "
           "struct_size;\n",
           name);
    for (uint32_t i = 0; i < t->field_count; i++) print_initial(&t->fields[i]);
    printf("    return desc;\n}\n");
}

static void print_source(const type_info *t, const char *name) {
    const char *noun = category_name(t->category);
    printf("\n_Static_assert(sizeof(snell_%s_desc) == %zu, \"run tools/update_api\");\n", name,
           t->desc_size);
    for (uint32_t i = 0; i < t->field_count; i++)
        printf("_Static_assert(offsetof(snell_%s_desc, %s) == %zu, \"run tools/update_api\");\n",
               name, t->fields[i].name, t->fields[i].offset);
    printf("snell_status snell_scene_add_%s(snell_scene *s, const snell_%s_desc *desc, snell_%s_id "
           "*out) {\n",
           name, name, noun);
    printf("    uint32_t index1 = 0;\n");
    printf("    snell_status status = scene_add_typed(s, CATEGORY_");
    for (const char *c = noun; *c; c++) putchar(toupper((unsigned char)*c));
    printf(", \"%s\", desc, &index1);\n", t->name);
    printf("    if (!status && out) *out = (snell_%s_id){index1, 0};\n    return status;\n}\n",
           noun);
}

/* A cell of a Markdown table: its bars would end it. */
static void print_cell(const char *text) {
    for (; *text; text++) printf(*text == '|' ? "\\|" : "%c", *text);
}

static void print_reference(void) {
    const type_info *t;
    category last = CATEGORY_COUNT;
    printf("# Reference of the scene language\n\nEvery type with its fields, from the program's "
           "own tables (generated by "
           "`tools/update_api`).\n`snell help NAME` prints the same. What the calls mean: `snell "
           "help scene`.\n");
    for (uint32_t i = 0; (t = type_at(i)) != NULL; i++) {
        const char *noun = category_name(t->category);
        if (t->category != last) printf("\n## %c%ss\n", toupper((unsigned char)noun[0]), noun + 1);
        last = t->category;
        printf("\n### %s\n\n%s\n\n| field | what | default | range | unit | "
               "|\n|---|---|---|---|---|---|\n",
               t->name, t->help);
        for (uint32_t k = 0; k < t->field_count; k++) {
            snell_field_info f;
            if (snell_type_get_field(i, k, &f) != SNELL_OK) continue;
            printf("| `%s` | %s | %s | ", f.name, f.kind,
                   f.required ? "*required*" : f.default_value);
            print_cell(f.range);
            printf(" | %s | ", f.unit);
            print_cell(f.help);
            printf(" |\n");
        }
    }
}

int main(int argc, char **argv) {
    bool header = argc == 2 && strcmp(argv[1], "header") == 0;
    if (argc == 2 && strcmp(argv[1], "reference") == 0) {
        print_reference();
        return 0;
    }
    if (!header && (argc != 2 || strcmp(argv[1], "source") != 0)) {
        fprintf(stderr, "usage: gen_api header|source|reference\n");
        return 2;
    }
    if (header)
        printf("/* clang-format off */\n");
    else
        printf("/* Generated by tools/update_api from the types' own tables; do not edit. */\n/* "
               "clang-format off */\n#include \"api/api.h\"\n");
    const type_info *t;
    for (uint32_t i = 0; (t = type_at(i)) != NULL; i++) {
        if (t->category == CATEGORY_SETTING) continue; /* these have functions of their own */
        char name[64];
        public_name(t, name, sizeof name);
        if (!header) {
            print_source(t, name);
            continue;
        }
        putchar('\n');
        print_struct(t, name);
        print_init(t, name);
        printf("SNELL_API snell_status snell_scene_add_%s(snell_scene *scene, const snell_%s_desc "
               "*desc, snell_%s_id *out);\n",
               name, name, category_name(t->category));
    }
    if (header) printf("/* clang-format on */\n");
    return 0;
}
