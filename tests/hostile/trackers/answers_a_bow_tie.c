/* Corners in an order that makes no convex quadrilateral. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    corners[2] = before[4], corners[3] = before[5];
    corners[4] = before[2], corners[5] = before[3];
}
