"""The comparison of trackers: its sequences, its fairness, its words."""

from dataclasses import replace

import numpy as np
import pytest

from performance.trackers.contenders import CONTENDERS, PEERS, Contender
from performance.trackers.race import Result, least, race
from performance.trackers.sequences import Sequence, motion
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.registry import TRACKERS


def _still(frames: int) -> Sequence:
    camera = Camera(VISIBILITY, Water(), Target(), noise_seed=1)
    poses = start_pose(VISIBILITY, Target(), 1.27) + motion(frames, speed=0.1)
    pictures = np.stack([camera.grey(pose, k) for k, pose in enumerate(poses)])
    return Sequence(pictures, np.stack([camera.corners(pose) for pose in poses]))


def test_every_contender_is_known_and_some_of_them_are_the_peers() -> None:
    begin, end = PEERS
    labels = [contender.label for contender in CONTENDERS]

    assert {contender.tracker for contender in CONTENDERS} <= set(TRACKERS)
    assert any(label.startswith(begin) and label.endswith(end) for label in labels)


def test_the_template_tracker_is_timed_and_errs_by_hundredths_of_a_pixel() -> None:
    (result,) = race((Contender("ours", "esm"),), _still(12))

    assert result.lost_at is None
    assert len(result.errors_px) == len(result.spent_us) == 11
    assert result.error(95) < 0.2
    assert result.median_us() > 0


def test_of_several_rounds_each_picture_keeps_its_least_time() -> None:
    slow, quick = (Result(Contender("ours", "esm"), spent_us=us) for us in ([9.0, 1.0], [3.0, 2.0]))

    assert least([[slow], [quick]])[0].spent_us == [3.0, 1.0]


def test_pictures_from_the_lost_one_on_are_not_part_of_the_error() -> None:
    result = Result(Contender("ours", "esm"), errors_px=[0.1, 0.1, 50.0], lost_at=2)

    assert result.error(95) == 0.1


def test_a_template_that_reaches_beyond_the_target_is_judged_by_the_target() -> None:
    still = _still(6)
    grown = replace(still, margin_px=6.0)
    (result,) = race((Contender("ours", "esm"),), grown)

    assert np.abs(grown.start_corners() - still.corners[0]).max() == pytest.approx(6.0, abs=0.3)
    assert np.allclose(still.start_corners(), still.corners[0], atol=1e-3)
    assert result.error(95) < 0.5
