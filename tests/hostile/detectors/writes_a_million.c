/* Writes a million detections where 64 fit. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image;
    for (int i = 1; i < 1000000; i++) found[i] = found[0];
    return SEAMARK_MOST_DETECTIONS;
}
