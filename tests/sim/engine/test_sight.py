"""A tracker that gets only the part of an image that it needs, beside one that gets all of it."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.camera.scene import buffers_for
from seamark.sim.engine.sight import Sight, look
from seamark.sim.settings.tracker import ROBUST
from seamark.sim.trackers import make
from seamark.sim.trackers.template.frame_step import PART_TOO_SMALL, likely_part, track_frame
from seamark.sim.trackers.template.level_buffers import Bench, bench_for, bench_size
from seamark.sim.trackers.template.tracker import Memory, TemplateTracker

_STILL = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
_IMAGES = 60
_OPTIONS: dict[str, dict[str, Any]] = {
    "as in currents-v1": {},
    "as in currents-v2": dict(ROBUST),
    "on four levels": {"pyramid_levels": 4},
    "image smoothed, one search": {"smoothing": "image"},
    "on one level": {"pyramid_levels": 1},
    "without prediction": {"predict_motion": False},
    "searched for on a grid": {"reacquire_px": 60},
    "margin around the target": {"template_margin_px": 4},
    "mutual information": {"criterion": "mi"},
    "affine, SSD": {"warp": "affine", "criterion": "ssd"},
}


def _camera() -> Camera:
    return Camera(VISIBILITY, Water.grey(0.8), Target(width_m=0.28), noise_seed=3)


def _tracker(camera: Camera, options: dict[str, Any]) -> TemplateTracker:
    tracker = make("esm", **options)
    assert isinstance(tracker, TemplateTracker)
    tracker.start(camera.grey(_STILL, 0), camera.corners(_STILL))
    return tracker


def _poses(seed: int) -> list[NDArray[np.float64]]:
    """Return poses (12,) of a vehicle that drifts, swerves now and then, and leaves the target."""
    random = np.random.default_rng(seed)
    sizes = np.array([0.003, 0.003, 0.002, 0.004, 0.004, 0.01])
    steps = sizes * random.standard_normal((_IMAGES, 6))
    steps[5::9] *= 3.0
    away = np.where(np.arange(_IMAGES) % 40 >= 36, 2.0, 0.0)
    path = _STILL + np.cumsum(steps, axis=0)
    path[:, 0] += away
    return [np.concatenate([pose, np.zeros(6)]) for pose in path]


def _bench(memory: Memory) -> Bench:
    return bench_for(bench_size(memory.levels))


def _copied(memory: Memory) -> Memory:
    return Memory(*(np.copy(part) for part in memory))


@pytest.mark.parametrize("options", _OPTIONS.values(), ids=list(_OPTIONS))
def test_a_tracker_finds_the_same_in_a_part_as_in_the_whole_image(options: dict[str, Any]) -> None:
    camera = _camera()
    whole, partly = _tracker(camera, options), _tracker(camera, options)
    height, width = VISIBILITY.height, VISIBILITY.width
    random, corners = np.random.default_rng(1), np.zeros(8)
    sight, buffers = Sight(camera.pencil(), partly.memory()), buffers_for(width)
    bench = _bench(partly.memory())
    lost = 0
    for frame, pose in enumerate(_poses(7), start=1):
        canvas = random.integers(0, 256, (height, width)).astype(np.uint8)

        found = look(sight, pose, frame, buffers, canvas, bench, corners)

        track = whole.update(camera.grey(pose[:6], frame))
        assert found == track.ok
        if found:
            assert corners.tobytes() == track.corners.tobytes()
        assert partly.memory().state.tobytes() == whole.memory().state.tobytes()
        assert partly.window() == whole.window()
        lost += not found
    assert 4 <= lost < _IMAGES // 2


@pytest.mark.parametrize("options", _OPTIONS.values(), ids=list(_OPTIONS))
def test_a_part_that_is_too_small_changes_nothing(options: dict[str, Any]) -> None:
    camera = _camera()
    memory = _tracker(camera, options).memory()
    pose = _STILL + np.array([0.03, 0.0, 0.0, 0.0, 0.0, 0.0])
    x0, y0, x1, y1 = memory.window.tolist()
    state, search, numbers, store, box = known = _copied(memory)
    part = (x0 + 16, y0 + 16, x1 - 32, y1 - 24)
    image, bench = camera.grey(pose, 1), _bench(memory)

    found, _, _ = track_frame(image, part, box, state, search, numbers, store, bench)

    assert found == PART_TOO_SMALL
    for ours, before in zip(known, memory, strict=True):
        assert ours.tobytes() == before.tobytes()


def test_less_than_half_of_the_window_is_drawn_where_the_target_is_expected() -> None:
    tracker = _tracker(_camera(), dict(ROBUST))
    x0, y0, x1, y1 = window = tracker.window()

    part = likely_part(tracker.memory().state, 2, window)

    assert (part[2] - part[0]) * (part[3] - part[1]) < 0.5 * (x1 - x0) * (y1 - y0)
    corners = _camera().corners(_STILL)
    assert (np.array(part[:2]) < corners.min(axis=0)).all()
    assert (np.array(part[2:]) > corners.max(axis=0)).all()


def test_the_whole_window_is_drawn_while_the_target_is_lost() -> None:
    camera = _camera()
    tracker = _tracker(camera, dict(ROBUST))

    assert not tracker.update(np.zeros((VISIBILITY.height, VISIBILITY.width), np.uint8)).ok

    assert likely_part(tracker.memory().state, 2, tracker.window()) == tracker.window()
