/* A model that answers 0; a hostile one replaces some of its functions. */
#include "fmu.h"

#define WEAK __attribute__((weak))

double values[8];
WEAK void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, void *callbacks) { return values; }
WEAK int fmi2SetupExperiment(void *model) { return 0; }
WEAK int fmi2EnterInitializationMode(void *model) { return 0; }
WEAK int fmi2ExitInitializationMode(void *model) { return 0; }
WEAK int fmi2SetReal(void *model, const unsigned *which, size_t count, const double *to) { return 0; }
WEAK int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to) {
    memset(to, 0, count * sizeof *to);
    return 0;
}
WEAK int fmi2DoStep(void *model, double t, double dt, int final) { return 0; }
