#include "fmu.h"
__attribute__((constructor)) static void begin(void) {
    for (;;) continue;
}
