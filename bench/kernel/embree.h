/* Embree beside snell: the same triangles and rays. Only where it was found (BENCH_HAS_EMBREE). */
#ifndef SNELL_BENCH_KERNEL_EMBREE_H
#define SNELL_BENCH_KERNEL_EMBREE_H

#include "subject.h"

typedef enum peer_quality { PEER_LOW, PEER_MEDIUM, PEER_HIGH } peer_quality;

typedef struct peer peer;

#define PEER_FLAGS "RTC_SCENE_FLAG_ROBUST" /* of the scenes */
enum { PEER_PACKET = 16 };

/* s must outlive it. Errors end the program. */
peer *peer_create(const subject *s);
/* Builds, or builds anew, on every processor: the seconds of the commit alone. */
double peer_build(peer *p, peer_quality quality);
size_t peer_bytes(const peer *p); /* that the commit took and has not given back */
void peer_version(const peer *p, char *out, size_t size);
void peer_destroy(peer *p); /* NULL: nothing */

/* By packets of 16 (rtcIntersect16, rtcOccluded16; coherent: with the flag that says so) or one ray
 * at a time (rtcIntersect1, rtcOccluded1). Either hits or, for any hit, blocked is given; the other is
 * NULL. Of a miss only `instance`, NO_ID, counts; of spheres `primitive` is the number. */
typedef struct peer_mode {
    bool packets, coherent;
} peer_mode;
void peer_trace(const peer *p, peer_mode mode, const ray *rays, size_t count, hit *hits,
                uint8_t *blocked);

#endif
