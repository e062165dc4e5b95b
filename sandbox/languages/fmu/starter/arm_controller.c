/* Moves an arm, as an FMI 2.0 FMU, as a starting point: keeps the vehicle above its target, the hand
 * open below it.
 */
#include <stddef.h>
#include <stdlib.h>

enum { ERROR_X = 0, ERROR_Y, JOINTS, SURGE = JOINTS + 5, SWAY, SPEEDS, REALS = SPEEDS + 5 };
enum { OK = 0, FAILED = 3, CO_SIMULATION = 1 };
enum { BOOLEANS = 1 }; /* none that is connected */

#define FASTEST 0.3 /* [rad/s] that all motors of the arm-5e-like reach */

/* [rad] its slew, upper arm, forearm, wrist and jaws: the tool points down */
static const double posture[] = {0.0, 0.45, 0.6, 0.0, 0.6};

typedef struct {
    double reals[REALS];
    int booleans[BOOLEANS];
} model;

static int reset(model *arm) {
    *arm = (model){.reals = {0.0}};
    return OK;
}

/* Called 20 times per simulated second, after the inputs are set. */
int fmi2DoStep(void *instance, double t, double dt, int no_going_back) {
    double *reals = ((model *)instance)->reals;
    (void)t, (void)dt, (void)no_going_back;
    reals[SURGE] = 0.5 * reals[ERROR_X]; /* m/s */
    reals[SWAY] = 0.5 * reals[ERROR_Y];
    for (int joint = 0; joint < 5; joint++) {
        double speed = 2.0 * (posture[joint] - reals[JOINTS + joint]);
        reals[SPEEDS + joint] = speed < -FASTEST ? -FASTEST : speed > FASTEST ? FASTEST : speed;
    }
    return OK;
}

#include "fmi2.h" /* what is part of every FMU, for this model */
