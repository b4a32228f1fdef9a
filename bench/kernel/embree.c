#include "embree.h"

#include <embree3/rtcore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "base/memory.h"
#include "base/thread.h"
#include "parts.h"

struct peer {
    const subject *subject;
    RTCDevice device;
    RTCScene scene;
    atomic_ptrdiff_t bytes; /* that the device has now */
    size_t committed_bytes;
};

/* ---- building ---- */

static bool count_bytes(void *user, ssize_t bytes, bool post) {
    (void)post;
    atomic_fetch_add(&((peer *)user)->bytes, bytes);
    return true;
}

static void report_error(void *user, enum RTCError code, const char *text) {
    (void)user;
    (void)code;
    bench_die(text);
}

peer *peer_create(const subject *s) {
    peer *p = bench_need(memory_zeroed(1, sizeof *p));
    p->subject = s;
    p->device = rtcNewDevice(NULL);
    if (p->device == NULL) bench_die("Embree gives no device");
    rtcSetDeviceErrorFunction(p->device, report_error, NULL);
    rtcSetDeviceMemoryMonitorFunction(p->device, count_bytes, p);
    return p;
}

static void set_buffer(RTCGeometry g, enum RTCBufferType type, uint32_t slot, enum RTCFormat format,
                       const void *from, size_t size, size_t count) {
    memcpy(bench_need(rtcSetNewGeometryBuffer(g, type, slot, format, size, count)), from,
           size * count);
}

static RTCGeometry make_geometry(const peer *p) {
    const bench_scene *s = &p->subject->scene;
    if (s->sphere_count) {
        RTCGeometry g = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        set_buffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, s->spheres,
                   sizeof(bench_sphere), s->sphere_count);
        return g;
    }
    RTCGeometry g = rtcNewGeometry(p->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryTimeStepCount(g, subject_keys(p->subject));
    for (uint32_t key = 0; key < subject_keys(p->subject); key++)
        set_buffer(g, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT3,
                   subject_positions(p->subject, key), sizeof(vec3), s->position_count);
    set_buffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, s->indices, 3 * sizeof(uint32_t),
               s->index_count / 3);
    return g;
}

