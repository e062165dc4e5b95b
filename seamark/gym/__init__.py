"""Gymnasium environments: one per benchmark version, see docs/training.md.

Importing this package registers them. It needs the extra `gym`.
"""

import gymnasium

BENCHMARKS = {  # name in the registry -> benchmark
    "seamark/StationKeeping-v1": "currents-v1",
    "seamark/StationKeeping-v2": "currents-v2",
    "seamark/VisualTracking-v1": "visibility-v1",
    "seamark/VisualTracking-v2": "visibility-v2",
}
_ENTRY_POINTS = {  # name without version -> single and vectorised environment
    "seamark/StationKeeping": (
        "seamark.gym.station_keeping:StationKeepingEnv",
        "seamark.gym.vector:StationKeepingVectorEnv",
    ),
    "seamark/VisualTracking": ("seamark.gym.visual_tracking:VisualTrackingEnv", None),
}


def _register() -> None:
    """Register the environments; loads neither Numba nor OpenCV."""
    for name, benchmark in BENCHMARKS.items():
        single, vectorised = _ENTRY_POINTS[name.partition("-")[0]]
        gymnasium.register(
            name,
            entry_point=single,
            vector_entry_point=vectorised,
            kwargs={"benchmark": benchmark},
        )


_register()
