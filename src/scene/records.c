#include "scene/records.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "sampling/sampling.h"

enum { VERSION = 4, STRING_MAX = 1 << 16, NAME_MAX_SIZE = 1024, PARAMS_MAX = 10000 };
enum { MESSAGE_RECORDS_MAX = 1000 };
enum record_kind { RECORD_OBJECT = 1, RECORD_INSTANCE, RECORD_PARAM, RECORD_MESSAGE };

#define TYPE_GROUP UINT32_MAX /* the number of a type that is in no registry */

static const char magic[8] = {'S', 'N', 'E', 'L', 'L', 'R', 'E', 'C'};

typedef struct block_header {
    char magic[8];
    uint32_t version, record_count;
    uint64_t size, types_hash;
    char format[16];
    uint32_t is_model, flags;
} block_header;
enum { HAS_NEXT_FRAME = 1, IS_SETTLED = 2 };

typedef struct record_header {
    uint32_t kind, zero;
    uint64_t size; /* with this header */
} record_header;
_Static_assert(sizeof(block_header) == 56 && sizeof(record_header) == 16, "no padding");

/* ---- the types' tables in one number (FNV-1a) ---- */

static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

static uint64_t hash_types(void) {
    uint64_t hash = 14695981039346656037u;
    const type_info *type;
    for (uint32_t i = 0; (type = type_at(i)) != NULL; i++) {
        uint64_t numbers[] = {type->category, type->desc_size, type->field_count};
        hash = hash_bytes(hash, numbers, sizeof numbers);
        hash = hash_bytes(hash, type->name, strlen(type->name) + 1);
        for (uint32_t j = 0; j < type->field_count; j++) {
            const field *f = &type->fields[j];
            uint64_t layout[] = {f->kind, f->offset, f->flags};
            hash = hash_bytes(hash, layout, sizeof layout);
            hash = hash_bytes(hash, f->name, strlen(f->name) + 1);
            if (f->choices) hash = hash_bytes(hash, f->choices, strlen(f->choices) + 1);
        }
    }
    return hash;
}

static bool type_number(const type_info *type, uint32_t *number) {
    const type_info *at;
    for (*number = 0; (at = type_at(*number)) != NULL; ++*number)
        if (at == type) return true;
    return false;
}

/* An array member is a pointer followed by a count, whatever it points to. */
static const void *array_get(const void *member, size_t *count) {
    const void *data;
    memcpy(&data, member, sizeof data);
    memcpy(count, (const char *)member + sizeof data, sizeof *count);
    return data;
}

static void array_put(void *member, const void *data, size_t count) {
    memcpy(member, &data, sizeof data);
    memcpy((char *)member + sizeof data, &count, sizeof count);
}

/* ---- writing: the same code measures (write NULL) and writes ---- */

typedef struct writer {
    record_write_fn *write;
    void *user;
    uint64_t at;
    bool failed;
} writer;

static void put(writer *w, const void *data, size_t size) {
    if (size == 0 || w->failed) return;
    if (w->write && !w->write(w->user, data, size)) w->failed = true;
    w->at += size;
}

static void put_u32(writer *w, uint32_t value) { put(w, &value, sizeof value); }
static void put_u64(writer *w, uint64_t value) { put(w, &value, sizeof value); }

static void put_padding(writer *w) {
    static const char zeros[8] = {0};
    put(w, zeros, (size_t)(-w->at & 7));
}

static void put_array(writer *w, const void *data, uint64_t count, size_t element_size) {
    put_padding(w);
    put_u64(w, count);
    put(w, data, (size_t)count * element_size);
    put_padding(w);
}

static void put_string(writer *w, const char *text) {
    size_t length = strlen(text);
    put_array(w, text, length + 1, 1); /* with its 0, so that the reader can borrow it */
}

