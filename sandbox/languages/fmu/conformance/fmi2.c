/* The built-in PI once more, as an FMU of FMI 2.0: the same operations in the same order. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { ERROR = 0, COMMAND = 3, KP = 6, KI, LIMIT, REALS };
enum { OK = 0, FAILED = 3, CO_SIMULATION = 1 };

typedef struct {
    double reals[REALS], integral[3];
    int visible, heave;
} model;

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
} callbacks;

static void (*release)(void *);

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const callbacks *given, int visible, int logging) {
    (void)visible, (void)logging;
    if (type != CO_SIMULATION || strcmp(guid, "{seamark-pi}") || !name || !resources) {
        given->logger(NULL, name, FAILED, "error", "wrong guid");
        return NULL;
    }
    release = given->release;
    return given->allocate(1, sizeof(model));
}

void fmi2FreeInstance(void *instance) {
    if (instance) release(instance);
}

int fmi2SetDebugLogging(void *instance, int on, size_t count, const char *const *categories) {
    (void)instance, (void)on, (void)count, (void)categories;
    return OK;
}

int fmi2SetupExperiment(void *instance, int tolerance_given, double tolerance, double start,
                        int stop_given, double stop) {
    (void)instance, (void)tolerance_given, (void)tolerance, (void)start, (void)stop_given;
    (void)stop;
    return OK;
}

int fmi2EnterInitializationMode(void *instance) {
    (void)instance;
    return OK;
}

int fmi2ExitInitializationMode(void *instance) {
    return ((model *)instance)->reals[LIMIT] > 0.0 ? OK : FAILED;
}

int fmi2Terminate(void *instance) {
    (void)instance;
    return OK;
}

int fmi2Reset(void *instance) {
    memset(instance, 0, sizeof(model));
    return OK;
}

int fmi2SetReal(void *instance, const unsigned *which, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= REALS) return FAILED;
        ((model *)instance)->reals[which[i]] = values[i];
    }
    return OK;
}

int fmi2GetReal(void *instance, const unsigned *which, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= REALS) return FAILED;
        values[i] = ((model *)instance)->reals[which[i]];
    }
    return OK;
}

int fmi2SetBoolean(void *instance, const unsigned *which, size_t count, const int *values) {
    model *pi = instance;
    for (size_t i = 0; i < count; i++) *(which[i] == 0 ? &pi->visible : &pi->heave) = values[i];
    return OK;
}

int fmi2GetBoolean(void *instance, const unsigned *which, size_t count, int *values) {
    model *pi = instance;
    for (size_t i = 0; i < count; i++) values[i] = which[i] == 0 ? pi->visible : pi->heave;
    return OK;
}

int fmi2DoStep(void *instance, double t, double dt, int no_going_back) {
    model *pi = instance;
    double *reals = pi->reals, limit = reals[LIMIT];
    (void)t, (void)no_going_back;
    for (int axis = 0; axis < (pi->heave ? 3 : 2); axis++) {
        double change = pi->visible ? reals[KI] * reals[ERROR + axis] * dt : 0.0;
        double wanted = reals[KP] * reals[ERROR + axis] + pi->integral[axis] + change;
        double given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
        if (given == wanted || (wanted - given) * change < 0.0) pi->integral[axis] += change;
        reals[COMMAND + axis] = given;
    }
    return OK;
}

/* An FMU has every function of the standard. These say that the model cannot do it. */
#define CANNOT(function) \
    int function(void) { return FAILED; }
CANNOT(fmi2CancelStep)
CANNOT(fmi2DeSerializeFMUstate)
CANNOT(fmi2FreeFMUstate)
CANNOT(fmi2GetBooleanStatus)
CANNOT(fmi2GetDirectionalDerivative)
CANNOT(fmi2GetFMUstate)
CANNOT(fmi2GetInteger)
CANNOT(fmi2GetIntegerStatus)
CANNOT(fmi2GetRealOutputDerivatives)
CANNOT(fmi2GetRealStatus)
CANNOT(fmi2GetStatus)
CANNOT(fmi2GetString)
CANNOT(fmi2GetStringStatus)
CANNOT(fmi2SerializeFMUstate)
CANNOT(fmi2SerializedFMUstateSize)
CANNOT(fmi2SetFMUstate)
CANNOT(fmi2SetInteger)
CANNOT(fmi2SetRealInputDerivatives)
CANNOT(fmi2SetString)
