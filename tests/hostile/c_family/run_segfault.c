#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    *(volatile int *)8 = 1;
    return 0;
}
