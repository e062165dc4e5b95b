#include "seamark.h"
int seamark_step(seamark_command*, int) { return 0; }
