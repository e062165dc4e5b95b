/* Ends its process as if all were well. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    _exit(0);
}
