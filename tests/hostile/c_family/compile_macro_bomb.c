#include "seamark.h"
#define A(x) x x x x x x x x
#define B(x) A(A(A(A(A(A(A(A(A(x)))))))))
int many[] = {B(1,)};

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
