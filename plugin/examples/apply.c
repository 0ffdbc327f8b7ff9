/* Blurs a small image with a lens: a gradient with a point light.
 *
 *     cc -I plugin/include plugin/examples/apply.c -L target/release -lseidel_c -lm -o apply
 *     LD_LIBRARY_PATH=target/release ./apply lens.json
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "seidel.h"

enum { WIDTH = 96, HEIGHT = 64 };

/* Prints the last error and exits unless the call succeeded. */
static void check(SeidelStatus status, const char *call) {
    char error[512];
    if (status == SEIDEL_STATUS_OK) {
        return;
    }
    seidel_last_error(error, sizeof error);
    fprintf(stderr, "%s: status %d: %s\n", call, (int)status, error);
    exit(1);
}

static int32_t store_progress(void *user, double share) {
    *(double *)user = share;
    return 0; /* any other value stops the work */
}

int main(int argc, char **argv) {
    static float image[HEIGHT][WIDTH][4], blurred[HEIGHT][WIDTH][4];
    SeidelLens *lens = NULL;
    double share = 0.0, before = 0.0, after = 0.0;
    int x, y;

    if (argc != 2) {
        fprintf(stderr, "usage: %s LENS.json\n", argv[0]);
        return 2;
    }
    if (seidel_abi_version() < SEIDEL_ABI_VERSION) {
        fprintf(stderr, "the library is older than the header\n");
        return 1;
    }
    for (y = 0; y < HEIGHT; y++) {
        for (x = 0; x < WIDTH; x++) {
            float light = 0.2f + 0.5f * (float)x / WIDTH;
            image[y][x][0] = image[y][x][1] = image[y][x][2] = light;
            image[y][x][3] = 1.0f;
        }
    }
    image[20][30][0] = image[20][30][1] = image[20][30][2] = 50.0f;

    check(seidel_lens_open(argv[1], &lens), "lens");

    SeidelSettings settings = {.size = sizeof settings};
    check(seidel_settings_init(&settings), "settings");
    settings.distance = 2.0; /* metres; not used with a depth image */

    SeidelRect area = {0, 0, WIDTH, HEIGHT};
    SeidelImage source = {
        .size = sizeof source, .data = image, .row_bytes = sizeof image[0],
        .channels = 4, .sample = SEIDEL_FLOAT, .rect = area,
    };
    SeidelImage output = source;
    output.data = blurred;
    SeidelPlate plate = {
        .size = sizeof plate, .format = area, .extent = area, .source = &source,
    };
    SeidelCallbacks callbacks = {
        .size = sizeof callbacks, .user = &share, .progress = store_progress,
    };
    check(seidel_apply(lens, &settings, &plate, &output, NULL, &callbacks), "apply");

    for (y = 0; y < HEIGHT; y++) {
        for (x = 0; x < WIDTH; x++) {
            before += image[y][x][1];
            after += blurred[y][x][1];
        }
    }
    check(seidel_lens_release(lens), "release");
    printf("seidel %s: light %.3f -> %.3f, point 50 -> %.3f, done %.0f %%\n", seidel_version(),
           before, after, blurred[20][30][1], 100.0 * share);
    /* Mirrored edges preserve the sum of the light. */
    return fabs(after / before - 1.0) < 1e-3 && blurred[20][30][1] < 50.0f ? 0 : 1;
}
