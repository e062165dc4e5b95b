"""Uploads of applications under test, each of which reads one or two."""

from seamark.server.programs.reader import ProgramReader
from seamark.server.web import services


class ReaderWithoutSpare(ProgramReader):
    """Starts a process when there is an upload: one that waits for the next would wait in vain."""

    def _start_spare(self) -> None:
        pass


def read_without_spare() -> None:
    """Let the applications that are created from now on start no process in advance."""
    services.ProgramReader = ReaderWithoutSpare  # type: ignore[attr-defined]
