"""Images: pure, the same by region and whole, noisy as stated, and true to the scene."""

import hashlib
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.seabed import TEXEL_M, TILE
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

Array = NDArray[np.float64]
CAMERA = Camera(VISIBILITY, Water(), Target(), noise_seed=11)
START = start_pose(VISIBILITY, Target(), 1.27)


def average(camera: Camera, pose: Array, frames: int = 64) -> Array:
    return np.mean([camera.grey(pose, k) for k in range(frames)], axis=0)


@given(
    x0=st.integers(-20, 330),
    y0=st.integers(-20, 250),
    width=st.integers(1, 330),
    height=st.integers(1, 250),
    frame=st.integers(0, 10**6),
    shift=st.tuples(*[st.floats(-0.3, 0.3)] * 6),
)
@settings(max_examples=60, deadline=None)
def test_region_has_the_bytes_of_the_whole_image(
    x0: int, y0: int, width: int, height: int, frame: int, shift: tuple[float, ...]
) -> None:
    pose = START + np.array(shift)
    whole = CAMERA.grey(pose, frame)

    part = CAMERA.region(pose, frame, (x0, y0, x0 + width, y0 + height))

    rows, columns = slice(max(y0, 0), max(y0 + height, 0)), slice(max(x0, 0), max(x0 + width, 0))
    assert np.array_equal(part[rows, columns], whole[rows, columns])


def test_images_do_not_depend_on_the_order_of_frames(camera: Camera, tilted: Array) -> None:
    forwards = [camera.grey(tilted, k) for k in range(5)]
    backwards = [camera.grey(tilted, k) for k in reversed(range(5))]

    assert all(np.array_equal(a, b) for a, b in zip(forwards, reversed(backwards), strict=True))


@pytest.mark.slow
def test_grey_image_is_the_green_channel_of_the_coloured_one(camera: Camera, tilted: Array) -> None:
    assert np.array_equal(camera.colour(tilted, 3)[:, :, 1], camera.grey(tilted, 3))


def test_another_noise_seed_changes_noise_but_not_the_scene(tilted: Array) -> None:
    other = Camera(VISIBILITY, Water(), Target(), noise_seed=12)

    difference = CAMERA.grey(tilted, 0).astype(float) - other.grey(tilted, 0)

    assert 1.0 < difference.std() < 4.0
    assert abs(difference.mean()) < 0.05


@pytest.mark.slow
def test_noise_grows_with_light_as_read_and_shot_noise_do(tilted: Array) -> None:
    images = np.array([CAMERA.grey(tilted, k) for k in range(100)], dtype=float)

    light, variance = images.mean(axis=0), images.var(axis=0)

    rounding = 1 / 12
    for low, high in ((20, 60), (80, 100), (100, 140)):
        chosen = (light > low) & (light < high)
        expected = 1.2**2 + 0.01 * light[chosen].mean() + rounding
        assert variance[chosen].mean() == pytest.approx(expected, rel=0.05)
    assert np.sqrt(variance.min()) > 0.8


