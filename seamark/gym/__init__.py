"""Gymnasium environments: one per benchmark version, see docs/training.md.

Importing this package registers them. It needs the extra `gym`.
"""

import gymnasium

from seamark.sim import registry

BENCHMARKS = {registry.benchmark(name).gym_id: name for name in registry.BENCHMARKS}
_ENTRY_POINTS = {  # role of what takes part -> single and vectorised environment
    "controller": (
        "seamark.gym.station_keeping:StationKeepingEnv",
        "seamark.gym.vector:StationKeepingVectorEnv",
    ),
    "tracker": ("seamark.gym.visual_tracking:VisualTrackingEnv", None),
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
