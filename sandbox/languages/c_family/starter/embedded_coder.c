/* A PI position controller as Embedded Coder generates one: a starting point for your own.
 *
 * What is generated has several files (model.c, model.h, rtwtypes.h ...): upload them as one zip
 * archive, as they are. One file as here does too. Inputs, outputs and parameters are connected by
 * their names.
 */
typedef double real_T;
typedef unsigned char boolean_T;

/* Parameters that the configuration may set (named as its keys) */
struct P_controller_T_ {
    real_T kp;
    real_T ki;
};
typedef struct P_controller_T_ P_controller_T;

/* External inputs (root inports): named as the numbers of an observation */
typedef struct {
    real_T error[3]; /* m: forward, starboard, down */
    real_T dt;       /* s */
    boolean_T target_visible;
} ExtU_controller_T;

/* External outputs (root outports): the command */
typedef struct {
    real_T surge; /* m/s */
    real_T sway;
    real_T heave;
} ExtY_controller_T;

typedef struct {
    real_T integral[3];
} DW_controller_T;

P_controller_T controller_P = {0.5, 0.02};
ExtU_controller_T controller_U;
ExtY_controller_T controller_Y;
static DW_controller_T controller_DW;

/* called at the start of each level, when the vehicle is put back */
void controller_initialize(void) {
    controller_DW.integral[0] = controller_DW.integral[1] = controller_DW.integral[2] = 0.0;
}

static real_T law(int axis) {
    real_T error = controller_U.error[axis];
    real_T speed;
    controller_DW.integral[axis] += error * controller_U.dt;
    speed = controller_P.kp * error + controller_P.ki * controller_DW.integral[axis];
    return speed > 0.6 ? 0.6 : speed < -0.6 ? -0.6 : speed; /* m/s */
}

/* called 20 times per simulated second */
void controller_step(void) {
    controller_Y.surge = controller_U.target_visible ? law(0) : 0.0;
    controller_Y.sway = controller_U.target_visible ? law(1) : 0.0;
    controller_Y.heave = controller_U.target_visible ? law(2) : 0.0;
}

void controller_terminate(void) {}
