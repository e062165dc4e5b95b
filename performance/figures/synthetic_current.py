"""Write the synthetic record of a ria that is shipped: `./run performance synthetic_current`.

Nothing in it was measured. Its constituents are invented, of the size of a semidiurnal ria's; its
profile is a power law that turns a little with height, and slow eddies are added: sinusoids with
periods of 3 to 30 minutes, which are the same at all heights.
"""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from seamark.current_data.picture import picture
from seamark.current_data.tides import Constituent, predicted
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.record import Record, write_record

NAME = "synthetic-ria"
FIGURE = "docs/figures/synthetic-ria.svg"
HEIGHTS = (1.0, 2.0, 3.0, 4.0, 6.0)  # [m]
HOURS, STEP_S = 12.5, 120.0
CONSTITUENTS = [
    Constituent("Z0", 0.04, 0.0, 0.0, 0.0, 250.0),
    Constituent("M2", 0.46, 70.0, 0.03, 340.0, 65.0),
    Constituent("S2", 0.16, 100.0, 0.01, 10.0, 66.0),
    Constituent("N2", 0.09, 50.0, 0.01, 320.0, 64.0),
    Constituent("M4", 0.05, 200.0, 0.01, 110.0, 60.0),
]
EXPONENT, VEER_RAD_M = 1.0 / 7.0, 0.02
EDDIES, EDDY_M_S = 12, 0.03
NOTES = {
    "title": "Synthetic ria: invented, not measured",
    "begins": "2026-05-02T00:00:00+00:00",
    "licence": "Apache-2.0, as Seamark; made by ./run performance synthetic_current",
}


def synthetic() -> Record:
    """Return the record."""
    begin = datetime.fromisoformat(NOTES["begins"]).astimezone(UTC)
    tide = predicted(
        CONSTITUENTS, begin=begin, hours=HOURS, latitude_deg=43.0, height_m=2.0, step_s=STEP_S
    )
    rng = streams(2026, 0, 0).record
    rates = 2.0 * np.pi / (60.0 * rng.uniform(3.0, 30.0, EDDIES))
    phases = rng.uniform(0.0, 2.0 * np.pi, (3, EDDIES))
    size = EDDY_M_S * np.sqrt(2.0 / EDDIES)
    angle = rates[:, None] * tide.times
    eddies = np.array([size * np.cos(angle + one[:, None]).sum(axis=0) for one in phases])
    eddies[2] *= 0.1
    rows = []
    for height in HEIGHTS:
        share, turn = (height / 2.0) ** EXPONENT, VEER_RAD_M * (height - 2.0)
        north, east, down = tide.velocity[0]
        rows.append(
            [
                share * (np.cos(turn) * north - np.sin(turn) * east) + eddies[0],
                share * (np.sin(turn) * north + np.cos(turn) * east) + eddies[1],
                down + eddies[2],
            ]
        )
    return Record(STEP_S, np.array(HEIGHTS), np.array(rows), NOTES)


def main(_arguments: Sequence[str]) -> int:
    """Write the record and its picture."""
    made = synthetic()
    (records.FOLDER / f"{NAME}{records.SUFFIX}").write_bytes(write_record(made))
    Path(FIGURE).write_text(picture(made), encoding="utf-8")
    return 0
