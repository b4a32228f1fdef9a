#include "materials/albedo.h"

#include "maths/vec.h"

/* Where x in [0, 1] lies between nodes. */
static int find_cell(double x, double *part) {
    double scaled = sqrt(clamp01(x)) * (ALBEDO_SIZE - 1);
    int cell = (int)scaled;
    if (cell > ALBEDO_SIZE - 2) cell = ALBEDO_SIZE - 2;
    *part = scaled - cell;
    return cell;
}

static double mix(double a, double b, double part) { return a + (b - a) * part; }

double albedo_ggx(double alpha, double cosine, double f0, double f90) {
    double row, column;
    int i = find_cell(alpha, &row), j = find_cell(cosine, &column);
    double e[2];
    for (int k = 0; k < 2; k++) {
        const float(*low)[2] = albedo_ggx_table[i], (*high)[2] = albedo_ggx_table[i + 1];
        e[k] = mix(mix((double)low[j][k], (double)low[j + 1][k], column),
                   mix((double)high[j][k], (double)high[j + 1][k], column), row);
    }
    return clamp01(f0 * e[0] + f90 * e[1]);
}

double albedo_ggx_mean(double alpha, double f0, double f90) {
    double row;
    int i = find_cell(alpha, &row);
    const float *low = albedo_ggx_mean_table[i], *high = albedo_ggx_mean_table[i + 1];
    return clamp01(f0 * mix((double)low[0], (double)high[0], row) +
                   f90 * mix((double)low[1], (double)high[1], row));
}

double albedo_sheen(double alpha, double cosine) {
    double row, column;
    int i = find_cell(alpha, &row), j = find_cell(cosine, &column);
    const float *low = albedo_sheen_table[i], *high = albedo_sheen_table[i + 1];
    return clamp01(mix(mix((double)low[j], (double)low[j + 1], column),
                       mix((double)high[j], (double)high[j + 1], column), row));
}
