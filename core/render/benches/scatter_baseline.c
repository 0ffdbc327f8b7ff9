/* The exact scatter as one would write it in C: the yardstick of benches/scatter.rs.
 *
 * Every pixel of every channel spreads its light with its own kernel, a skew-normal along the
 * meridian times a Gaussian across it, sampled at pixel centres within five standard deviations and
 * scaled to unit sum. Threads share out the source rows and each adds to a plane of its own.
 *
 * Usage: scatter_baseline WIDTH HEIGHT CORNER_SIGMA PLATE OUT
 * PLATE holds three planes of floats, OUT gets three. Prints seconds and the sum of all samples.
 */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CDF_REACH 6.0f
#define CDF_CELLS 4096
#define REACH_SIGMAS 5.0

static float cdf_table[CDF_CELLS + 2];

static void fill_cdf_table(void)
{
    for (int k = 0; k < CDF_CELLS + 2; k++) {
        double w = -CDF_REACH + 2.0 * CDF_REACH * k / CDF_CELLS;
        cdf_table[k] = (float)(0.5 * erfc(-w * M_SQRT1_2));
    }
}

static inline float cdf(float w)
{
    if (w <= -CDF_REACH)
        return 0.0f;
    if (w >= CDF_REACH)
        return 1.0f;
    float cell = (w + CDF_REACH) * (CDF_CELLS / (2.0f * CDF_REACH));
    int k = (int)cell;
    return cdf_table[k] + (cell - (float)k) * (cdf_table[k + 1] - cdf_table[k]);
}

static void scatter_channel(const float *plate, float *out, int width, int height, double corner,
                            double strength, double shape)
{
    size_t count = (size_t)width * height;
    double half_diagonal = 0.5 * hypot(width, height);
#pragma omp parallel
    {
        float *own = calloc(count, sizeof *own);
        float *kernel = NULL;
        size_t room = 0;
#pragma omp for schedule(dynamic, 4)
        for (int row = 0; row < height; row++) {
            for (int column = 0; column < width; column++) {
                float light = plate[(size_t)row * width + column];
                if (light == 0.0f)
                    continue;
                double x = column + 0.5 - width / 2.0, y = row + 0.5 - height / 2.0;
                double h = hypot(x, y), rho = h / half_diagonal;
                double c = h > 0 ? x / h : 1.0, s = h > 0 ? y / h : 0.0;
                double radial =
                    fmax(0.5, strength * (corner / 6 + (corner - corner / 6) * rho * rho));
                double across =
                    fmax(0.5, strength * (corner / 6 + (corner / 2 - corner / 6) * rho * rho));
                double alpha = shape * rho, delta = alpha / sqrt(1 + alpha * alpha);
                double scale = radial / sqrt(1 - 2 * delta * delta / M_PI);
                double mean = scale * delta * sqrt(2 / M_PI);
                /* The box of the underlying normal, whose centre lies at -mean along the meridian. */
                double reach_x = REACH_SIGMAS * hypot(scale * c, across * s);
                double reach_y = REACH_SIGMAS * hypot(scale * s, across * c);
                int left = (int)ceil(-mean * c - reach_x), right = (int)floor(-mean * c + reach_x);
                int top = (int)ceil(-mean * s - reach_y), bottom = (int)floor(-mean * s + reach_y);
                int columns = right - left + 1, rows = bottom - top + 1;
                if ((size_t)columns * rows > room) {
                    room = (size_t)columns * rows;
                    kernel = realloc(kernel, room * sizeof *kernel);
                }
                float cf = (float)c, sf = (float)s, mean_f = (float)mean, alpha_f = (float)alpha;
                float per_scale = (float)(1 / scale), per_across = (float)(1 / across);
                float sum = 0.0f;
                for (int j = 0; j < rows; j++) {
                    for (int i = 0; i < columns; i++) {
                        float dx = (float)(left + i), dy = (float)(top + j);
                        float z = (dx * cf + dy * sf + mean_f) * per_scale;
                        float t = (dy * cf - dx * sf) * per_across;
                        float w = expf(-0.5f * (z * z + t * t)) * cdf(alpha_f * z);
                        kernel[j * columns + i] = w;
                        sum += w;
                    }
                }
                float gain = light / sum;
                int first = column + left < 0 ? -column - left : 0;
                int last = column + right >= width ? width - column - left : columns;
                for (int j = 0; j < rows; j++) {
                    int y_out = row + top + j;
                    if (y_out < 0 || y_out >= height)
                        continue;
                    float *line = own + (size_t)y_out * width + column + left;
                    for (int i = first; i < last; i++)
                        line[i] += gain * kernel[j * columns + i];
                }
            }
        }
#pragma omp critical
        for (size_t k = 0; k < count; k++)
            out[k] += own[k];
        free(own);
        free(kernel);
    }
}

int main(int argc, char **argv)
{
    if (argc != 6) {
        fprintf(stderr, "usage: scatter_baseline WIDTH HEIGHT CORNER_SIGMA PLATE OUT\n");
        return 2;
    }
    int width = atoi(argv[1]), height = atoi(argv[2]);
    double corner = atof(argv[3]);
    static const double strength[3] = {0.9, 1.0, 1.15}, shape[3] = {3, 4, 5};
    size_t count = (size_t)width * height;
    float *plate = malloc(3 * count * sizeof *plate);
    float *out = calloc(3 * count, sizeof *out);
    FILE *file = fopen(argv[4], "rb");
    if (!plate || !out || !file || fread(plate, sizeof *plate, 3 * count, file) != 3 * count) {
        fprintf(stderr, "cannot read %s\n", argv[4]);
        return 1;
    }
    fclose(file);
    fill_cdf_table();
    double start = omp_get_wtime();
    for (int channel = 0; channel < 3; channel++)
        scatter_channel(plate + channel * count, out + channel * count, width, height, corner,
                        strength[channel], shape[channel]);
    double seconds = omp_get_wtime() - start, sum = 0;
    for (size_t k = 0; k < 3 * count; k++)
        sum += out[k];
    file = fopen(argv[5], "wb");
    if (!file || fwrite(out, sizeof *out, 3 * count, file) != 3 * count || fclose(file)) {
        fprintf(stderr, "cannot write %s\n", argv[5]);
        return 1;
    }
    printf("%.6f %.9g\n", seconds, sum);
    return 0;
}
