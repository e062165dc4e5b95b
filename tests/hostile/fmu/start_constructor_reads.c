#include "fmu.h"
__attribute__((constructor)) static void begin(void) {
    if (open("/etc/shadow", O_RDONLY) >= 0 || open("/etc/passwd", O_RDONLY) >= 0) puts("GOT");
    if (open("/proc/1/environ", O_RDONLY) >= 0 || getenv("SEAMARK_SECRET_KEY")) puts("GOT");
}
