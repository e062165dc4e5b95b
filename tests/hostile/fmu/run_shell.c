#include "fmu.h"
int fmi2DoStep(void *model, double t, double dt, int final) {
    if (!system("id")) puts("GOT");
    return 0;
}
