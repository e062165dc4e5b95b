#include "seamark.h"
__asm__(".zero 8000000000");

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
