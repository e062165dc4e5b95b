#ifndef RTW_HEADER_pi_types_h_
#define RTW_HEADER_pi_types_h_

/* Parameters (default storage) */
typedef struct P_pi_T_ P_pi_T;

#endif
