/* A corner that is nowhere. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    corners[0] = -INFINITY;
}
