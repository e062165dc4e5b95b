"""Images for a program: when they are taken, how late they come, and what they show."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest

from seamark.sim import registry
from seamark.sim.camera.arm_camera import ON_ARM, ArmCamera
from seamark.sim.control.observation import Images, Observation
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.program import BuiltIn, ImageProgram
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import ARM_INDEX, INDEX
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.sim.camera.test_arm_camera import replay
from tests.sim.engine.test_arm import ALPHA, BENCHMARK, SEED, SHORT, Moving, run

COMMAND = (0.1, 0.0, 0.0, 0.0, 0.3, -0.3, -0.1, 0.0, -0.1)
T = INDEX["t"]


class Seen(NamedTuple):
    """What a program had at one step."""

    t: float
    image_t: float
    images: Images


class Looking(Moving):
    """A program that moves the arm, and keeps its images."""

    def __init__(self) -> None:
        super().__init__(COMMAND)
        self.kept: list[Seen] = []
        self.shown = 0
        self.newest: Images = {}

    def reset(self, level: Mapping[str, float | int]) -> None:
        self.newest = {}

    def show(self, images: Images) -> None:
        self.newest = images
        self.shown += 1

    def step(self, values: Any) -> tuple[float, ...]:
        seen = Observation(values, ALPHA, self.newest)
        self.kept.append(Seen(seen.t, seen.image_t, seen.images))
        return super().step(values)


class Servo:
    """A controller that turns the arm by a row of pixels; also the law of `Outside`."""

    label = "Servo"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.old = -1.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        self.old = -1.0

    def step(self, observation: Observation) -> list[float]:
        new, self.old = observation.image_t != self.old, observation.image_t
        bright = observation.images["arm"][200].sum() / 320 / 256
        return [0.1 * new, 0.0, 0.0, 0.0, bright - 0.25, 0.0, 0.0, 0.0, 0.0]


class Outside(Looking):
    """The same as a program of another process."""

    servo = Servo({})

    def step(self, values: Any) -> tuple[float, ...]:
        return tuple(map(float, self.servo.step(Observation(values, ALPHA, self.newest))))


def look(**settings: Any) -> tuple[list[Seen], telemetry.Rows]:
    program = Looking()
    rows = run(program, **{"images": "arm"} | settings)
    return program.kept, rows


def late_steps(**settings: Any) -> int:
    """Return the drawn delay of the images of `run`."""
    config = registry.benchmark(BENCHMARK).read(SHORT | settings)
    experiment: Any = registry.benchmark(BENCHMARK).load()
    drawn = experiment.drawn(config, seed=SEED, trial=0)
    return int(drawn.camera_delay_steps)


def test_images_are_taken_ten_times_a_second_and_as_late_as_those_of_the_tracker() -> None:
    late = late_steps(camera_delay_steps=6)
    assert late > 2, "another seed: this one draws too short a delay to be seen"

    kept, rows = look(camera_delay_steps=6)

    for step, seen in enumerate(kept):
        taken = max(0, (step - late) // 2 * 2)
        assert seen.t == rows[step, T]
        assert seen.image_t == rows[taken, T]
    assert len({id(seen.images["arm"]) for seen in kept}) == len({s.image_t for s in kept})


def test_at_a_longer_control_period_each_observation_has_new_images() -> None:
    kept, _ = look(control_period_s=0.2, camera_delay_steps=0)

    assert [seen.image_t for seen in kept] == [seen.t for seen in kept]


@pytest.mark.slow
@pytest.mark.parametrize("blur", [0.0, 0.02])
def test_images_have_the_pixels_that_the_row_of_their_time_shows(blur: float) -> None:
    settings: dict[str, Any] = {"images": "both", "camera_exposure_s": blur}
    kept, rows = look(**settings, camera_delay_steps=3)
    again = replay(**settings)

    for seen in kept[::9]:
        (row,) = rows[rows[:, T] == seen.image_t]
        frame = again.frame(row)
        assert isinstance(frame.camera, ArmCamera)
        assert seen.images["arm"].tobytes() == frame.on_arm()[..., 1].tobytes()
        assert seen.images["vehicle"].tobytes() == frame.grey().tobytes()
        assert seen.images["vehicle"].tobytes() == frame.colour()[..., 1].tobytes()
    assert kept[0].images["arm"].tobytes() != kept[-1].images["arm"].tobytes()


def test_the_first_images_of_each_level_are_there_at_once_and_of_that_level() -> None:
    kept, rows = look(levels=[0.1, 0.2], level_duration_s=2.0, camera_delay_steps=6)

    first = len(rows) // 2
    assert rows[first, INDEX["level"]] != rows[0, INDEX["level"]]
    for step in (0, first, first + 1):
        assert kept[step].image_t == rows[step // first * first, T]
    assert {*kept[first].images} == {"arm"}


def test_a_program_is_shown_each_image_once() -> None:
    program = Looking()
    run(program, images="vehicle", camera_delay_steps=0)

    assert program.shown == len(program.seen) // 2


def test_images_are_read_only_and_have_the_sizes_of_the_layout() -> None:
    settings = {"images": "both", "camera_width_px": 720}
    entry = registry.benchmark(BENCHMARK)
    layout = entry.load().layout(entry.read(SHORT | settings))
    kept, _ = look(**settings)

    images = kept[0].images
    assert [[name, *image.shape] for name, image in images.items()] == layout["images"]
    assert layout["images"] == [["vehicle", 480, 720], ["arm", ON_ARM.height, ON_ARM.width]]
    assert layout["observation"][-1] == ["image_t", 0]
    assert not any(image.flags.writeable for image in images.values())


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["pi", "lqr"])
def test_a_run_that_ignores_its_images_has_the_bytes_of_one_without(controller: str) -> None:
    digests = set()
    for images in ("none", "vehicle", "both"):
        entry = registry.benchmark(BENCHMARK)
        config = entry.read(SHORT | {"images": images, "tracker": "esm", "level_duration_s": 2.0})
        solution = entry.load().built_in(controller, config)
        assert isinstance(solution, BuiltIn)
        assert isinstance(solution, ImageProgram)
        result = run_trial(
            BENCHMARK, config, solution, seed=SEED, trial=0, on_rows=lambda _rows: None
        )
        digests.add(result.digest)

    assert len(digests) == 1


def test_a_built_in_controller_has_the_images_of_any_other_program(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    experiment: Any = registry.benchmark(BENCHMARK).load()
    monkeypatch.setitem(registry.TASK_CONTROLLERS[experiment.task], "servo", f"{__name__}:Servo")
    config = registry.benchmark(BENCHMARK).read(SHORT | {"images": "arm"})
    built_in = experiment.built_in("servo", config)

    rows, others = run(built_in, images="arm"), run(Outside(), images="arm")

    assert telemetry.digest(rows) == telemetry.digest(others)
    assert np.ptp(rows[:, ARM_INDEX["joint_ref_0"]]) > 0.0


def test_without_the_setting_nothing_is_rendered_and_an_observation_is_as_before() -> None:
    entry = registry.benchmark(BENCHMARK)
    world = entry.load().world(entry.read(SHORT), seed=SEED, trial=0, level=0)  # type: ignore[attr-defined]
    loop = ClosedLoop(world, Looking(), trial=0, level=0)

    assert loop.images is None
    seen = Observation(loop.observation, ALPHA)
    assert "images" not in seen
    assert "image_t" not in seen
    with pytest.raises(AttributeError, match="images"):
        _ = seen.images


def test_an_observation_with_images_has_them_by_name_as_its_last_field() -> None:
    images = {"arm": np.zeros((2, 3), np.uint8)}
    seen = Observation(np.arange(21.0 + 8 + 1), None, images)

    assert list(seen)[-2:] == ["image_t", "images"]
    assert len(seen) == len(list(seen))
    assert seen.image_t == 29.0
    assert len(seen.thrust) == 8
    assert seen.images["arm"] is seen["images"]["arm"] is images["arm"]


@pytest.mark.parametrize("images", ["arm", "both"])
def test_images_of_an_arm_that_is_not_there_are_refused(images: str) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        registry.benchmark(BENCHMARK).read(SHORT | {"arm": "none", "images": images})

    assert "no camera on an arm" in refused.value.errors["images"]


def test_a_vehicle_without_an_arm_has_images_of_its_camera() -> None:
    class Alone(Looking):
        def step(self, values: Any) -> tuple[float, ...]:
            self.kept.append(Seen(values[0], values[-1], self.newest))
            return (0.0, 0.0, 0.0, 0.0)

    program = Alone()
    rows = run(program, arm="none", images="vehicle", camera_delay_steps=0)

    seen = program.kept[-1]
    (row,) = rows[rows[:, T] == seen.image_t]
    again = replay(arm="none", images="vehicle")
    assert seen.images["vehicle"].tobytes() == again.frame(row).grey().tobytes()


def test_a_ranked_run_has_the_images_that_it_asks_for() -> None:
    entry = registry.benchmark(BENCHMARK)

    ranked = entry.ranked(entry.read(SHORT | {"tracker": "esm", "images": "vehicle"}))
    assert ranked.cameras_of_program() == ("vehicle",)


def test_a_ranked_run_cannot_ask_for_images_of_an_arm_that_it_does_not_have() -> None:
    entry = registry.benchmark(BENCHMARK)

    with pytest.raises(ConfigurationInvalid) as refused:
        entry.ranked(entry.read(SHORT | {"tracker": "esm", "images": "both"}))

    assert "no camera on an arm" in refused.value.errors["images"]
