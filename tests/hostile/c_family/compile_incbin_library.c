#include "seamark.h"
__asm__(".rept 8\n.incbin \"/usr/lib/x86_64-linux-gnu/libc.so.6\"\n.endr");

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
