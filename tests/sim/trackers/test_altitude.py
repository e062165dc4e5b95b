"""The published finding in the whole chain: a changing altitude loses the translation warp."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.windows import lost
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark

# A vehicle that is a little buoyant and whose depth nothing holds: it rises while it keeps station.
RISING: Mapping[str, Any] = {
    "vehicle": "girona500",
    "velocity_law": "paper",
    "depth_hold": False,
    "heading_hold": False,
    "control_heave": True,
    "range_from": "size",
    "level_out_tilt": False,
    "levels": (0.0,),
    "level_duration_s": 30.0,
    "settle_s": 10.0,
}


def rows_with(warp: str) -> Rows:
    config = benchmark("currents-v1").read({**RISING, "warp": warp})
    rows: list[Rows] = []
    run_trial("currents-v1", config, BuiltIn("pi", config), seed=1, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def test_a_changing_altitude_loses_the_translation_warp() -> None:
    rows = rows_with("translation")

    assert np.ptp(rows[:, INDEX["z"]]) > 0.5
    assert lost(rows).any()


@pytest.mark.parametrize("warp", ["srt", "affine", "homography"])
def test_warps_with_a_scale_hold_the_target_at_any_altitude(warp: str) -> None:
    rows = rows_with(warp)

    assert not lost(rows).any()
    assert np.nanmax(rows[:, INDEX["tracker_error"]]) < 2.0
