#include "seamark.h"
#line 7 "/etc/passwd"
int x = y;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
