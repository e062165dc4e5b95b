/* Thinks for ever. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    for (volatile unsigned long i = 0;; i++) {}
}
