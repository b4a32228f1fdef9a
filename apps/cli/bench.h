/* snell bench, in parts: bench.c makes the rounds, bench_report.c says what they took, bench_advice.c
 * what is unusual about it. */
#ifndef SNELL_CLI_BENCH_H
#define SNELL_CLI_BENCH_H

#include <jansson.h>
#include <snell/snell.h>

#include "stage.h"

enum { ROUNDS_MAX = 101, ADVICE_MAX = 16, ADVICE_TEXT = 160 };

typedef enum bench_phase {
    BENCH_LOAD,
    BENCH_BUILD,
    BENCH_RENDER,
    BENCH_WRITE,
    BENCH_PHASE_COUNT
} bench_phase;

typedef struct bench_round {
    double wall[BENCH_PHASE_COUNT], cpu[BENCH_PHASE_COUNT]; /* seconds; cpu: helper included */
    snell_render_stats stats;
} bench_round;

typedef struct bench {
    const options *options;
    const render_values *values;
    const char *label; /* what is rendered, as messages call it */
    uint32_t threads, round_count;
    snell_isa isa;
    snell_render_desc desc;  /* of the last round, as are the next three */
    snell_scene_stats scene; /* format is not kept */
    uint64_t memory_peak, memory_peak_import;
    bench_round rounds[ROUNDS_MAX];
} bench;

typedef struct summary {
    double median, least, most;
} summary;
/* Of one number of every round, `offset` bytes into it. */
summary bench_summary(const bench *b, size_t offset);
#define BENCH_SUMMARY(b, field) bench_summary((b), offsetof(bench_round, field))
/* Wall seconds of whole rounds. */
summary bench_seconds(const bench *b);
/* Million rays of every kind in a second of the render; in a CPU second. */
summary bench_rate(const bench *b);
summary bench_rate_cpu(const bench *b);
uint64_t bench_nearest_rays(const snell_render_stats *s); /* those that look for the nearest hit */

void bench_text(const bench *b);
void bench_print_advice(const bench *b);
json_t *bench_json(const bench *b);
/* Lines about what is unusual; their number. */
size_t bench_advice(const bench *b, char lines[ADVICE_MAX][ADVICE_TEXT]);

#endif
