#include "seamark.h"
struct Spin {
    Spin() {
        for (volatile int i = 0;; i = i + 1) {}
    }
};
Spin spin;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
