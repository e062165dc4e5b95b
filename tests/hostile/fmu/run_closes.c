#include "fmu.h"
int fmi2DoStep(void *model, double t, double dt, int final) {
    for (int file = 3; file < 64; file++) close(file);
    return 0;
}
