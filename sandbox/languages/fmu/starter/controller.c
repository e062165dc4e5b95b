/* A PI position controller as an FMI 2.0 FMU, as a starting point: the law of the built-in PI.
 *
 * The sandbox compiles it. FMUs exported by Simulink or OpenModelica for 64-bit Linux are uploaded
 * unchanged; only the names of their inputs and outputs matter.
 */
#include <stddef.h>
#include <stdlib.h>

enum { ERROR_X = 0, SURGE = 3, KP = 6, KI, LIMIT, REALS }; /* value references */
enum { OK = 0, FAILED = 3, CO_SIMULATION = 1 };
enum { TARGET_VISIBLE = 0, CONTROL_HEAVE, BOOLEANS };

typedef struct {
    double reals[REALS], integral[3]; /* the integral in m/s */
    int booleans[BOOLEANS];
} model;

static int reset(model *pi) {
    *pi = (model){.reals = {[KP] = 0.5, [KI] = 0.02, [LIMIT] = 1.0}};
    return OK;
}

/* The control law, called 20 times per simulated second, after the inputs are set. */
int fmi2DoStep(void *instance, double t, double dt, int no_going_back) {
    model *pi = instance;
    double *reals = pi->reals, limit = reals[LIMIT];
    (void)t, (void)no_going_back;
    for (int axis = 0; axis < (pi->booleans[CONTROL_HEAVE] ? 3 : 2); axis++) {
        double error = reals[ERROR_X + axis]; /* m: forward, starboard, down */
        double change = pi->booleans[TARGET_VISIBLE] ? reals[KI] * error * dt : 0.0;
        double wanted = reals[KP] * error + pi->integral[axis] + change;
        double given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
        /* anti-windup: at the limit the integral may only move back inside */
        if (given == wanted || (wanted - given) * change < 0.0) pi->integral[axis] += change;
        reals[SURGE + axis] = given; /* m/s */
    }
    return OK;
}

#include "fmi2.h" /* what is part of every FMU, for this model */
