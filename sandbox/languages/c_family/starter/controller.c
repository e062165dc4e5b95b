/* A PI position controller as a starting point. */
#include "seamark.h"

static double kp, ki;
static const double LIMIT = 0.6; /* m/s */
static double integral[3];

int seamark_init(void) {
    /* the configuration of the run, without the seed of the trial */
    kp = seamark_config_number("kp", 0.5);
    ki = seamark_config_number("ki", 0.02);
    return 0;
}

void seamark_reset(const seamark_level *level) {
    /* called at the start of each level, when the vehicle is moved back */
    (void)level;
    for (int axis = 0; axis < 3; axis++) integral[axis] = 0.0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    /* called 20 times per simulated second */
    double speed[3];
    if (!observation->target_visible) return 0; /* the command is 0 before each step */
    for (int axis = 0; axis < 3; axis++) { /* m: forward, starboard, down */
        double error = observation->error[axis];
        integral[axis] += error * observation->dt;
        speed[axis] = kp * error + ki * integral[axis];
        if (speed[axis] > LIMIT) speed[axis] = LIMIT;
        if (speed[axis] < -LIMIT) speed[axis] = -LIMIT;
    }
    command->surge = speed[0]; /* m/s */
    command->sway = speed[1];
    command->heave = speed[2];
    return 0;
}
