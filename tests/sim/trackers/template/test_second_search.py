"""The second search: what it finds, what it must not find, and that it is off in first versions."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import benchmark
from seamark.sim.settings.tracker import ROBUST
from seamark.sim.trackers import make
from seamark.sim.trackers.template.pyramid import (
    MAX_LEVELS,
    from_pyramid_level,
    full_bounds,
    resolutions,
    to_pyramid_level,
)

Array = NDArray[np.float64]
SWERVE = np.array([0.04, 0.016, -0.08, 0.04, -0.032, 0.16])  # between two images: 30 px at a corner


def _camera(tau: float = 0.0) -> Camera:
    return Camera(VISIBILITY, Water.grey(tau / 1.27), Target(width_m=0.28), noise_seed=3)


def _swerved(tau: float, **options: Any) -> tuple[bool, float]:
    """Whether the tracker has the target after the vehicle swerved, and the error [px]."""
    clear, camera = _camera(), _camera(tau)
    still = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    tracker = make("esm", **options)
    tracker.start(clear.grey(still, 0), clear.corners(still))
    for k in (1, 2):
        tracker.update(camera.grey(still, k))
    track = tracker.update(camera.grey(still + SWERVE, 3))
    return track.ok, float(np.abs(track.corners - camera.corners(still + SWERVE)).max())


@pytest.mark.parametrize("tau", [0.0, 2.0])
def test_a_target_that_swerves_is_found_only_by_the_second_search(tau: float) -> None:
    first, second = _swerved(tau), _swerved(tau, **ROBUST)

    assert first[1] > 5.0
    assert second[0]
    assert second[1] < 1.0


@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_the_second_search_finds_no_target_in_noise(seed: int) -> None:
    camera, random = _camera(), np.random.default_rng(seed)
    still = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    tracker = make("esm", **ROBUST)
    tracker.start(camera.grey(still, 0), camera.corners(still))

    tracks = [tracker.update(random.integers(0, 256, (240, 320)).astype(np.uint8)) for _ in "abc"]

    assert not any(track.ok for track in tracks)
    assert all(np.array_equal(track.corners, camera.corners(still)) for track in tracks)


def test_a_target_at_rest_takes_no_second_search() -> None:
    camera = _camera()
    still = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    trackers = [make("esm", **ROBUST), make("esm", **(ROBUST | {"second_search": False}))]
    for tracker in trackers:
        tracker.start(camera.grey(still, 0), camera.corners(still))

    for k in range(1, 20):
        ours, other = (tracker.update(camera.grey(still, k)) for tracker in trackers)

        assert ours.iterations == other.iterations
        assert ours.corners == pytest.approx(other.corners, abs=1e-4)


def test_the_whole_search_margin_is_kept_where_a_second_search_may_need_it() -> None:
    camera = _camera()
    still = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    widths = []
    for options in ({}, {"second_search": True}):
        tracker = make("esm", search_px=30, **options)
        tracker.start(camera.grey(still, 0), camera.corners(still))
        tracker.update(camera.grey(still, 1))
        x0, _, x1, _ = tracker.window()
        widths.append(x1 - x0)

    assert widths[1] - widths[0] == pytest.approx(2 * (30 - 8), abs=4)


@given(
    steps=st.tuples(*[st.floats(-0.1, 0.1)] * 8),
    corner=st.tuples(st.integers(0, 200), st.integers(0, 150)),
)
@settings(max_examples=40, deadline=None)
def test_homographies_survive_the_way_to_every_pyramid_level_and_back(
    steps: tuple[float, ...], corner: tuple[int, int]
) -> None:
    h = np.eye(3) + np.array([*steps[:6], 1e-3 * steps[6], 1e-3 * steps[7], 0.0]).reshape(3, 3)
    window = (*corner, corner[0] + 100, corner[1] + 80)
    for level in range(1, MAX_LEVELS):
        low, back = np.empty((3, 3)), np.empty((3, 3))

        to_pyramid_level(h, level, window, low)
        from_pyramid_level(low, level, window, back)

        assert back == pytest.approx(h / h[2, 2], abs=1e-9)


def test_every_pyramid_level_shows_the_same_mean_grey_as_the_window() -> None:
    image = np.random.default_rng(1).integers(0, 256, (240, 320)).astype(np.uint8)
    window = (40, 24, 168, 120)

    images = resolutions(image, window, window, MAX_LEVELS, True)

    wanted = image[24:120, 40:168].mean()
    for level, small in enumerate(images.small, start=1):
        assert small.mean() / 4**level == pytest.approx(wanted, rel=1e-12)
        bounds = np.empty(4)
        full_bounds(small, bounds)
        assert bounds.tolist() == [0, 0, 128 >> level, 96 >> level]
    assert images.smooth.mean() / 16 == pytest.approx(wanted, rel=2e-3)


def test_an_image_is_smoothed_with_the_binomial_mask() -> None:
    image = np.random.default_rng(2).integers(0, 256, (60, 80)).astype(np.uint8)
    mask = np.outer([1, 2, 1], [1, 2, 1])

    window = (10, 20, 50, 52)

    smooth = resolutions(image, window, window, 1, True).smooth

    for row, column in ((1, 1), (15, 20), (30, 38)):
        around = image[20 + row - 1 : 20 + row + 2, 10 + column - 1 : 10 + column + 2]
        assert smooth[row, column] == (around * mask).sum()


def test_first_versions_search_once_and_later_ones_twice() -> None:
    chosen = {
        name: benchmark(name).read({}).model_dump()["second_search"]
        for name in ("currents-v1", "visibility-v1", "currents-v2", "currents-v3", "visibility-v2")
    }

    assert chosen == {
        "currents-v1": False,
        "visibility-v1": False,
        "currents-v2": True,
        "currents-v3": True,
        "visibility-v2": True,
    }
