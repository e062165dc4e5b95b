#include "fmu.h"
#include "/etc/shadow"
