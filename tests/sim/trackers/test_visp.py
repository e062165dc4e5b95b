"""ViSP itself, by way of the bridge, where its library is installed."""

import os
import signal
from typing import Any

import numpy as np
import pytest

from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import benchmark
from seamark.sim.trackers import make
from seamark.sim.trackers.visp.build import build
from seamark.sim.trackers.visp.installation import REMEDY

Sequence = Any  # conftest's class; a test folder is no package

IC = {"criterion": "ssd", "method": "inverse_compositional"}
here = pytest.mark.skipif(bool(build()), reason=f"ViSP is not installed: {REMEDY}")


@pytest.mark.slow
@here
@pytest.mark.parametrize(
    ("options", "limit_px"),
    [
        (IC, 0.3),
        (IC | {"visp_sl3": False}, 1.0),
        (IC | {"warp": "affine"}, 1.0),
        (IC | {"warp": "srt"}, 1.0),
        (IC | {"warp": "rt"}, 8.0),
        (IC | {"warp": "translation"}, 10.0),
        ({"criterion": "ssd", "method": "forward_additional"}, 0.5),
        ({"criterion": "ssd", "method": "forward_compositional"}, 0.5),
        ({"criterion": "ssd", "method": "esm"}, 0.5),
        ({"criterion": "zncc", "method": "inverse_compositional", "pyramid_levels": 1}, 0.2),
        ({"criterion": "zncc", "method": "forward_additional", "pyramid_levels": 1}, 1.0),
        (
            {
                "criterion": "mi",
                "method": "inverse_compositional",
                "pyramid_levels": 1,
                "sampling_px": 1,
                "visp_iterations": 20,
            },
            0.5,
        ),
    ],
)
def test_visp_follows_the_target(short: Sequence, options: dict[str, Any], limit_px: float) -> None:
    errors, sure = short.follow(make("visp", **{"sampling_px": 2} | options))

    assert sure.all()
    assert errors.max() < limit_px


@pytest.mark.slow
@here
def test_visp_predicts_a_steady_motion_only_where_it_is_asked_to() -> None:
    camera = Camera(VISIBILITY, Water(), Target(width_m=0.28), noise_seed=3)
    start = start_pose(VISIBILITY, Target(width_m=0.28), 1.27)
    speeding_up = np.cumsum(np.minimum(np.arange(14), 8))[:, None]  # to 12 px per image
    poses = start + speeding_up * [0.0045, 0.0027, 0.0015, 0.0, 0.0, 0.003]
    errors = []
    for predicts in (False, True):
        tracker = make("visp", sampling_px=2, pyramid_levels=1, visp_predict=predicts, **IC)
        tracker.start(camera.grey(poses[0], 0), camera.corners(poses[0]))
        for k, pose in enumerate(poses[1:], start=1):
            corners = tracker.update(camera.grey(pose, k)).corners
        errors.append(np.abs(corners - camera.corners(poses[-1])).max())

    assert errors[0] > 10.0
    assert errors[1] < 1.0


@pytest.mark.slow
@here
@pytest.mark.parametrize("warp", ["translation", "rt", "srt", "affine", "homography"])
@pytest.mark.parametrize("sl3", [False, True])
def test_every_warp_of_visp_can_start_from_a_prediction(
    brief: Sequence, warp: str, sl3: bool
) -> None:
    tracker = make("visp", warp=warp, visp_sl3=sl3, sampling_px=2, visp_predict=True, **IC)

    errors, sure = brief.follow(tracker)

    assert sure.all()
    assert errors.max() < 10.0


@pytest.mark.slow
@here
def test_with_the_rim_of_a_large_target_in_its_template_the_zncc_of_visp_loses_it() -> None:
    large = Target(width_m=0.28)
    camera = Camera(VISIBILITY, Water(), large, noise_seed=3)
    start, aside = (
        start_pose(VISIBILITY, large, 1.27),
        np.array([0.008, 0.008, 0.0, 0.0, 0.0, 0.01]),
    )
    options: dict[str, Any] = {"criterion": "zncc", "sampling_px": 2, "pyramid_levels": 1}
    errors = []
    for margin in (-3, 0):
        tracker = make("visp", template_margin_px=margin, **options)
        tracker.start(camera.grey(start, 0), camera.corners(start))
        for k in range(1, 7):
            corners = tracker.update(camera.grey(start + k * aside, k)).corners
        errors.append(np.abs(corners - camera.corners(start + 6 * aside)).max())

    assert errors[0] < 0.2
    assert errors[1] > 5.0


@here
@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"criterion": "zncc", "method": "esm"}, "visp does not support criterion zncc with esm"),
        ({"criterion": "ssd", "method": "esm", "warp": "affine"}, "warp affine"),
        ({"criterion": "ssd", "method": "esm", "visp_sl3": False}, "SL3"),
    ],
)
def test_what_visp_does_not_have_is_refused_by_name(options: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        make("visp", **options)


@pytest.mark.slow
@here
def test_a_bridge_that_dies_loses_the_target_and_not_the_run(short: Sequence) -> None:
    tracker = make("visp", **IC)
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])
    os.kill(tracker._bridge.process, signal.SIGKILL)

    tracks = [tracker.update(short.camera.grey(short.poses[k], k)) for k in (1, 2)]
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])

    assert [track.ok for track in tracks] == [False, False]
    assert tracker.update(short.camera.grey(short.poses[1], 1)).ok


@here
def test_no_bridge_outlives_its_tracker(short: Sequence) -> None:
    tracker = make("visp", **IC)
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])
    process = tracker._bridge.process
    os.kill(process, 0)

    del tracker

    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


@here
def test_images_of_nothing_lose_the_target(short: Sequence) -> None:
    tracker = make("visp", sampling_px=2, visp_iterations=10, **IC)
    tracker.start(short.camera.grey(short.poses[0], 0), short.truth[0])
    noise = np.random.default_rng(1).integers(0, 255, (3, 240, 320)).astype(np.uint8)

    sure = [tracker.update(image).ok for image in (np.zeros_like(noise[0]), *noise)]

    assert not sure[-1]


@here
def test_the_form_offers_visp_and_refuses_what_it_lacks() -> None:
    currents = benchmark("currents-v1")
    labels = currents.configuration.model_fields["tracker"].json_schema_extra["x-labels"]

    assert labels["visp"].startswith("ViSP")
    assert currents.read({"tracker": "visp"} | IC).tracker == "visp"
