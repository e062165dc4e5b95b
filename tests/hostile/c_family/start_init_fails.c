#include "seamark.h"
int seamark_init(void) { return 3; }

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
