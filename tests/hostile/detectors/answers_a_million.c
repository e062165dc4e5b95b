/* Says that there are a million detections. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image, (void)found;
    return 1000000;
}
