/* Blurs a small picture with a lens: a gradient with a point of light.
 *
 *     cc -I plugin/include plugin/examples/apply.c -L target/release -lseidel_c -lm -o apply
 *     LD_LIBRARY_PATH=target/release ./apply lens.json
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "seidel.h"

enum { WIDTH = 96, HEIGHT = 64 };

/* Says why the last call failed, and ends. */
static void check(SeidelStatus status, const char *what) {
    char why[512];
    if (status == SEIDEL_STATUS_OK) {
        return;
    }
    seidel_last_error(why, sizeof why);
    fprintf(stderr, "%s: status %d: %s\n", what, (int)status, why);
    exit(1);
}

static int32_t told(void *user, double share) {
    *(double *)user = share;
    return 0; /* anything else stops the work */
}

int main(int count, char **words) {
    static float picture[HEIGHT][WIDTH][4], blurred[HEIGHT][WIDTH][4];
    SeidelLens *lens = NULL;
    double share = 0.0, before = 0.0, after = 0.0;
    int x, y;

    if (count != 2) {
        fprintf(stderr, "usage: %s LENS.json\n", words[0]);
        return 2;
    }
    if (seidel_abi_version() < SEIDEL_ABI_VERSION) {
        fprintf(stderr, "the library is older than the header\n");
        return 1;
    }
    for (y = 0; y < HEIGHT; y++) {
        for (x = 0; x < WIDTH; x++) {
            float light = 0.2f + 0.5f * (float)x / WIDTH;
            picture[y][x][0] = picture[y][x][1] = picture[y][x][2] = light;
            picture[y][x][3] = 1.0f;
        }
    }
    picture[20][30][0] = picture[20][30][1] = picture[20][30][2] = 50.0f;

    check(seidel_lens_open(words[1], &lens), "lens");

    SeidelSettings settings = {.size = sizeof settings};
    check(seidel_settings_init(&settings), "settings");
    settings.distance = 2.0; /* metres; with a depth image this is not asked */

    SeidelRect all = {0, 0, WIDTH, HEIGHT};
    SeidelImage source = {
        .size = sizeof source, .data = picture, .row_bytes = sizeof picture[0],
        .channels = 4, .sample = SEIDEL_FLOAT, .rect = all,
    };
    SeidelImage output = source;
    output.data = blurred;
    SeidelPlate plate = {
        .size = sizeof plate, .format = all, .extent = all, .source = &source,
    };
    SeidelCallbacks callbacks = {
        .size = sizeof callbacks, .user = &share, .progress = told,
    };
    check(seidel_apply(lens, &settings, &plate, &output, NULL, &callbacks), "apply");

    for (y = 0; y < HEIGHT; y++) {
        for (x = 0; x < WIDTH; x++) {
            before += picture[y][x][1];
            after += blurred[y][x][1];
        }
    }
    check(seidel_lens_release(lens), "release");
    printf("seidel %s: light %.3f -> %.3f, point 50 -> %.3f, done %.0f %%\n", seidel_version(),
           before, after, blurred[20][30][1], 100.0 * share);
    /* Mirrored edges keep the light. */
    return fabs(after / before - 1.0) < 1e-3 && blurred[20][30][1] < 50.0f ? 0 : 1;
}
