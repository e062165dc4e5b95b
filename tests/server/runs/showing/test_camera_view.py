"""Pictures made again from telemetry."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing import camera_view
from seamark.sim import registry
from seamark.sim.benchmarks.station_keeping.experiment import EXPERIMENT
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX
from tests.cast import Backend

CONFIG = {"levels": [0.1, 0.2], "level_duration_s": 4.0, "settle_s": 1.0}
SEED = 11


@pytest.fixture
def recorded(backend: Backend) -> int:
    """A run of two short levels, with its telemetry."""
    claim = backend.running("ann", config=CONFIG, controller="p", seed=SEED)
    files = RunFiles(backend.settings.data, claim.run_id, claim.attempt)
    config = registry.benchmark("currents-v1").read(claim.config)
    program = BuiltIn("p", config)
    run_trial("currents-v1", config, program, seed=SEED, trial=0, on_rows=files.append_rows)
    return claim.run_id


def _decoded(jpeg: bytes | None) -> NDArray[Any]:
    assert jpeg is not None
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return image


def test_the_camera_view_shows_what_the_tracker_saw(backend: Backend, recorded: int) -> None:
    run = backend.show(recorded)
    config: Any = registry.benchmark("currents-v1").read(run.config)
    world = EXPERIMENT.world(config, seed=SEED, trial=0, level=1)
    row = RunFiles(backend.settings.data, recorded).rows(120, 121)[0]
    seen = world.camera.colour(row[INDEX["x"] : INDEX["yaw"] + 1].copy(), 80 + 40)

    shown = _decoded(camera_view.render(backend.settings, run, trial=0, t=6.0))

    corner = (slice(0, 150), slice(0, 150))  # no box is drawn here; JPEG changes a little
    assert np.abs(shown[corner].astype(int) - seen[corner].astype(int)).mean() < 3.0


def test_the_box_of_the_tracker_is_green(backend: Backend, recorded: int) -> None:
    shown = _decoded(camera_view.render(backend.settings, backend.show(recorded), trial=0, t=2.0))

    blue, green, red = (shown[:, :, channel].astype(int) for channel in range(3))
    assert np.count_nonzero((green > 150) & (green > red + 60) & (green > blue + 60)) > 100


def test_the_same_time_gives_the_same_bytes(backend: Backend, recorded: int) -> None:
    run = backend.show(recorded)

    first, second = (camera_view.render(backend.settings, run, trial=0, t=3.3) for _ in range(2))

    assert first == second


def test_a_time_after_the_end_gives_the_last_image(backend: Backend, recorded: int) -> None:
    run = backend.show(recorded)

    last, beyond = (camera_view.render(backend.settings, run, trial=0, t=t) for t in (7.95, 1e6))

    assert last == beyond


def test_a_trial_without_telemetry_has_no_camera_view(backend: Backend, recorded: int) -> None:
    assert camera_view.render(backend.settings, backend.show(recorded), trial=1, t=0.0) is None
    assert (
        camera_view.render(backend.settings, backend.show(backend.queue("ann")), trial=0, t=0.0)
        is None
    )


def test_an_image_that_many_viewers_ask_for_is_rendered_once(
    backend: Backend, recorded: int
) -> None:
    run = backend.show(recorded)

    first, second = (camera_view.render(backend.settings, run, trial=0, t=4.0) for _ in range(2))

    assert first is second
