"""Every combination of the form works or is refused with a reason, whatever the images show."""

import itertools
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import TRACKERS, benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.tracker import ROBUST
from seamark.sim.trackers import declaration, make, option_errors, option_names
from seamark.sim.trackers.declaration import Option
from seamark.sim.trackers.options import CRITERIA, METHODS, WARPS
from seamark.sim.trackers.visp.installation import unavailable_reason

AVAILABLE = [name for name in TRACKERS if name != "visp" or not unavailable_reason()]

CURRENTS = benchmark("currents-v1")
Sequence = Any  # conftest's class; a test folder is no package

# Largest error after 8 images: what a warp cannot represent there.
LIMITS_PX = {"homography": 0.3, "affine": 1.0, "srt": 1.0, "rt": 6.0, "translation": 9.0}


@pytest.mark.slow
@pytest.mark.parametrize("warp", WARPS)
def test_every_criterion_and_method_follows_the_target_with_every_warp(
    brief: Sequence, warp: str
) -> None:
    for criterion, method in itertools.product(CRITERIA, METHODS):
        errors, sure = brief.follow(make("esm", warp=warp, criterion=criterion, method=method))

        assert sure.all(), (criterion, method)
        assert errors.max() < LIMITS_PX[warp], (criterion, method)


def _options(chosen: dict[str, Any]) -> dict[str, object] | None:
    """Return the tracker's options; None where the form refuses the choice with a reason."""
    try:
        return CURRENTS.read(chosen).tracker_options()
    except ConfigurationInvalid as refusal:
        reasons = refusal.errors
    assert reasons
    assert all(chosen["tracker"] in sentence.lower() for sentence in reasons.values())
    return None


@pytest.mark.parametrize("name", TRACKERS)
def test_every_combination_of_the_form_works_or_is_refused_with_a_reason(
    brief: Sequence, name: str
) -> None:
    first, second = (brief.camera.grey(brief.poses[k], k) for k in range(2))
    tables = {"warp": WARPS, "criterion": CRITERIA, "method": METHODS, "visp_sl3": (True, False)}
    tried = set()
    for values in itertools.product(*tables.values()):
        chosen = {"tracker": name, **dict(zip(tables, values, strict=True))}
        options = _options(chosen)
        if options is None or str(options) in tried:  # what it does not look at changes nothing
            continue
        tried.add(str(options))
        tracker = make(name, **options)
        if name == "visp":  # each is a process of a second: test_visp.py starts one of every kind
            continue
        tracker.start(first, brief.truth[0])

        assert np.isfinite(tracker.update(second).corners).all(), chosen

    assert tried or unavailable_reason()


def _refused(name: str) -> list[tuple[dict[str, Any], str]]:
    """Return the combinations of options that the form refuses, with the first sentence of each."""
    names = [key for key in ("warp", "criterion", "method") if key in option_names(name)]
    tables = {"warp": WARPS, "criterion": CRITERIA, "method": METHODS}
    combinations = itertools.product(*(tables[key] for key in names))
    options = [dict(zip(names, values, strict=True)) for values in combinations]
    errors = [(each, option_errors(name, each)) for each in options]
    return [(each, next(iter(found.values()))) for each, found in errors if found]


@pytest.mark.parametrize("name", [name for name in TRACKERS if _refused(name)])
def test_what_the_form_refuses_the_tracker_refuses_with_the_same_sentence(name: str) -> None:
    for options, sentence in _refused(name):
        with pytest.raises(ValueError, match=re.escape(sentence)):
            make(name, **options)


NUMBERS = [option for option in declaration("esm").options if option.low is not None]


@pytest.mark.parametrize("option", NUMBERS, ids=lambda option: option.name)
def test_the_ends_of_every_range_work(brief: Sequence, option: Option) -> None:
    for value in (option.low, option.high):
        errors, _ = brief.follow(make("esm", **{option.name: type(option.default)(value)}))

        assert np.isfinite(errors).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", AVAILABLE)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(["noise", "black", "white", "stripes"]))
@settings(max_examples=8, deadline=None)
def test_images_of_nothing_neither_crash_nor_move_the_target_out_of_reason(
    name: str, seed: int, kind: str
) -> None:
    random = np.random.default_rng(seed)
    images = {
        "noise": random.integers(0, 256, (240, 320)),
        "black": np.zeros((240, 320)),
        "white": np.full((240, 320), 255),
        "stripes": np.indices((240, 320))[seed % 2] * 37 % 256,
    }
    corners = np.array([[100.0, 100], [180, 102], [181, 140], [99, 138]])
    ic = {"criterion": "ssd", "method": "inverse_compositional"}
    options = {"visp": ic | {"visp_iterations": 5, "visp_predict": True}, "esm": ROBUST}
    tracker = make(name, **options.get(name, {}))
    tracker.start(images["noise"].astype(np.uint8), corners)

    for _ in range(3):
        track = tracker.update(images[kind].astype(np.uint8))

        assert np.isfinite(track.corners).all()
        assert np.abs(track.corners - corners).max() < 120


@pytest.mark.parametrize("name", ["esm", "ecc", "klt"])
def test_a_jump_is_a_loss_only_beyond_the_largest_that_is_allowed(name: str) -> None:
    camera = Camera(VISIBILITY, Water(), Target(width_m=0.28), noise_seed=1)
    start = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    aside = start + np.array([0.0, 0.045, 0.0, 0.0, 0.0, 0.0])  # 9 px; the longer side has 85
    tracks = []
    for max_jump in (0.1, 1.0 / 3.0):
        tracker = make(name, max_jump=max_jump)
        tracker.start(camera.grey(start, 0), camera.corners(start))
        tracks.append(tracker.update(camera.grey(aside, 1)))

    assert [track.ok for track in tracks] == [False, True]
    assert np.array_equal(tracks[0].corners, camera.corners(start))
    assert np.abs(tracks[1].corners - camera.corners(aside)).max() < 1.5


@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_template_of_nothing_is_lost_and_no_error(criterion: str) -> None:
    corners = np.array([[50.0, 50], [150, 50], [150, 90], [50, 90]])
    tracker = make("esm", criterion=criterion, reacquire_px=60)
    tracker.start(np.full((240, 320), 90, np.uint8), corners)

    tracks = [tracker.update(np.full((240, 320), level, np.uint8)) for level in (90, 0, 255)]

    assert not any(track.ok for track in tracks)
    assert all(np.array_equal(track.corners, corners) for track in tracks)


def test_a_lost_target_is_found_again_where_it_came_back(jump: Sequence) -> None:
    near, far = jump.follow(make("esm")), jump.follow(make("esm", reacquire_px=80))

    assert not near[1][-1]
    assert far[1][-1]
    assert far[0][-1] < 0.3


def test_what_is_read_grows_while_the_target_is_lost(blackout: Sequence) -> None:
    tracker = make("esm", reacquire_px=80)
    tracker.start(blackout.camera.grey(blackout.poses[0], 0), blackout.truth[0])
    widths = []
    for k in range(1, 40):
        tracker.update(blackout.camera.region(blackout.poses[k], k, tracker.window()))
        x0, _, x1, _ = tracker.window()
        widths.append(x1 - x0)

    assert widths[19:26] == sorted(widths[19:26])
    assert widths[25] > widths[19] > widths[17]
