#include <stdio.h>
#include <stdlib.h>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    if (system("echo GOT a shell") == 0) puts("GOT a shell");
    return 0;
}
