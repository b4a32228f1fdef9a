/* Results of the kernel benchmark as text, scene by scene, or as one JSON object. */
#ifndef SNELL_BENCH_KERNEL_REPORT_H
#define SNELL_BENCH_KERNEL_REPORT_H

#include "measure.h"

/* embree: its version; NULL without. */
void report_head(const settings *t, const char *embree);
void report_scene(const scene_results *r, const settings *t);
/* The geometric means of the ratios, over all scenes. */
void report_means(const scene_results *r, size_t count, const settings *t);
void report_json(const scene_results *r, size_t count, const settings *t, const char *embree);

#endif
