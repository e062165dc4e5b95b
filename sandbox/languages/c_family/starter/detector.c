/* A minimal detector as a starting point.
 *
 * It reports long dark rectangles on brighter sand as boxes: it finds blocks of pixels that are
 * much darker than the mean, joins neighbours to regions, and puts a rectangle around each region,
 * along its principal axes. All numbers are sums, products, quotients and square roots, which are
 * the same on every machine.
 */
#include "seamark.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 3, MOST = 1 << 16 }; /* [px] side of a block; maximum number of blocks */
static const double dark_by = 2.0;  /* standard deviations below the mean */
static const double narrowest = 8.0; /* [px] minimum width of a box */
static const double plumpest = 2.0, slimmest = 4.5; /* length / width */
static const double fullest = 0.5; /* minimum share of the rectangle that is dark */

static int block, columns, rows; /* [px] side of a block; number of blocks */
static double sums[MOST];        /* of the pixels of each block */
static char dark[MOST];          /* whether a block is dark, and in no region yet */
static int region[MOST];         /* the blocks of a region */

static void find_dark(const seamark_image *image) {
    for (block = BLOCK; image->width / block * (image->height / block) > MOST;) block++;
    columns = image->width / block, rows = image->height / block;
    /* of a colour image the green channel: water absorbs red light first */
    const unsigned char *pixels = image->pixels + image->channels / 2;
    const int count = columns * rows;
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < count; i++) {
        sums[i] = 0.0;
        for (int j = 0; j < block * block; j++) {
            int x = i % columns * block + j % block, y = i / columns * block + j / block;
            sums[i] += pixels[(y * image->width + x) * image->channels];
        }
        sum += sums[i], squares += sums[i] * sums[i];
    }
    const double mean = sum / count, deviation = sqrt(squares / count - mean * mean);
    for (int i = 0; i < count; i++) dark[i] = sums[i] < mean - dark_by * deviation;
}

/* Move the dark blocks that are connected with one of them to `region`; return their number. */
static int grow(int first) {
    int count = 1;
    region[0] = first, dark[first] = 0;
    for (int i = 0; i < count; i++) {
        const int at = region[i], x = at % columns, y = at / columns;
        const int near[4] = {x > 0 ? at - 1 : at, x < columns - 1 ? at + 1 : at,
                             y > 0 ? at - columns : at, y < rows - 1 ? at + columns : at};
        for (int j = 0; j < 4; j++) {
            if (!dark[near[j]]) continue;
            dark[near[j]] = 0;
            region[count++] = near[j];
        }
    }
    return count;
}

/* Put a rectangle around the region; return 0 if it is not that of a box. */
static int enclose(int count, seamark_detection *found) {
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (int i = 0; i < count; i++) {
        const double x = region[i] % columns, y = region[i] / columns;
        sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
    }
    const double xx = sxx / count - sx / count * (sx / count);
    const double xy = sxy / count - sx / count * (sy / count);
    const double yy = syy / count - sy / count * (sy / count);
    /* (ux, uy): the first principal axis, an eigenvector of the covariance */
    const double half = (xx - yy) / 2.0;
    double ux = half + sqrt(half * half + xy * xy), uy = xy;
    if (ux == 0.0 && uy == 0.0) uy = 1.0;
    const double norm = sqrt(ux * ux + uy * uy);
    ux = ux / norm, uy = uy / norm;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}; /* along and across */
    for (int i = 0; i < count; i++) {
        const double x = region[i] % columns, y = region[i] / columns;
        const double at[2] = {x * ux + y * uy, y * ux - x * uy};
        for (int j = 0; j < 2; j++) {
            low[j] = fmin(low[j], at[j] - 0.5);
            high[j] = fmax(high[j], at[j] + 0.5);
        }
    }
    const double length = high[0] - low[0], width = high[1] - low[1];
    const double share = count / (length * width);
    if (width * block < narrowest || share < fullest) return 0;
    if (length < plumpest * width || length > slimmest * width) return 0;
    for (int i = 0; i < 4; i++) { /* clockwise */
        const double along = i == 1 || i == 2 ? high[0] : low[0], across = i < 2 ? low[1] : high[1];
        found->corners[2 * i] = block * (along * ux - across * uy) + (block - 1) / 2.0;
        found->corners[2 * i + 1] = block * (along * uy + across * ux) + (block - 1) / 2.0;
    }
    found->confidence = fmin(share, 1.0);
    strcpy(found->label, "box");
    return 1;
}

/* Called with each image; returns the number of detections. */
int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]) {
    int number = 0;
    find_dark(image);
    for (int i = 0; i < columns * rows && number < SEAMARK_MOST_DETECTIONS; i++)
        if (dark[i]) number += enclose(grow(i), &found[number]);
    return number;
}
