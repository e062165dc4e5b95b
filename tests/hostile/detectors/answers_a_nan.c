/* A corner that is no number. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image;
    found->corners[5] = NAN;
    return 1;
}
