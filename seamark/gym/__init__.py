"""Gymnasium environments: one per benchmark version, see docs/training.md.

Importing this package registers them. It needs the extra `gym`.
"""

import gymnasium

from seamark.gym.drawn import randomisation as randomisation
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark

_ENTRY_POINTS = {  # role of what takes part -> single and vectorised environment; detectors are
    # trained on images (`seamark dataset`), and have none
    "controller": (
        "seamark.gym.station_keeping:StationKeepingEnv",
        "seamark.gym.vector:StationKeepingVectorEnv",
    ),
    "tracker": ("seamark.gym.visual_tracking:VisualTrackingEnv", None),
}
BENCHMARKS = {
    benchmark.gym_id: benchmark.name
    for benchmark in map(registry.benchmark, registry.BENCHMARKS)
    if benchmark.role in _ENTRY_POINTS
}
_INTERVENTIONS = ("seamark.gym.intervention:InterventionEnv", None)
_DOCKS = ("seamark.gym.docking:DockingEnv", None)
_ROUTES = ("seamark.gym.following:FollowingEnv", None)


def _entry_points(benchmark: Benchmark) -> tuple[str, str | None]:
    if benchmark.moves_arm:
        return _INTERVENTIONS
    if benchmark.enters_dock:
        return _DOCKS
    return _ROUTES if benchmark.follows_route else _ENTRY_POINTS[benchmark.role]


def _register() -> None:
    """Register the environments; loads neither Numba nor OpenCV."""
    for gym_id, name in BENCHMARKS.items():
        benchmark = registry.benchmark(name)
        single, vectorised = _entry_points(benchmark)
        gymnasium.register(
            gym_id,
            entry_point=single,
            vector_entry_point=vectorised,
            kwargs={"benchmark": name},
        )


_register()
