/* Says at the first picture that it cannot. */
#include "seamark.h"

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image, (void)corners;
    return 7;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    return 0;
}
