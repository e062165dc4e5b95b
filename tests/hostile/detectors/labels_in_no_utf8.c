/* A label that is not UTF-8. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image;
    strcpy(found->label, "box\xff\xfe");
    return 1;
}
