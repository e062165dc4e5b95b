/* A PI position controller as a starting point: the law of the built-in PI. */
#include "seamark.h"

static double kp, ki, limit, integral[3]; /* the integral in m/s */
static int axes;

int seamark_init(void) {
    /* the configuration of the run, without the seed of the trial */
    kp = seamark_config_number("kp", 0.5);
    ki = seamark_config_number("ki", 0.02);
    limit = seamark_config_number("reference_limit_m_s", 1.0);
    axes = seamark_config_number("control_heave", 0.0) != 0.0 ? 3 : 2;
    return 0;
}

void seamark_reset(const seamark_level *level) {
    /* called at the start of each level, when the vehicle is moved back */
    (void)level;
    for (int axis = 0; axis < 3; axis++) integral[axis] = 0.0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    /* called 20 times per simulated second; the command is 0 before each step */
    double *answer[3] = {&command->surge, &command->sway, &command->heave}; /* m/s */
    for (int axis = 0; axis < axes; axis++) {
        double error = observation->error[axis]; /* m: forward, starboard, down */
        double change = observation->target_visible ? ki * error * observation->dt : 0.0;
        double wanted = kp * error + integral[axis] + change;
        double given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
        /* anti-windup: at the limit the integral may only move back inside */
        if (given == wanted || (wanted - given) * change < 0.0) integral[axis] += change;
        *answer[axis] = given;
    }
    return 0;
}
