#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    ((seamark_observation *)observation)->error[0] = 1e9;
    command->surge = 1.0;
    return 0;
}
