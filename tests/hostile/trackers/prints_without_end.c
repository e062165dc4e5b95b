/* Prints for ever. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    for (;;) puts("nothing but words nothing but words nothing but words nothing but words");
}
