#include <stdexcept>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    throw std::runtime_error("no plan");
    return 0;
}
