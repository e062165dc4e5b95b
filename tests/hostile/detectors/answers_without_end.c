/* Sends empty answers without end past the runner. */

static int attack(const seamark_image *image, seamark_detection *found) {
    static unsigned char frame[12] = {'d', SEAMARK_PROTOCOL, 0, 0, 3};
    (void)image, (void)found;
    for (;;) write(3, frame, sizeof frame);
}
