#include <math.h>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation;
    command->sway = NAN;
    return 0;
}
