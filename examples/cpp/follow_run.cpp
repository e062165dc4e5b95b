// Orders a run of the built-in PI and, if there is a third argument, one of that program; follows
// each to its end and writes its telemetry.
//
//     g++ -std=c++17 -I docs examples/cpp/follow_run.cpp -lcurl -o follow_run
//     ./follow_run https://seamark.example.org TOKEN [PROGRAM]

#include <iostream>

#include "seamark_client.hpp"

namespace {

void follow(const seamark::Client& client, const seamark::Run& submitted) {
    const seamark::Run run = client.wait(submitted.id());
    std::cout << "run " << run.id() << " " << run.state();
    if (run.has_score()) std::cout << ", score " << run.score();
    std::cout << std::endl;
    client.download(run.id(), "telemetry.csv", "run-" + std::to_string(run.id()) + ".csv");
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 3) {
        std::cerr << "usage: follow_run ADDRESS TOKEN [PROGRAM]\n";
        return 2;
    }
    curl_global_init(CURL_GLOBAL_DEFAULT);
    const seamark::Client client(arguments[1], arguments[2]);
    const seamark::Json config = {{"levels", {0.1}}, {"level_duration_s", 5}, {"settle_s", 1}};
    seamark::Json specification = {{"benchmark", "currents-v1"}, {"config", config}, {"seed", 7}};
    try {
        if (count > 3) follow(client, client.submit(specification, arguments[3]));
        specification["controller"] = "pi";
        follow(client, client.submit(specification));
        specification["seed"] = -1;
        client.submit(specification);
    } catch (const seamark::Refused& refused) {
        std::cout << "refused " << refused.status << ": " << refused.what() << std::endl;
        return 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << std::endl;
        return 1;
    }
    return 1;
}
