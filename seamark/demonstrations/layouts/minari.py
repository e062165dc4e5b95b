"""Minari: `data/metadata.json` and `data/main_data.hdf5` with a group for each episode.

Images are PNG where Minari's own data sets have JPEG; its reader takes both, and PNG has no loss.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.demonstrations.description import FILE, Description
from seamark.demonstrations.layouts import Episode
from seamark.demonstrations.layouts.png import new_images, packed_images

__all__ = ["packed_images", "refusal", "write"]
FORMAT_VERSION = "0.5.0"  # of Minari, whose layout this is: later ones read it
MB = 1e6


def refusal(description: Description) -> str:
    """Return nothing: all can be written."""
    return ""


def write(description: Description, episodes: Iterable[Episode], folder: Path) -> None:
    """Write the data set; `minari.MinariDataset(folder / "data")` reads it."""
    import h5py

    data = folder / "data"
    data.mkdir()
    main = data / "main_data.hdf5"
    count = steps = 0
    with h5py.File(main, "w") as file:
        for number, episode in enumerate(episodes):
            _write_episode(file.create_group(f"episode_{number}"), number, episode, description)
            count, steps = number + 1, steps + episode.outcome.steps
    metadata = _metadata(description) | {
        "total_episodes": count,
        "total_steps": steps,
        "dataset_size": round(main.stat().st_size / MB, 1),
    }
    (data / "metadata.json").write_text(json.dumps(metadata), encoding="utf-8")
    (folder / FILE).write_text(description.text(), encoding="utf-8")


def _write_episode(group: Any, number: int, episode: Episode, description: Description) -> None:
    outcome, arrays = episode
    told: dict[str, float] = {"id": number, "total_steps": outcome.steps, "seed": outcome.seed}
    told |= {"options/trial": outcome.trial, "options/level": outcome.level}
    told |= {"credit": outcome.credit, "success": outcome.success, "stages": outcome.stages}
    told["current_m_s"] = outcome.current_m_s
    group.attrs.update(told)
    if description.cameras:
        seen = group.create_group("observations")
        _write(seen, "state", arrays["observations"])
        for camera in description.cameras:
            _write_images(seen, f"image_{camera}", new_images(arrays, camera))
    else:
        _write(group, "observations", arrays["observations"])
    for name in ("actions", "rewards", "terminations", "truncations"):
        _write(group, name, arrays[name])
    infos = group.create_group("infos")
    for name in ("credit", "stages"):
        _write(infos, name, arrays[name])


def _write(group: Any, name: str, values: NDArray[Any]) -> None:
    group.create_dataset(name, data=values, chunks=values.shape, compression="gzip", shuffle=True)


def _write_images(group: Any, name: str, files: list[bytes | None]) -> None:
    """Write a file for each observation, also where it is that of the one before."""
    import h5py

    data = group.create_dataset(name, (len(files),), dtype=h5py.vlen_dtype(np.uint8))
    newest = b""
    for at, file in enumerate(files):
        newest = newest if file is None else file
        data[at] = np.frombuffer(newest, np.uint8)


def _metadata(description: Description) -> dict[str, Any]:
    """Return what Minari has to know, as plain JSON values."""
    task = description.task
    env = task.environment()
    spec = env.spec
    return {
        "data_format": "hdf5",
        "jpeg_encoding": True,  # whether images are encoded at all
        "observation_space": json.dumps(_space(env.observation_space)),
        "action_space": json.dumps(_space(env.action_space)),
        "env_spec": spec.to_json() if spec else None,
        "dataset_id": f"seamark/{task.benchmark}/{task.expert}-v0",
        "minari_version": FORMAT_VERSION,
        "algorithm_name": description.expert_label,
        "author": ["Seamark"],
        "author_email": [],
        "code_permalink": "",
        "description": f"{description.title}: {task.benchmark} of Seamark {description.version}",
        "requirements": [f"seamark=={description.version}"],
    }


def _space(space: Any) -> dict[str, Any]:
    """Return a space as Minari writes it."""
    if isinstance(getattr(space, "spaces", None), Mapping):
        subspaces = {name: _space(each) for name, each in space.spaces.items()}
        return {"type": "Dict", "subspaces": subspaces}
    return {
        "type": "Box",
        "dtype": str(space.dtype),
        "shape": list(space.shape),
        "low": space.low.tolist(),
        "high": space.high.tolist(),
    }
