/* Reads at no address. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    corners[0] = *(volatile double *)16;
}
