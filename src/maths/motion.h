/* Things that move: keys that people write, and the linear steps that rays see.
 *
 *     keys ──motion_interpolate──▶ translation lerped, rotation along the arc, stretch lerped
 *       └───motion_prepare───────▶ steps: clipped to when the shutter is open, linear in between
 *                                     └── motion_at, the same for the kernels and for shading
 *     motion_by_keys: at any time, for what no ray sees */
#ifndef SNELL_MATHS_MOTION_H
#define SNELL_MATHS_MOTION_H

#include <stddef.h>

#include "base/error.h"
#include "maths/vec.h"

typedef snell_motion_key motion_key;

/* At least one step, of ascending times; before the first and after the last it stands still. */
typedef struct motion {
    motion_key *steps; /* owned */
    uint32_t count;
    const motion_key *keys; /* all that it was made of; borrowed */
    size_t key_count;
} motion;

/* Linear pieces of each turn between two keys, or between a key and the shutter's end. */
enum { MOTION_STEPS = 16 };
/* More steps in what the shutters see are refused: 52 MiB for one motion. */
enum { MOTION_STEPS_MAX = 1 << 20 };

/* count >= 1, finite, ascending in time, each invertible. Errors begin with `what`. */
snell_status motion_check(const motion_key *keys, size_t count, const char *what);
/* The transform of checked keys at a time in seconds. A turn takes the shorter way, so keys are less
 * than half a turn apart. */
void motion_interpolate(const motion_key *keys, size_t count, double time, double out[3][4]);
/* The steps between two times (-INFINITY and INFINITY: all keys), of keys that outlive *out; an error where the motion becomes
 * singular on its way, or has more than MOTION_STEPS_MAX. Takes the memory of the steps there are. */
snell_status motion_prepare(const motion_key *keys, size_t count, double open, double close,
                            motion *out);
void motion_free(motion *m);
/* false: singular, which motion_prepare has excluded but for roundings; then nothing is there. */
bool motion_at(const motion *m, float time, transform *to_world, transform *to_local);
transform motion_transform(const motion *m, float time);
/* By the keys, also when no shutter is open. */
transform motion_by_keys(const motion *m, float time);
/* Of everything that a box passes through, a little widened: what lies between two steps is rounded. */
bounds3 motion_bounds(const motion *m, bounds3 b);

#endif
