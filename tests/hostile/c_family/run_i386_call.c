#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    long answer;
    __asm__ volatile("int $0x80" : "=a"(answer) : "a"(20L) : "memory");
    command->surge = 0.0 * (double)answer;
    return 0;
}
