"""One program in one box: start, load, step by step in lock step, end."""

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

from sandbox.level import Level
from sandbox.limits import Limits
from sandbox.outcome import Outcome

Command = tuple[float, float, float, float]


class Box:
    """A single-use box: may be started before its program is known (warm)."""

    def __init__(
        self,
        language: str = "python",
        *,
        limits: Limits,
        level: Level,
        core: int | None = None,
    ) -> None:
        """Start the interpreter in its box and return at once."""

    def load(
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None:
        """Send the program and its configuration; wait until `Controller(config)` is made."""

    def reset(self, level: Mapping[str, object]) -> None:
        """Announce a level; wait until the program is ready."""

    def step(self, values: Sequence[float]) -> Command:
        """Send one observation, return the checked command [m/s, m/s, m/s, rad/s]."""
        raise NotImplementedError

    def finish(self) -> Outcome:
        """Say good-bye; the program must end by itself, well."""
        raise NotImplementedError

    def take_output(self) -> bytes:
        """Return what the program printed since the last call."""
        return b""

    def close(self) -> None:
        """Kill everything in the box and make sure that nothing survives."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
