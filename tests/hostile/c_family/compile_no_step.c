#include "seamark.h"
int x;
