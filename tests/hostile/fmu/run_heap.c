#include "fmu.h"
int fmi2DoStep(void *model, double t, double dt, int final) {
    for (;;) memset(malloc(1 << 22), 1, 1 << 22);
    return 0;
}
