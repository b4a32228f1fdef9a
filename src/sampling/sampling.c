#include "sampling/sampling.h"

uint64_t hash_mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

double sample_more(double u, double v, uint32_t index) {
    uint64_t stream = hash_mix((uint64_t)(u * 0x1p53) + 0x9e3779b97f4a7c15u);
    stream = hash_mix(stream + (uint64_t)(v * 0x1p53));
    return (double)(hash_mix(stream + 0x9e3779b97f4a7c15u * (index + 1u)) >> 11) * 0x1p-53;
}

uint64_t path_code_child(uint64_t parent, uint32_t slot) {
    return hash_mix(parent + 0x9e3779b97f4a7c15u * (slot + 1u));
}

uint64_t sample_pixel_stream(uint64_t seed, uint32_t pixel_x, uint32_t pixel_y) {
    uint64_t h = hash_mix(seed + 0x9e3779b97f4a7c15u);
    return hash_mix(h ^ ((uint64_t)pixel_y << 32 | pixel_x));
}

uint64_t sample_scramble(uint64_t pixel_stream, uint32_t scramble) {
    return scramble ? hash_mix(pixel_stream + 0x9e3779b97f4a7c15u * scramble) : pixel_stream;
}

uint64_t sample_stream(uint64_t pixel_stream, uint64_t path_code, sample_purpose purpose) {
    return hash_mix(hash_mix(pixel_stream + path_code) + (uint64_t)purpose);
}

static uint32_t reverse_bits(uint32_t x) {
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

/* An Owen scramble of numbers whose bits are reversed: every step lets a bit change only higher bits
 * (Laine and Karras 2011, with the constants of Burley 2020). */
static uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/* The second Sobol dimension with its bits reversed. Its direction numbers are those of the polynomial 1 + x, so its
 * matrix is Pascal's triangle modulo 2: by Lucas' theorem bit j of the result is the sum of all bits i of the index
 * with j's bits among i's, which five steps compute. */
static uint32_t sobol_second_reversed(uint32_t index) {
    index ^= index >> 1 & 0x55555555u;
    index ^= index >> 2 & 0x33333333u;
    index ^= index >> 4 & 0x0f0f0f0fu;
    index ^= index >> 8 & 0x00ff00ffu;
    return index ^ index >> 16;
}

sample2 sample_point(uint64_t stream, uint32_t index) {
    uint64_t second = hash_mix(stream + 1);
    uint32_t shuffled = reverse_bits(scramble_reversed(reverse_bits(index), (uint32_t)second));
    /* The first dimension is the index with its bits reversed, so its reversed bits are the index. */
    uint32_t x = reverse_bits(scramble_reversed(shuffled, (uint32_t)stream));
    uint32_t y =
        reverse_bits(scramble_reversed(sobol_second_reversed(shuffled), (uint32_t)(stream >> 32)));
    return (sample2){x * 0x1p-32, y * 0x1p-32};
}