static void put_field(writer *w, const field *f, const void *member) {
    size_t element_size = field_element_size(f->kind);
    if (f->kind == FIELD_STRING) {
        put_string(w, *(const char *const *)member);
    } else if (f->kind == FIELD_BOOL) {
        put_u32(w, *(const bool *)member ? 1 : 0);
    } else if (element_size) {
        size_t count;
        const void *data = array_get(member, &count);
        put_array(w, data, count, element_size);
    } else {
        put(w, member, field_size(f->kind));
    }
}

static void put_fields(writer *w, const object *o) {
    for (uint32_t i = 0; i < o->type->field_count; i++) {
        const field *f = &o->type->fields[i];
        put_field(w, f, (const char *)o->desc + f->offset);
    }
}

static void put_object(writer *w, const object *o, uint32_t type) {
    put_u32(w, type);
    put_u32(w, o->line);
    put_string(w, o->name);
    put_string(w, o->file);
    put_fields(w, o);
}

static void put_placed(writer *w, const instance *i) {
    put_u32(w, i->shape);
    put_u32(w, i->material);
    put_u32(w, i->owner);
    put_u32(w, i->fills ? 1 : 0);
    put(w, &i->to_world, sizeof i->to_world);
}

static void put_instance(writer *w, const instance *i) {
    put_placed(w, i);
    put_u32(w, i->line);
    put_string(w, i->name);
    put_array(w, i->keys, i->key_count, sizeof *i->keys);
}

static void put_param(writer *w, const scene_param *p) {
    put_string(w, p->name);
    put_string(w, p->kind);
    put_string(w, p->value);
    put_string(w, p->default_value);
    put_string(w, p->help);
}

static void put_message(writer *w, const import_message *m) {
    put_u32(w, m->severity);
    put_u32(w, m->line);
    put_string(w, m->text);
    put_string(w, m->hint);
    put_string(w, m->file);
}

static void put_payload(writer *w, enum record_kind kind, const void *item, uint32_t type) {
    switch (kind) {
    case RECORD_OBJECT: put_object(w, item, type); break;
    case RECORD_INSTANCE: put_instance(w, item); break;
    case RECORD_PARAM: put_param(w, item); break;
    case RECORD_MESSAGE: put_message(w, item); break;
    }
    put_padding(w);
}

static void put_record(writer *w, enum record_kind kind, const void *item, uint32_t type,
                       uint32_t *count) {
    writer measure = {.at = w->at + sizeof(record_header)};
    put_payload(&measure, kind, item, type);
    record_header header = {.kind = kind, .size = measure.at - w->at};
    put(w, &header, sizeof header);
    put_payload(w, kind, item, type);
    ++*count;
}

static bool put_records(writer *w, const description *d, uint32_t *count) {
    for (int c = 0; c < CATEGORY_COUNT; c++)
        for (size_t i = 0; i < d->objects[c].count; i++) {
            uint32_t type;
            if (object_is_group(&d->objects[c].items[i]))
                type = TYPE_GROUP;
            else if (!type_number(d->objects[c].items[i].type, &type))
                return false;
            put_record(w, RECORD_OBJECT, &d->objects[c].items[i], type, count);
        }
    for (size_t i = 0; i < d->instance_count; i++)
        if (!d->instances[i].removed) put_record(w, RECORD_INSTANCE, &d->instances[i], 0, count);
    for (size_t i = 0; i < d->param_count; i++)
        put_record(w, RECORD_PARAM, &d->params[i], 0, count);
    for (size_t i = 0; i < d->message_count; i++)
        put_record(w, RECORD_MESSAGE, &d->messages[i], 0, count);
    return true;
}

