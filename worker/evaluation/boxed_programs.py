"""The uploaded programs of one trial, each in a box of its own with limits of its own."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

from seamark.programs.role_names import with_role
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.worker.evaluation.program_adapters import ADAPTERS, BoxLike
from seamark.worker.ipc.listener import Listener


class BoxedPrograms:
    """The boxes of one trial, by the roles of their programs; `close` closes all of them.

    Where there are several roles, the log and the sentences about a failure say whose they are.
    """

    def __init__(self, listener: Listener, *, named: bool) -> None:
        self._listener, self._named = listener, named
        self._boxes: dict[str, BoxLike] = {}
        self._logged_last, self._line_open = "", False  # role; whether its line goes on
        self.solutions: dict[str, Any] = {}  # role -> what takes part in the simulation

    def load(self, role: str, box: BoxLike, send_program: Callable[[BoxLike], None]) -> None:
        """Own a box from now on, and send the program of a role into it; raises ProgramEnded."""
        self._boxes[role] = box
        send_program(box)
        self.solutions[role] = ADAPTERS[role](box)

    def forward_output(self) -> None:
        """Log what the programs have printed since the last time."""
        for role, box in self._boxes.items():
            if text := box.take_output():
                self._log(role, text)

    def finish(self) -> Outcome:
        """Ask all programs to quit; return how they ended and what they used together.

        Raises
        ------
        ProgramEnded
            One of them did not end well.
        """
        return _together([box.finish() for box in self._boxes.values()])

    def named(self, ended: ProgramEnded) -> ProgramEnded:
        """Return the end of one of the programs, with a sentence that says which it is."""
        if not self._named:
            return ended
        boxes = self._boxes.items()
        return of_role(ended, next(role for role, box in boxes if box.outcome is ended.outcome))

    def close(self) -> None:
        """Log the rest, and close every box, whatever the others do; raises SandboxBroken."""
        with ExitStack() as stack:
            for box in self._boxes.values():
                stack.callback(box.close)
            self.forward_output()
            for role, solution in self.solutions.items():
                if note := solution.note():
                    self._log(role, note.encode())

    def _log(self, role: str, text: bytes) -> None:
        if self._named and role != self._logged_last:
            ending = "\n" if self._line_open else ""
            text = f"{ending}[{role}]\n".encode() + text
        self._logged_last, self._line_open = role, not text.endswith(b"\n")
        self._listener.log(text)


def of_role(ended: ProgramEnded, role: str) -> ProgramEnded:
    """Return the end of the program of a role, with a sentence that says which it is."""
    sentence = with_role(ended.outcome.sentence, role)
    return ProgramEnded(replace(ended.outcome, sentence=sentence))


def _together(outcomes: Sequence[Outcome]) -> Outcome:
    """Return the outcome of programs that ended well: the sum of their times, the largest memory.

    Each has memory limits of its own, so that the largest one is what compares with them.
    """
    first, *others = outcomes
    if not others:
        return first
    return replace(
        first,
        cpu_s=sum(one.cpu_s for one in outcomes),
        wall_s=sum(one.wall_s for one in outcomes),
        memory_mib=max(one.memory_mib for one in outcomes),
    )
