/* An exception that nobody catches. */
#include <stdexcept>
#include "seamark.h"

static double before[8];

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) corners[i] = before[i];
    throw std::runtime_error("no target");
    return 1;
}
