/* Calls a program in C or C++ without any guard, and says what it is given. With TRACKER or DETECTOR, one of
 * them; with MODEL, generated code that has no seamark.h. */
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static void report(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vdprintf(301, format, arguments);
    va_end(arguments);
}

static void look(const double *numbers, int count, double most) {
    for (int i = 0; i < count; i++)
        if (!(fabs(numbers[i]) <= most)) report("\nCALLER: took %g\n", numbers[i]);
    if (fcntl(3, F_GETFD) < 0) report("\nCALLER: its connection is closed\n");
}

#if defined(MODEL)
typedef struct { double surge, sway; } outputs;
extern outputs m_Y;
void m_initialize(void);
void m_step(void);

static void call(void) {
    m_initialize();
    for (int i = 0; i < 20; i++) {
        m_step();
        look(&m_Y.surge, 2, 1e6);
    }
}
#elif defined(TRACKER)
#include "seamark.h"

static void call(void) {
    double corners[8] = {10, 20, 30, 20, 30, 40, 10, 40};
    int file = memfd_create("images", 0);
    if (ftruncate(file, 1 << 20)) return;
    unsigned char *pixels = mmap(NULL, 1 << 20, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    seamark_image image = {pixels, 320, 240, 1};
    int code = seamark_tracker_start(&image, corners);
    if (code) report("\nCALLER: took the code %d\n", code);
    for (int i = 0; i < 6; i++) {
        memset(pixels, i, 320 * 240);
        code = seamark_tracker_update(&image, corners);
        if (code != 0 && code != 1) report("\nCALLER: took the code %d\n", code);
        look(corners, 8, 1e6);
        double across = (corners[4] - corners[0]) * (corners[7] - corners[3])
                        - (corners[5] - corners[1]) * (corners[6] - corners[2]);
        if (!(across > 1)) report("\nCALLER: took no convex quadrilateral\n");
        for (int at = 0; at < 320 * 240; at++)
            if (pixels[at] != i) {
                report("\nCALLER: the image changed\n");
                break;
            }
    }
}
#elif defined(DETECTOR)
#include "seamark.h"

static seamark_detection found[SEAMARK_MOST_DETECTIONS];

/* Say what is wrong with one detection. */
static void look_at(const seamark_detection *one) {
    size_t length = strnlen(one->label, SEAMARK_LABEL_BYTES);
    look(one->corners, 8, 1e6);
    if (!(one->confidence >= 0.0 && one->confidence <= 1.0))
        report("\nCALLER: took the confidence %g\n", one->confidence);
    if (length == 0 || length == SEAMARK_LABEL_BYTES) report("\nCALLER: took a label without an end\n");
    for (size_t i = 0; i < length; i++)
        if (one->label[i] < ' ') {
            report("\nCALLER: took a label with the byte %#x\n", (unsigned char)one->label[i]);
            break;
        }
}

static void call(void) {
    int file = memfd_create("images", 0);
    if (ftruncate(file, 1 << 20)) return;
    unsigned char *pixels = mmap(NULL, 1 << 20, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    seamark_image image = {pixels, 320, 240, 1};
    for (int i = 0; i < 6; i++) {
        memset(pixels, i, 320 * 240);
        memset(found, 0, sizeof found);
        int count = seamark_detect(&image, found);
        if (count < 0 || count > SEAMARK_MOST_DETECTIONS) report("\nCALLER: took %d detections\n", count);
        for (int j = 0; j < count && j < SEAMARK_MOST_DETECTIONS; j++) look_at(&found[j]);
        if (!count) report("\nCALLER: took no detection\n");
    }
}
#else
#include "seamark.h"

#pragma weak seamark_init
#pragma weak seamark_reset

double seamark_config_number(const char *key, double fallback) {
    (void)key;
    return fallback;
}

static void call(void) {
    seamark_level level = {0, 1, 1.0, 0.05, 0.0};
    if (seamark_init) {
        int code = seamark_init();
        if (code) report("\nCALLER: took the code %d\n", code);
    }
    if (seamark_reset) seamark_reset(&level);
    for (int i = 0; i < 20; i++) {
        seamark_observation observation = {.t = i / 20.0, .error = {0.1, 0.2, 0.3}};
        seamark_command command = {0};
        int code = seamark_step(&observation, &command);
        if (code) report("\nCALLER: took the code %d\n", code);
        look(&command.surge, 4, 1e6);
        if (observation.error[0] != 0.1) report("\nCALLER: the observation is %g\n", observation.error[0]);
    }
}
#endif

int main(void) {
    setlinebuf(stdout);
    report("\nCALLER: calls\n");
    call();
    report("\nCALLER: finished\n");
    return 0;
}
