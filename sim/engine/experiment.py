"""The interface of an experiment: how the levels of a benchmark run, and how they are scored.

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
    """The score of a trial."""

    score: float  # more is better; in the unit of the benchmark's headline
    level_held: float | None  # value of the last level up to which all were held; None: none
    rankable: bool
    reason: str = ""  # why it does not rank: a sentence for the user
    overall: Mapping[str, float | None] = field(default_factory=dict)  # metrics over all levels


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialPlan:
    """What is known of a trial before it runs."""

    order: tuple[int, ...]  # the levels in the order in which they run
    conditions: Mapping[str, Any] = field(default_factory=dict)  # what was drawn, as JSON values


class Level(Protocol):
    """One level, ready to run."""

    def run(self, on_rows: OnRows) -> None:
        """Run it; rows go to `on_rows` in order, a second of simulated time at once.

        Whatever the solution raises passes through, after the rows so far were delivered.
        """

    def close(self) -> None:
        """Release the resources of the level."""


class Experiment(Protocol):
    """How levels run and are scored, for one type of configuration and of solution."""

    def built_in(self, name: str, config: Any) -> Any:
        """Return a built-in solution."""

    def layout(self, config: Any) -> dict[str, Any]:
        """Return the role of a program and the layout of its messages."""

    def plan(self, config: Any, *, seed: int, trial: int) -> TrialPlan:
        """Return the order of a trial's levels, and the conditions that were drawn for it."""

    def level(self, config: Any, solution: Any, *, seed: int, trial: int, level: int) -> Level:
        """Return a level, which depends on these values only."""

    def camera(self, config: Any, *, seed: int, trial: int, level: int) -> "Camera":
        """Return the camera of a level; an image also depends on pose and frame number."""

    def first_camera(self, config: Any, *, seed: int, trial: int, level: int) -> "Camera":
        """Return the camera of the image with which the tracker is initialised."""

    def metrics(self, config: Any, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level by name, from all of its rows."""

    def trial_score(self, config: Any, levels: Sequence[Mapping[str, Any]]) -> TrialScore:
        """Return the score of a trial with these metrics."""
