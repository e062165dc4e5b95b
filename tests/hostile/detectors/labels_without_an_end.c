/* A label without its last 0, that goes on in all further detections. */

static int attack(const seamark_image *image, seamark_detection *found) {
    (void)image;
    memset(found->label, 'x', (char *)&found[SEAMARK_MOST_DETECTIONS] - found->label);
    return 1;
}
