#include <cstdio>
#include <cstdlib>
#include "seamark.h"
struct Late {
    ~Late() { std::puts("GOT the last word"); }
};
Late late;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
