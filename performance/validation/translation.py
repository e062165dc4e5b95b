"""The translation warp when the altitude changes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from performance.validation.markdown import table
from performance.validation.plots import COLOURS, figure
from performance.validation.trials import PAPER_VEHICLE, configured, trial
from seamark.sim.metrics.station_keeping import lost
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.vehicles import load

# What the original scene and its programs have, on a vehicle that is a little buoyant: P and PI act
# on the height too, which they know from the target's size alone, and nothing else holds the depth.
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


class Fate(NamedTuple):
    """What became of the target in one trial."""

    warp: str
    rows: Rows
    lost_at_s: float | None
    worst_px: float

    @property
    def risen_m(self) -> float:
        """Return how much higher the vehicle ended."""
        z = self.rows[:, INDEX["z"]]
        return float(z[0] - z[-1])


def fate(warp: str, **values: Any) -> Fate:
    """Return what becomes of the target with PI and one warp."""
    rows = trial("pi", warp=warp, **values).rows
    when = rows[lost(rows), INDEX["t"]]
    worst = float(np.nanmax(rows[:, INDEX["tracker_error"]]))
    return Fate(warp, rows, float(when[0]) if len(when) else None, worst)


def draw(fates: list[Fate], out: Path) -> None:
    """Write the plot of the tracker's error and the height gained."""
    with figure(out, rows=2, height=5.0) as (error, height):
        for colour, entry in zip(COLOURS, fates, strict=False):
            t, z = entry.rows[:, INDEX["t"]], entry.rows[:, INDEX["z"]]
            error.plot(t, entry.rows[:, INDEX["tracker_error"]], color=colour, label=entry.warp)
            height.plot(t, z[0] - z, color=colour, label=entry.warp)
        error.set_ylabel("tracker's error [px]")
        height.set_ylabel("height gained [m]")
        height.set_xlabel("time [s]")
        error.legend()


def text(figures: Path) -> str:
    """Write the plot and return the fact's text."""
    neutral = fate("translation", vehicle=PAPER_VEHICLE)
    fates = [fate(warp, vehicle=BUOYANT, **UNHELD) for warp in WARPS]
    draw([fates[0], fates[-1]], figures / "translation.png")
    vehicle = load(BUOYANT)
    net = vehicle.buoyancy.scalar - vehicle.weight.scalar
    rows = [
        (f.warp, _when(f.lost_at_s), f"{f.worst_px:.2f}", f"{f.risen_m:.2f}", _scale(f))
        for f in fates
    ]
    return "\n\n".join(
        [
            f"On `{PAPER_VEHICLE}` as it is, the warp does **not** lose the target: the vehicle is "
            f"neutral, so its depth changes by {100.0 * abs(neutral.risen_m):.1f} cm over the five "
            f"levels and there is no scale to follow (largest error {neutral.worst_px:.2f} px, "
            f"lost: {_when(neutral.lost_at_s)}).",
            f"The published loss comes out as soon as the vehicle is not exactly neutral. With "
            f"`{BUOYANT}` ({net:.0f} N more buoyancy than weight), the paper's velocity law, no "
            "depth hold, and a PI that acts on the height it reads off the target's size, as the "
            "original programs do, translation is "
            f"lost after {_when(fates[0].lost_at_s)}. Its template has one size, so it reports "
            "that the height is right while the vehicle rises; a warp with scale reports the "
            "change, and PI brings the vehicle back:",
            table(
                ("warp", "target lost after", "largest error px", "risen by m", "scale at the end"),
                rows,
            ),
            f"How: PI, seed 1, still water, {UNHELD['level_duration_s']:g} s, `lost` as the "
            "benchmark counts it (the tracker says so, or its corners are 15 px off).",
            "![Translation and homography on a rising vehicle](figures/translation.png)",
        ]
    )


def _when(at_s: float | None) -> str:
    return "never" if at_s is None else f"{at_s:.1f} s"


def _scale(entry: Fate) -> str:
    """Return how large the target ends in the picture, as a share of its size at the start."""
    altitude = configured(vehicle=BUOYANT).altitude_m
    return f"{altitude / (altitude + entry.risen_m):.2f}"
