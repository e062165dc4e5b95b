/* Tries to resize and to map anew the memory of the pictures before the runner has mapped it. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>
#include "seamark.h"

static double before[8];

static void attack(void) {
    for (int fd = 3; fd < 16; fd++) {
        if (!ftruncate(fd, 0)) printf("GOT nothing left in %d\n", fd);
        if (!ftruncate(fd, 1L << 30)) printf("GOT a GiB in %d\n", fd);
        if (!fallocate(fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096))
            printf("GOT a hole in %d\n", fd);
        if (pwrite(fd, "x", 1, 0) == 1) printf("GOT a byte in %d\n", fd);
        if (mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) != MAP_FAILED)
            printf("GOT a mapping of %d\n", fd);
    }
}

__attribute__((constructor)) static void early(void) { attack(); }

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    (void)image;
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    (void)image;
    attack();
    for (int i = 0; i < 8; i++) corners[i] = before[i];
    return 1;
}
