"""The limits of one trial's box: the same object for the worker, the form and the documentation."""

from seamark.sandbox.limits import Limits

_BASE = Limits()
CHECK = Limits(cpu_s=20.0, wall_s=60.0)  # of the box of a check, which simulates two seconds
CPU_PER_SIMULATED_S = 0.1  # [s/s] 5 ms for each of 20 answers per simulated second
WALL_PER_SIMULATED_S = 0.2  # [s/s] only the time in which the simulator waits counts


def for_trial(duration_s: float) -> Limits:
    """Return the limits for a trial of `duration_s` simulated seconds."""
    return Limits(
        cpu_s=_BASE.cpu_s + CPU_PER_SIMULATED_S * duration_s,
        wall_s=_BASE.wall_s + WALL_PER_SIMULATED_S * duration_s,
    )
