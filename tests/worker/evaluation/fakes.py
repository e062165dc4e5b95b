"""Stand-ins with the same protocols as the real things, for what a real box does too rarely."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.protocol.answers import Corners, Detection, Loss
from seamark.sim.engine.program import Command

SLOW = Outcome(verdict=Verdict.TIME_LIMIT, sentence="too slow", suspect_host=True)


class FakeBox:
    """A box whose program stays where it is; it fails at given steps."""

    def __init__(
        self,
        ends_at: int = -1,
        outcome: Outcome = SLOW,
        *,
        command: Command = (0.0, 0.0, 0.0, 0.0),
    ) -> None:
        self.ends_at, self._end = ends_at, outcome
        self.outcome: Outcome | None = None  # until it has ended
        self.command = command
        self.steps, self.closed = 0, False

    def load(
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None: ...

    def reset(self, level: Mapping[str, object]) -> None: ...

    def step(self, values: Any) -> Command:
        self._answer()
        return self.command

    def show(self, images: Any) -> None: ...

    def start(self, image: Any, corners: Any) -> None: ...

    def update(self, image: Any) -> Corners | Loss:
        self._answer()
        return Loss.REPORTED

    def detect(self, image: Any) -> list[Detection]:
        self._answer()
        return []

    def _answer(self) -> None:
        if self.steps == self.ends_at:
            self.outcome = self._end
            raise ProgramEnded(self._end)
        self.steps += 1

    def finish(self) -> Outcome:
        return Outcome(verdict=Verdict.OK, sentence="fine")

    def take_output(self) -> bytes:
        return b""

    def close(self) -> None:
        self.closed = True


class FakeBoxes:
    """Makes the given boxes, one after the other."""

    def __init__(self, *boxes: FakeBox) -> None:
        self.boxes = boxes
        self.made = 0

    def __call__(self, language: str, limits: Limits) -> FakeBox:
        self.made += 1
        return self.boxes[self.made - 1]


class FakeListener:
    """Keeps what it receives, and discards the rows of a trial that starts again."""

    def __init__(self) -> None:
        self.received: list[NDArray[np.float64]] = []
        self.restarted: list[int] = []
        self.ended: list[int] = []

    def rows(self, rows: NDArray[np.float64]) -> None:
        self.received.append(rows)

    def log(self, text: bytes) -> None: ...

    def trial_ended(self, trial: int) -> None:
        self.ended.append(trial)

    def trial_restarted(self, trial: int, reason: str) -> None:
        self.restarted.append(trial)
        self.received = [rows for rows in self.received if rows[0, 0] != trial]
