#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    __builtin_trap();
    return 0;
}
