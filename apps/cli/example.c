/* snell example: the scenes of scenes/, built into the program by cmake/embed.cmake. */
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "examples.h"
#include "report.h"
#include "text.h"

enum { EXAMPLES_MAX = 64 };

const char *example_name(size_t index) {
    return index < example_count ? example_table[index].name : NULL;
}

/* The first comment line, which says in a few words what the scene shows. */
static void first_line(const example_scene *scene, char *out, size_t size) {
    const char *text = (const char *)scene->text;
    size_t start = strspn(text, "- \t"), length = strcspn(text + start, "\n");
    snprintf(out, size, "%.*s", (int)(length < size ? length : size - 1), text + start);
}

static int list_examples(void) {
    char line[160];
    for (size_t i = 0; i < example_count; i++) {
        first_line(&example_table[i], line, sizeof line);
        printf("%-16s  %s\n", example_table[i].name, line);
    }
    return EXIT_DONE;
}

static int list_json(void) {
    json_t *root = json_object(), *list = json_array();
    char line[160];
    for (size_t i = 0; i < example_count; i++) {
        json_t *item = json_object();
        first_line(&example_table[i], line, sizeof line);
        json_object_set_new(item, "name", report_text(example_table[i].name));
        json_object_set_new(item, "about", report_text(line));
        json_array_append_new(list, item);
    }
    json_object_set_new(root, "schema", json_integer(1));
    json_object_set_new(root, "examples", list);
    return report_emit(root, EXIT_DONE);
}

static int print_example(const example_scene *scene) {
    if (report_json()) {
        json_t *root = json_object();
        json_object_set_new(root, "schema", json_integer(1));
        json_object_set_new(root, "name", report_text(scene->name));
        json_object_set_new(root, "text", report_text((const char *)scene->text));
        return report_emit(root, EXIT_DONE);
    }
    fwrite(scene->text, 1, scene->size, stdout);
    return EXIT_DONE;
}

int example_command(const options *o) {
    const char *names[EXAMPLES_MAX];
    size_t count = 0;
    if (o->operands.count == 0) return report_json() ? list_json() : list_examples();
    if (o->operands.count > 1) return report_usage(NULL, "example takes one NAME");
    for (size_t i = 0; i < example_count; i++) {
        if (strcmp(example_table[i].name, o->operands.items[0]) == 0) {
            return print_example(&example_table[i]);
        }
        if (count < EXAMPLES_MAX) names[count++] = example_table[i].name;
    }
    char hint[120] = "'snell example' lists them";
    const char *near = text_closest(o->operands.items[0], names, count);
    if (near != NULL) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return report_usage(hint, "there is no example '%s'", o->operands.items[0]);
}
