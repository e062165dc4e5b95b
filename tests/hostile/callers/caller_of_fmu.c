/* Calls the functions of an FMU (FMI 2.0) without any guard, and says what it is given. */
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *where, void *callbacks);
int fmi2ExitInitializationMode(void *model);
int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to);
int fmi2DoStep(void *model, double t, double dt, int final);

static void log_it(void *model, const char *name, int status, const char *category, const char *format, ...) {
    (void)model, (void)name, (void)status, (void)category;
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
}

static void look(int status) {
    if (status) dprintf(301, "\nCALLER: took status %d\n", status);
}

int main(void) {
    void *callbacks[5] = {(void *)log_it};
    unsigned which[4] = {0, 1, 2, 3};
    double *to = malloc(4 * sizeof *to);
    dprintf(301, "\nCALLER: calls\n");
    void *model = fmi2Instantiate("model", 1, "1", "", callbacks);
    if (!model) dprintf(301, "\nCALLER: took no model\n");
    look(fmi2ExitInitializationMode(model));
    for (int i = 0; i < 20; i++) {
        look(fmi2DoStep(model, i / 20.0, 0.05, 0));
        look(fmi2GetReal(model, which, 4, to));
        for (int at = 0; at < 4; at++)
            if (!(fabs(to[at]) <= 1e6)) dprintf(301, "\nCALLER: took %g\n", to[at]);
        if (fcntl(3, F_GETFD) < 0) dprintf(301, "\nCALLER: its connection is closed\n");
    }
    dprintf(301, "\nCALLER: finished\n");
    return 0;
}
