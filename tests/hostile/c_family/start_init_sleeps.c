#include <unistd.h>
#include "seamark.h"
int seamark_init(void) {
    sleep(600);
    return 0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
