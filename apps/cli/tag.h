/* The text inside a picture that tells how it was made: {"snell": version, "file": as typed,
 * "scene": its hash, "options": [...]}, the options written as on the command line, and nothing that
 * does not decide the picture. */
#ifndef SNELL_CLI_TAG_H
#define SNELL_CLI_TAG_H

#include <jansson.h>
#include <snell/snell.h>

#include "stage.h"

/* The caller frees it; NULL on lack of memory. film: what was rendered, for the look that its scene asks
 * for and what a noise reached. */
char *tag_make(const stage *s, const snell_film *film, bool partial);
/* The same of an animation: "animation": {"frames": "A..B" where they were chosen, "fps"}. asked: what every
 * frame is made with; film: the first. */
char *tag_make_movie(const stage *s, const snell_render_desc *asked, const snell_film *film,
                     double fps);
/* Whether a tag that was read is of several frames, so that one has to be chosen. */
bool tag_has_frames(const json_t *tag);
/* Of an animation of chosen frames the first; 0: it is none. */
uint32_t tag_first_frame(const json_t *tag);
/* NULL when the tag is not of this form, or an option in it is not render's. */
json_t *tag_read(const char *tag);
/* How many samples a pixel of the picture has that desc makes, where it has a noise; 0: not told. */
uint32_t tag_samples(const json_t *tag, const snell_render_desc *desc, uint32_t x, uint32_t y);
/* {"bound": .., "confidence": .., "blocks": .., "blocks_done": .., "samples": {min, mean, max}} */
json_t *tag_noise(const snell_render_stats *stats);
/* The value of an option in a tag that was read; NULL when there is none. */
const char *tag_option(const json_t *tag, const char *name);
/* The tag of a picture that snell convert made of one with `tag`; the caller frees it. What render
 * would have done as well (`linear`: exposure and tone map of floats) takes the place of its
 * options, the rest goes to a list "converted". */
char *tag_convert(const char *tag, const options *o, bool linear);
bool tag_is_picture(const char *path); /* by its name: a file that may have one */

#endif
