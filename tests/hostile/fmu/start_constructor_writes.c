#include "fmu.h"
__attribute__((constructor)) static void begin(void) {
    if (open("/box/python/seamark_inside/fmu/inside/runner.py", O_RDWR) >= 0) puts("GOT");
    if (creat("/usr/lib/mine.so", 0700) >= 0) puts("GOT");
}
