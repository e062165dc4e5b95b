#include <stdio.h>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    for (;;) puts("flood flood flood flood flood flood flood flood");
    return 0;
}
