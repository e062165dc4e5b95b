#include "pi.h"
#include <string.h>

DW_pi_T pi_DW;
ExtU_pi_T pi_U;
ExtY_pi_T pi_Y;

/* Model step function */
void pi_step(void)
{
  int axis;
  real_T limit = pi_U.reference_limit_m_s;
  for (axis = 0; axis < (pi_P.control_heave != 0.0 ? 3 : 2); axis++) {
    real_T error = pi_U.error[axis];
    real_T change = pi_U.target_visible ? pi_P.ki * error * pi_U.dt : 0.0;
    real_T wanted = pi_P.kp * error + pi_DW.integral[axis] + change;
    real_T given = wanted < -limit ? -limit : wanted > limit ? limit : wanted;
    if (given == wanted || (wanted - given) * change < 0.0) {
      pi_DW.integral[axis] += change;
    }
    pi_Y.command[axis] = given;
  }
}

/* Model initialize function */
void pi_initialize(void)
{
  (void) memset((void *)&pi_DW, 0, sizeof(DW_pi_T));
}

/* Model terminate function */
void pi_terminate(void)
{
}
