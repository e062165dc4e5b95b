/* As self_test.c, with the standard library of C++, which must be there too. */
#include <vector>

#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    const std::vector<double> error(observation->error, observation->error + 3);
    command->surge = 0.5 * error.at(0);
    command->sway = 0.5 * error.at(1);
    command->heave = 0.5 * error.at(2);
    return 0;
}

static std::vector<double> at_start;

int seamark_tracker_start(const seamark_image *, const double corners[8]) {
    at_start.assign(corners, corners + 8);
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    for (int i = 0; i < 8; i++) corners[i] = at_start.at(i) + image->pixels[image->width];
    return 1;
}
