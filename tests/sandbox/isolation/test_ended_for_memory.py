"""What is said of a program that the kernel ended for memory: its own limit, or the host's."""

from collections.abc import Iterator
from typing import cast

import pytest

from seamark.sandbox.isolation.process_tree import KILLED, Confined
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.session import Conversation
from tests.fuzz.sides import LIMITS, Cage


class EndedForMemory(Cage):
    """A box that the kernel ended; the memory that it gave back took CPU time."""

    of_host = ended = False

    def cpu_s(self) -> float:
        return LIMITS.cpu_s * 1.05 if self.ended else 0.0

    def out_of_memory(self) -> bool:
        return self.ended and not self.of_host

    def host_out_of_memory(self) -> bool:
        return self.ended and self.of_host

    def exit_code(self, within_s: float) -> int | None:
        return KILLED if self.ended else None


@pytest.fixture
def cage() -> Iterator[EndedForMemory]:
    made = EndedForMemory()
    yield made
    made.close()


def ended(cage: EndedForMemory) -> None:
    """Ask a program that the kernel ends before it answers."""
    talk = Conversation(cast(Confined, cage), LIMITS)
    talk.begin()
    talk.ask(messages.OBSERVE)
    cage.ended = True
    cage.theirs.close()
    talk.answer(messages.ANSWER, LIMITS.stepping, "step(observation)")


def test_memory_that_ended_the_program_comes_before_the_time_that_its_end_took(cage) -> None:
    with pytest.raises(ProgramEnded) as end:
        ended(cage)

    assert end.value.outcome.verdict is Verdict.MEMORY_LIMIT


def test_memory_that_the_host_did_not_have_is_no_fault_of_the_program(cage) -> None:
    cage.of_host = True

    with pytest.raises(SandboxBroken, match="host"):
        ended(cage)
