"""The layout of LeRobot's data sets, version 3.

LeRobot itself needs PyTorch and an older NumPy, so these tests read the files by themselves.
docs/training.md says with which version it has read them.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray

from tests.seamark.demonstrations.replay import replayed

Written = Callable[..., Path]
pytestmark = pytest.mark.slow  # all simulate
CAMERAS = ("vehicle", "arm")


def info(folder: Path) -> Any:
    return json.loads((folder / "meta" / "info.json").read_text())


def episodes_of(folder: Path) -> Any:
    return pq.read_table(folder / "meta" / "episodes").to_pylist()


def rows_of(folder: Path, about: Any) -> pd.DataFrame:
    """Return the rows of an episode, found as LeRobot does."""
    at = {"chunk_index": about["data/chunk_index"], "file_index": about["data/file_index"]}
    table = pd.read_parquet(folder / info(folder)["data_path"].format(**at))
    begin, end = about["dataset_from_index"], about["dataset_to_index"]
    return table[(table["index"] >= begin) & (table["index"] < end)]


def frames_of(folder: Path, about: Any, key: str) -> Iterator[NDArray[np.uint8]]:
    """Yield the images of an episode, found by their times."""
    names = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")
    where = {name: about[f"videos/{key}/{name}"] for name in names}
    path = folder / info(folder)["video_path"].format(video_key=key, **where)
    with av.open(str(path), "r") as video:
        for frame in video.decode(video=0):
            assert frame.time is not None
            if where["from_timestamp"] - 1e-4 < frame.time < where["to_timestamp"] - 1e-4:
                yield frame.to_ndarray(format="gray").astype(np.uint8)


def test_each_column_has_the_type_and_shape_that_its_feature_says(lerobot: Path) -> None:
    features = info(lerobot)["features"]
    schema = pq.read_schema(lerobot / "data" / "chunk-000" / "file-000.parquet")
    kinds = {"float32": pa.float32(), "int64": pa.int64(), "bool": pa.bool_()}

    columns = {name: f for name, f in features.items() if f["dtype"] != "video"}

    assert set(schema.names) == set(columns)
    for name, feature in columns.items():
        (width,) = feature["shape"]
        kind = kinds[feature["dtype"]]
        assert schema.field(name).type == (kind if width == 1 else pa.list_(kind, width))
        assert feature["names"] is None or len(feature["names"]) == width
    assert {name for name in features if name not in columns} == {
        f"observation.images.{camera}" for camera in CAMERAS
    }


def test_the_rows_are_an_episode_that_the_environment_repeats_bit_for_bit(lerobot: Path) -> None:
    compared = 0

    for about in episodes_of(lerobot):
        rows = rows_of(lerobot, about)
        actions = np.array(rows["action"].to_list())
        assert actions.dtype == np.float32
        steps = [*replayed(lerobot, about["seed"], about["level"], actions)]
        for at, state in enumerate(rows["observation.state"]):
            np.testing.assert_array_equal(state, steps[at].observation["state"])
            compared += 1
        rewards = np.array([step.reward for step in steps[1:]], np.float32)
        np.testing.assert_array_equal(rows["next.reward"], rewards)
        assert [*rows["next.done"]] == [False] * 39 + [True]
        np.testing.assert_array_equal(rows["frame_index"], np.arange(40))
        np.testing.assert_array_equal(rows["timestamp"], (np.arange(40) / 20).astype(np.float32))
        assert set(rows["episode_index"]) == {about["episode_index"]}

    assert compared == info(lerobot)["total_frames"] == 120


def test_the_frames_of_a_video_are_the_images_of_the_rows(lerobot: Path) -> None:
    compared = 0

    for about in episodes_of(lerobot):
        actions = np.array(rows_of(lerobot, about)["action"].to_list())
        steps = [*replayed(lerobot, about["seed"], about["level"], actions)]
        for camera in CAMERAS:
            frames = [*frames_of(lerobot, about, f"observation.images.{camera}")]
            assert len(frames) == about["length"]
            for frame, step in zip(frames, steps, strict=False):
                image = step.observation[f"image_{camera}"].astype(float)
                assert np.abs(frame - image).mean() < 6.0  # of 255; H.264 smooths the noise
                compared += 1

    assert compared == 2 * 120


def test_the_statistics_are_those_of_all_rows(lerobot: Path) -> None:
    stats = json.loads((lerobot / "meta" / "stats.json").read_text())
    table = pd.read_parquet(lerobot / "data")

    for name in ("observation.state", "action"):
        values = np.array(table[name].to_list(), float)
        for key, expected in {
            "min": values.min(axis=0),
            "max": values.max(axis=0),
            "mean": values.mean(axis=0),
            "std": values.std(axis=0),
        }.items():
            np.testing.assert_allclose(stats[name][key], expected, atol=1e-6)
        assert stats[name]["count"] == [120]
    grey = stats["observation.images.arm"]
    assert np.shape(grey["mean"]) == (3, 1, 1)
    assert 0.0 <= grey["min"][0][0][0] < grey["q50"][0][0][0] < grey["max"][0][0][0] <= 1.0


def test_the_statistics_of_images_are_those_of_their_pixels(lerobot: Path) -> None:
    (about, *_) = episodes_of(lerobot)
    actions = np.array(rows_of(lerobot, about)["action"].to_list())
    seen = {
        float(step.observation["state"][-1]): step.observation["image_vehicle"]
        for step in replayed(lerobot, about["seed"], about["level"], actions)
    }
    pixels = np.array([*seen.values()]) / 255.0

    def stat(name: str) -> Any:
        return np.ravel(about[f"stats/observation.images.vehicle/{name}"])

    np.testing.assert_allclose(stat("mean"), pixels.mean())
    np.testing.assert_allclose(stat("std"), pixels.std())
    np.testing.assert_allclose(stat("q50"), np.median(pixels), atol=1 / 255)
    np.testing.assert_allclose(stat("q99"), np.quantile(pixels, 0.99), atol=1 / 255)


def test_the_tasks_are_a_data_frame_by_text(lerobot: Path) -> None:
    tasks = pd.read_parquet(lerobot / "meta" / "tasks.parquet")

    assert [*tasks.index] == ["Turn a valve"]
    assert tasks.loc["Turn a valve"]["task_index"] == 0


def test_large_sets_have_several_files(written: Written, monkeypatch: Any) -> None:
    monkeypatch.setattr("seamark.demonstrations.layouts.lerobot.DATA_MB", 1e-3)
    monkeypatch.setattr("seamark.demonstrations.layouts.lerobot.VIDEO_MB", 1e-3)

    folder = written("lerobot")

    files = [about["data/file_index"] for about in episodes_of(folder)]
    assert files == [0, 1, 2]
    for about in episodes_of(folder):
        assert len(rows_of(folder, about)) == 40
        assert len([*frames_of(folder, about, "observation.images.arm")]) == 40


ENCODED = """
import hashlib
import numpy as np
from seamark.demonstrations.layouts.video import encoded
across, down = np.meshgrid(np.arange(320), np.arange(240))
images = [(128 + 60 * np.sin((across + 3 * k) / 9) + 60 * np.cos((down - k) / 7)).astype(np.uint8)
          for k in range(30)]
print(hashlib.sha256(encoded(images, 20)).hexdigest())
"""


def test_a_video_does_not_depend_on_what_was_in_memory_before() -> None:
    """glibc fills memory that is handed out with a byte of our choice (mallopt(3))."""
    seen = {
        subprocess.run(
            [sys.executable, "-c", ENCODED],
            env=os.environ | {"MALLOC_PERTURB_": filled},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for filled in ("1", "85", "254")
    }

    assert len(seen) == 1
