"""What a whole set of demonstrations is, as its files say."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from seamark.demonstrations.episodes import Task
from seamark.sim import registry

FILE = "seamark.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """A set of demonstrations.

    Attributes
    ----------
    observation, action
        A name for each number.
    cameras
        Name -> height and width of its images [px].
    rate_hz
        Control steps a second.
    """

    task: Task
    title: str
    expert_label: str
    gym_id: str
    robot: str
    version: str  # of Seamark
    observation: tuple[str, ...]
    action: tuple[str, ...]
    cameras: Mapping[str, tuple[int, int]]
    rate_hz: float

    def document(self) -> dict[str, Any]:
        """Return what `seamark.json` has, as plain JSON values."""
        return {
            "seamark": self.version,
            "benchmark": self.task.benchmark,
            "environment": self.gym_id,
            "options": self.task.options(),
            "expert": self.task.expert,
            "rate_hz": self.rate_hz,
            "observation": list(self.observation),
            "action": list(self.action),
            "cameras": {name: list(size) for name, size in self.cameras.items()},
        }

    def text(self) -> str:
        """Return that file."""
        return json.dumps(self.document(), indent=2) + "\n"


def describe(task: Task) -> Description:
    """Return the description of the demonstrations of a task."""
    from importlib.metadata import version

    entry = registry.benchmark(task.benchmark)
    config: Any = entry.read(task.settings)
    experiment: Any = entry.load()
    layout = experiment.layout(config)
    return Description(
        task=task,
        title=entry.title,
        expert_label=entry.built_in[task.expert],
        gym_id=entry.gym_id,
        robot=f"{config.vehicle} with {config.arm}",
        version=version("seamark"),
        observation=tuple(
            name if count == 0 else f"{name}_{at}"
            for name, count in layout["observation"]
            for at in range(max(count, 1))
        ),
        action=tuple(layout["command"]),
        cameras={camera: (height, width) for camera, height, width in layout.get("images", ())},
        rate_hz=1.0 / config.control_period_s,
    )
