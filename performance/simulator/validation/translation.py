"""The translation warp under changing altitude."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from performance.plots import COLOURS, figure
from performance.simulator.validation.trials import PAPER_VEHICLE, configured, trial
from performance.tables import markdown_table
from seamark.sim.metrics.windows import lost
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.vehicles import load

# The original scene and programs with a slightly buoyant vehicle: P and PI also control the height,
# which they estimate from the target's size alone; there is no depth hold.
UNHELD: Mapping[str, Any] = {
    "velocity_law": "paper",
    "depth_hold": False,
    "heading_hold": False,
    "control_heave": True,
    "range_from": "size",
    "level_out_tilt": False,
    "water_law": "uwsim",
    "water_type": "grey",
    "water_attenuation_1_m": 0.1,
    "levels": (0.0,),
    "level_duration_s": 30.0,  # longer, and the vehicle would leave the water
    "settle_s": 10.0,
}
BUOYANT = "girona500"
WARPS = ("translation", "rt", "srt", "affine", "homography")


class Outcome(NamedTuple):
    """How well one warp tracked the target in one trial."""

    warp: str
    rows: Rows
    lost_at_s: float | None
    worst_px: float

    @property
    def risen_m(self) -> float:
        """Return the height gained by the vehicle."""
        z = self.rows[:, INDEX["z"]]
        return float(z[0] - z[-1])


def outcome(warp: str, **values: Any) -> Outcome:
    """Return the outcome of a trial with PI and one warp."""
    rows = trial("pi", warp=warp, **values).rows
    when = rows[lost(rows), INDEX["t"]]
    worst = float(np.nanmax(rows[:, INDEX["tracker_error"]]))
    return Outcome(warp, rows, float(when[0]) if len(when) else None, worst)


def draw(outcomes: list[Outcome], out: Path) -> None:
    """Write the plot of tracker error and height gained."""
    with figure(out, rows=2, height=5.0) as (error, height):
        for colour, entry in zip(COLOURS, outcomes, strict=False):
            t, z = entry.rows[:, INDEX["t"]], entry.rows[:, INDEX["z"]]
            error.plot(t, entry.rows[:, INDEX["tracker_error"]], color=colour, label=entry.warp)
            height.plot(t, z[0] - z, color=colour, label=entry.warp)
        error.set_ylabel("tracker error [px]")
        height.set_ylabel("height gained [m]")
        height.set_xlabel("time [s]")
        error.legend()


def text(figures: Path) -> str:
    """Write the plot and return the text of the finding."""
    neutral = outcome("translation", vehicle=PAPER_VEHICLE)
    outcomes = [outcome(warp, vehicle=BUOYANT, **UNHELD) for warp in WARPS]
    draw([outcomes[0], outcomes[-1]], figures / "translation.png")
    vehicle = load(BUOYANT)
    net = vehicle.buoyancy.scalar - vehicle.weight.scalar
    rows = [
        (o.warp, _when(o.lost_at_s), f"{o.worst_px:.2f}", f"{o.risen_m:.2f}", _scale(o))
        for o in outcomes
    ]
    return "\n\n".join(
        [
            f"On the unmodified `{PAPER_VEHICLE}` the warp does **not** lose the target: the "
            "vehicle is neutrally buoyant, so its depth changes by "
            f"{100.0 * abs(neutral.risen_m):.1f} cm over the five levels and there is no change "
            f"of scale to follow (largest error {neutral.worst_px:.2f} px, "
            f"lost: {_when(neutral.lost_at_s)}).",
            f"The published loss appears as soon as the vehicle is not exactly neutral. With "
            f"`{BUOYANT}` ({net:.0f} N more buoyancy than weight), the paper's velocity law, no "
            "depth hold, and a PI that controls the height estimated from the target's size, as "
            "the original programs do, the translation warp loses the target after "
            f"{_when(outcomes[0].lost_at_s)}. Its template has a fixed size, so it reports the "
            "right height while the vehicle rises; a warp with scale reports the change, and PI "
            "brings the vehicle back:",
            markdown_table(
                ("warp", "target lost after", "largest error px", "height gained m", "final scale"),
                rows,
            ),
            f"Method: PI, seed 1, still water, {UNHELD['level_duration_s']:g} s, `lost` as the "
            "benchmark counts it (the tracker reports it, or its corners are 15 px off).",
            "![Translation and homography on a rising vehicle](figures/translation.png)",
        ]
    )


def _when(at_s: float | None) -> str:
    return "never" if at_s is None else f"{at_s:.1f} s"


def _scale(entry: Outcome) -> str:
    """Return the final size of the target in the image as a share of its initial size."""
    altitude = configured(vehicle=BUOYANT).altitude_m
    return f"{altitude / (altitude + entry.risen_m):.2f}"
