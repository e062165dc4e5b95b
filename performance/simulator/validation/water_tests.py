"""Gusts, DVL and visibility against published measurements."""

from pathlib import Path

import numpy as np

from performance.simulator.validation.published import A50, HEADER, KIM, TIDE, ZANEVELD, Comparison
from performance.tables import markdown_table
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark

TITLE = "Gusts, DVL and visibility"
# Turbulence intensity: standard deviation of the speed over its mean.
CHANNELS_PERCENT = 10.0  # typical of two sites
SLOW_PERCENT = 50.0  # at 0.2 m/s near the bottom
DVL_MM_S = 1.0  # long-term accuracy
SIGHTING_DEPTHS = (4.6, 4.8)  # optical depth at which a diver loses a black target
BENCHMARKS = ("currents-v1", "currents-v2")
TRIALS = 4
SEEDS = (1, 2, 3)
HALF_PERCENT = 50.0


def turbulence_percent(name: str) -> float:
    """Return the standard deviation of the current's speed over its mean [%], in a benchmark.

    Mean over the levels with a current and the trials.
    """
    entry = benchmark(name)
    config, rows, intensities = entry.read({}), list[Rows](), []
    for trial in range(TRIALS):
        rows.clear()
        program = BuiltIn("nothing", config.for_trial(trial))
        run_trial(name, config, program, seed=SEEDS[0], trial=trial, on_rows=rows.append)
        telemetry = np.concatenate(rows)
        speed = np.hypot(telemetry[:, INDEX["current_x"]], telemetry[:, INDEX["current_y"]])
        for level in np.unique(telemetry[:, INDEX["level"]]):
            mine = speed[telemetry[:, INDEX["level"]] == level]
            if mine.mean() > 0.0:
                intensities.append(float(mine.std() / mine.mean()))
    return 100.0 * float(np.mean(intensities))


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


def dvl_bias_mm_s(name: str) -> float:
    """Return the mean size of the DVL's bias on an axis in a benchmark [mm/s]."""
    settings = benchmark(name).read({}).model_dump()
    # Drawn evenly between half of the spread and the whole (sim/settings/trial_spreads.py).
    drawn = 0.75 * float(settings.get("dvl_bias_spread_m_s", 0.0))
    return 1e3 * (abs(float(settings["dvl_bias_m_s"])) + drawn)


def comparisons() -> list[Comparison]:
    """Return all comparisons of this section."""
    quantities = []
    for name in BENCHMARKS:
        gusts = turbulence_percent(name)
        quantities += [
            Comparison(
                f"{name}: turbulence, of tidal channels", gusts, CHANNELS_PERCENT, "%", TIDE
            ),
            Comparison(f"{name}: turbulence, of slow water", gusts, SLOW_PERCENT, "%", KIM),
            Comparison(f"{name}: DVL bias", dvl_bias_mm_s(name), DVL_MM_S, "mm/s", A50),
        ]
    depth = half_success_depth()
    what = "optical depth at which the target is lost"
    return quantities + [Comparison(what, depth, limit, "", ZANEVELD) for limit in SIGHTING_DEPTHS]


def section(_names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    quantities = comparisons()
    return "\n\n".join(
        [
            "The water of both benchmarks is calmer than measured tidal currents, and real water "
            "at these speeds is even more turbulent. The DVL of `currents-v1` has no bias. That "
            "of `currents-v2` has several times the long-term accuracy that the manufacturer of a "
            "small DVL states, so there the benchmark is harder than reality. The default tracker "
            "loses "
            f"the box at an optical depth of {quantities[-1].ours:.1f}; a diver loses a large "
            "black target at 4.6 to 4.8.",
            markdown_table(HEADER, [c.cells() for c in quantities]),
            "These comparisons only show magnitudes, because the set-ups differ. Turbulence "
            "intensity "
            "is the standard deviation of the speed over its mean; ours includes the waves of the "
            "speed and, in `currents-v2`, its lasting changes. The diver judges by eye whether a "
            "target is there. The tracker has to find its corners within 5 px, and has a target "
            "of 85 x 27 px to average over.",
            f"Method: the current of every control step of {TRIALS} trials with the benchmarks' "
            "defaults, mean over levels and trials; p@5 of `visibility-v1`, mean over seeds "
            f"{', '.join(map(str, SEEDS))}, interpolated where it falls below {HALF_PERCENT:g} %.",
        ]
    )
