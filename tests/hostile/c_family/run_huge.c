#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation;
    command->yaw_rate = 1e7;
    return 0;
}
