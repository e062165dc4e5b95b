/* Answers each picture twice. */
#include <string.h>

static unsigned char frame[72] = {'t', SEAMARK_PROTOCOL};
static unsigned question = 4; /* near the number of the first picture's question */

static void attack(const seamark_image *image, double corners[8]) {
    (void)image, (void)corners;
    memcpy(frame + 4, &question, 4);
    question++;
    write(3, frame, sizeof frame);
}
