"""Gusts, DVL and visibility against published measurements."""

from pathlib import Path

import numpy as np

from performance.validation.markdown import table
from performance.validation.published import A50, HEADER, KIM, THOMSON, ZANEVELD, Comparison
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics.current import Current
from seamark.sim.registry import benchmark

TITLE = "Gusts, DVL and visibility"
# Turbulence intensity: standard deviation of the speed over its mean.
TIDAL_CHANNELS_PERCENT = 10.0  # typical of two sites
SLOW_WATER_PERCENT = 50.0  # at 0.2 m/s near the bottom
DVL_MM_S = 1.0  # long-term accuracy
SIGHTING_DEPTHS = (4.6, 4.8)  # optical depth at which a diver loses a black target
LEVEL_M_S = 0.4
HOUR_S = 3600.0
SEEDS = (1, 2, 3)
HALF_PERCENT = 50.0


def turbulence_percent() -> float:
    """Return the standard deviation of our current's speed over its mean [%], from ten hours."""
    speeds = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        current = Current(LEVEL_M_S, rng=rng, duration_s=HOUR_S)
        at = np.arange(0.0, HOUR_S, 1.0)
        speeds += [float(np.linalg.norm(current.velocity(float(t)))) for t in at]
    return 100.0 * float(np.std(speeds) / np.mean(speeds))


def half_success_depth() -> float:
    """Return the optical depth at which p@5 of the default tracker falls to 50 %.

    Mean over the seeds, interpolated between the last level above and the next one.
    """
    entry = benchmark("visibility-v1")
    config, experiment = entry.read({}), entry.load()
    curves = []
    for seed in SEEDS:
        tracker = experiment.built_in("built-in", config)
        result = run_trial(
            entry.name, config, tracker, seed=seed, trial=0, on_rows=lambda _rows: None
        )
        curves.append([float(level["p5_percent"]) for level in result.levels])
    success = np.mean(curves, axis=0)
    depths = np.array([float(level["value"]) for level in result.levels])
    last = int(np.flatnonzero(success >= HALF_PERCENT)[-1])
    share = (success[last] - HALF_PERCENT) / (success[last] - success[last + 1])
    return float(depths[last] + share * (depths[last + 1] - depths[last]))


def comparisons() -> list[Comparison]:
    """Return all comparisons of this section."""
    bias_mm_s = 1e3 * float(benchmark("currents-v1").read({}).model_dump()["dvl_bias_m_s"])
    gusts, depth = turbulence_percent(), half_success_depth()
    intensity, lost = "turbulence intensity", "optical depth at which the target is lost"
    return [
        Comparison(f"{intensity}, tidal channels", gusts, TIDAL_CHANNELS_PERCENT, "%", THOMSON),
        Comparison(f"{intensity}, slow water", gusts, SLOW_WATER_PERCENT, "%", KIM),
        Comparison("DVL bias", bias_mm_s, DVL_MM_S, "mm/s", A50),
        *(Comparison(lost, depth, limit, "", ZANEVELD) for limit in SIGHTING_DEPTHS),
    ]


def section(_names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    found = comparisons()
    gusts, depth = found[0], found[-1]
    return "\n\n".join(
        [
            f"The water of `currents-v1` is calmer than the sea: its gusts are "
            f"{gusts.ours / gusts.measured:.1f} times those of two tidal channels, and water as "
            "slow as that of the benchmark is more turbulent still. Its DVL has no bias. The "
            f"default tracker loses the box at an optical depth of {depth.ours:.1f}; a diver loses "
            "a large black target at 4.6 to 4.8.",
            table(HEADER, [c.cells() for c in found]),
            "These are comparisons of magnitudes, since the set-ups differ. The DVL's figure is "
            "its long-term accuracy. The diver judges by eye whether a target is there, the "
            "tracker has to place its corners within 5 px and has a target of 85 x 27 px to "
            "average over.",
            f"Method: speed of the water each second over ten hours at {LEVEL_M_S:g} m/s; p@5 of "
            f"`visibility-v1` with its defaults, mean over seeds {', '.join(map(str, SEEDS))}, "
            f"interpolated where it falls below {HALF_PERCENT:g} %.",
        ]
    )
