/* Inside the exporter of Lua: the text in the making, and what its parts share. After the first failure,
 * kept in `status`, everything does nothing. */
#ifndef SNELL_EXPORTERS_LUA_EXPORT_H
#define SNELL_EXPORTERS_LUA_EXPORT_H

#include "scene/description.h"

typedef struct lua_export {
    const description *d;
    const char *path;
    char *text;
    size_t size, capacity;
    part_lists lists;
    uint32_t *uses; /* of each shape, by instances and solids that are drawn */
    bool *made;     /* each shape that is used more than once: s[..] holds it */
    bool *filled;   /* each shape that takes its material from around it somewhere */
    bool has_folder;
    snell_status status;
} lua_export;

/* ---- lua_text.c ---- */
void put(lua_export *e, const char *format, ...) PRINTF_LIKE(2, 3);
void put_end(lua_export *e); /* " }", after the last comma is taken back */
/* As few digits as make this float again. */
void put_float(lua_export *e, float value);
/* Degrees that the reader makes this many radians of. */
void put_angle(lua_export *e, float radians);
void put_floats(lua_export *e, const float *values, size_t count); /* {1, 2, 3} */
/* The same of points, in braces of their own while that is readable. */
void put_rows(lua_export *e, const float *values, size_t count, size_t width);
/* Of length 1 or nearly; the reader normalises what it gets, twice. */
void put_direction(lua_export *e, const char *what, snell_vec3 v);
void put_string(lua_export *e, const char *text);
void put_transform(lua_export *e, const transform *t);
void put_keys(lua_export *e, const motion_key *keys, size_t count);
/* How the file calls an object: m.wood, m["old wood"], m[3]. prefix: "m". */
void put_name(lua_export *e, const char *prefix, category which, uint32_t index);
/* `what` is said of the object, such as "mesh 'wing'"; the error says that Lua cannot hold it. */
void fail_object(lua_export *e, category which, uint32_t index, const char *hint,
                 const char *format, ...) PRINTF_LIKE(5, 6);

/* ---- lua_fields.c ---- */
/* The fields that differ from their defaults, each " name = value,". skip: names that the caller writes, as
 * choices: "width|height", or NULL. */
void put_fields(lua_export *e, category which, uint32_t index, const char *skip);
/* How many numbers the lists of an object hold. */
size_t count_numbers(const object *o);

/* ---- lua_shapes.c ---- */
void put_shapes(lua_export *e);

/* ---- lua_beside.c: files ---- */
/* Write the object's file; the name that the program calls it by goes to `out`. */
void write_mesh(lua_export *e, uint32_t shape, char *out, size_t size);
void write_image(lua_export *e, uint32_t texture, char *out, size_t size);
/* Has it nothing that a .ply cannot hold, and is it large enough for a file? */
bool is_for_file(const object *mesh);

#endif
