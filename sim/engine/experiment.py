"""What happens in a level of a benchmark, and what is made of it; one file per kind of experiment.

A benchmark names its experiment by path, so that forms need not load the simulator.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from seamark.sim.recording.telemetry import OnRows, Rows

if TYPE_CHECKING:
    from seamark.sim.camera.camera import Camera


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialScore:
    """What a trial is worth."""

    score: float  # more is better; the unit is that of the benchmark's headline
    level_held: float | None  # value of the last level up to which all were held; None: not one
    rankable: bool
    overall: Mapping[str, float | None] = field(default_factory=dict)  # metrics over all levels


class Level(Protocol):
    """One level, ready to run."""

    def run(self, on_rows: OnRows) -> None:
        """Run it; rows go to `on_rows` in order, a second of simulated time at once.

        Whatever the solution raises passes through, after the rows so far were delivered.
        """

    def close(self) -> None:
        """Give back what the level holds."""


class Experiment(Protocol):
    """How levels run and count. Each takes the configuration and the solutions of its own kind."""

    def built_in(self, name: str, config: Any) -> Any:
        """Return a built-in solution that can take part."""

    def layout(self, config: Any) -> dict[str, Any]:
        """Return what travels to a program and back: its role, and what that needs."""

    def level(self, config: Any, solution: Any, *, seed: int, trial: int, level: int) -> Level:
        """Return a level; nothing but these values goes into it."""

    def camera(self, config: Any, *, seed: int, trial: int, level: int) -> "Camera":
        """Return the camera of a level: all that a picture needs beside pose and frame number."""

    def first_camera(self, config: Any, *, seed: int, trial: int, level: int) -> "Camera":
        """Return the camera that takes the first picture of a level, for the tracker to learn."""

    def metrics(self, config: Any, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level by name, from all of its rows."""

    def trial_score(self, config: Any, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return what a trial with these metrics is worth."""
