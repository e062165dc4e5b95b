"""The verdict on a program that the kernel killed for memory: its own limit, or the host's."""

from collections.abc import Iterator
from typing import cast

import pytest

from seamark.sandbox.isolation.process_tree import KILLED, ProcessTree
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken, Verdict
from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.session import ProtocolSession
from tests.fuzz.sides import LIMITS, FakeProcessTree


class KilledForMemory(FakeProcessTree):
    """A box that the kernel killed; releasing its memory took CPU time."""

    by_host = killed = False

    def cpu_s(self) -> float:
        return LIMITS.cpu_s * 1.05 if self.killed else 0.0

    def out_of_memory(self) -> bool:
        return self.killed and not self.by_host

    def host_out_of_memory(self) -> bool:
        return self.killed and self.by_host

    def exit_code(self, within_s: float) -> int | None:
        return KILLED if self.killed else None


@pytest.fixture
def tree() -> Iterator[KilledForMemory]:
    made = KilledForMemory()
    yield made
    made.close()


def killed(tree: KilledForMemory) -> None:
    """Send a request to a program that the kernel kills before it answers."""
    session = ProtocolSession(cast(ProcessTree, tree), LIMITS)
    session.begin()
    session.ask(messages.OBSERVE)
    tree.killed = True
    tree.theirs.close()
    session.answer(messages.COMMAND, LIMITS.step_limit, "step(observation)")


def test_the_memory_limit_comes_before_the_cpu_time_of_releasing_the_memory(tree) -> None:
    with pytest.raises(ProgramEnded) as end:
        killed(tree)

    assert end.value.outcome.verdict is Verdict.MEMORY_LIMIT


def test_an_out_of_memory_host_is_not_the_programs_fault(tree) -> None:
    tree.by_host = True

    with pytest.raises(SandboxBroken, match="host"):
        killed(tree)