snell_status records_write(const description *d, record_write_fn *write, void *user) {
    block_header header = {.version = VERSION, .is_model = d->is_model, .types_hash = hash_types()};
    header.flags = (d->has_next_frame ? HAS_NEXT_FRAME : 0u) | (d->is_settled ? IS_SETTLED : 0u);
    memcpy(header.magic, magic, sizeof magic);
    memcpy(header.format, d->format, sizeof header.format);
    writer measure = {.at = sizeof header};
    if (!put_records(&measure, d, &header.record_count))
        return error_set(SNELL_ERR_INTERNAL, NULL, "an object of a type that is not registered");
    header.size = measure.at;
    writer w = {.write = write, .user = user};
    uint32_t written = 0;
    put(&w, &header, sizeof header);
    put_records(&w, d, &written);
    if (w.failed)
        return error_set(SNELL_ERR_IO, NULL, "the scene's %llu bytes could not be written",
                         (unsigned long long)header.size);
    return SNELL_OK;
}

/* ---- hashing: what decides a picture, and nothing else ---- */

static bool hash_words(void *user, const void *data, size_t size) {
    uint64_t *hash = user;
    const char *bytes = data, *end = bytes + size;
    uint64_t word, h = *hash;
    for (; end - bytes >= (ptrdiff_t)sizeof word; bytes += sizeof word) {
        memcpy(&word, bytes, sizeof word);
        h = hash_mix(h ^ word);
    }
    if (bytes < end) {
        word = 0;
        memcpy(&word, bytes, (size_t)(end - bytes));
        h = hash_mix(h ^ word);
    }
    *hash = h;
    return true;
}

snell_status records_hash(const description *d, uint64_t *out) {
    uint64_t hash = 0;
    writer w = {.write = hash_words, .user = &hash};
    const type_info *known = NULL; /* mostly the same as before: looking it up is dear */
    uint32_t type;
    for (int c = 0; c < CATEGORY_COUNT; c++)
        for (size_t i = 0; i < d->objects[c].count; i++) {
            const object *o = &d->objects[c].items[i];
            if (o->type != known && !object_is_group(o) && !type_number(o->type, &type))
                return error_set(SNELL_ERR_UNSUPPORTED, NULL,
                                 "a shape by functions of the caller has no hash");
            known = o->type;
            put_string(&w, o->type->name);
            put_fields(&w, o);
        }
    for (size_t i = 0; i < d->instance_count; i++) {
        const instance *at = &d->instances[i];
        if (at->removed) continue;
        put_placed(&w, at);
        put_array(&w, at->keys, at->key_count, sizeof *at->keys);
    }
    *out = hash;
    return SNELL_OK;
}

/* ---- reading ---- */

typedef struct reader {
    const unsigned char *data;
    size_t at, end; /* of the record being read */
    bool failed;
    description *d;
    description_mark base; /* what was there before */
    uint32_t instance_count, param_count, message_count;
    bool settled;
} reader;

static snell_status wrong(const char *what) {
    return error_set(SNELL_ERR_SYNTAX, NULL, "not a valid scene block: %s", what);
}

static void get(reader *r, void *out, size_t size) {
    if (r->failed || size > r->end - r->at) {
        r->failed = true;
        memset(out, 0, size);
        return;
    }
    memcpy(out, r->data + r->at, size);
    r->at += size;
}

static uint32_t get_u32(reader *r) {
    uint32_t value;
    get(r, &value, sizeof value);
    return value;
}

static void skip_padding(reader *r) {
    size_t size = -r->at & 7;
    if (size > r->end - r->at)
        r->failed = true;
    else
        r->at += size;
}

/* A pointer into the block, aligned to 8 bytes. */
static const void *get_array(reader *r, size_t element_size, size_t *count) {
    uint64_t wanted = 0;
    skip_padding(r);
    get(r, &wanted, sizeof wanted);
    *count = 0;
    if (r->failed || wanted > (r->end - r->at) / element_size) {
        r->failed = true;
        return NULL;
    }
    const void *start = r->data + r->at;
    *count = (size_t)wanted;
    r->at += *count * element_size;
    skip_padding(r);
    return *count ? start : NULL;
}

/* Never NULL: "" when it failed. */
static const char *get_string(reader *r, size_t size_max) {
    size_t size;
    const char *text = get_array(r, 1, &size);
    if (text == NULL || size > size_max || memchr(text, 0, size) != text + size - 1) {
        r->failed = true;
        return "";
    }
    return text;
}