double peer_build(peer *p, peer_quality quality) {
    static const enum RTCBuildQuality qualities[] = {
        RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_QUALITY_HIGH};
    if (p->scene) rtcReleaseScene(p->scene);
    p->scene = rtcNewScene(p->device);
    rtcSetSceneFlags(p->scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(p->scene, qualities[quality]);
    RTCGeometry g = make_geometry(p);
    rtcSetGeometryBuildQuality(g, qualities[quality]);
    rtcAttachGeometry(p->scene, g);
    ptrdiff_t before = atomic_load(&p->bytes);
    double start = time_seconds();
    rtcCommitGeometry(g);
    rtcCommitScene(p->scene);
    double seconds = time_seconds() - start;
    p->committed_bytes = (size_t)(atomic_load(&p->bytes) - before);
    rtcReleaseGeometry(g);
    return seconds;
}

size_t peer_bytes(const peer *p) { return p->committed_bytes; }

void peer_version(const peer *p, char *out, size_t size) {
    snprintf(out, size, "%d.%d.%d",
             (int)rtcGetDeviceProperty(p->device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
             (int)rtcGetDeviceProperty(p->device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
             (int)rtcGetDeviceProperty(p->device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

void peer_destroy(peer *p) {
    if (p == NULL) return;
    if (p->scene) rtcReleaseScene(p->scene);
    rtcReleaseDevice(p->device);
    free(p);
}

/* ---- tracing ----
 *
 * Rays are brought into Embree's layout and results into snell's with 16 bytes at a time, so that
 * little of the time is that. */

typedef float float4 __attribute__((vector_size(16)));

static float4 load4(const float *from) {
    float4 v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* Four rays' four numbers: to[i] takes number i of each. */
static void transpose4(const float4 in[4], float *to[4], size_t at) {
    float4 a = __builtin_shufflevector(in[0], in[1], 0, 4, 1, 5);
    float4 b = __builtin_shufflevector(in[2], in[3], 0, 4, 1, 5);
    float4 c = __builtin_shufflevector(in[0], in[1], 2, 6, 3, 7);
    float4 d = __builtin_shufflevector(in[2], in[3], 2, 6, 3, 7);
    const float4 out[4] = {
        __builtin_shufflevector(a, b, 0, 1, 4, 5), __builtin_shufflevector(a, b, 2, 3, 6, 7),
        __builtin_shufflevector(c, d, 0, 1, 4, 5), __builtin_shufflevector(c, d, 2, 3, 6, 7)};
    for (int i = 0; i < 4; i++) memcpy(to[i] + at, &out[i], sizeof out[i]);
}

static void pack(struct RTCRay16 *to, const ray *rays, bool timed) {
    for (size_t i = 0; i < PEER_PACKET; i += 4) {
        float4 o[4], d[4];
        for (int k = 0; k < 4; k++) o[k] = load4(&rays[i + (size_t)k].o.x);
        for (int k = 0; k < 4; k++) d[k] = load4(&rays[i + (size_t)k].d.x);
        transpose4(o, (float *[4]){to->org_x, to->org_y, to->org_z, to->tnear}, i);
        transpose4(d, (float *[4]){to->dir_x, to->dir_y, to->dir_z, to->tfar}, i);
    }
    if (timed)
        for (size_t i = 0; i < PEER_PACKET; i++) to->time[i] = rays[i].time;
}

static void trace_packets(const peer *p, struct RTCIntersectContext *context, const ray *rays,
                          size_t count, hit *hits, uint8_t *blocked) {
    bool timed = p->subject->deforming != NULL;
    struct RTCRayHit16 q = {0};
    int valid[PEER_PACKET] __attribute__((aligned(64)));
    ray rest[PEER_PACKET];
    for (int k = 0; k < PEER_PACKET; k++) valid[k] = -1, q.ray.mask[k] = ~0u;
    for (size_t i = 0; i < count; i += PEER_PACKET) {
        size_t n = count - i < PEER_PACKET ? count - i : PEER_PACKET;
        const ray *from = rays + i;
        if (n < PEER_PACKET) {
            for (size_t k = 0; k < PEER_PACKET; k++) {
                rest[k] = from[k < n ? k : 0];
                valid[k] = k < n ? -1 : 0;
            }
            from = rest;
        }
        pack(&q.ray, from, timed);
        if (blocked) {
            rtcOccluded16(valid, p->scene, context, &q.ray);
            for (size_t k = 0; k < n; k++) blocked[i + k] = q.ray.tfar[k] < 0;
            continue;
        }
        memset(q.hit.geomID, 0xff, sizeof q.hit.geomID);
        rtcIntersect16(valid, p->scene, context, &q);
        for (size_t k = 0; k < n; k++)
            hits[i + k] =
                (hit){q.ray.tfar[k], q.hit.u[k], q.hit.v[k], q.hit.primID[k], q.hit.geomID[k]};
    }
}

static void trace_single(const peer *p, struct RTCIntersectContext *context, const ray *rays,
                         size_t count, hit *hits, uint8_t *blocked) {
    for (size_t i = 0; i < count; i++) {
        const ray *r = &rays[i];
        struct RTCRayHit q;
        float4 o = load4(&r->o.x), d = load4(&r->d.x);
        d[3] = r->time;
        memcpy(&q.ray.org_x, &o, sizeof o);
        memcpy(&q.ray.dir_x, &d, sizeof d);
        q.ray.tfar = r->t_max;
        q.ray.mask = ~0u;
        q.ray.id = q.ray.flags = 0;
        if (blocked) {
            rtcOccluded1(p->scene, context, &q.ray);
            blocked[i] = q.ray.tfar < 0;
            continue;
        }
        q.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(p->scene, context, &q);
        hits[i] = (hit){q.ray.tfar, q.hit.u, q.hit.v, q.hit.primID, q.hit.geomID};
    }
}

void peer_trace(const peer *p, peer_mode mode, const ray *rays, size_t count, hit *hits,
                uint8_t *blocked) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (mode.coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#ifdef __SSE__
    /* As Embree's manual asks for: denormal numbers count as 0. */
    unsigned saved = _mm_getcsr();
    _mm_setcsr(saved | 0x8040);
#endif
    if (mode.packets)
        trace_packets(p, &context, rays, count, hits, blocked);
    else
        trace_single(p, &context, rays, count, hits, blocked);
#ifdef __SSE__
    _mm_setcsr(saved);
#endif
}
