/* The built-in PI once more, as an FMU of FMI 3.0 with vectors: the same operations. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ERROR = 1, VISIBLE, COMMAND, KP, KI, LIMIT, HEAVE };
enum { OK = 0, FAILED = 3 };

typedef struct {
    double error[3], integral[3], command[4], kp, ki, limit;
    bool visible, heave;
} model;

typedef void logger(void *, int, const char *, const char *);

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources,
                                  bool visible, bool logging, bool events, bool early,
                                  const uint32_t *intermediate, size_t count, void *environment,
                                  logger *log, void *update) {
    (void)visible, (void)logging, (void)events, (void)early, (void)intermediate, (void)count;
    (void)update;
    if (strcmp(token, "{seamark-pi-3}") || !name || !resources) {
        log(environment, FAILED, "error", "wrong token");
        return NULL;
    }
    return calloc(1, sizeof(model));
}

void fmi3FreeInstance(void *instance) { free(instance); }

int fmi3SetDebugLogging(void *instance, bool on, size_t count, const char *const *categories) {
    (void)instance, (void)on, (void)count, (void)categories;
    return OK;
}

int fmi3EnterInitializationMode(void *instance, bool tolerance_given, double tolerance,
                                double start, bool stop_given, double stop) {
    (void)instance, (void)tolerance_given, (void)tolerance, (void)start, (void)stop_given;
    (void)stop;
    return OK;
}

int fmi3ExitInitializationMode(void *instance) {
    return ((model *)instance)->limit > 0.0 ? OK : FAILED;
}

int fmi3Terminate(void *instance) {
    (void)instance;
    return OK;
}

int fmi3Reset(void *instance) {
    memset(instance, 0, sizeof(model));
    return OK;
}

/* Where the numbers of a variable stand, and how many they are; NULL if there is no such. */
static double *place(model *pi, uint32_t which, size_t *count) {
    *count = which == ERROR ? 3 : which == COMMAND ? 4 : 1;
    switch (which) {
    case ERROR: return pi->error;
    case COMMAND: return pi->command;
    case KP: return &pi->kp;
    case KI: return &pi->ki;
    case LIMIT: return &pi->limit;
    default: return NULL;
    }
}

int fmi3SetFloat64(void *instance, const uint32_t *which, size_t references, const double *values,
                   size_t numbers) {
    for (size_t i = 0; i < references; i++) {
        size_t count;
        double *to = place(instance, which[i], &count);
        if (!to || count > numbers) return FAILED;
        memcpy(to, values, count * sizeof *to);
        values += count, numbers -= count;
    }
    return numbers ? FAILED : OK;
}

int fmi3GetFloat64(void *instance, const uint32_t *which, size_t references, double *values,
                   size_t numbers) {
    for (size_t i = 0; i < references; i++) {
        size_t count;
        const double *from = place(instance, which[i], &count);
        if (!from || count > numbers) return FAILED;
        memcpy(values, from, count * sizeof *from);
        values += count, numbers -= count;
    }
    return numbers ? FAILED : OK;
}

int fmi3SetBoolean(void *instance, const uint32_t *which, size_t references, const bool *values,
                   size_t numbers) {
    model *pi = instance;
    if (numbers != references) return FAILED;
    for (size_t i = 0; i < numbers; i++)
        *(which[i] == VISIBLE ? &pi->visible : &pi->heave) = values[i];
    return OK;
}

int fmi3DoStep(void *instance, double t, double dt, bool no_going_back, bool *event, bool *end,
               bool *early, double *reached) {
    model *pi = instance;
    (void)no_going_back;
    for (int axis = 0; axis < (pi->heave ? 3 : 2); axis++) {
        double change = pi->visible ? pi->ki * pi->error[axis] * dt : 0.0;
        double wanted = pi->kp * pi->error[axis] + pi->integral[axis] + change;
        double given = wanted < -pi->limit ? -pi->limit : wanted > pi->limit ? pi->limit : wanted;
        if (given == wanted || (wanted - given) * change < 0.0) pi->integral[axis] += change;
        pi->command[axis] = given;
    }
    *event = *end = *early = false;
    *reached = t + dt;
    return OK;
}

/* An FMU has every function of the standard. These say that the model cannot do it. */
#define CANNOT(function) \
    int function(void) { return FAILED; }
CANNOT(fmi3ActivateModelPartition)
CANNOT(fmi3CompletedIntegratorStep)
CANNOT(fmi3DeserializeFMUState)
CANNOT(fmi3EnterConfigurationMode)
CANNOT(fmi3EnterContinuousTimeMode)
CANNOT(fmi3EnterEventMode)
CANNOT(fmi3EnterStepMode)
CANNOT(fmi3EvaluateDiscreteStates)
CANNOT(fmi3ExitConfigurationMode)
CANNOT(fmi3FreeFMUState)
CANNOT(fmi3GetAdjointDerivative)
CANNOT(fmi3GetBinary)
CANNOT(fmi3GetBoolean)
CANNOT(fmi3GetClock)
CANNOT(fmi3GetContinuousStateDerivatives)
CANNOT(fmi3GetContinuousStates)
CANNOT(fmi3GetDirectionalDerivative)
CANNOT(fmi3GetEventIndicators)
CANNOT(fmi3GetFMUState)
CANNOT(fmi3GetFloat32)
CANNOT(fmi3GetInt16)
CANNOT(fmi3GetInt32)
CANNOT(fmi3GetInt64)
CANNOT(fmi3GetInt8)
CANNOT(fmi3GetIntervalDecimal)
CANNOT(fmi3GetIntervalFraction)
CANNOT(fmi3GetNominalsOfContinuousStates)
CANNOT(fmi3GetNumberOfContinuousStates)
CANNOT(fmi3GetNumberOfEventIndicators)
CANNOT(fmi3GetNumberOfVariableDependencies)
CANNOT(fmi3GetOutputDerivatives)
CANNOT(fmi3GetShiftDecimal)
CANNOT(fmi3GetShiftFraction)
CANNOT(fmi3GetString)
CANNOT(fmi3GetUInt16)
CANNOT(fmi3GetUInt32)
CANNOT(fmi3GetUInt64)
CANNOT(fmi3GetUInt8)
CANNOT(fmi3GetVariableDependencies)
CANNOT(fmi3SerializeFMUState)
CANNOT(fmi3SerializedFMUStateSize)
CANNOT(fmi3SetBinary)
CANNOT(fmi3SetClock)
CANNOT(fmi3SetContinuousStates)
CANNOT(fmi3SetFMUState)
CANNOT(fmi3SetFloat32)
CANNOT(fmi3SetInt16)
CANNOT(fmi3SetInt32)
CANNOT(fmi3SetInt64)
CANNOT(fmi3SetInt8)
CANNOT(fmi3SetIntervalDecimal)
CANNOT(fmi3SetIntervalFraction)
CANNOT(fmi3SetShiftDecimal)
CANNOT(fmi3SetShiftFraction)
CANNOT(fmi3SetString)
CANNOT(fmi3SetTime)
CANNOT(fmi3SetUInt16)
CANNOT(fmi3SetUInt32)
CANNOT(fmi3SetUInt64)
CANNOT(fmi3SetUInt8)
CANNOT(fmi3UpdateDiscreteStates)
void *fmi3InstantiateModelExchange(void) { return NULL; }
void *fmi3InstantiateScheduledExecution(void) { return NULL; }
