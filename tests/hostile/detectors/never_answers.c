/* Waits for a signal that does not come. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image, (void)found;
    pause();
    return 1;
}
