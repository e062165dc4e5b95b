/* The built-in PI once more, in the layout of generated code. */
#ifndef RTW_HEADER_pi_h_
#define RTW_HEADER_pi_h_
#include "rtwtypes.h"
#include "pi_types.h"

/* Block states (default storage) for system '<Root>' */
typedef struct {
  real_T integral[3];                  /* '<Root>/Integrator' */
} DW_pi_T;

/* External inputs (root inport signals with default storage) */
typedef struct {
  real_T error[3];                     /* '<Root>/error' */
  real_T dt;                           /* '<Root>/dt' */
  boolean_T target_visible;            /* '<Root>/target_visible' */
  real_T reference_limit_m_s;          /* '<Root>/reference_limit_m_s' */
} ExtU_pi_T;

/* External outputs (root outports fed by signals with default storage) */
typedef struct {
  real_T command[4];                   /* '<Root>/command' */
} ExtY_pi_T;

/* Parameters (default storage) */
struct P_pi_T_ {
  real_T kp;                           /* Variable: kp */
  real_T ki;                           /* Variable: ki */
  real_T control_heave;                /* Variable: control_heave */
};

extern P_pi_T pi_P;
extern DW_pi_T pi_DW;
extern ExtU_pi_T pi_U;
extern ExtY_pi_T pi_Y;
extern void pi_initialize(void);
extern void pi_step(void);
extern void pi_terminate(void);

#endif
