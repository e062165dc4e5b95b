/* Put before each detector in C and C++ that is one function, `attack`: it makes it at each image, of which
 * it returns the number of detections. The first one is as it should be. */
#include <math.h>
#include <string.h>
#include <unistd.h>
#include "seamark.h"

static int attack(const seamark_image *image, seamark_detection *found);

int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]) {
    static const double corners[8] = {10, 20, 30, 20, 30, 40, 10, 40};
    memcpy(found->corners, corners, sizeof corners);
    strcpy(found->label, "box");
    found->confidence = 0.5;
    return attack(image, found);
}

