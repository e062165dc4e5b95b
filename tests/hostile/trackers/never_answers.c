/* Waits for a signal that does not come. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    pause();
}
