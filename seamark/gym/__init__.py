"""Gymnasium environments: one per benchmark version, see docs/training.md.

Importing this package registers them. It needs the extra `gym`.
"""

import gymnasium

from seamark.sim import registry

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


def _register() -> None:
    """Register the environments; loads neither Numba nor OpenCV."""
    for gym_id, name in BENCHMARKS.items():
        benchmark = registry.benchmark(name)
        points = _INTERVENTIONS if benchmark.moves_arm else _ENTRY_POINTS[benchmark.role]
        single, vectorised = points
        gymnasium.register(
            gym_id,
            entry_point=single,
            vector_entry_point=vectorised,
            kwargs={"benchmark": name},
        )


_register()
