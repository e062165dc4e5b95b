#include "seamark.h"
__attribute__((destructor)) static void spin(void) {
    for (volatile int i = 0;; i++) {}
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
