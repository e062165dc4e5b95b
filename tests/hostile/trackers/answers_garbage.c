/* Sends what is no frame. */

static unsigned char garbage[3000];

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    for (unsigned i = 0; i < sizeof garbage; i++) garbage[i] = (unsigned char)(i * 37);
    write(3, garbage, sizeof garbage);
}
