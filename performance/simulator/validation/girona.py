"""P and PI on the realistic vehicle: the same task with a physical current, several seeds."""

from pathlib import Path

from performance.simulator.validation.trials import configured, trial
from performance.tables import markdown_table
from seamark.sim.numerics.statistics import mean

TITLE = "P and PI on the realistic vehicle"
VEHICLE = "girona500"
SEEDS = (1, 2, 3)


def section(_names: list[str], _figures: Path) -> str:
    """Return the section's text."""
    speeds = configured(vehicle=VEHICLE).levels
    rows, scores = [], {}
    for law in ("p", "pi"):
        results = [trial(law, seed=seed, vehicle=VEHICLE).result for seed in SEEDS]
        scores[law] = [result.score for result in results]
        for level, speed in enumerate(speeds):
            levels = [result.levels[level] for result in results]
            cells = [
                f"{mean([float(m[name]) for m in levels]):.{digits}f}"
                for name, digits in (("rmse_m", 3), ("max_m", 3), ("rmse_px", 1))
            ]
            spread = [float(m["rmse_m"]) for m in levels]
            cells.append(f"{min(spread):.3f} to {max(spread):.3f}")
            cells.append(f"{sum(bool(m['held']) for m in levels)} of {len(SEEDS)}")
            rows.append((law.upper(), f"{speed:g}", *cells))
    header = (
        *("controller", "level m/s", "RMSE m", "largest m", "RMSE px"),
        *("RMSE m over the seeds", "held"),
    )
    score_text = "; ".join(
        f"{law.upper()} {mean(values):.1f} ({min(values):.1f} to {max(values):.1f})"
        for law, values in scores.items()
    )
    return "\n\n".join(
        [
            f"Score out of 100, mean and range over the seeds: {score_text}.",
            f"Method: `currents-v1` with its defaults on `{VEHICLE}` (head current as relative "
            "velocity, gusts, depth and heading hold, tracker `esm`), built-in gains, seeds "
            f"{', '.join(map(str, SEEDS))}, trial 0; means over the seeds for each level after its "
            "settle window. There is no published counterpart; this shows how the published "
            "controllers perform in a physically consistent current.",
            markdown_table(header, rows),
        ]
    )
