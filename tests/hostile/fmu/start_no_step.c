#include "fmu.h"
__attribute__((visibility("hidden"))) int fmi2DoStep(void *model, double t, double dt, int final) {
    return 0;
}
