"""What differs in the processes of a service that find this folder on their PYTHONPATH."""

import argon2

from seamark.sim import registry


class QuickHasher(argon2.PasswordHasher):
    """Hashes a password for next to nothing, where the real one takes a sixth of a second.

    As in the process of the tests; theirs about passwords hash as the service does.
    """

    def __init__(self) -> None:
        super().__init__(time_cost=1, memory_cost=8, parallelism=1)


argon2.PasswordHasher = QuickHasher  # type: ignore[assignment, misc]
registry.BENCHMARKS["currents-v1"] = "two_trials:BENCHMARK"
