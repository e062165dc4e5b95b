/* Moves an arm, as a starting point: keeps the vehicle above its target, the hand open below it. */
#include "seamark.h"

#define FASTEST 0.3 /* [rad/s] that all motors of the arm-5e-like reach */

/* [rad] its slew, upper arm, forearm, wrist and jaws: the tool points down */
static const double posture[] = {0.0, 0.45, 0.6, 0.0, 0.6};

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    /* called 20 times per simulated second; the command is 0 before each step */
    command->surge = 0.5 * observation->error[0]; /* m/s */
    command->sway = 0.5 * observation->error[1];
    for (int joint = 0; joint < 5; joint++) {
        double speed = 2.0 * (posture[joint] - observation->joints[joint]);
        command->arm[joint] = speed < -FASTEST ? -FASTEST : speed > FASTEST ? FASTEST : speed;
    }
    return 0;
}