def test_noise_differs_between_frames_and_between_rows(tilted: Array) -> None:
    mean = average(CAMERA, tilted)
    first, second = (CAMERA.grey(tilted, k) - mean for k in (0, 1))

    assert abs(np.corrcoef(first.ravel(), second.ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(first[:-1].ravel(), first[1:].ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(first[:, :-1].ravel(), first[:, 1:].ravel())[0, 1]) < 0.02


@pytest.mark.parametrize(("law", "density"), [("beer", 0.9), ("uwsim", 0.8)])
def test_contrast_to_the_veil_decays_by_the_law(law: str, density: float) -> None:
    veil = 255 * Water.grey(density, law=law).veil[1]
    clear, turbid = (
        average(Camera(VISIBILITY, Water.grey(c, law=law), Target(), noise_seed=1), START)
        for c in (0.0, density)
    )

    contrast = np.median((turbid - veil)[:8, 156:164] / (clear - veil)[:8, 156:164])

    depth, slope = 1.4, 116.0 / 257.3
    path = {"beer": density * depth * np.sqrt(1 + slope**2), "uwsim": (density * depth) ** 2}[law]
    assert contrast == pytest.approx(np.exp(-path), rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("water", "heading"),
    [
        (Water.grey(0.0), 0.7),
        (Water.of_type("3C"), 0.0),
        pytest.param(Water.grey(0.0), 0.0, marks=pytest.mark.long),
        pytest.param(Water.of_type("3C"), 0.7, marks=pytest.mark.long),
    ],
)
def test_images_agree_with_a_slow_supersampled_renderer(
    reference: Callable[..., object], water: Water, heading: float
) -> None:
    target = Target(heading_rad=heading, north_m=3.1, east_m=-40.2)
    pose = start_pose(VISIBILITY, target, 1.27) + np.array([0.06, -0.09, 0.04, 0.06, -0.05, 0.22])
    camera = Camera(VISIBILITY, water, target, noise_seed=2)

    truth = reference(VISIBILITY, water, target, 4).grey(pose)
    difference = average(camera, pose) - truth

    assert abs(difference.mean()) < 0.05
    assert difference.std() < 1.5
    x0, y0, x1, y1 = _around(camera.corners(pose), 3)
    box = difference[y0:y1, x0:x1]
    assert abs(box.mean()) < 0.25
    assert box.std() < 3.0
    down, right = (g[y0:y1, x0:x1].ravel() for g in np.gradient(truth))
    shift = np.linalg.lstsq(np.column_stack([right, down]), -box.ravel(), rcond=None)[0]
    assert np.abs(shift).max() < 0.02  # [px]


def _around(corners: Array, margin: int) -> tuple[int, int, int, int]:
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def test_seabed_repeats_after_a_tile_without_a_seam(tilted: Array) -> None:
    far = tilted + np.array([0, 3 * TILE * TEXEL_M, 0, 0, 0, 0])
    away = tilted + np.array([0, 10 * TILE * TEXEL_M, 0, 0, 0, 0])

    first, second = CAMERA.grey(far, 0).astype(int), CAMERA.grey(away, 0).astype(int)

    assert np.abs(first - second).max() <= 1
    assert (first != second).mean() < 0.01


def test_far_from_the_target_the_seabed_is_still_textured(tilted: Array) -> None:
    lost = tilted + np.array([-5000.0, 7000.0, 0, 0, 0, 1.0])

    assert average(CAMERA, lost, 16).std() > 5.0


@pytest.mark.parametrize("pose", [[0, 0, 4.9, 0, 0, 0], [0, 0, 20, 0, 0, 0], [0, 0, 2, 2, 0, 0]])
def test_a_camera_below_the_seabed_or_on_its_side_still_gives_an_image(pose: list[float]) -> None:
    image = CAMERA.grey(np.array(pose, dtype=float), 0)

    assert image.shape == (240, 320)


PROGRAM = """
import hashlib, numpy as np
from seamark.sim.camera import CURRENTS, Camera, Target, Water, start_pose
pose = start_pose(CURRENTS, Target(), 2.27) + np.array([0.1, -0.1, 0.1, 0.05, 0.04, 0.3])
camera = Camera(CURRENTS, Water.of_type("II"), Target(), noise_seed=5)
print(hashlib.sha256(camera.colour(pose, 77).tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_two_processes_render_the_same_bytes() -> None:
    here = printed_here(PROGRAM)

    assert len(here.strip()) == hashlib.sha256().digest_size * 2
    assert here == printed(PROGRAM)


@pytest.mark.parametrize("effects", [None, Effects(caustics=0.2)])
def test_a_camera_keeps_the_arrays_of_its_pencils(effects: Effects | None) -> None:
    """A compiled loop knows them by their addresses."""
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=1, effects=effects)

    for one, other in zip(camera.pencil(0), camera.pencil(0), strict=True):
        assert one is other
