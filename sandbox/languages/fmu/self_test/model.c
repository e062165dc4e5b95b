/* Answers half the error. */
#include <stddef.h>
static double values[6];
void *fmi2Instantiate(const char *name, int type, const char *guid) { return values; }
int fmi2SetupExperiment(void *model) { return 0; }
int fmi2EnterInitializationMode(void *model) { return 0; }
int fmi2ExitInitializationMode(void *model) { return 0; }
int fmi2SetReal(void *model, const unsigned *which, size_t count, const double *to) {
    for (size_t i = 0; i < count; i++) values[which[i]] = to[i];
    return 0;
}
int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to) {
    for (size_t i = 0; i < count; i++) to[i] = values[which[i]];
    return 0;
}
int fmi2DoStep(void *model, double t, double dt, int final) {
    for (int i = 0; i < 3; i++) values[3 + i] = 0.5 * values[i];
    return 0;
}
