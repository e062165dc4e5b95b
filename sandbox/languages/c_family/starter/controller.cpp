// A PI position controller as a starting point: the law of the built-in PI.
#include "seamark.h"

#include <algorithm>
#include <array>

namespace {

struct Controller {
    // the configuration of the run, without the seed of the trial
    double kp = seamark_config_number("kp", 0.5);
    double ki = seamark_config_number("ki", 0.02);
    double limit = seamark_config_number("reference_limit_m_s", 1.0);
    std::size_t axes = seamark_config_number("control_heave", 0.0) != 0.0 ? 3 : 2;
    std::array<double, 3> integral{};  // m/s

    double speed(std::size_t axis, const seamark_observation& observation) {
        const double error = observation.error[axis];  // m: forward, starboard, down
        const double change = observation.target_visible ? ki * error * observation.dt : 0.0;
        const double wanted = kp * error + integral[axis] + change;
        const double given = std::clamp(wanted, -limit, limit);
        // anti-windup: at the limit the integral may only move back inside
        if (given == wanted || (wanted - given) * change < 0.0) integral[axis] += change;
        return given;
    }
};

Controller& controller() {
    static Controller only;  // created at its first use, when the configuration is available
    return only;
}

}  // namespace

// called at the start of each level, when the vehicle is moved back
void seamark_reset(const seamark_level*) { controller().integral = {}; }

// called 20 times per simulated second; the command is 0 before each step
int seamark_step(const seamark_observation* observation, seamark_command* command) {
    double* const answer[] = {&command->surge, &command->sway, &command->heave};  // m/s
    for (std::size_t axis = 0; axis < controller().axes; ++axis)
        *answer[axis] = controller().speed(axis, *observation);
    return 0;
}
