#include "fmu.h"
int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to) {
    memset(to, 255, 1 << 26);
    return 0;
}
