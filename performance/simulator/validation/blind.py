"""Does a benchmark of position controllers need the camera? Blind dead reckoning beside PI."""

from functools import partial
from pathlib import Path
from typing import Any

from performance.statistics.adversaries import measured
from performance.tables import markdown_table
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.statistics import mean
from seamark.sim.registry import benchmark

TITLE = "Blind dead reckoning"
TRIALS = {"currents-v1": 3, "currents-v2": 8}
ENTRIES = {"nothing": "nothing", "blind": "blind", "PI": "pi", "oracle": "oracle"}
SEED = 1001
BIASES_MM_S = (0.0, 5.0, 20.0)
BIAS_TRIALS = 2


def biased_score(controller: str, bias_mm_s: float) -> float:
    """Return the mean score in currents-v1 with a bias of the DVL on every axis [mm/s]."""
    config = benchmark("currents-v1").read({"dvl_bias_m_s": bias_mm_s / 1e3})
    scores = [
        run_trial(
            "currents-v1",
            config,
            BuiltIn(controller, config),
            seed=SEED,
            trial=trial,
            on_rows=lambda _rows: None,
        ).score
        for trial in range(BIAS_TRIALS)
    ]
    return mean(scores)


def _cell(summary: dict[str, Any]) -> str:
    low, high = summary["score_low"], summary["score_high"]
    return f"{summary['score']:.3g} ({low:.3g} to {high:.3g})"


def section(_names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    rows = []
    for name, trials in TRIALS.items():
        entry = benchmark(name)
        cells = [
            _cell(measured(entry, partial(entry.load().built_in, key), trials=trials, seed=SEED))
            for key in ENTRIES.values()
        ]
        rows.append((name, entry.headline.unit, *cells))
    biased = [
        (f"{bias:g}", *(f"{biased_score(entry, bias):.1f}" for entry in ("blind", "pi")))
        for bias in BIASES_MM_S
    ]
    return "\n\n".join(
        [
            "In `currents-v1` a controller that integrates the DVL's velocity and never uses the "
            "camera beats PI: the DVL has no bias. In `currents-v2` it has one, the start is off "
            "the station, and blind control fails. Mean score with 95 % interval:",
            markdown_table(("benchmark", "unit", *ENTRIES), rows),
            "Score in `currents-v1` with a bias of the DVL on every axis:",
            markdown_table(("bias mm/s", "blind", "PI"), biased),
            f"Method: ranked scenarios, seed {SEED}, "
            f"{' and '.join(map(str, TRIALS.values()))} trials (with bias {BIAS_TRIALS}), "
            "built-in entries of `sim/control/position`.",
        ]
    )
