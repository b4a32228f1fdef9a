/* OpenEXR, by OpenEXRCore: R, G, B, A or Y of the first part, in rows, of any compression and sample
 * type. */
#include <stdlib.h>
#include <string.h>

#include "importers/image_float.h"

#if SNELL_HAS_OPENEXR
#include <openexr.h>

typedef struct memory_file {
    const uint8_t *data;
    size_t size;
} memory_file;

static int64_t read_at(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t report) {
    (void)context, (void)report;
    const memory_file *file = user;
    if (offset >= file->size) return 0;
    uint64_t left = file->size - offset, count = size < left ? size : left;
    memcpy(buffer, file->data + offset, (size_t)count);
    return (int64_t)count;
}

static int64_t file_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const memory_file *)user)->size;
}

static void on_error(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context, (void)code, (void)text; /* the result says enough; the default would print */
}

/* Where a channel's floats go; grey goes to red first. */
static int place_of(const char *name) {
    static const char *const names[] = {"R", "G", "B", "A"};
    for (int i = 0; i < 4; i++)
        if (strcmp(name, names[i]) == 0) return i;
    return strcmp(name, "Y") == 0 ? 0 : -1;
}

/* false: a channel that is not wanted, or coarser than the picture. */
static bool aim_channels(exr_decode_pipeline_t *decode, float *rows, uint32_t width, bool *is_grey,
                         bool *has_alpha) {
    bool any = false;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        int place = place_of(channel->channel_name);
        channel->decode_to_ptr = NULL;
        if (place < 0) continue;
        if (channel->x_samples != 1 || channel->y_samples != 1) return false;
        if (channel->channel_name[0] == 'Y') *is_grey = true;
        if (place == 3) *has_alpha = true;
        any = true;
        channel->decode_to_ptr = (uint8_t *)(rows + place);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4 * sizeof(float);
        channel->user_line_stride = (int32_t)(width * 4 * sizeof(float));
    }
    return any;
}

typedef struct exr_job {
    exr_context_t file;
    exr_decode_pipeline_t decode;
    bool started, is_grey, has_alpha;
} exr_job;

static bool read_rows(exr_job *job, const exr_attr_box2i_t *window, decoded_image *image) {
    int32_t step;
    if (exr_get_scanlines_per_chunk(job->file, 0, &step) || step < 1) return false;
    for (int64_t y = window->min.y; y <= window->max.y; y += step) {
        exr_chunk_info_t chunk;
        if (exr_read_scanline_chunk_info(job->file, 0, (int)y, &chunk)) return false;
        bool first = !job->started;
        if (first ? exr_decoding_initialize(job->file, 0, &chunk, &job->decode)
                  : exr_decoding_update(job->file, 0, &chunk, &job->decode))
            return false;
        job->started = true;
        float *rows = (float *)(void *)image->pixels +
                      (size_t)(chunk.start_y - window->min.y) * image->width * 4;
        if (chunk.start_y < window->min.y || chunk.height > window->max.y - chunk.start_y + 1 ||
            (uint32_t)chunk.width != image->width ||
            !aim_channels(&job->decode, rows, image->width, &job->is_grey, &job->has_alpha))
            return false;
        if (first && exr_decoding_choose_default_routines(job->file, 0, &job->decode)) return false;
        if (exr_decoding_run(job->file, 0, &job->decode)) return false;
    }
    return true;
}

static void complete(const exr_job *job, decoded_image *image) {
    float *p = (float *)(void *)image->pixels;
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++, p += 4) {
        if (job->is_grey) p[1] = p[2] = p[0];
        if (!job->has_alpha) p[3] = 1;
    }
}

snell_status image_decode_exr(const void *data, size_t size, size_t size_max, decoded_image *out) {
    memory_file memory = {data, size};
    exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
    how.user_data = &memory;
    how.read_fn = read_at;
    how.size_fn = file_size;
    how.error_handler_fn = on_error;
    exr_job job = {.decode = EXR_DECODE_PIPELINE_INITIALIZER};
    exr_attr_box2i_t window;
    exr_storage_t storage;
    snell_status status = SNELL_OK;
    if (exr_start_read(&job.file, "image", &how))
        return error_set(SNELL_ERR_SYNTAX, NULL, "a broken OpenEXR image");
    if (exr_get_data_window(job.file, 0, &window) || exr_get_storage(job.file, 0, &storage))
        status = error_set(SNELL_ERR_SYNTAX, NULL, "a broken OpenEXR image");
    else if (storage != EXR_STORAGE_SCANLINE)
        status = error_set(SNELL_ERR_UNSUPPORTED, "save it in rows (scan lines)",
                           "an OpenEXR image in tiles or of deep pixels cannot be read");
    if (!status) {
        int64_t width = (int64_t)window.max.x - window.min.x + 1,
                height = (int64_t)window.max.y - window.min.y + 1;
        out->width = width < 0 || width > UINT32_MAX ? 0 : (uint32_t)width;
        out->height = height < 0 || height > UINT32_MAX ? 0 : (uint32_t)height;
        status = image_make_float_room(out, size_max);
    }
    if (!status && !read_rows(&job, &window, out))
        status = error_set(SNELL_ERR_SYNTAX, NULL,
                           "an OpenEXR image that is broken or has no channels R, G, B or Y");
    if (!status) complete(&job, out);
    if (job.started) exr_decoding_destroy(job.file, &job.decode);
    exr_finish(&job.file);
    return status;
}

#else

snell_status image_decode_exr(const void *data, size_t size, size_t size_max, decoded_image *out) {
    (void)data, (void)size, (void)size_max, (void)out;
    return error_set(SNELL_ERR_UNSUPPORTED, "build with -DSNELL_OPENEXR=ON",
                     "this build cannot read OpenEXR images");
}

#endif
