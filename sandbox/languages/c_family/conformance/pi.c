/* The built-in PI once more, in C: the same operations in the same order. */
#include "seamark.h"

static double kp, ki, limit, integral[3];
static int axes;

int seamark_init(void) {
    kp = seamark_config_number("kp", 0.0);
    ki = seamark_config_number("ki", 0.0);
    limit = seamark_config_number("reference_limit_m_s", 0.0);
    axes = seamark_config_number("control_heave", 0.0) != 0.0 ? 3 : 2;
    return limit > 0.0 ? 0 : 1;
}

void seamark_reset(const seamark_level *level) {
    (void)level;
    for (int axis = 0; axis < 3; axis++) integral[axis] = 0.0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    double *answer[3] = {&command->surge, &command->sway, &command->heave};
    for (int axis = 0; axis < axes; axis++) {
        double error = observation->error[axis];
        double change = observation->target_visible ? ki * error * observation->dt : 0.0;
        double wanted = kp * error + integral[axis] + change;
        double given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
        if (given == wanted || (wanted - given) * change < 0.0) integral[axis] += change;
        *answer[axis] = given;
    }
    return 0;
}
