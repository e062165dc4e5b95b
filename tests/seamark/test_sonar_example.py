"""The example that holds station by the sonar does so, and only by the sonar."""

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.control.observation import Images, Observation
from seamark.sim.engine.program import Command
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.sonar.sonar import Sonar

EXAMPLE = Path(__file__).parents[2] / "examples" / "sonar" / "main.py"
SETTINGS = {
    "sonar": "forward",
    "levels": [0.2],
    "level_duration_s": 50.0,  # it has arrived after 40 s
    "vehicle": "girona500",
}


def example(config: Mapping[str, Any]) -> Any:
    spec = importlib.util.spec_from_file_location("sonar_example", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Controller(config)


class Uploaded:
    """The example, as a program that is given images."""

    def __init__(self, config: Any) -> None:
        self._controller = example(config.for_program())
        self._images: Images = {}

    def reset(self, level: Mapping[str, float | int]) -> None:
        self._controller.reset(level)

    def show(self, images: Images) -> None:
        self._images = images

    def step(self, values: NDArray[np.float64]) -> Command:
        seen = Observation(values, None, self._images, route=True)
        return tuple(map(float, self._controller.step(seen)))


def distances() -> NDArray[np.float64]:
    """Return how far the vehicle is from the weight [m], over the last 10 s of a level."""
    config, rows = registry.benchmark("track-v1").read(SETTINGS), []
    program = Uploaded(config.for_trial(0))
    run_trial(
        "track-v1", config, program, seed=1, trial=0, on_rows=lambda part: rows.append(part.copy())
    )
    last: Rows = np.concatenate(rows)[-200:]
    away: NDArray[np.float64] = np.hypot(last[:, INDEX["x"]], last[:, INDEX["y"]])
    return away


@pytest.mark.slow
def test_the_example_holds_its_distance_from_the_weight_in_a_current() -> None:
    held = distances()

    assert held.mean() == pytest.approx(12.0, abs=0.4)  # 13 m along the beam from 5 m above it
    assert np.ptp(held) < 0.6


@pytest.mark.slow
def test_the_example_does_not_hold_it_without_the_images(monkeypatch: pytest.MonkeyPatch) -> None:
    def open_water(sonar: Sonar, *_: object) -> NDArray[np.uint8]:
        return np.zeros((sonar.device.bins, sonar.device.beams), np.uint8)

    monkeypatch.setattr(Sonar, "image", open_water)

    held = distances()

    assert np.ptp(held) > 3.0
