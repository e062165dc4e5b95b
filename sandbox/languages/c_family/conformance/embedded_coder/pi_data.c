#include "pi.h"

/* Block parameters (default storage) */
P_pi_T pi_P = {
  0.0,
  0.0,
  0.0
};
