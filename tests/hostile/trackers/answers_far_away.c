/* Corners further than any picture. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    corners[7] = 1e7;
}
