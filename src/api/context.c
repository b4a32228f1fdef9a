#include "api/api.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

const snell_message *snell_last_error(void) { return error_last(); }

/* The library's own log: one call at a time reaches the user's. */
static void write_log(void *user, const snell_message *message) {
    snell_context *c = user;
    pthread_mutex_lock(&c->log_lock);
    c->user_log.write(c->user_log.user, message);
    pthread_mutex_unlock(&c->log_lock);
}

snell_status snell_context_create(const snell_context_desc *desc, snell_context **out) {
    snell_context_desc defaults = SNELL_INIT(context_desc);
    if (desc == NULL) desc = &defaults;
    if (out == NULL)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "snell_context_create: out is NULL");
    if (desc->struct_size != sizeof *desc)
        return error_set(SNELL_ERR_VERSION, "compile against the library's own header",
                         "snell_context_create: the description has another version's size");
    if (desc->thread_count > 4096)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "%u threads are too many", desc->thread_count);
    if (desc->isa_max < SNELL_ISA_AUTO || desc->isa_max > SNELL_ISA_AVX512)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "isa_max is no instruction set");
    if (desc->build < SNELL_BUILD_BALANCED || desc->build > SNELL_BUILD_BEST)
        return error_set(SNELL_ERR_ARGUMENT, NULL, "build is no quality of builds");
    snell_context *c = memory_zeroed(1, sizeof *c);
    if (c == NULL) return error_no_memory();
    snell_status status = thread_pool_create(desc->thread_count, &c->pool);
    if (status) {
        free(c);
        return status;
    }
    pthread_mutex_init(&c->log_lock, NULL);
    c->memory_max = desc->memory_max;
    c->build = desc->build;
    c->isa = accel_best_isa(desc->isa_max);
    c->user_log = (log_sink){desc->log, desc->user};
    if (desc->log) c->log = (log_sink){write_log, c};
    *out = c;
    return SNELL_OK;
}

void snell_context_destroy(snell_context *c) {
    if (c == NULL) return;
    thread_pool_destroy(c->pool);
    pthread_mutex_destroy(&c->log_lock);
    free(c);
}

uint32_t snell_context_thread_count(const snell_context *c) { return thread_pool_size(c->pool); }
snell_isa snell_context_isa(const snell_context *c) { return c->isa; }

const char *snell_isa_name(snell_isa isa) {
    static const char *const names[] = {"auto", "scalar", "avx2", "avx512"};
    return isa >= SNELL_ISA_AUTO && isa <= SNELL_ISA_AVX512 ? names[isa] : "unknown";
}

const char *snell_version(void) { return SNELL_VERSION_STRING; }

/* Each name in turn, after a space: the first one is stepped over. */
const char *snell_features(const char **missing) {
    static const char without[] = ""
#if !SNELL_HAS_ASSIMP
                                  " assimp"
#endif
#if !SNELL_HAS_OPENEXR
                                  " openexr"
#endif
#if !SNELL_HAS_JPEG
                                  " jpeg"
#endif
#if !SNELL_HAS_WEBP
                                  " webp"
#endif
#if !SNELL_HAS_DRACO
                                  " draco"
#endif
#if !SNELL_HAS_SIMD
                                  " avx2 avx512"
#endif
        ;
    if (missing) *missing = without[0] ? without + 1 : without;
    return "lua gltf png"
#if SNELL_HAS_ASSIMP
           " assimp"
#endif
#if SNELL_HAS_OPENEXR
           " openexr"
#endif
#if SNELL_HAS_JPEG
           " jpeg"
#endif
#if SNELL_HAS_WEBP
           " webp"
#endif
#if SNELL_HAS_DRACO
           " draco"
#endif
#if SNELL_HAS_SIMD
           " avx2 avx512"
#endif
        ;
}

void snell_free(void *data) { free(data); }
