/* Writes into the picture. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    ((unsigned char *)image->pixels)[0] = 255;
}
