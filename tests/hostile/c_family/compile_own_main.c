#include "seamark.h"
int main(void) { return 0; }

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
