#include <stdexcept>
#include "seamark.h"
struct Bad {
    Bad() { throw std::runtime_error("no plan"); }
};
Bad bad;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
