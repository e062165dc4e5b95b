/* Reads on behind the last picture's memory. */

static void attack(const seamark_image *image, double corners[8]) {
    unsigned long sum = 0;
    for (long i = 0; i < (1L << 30); i += 4096) sum += image->pixels[i];
    corners[0] = (double)(sum % 7);
}
