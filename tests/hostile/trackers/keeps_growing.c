/* Takes memory until there is none. */
#include <stdlib.h>
#include <string.h>

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    for (;;) {
        char *more = malloc(1 << 20);
        if (more) memset(more, 1, 1 << 20);
    }
}
