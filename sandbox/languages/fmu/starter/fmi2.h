/* What is part of every FMU: the instance, its states, access to its variables. */

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                      const void *callbacks, int visible, int logging) {
    model *one = type == CO_SIMULATION ? malloc(sizeof *one) : NULL;
    (void)name, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    if (one) reset(one);
    return one;
}

void fmi2FreeInstance(void *instance) { free(instance); }
int fmi2Reset(void *instance) { return reset(instance); }

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

int fmi2EnterInitializationMode(void *instance) { return instance ? OK : FAILED; }
int fmi2ExitInitializationMode(void *instance) { return instance ? OK : FAILED; }
int fmi2Terminate(void *instance) { return instance ? OK : FAILED; }

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
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= BOOLEANS) return FAILED;
        ((model *)instance)->booleans[which[i]] = values[i];
    }
    return OK;
}

int fmi2GetBoolean(void *instance, const unsigned *which, size_t count, int *values) {
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= BOOLEANS) return FAILED;
        values[i] = ((model *)instance)->booleans[which[i]];
    }
    return OK;
}

/* An FMU exports every function of the standard; these are not supported by the model. */
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
