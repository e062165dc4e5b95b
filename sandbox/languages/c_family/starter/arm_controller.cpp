// Moves an arm, as a starting point: keeps the vehicle above its target, the hand open below it.
#include "seamark.h"

#include <algorithm>
#include <array>

namespace {

// [rad] slew, upper arm, forearm, wrist and jaws of the arm-5e-like: the tool points down
constexpr std::array posture{0.0, 0.45, 0.6, 0.0, 0.6};
constexpr double fastest = 0.3;  // [rad/s] that all of its motors reach

}  // namespace

// called 20 times per simulated second; the command is 0 before each step
int seamark_step(const seamark_observation* observation, seamark_command* command) {
    command->surge = 0.5 * observation->error[0];  // m/s
    command->sway = 0.5 * observation->error[1];
    for (std::size_t joint = 0; joint < posture.size(); ++joint) {
        const double speed = 2.0 * (posture[joint] - observation->joints[joint]);
        command->arm[joint] = std::clamp(speed, -fastest, fastest);
    }
    return 0;
}
