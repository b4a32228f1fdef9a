/* How far two pictures are apart; the numbers are explained at snell_comparison in snell.h. */
#ifndef SNELL_IMAGE_COMPARE_H
#define SNELL_IMAGE_COMPARE_H

#include "base/thread.h"
#include "image/film.h"
#include "image/tonemap.h"
#include "image/white_balance.h"

typedef struct compare_options {
    bool as_shown;
    const tonemap *map;  /* of linear pictures as shown */
    double exposure;     /* stops, the same */
    white_balance white; /* the same */
    double pixels_per_degree;
    const film *variances[2]; /* of the reference, of the picture; NULL: none; of the same size */
    uint32_t variance_count;  /* 0: very many */
    film *error;              /* NULL: not wanted; becomes RGB, linear */
    snell_error_map error_map;
    bool error_values;
    bool (*progress)(void *user, double fraction); /* may be NULL; by the calling thread */
    void *user;
} compare_options;

/* Two pictures of one size. The same bits for any pool. */
snell_status compare_films(const film *reference, const film *picture,
                           const compare_options *options, thread_pool *pool,
                           snell_comparison *out);

/* What |t| of Student's distribution with so many degrees of freedom (0: the normal one) exceeds
 * with the probability p, 0 < p < 1. */
double student_quantile(double p, uint32_t freedom);

#endif
