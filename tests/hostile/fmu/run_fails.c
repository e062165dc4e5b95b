#include "fmu.h"
int fmi2DoStep(void *model, double t, double dt, int final) {
    return 3;
    return 0;
}
