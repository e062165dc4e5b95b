#include "fmu.h"
typedef void log_it(void *, const char *, int, const char *, const char *, ...);
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, void *callbacks) {
    (*(log_it **)callbacks)(NULL, name, 3, "", "%n%n%s%s");
    return values;
}
