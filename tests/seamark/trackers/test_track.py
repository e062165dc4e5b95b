"""The trackers on a person's own video, as a library and by the command."""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from seamark.cli.main import cli
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.trackers import VideoUnreadable, track

IMAGES, RATE = 12, 20.0
Image = NDArray[np.uint8]


def poses() -> Iterator[NDArray[np.float64]]:
    for k in range(IMAGES):
        yield start_pose(VISIBILITY, Target(), 1.5) + 0.01 * k * np.array([1, 0.5, 0, 0, 0, 1])


CAMERA = Camera(VISIBILITY, Water(), Target(), noise_seed=1)
SEEN = [CAMERA.grey(pose, k) for k, pose in enumerate(poses())]
TRUE = [CAMERA.corners(pose) for pose in poses()]
TEXT = " ".join(f"{x:.2f},{y:.2f}" for x, y in TRUE[0])


@pytest.fixture
def video(tmp_path: Path) -> Path:
    path = tmp_path / "dive.avi"
    size = VISIBILITY.width, VISIBILITY.height
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), RATE, size)
    for image in SEEN:
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    return path


@pytest.mark.parametrize("tracker", ["esm", "klt"])
def test_a_target_is_followed_through_images(tracker: str) -> None:
    found = list(track(SEEN, TRUE[0], tracker=tracker))

    assert [each.number for each in found] == list(range(IMAGES))
    assert all(each.ok for each in found)
    for each, corners in zip(found, TRUE, strict=True):
        assert np.abs(each.corners - corners).max() < 2.0


def test_a_video_is_followed_from_any_image_with_its_times(video: Path) -> None:
    found = list(track(video, TRUE[3], first=3, warp="affine"))

    assert [each.number for each in found] == list(range(3, IMAGES))
    np.testing.assert_allclose([each.time_s for each in found], np.arange(3, IMAGES) / RATE)
    assert found[0].image.shape == (VISIBILITY.height, VISIBILITY.width, 3)
    assert np.abs(found[-1].corners - TRUE[-1]).max() < 2.0


def test_a_target_that_vanishes_is_reported_as_lost_at_its_last_place() -> None:
    noise = np.random.default_rng(1).integers(0, 255, SEEN[0].shape, np.uint8)

    *_, before, last = track([*SEEN[:3], noise], TRUE[0])

    assert before.ok
    assert not last.ok
    np.testing.assert_array_equal(last.corners, before.corners)


def test_what_cannot_be_tracked_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "notes.mp4"
    file.write_text("no video")
    with pytest.raises(VideoUnreadable, match="no video that OpenCV can read"):
        list(track(file, TRUE[0]))
    with pytest.raises(FileNotFoundError):
        list(track(tmp_path / "none.mp4", TRUE[0]))
    with pytest.raises(VideoUnreadable, match="no image 99"):
        list(track(SEEN, TRUE[0], first=99))
    with pytest.raises(ValueError, match="tracker 'magic' must be one of esm"):
        track(SEEN, TRUE[0], tracker="magic")
    with pytest.raises(ValueError, match="no option bend"):
        track(SEEN, TRUE[0], bend=1)
    with pytest.raises(ValueError, match="warp must be one of"):
        track(SEEN, TRUE[0], warp="bent")
    with pytest.raises(ValueError, match="four corners"):
        track(SEEN, TRUE[0][:3])
    with pytest.raises(ValueError, match="convex"):
        list(track(SEEN, TRUE[0][[0, 2, 1, 3]]))
    with pytest.raises(ValueError, match="uint8"):
        list(track([SEEN[0].astype(np.float64)], TRUE[0]))


def test_the_command_writes_corners_and_a_drawn_video(video: Path, tmp_path: Path) -> None:
    out, drawn = tmp_path / "dive.csv", tmp_path / "drawn.mp4"
    arguments = ["track", str(video), "--corners", TEXT, "--out", str(out), "--json"]

    ended = CliRunner().invoke(cli, [*arguments, "--drawn", str(drawn), "--set", "warp=srt"])

    assert ended.exit_code == 0, ended.output
    assert json.loads(ended.output) == {"images": IMAGES, "held": IMAGES, "out": str(out)}
    with out.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == IMAGES
    assert abs(float(rows[-1]["x0"]) - TRUE[-1][0, 0]) < 2.0
    shown = cv2.VideoCapture(str(drawn))
    there, image = shown.read()
    assert there
    assert image[..., 1].astype(int).max() - image[..., 0].astype(int).min() > 100


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--corners", "1,2 3,4"], "write four points"),
        (["--corners", TEXT, "--set", "warp=bent"], "warp"),
        (["--corners", TEXT, "--first", "99"], "no image 99"),
        (["--corners", TEXT, "--drawn", "drawn.txt"], ".mp4"),
    ],
)
def test_the_command_says_what_is_wrong_and_leaves_nothing(
    video: Path, tmp_path: Path, arguments: list[str], message: str
) -> None:
    out = tmp_path / "dive.csv"

    ended = CliRunner().invoke(cli, ["track", str(video), "--out", str(out), *arguments])

    assert ended.exit_code == 2
    assert message in ended.output
    assert not out.exists()
