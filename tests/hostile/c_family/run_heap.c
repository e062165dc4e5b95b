#include <stdlib.h>
#include <string.h>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    for (;;) {
        char *much = malloc(1 << 20);
        if (much) memset(much, 1, 1 << 20);
    }
    return 0;
}
