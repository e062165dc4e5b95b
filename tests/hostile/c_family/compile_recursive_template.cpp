#include "seamark.h"
template <int N> struct Deep : Deep<N + 1> {};
Deep<0> deep;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
