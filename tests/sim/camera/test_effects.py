"""Disturbances of the images: off by default, pure, the same by region and whole, as stated."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.benchmarks.visibility_v1.experiment import EXPERIMENT
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.raycast_effects import gaussian_blur
from seamark.sim.camera.snow import CUBE_M, flake_count
from seamark.sim.engine.replay import Replay
from seamark.sim.recording.telemetry import Rows
from seamark.sim.settings.targets import TARGETS
from seamark.sim.trackers.interface import Track

Array = NDArray[np.float64]
START = start_pose(VISIBILITY, Target(), 1.27)
ON: dict[str, dict[str, Any]] = {
    "blur": {"exposure_s": 0.04},
    "dusk": {"light_level": 0.3},
    "lamp": {"light_level": 0.2, "lamp": 3.0},
    "caustics": {"caustics": 0.4},
    "snow": {"snow_per_m3": 500.0},
    "scatter": {"scatter_rad": 0.004},
    "fish": {"fish_per_min": 20.0, "fish_length_m": 0.5},
}
ALL: dict[str, Any] = {k: v for options in ON.values() for k, v in options.items()}
CAMERAS = [
    Camera(VISIBILITY, Water.of_type("3C"), Target(), noise_seed=4, effects=Effects(**options))
    for options in [*ON.values(), ALL]
]


def light(effects: Effects, motion: Array, frames: int = 32, water: Water | None = None) -> Array:
    """Mean image: the light without most of its noise."""
    camera = Camera(VISIBILITY, water or Water(), Target(), noise_seed=4, effects=effects)
    return np.mean([camera.grey(motion, k) for k in range(frames)], axis=0)


@pytest.mark.slow
@given(
    camera=st.sampled_from(CAMERAS),
    corner=st.tuples(st.integers(-20, 310), st.integers(-20, 230)),
    size=st.tuples(st.integers(1, 200), st.integers(1, 150)),
    frame=st.integers(0, 10**5),
    motion=st.tuples(*[st.floats(-0.3, 0.3)] * 12),
)
@settings(max_examples=60, deadline=None)
def test_region_has_the_bytes_of_the_whole_image_with_effects(
    camera: Camera,
    corner: tuple[int, int],
    size: tuple[int, int],
    frame: int,
    motion: tuple[float, ...],
) -> None:
    moving = np.concatenate([START, np.zeros(6)]) + np.array(motion)
    whole = camera.grey(moving, frame)

    (x0, y0), (width, height) = corner, size
    part = camera.region(moving, frame, (x0, y0, x0 + width, y0 + height))

    rows, columns = slice(max(y0, 0), max(y0 + height, 0)), slice(max(x0, 0), max(x0 + width, 0))
    assert np.array_equal(part[rows, columns], whole[rows, columns])


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS, ids=[*ON, "all"])
def test_grey_image_is_the_green_channel_with_effects(camera: Camera) -> None:
    motion = np.concatenate([START, [0.3, 0.1, 0.0, 0.0, 0.0, 0.2]])

    assert np.array_equal(camera.colour(motion, 40)[:, :, 1], camera.grey(motion, 40))


@pytest.mark.parametrize("name", ON)
def test_every_effect_changes_images_and_none_does_when_off(name: str) -> None:
    motion = np.concatenate([START, [0.5, 0.2, 0.0, 0.0, 0.0, 0.0]])
    plain = Camera(VISIBILITY, Water(), Target(), noise_seed=4)
    off = Camera(VISIBILITY, Water(), Target(), noise_seed=4, effects=Effects())
    on = Camera(VISIBILITY, Water(), Target(), noise_seed=4, effects=Effects(**ON[name]))

    images = [[c.grey(motion, k) for k in range(0, 120, 10)] for c in (plain, off, on)]

    assert np.array_equal(images[0], images[1])
    assert not np.array_equal(images[0], images[2])


def test_rendering_with_effects_that_are_off_gives_the_same_image() -> None:
    """Effects with next to no strength: the other code path, the same scene."""
    plain = Camera(VISIBILITY, Water(), Target(), noise_seed=4).grey(START, 0)
    longer = Camera(
        VISIBILITY, Water(), Target(), noise_seed=4, effects=Effects(exposure_s=0.05)
    ).grey(START, 0)

    assert np.array_equal(plain, longer)  # at rest there is no blur


def test_motion_blurs_edges_over_the_distance_moved_during_the_exposure() -> None:
    """An edge across the motion becomes a ramp of speed x time x focal length / depth."""
    speed, exposure, depth = 0.8, 0.05, 1.27
    motion = np.concatenate([START, [0.0, speed, 0.0, 0.0, 0.0, 0.0]])

    sharp, blurry = (
        light(Effects(exposure_s=time), motion, water=Water.grey(0.0))[116:124].mean(axis=0)
        for time in (0.0, exposure)
    )

    way = speed * exposure * 257.3 / depth
    kernel = np.full(round(way), 1 / round(way))
    expected = np.convolve(sharp, kernel, mode="same")
    rim = slice(60, 260)
    assert way == pytest.approx(8.1, abs=0.1)
    assert np.abs(blurry - expected)[rim].mean() < 0.35 * np.abs(sharp - expected)[rim].mean()
    assert blurry[rim].mean() == pytest.approx(sharp[rim].mean(), abs=0.5)


def test_a_blurred_point_is_a_gaussian_with_the_given_sigma() -> None:
    point = np.zeros((41, 41), np.float32)
    point[20, 20] = 1.0

    spot = gaussian_blur(point, 2.5)

    offset = np.arange(41) - 20
    assert spot.sum() == pytest.approx(1.0, abs=1e-5)
    assert np.sqrt((spot.sum(axis=0) * offset**2).sum()) == pytest.approx(2.5, rel=0.02)
    assert np.sqrt((spot.sum(axis=1) * offset**2).sum()) == pytest.approx(2.5, rel=0.02)


@given(density=st.floats(1.0, 2000.0), seed=st.integers(0, 2**31 - 1))
@settings(max_examples=20, deadline=None)
def test_snow_is_as_dense_as_stated(density: float, seed: int) -> None:
    cubes = [(i, j, k) for i in range(-8, 8) for j in range(-8, 8) for k in range(16)]

    flakes = sum(flake_count(i, j, k, density, seed) for i, j, k in cubes)

    volume = len(cubes) * CUBE_M**3
    spread = 4 * np.sqrt(len(cubes) / 4)  # every cube rounds up or down
    assert flakes == pytest.approx(density * volume, abs=spread)


def test_snow_drifts_from_frame_to_frame_without_changing() -> None:
    effects = Effects(snow_per_m3=300.0, frame_s=0.01)
    camera = Camera(VISIBILITY, Water.grey(0.0), Target(), noise_seed=4, effects=effects)
    still = light(Effects(), START, water=Water.grey(0.0))

    near, later, far = ((camera.grey(START, k) - still).clip(20) for k in (0, 1, 2000))

    def alike(a: Array, b: Array) -> float:
        return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])

    assert alike(near, later) > 0.5
    assert alike(near, far) < 0.2


@pytest.mark.slow
def test_light_scales_all_but_the_noise() -> None:
    bright = light(Effects(), START)
    dim = light(Effects(light_level=0.5), START)

    assert dim == pytest.approx(0.5 * bright, abs=1.5)


def test_the_lamp_is_brightest_below_itself_and_backscatters_in_turbid_water() -> None:
    dark = {"light_level": 0.01, "lamp": 8.0, "lamp_cone_rad": 0.4}
    clear = light(Effects(**dark), START, water=Water.grey(0.05))
    turbid = light(Effects(**dark), START, water=Water.grey(3.0))

    ahead, aft = clear[:60].mean(), clear[180:].mean()
    assert ahead > 2 * aft
    assert turbid[:40].mean() > turbid[200:].mean() + 1.0


def test_contrast_falls_with_turbidity() -> None:
    contrasts = [light(Effects(), START, 8, Water.grey(c)).std() for c in (0.0, 0.4, 0.8, 1.6, 3.2)]

    assert all(a > b + 0.5 for a, b in pairwise(contrasts))


def test_a_fish_hides_the_target_for_a_while() -> None:
    effects = Effects(fish_per_min=10.0, fish_length_m=0.5)
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=4, effects=effects)
    clear = light(Effects(), START)

    hidden = [np.abs(camera.grey(START, k) - clear)[100:140, 120:200].mean() for k in range(120)]

    assert 5 < sum(value > 10 for value in hidden) < 60
    assert min(hidden) < 2.5


@pytest.mark.parametrize("name", TARGETS)
def test_every_target_is_rendered_at_its_true_corners(name: str) -> None:
    shape = TARGETS[name]
    target = Target(
        length_m=shape.length_m,
        width_m=shape.width_m,
        height_m=shape.height_m,
        lettered=shape.lettered,
    )
    camera = Camera(VISIBILITY, Water.grey(0.0), target, noise_seed=4)
    pose = start_pose(VISIBILITY, target, 1.27)
    corners = camera.corners(pose)

    image = camera.grey(pose, 0).astype(float)

    x0, y0 = corners.min(axis=0).astype(int) + 2
    x1, y1 = corners.max(axis=0).astype(int) - 1
    assert np.median(image[y0:y1, x0:x1]) < 60 < np.median(image)
    assert (image[y0:y1, x0:x1].std() > 8) == shape.lettered


class Keeps:
    """A tracker that keeps what it is shown and answers with where the target was at the start."""

    def __init__(self) -> None:
        self.seen: list[NDArray[np.uint8]] = []

    def start(self, image: NDArray[np.uint8], corners: Array) -> None:
        self.corners = corners
        self.seen.append(image.copy())

    def window(self) -> tuple[int, int, int, int]:
        return (0, 0, 320, 240)

    def update(self, image: NDArray[np.uint8]) -> Track:
        self.seen.append(image.copy())
        return Track(self.corners, True, 0.0, 1)


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["fixed", "free"])
def test_images_from_telemetry_are_those_of_the_run_with_every_effect(mode: str) -> None:
    benchmark = registry.benchmark("visibility-v1")
    config = benchmark.read(
        {
            **{"mode": mode, "sweep_from": 0.5, "sweep_to": 1.0, "sweep_step": 0.5},
            **{"camera_exposure_s": 0.04, "light_level": 0.4, "lamp": 2.0, "caustics": 0.3},
            **{"snow_per_m3": 200.0, "scatter_mrad": 1.4, "fish_per_min": 20.0, "target": "long"},
        }
        | {"level_duration_s": 2.0}
    )
    tracker = Keeps()
    delivered: list[Rows] = []
    level: Any = EXPERIMENT.level(config, tracker, seed=3, trial=0, level=0)

    level.run(delivered.append)
    level.close()

    rows = np.concatenate(delivered)
    replay = Replay("visibility-v1", config, lambda trial: 3)
    assert len(rows) == len(tracker.seen) > 20
    for at in range(1, len(rows), 7):
        assert np.array_equal(replay.frame(rows[at]).grey(), tracker.seen[at])


@pytest.mark.parametrize(
    "options",
    [
        {"exposure_s": 0.06},
        {"light_level": 0.0},
        {"lamp": -1.0},
        {"caustics": 1.6},
        {"lamp_cone_rad": 1.6},
        {"snow_per_m3": -1.0},
    ],
)
def test_impossible_effects_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"\w+"):
        Effects(**options)
