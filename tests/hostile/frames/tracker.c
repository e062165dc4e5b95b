/* Put before each tracker in C and C++ that is one function, `attack`: it makes it at each image. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <unistd.h>
#include "seamark.h"

static double before[8];
static void attack(const seamark_image *image, double corners[8]);

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    for (int i = 0; i < 8; i++) corners[i] = before[i];
    attack(image, corners);
    return 1;
}

