"""LeRobot data set v3: many episodes in a file of Parquet, and what each is in `meta/episodes`.

A row is an observation and the action that follows from it, so the last observation of an episode
is left out. Images are videos with a frame for each row.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.demonstrations.description import FILE, Description
from seamark.demonstrations.episodes import Images
from seamark.demonstrations.layouts import Episode
from seamark.demonstrations.layouts.columns import numbers, vectors
from seamark.demonstrations.layouts.lerobot_statistics import (
    Statistics,
    Total,
    of_grey_levels,
    of_numbers,
)
from seamark.demonstrations.layouts.rolling import FILES_A_CHUNK, RollingTables
from seamark.demonstrations.layouts.video import CODEC, PIXELS, RollingVideo, encoded

VERSION = "v3.0"
DATA_MB, VIDEO_MB = 100, 200  # at which the next file begins
MIB = 2**20
ROWS_A_GROUP = 64  # episodes in `meta/episodes`
STATE, ACTION, IMAGES = "observation.state", "action", "observation.images."
_PATH = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_INDICES = ("frame_index", "episode_index", "index", "task_index")


def refusal(description: Description) -> str:
    """Return why these demonstrations cannot be written; empty if they can."""
    if not float(description.rate_hz).is_integer():
        return (
            "LeRobot counts whole frames a second: choose a control_period_s such as 0.05, or "
            "another format."
        )
    if any(side % 2 for size in description.cameras.values() for side in size):
        return "A video needs an even width and height of the images, or choose another format."
    return ""


def packed_images(images: Mapping[str, Images], rate_hz: float) -> dict[str, NDArray[Any]]:
    """Return a video of each camera without the last image, and how many pixels are how bright."""
    packed: dict[str, NDArray[Any]] = {}
    for camera, seen in images.items():
        video = encoded([*seen][:-1], round(rate_hz))
        packed[f"{camera}_video"] = np.frombuffer(video, np.uint8)
        packed[f"{camera}_grey_levels"] = sum(
            (np.bincount(image.ravel(), minlength=256) for image in seen.frames),
            np.zeros(256, np.int64),
        )
        packed[f"{camera}_images"] = np.array(len(seen.frames))
    return packed


def write(description: Description, episodes: Iterable[Episode], folder: Path) -> None:
    """Write the data set; `LeRobotDataset(repo_id, root=folder)` reads it."""
    (folder / "meta").mkdir()
    with _Writer(description, folder) as writer:
        for episode in episodes:
            writer.add(episode)
    _write_json(folder / "meta" / "info.json", _info(description, writer.count, writer.frames))
    _write_json(folder / "meta" / "stats.json", writer.statistics())
    _write_tasks(folder / "meta" / "tasks.parquet", description.title)
    (folder / FILE).write_text(description.text(), encoding="utf-8")


class _Writer:
    """Writes episodes; a context manager."""

    def __init__(self, description: Description, folder: Path) -> None:
        self._description = description
        self._rate = round(description.rate_hz)
        self.count = self.frames = 0  # of episodes, of rows
        self._data = RollingTables(folder / "data", limit_bytes=DATA_MB * MIB)
        self._episodes = RollingTables(folder / "meta" / "episodes", limit_bytes=DATA_MB * MIB)
        self._videos = {
            camera: RollingVideo(
                folder / "videos" / f"{IMAGES}{camera}",
                limit_bytes=VIDEO_MB * MIB,
                rate_hz=self._rate,
            )
            for camera in description.cameras
        }
        self._rows: list[dict[str, Any]] = []
        self._totals: dict[str, Total] = {}
        self._open = ExitStack()

    def __enter__(self) -> _Writer:
        """Begin."""
        for tables in (self._data, self._episodes):
            self._open.enter_context(tables)
        for video in self._videos.values():
            self._open.enter_context(video)
        return self

    def __exit__(self, *_: object) -> None:
        """Complete all files."""
        with self._open:
            self._write_rows()

    def add(self, episode: Episode) -> None:
        """Write an episode."""
        columns = self._columns(episode)
        length = episode.outcome.steps
        row = self._row(episode, length)
        for camera, video in self._videos.items():
            content = episode.arrays[f"{camera}_video"].tobytes()
            where = video.add(content, length)
            row |= {f"videos/{IMAGES}{camera}/{name}": value for name, value in where.items()}
        for name, statistics in self._statistics(columns, episode).items():
            self._totals.setdefault(name, Total()).add(statistics)
            row |= {f"stats/{name}/{key}": value.tolist() for key, value in statistics.items()}
        self._write_columns(columns)
        self._rows.append(row)
        self.count, self.frames = self.count + 1, self.frames + length
        if len(self._rows) == ROWS_A_GROUP:
            self._write_rows()

    def statistics(self) -> dict[str, Any]:
        """Return those of all episodes, as plain JSON values."""
        return {name: total.statistics() for name, total in self._totals.items()}

    def _columns(self, episode: Episode) -> dict[str, NDArray[Any]]:
        """Return name -> values of each row, (n, k) or (n,)."""
        from seamark.sim.benchmarks.intervention.experiment import DONE_CREDIT

        arrays, length = episode.arrays, episode.outcome.steps
        within = np.arange(length)
        return {
            STATE: arrays["observations"][:-1],
            ACTION: arrays["actions"],
            "next.reward": arrays["rewards"].astype(np.float32),
            "next.done": arrays["terminations"] | arrays["truncations"],
            "next.success": arrays["credit"][1:] >= DONE_CREDIT,
            "timestamp": (within / self._rate).astype(np.float32),
            "frame_index": within,
            "episode_index": np.full(length, self.count),
            "index": self.frames + within,
            "task_index": np.zeros(length, np.int64),
        }

    def _write_columns(self, columns: Mapping[str, NDArray[Any]]) -> None:
        import pyarrow as pa

        self._data.write(
            pa.table(
                {
                    name: vectors(values) if values.ndim == 2 else numbers(values)
                    for name, values in columns.items()
                }
            )
        )

    def _row(self, episode: Episode, length: int) -> dict[str, Any]:
        """Return what `meta/episodes` has of an episode, but for its videos and statistics."""
        row: dict[str, Any] = {
            "episode_index": self.count,
            "tasks": [self._description.title],
            "length": length,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + length,
        }
        for name, tables in (("data", self._data), ("meta/episodes", self._episodes)):
            row[f"{name}/chunk_index"], row[f"{name}/file_index"] = tables.place
        told = episode.outcome.as_dict()
        names = ("seed", "trial", "level", "current_m_s", "credit", "stages", "success")
        return row | {name: told[name] for name in names}

    def _statistics(
        self, columns: Mapping[str, NDArray[Any]], episode: Episode
    ) -> dict[str, Statistics]:
        whole: dict[str, Statistics] = {
            name: of_numbers(values.reshape(len(values), -1)) for name, values in columns.items()
        }
        for camera in self._videos:
            levels = episode.arrays[f"{camera}_grey_levels"]
            whole[f"{IMAGES}{camera}"] = of_grey_levels(
                levels, int(episode.arrays[f"{camera}_images"])
            )
        return whole

    def _write_rows(self) -> None:
        import pyarrow as pa

        if self._rows:
            self._episodes.write(pa.Table.from_pylist(self._rows))
            self._rows.clear()


def _info(description: Description, episodes: int, frames: int) -> dict[str, Any]:
    """Return `meta/info.json` as plain JSON values."""
    return {
        "codebase_version": VERSION,
        "robot_type": description.robot,
        "total_episodes": episodes,
        "total_frames": frames,
        "total_tasks": 1,
        "chunks_size": FILES_A_CHUNK,
        "data_files_size_in_mb": DATA_MB,
        "video_files_size_in_mb": VIDEO_MB,
        "fps": round(description.rate_hz),
        "splits": {"train": f"0:{episodes}"},
        "data_path": f"data/{_PATH}.parquet",
        "video_path": f"videos/{{video_key}}/{_PATH}.mp4" if description.cameras else None,
        "features": _features(description),
    }


def _features(description: Description) -> dict[str, Any]:
    """Return name -> type and shape of each column and video."""
    vectors = {STATE: description.observation, ACTION: description.action}
    features: dict[str, Any] = {
        name: {"dtype": description.task.dtype, "shape": [len(names)], "names": list(names)}
        for name, names in vectors.items()
    }
    for camera, (height, width) in description.cameras.items():
        features[f"{IMAGES}{camera}"] = {
            "dtype": "video",
            "shape": [height, width, 3],
            "names": ["height", "width", "channels"],
            "info": {
                "video.height": height,
                "video.width": width,
                "video.codec": CODEC,
                "video.pix_fmt": PIXELS,
                "video.is_depth_map": False,
                "video.fps": round(description.rate_hz),
                "video.channels": 3,
                "has_audio": False,
            },
        }
    kinds = {"next.reward": "float32", "next.done": "bool", "next.success": "bool"}
    kinds |= {"timestamp": "float32"} | dict.fromkeys(_INDICES, "int64")
    single = {"shape": [1], "names": None}
    return features | {name: {"dtype": kind, **single} for name, kind in kinds.items()}


def _write_tasks(path: Path, task: str) -> None:
    """Write the table of tasks, whose index is the text, as a data frame of pandas."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    index = "__index_level_0__"
    number = {"name": "task_index", "field_name": "task_index", "metadata": None}
    text = {"name": None, "field_name": index, "metadata": None}
    frame = {
        "index_columns": [index],
        "column_indexes": [],
        "columns": [
            number | {"pandas_type": "int64", "numpy_type": "int64"},
            text | {"pandas_type": "unicode", "numpy_type": "object"},
        ],
    }
    table = pa.table({"task_index": pa.array([0], pa.int64()), index: pa.array([task])})
    pq.write_table(table.replace_schema_metadata({"pandas": json.dumps(frame)}), path)


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=4) + "\n", encoding="utf-8")
