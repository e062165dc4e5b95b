#include <chrono>
#include <thread>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    for (int i = 0; i < 200; i++)
        std::thread([] { std::this_thread::sleep_for(std::chrono::seconds(60)); }).detach();
    return 0;
}
