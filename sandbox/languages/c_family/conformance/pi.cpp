// The built-in PI once more, in C++: the same operations in the same order.
#include <algorithm>
#include <array>
#include <memory>

#include "seamark.h"

namespace {

class Controller {
public:
    int step(const seamark_observation& observation, seamark_command& command) {
        double* const answer[] = {&command.surge, &command.sway, &command.heave};
        for (std::size_t axis = 0; axis < axes; ++axis) {
            const double error = observation.error[axis];
            const double change = observation.target_visible ? ki * error * observation.dt : 0.0;
            const double wanted = kp * error + integral[axis] + change;
            *answer[axis] = std::clamp(wanted, -limit, limit);
            if (*answer[axis] == wanted || (wanted - *answer[axis]) * change < 0.0)
                integral[axis] += change;
        }
        return 0;
    }

    void reset() { integral = {}; }

private:
    double kp = seamark_config_number("kp", 0.0);
    double ki = seamark_config_number("ki", 0.0);
    double limit = seamark_config_number("reference_limit_m_s", 0.0);
    std::size_t axes = seamark_config_number("control_heave", 0.0) != 0.0 ? 3 : 2;
    std::array<double, 3> integral{};
};

std::unique_ptr<Controller> controller;

}  // namespace

int seamark_init() {
    controller = std::make_unique<Controller>();
    return 0;
}

void seamark_reset(const seamark_level*) { controller->reset(); }

int seamark_step(const seamark_observation* observation, seamark_command* command) {
    return controller->step(*observation, *command);
}
