#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "seamark.h"
extern char **environ;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    for (char **at = environ; *at; at++)
        if (strstr(*at, "SEAMARK")) printf("GOT %s\n", *at);
    if (getenv("SEAMARK_SECRET_KEY")) puts("GOT a secret");
    return 0;
}
