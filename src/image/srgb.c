#include "image/srgb.h"

#include <pthread.h>
#include <string.h>

#include "maths/functions.h"

double srgb_decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : fn_pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_encode(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * fn_pow(linear, 1 / 2.4) - 0.055;
}

static float decoded[256], plain[256];
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void fill(void) {
    for (int i = 0; i < 256; i++) {
        plain[i] = (float)(i / 255.0);
        decoded[i] = (float)srgb_decode(i / 255.0);
    }
}

const float *srgb_table(void) {
    pthread_once(&once, fill);
    return decoded;
}

const float *unorm_table(void) {
    pthread_once(&once, fill);
    return plain;
}

float srgb_to_linear(double shown) {
    return shown > 0 ? (float)srgb_decode(shown < 1 ? shown : 1) : 0;
}

static int hex_digit(char c) {
    static const char digits[] = "0123456789abcdef";
    const char *at = c >= 'A' && c <= 'F' ? strchr(digits, c - 'A' + 'a') : strchr(digits, c);
    return at && c ? (int)(at - digits) : -1;
}

bool srgb_read_hex(const char *text, snell_vec3 *out) {
    size_t size = strlen(text);
    if (text[0] != '#' || (size != 4 && size != 7)) return false;
    float *channels = &out->x;
    for (int i = 0; i < 3; i++) {
        int high = hex_digit(text[size == 4 ? 1 + i : 1 + 2 * i]);
        int low = hex_digit(text[size == 4 ? 1 + i : 2 + 2 * i]);
        if (high < 0 || low < 0) return false;
        channels[i] = srgb_table()[16 * high + low];
    }
    return true;
}
