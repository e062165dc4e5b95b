/* A minimal template tracker as a starting point.
 *
 * It stores some pixels of the target and searches around the last position for the smallest sum of
 * absolute differences. Means are subtracted, since turbid water adds scattered light. Integer
 * arithmetic gives the same result on every machine.
 */
#include "seamark.h"

#include <math.h>
#include <stdlib.h>

enum { POINTS = 1200, REACH = 8 }; /* maximum number of template pixels; search radius [px] */

static int left, top, columns, rows, pitch; /* position of the target and its sampling grid [px] */
static int patch[POINTS], count;            /* template pixels minus their mean, times count */
static long long contrast;                  /* sum of their absolute values */
static double corners_here[8];              /* [px] */

static int pixel(const seamark_image *image, int x, int y) {
    return image->pixels[(y * image->width + x) * image->channels];
}

/* Write the pixels of the grid at a position to `to`: minus their mean, times their number. */
static void look(const seamark_image *image, int at_x, int at_y, int *to) {
    int sum = 0;
    for (int i = 0; i < count; i++) {
        to[i] = pixel(image, at_x + i % columns * pitch, at_y + i / columns * pitch);
        sum += to[i];
    }
    for (int i = 0; i < count; i++) to[i] = count * to[i] - sum;
}

/* Called at the start of each level: the corners are x and y of the upper left, upper right, lower
 * right and lower left one. */
int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    double low[2] = {corners[0], corners[1]}, high[2] = {corners[0], corners[1]};
    for (int i = 0; i < 8; i++) {
        low[i % 2] = fmin(low[i % 2], corners[i]);
        high[i % 2] = fmax(high[i % 2], corners[i]);
        corners_here[i] = corners[i];
    }
    left = (int)fmax(ceil(low[0]), 0.0), top = (int)fmax(ceil(low[1]), 0.0);
    int width = (int)fmin(floor(high[0]), image->width - 1.0) - left;
    int height = (int)fmin(floor(high[1]), image->height - 1.0) - top;
    for (pitch = 1; width / pitch * (height / pitch) > POINTS;) pitch++;
    columns = width / pitch, rows = height / pitch, count = columns * rows;
    if (width < 1 || height < 1 || !count) return 1; /* no target: this ends the run */
    look(image, left, top, patch);
    contrast = 0;
    for (int i = 0; i < count; i++) contrast += abs(patch[i]);
    return 0;
}

/* Called with each following image, 20 per simulated second; returns 0 if the target is lost. */
int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    static int seen[POINTS];
    long long best = -1;
    int best_x = 0, best_y = 0;
    for (int y = top - REACH; y <= top + REACH; y++) {
        if (y < 0 || y + rows * pitch > image->height) continue;
        for (int x = left - REACH; x <= left + REACH; x++) {
            if (x < 0 || x + columns * pitch > image->width) continue;
            long long difference = 0;
            look(image, x, y, seen);
            for (int i = 0; i < count; i++) difference += abs(seen[i] - patch[i]);
            if (best >= 0 && difference >= best) continue;
            best = difference, best_x = x, best_y = y;
        }
    }
    if (best < 0 || 10 * best > 9 * contrast) return 0;
    for (int i = 0; i < 8; i++) {
        corners_here[i] += i % 2 ? best_y - top : best_x - left;
        corners[i] = corners_here[i];
    }
    left = best_x, top = best_y;
    return 1;
}
