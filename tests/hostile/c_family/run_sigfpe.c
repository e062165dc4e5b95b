#include "seamark.h"
static volatile int zero;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation;
    command->surge = 7 / zero;
    return 0;
}
