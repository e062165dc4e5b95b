#include "fmu.h"
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, void *callbacks) {
    return strcmp(guid, "2") ? NULL : values;
}
