"""A new worker looks at programs that were installed; the old one ends when its runs have ended."""

import fcntl
import socket
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from seamark.embedded.installed_tools import InstalledTools
from seamark.embedded.supervisor import Child
from seamark.embedded.worker_renewal import WorkerRenewal
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.storage import installation
from tests.cast import Backend

OLD, NEW = (f"{name}@{socket.gethostname()}" for name in ("old", "new"))


@dataclass
class Children:
    """Stands in for the supervisor: workers that are listed at once, and end when asked."""

    backend: Backend
    names: list[str] = field(default_factory=lambda: [OLD, NEW])
    children: list[Child] = field(default_factory=list)
    simulator: str = workers.RUNNING

    def start(self) -> Child:
        name = self.names.pop(0)
        child = Child(name, (), {}, Path())
        self.children.append(child)
        with self.backend.database.writing() as session:
            worker = Worker(name=name, slots=1, level="strong", languages=[], findings=[])
            workers.register(session, worker)
        self.says(name, self.simulator)
        return child

    def says(self, name: str, simulator: str) -> None:
        with self.backend.database.writing() as session:
            workers.heartbeat(session, name, {workers.SIMULATOR: simulator})

    def retire(self, child: Child) -> None:
        self.children.remove(child)

    @property
    def running(self) -> list[str]:
        return [child.name for child in self.children]


@dataclass
class Machine:
    """A service on a machine where something is installed on demand."""

    backend: Backend
    status: Path
    children: Children
    renewal: WorkerRenewal

    def install(self) -> None:
        self.status.write_text("octave")
        for _ in range(3):  # a change counts when nothing follows it
            self.step()

    def step(self) -> None:
        self.renewal.step()

    def listed(self) -> dict[str, bool]:
        """Return the workers that are listed, and whether each claims runs."""
        with self.backend.database.reading() as session:
            return {worker.name: worker.claims for worker in workers.listed(session)}


@pytest.fixture
def machine(backend: Backend, tmp_path: Path) -> Iterator[Machine]:
    children, status = Children(backend), tmp_path / "status"
    renewal = WorkerRenewal(
        backend.settings,
        children,  # type: ignore[arg-type]
        children.start,
        say=lambda _: None,
        tools=InstalledTools((status,), every_s=0.0),
        installer=tmp_path / "installer",
        step_every_s=0.0,
        settled_s=0.0,
    )
    with renewal:
        yield Machine(backend, status, children, renewal)


def test_a_worker_with_a_run_goes_on_beside_its_successor_and_claims_no_more(
    machine: Machine,
) -> None:
    machine.backend.queue("ann")
    claim = machine.backend.claim(f"{OLD}/0")
    assert claim is not None

    machine.install()
    during = machine.children.running, machine.listed()
    machine.backend.finish(claim)
    for _ in range(2):
        machine.step()

    assert during == ([OLD, NEW], {OLD: False, NEW: True})
    assert (machine.children.running, machine.listed()) == ([NEW], {NEW: True})


def test_a_simulator_that_is_being_compiled_is_not_thrown_away(machine: Machine) -> None:
    machine.children.says(OLD, workers.preparing(1, 6))
    machine.install()
    during = machine.children.running

    machine.children.says(OLD, workers.RUNNING)
    for _ in range(3):
        machine.step()

    assert during == [OLD]
    assert machine.children.running == [NEW]


def test_uploads_wait_until_a_worker_has_tried_what_was_installed(
    machine: Machine, tmp_path: Path
) -> None:
    def waits() -> bool:
        machine.step()
        return installation.is_under_way(machine.backend.settings)

    with (tmp_path / "installer").open("w") as installer:
        fcntl.flock(installer, fcntl.LOCK_EX)
        locked = waits()
        machine.status.write_text("octave")
        changed = [waits() for _ in range(3)]
    replaced = [waits() for _ in range(3)]

    assert locked
    assert all(changed)
    assert machine.children.running == [NEW]
    assert replaced[-1] is False
