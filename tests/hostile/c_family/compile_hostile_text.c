#include "seamark.h"
#error "[2J<script>alert(1)</script> {{ 7*7 }}"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
