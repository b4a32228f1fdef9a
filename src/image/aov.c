#include "image/aov.h"

#include <stdio.h>
#include <string.h>

const aov_info aov_table[AOV_COUNT] = {
#define AOV(id, layer, channels, count, mean, shown, help)                                         \
    {#id, layer, channels, count, AOV_##mean, AOV_##shown##_SHOWN, help},
#include "image/aovs.def"
#undef AOV
};
_Static_assert(AOV_COUNT <= 32, "aov_set has a bit for each");

static snell_status unknown(const char *name, size_t length) {
    char word[64], hint[96] = "'snell help aovs' lists them";
    const char *names[AOV_COUNT];
    snprintf(word, sizeof word, "%.*s", (int)length, name);
    for (int i = 0; i < AOV_COUNT; i++) names[i] = aov_table[i].name;
    const char *near = closest_word(word, names, AOV_COUNT);
    if (near) snprintf(hint, sizeof hint, "did you mean '%s'?", near);
    return error_set(SNELL_ERR_ARGUMENT, hint, "there is no AOV '%s'", word);
}

snell_status aov_parse(const char *list, aov_set *out) {
    *out = 0;
    for (const char *at = list; at && *at;) {
        at += strspn(at, " ");
        size_t span = strcspn(at, ","), length = span;
        while (length > 0 && at[length - 1] == ' ') length--;
        int i = 0;
        if (length == 3 && memcmp(at, "all", length) == 0) {
            *out |= ((aov_set)1 << AOV_COUNT) - 1;
            at += span + (at[span] == ',');
            continue;
        }
        while (i < AOV_COUNT &&
               (strlen(aov_table[i].name) != length || memcmp(aov_table[i].name, at, length) != 0))
            i++;
        if (i == AOV_COUNT) return unknown(at, length);
        *out |= (aov_set)1 << i;
        at += span + (at[span] == ',');
    }
    return SNELL_OK;
}

void aov_channel_name(const film_layer *layer, uint32_t channel, char out[AOV_NAME_MAX]) {
    const char *at = layer->kind->channels;
    for (uint32_t i = 0; i < channel; i++) at = strchr(at, '|') + 1;
    bool by_light = layer->kind == &aov_table[AOV_light];
    snprintf(out, AOV_NAME_MAX, "%s%.*s", by_light ? layer->name : layer->kind->layer,
             (int)strcspn(at, "|"), at);
}

/* ---- cryptomatte ---- */

static uint32_t rotate(uint32_t x, int bits) { return x << bits | x >> (32 - bits); }

static uint32_t scramble(uint32_t block) { return rotate(block * 0xcc9e2d51u, 15) * 0x1b873593u; }

/* Appleby's MurmurHash3_x86_32: blocks of four bytes, little endian, then what is left. */
uint32_t crypto_hash(const char *name) {
    const uint8_t *at = (const uint8_t *)name;
    size_t length = strlen(name), left = length;
    uint32_t hash = 0;
    for (; left >= 4; at += 4, left -= 4) {
        uint32_t block =
            at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
        hash = rotate(hash ^ scramble(block), 13) * 5 + 0xe6546b64u;
    }
    uint32_t rest = 0;
    while (left > 0) rest = rest << 8 | at[--left];
    hash ^= scramble(rest);
    hash ^= (uint32_t)length;
    hash = (hash ^ hash >> 16) * 0x85ebca6bu;
    hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
    return hash ^ hash >> 16;
}

uint32_t crypto_id(const char *name) {
    uint32_t hash = crypto_hash(name), exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

float crypto_float(uint32_t id) {
    float value;
    memcpy(&value, &id, sizeof value);
    return value;
}
