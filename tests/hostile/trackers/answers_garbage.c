/* Sends what is no frame. */
#include <unistd.h>
#include "seamark.h"

static double before[8];
static unsigned char garbage[3000];

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) corners[i] = before[i];
    for (unsigned i = 0; i < sizeof garbage; i++) garbage[i] = (unsigned char)(i * 37);
    write(3, garbage, sizeof garbage);
    return 1;
}