/* Ids in a block count from its own first object. */
static void shift_id(reader *r, category which, uint32_t *index1) {
    size_t base = r->base.objects[which];
    if (*index1 == 0) return;
    if (*index1 > UINT32_MAX - base)
        r->failed = true;
    else
        *index1 += (uint32_t)base;
}

/* Materials and shapes are named alike. */
_Static_assert(sizeof(snell_shape_id) == sizeof(snell_material_id) &&
                   offsetof(snell_shape_id, index1) == offsetof(snell_material_id, index1),
               "ids have one layout");

/* Arrays of ids that had to be shifted, freed after their object is made: one of materials, one of
 * shapes. */
typedef struct shifted_ids {
    snell_material_id *ids[2];
} shifted_ids;

static void get_ids(reader *r, category which, void *member, snell_material_id **shifted) {
    size_t count;
    const void *data = get_array(r, sizeof **shifted, &count);
    if (count && r->base.objects[which]) {
        if (*shifted) { /* no type has two such arrays */
            r->failed = true;
            return;
        }
        *shifted = memory_resize(NULL, count, sizeof **shifted);
        if (*shifted == NULL) {
            r->failed = true;
            return;
        }
        memcpy(*shifted, data, count * sizeof **shifted);
        for (size_t i = 0; i < count; i++) shift_id(r, which, &(*shifted)[i].index1);
        data = *shifted;
    }
    array_put(member, data, count);
}

static void get_field(reader *r, const field *f, void *member, shifted_ids *shifted) {
    size_t element_size = field_element_size(f->kind), count;
    switch (f->kind) {
    case FIELD_STRING: *(const char **)member = get_string(r, STRING_MAX); break;
    case FIELD_BOOL: {
        uint32_t value = get_u32(r);
        if (value > 1) r->failed = true;
        *(bool *)member = value == 1;
        break;
    }
    case FIELD_INPUT:
    case FIELD_SCALAR: {
        snell_input *input = member;
        get(r, input, sizeof *input);
        shift_id(r, CATEGORY_TEXTURE, &input->texture.index1);
        break;
    }
    case FIELD_TEXTURE:
        get(r, member, sizeof(snell_texture_id));
        shift_id(r, CATEGORY_TEXTURE, &((snell_texture_id *)member)->index1);
        break;
    case FIELD_MATERIAL:
        get(r, member, sizeof(snell_material_id));
        shift_id(r, CATEGORY_MATERIAL, &((snell_material_id *)member)->index1);
        break;
    case FIELD_MATERIALS: get_ids(r, CATEGORY_MATERIAL, member, &shifted->ids[0]); break;
    case FIELD_SHAPES: get_ids(r, CATEGORY_SHAPE, member, &shifted->ids[1]); break;
    default:
        if (element_size) {
            const void *data = get_array(r, element_size, &count);
            array_put(member, data, count);
        } else {
            get(r, member, field_size(f->kind));
        }
    }
}

/* The name itself, or with ".2" and so on where the description had it before this block. */
static const char *free_name(const reader *r, category which, const char *name, char *out,
                             size_t size) {
    const object_list *list = &r->d->objects[which];
    const char *wanted = name;
    for (int i = 2; i < 1000; i++) {
        const object *there = description_find(r->d, which, wanted);
        if (there == NULL || (size_t)(there - list->items) >= r->base.objects[which]) return wanted;
        snprintf(out, size, "%s.%d", name, i);
        wanted = out;
    }
    return wanted;
}

/* Adding normalises directions, and what was rounded to floats would not stay as it is: a settled block
 * has them back, if they are of length 1 but for that rounding. */
