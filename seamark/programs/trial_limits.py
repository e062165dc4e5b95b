"""The sandbox limits of one trial: the same object for worker, form and documentation."""

from seamark.sandbox.limits import Limits

_BASE = Limits()
CHECK = Limits(cpu_s=20.0, wall_s=60.0)  # of a check, which simulates two seconds
CPU_PER_SIMULATED_S = 0.1  # [s/s] 5 ms for each of the 20 steps of a simulated second
WALL_PER_SIMULATED_S = 0.2  # [s/s] counts while the simulator waits for the program


def for_trial(duration_s: float) -> Limits:
    """Return the limits for a trial of `duration_s` simulated seconds."""
    return Limits(
        cpu_s=_BASE.cpu_s + CPU_PER_SIMULATED_S * duration_s,
        wall_s=_BASE.wall_s + WALL_PER_SIMULATED_S * duration_s,
    )
