#include "seamark.h"

constexpr long spin() {
    long n = 0;
    while (n >= 0) n = (n + 1) % 1000;
    return n;
}
constexpr long never = spin();

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
