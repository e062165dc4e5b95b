"""What C and C++ share: header, runner, the script inside both boxes, and the host's compiler."""

from seamark.sandbox.languages.language import Calls

CALLS = Calls("The program (constructors and seamark_init)", "seamark_reset", "seamark_step")

GCC = ("gcc", "libc6-dev")  # packages of Debian; the headers are only recommended by gcc

ROLES = ("controller", "tracker", "detector")

SELF_TEST = """\
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = 0.5 * observation->error[0];
    command->sway = 0.5 * observation->error[1];
    command->heave = 0.5 * observation->error[2];
    return 0;
}

static double before[8];

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    for (int i = 0; i < 8; i++) before[i] = corners[i];
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    for (int i = 0; i < 8; i++) corners[i] = before[i] + image->pixels[image->width];
    return 1;
}
"""
