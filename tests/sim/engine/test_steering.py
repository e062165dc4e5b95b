"""A control step's end in one compiled call moves the vehicle as its parts do one by one."""

import math
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.engine.closed_loop import ClosedLoop, StateInvalid
from seamark.sim.engine.program import Command
from seamark.sim.recording.telemetry import INDEX, STEP_US

SETTINGS = {"tracker": "truth", "levels": [0.3], "level_duration_s": 20.0, "contact": True}


class _Sinking:
    """Goes down until the vehicle lies on the bottom, and turns."""

    def __init__(self, *, last: float = 0.4) -> None:
        self._last, self._step = last, 0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing."""

    def step(self, values: NDArray[np.float64]) -> Command:
        self._step += 1
        return (0.1, -0.1, 0.4 if self._step < 50 else self._last, 0.2)


def _rows(program: _Sinking) -> NDArray[np.float64]:
    benchmark = registry.benchmark("currents-v3")
    config = benchmark.read(SETTINGS)
    loop = benchmark.load().level(config, program, seed=3, trial=0, level=0)
    rows: list[NDArray[np.float64]] = []
    try:
        loop.run(rows.append)
    finally:
        loop.close()
    return np.delete(np.concatenate(rows), STEP_US, axis=1)


def test_one_call_moves_a_vehicle_as_its_parts_do_in_the_water_and_on_the_bottom(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    together = _rows(_Sinking())
    monkeypatch.setattr(ClosedLoop, "_steers", lambda _loop: None)
    apart = _rows(_Sinking())

    assert (together[:, INDEX["contact_n"]] > 0.0).any()
    np.testing.assert_array_equal(together, apart)


def test_a_command_that_is_no_number_ends_the_level_before_anything_moves() -> None:
    with pytest.raises(StateInvalid, match="thrusters' command is no longer"):
        _rows(_Sinking(last=math.nan))
