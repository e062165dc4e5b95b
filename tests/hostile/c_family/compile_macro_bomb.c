#include "seamark.h"
#define A(...) __VA_ARGS__ __VA_ARGS__ __VA_ARGS__ __VA_ARGS__ __VA_ARGS__ __VA_ARGS__ __VA_ARGS__ __VA_ARGS__
#define B A(A(A(A(A(A(A(A(A(1,)))))))))
int many[] = {B};

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
