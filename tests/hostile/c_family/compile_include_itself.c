#include "program.c"
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
