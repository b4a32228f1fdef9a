/* The heads of PFM and PPM files: numbers between white space and # comments. */
#ifndef SNELL_IMAGE_PNM_H
#define SNELL_IMAGE_PNM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Skips white space and comments from *at; false at the end of the data. A comment's text (without
 * # and line end) goes to `comment`, if not NULL. */
bool pnm_skip_space(const uint8_t *data, size_t size, size_t *at,
                    bool (*comment)(void *user, const uint8_t *text, size_t size), void *user);
/* A positive decimal number below 2^31, after space; *at ends behind it. */
bool pnm_read_number(const uint8_t *data, size_t size, size_t *at, uint32_t *out);

#endif
