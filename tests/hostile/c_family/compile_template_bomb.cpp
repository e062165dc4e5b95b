#include "seamark.h"

template <int N, int M> struct Bomb {
    static constexpr long value = Bomb<N - 1, 2 * M>::value + Bomb<N - 1, 2 * M + 1>::value;
};
template <int M> struct Bomb<0, M> { static constexpr long value = M; };
long boom = Bomb<26, 0>::value;

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    command->surge = observation->error[0];
    return 0;
}
