// A PI position controller as a starting point.
#include "seamark.h"

#include <algorithm>
#include <array>

namespace {

constexpr double limit = 0.6;  // m/s

struct Controller {
    // the configuration of the run, without the seed of the trial
    double kp = seamark_config_number("kp", 0.5);
    double ki = seamark_config_number("ki", 0.02);
    std::array<double, 3> integral{};

    double speed(int axis, const seamark_observation& observation) {
        const double error = observation.error[axis];  // m: forward, starboard, down
        integral[axis] += error * observation.dt;
        return std::clamp(kp * error + ki * integral[axis], -limit, limit);
    }
};

Controller& controller() {
    static Controller only;  // created at its first use, when the configuration is available
    return only;
}

}  // namespace

// called at the start of each level, when the vehicle is moved back
void seamark_reset(const seamark_level*) { controller().integral = {}; }

// called 20 times per simulated second
int seamark_step(const seamark_observation* observation, seamark_command* command) {
    if (!observation->target_visible) return 0;  // the command is 0 before each step
    command->surge = controller().speed(0, *observation);  // m/s
    command->sway = controller().speed(1, *observation);
    command->heave = controller().speed(2, *observation);
    return 0;
}
