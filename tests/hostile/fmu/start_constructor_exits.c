#include "fmu.h"
__attribute__((constructor)) static void begin(void) {
    _exit(0);
}
