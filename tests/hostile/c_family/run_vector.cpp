#include <vector>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    std::vector<std::vector<char>> much;
    for (;;) much.emplace_back(1 << 20, 'x');
    return 0;
}
