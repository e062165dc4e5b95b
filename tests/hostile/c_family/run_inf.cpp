#include <limits>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation;
    command->heave = -std::numeric_limits<double>::infinity();
    return 0;
}
