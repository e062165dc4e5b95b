#include "seamark.h"
static int deep(volatile int *up) {
    volatile int here[1024];
    here[0] = *up + 1;
    return deep(here) + here[0];
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation;
    volatile int top = 0;
    command->surge = deep(&top);
    return 0;
}
