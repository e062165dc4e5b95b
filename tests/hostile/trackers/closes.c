/* Closes the connection and lives on. */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    close(3);
    pause();
}
