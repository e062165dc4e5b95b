#include "pi.h"

/* The example main program, which is not used. */
int main(int argc, const char *argv[])
{
  (void)argc;
  (void)argv;
  pi_initialize();
  pi_step();
  pi_terminate();
  return 0;
}
