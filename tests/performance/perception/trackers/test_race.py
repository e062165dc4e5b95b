"""The comparison of trackers: its sequences and its fairness."""

from dataclasses import replace

import numpy as np
import pytest

from performance.perception.trackers.contenders import CELLS, PEERS, SLOW_CELLS, Contender
from performance.perception.trackers.race import Result, fastest, qualified, race
from performance.perception.trackers.sequences import Sequence, motion
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import TRACKERS


def _still(frames: int) -> Sequence:
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=1)
    poses = start_pose(VISIBILITY, Target(), 1.27) + motion(frames, speed=0.1)
    images = np.stack([camera.grey(pose, k) for k, pose in enumerate(poses)])
    return Sequence(images, np.stack([camera.corners(pose) for pose in poses]))


def test_every_contender_is_registered_and_some_are_the_reference() -> None:
    begin, end = PEERS
    contenders = [contender for cell in CELLS + SLOW_CELLS for contender in cell]
    labels = [contender.label for contender in contenders]

    assert {contender.tracker for contender in contenders} <= set(TRACKERS)
    assert any(label.startswith(begin) and label.endswith(end) for label in labels)


def test_the_template_tracker_is_timed_and_has_a_small_error() -> None:
    (result,) = race((Contender("ours", "esm"),), _still(12))

    assert result.lost_at is None
    assert len(result.errors_px) == len(result.cpu_us) == 11
    assert result.error(95) < 0.2
    assert result.median_us() > 0


def test_each_image_keeps_its_shortest_time_over_several_rounds() -> None:
    slow, quick = (Result(Contender("ours", "esm"), cpu_us=us) for us in ([9.0, 1.0], [3.0, 2.0]))

    assert fastest([[slow], [quick]])[0].cpu_us == [3.0, 1.0]


def test_images_from_the_loss_on_are_not_part_of_the_error() -> None:
    result = Result(Contender("ours", "esm"), errors_px=[0.1, 0.1, 50.0], lost_at=2)

    assert result.error(95) == 0.1


def test_the_error_of_a_template_that_extends_beyond_the_target_is_that_of_the_target() -> None:
    still = _still(6)
    grown = replace(still, margin_px=6.0)
    (result,) = race((Contender("ours", "esm"),), grown)

    assert np.abs(grown.start_corners() - still.corners[0]).max() == pytest.approx(6.0, abs=0.3)
    assert np.allclose(still.start_corners(), still.corners[0], atol=1e-3)
    assert result.error(95) < 0.5


def test_every_tracker_that_can_predict_is_compared_with_and_without() -> None:
    lines = {(cell[0].label, cell[0].predicts) for cell in CELLS}

    for label in ("ours ZNCC ESM homography", "ViSP SSD ESM homography", "OpenCV ECC homography"):
        assert {(label, True), (label, False)} <= lines


def test_all_set_ups_of_a_cell_are_one_tracker_and_predict_alike() -> None:
    for cell in CELLS + SLOW_CELLS:
        assert len({(one.label, one.tracker, one.predicts) for one in cell}) == 1


def test_a_set_up_that_keeps_the_target_qualifies_before_one_that_loses_it() -> None:
    still = _still(8)
    beside = Contender("ours", "esm", {"max_jump": 0.1, "fine_iterations": 1}, setup="too weak")
    jumping = replace(still, corners=still.corners.copy(), images=still.images.copy())
    jumping.images[4:] = np.roll(still.images[4:], 12, axis=2)
    jumping.corners[4:] += [12.0, 0.0]
    robust = Contender("ours", "esm", {"second_search": True, "max_jump": 1.0})

    assert qualified([(beside, robust)], jumping) == [robust]
