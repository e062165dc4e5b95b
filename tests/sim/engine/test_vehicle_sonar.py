"""The sonar of a vehicle: what programs get, when, and that runs without one stay as they were."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.benchmarks.reference_results import configuration_digest, of_benchmark
from seamark.sim.camera.target import Target
from seamark.sim.control.observation import SONAR, Images, Observation
from seamark.sim.engine.program import Command
from seamark.sim.engine.replay import NoSonar, Replay
from seamark.sim.engine.trial import run_trial
from seamark.sim.engine.vehicle_sonar import VehicleSonar, pipe_looks
from seamark.sim.physics.pipe import pipe_along
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.sonar.device import Device

ENTRY = registry.benchmark("track-v1")
SHORT = {"levels": [0.2], "level_duration_s": 3.0, "vehicle": "bluerov2-heavy-v2"}
FORWARD = {"sonar": "forward"}
DEVICE = Device(range_m=20.0, tilt_rad=0.35)
SEED = 5


class Looking:
    """Keeps its images, and steers for the point ahead."""

    def __init__(self) -> None:
        self.newest: Images | None = None
        self.kept: list[tuple[float, float, NDArray[np.uint8]]] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def show(self, images: Images) -> None:
        self.newest = images

    def step(self, values: NDArray[np.float64]) -> Command:
        seen = Observation(values, None, self.newest, route=True)
        if self.newest is not None:
            self.kept.append((seen.t, seen.image_t, seen.images[SONAR]))
        ahead, side, down = (0.4 * seen.error).tolist()
        return ahead, side, down, 0.0


def ran(**settings: Any) -> tuple[Looking, Rows, str]:
    program, rows = Looking(), []
    config = ENTRY.read(SHORT | settings)
    result = run_trial(
        "track-v1",
        config,
        program,
        seed=SEED,
        trial=0,
        on_rows=lambda part: rows.append(part.copy()),
    )
    return program, np.concatenate(rows), result.digest


def test_without_a_sonar_a_configuration_is_stored_as_it_was_before_there_were_any() -> None:
    for settings in ({}, {"sonar": "none"}, {"sonar_range_m": 12.0}):
        config = ENTRY.read(settings)
        assert not [name for name in config.model_dump() if "sonar" in name]
        assert not [name for name in config.for_program() if "sonar" in name]
    assert all(
        configuration_digest(ENTRY, name) == result.configuration
        for name, result in of_benchmark(ENTRY).items()
    )


def test_a_sonar_is_stored_and_a_program_is_told_of_it() -> None:
    config = ENTRY.read(FORWARD | {"sonar_range_m": 12.0})

    assert ENTRY.read(config.model_dump()) == config == ENTRY.restore(config.model_dump())
    told = config.for_program()
    assert (told["sonar"], told["sonar_range_m"], told["sonar_tilt_rad"]) == ("forward", 12.0, 0.35)
    layout = ENTRY.load().layout(config.for_trial(0))
    assert layout["images"] == [[SONAR, 400, 256]]
    assert layout["observation"][-1] == ["image_t", 0]


def test_a_ranked_run_has_no_sonar() -> None:
    assert ENTRY.ranked(ENTRY.read(FORWARD)).cameras_of_program() == ()
    assert ENTRY.changes_scenario(ENTRY.read(FORWARD))


@pytest.mark.parametrize(("name", "value"), [("sonar", "aft"), ("sonar_range_m", 500.0)])
def test_another_sonar_is_refused(name: str, value: object) -> None:
    with pytest.raises(ConfigurationInvalid, match=name):
        ENTRY.read({name: value})


@pytest.mark.slow
def test_a_program_gets_ten_images_a_second_that_its_rows_show_again() -> None:
    program, rows, digest = ran(**FORWARD)
    again = Replay("track-v1", ENTRY.read(SHORT | FORWARD), lambda _trial: SEED)

    times = sorted({image_t for _t, image_t, _image in program.kept})
    assert np.diff(times) == pytest.approx(0.1)
    for _t, image_t, image in program.kept[::13]:
        (row,) = rows[rows[:, INDEX["t"]] == image_t]
        frame = again.frame(row)
        assert frame.sonar is not None
        assert frame.sonar.image(frame.motion, frame.number).tobytes() == image.tobytes()
    assert not program.kept[0][2].flags.writeable
    blind, _rows, other = ran()
    assert (blind.kept, other) == ([], digest)


def test_a_run_without_a_sonar_has_no_fan() -> None:
    config = ENTRY.read(SHORT)
    row = np.zeros(config.telemetry_shape()[1])

    with pytest.raises(NoSonar, match="no imaging sonar"):
        Replay("track-v1", config, lambda _trial: SEED).frame(row).fan()


def brightest(pose: list[float], target: Target) -> tuple[float, float]:
    """Return range and azimuth of the strongest echo, on average over frames."""
    sonar = VehicleSonar(DEVICE, target, seabed_m=20.0, noise_seed=2)
    frames = [sonar.image(np.array(pose), k).astype(np.float64) ** 2 for k in range(12)]
    row, column = np.unravel_index(int(np.mean(frames, axis=0).argmax()), frames[0].shape)
    return (row + 0.5) * DEVICE.bin_m, DEVICE.azimuth_rad(float(column))


@pytest.mark.parametrize("yaw", [0.0, 2.0])
@pytest.mark.parametrize("aside", [-3.0, 0.0, 4.0])
def test_the_weight_appears_where_it_is(yaw: float, aside: float) -> None:
    ahead, height = 9.0, 4.0
    sine, cosine = math.sin(yaw), math.cos(yaw)
    target = Target(
        length_m=0.5,
        width_m=0.5,
        height_m=0.5,
        seabed_m=20.0,
        north_m=7.0 + cosine * ahead - sine * aside,
        east_m=-2.0 + sine * ahead + cosine * aside,
        heading_rad=yaw,
    )

    away, azimuth = brightest([7.0, -2.0, 20.0 - height, 0.0, 0.0, yaw], target)

    x, y, z = ahead - 0.3, aside, height - 0.25  # from the sonar to the middle of the weight
    assert away == pytest.approx(math.sqrt(x * x + y * y + z * z), abs=0.4)
    along = math.cos(DEVICE.tilt_rad) * x + math.sin(DEVICE.tilt_rad) * z
    assert azimuth == pytest.approx(math.atan2(y, along), abs=0.03)


def test_what_is_ahead_leaves_the_image_when_the_bow_rises() -> None:
    target = Target(length_m=1.0, width_m=1.0, height_m=1.0, seabed_m=20.0, north_m=9.0)
    sonar = VehicleSonar(DEVICE, target, seabed_m=20.0, noise_seed=2)

    level, raised = (sonar.image(np.array([0, 0, 16.0, 0, pitch, 0]), 0) for pitch in (0.0, 0.6))

    assert level.max() == 255
    assert raised.max() < 100


def test_a_pipe_crosses_the_image_but_for_where_sand_covers_it() -> None:
    axis = np.array([[8.0, -30.0], [8.0, 1.0], [8.0, 30.0]])
    pipe = pipe_along(axis, 20.0, 0.2, seed=1)._replace(covered_m=np.array([[29.0, 33.0]]))
    sonar = VehicleSonar(DEVICE, None, pipe_looks(pipe), seabed_m=20.0, noise_seed=2)

    frames = [sonar.image(np.array([0, 0, 16.0, 0, 0, 0]), k) for k in range(12)]
    mean = np.mean(np.square(frames, dtype=np.float64), axis=0)

    found = []
    for column in (40, 80, 127, 128, 180, 220):
        y, z = 7.7, 3.8  # [m] from the sonar ahead, and down to a height in the middle of the pipe
        along = math.cos(DEVICE.tilt_rad) * y + math.sin(DEVICE.tilt_rad) * z
        aside = along * math.tan(DEVICE.azimuth_rad(column))
        row = round(math.sqrt(aside**2 + y**2 + z**2) / DEVICE.bin_m)
        found.append(bool(mean[row - 8 : row + 5, column].max() > 80.0**2))
    assert found == [True, True, False, False, True, True]