static snell_status keep_directions(const type_info *type, const void *from, void *to) {
    for (uint32_t i = 0; i < type->field_count; i++) {
        const field *f = &type->fields[i];
        if (f->kind != FIELD_VEC3 || !(f->flags & FIELD_UNIT_LENGTH)) continue;
        snell_vec3 v;
        memcpy(&v, (const char *)from + f->offset, sizeof v);
        double x = (double)v.x, y = (double)v.y, z = (double)v.z;
        if (!(fabs(x * x + y * y + z * z - 1) < 1e-6)) return wrong("a direction's length");
        memcpy((char *)to + f->offset, &v, sizeof v);
    }
    return SNELL_OK;
}

static snell_status read_object(reader *r) {
    uint32_t number = get_u32(r), line = get_u32(r), index = 0;
    const char *name = get_string(r, NAME_MAX_SIZE), *file = get_string(r, STRING_MAX);
    char other_name[NAME_MAX_SIZE + 16];
    if (!r->failed && number == TYPE_GROUP) {
        const char *kept = free_name(r, CATEGORY_SHAPE, name, other_name, sizeof other_name);
        skip_padding(r);
        if (r->failed || r->at != r->end) return wrong("a group's record");
        return description_add_empty_group(r->d, (object_source){kept, file, line}, NULL);
    }
    const type_info *type = r->failed ? NULL : type_at(number);
    if (type == NULL) return wrong("an unknown type");
    void *desc = memory_zeroed(1, type->desc_size);
    if (desc == NULL) return error_no_memory();
    desc_init(type, desc);
    shifted_ids shifted = {{NULL, NULL}};
    for (uint32_t i = 0; i < type->field_count; i++)
        get_field(r, &type->fields[i], (char *)desc + type->fields[i].offset, &shifted);
    skip_padding(r);
    snell_status status = SNELL_OK;
    bool kept = type->category == CATEGORY_SETTING && description_setting(r->d, type->name) &&
                r->base.objects[CATEGORY_SETTING] > 0;
    if (r->failed || r->at != r->end)
        status = wrong("a record that does not fit its type");
    else if (!kept)
        status = description_add_desc(
            r->d, type, desc,
            (object_source){free_name(r, type->category, name, other_name, sizeof other_name), file,
                            line},
            &index);
    if (!status && !kept && r->settled)
        status = keep_directions(type, desc, r->d->objects[type->category].items[index].desc);
    free(shifted.ids[0]);
    free(shifted.ids[1]);
    free(desc);
    return status;
}

static snell_status read_instance(reader *r) {
    uint32_t shape = get_u32(r), material = get_u32(r), owner = get_u32(r), fills = get_u32(r);
    transform to_world;
    get(r, &to_world, sizeof to_world);
    uint32_t line = get_u32(r), index;
    const char *name = get_string(r, NAME_MAX_SIZE);
    size_t key_count;
    const motion_key *keys = get_array(r, sizeof *keys, &key_count);
    size_t shapes = r->d->objects[CATEGORY_SHAPE].count - r->base.objects[CATEGORY_SHAPE],
           materials = r->d->objects[CATEGORY_MATERIAL].count - r->base.objects[CATEGORY_MATERIAL];
    if (r->failed || r->at != r->end) return wrong("an instance of the wrong size");
    if (shape >= shapes || (material != NO_MATERIAL && material >= materials))
        return wrong("an instance of something that does not exist");
    if (fills > 1 || (owner != NO_GROUP && owner >= shapes)) return wrong("an instance's group");
    shape += (uint32_t)r->base.objects[CATEGORY_SHAPE];
    if (material != NO_MATERIAL) material += (uint32_t)r->base.objects[CATEGORY_MATERIAL];
    snell_status status = description_add_instance(r->d, shape, material, &to_world,
                                                   (object_source){name, NULL, line}, &index);
    if (!status) r->d->instances[index].fills = fills == 1;
    if (!status && owner != NO_GROUP)
        status =
            description_set_owner(r->d, index, owner + (uint32_t)r->base.objects[CATEGORY_SHAPE]);
    if (!status && key_count) status = description_set_motion(r->d, index, keys, key_count);
    return status;
}

