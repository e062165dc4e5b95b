#include "fmu.h"
int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to) {
    to[0] = to[1] = NAN;
    return 0;
}
