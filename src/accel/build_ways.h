/* How the build splits the triangles of a mesh that deforms. */
#ifndef SNELL_ACCEL_BUILD_WAYS_H
#define SNELL_ACCEL_BUILD_WAYS_H

#include "accel/build.h"

/* By the job's ways. Reorders the references; returns how many went left, 0 where nothing can be
 * split. */
size_t build_split_ways(const build_job *job, build_reference *references, size_t count);

#endif