static snell_status read_param(reader *r) {
    const char *texts[5];
    for (int i = 0; i < 5; i++) texts[i] = get_string(r, STRING_MAX);
    if (r->failed || r->at != r->end || ++r->param_count > PARAMS_MAX)
        return wrong("a parameter of the wrong size, or too many");
    return description_add_param(r->d, texts[0], texts[1], texts[2], texts[3], texts[4]);
}

static snell_status read_message(reader *r) {
    uint32_t severity = get_u32(r), line = get_u32(r);
    const char *text = get_string(r, STRING_MAX), *hint = get_string(r, STRING_MAX),
               *file = get_string(r, STRING_MAX);
    if (r->failed || r->at != r->end || severity < SNELL_DEBUG || severity > SNELL_ERROR ||
        ++r->message_count > MESSAGE_RECORDS_MAX)
        return wrong("a message of the wrong size, or too many");
    return description_add_message(r->d, (snell_severity)severity, file, line, hint, "%s", text);
}

static snell_status read_record(reader *r, const record_header *header) {
    switch (header->kind) {
    case RECORD_OBJECT: return read_object(r);
    case RECORD_INSTANCE: return read_instance(r);
    case RECORD_PARAM: return read_param(r);
    case RECORD_MESSAGE: return read_message(r);
    default: return wrong("an unknown kind of record");
    }
}

static snell_status read_records(reader *r, size_t size, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        record_header header;
        if (size - r->at < sizeof header) return wrong("it ends early");
        memcpy(&header, r->data + r->at, sizeof header);
        if (header.size < sizeof header || header.size > size - r->at || header.size % 8 != 0 ||
            header.zero != 0)
            return wrong("a record's size");
        r->end = r->at + (size_t)header.size;
        r->at += sizeof header;
        snell_status status = read_record(r, &header);
        if (status) return status;
        r->at = r->end;
    }
    return r->at == size ? SNELL_OK : wrong("it goes on after its end");
}

static snell_status check_header(const block_header *header, size_t size) {
    if (memcmp(header->magic, magic, sizeof magic) != 0) return wrong("it does not begin as one");
    if (header->version != VERSION || header->types_hash != hash_types())
        return error_set(SNELL_ERR_SYNTAX, "install library and programs of one build",
                         "a scene block of another build of snell");
    if (header->size != size) return wrong("its size");
    if (header->is_model > 1 || header->flags > (HAS_NEXT_FRAME | IS_SETTLED))
        return wrong("its header");
    if (memchr(header->format, 0, sizeof header->format) == NULL) return wrong("its format's name");
    return SNELL_OK;
}

bool records_fit(const void *data, size_t size) {
    block_header header;
    if (size < sizeof header) return false;
    memcpy(&header, data, sizeof header);
    return memcmp(header.magic, magic, sizeof magic) == 0 && header.version == VERSION &&
           header.types_hash == hash_types();
}

snell_status records_read(const void *data, size_t size, description *d) {
    block_header header;
    if (((uintptr_t)data & 7) != 0)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "a scene block must be aligned to 8 bytes");
    if (size < sizeof header || size % 8 != 0) return wrong("its size");
    memcpy(&header, data, sizeof header);
    snell_status status = check_header(&header, size);
    if (status) return status;
    reader r = {.data = data,
                .at = sizeof header,
                .d = d,
                .base = description_get_mark(d),
                .settled = (header.flags & IS_SETTLED) != 0};
    status = read_records(&r, size, header.record_count);
    if (status == SNELL_OK) {
        memcpy(d->format, header.format, sizeof d->format);
        d->is_model = header.is_model == 1;
        d->has_next_frame = (header.flags & HAS_NEXT_FRAME) != 0;
        d->is_settled = r.settled;
        return SNELL_OK;
    }
    description_rewind(d, &r.base);
    if (status != SNELL_ERR_ARGUMENT) return status;
    return error_set(SNELL_ERR_SYNTAX, error_last()->hint, "not a valid scene block: %s",
                     error_last()->text);
}
