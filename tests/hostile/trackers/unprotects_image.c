#define _GNU_SOURCE
/* Has the kernel make the picture writable, or give its pages back. */
#include <stdio.h>
#include <sys/mman.h>
#include "seamark.h"

static double before[8];

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) corners[i] = before[i];
    void *page = (void *)((unsigned long)image->pixels & ~4095UL);
    if (!mprotect(page, 4096, PROT_READ | PROT_WRITE)) puts("GOT writable memory");
    if (!madvise(page, 4096, MADV_REMOVE)) puts("GOT the pages removed");
    if (mremap(page, 4096, 1 << 25, MREMAP_MAYMOVE) == MAP_FAILED) puts("it does not grow");
    return 1;
}
